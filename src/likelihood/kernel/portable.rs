//! The kernel in plain Rust: loops over sixteen lanes that the compiler vectorises as it can.

use super::numbers::{EXP2, GAUSSIAN_EXPONENT_MAX, SQRT2_SIN_PI, TURNS_PER_UNIT, horner};
use super::term::SourceTerm;
use super::tile::{LANES, Pack, TILE, Tile};
use crate::likelihood::extents::Gain;
use crate::likelihood::{VisBlock, Xy};
use crate::rime::shape::Profile;

/// Adds the sums of each term over `block` to `sums`.
pub(super) fn accumulate(block: &VisBlock, terms: &[SourceTerm], gains: &[Gain], sums: &mut [Xy]) {
    let mut tile = Tile::new();
    for first in (0..block.len()).step_by(TILE) {
        tile.fill(block, first);
        for (i, (term, sum)) in terms.iter().zip(&mut *sums).enumerate() {
            tile.look(gains.get(i..=i));
            let part = tile_sums(&tile, term);
            sum.x += part.x;
            sum.y += part.y;
        }
    }
}

/// X and Y of `term` over `tile`.
fn tile_sums(tile: &Tile, term: &SourceTerm) -> Xy {
    if !tile.holds_phases_of(term) {
        return super::slow::tile_sums(tile, term);
    }
    match term.profile {
        Profile::Exponential => sums_with(tile, term, exponential),
        Profile::Gaussian => sums_with(tile, term, gaussian),
        Profile::Point => sums_with(tile, term, |_| 1.0),
    }
}

#[inline(always)]
fn sums_with(tile: &Tile, term: &SourceTerm, factor: impl Fn(f32) -> f32) -> Xy {
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    for pack in tile.packs() {
        let cosine = cosine(&fixed_phase(pack, term));
        for i in 0..LANES {
            let f = factor(term.q(pack.u_single[i], pack.v_single[i], pack.w_single[i]));
            x[i] += pack.amplitude[i] * f * cosine[i];
            y[i] += pack.weight[i] * f * f;
        }
    }
    Xy {
        x: x.iter().map(|&x| x as f64).sum(),
        y: y.iter().map(|&y| y as f64).sum(),
    }
}

/// Phase minus the angle of the datum, modulo a turn, in fixed point.
#[inline(always)]
fn fixed_phase(pack: &Pack, term: &SourceTerm) -> [i32; LANES] {
    std::array::from_fn(|i| {
        let sum =
            pack.start[i] + pack.u[i] * term.l + pack.v[i] * term.m + pack.w[i] * term.n_minus_1;
        sum.to_bits() as i32
    })
}

/// cos 2πx = 1 - (sqrt(2) sin πx)², without folding: |πx| <= π/2 as it stands.
#[inline(always)]
fn cosine(phase: &[i32; LANES]) -> [f32; LANES] {
    std::array::from_fn(|i| {
        let x = phase[i] as f32 * TURNS_PER_UNIT;
        let sine = x * horner(&SQRT2_SIN_PI, x * x);
        1.0 - sine * sine
    })
}

/// (1 + Q)^(-3/2).
#[inline(always)]
pub(super) fn exponential(q: f32) -> f32 {
    let t = 1.0 + q;
    1.0 / (t * t.sqrt())
}

/// 2^(-Q): the whole part goes to the exponent bits, the rest through a polynomial.
#[inline(always)]
pub(super) fn gaussian(q: f32) -> f32 {
    // 1.5 x 2^23: adding it rounds to a whole number, which the low bits then hold
    const ROUND: f32 = 12_582_912.0;
    let power = -q.min(GAUSSIAN_EXPONENT_MAX);
    let whole = power + ROUND;
    let mantissa = horner(&EXP2, power - (whole - ROUND));
    f32::from_bits(mantissa.to_bits().wrapping_add(whole.to_bits() << 23))
}
