//! X of a round source at every position of a facet at once.
//!
//! The transform to the sky is a product of one along u and one along v: first each row of cells
//! becomes a row of positions in l, then each column of those becomes positions in m.
#![allow(clippy::inline_always)] // one loop is compiled anew for each instruction set
#![allow(clippy::needless_range_loop)] // a closure would be compiled for the least of processors
#![allow(unsafe_code)] // entering code compiled for an instruction set

use super::Facet;
use super::cells::LANES;
use super::evaluate::Level;
use super::lanes::Lanes;
use super::lanes::portable::Plain;
#[cfg(target_arch = "x86_64")]
use super::lanes::{avx2::Avx2, avx512::Avx512};
use super::span::Span;
use super::term::FacetTerm;
use super::turns::cos_sin;
use crate::likelihood::Isa;
use crate::rime::Source;
use crate::rime::shape::Profile;

/// X of one round shape of unit flux density over a facet, and its Y.
#[derive(Debug, Clone, PartialEq)]
pub struct FacetMap {
    /// X [Jy⁻¹], axes (m, l), at the middles of equal parts of the facet's region.
    pub x: Vec<f32>,
    /// Y [Jy⁻²], the same everywhere.
    pub y: f64,
}

/// Sixteen complex numbers: real and imaginary parts.
type Pair = [[f32; LANES]; 2];

impl Facet {
    /// X and Y of a round source of scale-length `scale_rad` [rad] at `n_side` x `n_side` positions,
    /// the middles of equal parts of the region.
    ///
    /// As a source in the middle of the region sees the baselines: the change of the shape with w over
    /// the region is left out, with the second-order terms that [`Facet::xy_batch`] leaves out too. The
    /// factors of the instrument are those at the first place that the facet looks from: plan it with
    /// [`Gains::Centre`](super::Gains::Centre).
    pub fn map(&self, scale_rad: f64, n_side: usize) -> FacetMap {
        let source = Source {
            lm: self.centre.lm,
            flux_jy: 1.0,
            scale_rad,
            ..Source::default()
        };
        let term = FacetTerm::new(&self.plan, &self.centre, &source);
        let last = self.plan.innermost(term.major_rad);
        let look = &self.looks[0];
        let y = self.xy_look(look, std::slice::from_ref(&source))[0].y;
        let mut sums = vec![[0.0f32; 2]; n_side * n_side];
        for number in 0..=last {
            let shape = (&term, number < last);
            add_level(self.isa, self.level(look, number), shape, n_side, &mut sums);
        }
        let region = self.region();
        let middle = |i: usize| (i as f64 + 0.5) / n_side as f64;
        let x = sums.iter().enumerate().map(|(i, [x, with_w])| {
            let lm = region.from_unit(middle(i % n_side), middle(i / n_side));
            let bend = FacetTerm::new(&self.plan, &self.centre, &Source { lm, ..source });
            x - bend.curvature as f32 * with_w
        });
        FacetMap { x: x.collect(), y }
    }
}

/// Adds Re M and Im M_w of `level` to `sums`, M being Σ g F exp(-2πi u δ) and M_w the same of the grid
/// times w.
fn add_level(
    isa: Isa,
    level: Level,
    shape: (&FacetTerm, bool),
    n_side: usize,
    sums: &mut [[f32; 2]],
) {
    match isa {
        Isa::Portable => add_with::<Plain>(level, shape, n_side, sums),
        // SAFETY: a facet is made with instructions that are there.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { add_avx2(level, shape, n_side, sums) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { add_avx512(level, shape, n_side, sums) },
        #[cfg(not(target_arch = "x86_64"))]
        _ => add_with::<Plain>(level, shape, n_side, sums),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn add_avx2(level: Level, shape: (&FacetTerm, bool), n_side: usize, sums: &mut [[f32; 2]]) {
    add_with::<Avx2>(level, shape, n_side, sums);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn add_avx512(level: Level, shape: (&FacetTerm, bool), n_side: usize, sums: &mut [[f32; 2]]) {
    add_with::<Avx512>(level, shape, n_side, sums);
}

#[inline(always)]
fn add_with<L: Lanes>(
    level: Level,
    (term, is_band): (&FacetTerm, bool),
    n_side: usize,
    sums: &mut [[f32; 2]],
) {
    let offset_q = if term.profile == Profile::Exponential {
        1.0
    } else {
        0.0
    };
    let mut span = Span::default();
    span.set(level.plan, level.number, term, offset_q);
    let width = level.plan.columns() / LANES;
    let step = level.plan.cell(level.number) * level.plan.needs.side_rad / n_side as f64;
    let half = level.plan.columns() as f64 / 2.0;
    let along_u = phases(width, -half, step, n_side);
    let row_packs = span.rows.len().div_ceil(LANES);
    let along_v = phases(row_packs, 0.0, step, n_side);
    // Per position in l: the rows, of g and of g times w.
    let mut rows = vec![[[[0.0f32; LANES]; 2]; 2]; n_side * row_packs];
    let mut cells: Vec<[Pair; 2]> = vec![[[[0.0; LANES]; 2]; 2]; width];
    for (number, row) in span.rows.iter().enumerate() {
        let range = row.first as usize..row.end as usize;
        for i in range.clone() {
            let pack = &level.packs[number * width + i];
            let common = &level.common[number * width + i];
            let window = if is_band { &common.band } else { &common.low };
            for k in 0..LANES {
                let q = span.columns[i].pu[k] + row.rv;
                let factor = window[k] * profile_factor(term.profile, q * q + row.sv2);
                cells[i][0][0][k] = factor * pack.re[k];
                cells[i][0][1][k] = factor * pack.im[k];
                cells[i][1][0][k] = factor * pack.w_re[k];
                cells[i][1][1][k] = factor * pack.w_im[k];
            }
        }
        for position in 0..n_side {
            let phases = &along_u[position * width..][range.clone()];
            let cells = &cells[range.clone()];
            let to = &mut rows[position * row_packs + number / LANES];
            for grid in 0..2 {
                let [re, im] = turned::<L>(cells.iter().map(|c| &c[grid]), phases);
                to[grid][0][number % LANES] = re;
                to[grid][1][number % LANES] = im;
            }
        }
    }
    for (position, rows) in rows.chunks_exact(row_packs).enumerate() {
        for (other, phases) in along_v.chunks_exact(row_packs).enumerate() {
            let to = &mut sums[other * n_side + position];
            to[0] += turned::<L>(rows.iter().map(|r| &r[0]), phases)[0];
            to[1] += turned::<L>(rows.iter().map(|r| &r[1]), phases)[1];
        }
    }
}

/// F where Q has what the profile adds.
#[inline(always)]
fn profile_factor(profile: Profile, q: f32) -> f32 {
    match profile {
        Profile::Exponential => 1.0 / (q * q.sqrt()),
        Profile::Gaussian => (-q).exp2(),
        Profile::Point => 1.0,
    }
}

/// cos and sin of 2π u δ for `packs` packs of cells from number `first` on, at the middles of `n`
/// equal parts of the facet; `step` is the size of a cell times that of a part.
#[inline(always)]
fn phases(packs: usize, first: f64, step: f64, n: usize) -> Vec<Pair> {
    let mut phases = vec![[[0.0; LANES]; 2]; packs * n];
    for (i, pair) in phases.iter_mut().enumerate() {
        let offset = ((i / packs) as f64 + 0.5 - 0.5 * n as f64) * step;
        for k in 0..LANES {
            let cell = first + ((i % packs) * LANES + k) as f64;
            let [cos, sin] = cos_sin(cell * offset);
            pair[0][k] = cos;
            pair[1][k] = sin;
        }
    }
    phases
}

/// Σ c exp(-2πi φ).
#[inline(always)]
fn turned<'a, L: Lanes>(cells: impl Iterator<Item = &'a Pair>, phases: &[Pair]) -> [f32; 2] {
    let (mut a, mut b) = (L::splat(0.0), L::splat(0.0));
    for (cell, phase) in cells.zip(phases) {
        for part in 0..L::PARTS {
            let (re, im) = (L::load(&cell[0], part), L::load(&cell[1], part));
            let (cos, sin) = (L::load(&phase[0], part), L::load(&phase[1], part));
            a = im.mul_add(sin, re.mul_add(cos, a));
            b = re.mul_sub_from(sin, im.mul_add(cos, b));
        }
    }
    [a, b].map(|x| L::total(x.add_to(L::nothing())) as f32)
}
