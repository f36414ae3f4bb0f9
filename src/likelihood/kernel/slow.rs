//! The tile in plain f64, for phases beyond the fixed-point form (more than 500 000 turns).

use super::numbers::PHASE_MAGIC;
use super::term::SourceTerm;
use super::tile::{LANES, Tile};
use crate::likelihood::Xy;
use crate::rime::shape::Profile;
use std::f64::consts::TAU;

/// X and Y of `term` over `tile`.
pub(super) fn tile_sums(tile: &Tile, term: &SourceTerm) -> Xy {
    let mut sum = Xy::default();
    for pack in tile.packs() {
        for i in 0..LANES {
            let (u, v, w) = (pack.u[i], pack.v[i], pack.w[i]);
            let turns = u * term.l + v * term.m + w * term.n_minus_1;
            let cosine = (TAU * (turns - turns.round() + pack.start[i] - PHASE_MAGIC)).cos();
            let factor = factor(term.profile, term.q(u as f32, v as f32, w as f32) as f64);
            sum.x += pack.amplitude[i] as f64 * factor * cosine;
            sum.y += pack.weight[i] as f64 * factor * factor;
        }
    }
    sum
}

/// F of the scaled Q of [`SourceTerm`].
pub(super) fn factor(profile: Profile, q: f64) -> f64 {
    match profile {
        Profile::Exponential => 1.0 / ((1.0 + q) * (1.0 + q).sqrt()),
        Profile::Gaussian => (-q).exp2(),
        Profile::Point => 1.0,
    }
}
