//! The sum of the product of two models over one block, in plain loops that are compiled anew for
//! each instruction set.

use super::numbers::{PHASE_MAGIC, SQRT2_SIN_PI, TURNS_PER_UNIT, horner};
use super::portable::{exponential, gaussian};
use super::slow;
use super::term::SourceTerm;
use super::tile::{LANES, TILE, Tile};
use crate::likelihood::VisBlock;
use crate::likelihood::extents::Gain;
use crate::rime::shape::Profile;
use crate::rime::{Ray, Source};
use std::f64::consts::TAU;

/// Two sources of unit flux density, ready for the kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairTerm {
    /// The first one with the phase of the first less that of the second.
    first: SourceTerm,
    second: SourceTerm,
    rays: [Ray; 2],
}

impl PairTerm {
    /// The term of a pair; its flux densities are left out.
    pub fn new([first, second]: &[Source; 2], profile: Profile) -> PairTerm {
        let [a, b] = [first, second].map(|source| SourceTerm::new(source, profile));
        PairTerm {
            first: SourceTerm {
                l: a.l - b.l,
                m: a.m - b.m,
                n_minus_1: a.n_minus_1 - b.n_minus_1,
                ..a
            },
            second: b,
            rays: [first.ray(), second.ray()],
        }
    }

    /// What the instrument makes the factors of both of.
    pub(super) fn rays(&self) -> [Ray; 2] {
        self.rays
    }
}

/// Adds Σ w F_i F_j cos 2π(φ_i - φ_j) of each of `terms` over `block` to `sums`.
#[inline(always)]
pub(super) fn accumulate(block: &VisBlock, terms: &[PairTerm], gains: &[Gain], sums: &mut [f64]) {
    let mut tile = Tile::new();
    for first in (0..block.len()).step_by(TILE) {
        tile.fill(block, first);
        for (i, (term, sum)) in terms.iter().zip(&mut *sums).enumerate() {
            tile.look(gains.get(2 * i..2 * i + 2));
            *sum += if tile.holds_phases_of(&term.first) {
                tile_sum(&tile, term)
            } else {
                slow_tile_sum(&tile, term)
            };
        }
    }
}

#[inline(always)]
fn tile_sum(tile: &Tile, term: &PairTerm) -> f64 {
    match term.first.profile {
        Profile::Exponential => sum_with(tile, term, exponential),
        Profile::Gaussian => sum_with(tile, term, gaussian),
        Profile::Point => sum_with(tile, term, |_| 1.0),
    }
}

#[inline(always)]
fn sum_with(tile: &Tile, term: &PairTerm, factor: impl Fn(f32) -> f32) -> f64 {
    let PairTerm { first, second, .. } = term;
    let mut sums = [0.0; LANES];
    for pack in tile.packs() {
        for (i, sum) in sums.iter_mut().enumerate() {
            let phase = PHASE_MAGIC
                + pack.u[i] * first.l
                + pack.v[i] * first.m
                + pack.w[i] * first.n_minus_1;
            let x = phase.to_bits() as i32 as f32 * TURNS_PER_UNIT;
            let sine = x * horner(&SQRT2_SIN_PI, x * x);
            let (u, v, w) = (pack.u_single[i], pack.v_single[i], pack.w_single[i]);
            let product = factor(first.q(u, v, w)) * factor(second.q(u, v, w));
            *sum += pack.weight[i] * product * (1.0 - sine * sine);
        }
    }
    sums.iter().map(|&x| x as f64).sum()
}

/// The same in f64, for phases beyond the fixed-point form.
#[cold]
fn slow_tile_sum(tile: &Tile, PairTerm { first, second, .. }: &PairTerm) -> f64 {
    let factor = |term: &SourceTerm, u: f64, v: f64, w: f64| {
        slow::factor(term.profile, term.q(u as f32, v as f32, w as f32) as f64)
    };
    let mut sum = 0.0;
    for pack in tile.packs() {
        for i in 0..LANES {
            let (u, v, w) = (pack.u[i], pack.v[i], pack.w[i]);
            let turns = u * first.l + v * first.m + w * first.n_minus_1;
            let cosine = (TAU * (turns - turns.round())).cos();
            let product = factor(first, u, v, w) * factor(second, u, v, w);
            sum += pack.weight[i] as f64 * product * cosine;
        }
    }
    sum
}
