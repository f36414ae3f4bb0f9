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

/// Coordinates are kept this far from the faces of the unit cube, beyond which z would be infinite.
const FACE: f64 = 1e-14;

/// The coordinate of the unit cube at z.
pub(crate) fn to_unit(z: f64) -> f64 {
    cdf(z).clamp(FACE, 1.0 - FACE)
}

/// z at a coordinate of the unit cube.
pub(crate) fn from_unit(u: f64) -> f64 {
    quantile(u.clamp(FACE, 1.0 - FACE))
}
