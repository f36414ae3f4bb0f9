//! The header of a written file.
//!
//! # Source
//! Memo, sections 3.1 (what must be there) and 3.2 (what may); names as pyuvdata 3.2 reads them.

use super::layout::Layout;
use crate::h5::NewGroup;
use crate::{Field, Frame, Observation, TimeScale};

/// What is known only when all rows are.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    pub(super) rows: usize,
    pub(super) times: usize,
    pub(super) baselines: usize,
    /// Antennas that have data.
    pub(super) antennas: usize,
}

/// Writes all of the header but what there is one of for each row.
pub(super) fn write(
    header: &NewGroup,
    observation: &Observation,
    layout: &Layout,
    counts: Counts,
) -> Result<(), String> {
    header.text("version", "1.2")?;
    write_counts(header, observation, layout, counts)?;
    write_telescope(header, observation, layout)?;
    write_channels(header, observation, layout)?;
    write_centres(header, &observation.fields)?;
    let codes: Vec<i64> = (observation.corrs.iter())
        .map(|corr| corr.stokes_code().into())
        .collect();
    header.array("polarization_array", &[codes.len()], &codes)?;
    write_notes(header, observation)?;
    header.text("history", &observation.history.join("\n"))
}

fn write_counts(
    header: &NewGroup,
    observation: &Observation,
    layout: &Layout,
    counts: Counts,
) -> Result<(), String> {
    let values = [
        ("Nblts", counts.rows),
        ("Ntimes", counts.times),
        ("Nbls", counts.baselines),
        ("Nants_data", counts.antennas),
        ("Nants_telescope", observation.antennas.len()),
        ("Nfreqs", layout.spw_f.len()),
        ("Npols", observation.corrs.len()),
        ("Nspws", window_numbers(layout).len()),
        ("Nphase", observation.fields.len()),
    ];
    values
        .iter()
        .try_for_each(|&(name, value)| header.value(name, value as i64))
}

fn write_telescope(
    header: &NewGroup,
    observation: &Observation,
    layout: &Layout,
) -> Result<(), String> {
    let antennas = &observation.antennas;
    let [lon_deg, lat_deg, height_m] = layout.geodetic;
    header.text("telescope_frame", "itrs")?;
    header.value("longitude", lon_deg)?;
    header.value("latitude", lat_deg)?;
    header.value("altitude", height_m)?;
    header.text("telescope_name", named(&observation.telescope))?;
    header.text("instrument", named(&observation.instrument))?;
    header.array(
        "antenna_numbers",
        &[antennas.len()],
        &layout.antenna_numbers,
    )?;
    header.texts("antenna_names", &antenna_names(observation, layout))?;
    let offsets_m: Vec<f64> = (antennas.iter())
        .flat_map(|antenna| [0, 1, 2].map(|d| antenna.itrf_m[d] - layout.array_m[d]))
        .collect();
    header.array("antenna_positions", &[antennas.len(), 3], &offsets_m)?;
    let diameters_m: Option<Vec<f64>> = antennas.iter().map(|a| a.diameter_m).collect();
    match diameters_m {
        Some(values) => header.array("antenna_diameters", &[values.len()], &values),
        None => Ok(()),
    }
}

/// An empty text is no name to readers.
fn named(name: &str) -> &str {
    if name.trim().is_empty() {
        "unknown"
    } else {
        name
    }
}

/// Their names, or numbers where a name is missing or stands twice, which readers do not take.
fn antenna_names(observation: &Observation, layout: &Layout) -> Vec<String> {
    let names: Vec<&str> = observation.antennas.iter().map(|a| a.name.trim()).collect();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    let good = !sorted.contains(&"") && sorted.windows(2).all(|pair| pair[0] != pair[1]);
    if good {
        return names.into_iter().map(str::to_owned).collect();
    }
    layout.antenna_numbers.iter().map(i64::to_string).collect()
}

fn write_channels(
    header: &NewGroup,
    observation: &Observation,
    layout: &Layout,
) -> Result<(), String> {
    let setup = &observation.freq_setups[0];
    let n_chan = setup.freq_hz_f.len();
    let widths_hz: Vec<f64> = setup.chan_width_hz_f.iter().map(|hz| hz.abs()).collect();
    let numbers = window_numbers(layout);
    header.array("freq_array", &[n_chan], &setup.freq_hz_f)?;
    header.array("channel_width", &[n_chan], &widths_hz)?;
    header.array("spw_array", &[numbers.len()], &numbers)?;
    header.array("flex_spw_id_array", &[n_chan], &layout.spw_f)?;
    // pyuvdata leaves it out since 3.0, the memo still wants it.
    header.value("flex_spw", numbers.len() > 1)
}

/// The windows in the order of their first channels.
fn window_numbers(layout: &Layout) -> Vec<i64> {
    let mut numbers = Vec::new();
    for &id in &layout.spw_f {
        if !numbers.contains(&id) {
            numbers.push(id);
        }
    }
    numbers
}

fn write_centres(header: &NewGroup, fields: &[Field]) -> Result<(), String> {
    let catalog = header.group("phase_center_catalog")?;
    for (i, field) in fields.iter().enumerate() {
        let entry = catalog.group(&i.to_string())?;
        if field.drifts {
            unprojected(&entry, field)?;
            continue;
        }
        let (frame, epoch) = match field.frame {
            Frame::Icrs => ("icrs", 2000.0),
            Frame::Fk5(equinox) => ("fk5", equinox),
            Frame::Fk4(equinox) => ("fk4", equinox),
        };
        entry.text("cat_name", named(&field.name))?;
        entry.text("cat_type", "sidereal")?;
        entry.value("cat_lon", field.ra_rad)?;
        entry.value("cat_lat", field.dec_rad)?;
        entry.text("cat_frame", frame)?;
        entry.value("cat_epoch", epoch)?;
        entry.text("info_source", "file")?;
    }
    Ok(())
}

/// As pyuvdata writes what is not phased: to the zenith.
fn unprojected(entry: &NewGroup, field: &Field) -> Result<(), String> {
    entry.text("cat_name", named(&field.name))?;
    entry.text("cat_type", "unprojected")?;
    entry.value("cat_lon", 0.0)?;
    entry.value("cat_lat", std::f64::consts::FRAC_PI_2)?;
    entry.text("cat_frame", "altaz")?;
    entry.text("info_source", "file")
}

fn write_notes(header: &NewGroup, observation: &Observation) -> Result<(), String> {
    let notes = observation.uvh5.as_ref();
    header.text(
        "vis_units",
        notes.map_or("Jy", |notes| notes.vis_units.as_str()),
    )?;
    if let Some(convention) = notes.and_then(|notes| notes.pol_convention.as_deref()) {
        header.text("pol_convention", convention)?;
    }
    if let Some(orientation) = notes.and_then(|notes| notes.x_orientation.as_deref()) {
        header.text("x_orientation", orientation)?;
    }
    if observation.time_scale == TimeScale::Tai {
        header.text("timesys", "TAI")?;
    }
    if !observation.date_obs.is_empty() {
        header.text("rdate", &observation.date_obs)?;
    }
    if let Some(seconds) = observation.earth.ut1_utc_s {
        header.value("dut1", seconds)?;
    }
    match observation.earth.gst0_deg {
        Some(gst0_deg) => header.value("gst0", gst0_deg),
        None => Ok(()),
    }
}
