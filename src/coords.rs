//! Directions on the sky and their direction cosines about a phase centre.

mod frame;

pub use frame::IcrsCentre;

/// A direction: right ascension and declination [rad] in the frame of the phase centre.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RaDec {
    /// Right ascension [rad].
    pub ra_rad: f64,
    /// Declination [rad].
    pub dec_rad: f64,
}

/// Direction cosines about a phase centre: l east, m north.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Lm {
    /// Towards east.
    pub l: f64,
    /// Towards north.
    pub m: f64,
}

impl Lm {
    /// `n - 1` with n = sqrt(1 - l² - m²), without cancellation near the phase centre.
    pub fn n_minus_1(self) -> f64 {
        let r2 = self.l * self.l + self.m * self.m;
        -r2 / (1.0 + (1.0 - r2).max(0.0).sqrt())
    }

    /// (l/n, m/n): what w takes off u and v as seen from this direction.
    pub fn slopes(self) -> [f64; 2] {
        let n = 1.0 + self.n_minus_1();
        [self.l / n, self.m / n]
    }

    /// The baseline (u, v, w) as a source in this direction sees it, (u - w l/n, v - w m/n): how fast
    /// the phase u l + v m + w (n - 1) changes with l and m there.
    pub fn uv_seen(self, u: f64, v: f64, w: f64) -> [f64; 2] {
        let [slope_u, slope_v] = self.slopes();
        [u - w * slope_u, v - w * slope_v]
    }

    /// Distance in the (l, m) plane.
    pub fn distance(self, other: Lm) -> f64 {
        (self.l - other.l).hypot(self.m - other.m)
    }
}

impl RaDec {
    /// The unit vector towards it: x to RA 0, z to the north pole.
    pub fn unit_vector(self) -> [f64; 3] {
        let (sin_ra, cos_ra) = self.ra_rad.sin_cos();
        let (sin_dec, cos_dec) = self.dec_rad.sin_cos();
        [cos_dec * cos_ra, cos_dec * sin_ra, sin_dec]
    }

    /// Angle between two directions [rad], precise at any distance.
    ///
    /// # Source
    /// Vincenty 1975, Survey Review 23, 88, on a sphere.
    pub fn separation_rad(self, other: RaDec) -> f64 {
        let (sin_ra, cos_ra) = (other.ra_rad - self.ra_rad).sin_cos();
        let (sin_1, cos_1) = self.dec_rad.sin_cos();
        let (sin_2, cos_2) = other.dec_rad.sin_cos();
        let east = cos_2 * sin_ra;
        let north = cos_1 * sin_2 - sin_1 * cos_2 * cos_ra;
        let along = sin_1 * sin_2 + cos_1 * cos_2 * cos_ra;
        east.hypot(north).atan2(along)
    }

    /// Direction cosines of `self` about `centre` (orthographic projection).
    pub fn to_lm(self, centre: RaDec) -> Lm {
        let d_ra = self.ra_rad - centre.ra_rad;
        let cos_dec = self.dec_rad.cos();
        let half = (0.5 * d_ra).sin();
        Lm {
            l: cos_dec * d_ra.sin(),
            // sin(d) cos(d0) - cos(d) sin(d0) cos(da), written so that small offsets keep their digits
            m: (self.dec_rad - centre.dec_rad).sin()
                + 2.0 * centre.dec_rad.sin() * cos_dec * half * half,
        }
    }

    /// The direction whose cosines about `centre` are `lm`; RA in [0, 2π).
    pub fn from_lm(lm: Lm, centre: RaDec) -> RaDec {
        let n = 1.0 + lm.n_minus_1();
        let (sin_dec0, cos_dec0) = centre.dec_rad.sin_cos();
        let z = lm.m * cos_dec0 + n * sin_dec0;
        let y = n * cos_dec0 - lm.m * sin_dec0;
        let ra = centre.ra_rad + lm.l.atan2(y);
        RaDec {
            ra_rad: ra.rem_euclid(std::f64::consts::TAU),
            dec_rad: z.atan2(lm.l.hypot(y)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{ARCSEC, DEG};

    #[test]
    fn lm_and_back_is_exact_to_a_microarcsecond() {
        let centre = RaDec {
            ra_rad: 359.99 * DEG,
            dec_rad: -30.0 * DEG,
        };
        for (l, m) in [(0.0, 0.0), (1e-5, -2e-6), (0.01, 0.02), (-0.3, 0.1)] {
            let back = RaDec::from_lm(Lm { l, m }, centre).to_lm(centre);
            assert!((back.l - l).abs() < 1e-6 * ARCSEC && (back.m - m).abs() < 1e-6 * ARCSEC);
        }
    }

    #[test]
    fn separations_are_those_of_a_sphere() {
        let at = |ra: f64, dec: f64| RaDec {
            ra_rad: ra * DEG,
            dec_rad: dec * DEG,
        };
        for (a, b, deg) in [
            (at(10.0, 20.0), at(10.0, 20.0), 0.0),
            (at(10.0, 20.0), at(10.0, -25.0), 45.0),
            (at(0.0, 0.0), at(90.0, 0.0), 90.0),
            (at(0.0, 0.0), at(180.0, 0.0), 180.0),
            (at(30.0, 89.0), at(210.0, 89.0), 2.0),
            // cos d = sin² 60 + cos² 60 cos 60 = 7/8
            (at(0.0, 60.0), at(60.0, 60.0), 0.875_f64.acos() / DEG),
            // Across 0 h; 0.01 arcsec in RA at 60 deg is half of that on the sky.
            (at(359.999_999, 0.0), at(0.000_001, 0.0), 2e-6),
            (at(0.0, 60.0), at(0.01 / 3600.0, 60.0), 0.005 / 3600.0),
        ] {
            let error = a.separation_rad(b) / DEG - deg;
            assert!(error.abs() < 1e-13 + 1e-12 * deg, "{a:?} {b:?}: {error}");
            let chord = a.unit_vector().into_iter().zip(b.unit_vector());
            let chord: f64 = chord.map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
            assert!((chord - 2.0 * (0.5 * deg * DEG).sin()).abs() < 1e-15);
        }
    }

    #[test]
    fn east_is_positive_l_and_north_positive_m() {
        let centre = RaDec {
            ra_rad: 1.0,
            dec_rad: 0.5,
        };
        let lm = RaDec {
            ra_rad: 1.001,
            dec_rad: 0.501,
        }
        .to_lm(centre);
        assert!(lm.l > 0.0 && lm.m > 0.0);
    }
}
