//! Sixteen numbers, whatever the compiler makes of them.

use super::{LANES, Lanes};
use crate::likelihood::kernel::numbers::{EXP2, GAUSSIAN_EXPONENT_MAX, horner};

/// Sixteen f32.
#[derive(Clone, Copy)]
pub(in super::super) struct Plain([f32; LANES]);

impl Plain {
    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Plain(self.0.map(f))
    }
}

impl Lanes for Plain {
    const PARTS: usize = 1;
    type Sum = [f64; LANES];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Plain([x; LANES])
    }

    #[inline(always)]
    fn load(from: &[f32; LANES], _part: usize) -> Self {
        Plain(*from)
    }

    #[inline(always)]
    fn repeat(from: &[f32; LANES], part: usize) -> Self {
        let mut four_times = [0.0; LANES];
        for i in 0..LANES {
            four_times[i] = from[LANES / 4 * part + i / 4];
        }
        Plain(four_times)
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES], _part: usize) {
        *to = self.0;
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Plain(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Plain(std::array::from_fn(|i| self.0[i] * other.0[i]))
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Plain(std::array::from_fn(|i| self.0[i] * b.0[i] + c.0[i]))
    }

    #[inline(always)]
    fn mul_sub_from(self, b: Self, c: Self) -> Self {
        Plain(std::array::from_fn(|i| c.0[i] - self.0[i] * b.0[i]))
    }

    #[inline(always)]
    fn rsqrt(self) -> Self {
        self.map(|x| 1.0 / x.sqrt())
    }

    #[inline(always)]
    fn exp2_neg(self) -> Self {
        // 1.5 x 2^23: adding it rounds to a whole number, which the low bits then hold
        const ROUND: f32 = 12_582_912.0;
        self.map(|q| {
            let power = -q.min(GAUSSIAN_EXPONENT_MAX);
            let whole = power + ROUND;
            let mantissa = horner(&EXP2, power - (whole - ROUND));
            f32::from_bits(mantissa.to_bits().wrapping_add(whole.to_bits() << 23))
        })
    }

    #[inline(always)]
    fn nothing() -> Self::Sum {
        [0.0; LANES]
    }

    #[inline(always)]
    fn add_to(self, sum: Self::Sum) -> Self::Sum {
        std::array::from_fn(|i| sum[i] + f64::from(self.0[i]))
    }

    #[inline(always)]
    fn total(sum: Self::Sum) -> f64 {
        sum.iter().sum()
    }
}
