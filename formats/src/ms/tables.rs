//! The tables of a written set.
//!
//! # Source
//! Note; units and measures as casacore's default_ms has them.

use std::path::Path;

use num_complex::Complex;

use super::layout::Layout;
use super::{DAY_S, corrs};
use crate::casa::{Column, Kind, NewTable};
use crate::{Corr, Observation};

use Kind::{Bool, Double, Int, Text};

/// Frames of frequencies, by casacore's codes (class MFrequency).
const FREQ_FRAMES: [(u32, &str); 10] = [
    (0, "REST"),
    (1, "LSRK"),
    (2, "LSRD"),
    (3, "BARY"),
    (4, "GEO"),
    (5, "TOPO"),
    (6, "GALACTO"),
    (7, "LGROUP"),
    (8, "CMB"),
    (64, "Undefined"),
];
/// The code of frequencies at the telescope.
const TOPO: i32 = 5;

/// A column of one text a row.
const fn text(name: &'static str) -> Column {
    Column::one(name, Text)
}

/// A column of one whole number a row.
const fn int(name: &'static str) -> Column {
    Column::one(name, Int)
}

/// A column of one truth value a row.
const fn boolean(name: &'static str) -> Column {
    Column::one(name, Bool)
}

/// A column of one number of a unit a row.
const fn real(name: &'static str, unit: &'static str) -> Column {
    Column::one(name, Double).unit(unit, 1)
}

/// A column of one point in time a row.
const fn epoch(name: &'static str, scale: &'static str) -> Column {
    real(name, "s").measure("epoch", scale)
}

/// What is written beside the rows.
pub(super) struct Parts<'a> {
    pub(super) root: &'a Path,
    pub(super) observation: &'a Observation,
    pub(super) layout: &'a Layout,
    /// The scale of times: UTC or TAI.
    pub(super) scale: &'static str,
    /// First and last time [s].
    pub(super) span_s: [f64; 2],
}

impl Parts<'_> {
    /// Writes all subtables and makes them known to the main table.
    pub(super) fn write(&self, main: &mut NewTable) -> Result<(), String> {
        let parts = [
            self.antenna()?,
            self.data_description()?,
            self.feed()?,
            self.flag_cmd()?,
            self.field()?,
            self.history()?,
            self.observation()?,
            self.pointing()?,
            self.polarization()?,
            self.processor()?,
            self.spectral_window()?,
            self.state()?,
        ];
        parts.into_iter().try_for_each(|part| main.attach(part))
    }

    fn create(&self, name: &str, columns: &[Column], n_row: usize) -> Result<NewTable, String> {
        let mut table = NewTable::create(&self.root.join(name), name, columns)?;
        table.add_rows(n_row)?;
        Ok(table)
    }

    fn antenna(&self) -> Result<NewTable, String> {
        const COLUMNS: [Column; 8] = [
            Column::fixed("OFFSET", Double, &[3])
                .unit("m", 3)
                .measure("position", "ITRF"),
            Column::fixed("POSITION", Double, &[3])
                .unit("m", 3)
                .measure("position", "ITRF"),
            text("TYPE"),
            real("DISH_DIAMETER", "m"),
            boolean("FLAG_ROW"),
            text("MOUNT"),
            text("NAME"),
            text("STATION"),
        ];
        let antennas = &self.observation.antennas;
        let mut table = self.create("ANTENNA", &COLUMNS, antennas.len())?;
        let alike = |text: &str| vec![text.to_owned(); antennas.len()];
        let positions_m: Vec<f64> = antennas.iter().flat_map(|a| a.itrf_m).collect();
        let diameters_m: Vec<f64> = antennas
            .iter()
            .map(|a| a.diameter_m.unwrap_or(0.0))
            .collect();
        table.put_vectors("OFFSET", 0, vec![0.0; 3 * antennas.len()], 3)?;
        table.put_vectors("POSITION", 0, positions_m, 3)?;
        table.put_range("TYPE", 0, &alike("GROUND-BASED"))?;
        table.put_range("DISH_DIAMETER", 0, &diameters_m)?;
        table.put_range("MOUNT", 0, &alike("ALT-AZ"))?;
        table.put_range("NAME", 0, &self.layout.antenna_names)?;
        table.put_range("STATION", 0, &self.layout.antenna_names)?;
        Ok(table)
    }

    fn data_description(&self) -> Result<NewTable, String> {
        let columns = [
            boolean("FLAG_ROW"),
            int("POLARIZATION_ID"),
            int("SPECTRAL_WINDOW_ID"),
        ];
        let n_window = self.n_window();
        let mut table = self.create("DATA_DESCRIPTION", &columns, n_window)?;
        let windows: Vec<i32> = (0..n_window as i32).collect();
        table.put_range("SPECTRAL_WINDOW_ID", 0, &windows)?;
        Ok(table)
    }

    fn feed(&self) -> Result<NewTable, String> {
        let columns = [
            Column::fixed("POSITION", Double, &[3])
                .unit("m", 3)
                .measure("position", "ITRF"),
            Column::any("BEAM_OFFSET", Double, 2)
                .unit("rad", 2)
                .measure("direction", "J2000"),
            Column::any("POLARIZATION_TYPE", Text, 1),
            Column::any("POL_RESPONSE", Kind::Complex, 2),
            Column::any("RECEPTOR_ANGLE", Double, 1).unit("rad", 1),
            int("ANTENNA_ID"),
            int("BEAM_ID"),
            int("FEED_ID"),
            real("INTERVAL", "s"),
            int("NUM_RECEPTORS"),
            int("SPECTRAL_WINDOW_ID"),
            epoch("TIME", self.scale),
        ];
        let n = self.observation.antennas.len();
        let mut table = self.create("FEED", &columns, n)?;
        let circular = [Corr::Rr, Corr::Ll, Corr::Rl, Corr::Lr];
        let is_circular = self
            .observation
            .corrs
            .iter()
            .any(|corr| circular.contains(corr));
        let hands = if is_circular { ["R", "L"] } else { ["X", "Y"] };
        let (one, zero) = (Complex::new(1f32, 0.0), Complex::default());
        table.put_vectors("POSITION", 0, vec![0.0; 3 * n], 3)?;
        for row in 0..n as u64 {
            table.put_matrix("BEAM_OFFSET", row, &[0.0; 4], 2)?;
            table.put("POLARIZATION_TYPE", row, &hands.map(str::to_owned).to_vec())?;
            table.put_matrix("POL_RESPONSE", row, &[one, zero, zero, one], 2)?;
            table.put("RECEPTOR_ANGLE", row, &vec![0.0; 2])?;
        }
        table.put_range("ANTENNA_ID", 0, &(0..n as i32).collect::<Vec<_>>())?;
        table.put_range("BEAM_ID", 0, &vec![-1; n])?;
        table.put_range("NUM_RECEPTORS", 0, &vec![2; n])?;
        table.put_range("SPECTRAL_WINDOW_ID", 0, &vec![-1; n])?;
        table.put_range("TIME", 0, &vec![self.span_s[0]; n])?;
        Ok(table)
    }

    fn flag_cmd(&self) -> Result<NewTable, String> {
        let columns = [
            boolean("APPLIED"),
            text("COMMAND"),
            real("INTERVAL", "s"),
            int("LEVEL"),
            text("REASON"),
            int("SEVERITY"),
            epoch("TIME", self.scale),
            text("TYPE"),
        ];
        self.create("FLAG_CMD", &columns, 0)
    }

    fn field(&self) -> Result<NewTable, String> {
        let direction = |name| {
            let column = Column::any(name, Double, 2).unit("rad", 2);
            column.measure("direction", self.layout.frame)
        };
        let columns = [
            direction("DELAY_DIR"),
            direction("PHASE_DIR"),
            direction("REFERENCE_DIR"),
            text("CODE"),
            boolean("FLAG_ROW"),
            text("NAME"),
            int("NUM_POLY"),
            int("SOURCE_ID"),
            epoch("TIME", self.scale),
        ];
        let fields = &self.observation.fields;
        let mut table = self.create("FIELD", &columns, fields.len())?;
        let names: Vec<String> = fields.iter().map(|field| field.name.clone()).collect();
        table.put_range("NAME", 0, &names)?;
        table.put_range(
            "SOURCE_ID",
            0,
            &(0..fields.len() as i32).collect::<Vec<_>>(),
        )?;
        table.put_range("TIME", 0, &vec![self.span_s[0]; fields.len()])?;
        for (row, field) in fields.iter().enumerate() {
            for name in ["DELAY_DIR", "PHASE_DIR", "REFERENCE_DIR"] {
                table.put_matrix(name, row as u64, &[field.ra_rad, field.dec_rad], 2)?;
            }
        }
        Ok(table)
    }

    fn history(&self) -> Result<NewTable, String> {
        let columns = [
            Column::any("APP_PARAMS", Text, 1),
            Column::any("CLI_COMMAND", Text, 1),
            text("APPLICATION"),
            text("MESSAGE"),
            int("OBJECT_ID"),
            int("OBSERVATION_ID"),
            text("ORIGIN"),
            text("PRIORITY"),
            epoch("TIME", self.scale),
        ];
        let lines = &self.observation.history;
        let mut table = self.create("HISTORY", &columns, lines.len())?;
        let alike = |text: &str| vec![text.to_owned(); lines.len()];
        table.put_range("APPLICATION", 0, &alike("vis2cat"))?;
        table.put_range("MESSAGE", 0, lines)?;
        table.put_range("ORIGIN", 0, &alike("vis2cat"))?;
        table.put_range("PRIORITY", 0, &alike("NORMAL"))?;
        table.put_range("TIME", 0, &vec![self.span_s[0]; lines.len()])?;
        for row in 0..lines.len() as u64 {
            table.put("APP_PARAMS", row, &vec![String::new()])?;
            table.put("CLI_COMMAND", row, &vec![String::new()])?;
        }
        Ok(table)
    }

    fn observation(&self) -> Result<NewTable, String> {
        const LOCATION: Column = Column::fixed("TELESCOPE_LOCATION", Double, &[3]).unit("m", 3);
        let columns = [
            Column::fixed("TIME_RANGE", Double, &[2])
                .unit("s", 1)
                .measure("epoch", self.scale),
            Column::any("LOG", Text, 1),
            Column::any("SCHEDULE", Text, 1),
            boolean("FLAG_ROW"),
            text("OBSERVER"),
            text("PROJECT"),
            epoch("RELEASE_DATE", self.scale),
            text("SCHEDULE_TYPE"),
            text("TELESCOPE_NAME"),
            LOCATION.measure("position", "ITRF"),
        ];
        let mut table = self.create("OBSERVATION", &columns, 1)?;
        table.put_vectors("TIME_RANGE", 0, self.span_s.to_vec(), 2)?;
        table.put("LOG", 0, &vec![String::new()])?;
        table.put("SCHEDULE", 0, &vec![String::new()])?;
        table.put("OBSERVER", 0, &self.observation.observer)?;
        table.put("RELEASE_DATE", 0, &self.span_s[1])?;
        table.put("TELESCOPE_NAME", 0, &self.observation.telescope)?;
        // pyuvdata's column: without it, it asks the network where the telescope is.
        let location_m = self.layout.array_m.to_vec();
        table.put_vectors("TELESCOPE_LOCATION", 0, location_m, 3)?;
        Ok(table)
    }

    fn pointing(&self) -> Result<NewTable, String> {
        let direction = |name| {
            let column = Column::any(name, Double, 2).unit("rad", 2);
            column.measure("direction", self.layout.frame)
        };
        let columns = [
            direction("DIRECTION"),
            int("ANTENNA_ID"),
            real("INTERVAL", "s"),
            text("NAME"),
            int("NUM_POLY"),
            direction("TARGET"),
            epoch("TIME", self.scale),
            epoch("TIME_ORIGIN", self.scale),
            boolean("TRACKING"),
        ];
        self.create("POINTING", &columns, 0)
    }

    fn polarization(&self) -> Result<NewTable, String> {
        let columns = [
            Column::any("CORR_TYPE", Int, 1),
            Column::any("CORR_PRODUCT", Int, 2),
            boolean("FLAG_ROW"),
            int("NUM_CORR"),
        ];
        let list = (self.layout.corr_order.iter()).map(|&p| self.observation.corrs[p]);
        let numbers: Vec<i32> = list.clone().map(corrs::number).collect();
        let receptors: Vec<i32> = list.flat_map(corrs::receptors).collect();
        let mut table = self.create("POLARIZATION", &columns, 1)?;
        table.put("NUM_CORR", 0, &(numbers.len() as i32))?;
        table.put("CORR_TYPE", 0, &numbers)?;
        table.put_matrix("CORR_PRODUCT", 0, &receptors, 2)?;
        Ok(table)
    }

    fn processor(&self) -> Result<NewTable, String> {
        let columns = [
            boolean("FLAG_ROW"),
            int("MODE_ID"),
            text("TYPE"),
            int("TYPE_ID"),
            text("SUB_TYPE"),
        ];
        self.create("PROCESSOR", &columns, 0)
    }

    fn spectral_window(&self) -> Result<NewTable, String> {
        const COLUMNS: [Column; 14] = [
            int("MEAS_FREQ_REF"),
            Column::any("CHAN_FREQ", Double, 1).unit("Hz", 1),
            real("REF_FREQUENCY", "Hz"),
            Column::any("CHAN_WIDTH", Double, 1).unit("Hz", 1),
            Column::any("EFFECTIVE_BW", Double, 1).unit("Hz", 1),
            Column::any("RESOLUTION", Double, 1).unit("Hz", 1),
            boolean("FLAG_ROW"),
            int("FREQ_GROUP"),
            text("FREQ_GROUP_NAME"),
            int("IF_CONV_CHAIN"),
            text("NAME"),
            int("NET_SIDEBAND"),
            int("NUM_CHAN"),
            real("TOTAL_BANDWIDTH", "Hz"),
        ];
        let mut table = self.create("SPECTRAL_WINDOW", &COLUMNS, self.n_window())?;
        for name in ["CHAN_FREQ", "REF_FREQUENCY"] {
            table.put_reference_column(name, "frequency", "MEAS_FREQ_REF", &FREQ_FRAMES)?;
        }
        for (s, setup) in self.observation.freq_setups.iter().enumerate() {
            for (w, window) in self.layout.windows.iter().enumerate() {
                let row = self.layout.description(s, w) as u64;
                let freq_hz_f = setup.freq_hz_f[window.clone()].to_vec();
                let width_hz_f = setup.chan_width_hz_f[window.clone()].to_vec();
                let size_hz_f: Vec<f64> = width_hz_f.iter().map(|hz| hz.abs()).collect();
                let sideband = if width_hz_f[0] < 0.0 { -1 } else { 1 };
                table.put("MEAS_FREQ_REF", row, &TOPO)?;
                table.put("REF_FREQUENCY", row, &freq_hz_f[0])?;
                table.put("NUM_CHAN", row, &(freq_hz_f.len() as i32))?;
                table.put("NET_SIDEBAND", row, &sideband)?;
                table.put("TOTAL_BANDWIDTH", row, &size_hz_f.iter().sum::<f64>())?;
                table.put("NAME", row, &format!("SPW{row}"))?;
                table.put("CHAN_FREQ", row, &freq_hz_f)?;
                table.put("CHAN_WIDTH", row, &width_hz_f)?;
                table.put("EFFECTIVE_BW", row, &size_hz_f)?;
                table.put("RESOLUTION", row, &size_hz_f)?;
            }
        }
        Ok(table)
    }

    fn state(&self) -> Result<NewTable, String> {
        let columns = [
            real("CAL", "K"),
            boolean("FLAG_ROW"),
            real("LOAD", "K"),
            text("OBS_MODE"),
            boolean("REF"),
            boolean("SIG"),
            int("SUB_SCAN"),
        ];
        self.create("STATE", &columns, 0)
    }

    fn n_window(&self) -> usize {
        (self.layout).description(self.observation.freq_setups.len(), 0)
    }
}

/// The main table, without its columns of samples; (u, v, w) and weights have that many values.
pub(super) fn main(
    root: &Path,
    layout: &Layout,
    scale: &'static str,
    tile: [u64; 3],
) -> Result<NewTable, String> {
    let columns = [
        Column::fixed("UVW", Double, &[3])
            .unit("m", 3)
            .measure("uvw", layout.frame),
        Column::any("FLAG_CATEGORY", Bool, 3),
        by_corr("WEIGHT", layout),
        by_corr("SIGMA", layout),
        int("ANTENNA1"),
        int("ANTENNA2"),
        int("ARRAY_ID"),
        int("DATA_DESC_ID"),
        real("EXPOSURE", "s"),
        int("FEED1"),
        int("FEED2"),
        int("FIELD_ID"),
        boolean("FLAG_ROW"),
        real("INTERVAL", "s"),
        int("OBSERVATION_ID"),
        int("PROCESSOR_ID"),
        int("SCAN_NUMBER"),
        int("STATE_ID"),
        epoch("TIME", scale),
        epoch("TIME_CENTROID", scale),
    ];
    let mut table = NewTable::create(root, "MAIN", &columns)?;
    table.add_tiled(&Column::any("DATA", Kind::Complex, 2), tile)?;
    table.add_tiled(&Column::any("FLAG", Bool, 2), tile)?;
    table.add_tiled(&Column::any("WEIGHT_SPECTRUM", Kind::Float, 2), tile)?;
    table.put_column_keyword("FLAG_CATEGORY", "CATEGORY", &Vec::<String>::new())?;
    table.put_keyword("MS_VERSION", &2f32)?;
    // pyuvdata asks this of a set; where it finds nothing it goes by who is named in HISTORY.
    table.put_keyword("pyuvdata_flip_conj", &true)?;
    Ok(table)
}

/// A column of one number for each correlation, of which there are four at most.
fn by_corr(name: &'static str, layout: &Layout) -> Column {
    const SHAPES: [&[u64]; 5] = [&[0], &[1], &[2], &[3], &[4]];
    match SHAPES.get(layout.corr_order.len()) {
        Some(shape) => Column::fixed(name, Kind::Float, shape),
        None => Column::any(name, Kind::Float, 1),
    }
}

/// Seconds of a modified Julian date.
pub(super) fn seconds(mjd: f64) -> f64 {
    mjd * DAY_S
}
