//! Source shapes: the factor F(u, v) of a source of unit flux density.
//!
//! A shape is a radial [`Profile`] of the elliptical radius squared
//!
//! ```text
//! q = α² (k1² + k2²)      k1 = ((1+e1) u + e2 v)/det     k2 = (e2 u + (1-e1) v)/det
//!                         det = 1 - e1² - e2²
//! ```
//!
//! which is a [`QuadraticForm`] in (u, v), worked out once a source. On the sky the scale-lengths
//! of the axes are α/(1-|e|) and α/(1+|e|).

mod form;

pub use form::QuadraticForm;

use std::f64::consts::{LN_2, PI};

/// Ellipticity (e1, e2), |e| = (a - b)/(a + b); the major axis lies at atan2(e2, e1)/2 from l
/// (east) towards m (north).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ellipticity {
    /// Stretch along l (positive) or m (negative).
    pub e1: f64,
    /// Stretch along the diagonals.
    pub e2: f64,
}

impl Ellipticity {
    /// |e| = sqrt(e1² + e2²).
    pub fn modulus(self) -> f64 {
        self.e1.hypot(self.e2)
    }
}

/// A radial profile of unit flux density.
///
/// | function | meaning |
/// |---|---|
/// | `factor` | F at q = α²(k1² + k2²); 1 at q = 0, so that the flux density is the total one |
/// | `fwhm_per_scale` | full width at half maximum on the sky in units of α |
///
/// # Source
/// Malyali et al. (2018), section 2; Rivi & Miller (2018), equation 5.
pub trait Shape: std::fmt::Debug + Sync {
    /// F at elliptical radius squared `q`.
    fn factor(&self, q: f64) -> f64;

    /// Full width at half maximum of the brightness over the scale-length α.
    fn fwhm_per_scale(&self) -> f64;
}

/// Exponential (Sersic n = 1) disk, brightness exp(-r/α)/(2πα²): F = (1 + 4π² q)^(-3/2).
#[derive(Debug, Clone, Copy)]
pub struct Exponential;

/// Gaussian, brightness exp(-r²/2α²)/(2πα²): F = exp(-2π² q).
#[derive(Debug, Clone, Copy)]
pub struct Gaussian;

/// Point: F = 1.
#[derive(Debug, Clone, Copy)]
pub struct Point;

impl Shape for Exponential {
    fn factor(&self, q: f64) -> f64 {
        let t = 1.0 + 4.0 * PI * PI * q;
        1.0 / (t * t.sqrt())
    }

    fn fwhm_per_scale(&self) -> f64 {
        2.0 * LN_2
    }
}

impl Shape for Gaussian {
    fn factor(&self, q: f64) -> f64 {
        (-2.0 * PI * PI * q).exp()
    }

    fn fwhm_per_scale(&self) -> f64 {
        (8.0 * LN_2).sqrt()
    }
}

impl Shape for Point {
    fn factor(&self, _q: f64) -> f64 {
        1.0
    }

    fn fwhm_per_scale(&self) -> f64 {
        0.0
    }
}

/// The shapes that a user can choose; the kernels choose their inner loop by it, once a source.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// [`Exponential`], α the scale-length.
    #[default]
    Exponential,
    /// [`Gaussian`], α the standard deviation.
    Gaussian,
    /// [`Point`].
    Point,
}

impl Profile {
    /// The shape of that name.
    pub fn shape(self) -> &'static dyn Shape {
        match self {
            Self::Exponential => &Exponential,
            Self::Gaussian => &Gaussian,
            Self::Point => &Point,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_have_their_values_at_known_radii() {
        let q = 1.0 / (4.0 * PI * PI);
        assert!((Exponential.factor(3.0 * q) - 0.125).abs() < 1e-15);
        assert!((Gaussian.factor(2.0 * q) - (-1.0f64).exp()).abs() < 1e-15);
        assert_eq!(Point.factor(3.0), 1.0);
        for profile in [Profile::Exponential, Profile::Gaussian, Profile::Point] {
            assert_eq!(profile.shape().factor(0.0), 1.0);
        }
    }

    /// F by summing the brightness over a fine grid on the sky.
    fn factor_by_sky_sum(profile: Profile, e: Ellipticity, u: f64, v: f64) -> f64 {
        let (step, half) = (0.05, 600);
        let (mut sum, mut total) = (0.0, 0.0);
        for i in -half..=half {
            for j in -half..=half {
                let (l, m) = (i as f64 * step, j as f64 * step);
                let x = (1.0 - e.e1) * l - e.e2 * m;
                let y = -e.e2 * l + (1.0 + e.e1) * m;
                let brightness = match profile {
                    Profile::Exponential => (-x.hypot(y)).exp(),
                    _ => (-0.5 * (x * x + y * y)).exp(),
                };
                sum += brightness * (2.0 * PI * (u * l + v * m)).cos();
                total += brightness;
            }
        }
        sum / total
    }

    #[test]
    fn elliptical_factors_are_the_transform_of_the_sky() {
        let e = Ellipticity { e1: 0.3, e2: -0.2 };
        let form = QuadraticForm::new(1.0, e);
        for profile in [Profile::Exponential, Profile::Gaussian] {
            for (u, v) in [(0.1, 0.0), (0.0, 0.1), (0.07, -0.11), (0.07, 0.11)] {
                let expected = factor_by_sky_sum(profile, e, u, v);
                let factor = profile.shape().factor(form.at(u, v));
                assert!(
                    (factor - expected).abs() < 2e-3,
                    "{profile:?} at ({u}, {v}): {factor}, {expected}"
                );
            }
        }
    }

    #[test]
    fn widths_halve_the_profile() {
        let half = 0.5 * Exponential.fwhm_per_scale();
        assert!(((-half).exp() - 0.5).abs() < 1e-15);
        let half = 0.5 * Gaussian.fwhm_per_scale();
        assert!(((-0.5 * half * half).exp() - 0.5).abs() < 1e-15);
    }
}
