//! Axes of a source on the sky, as a catalogue gives them.

use super::{Ellipticity, Profile};

/// Widths and position angle of a source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// Full width at half maximum of the major axis [rad].
    pub major_rad: f64,
    /// Full width at half maximum of the minor axis [rad].
    pub minor_rad: f64,
    /// Position angle of the major axis, from north through east, in [0, 180) [deg].
    pub pa_deg: f64,
}

impl Axes {
    /// Axes of a source of scale-length `scale_rad` [rad] and ellipticity `e`.
    ///
    /// # Formula
    /// ```text
    /// major = f α/(1-|e|)   minor = f α/(1+|e|)   PA = 90° - atan2(e2, e1)/2
    /// ```
    /// with f from [`super::Shape::fwhm_per_scale`]. The angle of a circular source means nothing; it
    /// comes out as 90°.
    pub fn new(profile: Profile, scale_rad: f64, e: Ellipticity) -> Axes {
        let fwhm_rad = profile.shape().fwhm_per_scale() * scale_rad;
        let pa_deg = (90.0 - 0.5 * e.e2.atan2(e.e1).to_degrees()).rem_euclid(180.0);
        Axes {
            major_rad: fwhm_rad / (1.0 - e.modulus()),
            minor_rad: fwhm_rad / (1.0 + e.modulus()),
            // rem_euclid rounds tiny negative angles up to 180 itself
            pa_deg: if pa_deg < 180.0 { pa_deg } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pa_deg(e1: f64, e2: f64) -> f64 {
        Axes::new(Profile::Gaussian, 1.0, Ellipticity { e1, e2 }).pa_deg
    }

    #[test]
    fn widths_of_an_ellipse_of_modulus_a_half() {
        let e = Ellipticity { e1: 0.3, e2: 0.4 };
        let axes = Axes::new(Profile::Exponential, 2.0, e);
        assert!((axes.major_rad - 1.3862943611 * 4.0).abs() < 1e-9);
        assert!((axes.minor_rad - 1.3862943611 * 4.0 / 3.0).abs() < 1e-9);
        let axes = Axes::new(Profile::Gaussian, 2.0, e);
        assert!((axes.major_rad - 2.3548200450 * 4.0).abs() < 1e-9);
    }

    #[test]
    fn position_angles_go_from_north_through_east() {
        assert!((pa_deg(0.5, 0.0) - 90.0).abs() < 1e-12, "east to west");
        assert!(pa_deg(-0.5, 0.0).abs() < 1e-12, "north to south");
        assert!(
            (pa_deg(0.0, 0.5) - 45.0).abs() < 1e-12,
            "towards north-east"
        );
        assert!(
            (pa_deg(0.0, -0.5) - 135.0).abs() < 1e-12,
            "towards north-west"
        );
    }

    #[test]
    fn position_angles_stay_below_180_deg() {
        for e2 in [0.0, -0.0, 1e-300, -1e-300, 1e-17, -1e-17] {
            let pa = pa_deg(-0.5, e2);
            assert!((0.0..180.0).contains(&pa), "{pa}");
        }
    }
}
