//! What goes into the file beside the rows.

use vis2cat_formats::{Antenna, EarthOrientation, Field, Frame, FreqSetup, Observation, TimeScale};

use super::pointing::gast_rad;
use super::{Dish, Orientation, SimulateConfig, SimulateError, format_utc};
use crate::units::{ARCSEC, DEG};

/// The observation of `config` from `start_mjd` on, of `n_row` rows.
///
/// The array's reference position is the mean of its antennas', whose own positions are absolute.
pub(super) fn describe(
    config: &SimulateConfig,
    start_mjd: f64,
    earth: EarthOrientation,
    n_row: u64,
) -> Observation {
    let date_obs = format_utc(start_mjd.floor());
    Observation {
        telescope: config.array.name.clone(),
        instrument: config.array.name.clone(),
        observer: "vis2cat".to_owned(),
        date_obs: date_obs.split('T').next().unwrap_or_default().to_owned(),
        array_position_m: config.array.centre_m(),
        antennas: config.array.dishes.iter().zip(1..).map(antenna).collect(),
        fields: vec![Field {
            name: config.field_name.clone(),
            ra_rad: config.centre.ra_rad,
            dec_rad: config.centre.dec_rad,
            frame: Frame::Icrs,
            drifts: false,
        }],
        freq_setups: vec![FreqSetup {
            freq_hz_f: config.freq_hz_f(),
            chan_width_hz_f: vec![config.chan_width_hz(); config.n_chan],
            n_if: 1,
        }],
        corrs: config.corrs.clone(),
        n_row,
        time_scale: TimeScale::Utc,
        earth,
        history: vec![format!(
            "Simulated by vis2cat {}, seed {}, noise {}",
            env!("CARGO_PKG_VERSION"),
            config.seed,
            if config.noise { "on" } else { "off" }
        )],
        warnings: Vec::new(),
        uvh5: None,
        ms: None,
    }
}

fn antenna((dish, number): (&Dish, u32)) -> Antenna {
    Antenna {
        number,
        name: dish.name.clone(),
        itrf_m: dish.itrf_m,
        diameter_m: dish.diameter_m,
    }
}

/// The Earth's orientation at 0 h UTC of the day of `mjd`, for which `earth` holds.
pub(super) fn earth_of_day(
    mjd: f64,
    earth: Orientation,
) -> Result<EarthOrientation, SimulateError> {
    Ok(EarthOrientation {
        ut1_utc_s: Some(earth.ut1_utc_s),
        polar_motion_arcsec: Some(earth.pole_rad.map(|rad| rad / ARCSEC)),
        gst0_deg: Some(gast_rad(mjd.floor(), earth)? / DEG),
    })
}
