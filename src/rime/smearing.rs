//! Time and bandwidth smearing: a sample is a mean over a channel and an integration, over which the
//! phase of a source away from the phase centre turns.
//!
//! # Formula
//! With φ the phase at the middle of the sample [turn] and b = (u, v, w) [wavelength],
//!
//! ```text
//! <exp 2πiφ> = exp(2πiφ) sinc(φ Δν/ν) sinc(dφ/dt τ)      sinc x = sin(πx)/(πx)
//! φ = b·s      dφ/dt = Ω b·(s × p)      s = (l, m, n-1)
//! ```
//!
//! The phase grows with the frequency at fixed delay φ/ν. The baseline is turned by the Earth about the
//! celestial pole p, given in the axes of (u, v, w): db/dt = Ω p × b.
//!
//! # Not valid when
//! The phase is far from linear over the sample: with minutes of time or channels as wide as the
//! frequency. The change of shape F over the sample, of second order, is left out.
//!
//! # Source
//! Thompson, Moran & Swenson (3rd ed., 2017), sections 6.3 and 6.4; Bridle & Schwab (1999), ASP Conf. 180, 371.

use crate::coords::Lm;
use crate::units::ARCSEC;
use std::f64::consts::PI;

/// Rotation of the Earth in inertial space [rad/s] (IERS Conventions 2010, table 1.2).
pub const EARTH_RAD_PER_S: f64 = 7.292_115e-5;

/// sin(πx)/(πx).
pub fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-8 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}

/// The celestial pole at the epoch `year` (Julian), unit vector in ICRS: precession only, to 20
/// arcsec for a century.
///
/// # Source
/// IERS Conventions (2010), equation 5.16.
pub fn pole_of(year: f64) -> [f64; 3] {
    let t = (year - 2000.0) / 100.0;
    let x = (2_004.191_898 * t - 0.429_783 * t * t) * ARCSEC;
    let y = (-0.025_896 * t - 22.407_275 * t * t) * ARCSEC;
    [x, y, (1.0 - x * x - y * y).sqrt()]
}

/// How phases turn over the samples of an observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smearing {
    /// The celestial pole of date in the axes of (u, v, w).
    pub pole: [f64; 3],
}

impl Smearing {
    /// s = (l, m, n-1): the phase of `lm` in turns for each wavelength of baseline.
    pub fn turns(lm: Lm) -> [f64; 3] {
        [lm.l, lm.m, lm.n_minus_1()]
    }

    /// Ω s × p: how fast the phase of `lm` turns [turn/s] for each wavelength of baseline.
    pub fn turns_per_s(&self, lm: Lm) -> [f64; 3] {
        let ([a, b, c], [x, y, z]) = (Self::turns(lm), self.pole);
        [b * z - c * y, c * x - a * z, a * y - b * x].map(|turns| EARTH_RAD_PER_S * turns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coords::RaDec;
    use crate::simulate::{Orientation, Pointing, Site, UvwFrame};
    use crate::units::{DEG, SPEED_OF_LIGHT};

    #[test]
    fn the_pole_is_that_of_sofa() {
        for year in [1980.0, 2020.0, 2050.0] {
            let (x, y, _) = sofars::pnp::xys06a(2_451_545.0, (year - 2000.0) * 365.25);
            let pole = pole_of(year);
            let off = (pole[0] - x).hypot(pole[1] - y) / ARCSEC;
            assert!(off < 20.0, "{year}: {off}");
        }
    }

    /// Rates against (u, v, w) a second apart, with precession, nutation and aberration.
    #[test]
    fn phases_turn_as_the_earth_does() {
        let centre = RaDec {
            ra_rad: 53.1 * DEG,
            dec_rad: -30.0 * DEG,
        };
        let site = Site::from_itrf([5_109_360.0, 2_006_852.0, -3_238_948.0]).unwrap();
        let baseline_m = [-3000.0, 5000.0, -2500.0];
        let frame = crate::coords::IcrsCentre::new(centre, vis2cat_formats::Frame::Icrs);
        let smearing = Smearing {
            pole: frame.from_icrs(pole_of(2020.0)),
        };
        let lm = Lm {
            l: 0.008,
            m: -0.009,
        };
        let mjd = 58_849.3;
        let uvw = |mjd: f64| {
            let orientation = Orientation::default();
            let pointing = Pointing::at(centre, site, mjd, orientation).unwrap();
            UvwFrame::new(&pointing)
                .apply(baseline_m)
                .map(|metres| metres * 1.28e9 / SPEED_OF_LIGHT)
        };
        let dot = |b: [f64; 3], s: [f64; 3]| b[0] * s[0] + b[1] * s[1] + b[2] * s[2];
        let phase = |mjd| dot(uvw(mjd), Smearing::turns(lm));
        let step = 10.0 / 86400.0;
        let expected = (phase(mjd + step) - phase(mjd - step)) / 20.0;
        let rate = dot(uvw(mjd), smearing.turns_per_s(lm));
        assert!((rate / expected - 1.0).abs() < 3e-4, "{rate} {expected}");
        // Of a pole that has not precessed this would be ten times as much.
        let old = Smearing {
            pole: frame.from_icrs([0.0, 0.0, 1.0]),
        };
        assert!((dot(uvw(mjd), old.turns_per_s(lm)) / expected - 1.0).abs() > 5e-4);
    }
}
