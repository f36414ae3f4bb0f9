//! The normal distribution: its cumulative distribution and the inverse of that.

use std::f64::consts::SQRT_2;

/// Probability of less than `z` standard deviations; keeps its digits in the lower tail.
pub(crate) fn cdf(z: f64) -> f64 {
    puruspe::erfc(-z / SQRT_2) / 2.0
}

/// The inverse of [`cdf`].
pub(crate) fn quantile(p: f64) -> f64 {
    -SQRT_2 * puruspe::inverfc(2.0 * p)
}
