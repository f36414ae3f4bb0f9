//! What each row says besides its visibilities.
//!
//! # Source
//! Note, section on MAIN.

use super::DAY_S;
use super::antennas::Antennas;
use super::fields::Fields;
use super::windows::Windows;
use crate::ReadError;
use crate::casa::Table;
use crate::chunk::RowHead;

/// What rows refer to.
#[derive(Debug)]
pub(super) struct Tables {
    pub(super) antennas: Antennas,
    pub(super) fields: Fields,
    pub(super) windows: Windows,
}

/// Most rows whose heads are read at a time.
const MAX_HEADS: u64 = 4096;

/// What some rows say besides their visibilities.
#[derive(Debug, Default)]
pub(super) struct Heads {
    first: u64,
    uvw_m: Vec<f64>,
    time_s: Vec<f64>,
    interval_s: Vec<f64>,
    ants: [Vec<i32>; 2],
    field: Vec<i32>,
    description: Vec<i32>,
    flag_row: Vec<bool>,
}

impl Heads {
    /// The heads of the rows from `row` on, at most `n_most`.
    pub(super) fn read(main: &mut Table, row: u64, n_most: u64) -> Result<Self, ReadError> {
        let end = (row + n_most.min(MAX_HEADS)).min(main.n_row);
        let rows = || row..end;
        Ok(Self {
            first: row,
            uvw_m: main.rows("UVW", rows(), &[3])?,
            time_s: main.rows("TIME", rows(), &[])?,
            interval_s: intervals_s(main, row, end)?,
            ants: [
                main.rows("ANTENNA1", rows(), &[])?,
                main.rows("ANTENNA2", rows(), &[])?,
            ],
            field: main.rows("FIELD_ID", rows(), &[])?,
            description: main.rows("DATA_DESC_ID", rows(), &[])?,
            flag_row: main.rows("FLAG_ROW", rows(), &[])?,
        })
    }

    /// Whether the head of a row is held.
    pub(super) fn has(&self, row: u64) -> bool {
        row.checked_sub(self.first)
            .is_some_and(|at| at < self.time_s.len() as u64)
    }

    /// The number of the data description of a row that is held.
    pub(super) fn description(&self, row: u64) -> i32 {
        self.description[(row - self.first) as usize]
    }

    /// A row that is held, and whether all of it is bad.
    pub(super) fn get(
        &self,
        main: &Table,
        row: u64,
        tables: &Tables,
    ) -> Result<(RowHead, bool), ReadError> {
        let at = (row - self.first) as usize;
        let uvw_m = [0, 1, 2].map(|d| self.uvw_m[3 * at + d]);
        let time_mjd = self.time_s[at] / DAY_S;
        for (column, values) in [("UVW", uvw_m.as_slice()), ("TIME", &[time_mjd])] {
            if let Some(bad) = values.iter().find(|x| !x.is_finite()) {
                return Err(main.cell_error(column, row, format!("{bad} is not finite")));
            }
        }
        let antenna = |column, number| {
            tables.antennas.find(number).ok_or_else(|| {
                let what = format!("antenna {number} is not in table ANTENNA");
                main.cell_error(column, row, what)
            })
        };
        let ants = [
            antenna("ANTENNA1", self.ants[0][at])?,
            antenna("ANTENNA2", self.ants[1][at])?,
        ];
        let field = tables.fields.find(self.field[at]);
        let setup = tables.windows.find(self.description[at]);
        let head = RowHead {
            uvw_m,
            time_mjd,
            interval_s: self.interval_s[at],
            ants,
            field: field.map_err(|what| main.cell_error("FIELD_ID", row, what))?,
            freq_setup: setup.map_err(|what| main.cell_error("DATA_DESC_ID", row, what))?,
        };
        let is_flagged =
            self.flag_row[at] || ants.iter().any(|&ant| tables.antennas.is_flagged(ant));
        Ok((head, is_flagged))
    }
}

/// How long was integrated, or else the time that a row stands for; NaN where neither is said.
fn intervals_s(main: &mut Table, row: u64, end: u64) -> Result<Vec<f64>, ReadError> {
    let mut found = vec![f64::NAN; (end - row) as usize];
    for column in ["EXPOSURE", "INTERVAL"] {
        if !found.iter().any(|s| s.is_nan()) || !main.has(column) {
            continue;
        }
        let values_s = main.rows::<f64>(column, row..end, &[])?;
        for (interval_s, value_s) in found.iter_mut().zip(values_s) {
            if interval_s.is_nan() && value_s.is_finite() && value_s > 0.0 {
                *interval_s = value_s;
            }
        }
    }
    Ok(found)
}
