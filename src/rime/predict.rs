//! The visibility of one source.

use super::Source;
use super::shape::{Profile, QuadraticForm};
use num_complex::Complex;
use std::f64::consts::TAU;

/// Phase of `source` in turns, φ = u l + v m + w (n-1), for (u, v, w) in wavelengths.
pub fn phase_turns(source: &Source, u: f64, v: f64, w: f64) -> f64 {
    u * source.lm.l + v * source.lm.m + w * source.lm.n_minus_1()
}

/// Visibility of `source` [Jy] on the baseline (u, v, w) [wavelength], all in f64.
///
/// # Formula
/// ```text
/// V = S F(u, v) exp(+2πi φ)      φ = u l + v m + w (n-1)
/// ```
pub fn predict(source: &Source, profile: Profile, u: f64, v: f64, w: f64) -> Complex<f64> {
    let q = QuadraticForm::new(source.scale_rad, source.e).at(u, v);
    let phase = phase_turns(source, u, v, w);
    Complex::from_polar(
        source.flux_jy * profile.shape().factor(q),
        TAU * (phase - phase.round()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coords::Lm;

    #[test]
    fn a_point_a_quarter_turn_away_is_imaginary() {
        let source = Source {
            lm: Lm { l: 0.25, m: 0.0 },
            flux_jy: 2.0,
            ..Source::default()
        };
        let vis = predict(&source, Profile::Point, 1.0, 5.0, 0.0);
        assert!((vis - Complex::new(0.0, 2.0)).norm() < 1e-15);
    }

    #[test]
    fn the_w_term_turns_backwards() {
        let source = Source {
            lm: Lm { l: 0.6, m: 0.0 },
            flux_jy: 1.0,
            ..Source::default()
        };
        // n - 1 = -0.2, so that w = 1.25 gives -1/4 turn
        let vis = predict(&source, Profile::Point, 0.0, 0.0, 1.25);
        assert!((vis - Complex::new(0.0, -1.0)).norm() < 1e-14);
    }

    #[test]
    fn the_shape_attenuates_the_amplitude() {
        let source = Source {
            flux_jy: 3.0,
            scale_rad: 1.0 / TAU,
            ..Source::default()
        };
        let vis = predict(&source, Profile::Exponential, 0.0, 3f64.sqrt(), 0.0);
        assert!((vis - Complex::new(3.0 / 8.0, 0.0)).norm() < 1e-14);
    }
}
