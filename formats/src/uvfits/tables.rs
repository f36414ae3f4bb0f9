//! The tables behind the groups of a written file: FQ, SU, AN.
//!
//! # Source
//! Memo, sections 4.1 (AN), 4.7 (FQ), 4.13 (SU): all columns that it lists are there, for readers
//! that ask for each.

use super::plan::{Plan, reference_day};
use crate::date;
use crate::fits::{Cards, Column, ColumnData, TableSpec, extensions};
use crate::{Corr, Frame, Observation, TimeScale};

/// The tables as the bytes of their HDUs; the antennas last.
pub(super) fn all(observation: &Observation, plan: &Plan, day_mjd: f64) -> Result<Vec<u8>, String> {
    let mut tables = vec![frequencies(observation, plan)];
    if plan.has_source {
        tables.push(sources(observation));
    }
    tables.push(antennas(observation, plan, day_mjd));
    extensions(&tables)
}

fn table(name: &str, columns: Vec<Column>, cards: Cards) -> TableSpec {
    let extname = name.to_owned();
    TableSpec {
        extname,
        columns,
        cards,
    }
}

/// A column of strings, at least `width` wide and as wide as the longest needs.
fn text<'a>(name: &str, width: usize, values: impl Iterator<Item = &'a str>) -> Column {
    let values = values.map(|value| format!("{value:<width$}")).collect();
    column(name, "", ColumnData::Text(values))
}

fn numbers(name: &str, form: impl Into<String>, unit: &str, values: Vec<f64>) -> Column {
    let form = form.into();
    column(name, unit, ColumnData::Cells { form, values })
}

fn column(name: &str, unit: &str, data: ColumnData) -> Column {
    Column {
        name: name.to_owned(),
        unit: (!unit.is_empty()).then(|| unit.to_owned()),
        ucd: None,
        description: String::new(),
        data,
    }
}

/// `AIPS FQ`: one row a frequency set-up.
fn frequencies(observation: &Observation, plan: &Plan) -> TableSpec {
    let (n_row, n_if) = (plan.ifs.len(), plan.n_if);
    let per_if = (plan.n_chan / n_if) as f64;
    let bands = || plan.ifs.iter().flatten();
    let columns = vec![
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
    cards.push("EXTVER", 1, "");
    cards.push("NO_IF", n_if, "");
    table("AIPS FQ", columns, cards)
}

/// `AIPS SU`: one row a field.
fn sources(observation: &Observation) -> TableSpec {
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
    let columns = vec![
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
    cards.push("EXTVER", 1, "");
    cards.push("NO_IF", n_if, "");
    cards.push("FREQID", -1, "any");
    cards.push("VELTYP", "", "");
    cards.push("VELDEF", "", "");
    table("AIPS SU", columns, cards)
}

/// `AIPS AN`: one row an antenna, positions geocentric.
fn antennas(observation: &Observation, plan: &Plan, day_mjd: f64) -> TableSpec {
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
    table(
        "AIPS AN",
        columns,
        antenna_cards(observation, plan, day_mjd),
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
    cards.push("EXTVER", 1, "subarray");
    // Zero: STABXYZ is geocentric. Relative positions are understood in two ways by readers.
    for key in ["ARRAYX", "ARRAYY", "ARRAYZ"] {
        cards.push(key, 0.0, "m");
    }
    cards.push(
        "GSTIA0",
        earth.gst0_deg.unwrap_or(mean_deg),
        "deg, sidereal time at 0 h of RDATE",
    );
    cards.push("DEGPDY", date::DEG_PER_DAY, "deg/day");
    cards.push("FREQ", plan.ref_hz, "Hz");
    cards.push("RDATE", day, "");
    cards.push("POLARX", polar_arcsec[0], "arcsec");
    cards.push("POLARY", polar_arcsec[1], "arcsec");
    cards.push("UT1UTC", earth.ut1_utc_s.unwrap_or(0.0), "s");
    if !is_tai {
        cards.push("DATUTC", 0.0, "s, time scale - UTC");
    }
    // The memo has both spellings; some readers know only the second and then assume TAI.
    cards.push("TIMESYS", time_scale, "");
    cards.push("TIMSYS", time_scale, "");
    cards.push("ARRNAM", observation.telescope.as_str(), "");
    cards.push("XYZHAND", "RIGHT", "");
    cards.push("FRAME", "ITRF", "");
    cards.push("NUMORB", 0, "");
    cards.push("NO_IF", plan.n_if, "");
    cards.push("NOPCAL", 0, "");
    cards.push("POLTYPE", "", "");
    cards.push("FREQID", -1, "any");
    cards
}
