//! The kernel in AVX2 and FMA: eight lanes, two vectors a pack.
#![allow(unsafe_code)] // loads through pointers; entering code compiled for AVX2

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

/// Adds the sums of each term over `block` to `sums`. The caller has checked for AVX2 and FMA.
pub(super) fn accumulate(block: &VisBlock, terms: &[SourceTerm], gains: &[Gain], sums: &mut [Xy]) {
    // SAFETY: `kernel::accumulate`, the only caller, asserts `Isa::Avx2.is_available()`.
    unsafe { accumulate_avx2(block, terms, gains, sums) }
}

#[target_feature(enable = "avx2,fma")]
fn accumulate_avx2(block: &VisBlock, terms: &[SourceTerm], gains: &[Gain], sums: &mut [Xy]) {
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
    // SAFETY: `kernel::subtract`, the only caller, asserts `Isa::Avx2.is_available()`.
    unsafe { subtract_avx2(block, models) }
}

#[target_feature(enable = "avx2,fma")]
fn subtract_avx2(block: &mut VisBlock, models: &[Model]) {
    model::subtract(block, models);
}

/// Works out factors of the instrument. The caller has checked for the instructions.
pub(super) fn look(block: &VisBlock, gain: &Gain, gains: &mut [f32]) {
    // SAFETY: `kernel::look`, the only caller, asserts `Isa::Avx2.is_available()`.
    unsafe { look_avx2(block, gain, gains) }
}

#[target_feature(enable = "avx2,fma")]
fn look_avx2(block: &VisBlock, gain: &Gain, gains: &mut [f32]) {
    model::look(block, gain, gains);
}

/// Adds the sums of pairs over `block` to `sums`. The caller has checked for the instructions.
pub(super) fn accumulate_pairs(
    block: &VisBlock,
    terms: &[PairTerm],
    gains: &[Gain],
    sums: &mut [f64],
) {
    // SAFETY: `kernel::accumulate_pairs`, the only caller, asserts `Isa::Avx2.is_available()`.
    unsafe { accumulate_pairs_avx2(block, terms, gains, sums) }
}

#[target_feature(enable = "avx2,fma")]
fn accumulate_pairs_avx2(block: &VisBlock, terms: &[PairTerm], gains: &[Gain], sums: &mut [f64]) {
    cross::accumulate(block, terms, gains, sums);
}

/// X and Y of `term` over `tile`.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn tile_sums<const PROFILE: u8>(tile: &Tile, term: &SourceTerm) -> Xy {
    let (mut x, mut y) = (_mm256_setzero_ps(), _mm256_setzero_ps());
    for pack in tile.packs() {
        for half in 0..2 {
            let cosine = cosine(fixed_phase(pack, half, term));
            let amplitude = load(&pack.amplitude, half);
            let weight = load(&pack.weight, half);
            if PROFILE == POINT {
                x = _mm256_fmadd_ps(amplitude, cosine, x);
                y = _mm256_add_ps(weight, y);
            } else {
                let factor = match PROFILE {
                    EXPONENTIAL => exponential(pack, half, term),
                    _ => gaussian(pack, half, term),
                };
                x = _mm256_fmadd_ps(_mm256_mul_ps(amplitude, factor), cosine, x);
                y = _mm256_fmadd_ps(_mm256_mul_ps(weight, factor), factor, y);
            }
        }
    }
    Xy {
        x: total(x),
        y: total(y),
    }
}

/// Phase minus the angle of the datum, modulo a turn, in fixed point.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn fixed_phase(pack: &Pack, half: usize, term: &SourceTerm) -> __m256i {
    let (l, m) = (_mm256_set1_pd(term.l), _mm256_set1_pd(term.m));
    let n_minus_1 = _mm256_set1_pd(term.n_minus_1);
    let phase = |quarter: usize| {
        let mut sum = load_quarter(&pack.start, quarter);
        sum = _mm256_fmadd_pd(load_quarter(&pack.u, quarter), l, sum);
        sum = _mm256_fmadd_pd(load_quarter(&pack.v, quarter), m, sum);
        sum = _mm256_fmadd_pd(load_quarter(&pack.w, quarter), n_minus_1, sum);
        _mm256_castpd_ps(sum)
    };
    // low halves of the eight sums, in the order 0 1 4 5 2 3 6 7, then put right
    let low = _mm256_shuffle_ps::<0b10_00_10_00>(phase(2 * half), phase(2 * half + 1));
    _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_castps_si256(low))
}

/// cos 2πx = 1 - (sqrt(2) sin πx)², without folding: |πx| <= π/2 as it stands.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn cosine(phase: __m256i) -> __m256 {
    let x = _mm256_mul_ps(_mm256_cvtepi32_ps(phase), _mm256_set1_ps(TURNS_PER_UNIT));
    let sine = _mm256_mul_ps(x, horner(&SQRT2_SIN_PI, _mm256_mul_ps(x, x)));
    _mm256_fnmadd_ps(sine, sine, _mm256_set1_ps(1.0))
}

/// Q + `offset`.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn radius(offset: __m256, pack: &Pack, half: usize, term: &SourceTerm) -> __m256 {
    let ([p, r, t], [s, z]) = (
        term.along.map(|x| _mm256_set1_ps(x)),
        term.across.map(|x| _mm256_set1_ps(x)),
    );
    let (v, w) = (load(&pack.v_single, half), load(&pack.w_single, half));
    let along = _mm256_mul_ps(p, load(&pack.u_single, half));
    let along = _mm256_fmadd_ps(t, w, _mm256_fmadd_ps(r, v, along));
    let across = _mm256_fmadd_ps(z, w, _mm256_mul_ps(s, v));
    _mm256_fmadd_ps(along, along, _mm256_fmadd_ps(across, across, offset))
}

/// (1 + Q)^(-3/2) = t^(-3/2). From an estimate g of 1/sqrt(t), good to 3.7e-4, and
/// h = 1 - t g²: t^(-3/2) = g³ (1 - h)^(-3/2) = g³ (1 + 3h/2 + 15h²/8) to 1e-9.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn exponential(pack: &Pack, half: usize, term: &SourceTerm) -> __m256 {
    let one = _mm256_set1_ps(1.0);
    let t = radius(one, pack, half, term);
    let guess = _mm256_rsqrt_ps(t);
    let square = _mm256_mul_ps(guess, guess);
    let h = _mm256_fnmadd_ps(t, square, one);
    let cube = _mm256_mul_ps(square, guess);
    _mm256_mul_ps(cube, horner(&[1.0, 1.5, 1.875], h))
}

/// 2^(-Q): the whole part goes to the exponent bits, the rest through a polynomial.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn gaussian(pack: &Pack, half: usize, term: &SourceTerm) -> __m256 {
    let q = radius(_mm256_setzero_ps(), pack, half, term);
    let q = _mm256_min_ps(q, _mm256_set1_ps(GAUSSIAN_EXPONENT_MAX));
    let power = _mm256_sub_ps(_mm256_setzero_ps(), q);
    let whole = _mm256_cvtps_epi32(power);
    let rest = _mm256_sub_ps(power, _mm256_cvtepi32_ps(whole));
    let mantissa = _mm256_castps_si256(horner(&EXP2, rest));
    _mm256_castsi256_ps(_mm256_add_epi32(mantissa, _mm256_slli_epi32::<23>(whole)))
}

/// c0 + c1 x + ...
#[inline]
#[target_feature(enable = "avx2,fma")]
fn horner<const N: usize>(coefficients: &[f32; N], x: __m256) -> __m256 {
    let mut sum = _mm256_set1_ps(coefficients[N - 1]);
    for &c in coefficients[..N - 1].iter().rev() {
        sum = _mm256_fmadd_ps(sum, x, _mm256_set1_ps(c));
    }
    sum
}

/// Sum of the lanes, in f64.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn total(lanes: __m256) -> f64 {
    let low = _mm256_cvtps_pd(_mm256_castps256_ps128(lanes));
    let high = _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(lanes));
    let four = _mm256_add_pd(low, high);
    let two = _mm_add_pd(
        _mm256_castpd256_pd128(four),
        _mm256_extractf128_pd::<1>(four),
    );
    _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)))
}

/// Eight of the sixteen lanes, the first ones for `half` 0.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn load(lanes: &[f32; LANES], half: usize) -> __m256 {
    let eight = &lanes[8 * half..8 * half + 8];
    // SAFETY: the slice holds eight f32, the instruction reads eight and needs no alignment.
    unsafe { _mm256_loadu_ps(eight.as_ptr()) }
}

/// Four of the sixteen lanes, the first ones for `quarter` 0.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn load_quarter(lanes: &[f64; LANES], quarter: usize) -> __m256d {
    let four = &lanes[4 * quarter..4 * quarter + 4];
    // SAFETY: the slice holds four f64, the instruction reads four and needs no alignment.
    unsafe { _mm256_loadu_pd(four.as_ptr()) }
}
