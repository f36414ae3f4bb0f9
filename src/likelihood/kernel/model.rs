//! Model visibilities, in plain loops that are compiled anew for each instruction set.
#![allow(clippy::needless_range_loop)] // a closure would be compiled for the least of processors

use super::numbers::{PHASE_MAGIC, SQRT2_COS_PI, SQRT2_SIN_PI, TURNS_MAX, TURNS_PER_UNIT, horner};
use super::portable::{exponential, gaussian};
use super::term::SourceTerm;
use super::tile::{LANES, gains_of};
use crate::likelihood::VisBlock;
use crate::likelihood::extents::{Extents, Gain};
use crate::rime::shape::Profile;
use crate::rime::{Source, predict};

/// A source with its flux density.
pub(super) struct Model {
    term: SourceTerm,
    flux_jy: f32,
    source: Source,
    gain: Option<Gain>,
}

impl Model {
    pub(super) fn new((source, profile): &(Source, Profile), extents: &Extents) -> Model {
        Model {
            term: SourceTerm::new(source, *profile),
            flux_jy: source.flux_jy as f32,
            source: *source,
            gain: extents.gain(source.ray()),
        }
    }
}

/// Sixteen samples and the sum of the models there [Jy].
#[derive(Default)]
struct Lanes {
    u: [f64; LANES],
    v: [f64; LANES],
    w: [f64; LANES],
    re: [f32; LANES],
    im: [f32; LANES],
    /// Place in the band, relative width and integration time.
    extent: [[f32; LANES]; 3],
}

/// Works out the factors of the instrument for all samples of `block`, which has extents.
#[inline(always)]
pub(super) fn look(block: &VisBlock, gain: &Gain, gains: &mut [f32]) {
    let extents = &block.extents;
    for (k, gains) in gains.chunks_mut(LANES).enumerate() {
        let range = k * LANES..k * LANES + gains.len();
        let (mut uvw, mut extent) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for (lanes, of) in uvw.iter_mut().zip([&block.u, &block.v, &block.w]) {
            for (lane, x) in lanes.iter_mut().zip(&of[range.clone()]) {
                *lane = *x as f32;
            }
        }
        let of = [&extents.place, &extents.width, &extents.interval_s];
        for (lanes, of) in extent.iter_mut().zip(of) {
            lanes[..gains.len()].copy_from_slice(&of[range.clone()]);
        }
        gains.copy_from_slice(&gains_of(gain, &uvw, &extent)[..gains.len()]);
    }
}

/// Subtracts weight times the sum of `models` from the weighted data.
#[inline(always)]
pub(super) fn subtract(block: &mut VisBlock, models: &[Model]) {
    for first in (0..block.len()).step_by(LANES) {
        let range = first..block.len().min(first + LANES);
        let count = range.len();
        let mut lanes = Lanes::default();
        lanes.u[..count].copy_from_slice(&block.u[range.clone()]);
        lanes.v[..count].copy_from_slice(&block.v[range.clone()]);
        lanes.w[..count].copy_from_slice(&block.w[range.clone()]);
        let extents = &block.extents;
        if extents.instrument.is_some() {
            let of = [&extents.place, &extents.width, &extents.interval_s];
            for (lanes, of) in lanes.extent.iter_mut().zip(of) {
                lanes[..count].copy_from_slice(&of[range.clone()]);
            }
        }
        for model in models {
            lanes.add(model);
        }
        let data = block.weighted_re[range.clone()].iter_mut();
        let data = data.zip(&mut block.weighted_im[range.clone()]);
        for (i, ((re, im), weight)) in data.zip(&block.weight[range]).enumerate() {
            *re -= weight * lanes.re[i];
            *im -= weight * lanes.im[i];
        }
    }
}

impl Lanes {
    /// Adds the visibilities of `model`.
    #[inline(always)]
    fn add(&mut self, model: &Model) {
        if !self.holds_phases_of(&model.term) {
            return self.add_plain(model);
        }
        match model.term.profile {
            Profile::Exponential => self.add_with(model, exponential),
            Profile::Gaussian => self.add_with(model, gaussian),
            Profile::Point => self.add_with(model, |_| 1.0),
        }
    }

    /// True if every phase fits the fixed-point form.
    #[inline(always)]
    fn holds_phases_of(&self, term: &SourceTerm) -> bool {
        let (l, m, n) = (term.l.abs(), term.m.abs(), term.n_minus_1.abs());
        let mut fits = true;
        for i in 0..LANES {
            let turns = self.u[i].abs() * l + self.v[i].abs() * m + self.w[i].abs() * n;
            fits &= turns < TURNS_MAX;
        }
        fits
    }

    /// With s = sqrt(2) sin πx and c = sqrt(2) cos πx: cos 2πx = 1 - s², sin 2πx = s c.
    #[inline(always)]
    fn add_with(&mut self, model: &Model, factor: impl Fn(f32) -> f32) {
        let (term, gain) = (&model.term, self.gain(model));
        for i in 0..LANES {
            let (u, v, w) = (self.u[i], self.v[i], self.w[i]);
            let phase = PHASE_MAGIC + u * term.l + v * term.m + w * term.n_minus_1;
            let x = phase.to_bits() as i32 as f32 * TURNS_PER_UNIT;
            let sine = x * horner(&SQRT2_SIN_PI, x * x);
            let cosine = horner(&SQRT2_COS_PI, x * x);
            let amplitude = model.flux_jy * gain[i] * factor(term.q(u as f32, v as f32, w as f32));
            self.re[i] += amplitude * (1.0 - sine * sine);
            self.im[i] += amplitude * (sine * cosine);
        }
    }

    /// The instrument's factors; 1 without.
    #[inline(always)]
    fn gain(&self, model: &Model) -> [f32; LANES] {
        let mut gains = [1.0; LANES];
        if let Some(gain) = &model.gain {
            let uvw = [&self.u, &self.v, &self.w].map(|of| of.map(|x| x as f32));
            gains = gains_of(gain, &uvw, &self.extent);
        }
        gains
    }

    /// The same in f64, for phases of any size.
    #[cold]
    fn add_plain(&mut self, model: &Model) {
        let gain = self.gain(model);
        for i in 0..LANES {
            let (u, v, w) = (self.u[i], self.v[i], self.w[i]);
            let vis = predict(&model.source, model.term.profile, u, v, w);
            self.re[i] += gain[i] * vis.re as f32;
            self.im[i] += gain[i] * vis.im as f32;
        }
    }
}
