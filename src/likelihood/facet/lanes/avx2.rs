//! Eight lanes of AVX2 and FMA.
#![allow(unsafe_code)] // every instruction: see the module above

use super::{LANES, Lanes};
use crate::likelihood::kernel::numbers::{EXP2, GAUSSIAN_EXPONENT_MAX};
#[allow(clippy::wildcard_imports)] // twenty intrinsics
use std::arch::x86_64::*;

/// Eight f32.
#[derive(Clone, Copy)]
pub(in super::super) struct Avx2(__m256);

// SAFETY of all blocks: `evaluate` and `fill` make these vectors only after they asserted
// `Isa::Avx2.is_available()`; loads and stores touch eight f32 of a slice of eight, unaligned.
impl Lanes for Avx2 {
    const PARTS: usize = 2;
    type Sum = [__m256d; 2];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        unsafe { Self(_mm256_set1_ps(x)) }
    }

    #[inline(always)]
    fn load(from: &[f32; LANES], part: usize) -> Self {
        let eight = &from[8 * part..8 * part + 8];
        unsafe { Self(_mm256_loadu_ps(eight.as_ptr())) }
    }

    #[inline(always)]
    fn repeat(from: &[f32; LANES], part: usize) -> Self {
        let (first, second) = (from[2 * part], from[2 * part + 1]);
        unsafe { Self(_mm256_set_m128(_mm_set1_ps(second), _mm_set1_ps(first))) }
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES], part: usize) {
        let eight = &mut to[8 * part..8 * part + 8];
        unsafe { _mm256_storeu_ps(eight.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        unsafe { Self(_mm256_add_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        unsafe { Self(_mm256_mul_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        unsafe { Self(_mm256_fmadd_ps(self.0, b.0, c.0)) }
    }

    #[inline(always)]
    fn mul_sub_from(self, b: Self, c: Self) -> Self {
        unsafe { Self(_mm256_fnmadd_ps(self.0, b.0, c.0)) }
    }

    /// From an estimate g good to 3.7e-4 and h = 1 - x g²: g (1 + h/2 + 3h²/8), to 2e-10.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        let guess = unsafe { Self(_mm256_rsqrt_ps(self.0)) };
        let h = self.mul(guess).mul_sub_from(guess, Self::splat(1.0));
        let series = h.mul_add(Self::splat(0.375), Self::splat(0.5));
        guess.mul(h.mul_add(series, Self::splat(1.0)))
    }

    #[inline(always)]
    fn exp2_neg(self) -> Self {
        unsafe {
            let q = _mm256_min_ps(self.0, _mm256_set1_ps(GAUSSIAN_EXPONENT_MAX));
            let power = _mm256_sub_ps(_mm256_setzero_ps(), q);
            let whole = _mm256_cvtps_epi32(power);
            let rest = Self(_mm256_sub_ps(power, _mm256_cvtepi32_ps(whole)));
            let mantissa = EXP2.iter().rev().fold(Self::splat(0.0), |sum, &c| {
                sum.mul_add(rest, Self::splat(c))
            });
            let bits = _mm256_add_epi32(
                _mm256_castps_si256(mantissa.0),
                _mm256_slli_epi32::<23>(whole),
            );
            Self(_mm256_castsi256_ps(bits))
        }
    }

    #[inline(always)]
    fn nothing() -> Self::Sum {
        unsafe { [_mm256_setzero_pd(); 2] }
    }

    #[inline(always)]
    fn add_to(self, sum: Self::Sum) -> Self::Sum {
        unsafe {
            let low = _mm256_cvtps_pd(_mm256_castps256_ps128(self.0));
            let high = _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(self.0));
            [_mm256_add_pd(sum[0], low), _mm256_add_pd(sum[1], high)]
        }
    }

    #[inline(always)]
    fn total(sum: Self::Sum) -> f64 {
        unsafe {
            let four = _mm256_add_pd(sum[0], sum[1]);
            let two = _mm_add_pd(
                _mm256_castpd256_pd128(four),
                _mm256_extractf128_pd::<1>(four),
            );
            _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)))
        }
    }
}
