//! Constants of the kernels: the fixed-point phase and the minimax polynomials.
//!
//! Polynomials are fits by the Remez algorithm, with the leading coefficient held at its f32
//! value; each has a test on its error.

/// 1.5 x 2^20. An f64 of this size has an ulp of 2^-32, so that after adding a phase in turns the
/// low 32 bits of the sum are the phase modulo one turn, in fixed point and already rounded.
/// Signed, they lie in [-1/2, 1/2) turn. Valid for phases up to [`TURNS_MAX`].
pub(in crate::likelihood) const PHASE_MAGIC: f64 = 1_572_864.0;

/// Largest phase [turn] that the fixed-point form holds, with room for the offset of the datum.
pub(in crate::likelihood) const TURNS_MAX: f64 = 524_286.0;

/// Fixed point to turns: 2^-32.
pub(in crate::likelihood) const TURNS_PER_UNIT: f32 = 1.0 / 4_294_967_296.0;

/// sqrt(2) sin(πx) = x (c0 + c1 x² + ...) on |x| <= 1/2, to 5e-8. Its square is 1 - cos(2πx).
///
/// c3 is 3.3e-6 above the fit: as fitted, the mean of cos(2πx) over a turn was 9e-9 instead of 0,
/// and while noise adds up sqrt(N) times, a bias adds up N times.
pub(in crate::likelihood) const SQRT2_SIN_PI: [f32; 5] = [
    4.442_883,
    -7.308_249,
    3.606_387_4,
    -0.846_244_9,
    0.110_019_25,
];

/// sqrt(2) cos(πx) = c0 + c1 x² + ... on |x| <= 1/2, to 5e-8.
pub(in crate::likelihood) const SQRT2_COS_PI: [f32; 6] = [
    std::f32::consts::SQRT_2,
    -6.978_859_4,
    5.739_727_5,
    -1.886_545_4,
    0.324_332_1,
    -0.021_814_223,
];

/// 2^x = c0 + c1 x + ... on |x| <= 1/2, to 2e-8 relative.
pub(in crate::likelihood) const EXP2: [f32; 7] = [
    1.0,
    std::f32::consts::LN_2,
    0.240_226_47,
    0.055_503_286,
    0.009_618_489,
    0.001_339_993_1,
    0.000_153_458_12,
];

/// Largest -log2 F of a Gaussian that the kernels tell from zero: keeps products out of the
/// subnormal numbers, which are slow.
pub(in crate::likelihood) const GAUSSIAN_EXPONENT_MAX: f32 = 60.0;

/// atan(x)/2π = x (c0 + c1 x² + ...) on [0, 1], to 6e-9.
const ATAN_TURNS: [f32; 9] = [
    0.159_154_92,
    -0.053_050_477,
    0.031_808_56,
    -0.022_538_297,
    0.016_709_592,
    -0.011_514_635,
    0.006_331_38,
    -0.002_292_048_2,
    0.000_391_000_04,
];

/// c0 + c1 x + ... by Horner's rule, single precision.
#[inline(always)]
pub(in crate::likelihood) fn horner<const N: usize>(coefficients: &[f32; N], x: f32) -> f32 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Modulus of (re, im), to 2e-7 relative, and angle in turns, in [-1/2, 1/2], to 3e-8; 0 and 0 for
/// (0, 0). Without branches, so that loops over it vectorise.
#[inline(always)]
pub(super) fn polar(re: f32, im: f32) -> (f32, f64) {
    let (x, y) = (re.abs(), im.abs());
    let long = if y > x { y } else { x };
    let short = if y > x { x } else { y };
    // the smallest divisor keeps 0/0 away
    let ratio = short / (long + f32::MIN_POSITIVE);
    let square = ratio * ratio;
    let modulus = long * (1.0 + square).sqrt();
    let mut turns = (ratio * horner(&ATAN_TURNS, square)) as f64;
    turns = if y > x { 0.25 - turns } else { turns };
    turns = if re < 0.0 { 0.5 - turns } else { turns };
    (modulus, if im < 0.0 { -turns } else { turns })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, SQRT_2, TAU};

    /// Largest |approximation - truth| over 10 001 points of [a, b].
    fn worst(a: f64, b: f64, error: impl Fn(f64) -> f64) -> f64 {
        (0..=10_000)
            .map(|i| error(a + (b - a) * i as f64 / 10_000.0).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn sine_and_cosine_are_good_to_single_precision() {
        let sin = |x: f64| {
            let x32 = x as f32;
            (x32 * horner(&SQRT2_SIN_PI, x32 * x32)) as f64 - SQRT_2 * (PI * x32 as f64).sin()
        };
        assert!(worst(-0.5, 0.5, sin) < 2e-7);
        let cos = |x: f64| {
            let x32 = x as f32;
            horner(&SQRT2_COS_PI, x32 * x32) as f64 - SQRT_2 * (PI * x32 as f64).cos()
        };
        assert!(worst(-0.5, 0.5, cos) < 2.5e-7);
    }

    #[test]
    fn powers_of_two_are_good_to_single_precision() {
        let error = |x: f64| horner(&EXP2, x as f32) as f64 / (x as f32 as f64).exp2() - 1.0;
        assert!(worst(-0.5, 0.5, error) < 1.5e-7);
    }

    #[test]
    fn modulus_and_angle_agree_with_their_definition_all_around() {
        let at = |t: f64| {
            let (im, re) = (TAU * t).sin_cos();
            (3.0 * re as f32, 3.0 * im as f32)
        };
        let angle = |t: f64| {
            let (re, im) = at(t);
            polar(re, im).1 - (im as f64).atan2(re as f64) / TAU
        };
        let worst_angle = worst(-0.499, 0.499, angle);
        assert!(worst_angle < 3e-8, "{worst_angle:e}");
        let modulus = |t: f64| {
            let (re, im) = at(t);
            polar(re, im).0 as f64 / (re as f64).hypot(im as f64) - 1.0
        };
        assert!(worst(-0.5, 0.5, modulus) < 2e-7);
        assert_eq!(polar(0.0, 0.0), (0.0, 0.0));
        assert_eq!(polar(-1.0, 0.0), (1.0, 0.5));
    }

    #[test]
    fn the_magic_sum_holds_the_phase_in_fixed_point() {
        for phase in [
            0.0,
            0.25,
            -0.25,
            0.49,
            13_124.125,
            -TURNS_MAX,
            TURNS_MAX + 0.375,
        ] {
            let fixed = (PHASE_MAGIC + phase).to_bits() as u32 as i32;
            let turns = fixed as f64 / 4_294_967_296.0;
            assert!((turns - (phase - phase.round())).abs() < 2e-10, "{phase}");
        }
    }
}
