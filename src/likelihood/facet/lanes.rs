//! Vectors of f32: what the sum over cells needs, once for each instruction set.
//!
//! Implementations for wide registers use instructions that not every processor has: only code that
//! has checked for them may use these types. `evaluate.rs` and `fill.rs` are the only ones, and do.
#![allow(clippy::inline_always)] // must end up in code compiled for the instruction set

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(super) mod avx512;
pub(super) mod portable;

use super::cells::LANES;

/// A vector of f32, [`LANES`] or half as many.
///
/// | function | value |
/// |---|---|
/// | `splat` | the same number in all lanes |
/// | `load` | lanes number `part` of sixteen numbers |
/// | `repeat` | every number of group `part` four times, for as many as there are lanes |
/// | `store` | writes the lanes number `part` of sixteen numbers |
/// | `add`, `mul` | sum, product |
/// | `mul_add` | a b + c |
/// | `mul_sub_from` | c - a b |
/// | `rsqrt` | 1/sqrt, to 3e-7 relative |
/// | `exp2_neg` | 2^(-q) for q >= 0, to 2e-7 relative, never subnormal |
/// | `add_to` | adds every lane to a sum in f64 |
/// | `total` | all the lanes of a sum together |
pub(super) trait Lanes: Copy {
    /// Vectors that hold sixteen numbers.
    const PARTS: usize;
    /// As many f64.
    type Sum: Copy;
    fn splat(x: f32) -> Self;
    fn load(from: &[f32; LANES], part: usize) -> Self;
    fn repeat(from: &[f32; LANES], part: usize) -> Self;
    fn store(self, to: &mut [f32; LANES], part: usize);
    fn add(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn mul_add(self, b: Self, c: Self) -> Self;
    fn mul_sub_from(self, b: Self, c: Self) -> Self;
    fn rsqrt(self) -> Self;
    fn exp2_neg(self) -> Self;
    fn nothing() -> Self::Sum;
    fn add_to(self, sum: Self::Sum) -> Self::Sum;
    fn total(sum: Self::Sum) -> f64;
}
