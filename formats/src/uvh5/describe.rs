//! What the header says of the observation as a whole.
//!
//! # Source
//! Memo, sections 3.1 and 3.2.

use crate::h5::Group;
use crate::{EarthOrientation, Observation, ReadError, TimeScale, Uvh5Notes, date};

/// Names, days, time scale, history; nothing of the axes.
pub(super) fn describe(
    header: &Group,
    warnings: &mut Vec<String>,
) -> Result<Observation, ReadError> {
    let text = |name| optional_text(header, name);
    let real = |name| -> Result<Option<f64>, ReadError> {
        header
            .dataset(name)?
            .map(|dataset| dataset.real())
            .transpose()
    };
    let history = text("history")?.unwrap_or_default();
    Ok(Observation {
        telescope: header.need("telescope_name")?.text()?,
        instrument: text("instrument")?.unwrap_or_default(),
        date_obs: text("rdate")?
            .and_then(|day| date::parse_day(&day))
            .unwrap_or_default(),
        time_scale: time_scale(text("timesys")?, warnings),
        earth: EarthOrientation {
            ut1_utc_s: real("dut1")?,
            polar_motion_arcsec: None,
            gst0_deg: real("gst0")?,
        },
        history: history.lines().map(str::to_owned).collect(),
        ..Observation::default()
    })
}

fn time_scale(name: Option<String>, warnings: &mut Vec<String>) -> TimeScale {
    match name.map(|name| name.to_uppercase()).as_deref() {
        None | Some("" | "UTC") => TimeScale::Utc,
        Some("TAI" | "IAT") => TimeScale::Tai,
        Some(other) => {
            warnings.push(format!("time scale '{other}' is taken as UTC"));
            TimeScale::Other
        }
    }
}

/// What there is no place for in other formats.
pub(super) fn notes(
    header: &Group,
    spw_f: Vec<i64>,
    warnings: &mut Vec<String>,
) -> Result<Uvh5Notes, ReadError> {
    let notes = Uvh5Notes {
        spw_f,
        vis_units: optional_text(header, "vis_units")?.unwrap_or_else(|| "uncalib".into()),
        pol_convention: optional_text(header, "pol_convention")?,
        x_orientation: optional_text(header, "x_orientation")?,
    };
    if notes.vis_units != "Jy" {
        warnings.push(format!(
            "the visibilities are in '{}', not in Jy; they are used as stored",
            notes.vis_units
        ));
    }
    if notes.pol_convention.as_deref() == Some("sum") {
        warnings.push(
            "pol_convention is 'sum', I = XX + YY, but half the sum of the hands is taken as total \
             intensity: flux densities come out half"
                .into(),
        );
    }
    Ok(notes)
}

fn optional_text(header: &Group, name: &str) -> Result<Option<String>, ReadError> {
    header
        .dataset(name)?
        .map(|dataset| dataset.text())
        .transpose()
}
