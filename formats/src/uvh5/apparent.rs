//! Apparent places of phase centres, which UVH5 wants beside every row.
//!
//! # Source
//! Memo, section 3.1 (phase_center_app_ra, phase_center_app_dec, phase_center_frame_pa); IAU SOFA
//! routines atci13 and pas. Geocentric: diurnal aberration, 0.3 arcsec, is left out.

use std::collections::HashMap;

use sofars::astro::atci13;
use sofars::consts::DJM0;

use crate::Field;
use crate::date::{DEG_PER_DAY, gmst0_deg};

/// Terrestrial time is this far ahead of UTC [day]: 69 s since 2017. A minute moves no place by as
/// much as a milliarcsecond.
const TT_UTC_DAYS: f64 = 69.184 / 86_400.0;

/// Half the arc over which the position angle of the frame's north is taken [rad], as pyuvdata
/// takes it.
const ARC_RAD: f64 = std::f64::consts::PI / 360.0;
/// Places kept; more are computed again.
const MAX_KEPT: usize = 1 << 12;

/// An apparent place, referred to the equinox of date.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[allow(clippy::struct_field_names)] // Units end the name.
pub(super) struct Place {
    pub(super) ra_rad: f64,
    pub(super) dec_rad: f64,
    /// Position angle of the frame's north, from the apparent north through east.
    pub(super) frame_pa_rad: f64,
}

/// Apparent places that were asked for: rows of the same time share theirs.
#[derive(Debug, Default)]
pub(super) struct Places {
    kept: HashMap<(u32, u64), Place>,
    /// Longitude and latitude of the array [rad].
    array_rad: [f64; 2],
}

impl Places {
    /// For an array at that longitude and latitude [deg].
    pub(super) fn new(longitude_deg: f64, latitude_deg: f64) -> Self {
        Self {
            array_rad: [longitude_deg.to_radians(), latitude_deg.to_radians()],
            ..Self::default()
        }
    }

    /// The place of `field`, whose number is `index`, at a time.
    pub(super) fn at(&mut self, index: u32, field: &Field, mjd: f64) -> Place {
        let key = (index, mjd.to_bits());
        if let Some(place) = self.kept.get(&key) {
            return *place;
        }
        let place = if field.drifts {
            self.zenith(mjd)
        } else {
            place(field, mjd)
        };
        if self.kept.len() >= MAX_KEPT {
            self.kept.clear();
        }
        self.kept.insert(key, place);
        place
    }
}

impl Places {
    /// The zenith, which is what data that are not phased refer to.
    fn zenith(&self, mjd: f64) -> Place {
        let gmst_deg = gmst0_deg(mjd) + mjd.fract() * DEG_PER_DAY;
        let [longitude_rad, latitude_rad] = self.array_rad;
        Place {
            ra_rad: (gmst_deg.to_radians() + longitude_rad).rem_euclid(std::f64::consts::TAU),
            dec_rad: latitude_rad,
            frame_pa_rad: 0.0,
        }
    }
}

fn place(field: &Field, mjd: f64) -> Place {
    let apparent = |dec_rad: f64| {
        let (ra_rad, dec_rad) = field.frame.to_icrs(field.ra_rad, dec_rad);
        let (cirs_ra_rad, dec_rad, origins_rad) =
            atci13(ra_rad, dec_rad, 0.0, 0.0, 0.0, 0.0, DJM0, mjd + TT_UTC_DAYS);
        let ra_rad = (cirs_ra_rad - origins_rad).rem_euclid(std::f64::consts::TAU);
        (ra_rad, dec_rad)
    };
    let (ra_rad, dec_rad) = apparent(field.dec_rad);
    let (south, north) = (
        apparent(field.dec_rad - ARC_RAD),
        apparent(field.dec_rad + ARC_RAD),
    );
    Place {
        ra_rad,
        dec_rad,
        frame_pa_rad: position_angle_rad(south, north),
    }
}

/// Direction of `to` as seen from `from`, from north through east (SOFA `pas`).
fn position_angle_rad(from: (f64, f64), to: (f64, f64)) -> f64 {
    let (sin_ra, cos_ra) = (to.0 - from.0).sin_cos();
    let y = sin_ra * to.1.cos();
    let x = to.1.sin() * from.1.cos() - to.1.cos() * from.1.sin() * cos_ra;
    y.atan2(x)
}
