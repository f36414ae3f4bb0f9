//! Sixteen lanes of AVX-512F.
#![allow(unsafe_code)] // every instruction: see the module above

use super::{LANES, Lanes};
use crate::likelihood::kernel::numbers::{EXP2, GAUSSIAN_EXPONENT_MAX};
#[allow(clippy::wildcard_imports)] // twenty intrinsics
use std::arch::x86_64::*;

/// Sixteen f32.
#[derive(Clone, Copy)]
pub(in super::super) struct Avx512(__m512);

// SAFETY of all blocks: `evaluate` and `fill` make these vectors only after they asserted
// `Isa::Avx512.is_available()`; loads and stores touch sixteen f32 of an array of sixteen, unaligned.
impl Lanes for Avx512 {
    const PARTS: usize = 1;
    type Sum = [__m512d; 2];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        unsafe { Self(_mm512_set1_ps(x)) }
    }

    #[inline(always)]
    fn load(from: &[f32; LANES], _part: usize) -> Self {
        unsafe { Self(_mm512_loadu_ps(from.as_ptr())) }
    }

    #[inline(always)]
    fn repeat(from: &[f32; LANES], part: usize) -> Self {
        let four = &from[4 * part..4 * part + 4];
        unsafe {
            let which = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
            let four = _mm512_castps128_ps512(_mm_loadu_ps(four.as_ptr()));
            Self(_mm512_permutexvar_ps(which, four))
        }
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES], _part: usize) {
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        unsafe { Self(_mm512_add_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        unsafe { Self(_mm512_mul_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        unsafe { Self(_mm512_fmadd_ps(self.0, b.0, c.0)) }
    }

    #[inline(always)]
    fn mul_sub_from(self, b: Self, c: Self) -> Self {
        unsafe { Self(_mm512_fnmadd_ps(self.0, b.0, c.0)) }
    }

    /// From an estimate g good to 2^-14 and h = 1 - x g²: g (1 + h/2), to 1.4e-9.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        let guess = unsafe { Self(_mm512_rsqrt14_ps(self.0)) };
        let h = self.mul(guess).mul_sub_from(guess, Self::splat(1.0));
        guess.mul(h.mul_add(Self::splat(0.5), Self::splat(1.0)))
    }

    #[inline(always)]
    fn exp2_neg(self) -> Self {
        const NEAREST: i32 = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;
        unsafe {
            let q = _mm512_min_ps(self.0, _mm512_set1_ps(GAUSSIAN_EXPONENT_MAX));
            let power = _mm512_sub_ps(_mm512_setzero_ps(), q);
            let whole = _mm512_roundscale_ps::<NEAREST>(power);
            let rest = Self(_mm512_sub_ps(power, whole));
            let mantissa = EXP2.iter().rev().fold(Self::splat(0.0), |sum, &c| {
                sum.mul_add(rest, Self::splat(c))
            });
            Self(_mm512_scalef_ps(mantissa.0, whole))
        }
    }

    #[inline(always)]
    fn nothing() -> Self::Sum {
        unsafe { [_mm512_setzero_pd(); 2] }
    }

    #[inline(always)]
    fn add_to(self, sum: Self::Sum) -> Self::Sum {
        unsafe {
            let low = _mm512_castps512_ps256(self.0);
            let high = _mm512_castps512_ps256(_mm512_shuffle_f32x4::<0b1110>(self.0, self.0));
            [
                _mm512_add_pd(sum[0], _mm512_cvtps_pd(low)),
                _mm512_add_pd(sum[1], _mm512_cvtps_pd(high)),
            ]
        }
    }

    #[inline(always)]
    fn total(sum: Self::Sum) -> f64 {
        unsafe { _mm512_reduce_add_pd(_mm512_add_pd(sum[0], sum[1])) }
    }
}
