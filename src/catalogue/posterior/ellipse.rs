//! A source's shape as axes and position angle.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::rime::shape::{Ellipticity, Profile};

/// Full axes at half maximum, and the position angle of the major one.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ellipse {
    /// Major axis [rad].
    pub maj_rad: f64,
    /// Minor axis [rad].
    pub min_rad: f64,
    /// North through east [rad] in [0, π); NaN for a circle.
    pub pa_rad: f64,
}

impl Ellipse {
    /// The ellipse of scale-length `scale_rad`, whose axes have scale-lengths α/(1 ∓ |e|), and whose
    /// major axis lies at atan2(e2, e1)/2 from east towards north.
    pub fn new(scale_rad: f64, e: Ellipticity, profile: Profile) -> Self {
        let fwhm_rad = profile.shape().fwhm_per_scale() * scale_rad;
        let size = e.e1.hypot(e.e2);
        let pa_rad = if size == 0.0 || fwhm_rad == 0.0 {
            f64::NAN
        } else {
            half_turn(FRAC_PI_2 - 0.5 * e.e2.atan2(e.e1))
        };
        Self {
            maj_rad: fwhm_rad / (1.0 - size),
            min_rad: fwhm_rad / (1.0 + size),
            pa_rad,
        }
    }
}

/// `angle` of an axis, in [0, π).
pub(super) fn half_turn(angle: f64) -> f64 {
    let angle = angle.rem_euclid(PI);
    if angle < PI { angle } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::DEG;

    #[test]
    fn axes_follow_from_the_ellipticity() {
        let e = Ellipticity { e1: -0.2, e2: 0.0 };
        let ellipse = Ellipse::new(1.0, e, Profile::Exponential);
        assert!((ellipse.maj_rad - 1.386_294_361 / 0.8).abs() < 1e-9);
        assert!((ellipse.min_rad - 1.386_294_361 / 1.2).abs() < 1e-9);
        // The harmonic mean of the axes is that of the circle, and |e| = (a - b)/(a + b).
        let (a, b) = (ellipse.maj_rad, ellipse.min_rad);
        assert!(((a - b) / (a + b) - 0.2).abs() < 1e-12);
    }

    #[test]
    fn the_position_angle_turns_from_north_through_east() {
        let pa = |e1, e2| Ellipse::new(1.0, Ellipticity { e1, e2 }, Profile::Gaussian).pa_rad / DEG;
        assert!((pa(0.3, 0.0) - 90.0).abs() < 1e-9); // along l: east
        assert!(pa(-0.3, 0.0).abs() < 1e-9); // along m: north
        assert!((pa(0.0, 0.3) - 45.0).abs() < 1e-9); // north-east
        assert!((pa(0.0, -0.3) - 135.0).abs() < 1e-9);
        assert!(pa(0.0, 0.0).is_nan());
    }

    #[test]
    fn a_point_has_no_size() {
        let point = Ellipse::new(1.0, Ellipticity { e1: 0.1, e2: 0.0 }, Profile::Point);
        assert!(point.maj_rad == 0.0 && point.min_rad == 0.0 && point.pa_rad.is_nan());
    }
}
