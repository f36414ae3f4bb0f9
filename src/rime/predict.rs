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
/// V = S F(u', v') exp(+2πi φ)      φ = u l + v m + w (n-1)      u' = u - w l/n   v' = v - w m/n
/// ```
///
/// # Departure
/// Malyali et al. (2018) write F(u, v). Over a source away from the phase centre w turns the phase as
/// well, so that its shape is seen with (u', v'); the two differ by 1% half a degree away.
pub fn predict(source: &Source, profile: Profile, u: f64, v: f64, w: f64) -> Complex<f64> {
    let [u_seen, v_seen] = source.lm.uv_seen(u, v, w);
    let q = QuadraticForm::new(source.scale_rad, source.e).at(u_seen, v_seen);
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
    use crate::rime::shape::Ellipticity;

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

    /// A disk far from the phase centre as many points on the sky.
    #[test]
    fn a_disk_is_the_sum_of_its_points() {
        let disk = Source {
            lm: Lm { l: 0.04, m: -0.02 },
            flux_jy: 1.0,
            scale_rad: 1e-5,
            e: Ellipticity { e1: 0.3, e2: -0.2 },
            ..Source::default()
        };
        let (u, v, w) = (9e3, 4e3, -2.5e4);
        let (mut sum, mut flux_jy) = (Complex::default(), 0.0);
        for i in -200..=200 {
            for j in -200..=200 {
                let (dl, dm) = (f64::from(i) * 1e-6, f64::from(j) * 1e-6);
                let x = (1.0 - disk.e.e1) * dl - disk.e.e2 * dm;
                let y = -disk.e.e2 * dl + (1.0 + disk.e.e1) * dm;
                let point = Source {
                    lm: Lm {
                        l: disk.lm.l + dl,
                        m: disk.lm.m + dm,
                    },
                    flux_jy: (-x.hypot(y) / disk.scale_rad).exp(),
                    ..Source::default()
                };
                sum += predict(&point, Profile::Point, u, v, w);
                flux_jy += point.flux_jy;
            }
        }
        let vis = predict(&disk, Profile::Exponential, u, v, w);
        let off = (sum / flux_jy - vis).norm();
        assert!(off < 2e-4, "{off}");
        let flat = predict(&disk, Profile::Exponential, u, v, 0.0).norm();
        assert!((flat - vis.norm()).abs() > 1e-2, "no test of w");
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
