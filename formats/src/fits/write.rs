//! Tables as bytes: headers from here, cells and sums by CFITSIO.

use std::path::Path;

use super::card::print::to_ascii;
use super::cfitsio::{CfitsioError, MemoryFits};
use super::spec::{Column, ColumnData, TableSpec, empty_primary};
use super::{BLOCK_BYTES, Cards};
use crate::WriteError;
use crate::pending::{PendingFile, refuse_existing};

/// Most columns of a table (Standard, section 7.3.1).
const MAX_COLUMNS: usize = 999;

/// Writes `tables` behind a primary HDU with `primary`, to be named `path`.
///
/// # Errors
/// The file exists and `overwrite` is false, it cannot be written, or what is given is no FITS
/// table: columns of unequal length, illegal names or keywords, a missing integer without null.
pub fn prepare_tables(
    path: &Path,
    overwrite: bool,
    primary: &Cards,
    tables: &[TableSpec],
) -> Result<PendingFile, WriteError> {
    let parameter = |what| WriteError::Parameter {
        path: path.into(),
        what,
    };
    let fault = (primary.fault()).or_else(|| tables.iter().find_map(check_table));
    fault.map_or(Ok(()), |what| Err(parameter(what)))?;
    refuse_existing(path, overwrite)?;
    let bytes = file_bytes(primary, tables).map_err(|e| parameter(e.0))?;
    let mut file = PendingFile::create(path, overwrite)?;
    file.append(&bytes)?;
    file.sync()?;
    Ok(file)
}

/// [`prepare_tables`] and the rename in one.
///
/// # Errors
/// As [`prepare_tables`].
pub fn write_tables(
    path: &Path,
    overwrite: bool,
    primary: &Cards,
    tables: &[TableSpec],
) -> Result<(), WriteError> {
    prepare_tables(path, overwrite, primary, tables)?.commit()
}

/// The HDUs of `tables` as bytes, to stand behind another primary HDU.
///
/// # Errors
/// CFITSIO's words.
pub(crate) fn extensions(tables: &[TableSpec]) -> Result<Vec<u8>, String> {
    let mut bytes = file_bytes(&Cards::default(), tables).map_err(|e| e.0)?;
    // With nothing to say the primary HDU is one block.
    Ok(bytes.split_off(BLOCK_BYTES))
}

/// The whole file.
fn file_bytes(primary: &Cards, tables: &[TableSpec]) -> Result<Vec<u8>, CfitsioError> {
    let mut first = empty_primary();
    first.keywords.extend(primary.keywords.iter().cloned());
    first.comments.clone_from(&primary.comments);
    first.history.clone_from(&primary.history);
    let mut bytes = with_sums(first).header();
    for table in tables {
        bytes.extend(with_sums(table.header()).header());
        let data_bytes = table.row_bytes() * table.rows();
        bytes.resize(bytes.len() + data_bytes.next_multiple_of(BLOCK_BYTES), 0);
    }
    let mut fits = MemoryFits::edit(bytes)?;
    fits.write_sums(0)?;
    for (hdu, table) in (1..).zip(tables) {
        for column in &table.columns {
            write_column(&mut fits, hdu, column)?;
        }
        fits.write_sums(hdu)?;
    }
    fits.into_bytes()
}

/// `cards` with the keywords that [`MemoryFits::write_sums`] fills in.
fn with_sums(mut cards: Cards) -> Cards {
    cards.push("CHECKSUM", "0000000000000000", "HDU checksum");
    cards.push("DATASUM", "0", "data unit sum");
    cards
}

fn write_column(fits: &mut MemoryFits, hdu: usize, column: &Column) -> Result<(), CfitsioError> {
    let name = &column.name;
    match &column.data {
        ColumnData::F64(values) | ColumnData::Cells { values, .. } => {
            fits.write_column(hdu, name, values)
        }
        ColumnData::I64 { values, null } => {
            let null = null.unwrap_or_default();
            let values: Vec<i64> = values.iter().map(|v| v.unwrap_or(null)).collect();
            fits.write_column(hdu, name, &values)
        }
        ColumnData::I32(values) => fits.write_column(hdu, name, values),
        ColumnData::Text(values) => {
            let values: Vec<String> = values.iter().map(|text| to_ascii(text)).collect();
            fits.write_column(hdu, name, &values)
        }
    }
}

/// Why `table` cannot be written, if it cannot.
fn check_table(table: &TableSpec) -> Option<String> {
    let name = &table.extname;
    if table.columns.len() > MAX_COLUMNS {
        return Some(format!("table {name} has more than {MAX_COLUMNS} columns"));
    }
    let faults = (0..table.columns.len()).map(|i| check_column(table, i));
    let fault = faults.flatten().next();
    let fault = fault.map(|(column, what)| format!("table {name}, column {column:?} {what}"));
    fault.or_else(|| table.cards.fault())
}

/// Name of column `i` and what is wrong with it, if anything is.
fn check_column(table: &TableSpec, i: usize) -> Option<(&str, String)> {
    let column = &table.columns[i];
    let name = column.name.as_str();
    let legal = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.is_empty() || !name.chars().all(legal) {
        return Some((name, "must be of letters, digits and _ only".into()));
    }
    let same = |other: &Column| other.name.eq_ignore_ascii_case(name);
    if table.columns[..i].iter().any(same) {
        return Some((name, "stands twice".into()));
    }
    let (rows, first) = (column.data.rows(), table.rows());
    if rows.is_some_and(|rows| rows != first) {
        let rows = rows.unwrap_or_default();
        return Some((name, format!("has {rows} rows, the first column {first}")));
    }
    if let ColumnData::I64 { values, null } = &column.data {
        let wrong = |v: &Option<i64>| match v {
            None => null.is_none(),
            Some(_) => v == null,
        };
        if values.iter().any(wrong) {
            let what = "lacks a value without having a null, or has the null for a value";
            return Some((name, what.into()));
        }
    }
    None
}
