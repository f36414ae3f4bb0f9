//! The kernel in AVX-512F: sixteen lanes.
//!
//! Per sixteen samples of an exponential disk 35 vector instructions: 6 FMA and a permutation for
//! the phase, 11 for the cosine and X, 7 for Q, 8 for F, 2 for Y.
#![allow(unsafe_code)] // loads through pointers; entering code compiled for AVX-512

use super::cross::{self, PairTerm};
use super::model::{self, Model};
use super::numbers::{EXP2, GAUSSIAN_EXPONENT_MAX, SQRT2_SIN_PI, TURNS_PER_UNIT};
use super::term::SourceTerm;
use super::tile::{LANES, Pack, TILE, Tile};
use crate::likelihood::extents::Gain;
use crate::likelihood::{VisBlock, Xy};
use crate::rime::shape::Profile;
#[allow(clippy::wildcard_imports)] // thirty intrinsics
use std::arch::x86_64::*;

const EXPONENTIAL: u8 = 0;
const GAUSSIAN: u8 = 1;
const POINT: u8 = 2;

/// Adds the sums of each term over `block` to `sums`. The caller has checked for AVX-512F.
pub(super) fn accumulate(block: &VisBlock, terms: &[SourceTerm], gains: &[Gain], sums: &mut [Xy]) {
    // SAFETY: `kernel::accumulate`, the only caller, asserts `Isa::Avx512.is_available()`.
    unsafe { accumulate_avx512(block, terms, gains, sums) }
}

#[target_feature(enable = "avx512f,avx2,fma")]
fn accumulate_avx512(block: &VisBlock, terms: &[SourceTerm], gains: &[Gain], sums: &mut [Xy]) {
    let mut tile = Tile::new();
    for first in (0..block.len()).step_by(TILE) {
        tile.fill(block, first);
        for (i, (term, sum)) in terms.iter().zip(&mut *sums).enumerate() {
            tile.look(gains.get(i..=i));
            let part = if tile.holds_phases_of(term) {
                match term.profile {
                    Profile::Exponential => tile_sums::<EXPONENTIAL>(&tile, term),
                    Profile::Gaussian => tile_sums::<GAUSSIAN>(&tile, term),
                    Profile::Point => tile_sums::<POINT>(&tile, term),
                }
            } else {
                super::slow::tile_sums(&tile, term)
            };
            sum.x += part.x;
            sum.y += part.y;
        }
    }
}

/// Subtracts the models from `block`. The caller has checked for the instructions.
pub(super) fn subtract(block: &mut VisBlock, models: &[Model]) {
    // SAFETY: `kernel::subtract`, the only caller, asserts `Isa::Avx512.is_available()`.
    unsafe { subtract_avx512(block, models) }
}

#[target_feature(enable = "avx512f,avx2,fma")]
fn subtract_avx512(block: &mut VisBlock, models: &[Model]) {
    model::subtract(block, models);
}

/// Works out factors of the instrument. The caller has checked for the instructions.
pub(super) fn look(block: &VisBlock, gain: &Gain, gains: &mut [f32]) {
    // SAFETY: `kernel::look`, the only caller, asserts `Isa::Avx512.is_available()`.
    unsafe { look_avx512(block, gain, gains) }
}

#[target_feature(enable = "avx512f,avx2,fma")]
fn look_avx512(block: &VisBlock, gain: &Gain, gains: &mut [f32]) {
    model::look(block, gain, gains);
}

/// Adds the sums of pairs over `block` to `sums`. The caller has checked for the instructions.
pub(super) fn accumulate_pairs(
    block: &VisBlock,
    terms: &[PairTerm],
    gains: &[Gain],
    sums: &mut [f64],
) {
    // SAFETY: `kernel::accumulate_pairs`, the only caller, asserts `Isa::Avx512.is_available()`.
    unsafe { accumulate_pairs_avx512(block, terms, gains, sums) }
}

#[target_feature(enable = "avx512f,avx2,fma")]
fn accumulate_pairs_avx512(block: &VisBlock, terms: &[PairTerm], gains: &[Gain], sums: &mut [f64]) {
    cross::accumulate(block, terms, gains, sums);
}

/// X and Y of `term` over `tile`.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn tile_sums<const PROFILE: u8>(tile: &Tile, term: &SourceTerm) -> Xy {
    let (mut x, mut y) = (_mm512_setzero_ps(), _mm512_setzero_ps());
    for pack in tile.packs() {
        let cosine = cosine(fixed_phase(pack, term));
        let (amplitude, weight) = (load(&pack.amplitude), load(&pack.weight));
        if PROFILE == POINT {
            x = _mm512_fmadd_ps(amplitude, cosine, x);
            y = _mm512_add_ps(weight, y);
        } else {
            let factor = match PROFILE {
                EXPONENTIAL => exponential(_mm512_set1_ps(1.0), pack, term),
                _ => gaussian(pack, term),
            };
            x = _mm512_fmadd_ps(_mm512_mul_ps(amplitude, factor), cosine, x);
            y = _mm512_fmadd_ps(_mm512_mul_ps(weight, factor), factor, y);
        }
    }
    Xy {
        x: total(x),
        y: total(y),
    }
}

/// Phase minus the angle of the datum, modulo a turn, in fixed point.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn fixed_phase(pack: &Pack, term: &SourceTerm) -> __m512i {
    let low_halves = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    let (l, m) = (_mm512_set1_pd(term.l), _mm512_set1_pd(term.m));
    let n_minus_1 = _mm512_set1_pd(term.n_minus_1);
    let phase = |half: usize| {
        let mut sum = load_half(&pack.start, half);
        sum = _mm512_fmadd_pd(load_half(&pack.u, half), l, sum);
        sum = _mm512_fmadd_pd(load_half(&pack.v, half), m, sum);
        sum = _mm512_fmadd_pd(load_half(&pack.w, half), n_minus_1, sum);
        _mm512_castpd_si512(sum)
    };
    _mm512_permutex2var_epi32(phase(0), low_halves, phase(1))
}

/// cos 2πx = 1 - (sqrt(2) sin πx)², without folding: |πx| <= π/2 as it stands.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn cosine(phase: __m512i) -> __m512 {
    let x = _mm512_mul_ps(_mm512_cvtepi32_ps(phase), _mm512_set1_ps(TURNS_PER_UNIT));
    let sine = _mm512_mul_ps(x, horner(&SQRT2_SIN_PI, _mm512_mul_ps(x, x)));
    _mm512_fnmadd_ps(sine, sine, _mm512_set1_ps(1.0))
}

/// Q + `offset`.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn radius(offset: __m512, pack: &Pack, term: &SourceTerm) -> __m512 {
    let ([p, r, t], [s, z]) = (
        term.along.map(|x| _mm512_set1_ps(x)),
        term.across.map(|x| _mm512_set1_ps(x)),
    );
    let (v, w) = (load(&pack.v_single), load(&pack.w_single));
    let along = _mm512_mul_ps(p, load(&pack.u_single));
    let along = _mm512_fmadd_ps(t, w, _mm512_fmadd_ps(r, v, along));
    let across = _mm512_fmadd_ps(z, w, _mm512_mul_ps(s, v));
    _mm512_fmadd_ps(along, along, _mm512_fmadd_ps(across, across, offset))
}

/// (1 + Q)^(-3/2) = t^(-3/2). From an estimate g of 1/sqrt(t), good to 2^-14, and
/// h = 1 - t g²: t^(-3/2) = g³ (1 - h)^(-3/2) = g³ (1 + 3h/2) to 3e-8.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn exponential(one: __m512, pack: &Pack, term: &SourceTerm) -> __m512 {
    let t = radius(one, pack, term);
    let guess = _mm512_rsqrt14_ps(t);
    let square = _mm512_mul_ps(guess, guess);
    let h = _mm512_fnmadd_ps(t, square, one);
    let cube = _mm512_mul_ps(square, guess);
    _mm512_mul_ps(cube, _mm512_fmadd_ps(h, _mm512_set1_ps(1.5), one))
}

/// 2^(-Q).
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn gaussian(pack: &Pack, term: &SourceTerm) -> __m512 {
    let q = radius(_mm512_setzero_ps(), pack, term);
    let q = _mm512_min_ps(q, _mm512_set1_ps(GAUSSIAN_EXPONENT_MAX));
    let power = _mm512_sub_ps(_mm512_setzero_ps(), q);
    let whole = _mm512_roundscale_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(power);
    _mm512_scalef_ps(horner(&EXP2, _mm512_sub_ps(power, whole)), whole)
}

/// c0 + c1 x + ...
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn horner<const N: usize>(coefficients: &[f32; N], x: __m512) -> __m512 {
    let mut sum = _mm512_set1_ps(coefficients[N - 1]);
    for &c in coefficients[..N - 1].iter().rev() {
        sum = _mm512_fmadd_ps(sum, x, _mm512_set1_ps(c));
    }
    sum
}

/// Sum of the lanes, in f64.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn total(lanes: __m512) -> f64 {
    let low = _mm512_castps512_ps256(lanes);
    let high = _mm512_castps512_ps256(_mm512_shuffle_f32x4::<0b1110>(lanes, lanes));
    _mm512_reduce_add_pd(_mm512_add_pd(_mm512_cvtps_pd(low), _mm512_cvtps_pd(high)))
}

#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn load(lanes: &[f32; LANES]) -> __m512 {
    // SAFETY: the array holds sixteen f32, the instruction reads sixteen and needs no alignment.
    unsafe { _mm512_loadu_ps(lanes.as_ptr()) }
}

/// Eight of the sixteen lanes, the first ones for `half` 0.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn load_half(lanes: &[f64; LANES], half: usize) -> __m512d {
    let eight = &lanes[8 * half..8 * half + 8];
    // SAFETY: the slice holds eight f64, the instruction reads eight and needs no alignment.
    unsafe { _mm512_loadu_pd(eight.as_ptr()) }
}
