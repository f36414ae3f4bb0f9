//! A piece of a block that stays in the first-level cache while every source passes over it.

use super::numbers::{PHASE_MAGIC, TURNS_MAX, polar};
use super::term::SourceTerm;
use crate::likelihood::VisBlock;
use crate::likelihood::extents::{Extents, Gain};
use std::ops::Range;

/// Samples in a pack: what one vector of f32 holds at most.
pub(super) const LANES: usize = 16;

/// Packs in a tile. 32 packs take 27 KB, and f32 lanes add up 32 terms before they are widened.
const PACKS: usize = 32;

/// Samples in a tile.
pub(super) const TILE: usize = LANES * PACKS;

/// Sixteen samples. The datum w d is kept as amplitude and angle, so that
/// Re[w d exp(-2πiφ)] = |w d| cos 2π(φ - angle) needs one cosine and no sine.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Pack {
    pub(super) u: [f64; LANES],
    pub(super) v: [f64; LANES],
    pub(super) w: [f64; LANES],
    /// [`PHASE_MAGIC`] minus the angle of the datum [turn].
    pub(super) start: [f64; LANES],
    pub(super) u_single: [f32; LANES],
    pub(super) v_single: [f32; LANES],
    pub(super) w_single: [f32; LANES],
    /// |w d|.
    pub(super) amplitude: [f32; LANES],
    pub(super) weight: [f32; LANES],
}

impl Pack {
    /// Samples of amplitude and weight zero.
    const EMPTY: Pack = Pack {
        u: [0.0; LANES],
        v: [0.0; LANES],
        w: [0.0; LANES],
        start: [PHASE_MAGIC; LANES],
        u_single: [0.0; LANES],
        v_single: [0.0; LANES],
        w_single: [0.0; LANES],
        amplitude: [0.0; LANES],
        weight: [0.0; LANES],
    };

    /// Sets the sixteen samples from `first` on.
    #[inline(always)]
    fn fill(&mut self, block: &VisBlock, first: usize) {
        let range = first..first + LANES;
        self.u.copy_from_slice(&block.u[range.clone()]);
        self.v.copy_from_slice(&block.v[range.clone()]);
        self.w.copy_from_slice(&block.w[range.clone()]);
        self.weight.copy_from_slice(&block.weight[range.clone()]);
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        re.copy_from_slice(&block.weighted_re[range.clone()]);
        im.copy_from_slice(&block.weighted_im[range]);
        self.finish(&re, &im);
    }

    /// Sets the last samples of a block, fewer than sixteen, and pads with empty ones.
    fn fill_tail(&mut self, block: &VisBlock, first: usize) {
        *self = Pack::EMPTY;
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        for (i, k) in (first..block.len()).enumerate() {
            self.u[i] = block.u[k];
            self.v[i] = block.v[k];
            self.w[i] = block.w[k];
            self.weight[i] = block.weight[k];
            re[i] = block.weighted_re[k];
            im[i] = block.weighted_im[k];
        }
        self.finish(&re, &im);
    }

    /// Works out what follows from u, v and the weighted datum.
    #[inline(always)]
    fn finish(&mut self, re: &[f32; LANES], im: &[f32; LANES]) {
        for i in 0..LANES {
            let (modulus, turns) = polar(re[i], im[i]);
            self.amplitude[i] = modulus;
            self.start[i] = PHASE_MAGIC - turns;
        }
        for i in 0..LANES {
            self.u_single[i] = self.u[i] as f32;
            self.v_single[i] = self.v[i] as f32;
            self.w_single[i] = self.w[i] as f32;
        }
    }
}

/// The factors of sixteen samples. All is by value: of references the compiler does not know whether they
/// are to the same place, and works out one sample after the other.
#[inline(always)]
pub(super) fn gains_of(
    gain: &Gain,
    uvw: &[[f32; LANES]; 3],
    extent: &[[f32; LANES]; 3],
) -> [f32; LANES] {
    let (gain, [u, v, w], [place, width, interval_s]) = (*gain, *uvw, *extent);
    let mut gains = [0.0; LANES];
    for i in 0..LANES {
        gains[i] = gain.at([u[i], v[i], w[i]], [place[i], width[i], interval_s[i]]);
    }
    gains
}

/// Up to [`TILE`] samples in packs, the last one padded.
pub(super) struct Tile {
    packs: Box<[Pack]>,
    used: usize,
    /// Largest |u|, |v| and |w| [wavelength].
    reach: [f64; 3],
    /// What the instrument's factors are made of, where there are any.
    seen: Option<Box<Seen>>,
}

/// The extents of a tile's samples, and what their amplitudes and weights are without factors.
struct Seen {
    extent: [[f32; TILE]; 3],
    amplitude: [f32; TILE],
    weight: [f32; TILE],
}

impl Tile {
    /// A tile without samples.
    pub(super) fn new() -> Tile {
        Tile {
            packs: vec![Pack::EMPTY; PACKS].into_boxed_slice(),
            used: 0,
            reach: [0.0; 3],
            seen: None,
        }
    }

    /// The packs that hold samples.
    #[inline(always)]
    pub(super) fn packs(&self) -> &[Pack] {
        &self.packs[..self.used]
    }

    /// Sets the samples of `block` from `first` on, as many as fit. Inlined into each kernel, so
    /// that it is compiled for that kernel's instructions.
    #[inline(always)]
    pub(super) fn fill(&mut self, block: &VisBlock, first: usize) {
        let end = block.len().min(first + TILE);
        self.used = (end - first).div_ceil(LANES);
        let mut reach = [[0.0f64; LANES]; 3];
        for (i, pack) in self.packs[..self.used].iter_mut().enumerate() {
            let at = first + i * LANES;
            if at + LANES <= end {
                pack.fill(block, at);
            } else {
                pack.fill_tail(block, at);
            }
            for (reach, values) in reach.iter_mut().zip([&pack.u, &pack.v, &pack.w]) {
                for (reach, value) in reach.iter_mut().zip(values) {
                    *reach = reach.max(value.abs());
                }
            }
        }
        self.reach = reach.map(|lanes| lanes.into_iter().fold(0.0, f64::max));
        if block.extents.instrument.is_some() {
            self.keep(&block.extents, first..end);
        }
    }

    /// Keeps what [`Tile::look`] needs.
    fn keep(&mut self, extents: &Extents, range: Range<usize>) {
        let seen = self.seen.get_or_insert_with(|| {
            Box::new(Seen {
                extent: [[0.0; TILE]; 3],
                amplitude: [0.0; TILE],
                weight: [0.0; TILE],
            })
        });
        let of = [&extents.place, &extents.width, &extents.interval_s];
        for (kept, of) in seen.extent.iter_mut().zip(of) {
            kept[..range.len()].copy_from_slice(&of[range.clone()]);
        }
        for (i, pack) in self.packs[..self.used].iter().enumerate() {
            let lanes = i * LANES..(i + 1) * LANES;
            seen.amplitude[lanes.clone()].copy_from_slice(&pack.amplitude);
            seen.weight[lanes].copy_from_slice(&pack.weight);
        }
    }

    /// Sets amplitudes and weights to those for the factors s of a source, s w d and s² w, or for two
    /// sources, whose product takes the place of s². Nothing is done without.
    #[inline(always)]
    pub(super) fn look(&mut self, gains: Option<&[Gain]>) {
        let (Some([first, others @ ..]), Some(seen)) = (gains, &self.seen) else {
            return;
        };
        let (packs, _) = seen.amplitude.as_chunks::<LANES>();
        for (p, pack) in self.packs[..self.used].iter_mut().enumerate() {
            let uvw = [pack.u_single, pack.v_single, pack.w_single];
            let extent = seen.extent.each_ref().map(|of| of.as_chunks().0[p]);
            let gain = gains_of(first, &uvw, &extent);
            let other = others.first().map_or(gain, |g| gains_of(g, &uvw, &extent));
            let (amplitude, weight) = (packs[p], seen.weight.as_chunks::<LANES>().0[p]);
            for i in 0..LANES {
                pack.amplitude[i] = amplitude[i] * gain[i];
                pack.weight[i] = weight[i] * gain[i] * other[i];
            }
        }
    }

    /// True if every phase of `term` fits the fixed-point form.
    #[inline(always)]
    pub(super) fn holds_phases_of(&self, term: &SourceTerm) -> bool {
        let [u, v, w] = self.reach;
        u * term.l.abs() + v * term.m.abs() + w * term.n_minus_1.abs() < TURNS_MAX
    }
}
