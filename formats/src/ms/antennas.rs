//! Where the antennas are: table `ANTENNA`.
//!
//! # Source
//! Note, section on ANTENNA: an antenna is known by its row, from 0.

use std::path::Path;

use super::MAX_SUBTABLE_ROWS;
use crate::casa::Table;
use crate::{Antenna, ReadError};

/// The antennas, and how to find one.
#[derive(Debug)]
pub(super) struct Antennas {
    pub(super) list: Vec<Antenna>,
    /// Place in the list of each row, where it is an antenna.
    places: Vec<Option<u32>>,
    /// Whether all data of an antenna in the list are bad.
    flagged: Vec<bool>,
}

impl Antennas {
    pub(super) fn read(root: &Path) -> Result<Self, ReadError> {
        let mut table = Table::open_sub(root, "ANTENNA")?;
        check_frame(&mut table)?;
        if table.n_row > MAX_SUBTABLE_ROWS {
            return Err(table.malformed(format!("has {} rows", table.n_row)));
        }
        let mut antennas = Self {
            list: Vec::new(),
            places: Vec::new(),
            flagged: Vec::new(),
        };
        for row in 0..table.n_row {
            antennas.append(&mut table, row)?;
        }
        if antennas.list.is_empty() {
            return Err(table.malformed("has no antenna"));
        }
        Ok(antennas)
    }

    fn append(&mut self, table: &mut Table, row: u64) -> Result<(), ReadError> {
        let position_m = table.shaped::<f64>("POSITION", row, &[3])?;
        if let Some(bad) = position_m.iter().find(|x| !x.is_finite()) {
            return Err(table.cell_error("POSITION", row, format!("{bad} is not finite")));
        }
        let name = table.text("NAME", row)?;
        // pyuvdata fills up with such rows, so that the row is the number.
        let is_filler = name.is_empty() && position_m.iter().all(|&x| x == 0.0);
        self.places
            .push((!is_filler).then_some(self.list.len() as u32));
        if is_filler {
            return Ok(());
        }
        let diameter_m = if table.has("DISH_DIAMETER") {
            Some(table.scalar::<f64>("DISH_DIAMETER", row)?).filter(|&d| d > 0.0)
        } else {
            None
        };
        self.flagged
            .push(table.has("FLAG_ROW") && table.scalar("FLAG_ROW", row)?);
        self.list.push(Antenna {
            number: row as u32,
            name,
            itrf_m: [position_m[0], position_m[1], position_m[2]],
            diameter_m,
        });
        Ok(())
    }

    /// The place in the list of the antenna of that row.
    pub(super) fn find(&self, number: i32) -> Option<u32> {
        let row = usize::try_from(number).ok()?;
        self.places.get(row).copied().flatten()
    }

    /// Whether all data of an antenna are bad.
    pub(super) fn is_flagged(&self, place: u32) -> bool {
        self.flagged[place as usize]
    }
}

fn check_frame(table: &mut Table) -> Result<(), ReadError> {
    let frame = table.reference("POSITION")?.frame;
    match frame.as_deref() {
        None | Some("ITRF" | "ITRS") => Ok(()),
        Some(other) => {
            let what = format!("is in '{other}': only positions on the Earth (ITRF) are read");
            Err(table.column_error("POSITION", what))
        }
    }
}
