//! Celestial frames of old files, turned to ICRS.

use sofars::pnp::prec76;
use sofars::star::{fk5hz, fk45z};

use crate::Frame;

const J2000: f64 = 2_451_545.0;
const JULIAN_YEAR_DAYS: f64 = 365.25;

impl Frame {
    /// ICRS right ascension and declination [rad] of a direction in this frame [rad].
    ///
    /// # Source
    /// IAU SOFA routines prec76, fk45z and fk5hz.
    pub fn to_icrs(self, ra_rad: f64, dec_rad: f64) -> (f64, f64) {
        let (ra_rad, dec_rad) = match self {
            Self::Icrs => return (ra_rad, dec_rad),
            Self::Fk5(equinox) => precess_to_j2000(ra_rad, dec_rad, equinox),
            Self::Fk4(equinox) => fk45z(ra_rad, dec_rad, equinox),
        };
        fk5hz(ra_rad, dec_rad, J2000, 0.0)
    }
}

/// Precession from `equinox` to J2000 by the IAU 1976 angles.
fn precess_to_j2000(ra_rad: f64, dec_rad: f64, equinox: f64) -> (f64, f64) {
    let days = (equinox - 2000.0) * JULIAN_YEAR_DAYS;
    let (zeta, z, theta) = prec76(J2000, days, J2000, 0.0);
    let (sin_dec, cos_dec) = dec_rad.sin_cos();
    let (sin_ra, cos_ra) = (ra_rad + zeta).sin_cos();
    let (sin_theta, cos_theta) = theta.sin_cos();
    let x = cos_theta * cos_dec * cos_ra - sin_theta * sin_dec;
    let y = cos_dec * sin_ra;
    let sin_new = sin_theta * cos_dec * cos_ra + cos_theta * sin_dec;
    (
        (y.atan2(x) + z).rem_euclid(std::f64::consts::TAU),
        sin_new.atan2(x.hypot(y)),
    )
}
