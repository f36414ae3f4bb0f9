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

/// A row without its visibilities, and whether all of it is bad.
pub(super) fn read(
    main: &mut Table,
    row: u64,
    tables: &Tables,
) -> Result<(RowHead, bool), ReadError> {
    let uvw_m = main.shaped::<f64>("UVW", row, &[3])?;
    let time_mjd = main.scalar::<f64>("TIME", row)? / DAY_S;
    for (column, values) in [("UVW", uvw_m.as_slice()), ("TIME", &[time_mjd])] {
        if let Some(bad) = values.iter().find(|x| !x.is_finite()) {
            return Err(main.cell_error(column, row, format!("{bad} is not finite")));
        }
    }
    let ants = [
        antenna(main, "ANTENNA1", row, tables)?,
        antenna(main, "ANTENNA2", row, tables)?,
    ];
    let number = main.scalar::<i32>("FIELD_ID", row)?;
    let field = tables.fields.find(number);
    let is_flagged = main.scalar::<bool>("FLAG_ROW", row)?
        || ants.iter().any(|&ant| tables.antennas.is_flagged(ant));
    let head = RowHead {
        uvw_m: [uvw_m[0], uvw_m[1], uvw_m[2]],
        time_mjd,
        interval_s: interval_s(main, row)?,
        ants,
        field: field.map_err(|what| main.cell_error("FIELD_ID", row, what))?,
        freq_setup: freq_setup(main, row, tables)?,
    };
    Ok((head, is_flagged))
}

/// The place in the set-ups of a row's spectral window.
pub(super) fn freq_setup(main: &mut Table, row: u64, tables: &Tables) -> Result<u32, ReadError> {
    let number = main.scalar::<i32>("DATA_DESC_ID", row)?;
    let setup = tables.windows.find(number);
    setup.map_err(|what| main.cell_error("DATA_DESC_ID", row, what))
}

fn antenna(main: &mut Table, column: &str, row: u64, tables: &Tables) -> Result<u32, ReadError> {
    let number = main.scalar::<i32>(column, row)?;
    tables.antennas.find(number).ok_or_else(|| {
        let what = format!("antenna {number} is not in table ANTENNA");
        main.cell_error(column, row, what)
    })
}

/// How long was integrated, or else the time that a row stands for; NaN where neither is said.
fn interval_s(main: &mut Table, row: u64) -> Result<f64, ReadError> {
    for column in ["EXPOSURE", "INTERVAL"] {
        if main.has(column) {
            let value_s = main.scalar::<f64>(column, row)?;
            if value_s.is_finite() && value_s > 0.0 {
                return Ok(value_s);
            }
        }
    }
    Ok(f64::NAN)
}
