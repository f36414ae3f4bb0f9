//! Where an ICRS direction stands in the sky of an array at a given time.

use sofars::astro::{atco13, atoc13};
use sofars::consts::DJM0;
use sofars::coords::gc2gd;
use sofars::erst::gst06a;
use sofars::pnp::sp00;
use sofars::ts::{taitt, utctai, utcut1};

use super::{Orientation, SimulateError};
use crate::coords::RaDec;
use crate::units::DEG;

/// Half the arc over which the position angle of the celestial frame is taken [rad].
const ARC_RAD: f64 = 0.5 * DEG;
/// SOFA's number of the reference ellipsoid WGS84.
const WGS84: i32 = 1;

/// Reference position of an array on the ellipsoid.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Site {
    /// Longitude, east positive [rad].
    pub lon_rad: f64,
    /// Geodetic latitude [rad].
    pub lat_rad: f64,
    /// Height above the ellipsoid [m].
    pub height_m: f64,
}

impl Site {
    /// The site at geocentric ITRF position `itrf_m` (SOFA `gc2gd`).
    ///
    /// # Errors
    /// The position has no place on the ellipsoid.
    pub fn from_itrf(itrf_m: [f64; 3]) -> Result<Self, SimulateError> {
        let (lon_rad, lat_rad, height_m) = gc2gd(WGS84, itrf_m).map_err(|_| {
            SimulateError::parameter(format!("no place on the Earth is at {itrf_m:?} m"))
        })?;
        Ok(Self {
            lon_rad,
            lat_rad,
            height_m,
        })
    }
}

/// Apparent direction of the phase centre at one time.
///
/// As pyuvdata defines it: apparent place of the ICRS direction for an observer at the site
/// (bias, precession, nutation IAU 2006/2000A, light deflection, annual and diurnal aberration, polar
/// motion; no refraction), referred to the equinox, and the position angle that brings v back to the
/// ICRS north.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pointing {
    /// Apparent hour angle at Greenwich [rad].
    pub gha_rad: f64,
    /// Apparent declination [rad].
    pub dec_rad: f64,
    /// Position angle of the apparent frame in the ICRS frame [rad].
    pub frame_pa_rad: f64,
    /// Elevation above the horizon [rad].
    pub elevation_rad: f64,
}

impl Pointing {
    /// The pointing at `centre` (ICRS) from `site` at `mjd` [day, UTC].
    ///
    /// # Errors
    /// The date is beyond what SOFA takes.
    ///
    /// # Source
    /// SOFA routines `atco13`, `atoc13`, `gst06a`, `sp00`.
    pub fn at(
        centre: RaDec,
        site: Site,
        mjd: f64,
        earth: Orientation,
    ) -> Result<Self, SimulateError> {
        compute(centre, site, mjd, earth).map_err(|_| {
            SimulateError::parameter(format!("no apparent place can be computed for MJD {mjd}"))
        })
    }
}

/// Greenwich apparent sidereal time at `mjd` [rad] (SOFA `gst06a`).
///
/// # Errors
/// The date is beyond what SOFA takes.
pub(super) fn gast_rad(mjd: f64, earth: Orientation) -> Result<f64, SimulateError> {
    sidereal(mjd, earth)
        .map(|(gast_rad, _)| gast_rad)
        .map_err(|_| SimulateError::parameter(format!("no sidereal time for MJD {mjd}")))
}

fn compute(centre: RaDec, site: Site, mjd: f64, earth: Orientation) -> Result<Pointing, i32> {
    let [x_pole, y_pole] = earth.pole_rad;
    let (_, zenith_distance_rad, _, dec_rad, cio_ra_rad, origins_rad) = atco13(
        centre.ra_rad,
        centre.dec_rad,
        0.0,
        0.0,
        0.0,
        0.0,
        DJM0,
        mjd,
        earth.ut1_utc_s,
        site.lon_rad,
        site.lat_rad,
        site.height_m,
        x_pole,
        y_pole,
        0.0,
        0.0,
        0.0,
        0.0,
    )?;
    // the right ascension counts from the celestial intermediate origin; from the equinox it is
    // smaller by the equation of the origins
    let ra_rad = cio_ra_rad - origins_rad;
    let (gast_rad, tio_rad) = sidereal(mjd, earth)?;
    let to_icrs = |dec_rad: f64| observed_to_icrs(cio_ra_rad, dec_rad, site, mjd, earth);
    let south = to_icrs(dec_rad - ARC_RAD)?;
    let north = to_icrs(dec_rad + ARC_RAD)?;
    Ok(Pointing {
        gha_rad: gast_rad + tio_rad - ra_rad,
        dec_rad,
        frame_pa_rad: -position_angle_rad(south, north),
        elevation_rad: std::f64::consts::FRAC_PI_2 - zenith_distance_rad,
    })
}

/// Greenwich apparent sidereal time and the place of the terrestrial origin s' [rad].
fn sidereal(mjd: f64, earth: Orientation) -> Result<(f64, f64), i32> {
    let (tai1, tai2) = utctai(DJM0, mjd)?;
    let (tt1, tt2) = taitt(tai1, tai2)?;
    let (ut1, ut2) = utcut1(DJM0, mjd, earth.ut1_utc_s)?;
    Ok((gst06a(ut1, ut2, tt1, tt2), sp00(tt1, tt2)))
}

/// The ICRS direction of an apparent one; a declination beyond the pole comes down on the other side.
fn observed_to_icrs(
    cio_ra_rad: f64,
    dec_rad: f64,
    site: Site,
    mjd: f64,
    earth: Orientation,
) -> Result<RaDec, i32> {
    let over_pole = dec_rad.abs() > std::f64::consts::FRAC_PI_2;
    let (ra_rad, dec_rad) = if over_pole {
        let pi = std::f64::consts::PI;
        (cio_ra_rad + pi, pi.copysign(dec_rad) - dec_rad)
    } else {
        (cio_ra_rad, dec_rad)
    };
    let [x_pole, y_pole] = earth.pole_rad;
    let (ra_rad, dec_rad) = atoc13(
        "r",
        ra_rad,
        dec_rad,
        DJM0,
        mjd,
        earth.ut1_utc_s,
        site.lon_rad,
        site.lat_rad,
        site.height_m,
        x_pole,
        y_pole,
        0.0,
        0.0,
        0.0,
        0.0,
    )?;
    Ok(RaDec { ra_rad, dec_rad })
}

/// Position angle of `to` seen from `from`, north through east [rad] (SOFA `pas`).
fn position_angle_rad(from: RaDec, to: RaDec) -> f64 {
    let (sin_ra, cos_ra) = (to.ra_rad - from.ra_rad).sin_cos();
    let (sin_from, cos_from) = from.dec_rad.sin_cos();
    let (sin_to, cos_to) = to.dec_rad.sin_cos();
    (sin_ra * cos_to).atan2(sin_to * cos_from - cos_to * sin_from * cos_ra)
}
