//! The tables behind the groups of a written file: FQ, SU, AN.
//!
//! # Source
//! Memo, sections 4.1 (AN), 4.7 (FQ), 4.13 (SU): all columns that it lists are there, for readers
//! that ask for each.

use super::date;
use super::plan::{Plan, reference_day};
use crate::fits::card::{Cards, printable};
use crate::fits::table::{Cells, Column, table_bytes};
use crate::{Corr, Frame, Observation, TimeScale};

/// The tables as the bytes of their HDUs; the antennas last.
pub(super) fn all(observation: &Observation, plan: &Plan, day_mjd: f64) -> Result<Vec<u8>, String> {
    let mut bytes = frequencies(observation, plan)?;
    if plan.has_source {
        bytes.extend(sources(observation)?);
    }
    bytes.extend(antennas(observation, plan, day_mjd)?);
    Ok(bytes)
}

/// A column of strings, at least `width` wide and as wide as the longest needs.
fn text<'a>(name: &'static str, width: usize, values: impl Iterator<Item = &'a str>) -> Column {
    let values: Vec<String> = values.map(|value| printable(value.as_bytes())).collect();
    let longest = values.iter().map(String::len).max().unwrap_or(0);
    Column {
        name,
        form: format!("{}A", longest.max(width)),
        unit: "",
        cells: Cells::Text(values),
    }
}

fn numbers(
    name: &'static str,
    form: impl Into<String>,
    unit: &'static str,
    values: Vec<f64>,
) -> Column {
    Column {
        name,
        form: form.into(),
        unit,
        cells: Cells::Numbers(values),
    }
}

/// `AIPS FQ`: one row a frequency set-up.
fn frequencies(observation: &Observation, plan: &Plan) -> Result<Vec<u8>, String> {
    let (n_row, n_if) = (plan.ifs.len(), plan.n_if);
    let per_if = (plan.n_chan / n_if) as f64;
    let bands = || plan.ifs.iter().flatten();
    let columns = [
        numbers("FRQSEL", "1J", "", (1..=n_row).map(|i| i as f64).collect()),
        numbers(
            "IF FREQ",
            format!("{n_if}D"),
            "HZ",
            bands().map(|b| b.first_hz - plan.ref_hz).collect(),
        ),
        numbers(
            "CH WIDTH",
            format!("{n_if}E"),
            "HZ",
            bands().map(|b| b.step_hz).collect(),
        ),
        numbers(
            "TOTAL BANDWIDTH",
            format!("{n_if}E"),
            "HZ",
            bands().map(|b| b.step_hz.abs() * per_if).collect(),
        ),
        numbers(
            "SIDEBAND",
            format!("{n_if}J"),
            "",
            bands()
                .map(|b| if b.step_hz < 0.0 { -1.0 } else { 1.0 })
                .collect(),
        ),
    ];
    debug_assert_eq!(n_row, observation.freq_setups.len());
    let mut cards = Cards::default();
    cards.integer("EXTVER", 1, "");
    cards.integer("NO_IF", n_if as i64, "");
    table_bytes("AIPS FQ", n_row, &columns, &cards)
}

/// `AIPS SU`: one row a field.
fn sources(observation: &Observation) -> Result<Vec<u8>, String> {
    let fields = &observation.fields;
    let n_row = fields.len();
    let n_if = observation.freq_setups[0].n_if;
    let zeros = |n: usize| vec![0.0; n * n_row];
    let ra_deg: Vec<f64> = fields.iter().map(|f| f.ra_rad.to_degrees()).collect();
    let dec_deg: Vec<f64> = fields.iter().map(|f| f.dec_rad.to_degrees()).collect();
    let epoch = |frame| match frame {
        Frame::Icrs => 2000.0,
        Frame::Fk5(equinox) | Frame::Fk4(equinox) => equinox,
    };
    let per_if = |letter: &str| format!("{n_if}{letter}");
    let columns = [
        numbers("ID. NO.", "1J", "", (1..=n_row).map(|i| i as f64).collect()),
        text("SOURCE", 20, fields.iter().map(|f| f.name.as_str())),
        numbers("QUAL", "1J", "", zeros(1)),
        text("CALCODE", 4, fields.iter().map(|_| "")),
        numbers("IFLUX", per_if("E"), "JY", zeros(n_if)),
        numbers("QFLUX", per_if("E"), "JY", zeros(n_if)),
        numbers("UFLUX", per_if("E"), "JY", zeros(n_if)),
        numbers("VFLUX", per_if("E"), "JY", zeros(n_if)),
        numbers("FREQOFF", per_if("D"), "HZ", zeros(n_if)),
        numbers("BANDWIDTH", "1D", "HZ", zeros(1)),
        numbers("RAEPO", "1D", "DEGREES", ra_deg.clone()),
        numbers("DECEPO", "1D", "DEGREES", dec_deg.clone()),
        numbers(
            "EPOCH",
            "1D",
            "YEARS",
            fields.iter().map(|f| epoch(f.frame)).collect(),
        ),
        numbers("RAAPP", "1D", "DEGREES", ra_deg.clone()),
        numbers("DECAPP", "1D", "DEGREES", dec_deg.clone()),
        numbers("LSRVEL", per_if("D"), "M/SEC", zeros(n_if)),
        numbers("RESTFREQ", per_if("D"), "HZ", zeros(n_if)),
        numbers("PMRA", "1D", "DEG/DAY", zeros(1)),
        numbers("PMDEC", "1D", "DEG/DAY", zeros(1)),
        numbers("RAOBS", "1D", "DEGREES", ra_deg),
        numbers("DECOBS", "1D", "DEGREES", dec_deg),
    ];
    let mut cards = Cards::default();
    cards.integer("EXTVER", 1, "");
    cards.integer("NO_IF", n_if as i64, "");
    cards.integer("FREQID", -1, "any");
    cards.text("VELTYP", "", "");
    cards.text("VELDEF", "", "");
    table_bytes("AIPS SU", n_row, &columns, &cards)
}

/// `AIPS AN`: one row an antenna, positions geocentric.
fn antennas(observation: &Observation, plan: &Plan, day_mjd: f64) -> Result<Vec<u8>, String> {
    let list = &observation.antennas;
    let n_row = list.len();
    let linear = !matches!(
        observation.corrs[0],
        Corr::Rr | Corr::Ll | Corr::Rl | Corr::Lr
    );
    let (feed_a, feed_b) = if linear { ("X", "Y") } else { ("R", "L") };
    let angle_b_deg = if linear { 90.0 } else { 0.0 };
    let same = |value: f64| vec![value; n_row];
    let mut columns = vec![
        text("ANNAME", 8, list.iter().map(|a| a.name.as_str())),
        numbers(
            "STABXYZ",
            "3D",
            "METERS",
            list.iter().flat_map(|a| a.itrf_m).collect(),
        ),
        numbers("ORBPARM", "0D", "", Vec::new()),
        numbers(
            "NOSTA",
            "1J",
            "",
            plan.antenna_numbers.iter().map(|&n| n.into()).collect(),
        ),
        numbers("MNTSTA", "1J", "", same(0.0)),
        numbers("STAXOF", "1E", "METERS", same(0.0)),
        text("POLTYA", 1, list.iter().map(|_| feed_a)),
        numbers("POLAA", "1E", "DEGREES", same(0.0)),
        numbers("POLCALA", "0E", "", Vec::new()),
        text("POLTYB", 1, list.iter().map(|_| feed_b)),
        numbers("POLAB", "1E", "DEGREES", same(angle_b_deg)),
        numbers("POLCALB", "0E", "", Vec::new()),
    ];
    if list.iter().any(|antenna| antenna.diameter_m.is_some()) {
        let diameters_m = list.iter().map(|a| a.diameter_m.unwrap_or(0.0)).collect();
        columns.push(numbers("DIAMETER", "1E", "METERS", diameters_m));
    }
    table_bytes(
        "AIPS AN",
        n_row,
        &columns,
        &antenna_cards(observation, plan, day_mjd),
    )
}

fn antenna_cards(observation: &Observation, plan: &Plan, day_mjd: f64) -> Cards {
    let day = reference_day(observation, day_mjd);
    let mean_deg = date::gmst0_deg(date::mjd_of_day(&day).unwrap_or(day_mjd));
    let earth = &observation.earth;
    let polar_arcsec = earth.polar_motion_arcsec.unwrap_or([0.0; 2]);
    let is_tai = observation.time_scale == TimeScale::Tai;
    let time_scale = if is_tai { "TAI" } else { "UTC" };
    let mut cards = Cards::default();
    cards.integer("EXTVER", 1, "subarray");
    // Zero: STABXYZ is geocentric. Relative positions are understood in two ways by readers.
    for key in ["ARRAYX", "ARRAYY", "ARRAYZ"] {
        cards.real(key, 0.0, "m");
    }
    cards.real(
        "GSTIA0",
        earth.gst0_deg.unwrap_or(mean_deg),
        "deg, sidereal time at 0 h of RDATE",
    );
    cards.real("DEGPDY", date::DEG_PER_DAY, "deg/day");
    cards.real("FREQ", plan.ref_hz, "Hz");
    cards.text("RDATE", &day, "");
    cards.real("POLARX", polar_arcsec[0], "arcsec");
    cards.real("POLARY", polar_arcsec[1], "arcsec");
    cards.real("UT1UTC", earth.ut1_utc_s.unwrap_or(0.0), "s");
    if !is_tai {
        cards.real("DATUTC", 0.0, "s, time scale - UTC");
    }
    // The memo has both spellings; some readers know only the second and then assume TAI.
    cards.text("TIMESYS", time_scale, "");
    cards.text("TIMSYS", time_scale, "");
    cards.text("ARRNAM", &observation.telescope, "");
    cards.text("XYZHAND", "RIGHT", "");
    cards.text("FRAME", "ITRF", "");
    cards.integer("NUMORB", 0, "");
    cards.integer("NO_IF", plan.n_if as i64, "");
    cards.integer("NOPCAL", 0, "");
    cards.text("POLTYPE", "", "");
    cards.integer("FREQID", -1, "any");
    cards
}
