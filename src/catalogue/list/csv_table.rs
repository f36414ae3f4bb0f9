//! A list of sources as comma-separated values.

use std::path::Path;

use vis2cat_formats::ReadError;

use super::cells::CellTable;
use super::malformed;

/// The cells of a CSV file; lines that start with `#` are skipped. The unit of a column stands in
/// brackets behind its name.
pub(super) fn read(path: &Path) -> Result<CellTable, ReadError> {
    let file = std::fs::File::open(path).map_err(|source| ReadError::Io {
        path: path.into(),
        source,
    })?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(file);
    let headers = reader.headers().map_err(|e| csv_error(path, 0, &e))?;
    let columns = headers.iter().map(name_and_unit).collect();
    let mut rows = Vec::new();
    for record in reader.into_records() {
        let record = record.map_err(|e| csv_error(path, rows.len() + 1, &e))?;
        rows.push(record.iter().map(str::to_owned).collect());
    }
    Ok(CellTable {
        path: path.into(),
        columns,
        rows,
    })
}

/// `Total_flux[uJy]` as name and unit.
fn name_and_unit(header: &str) -> (String, Option<String>) {
    let header = header.trim_start_matches('\u{feff}').trim();
    match header.split_once('[') {
        Some((name, unit)) => {
            let unit = unit.trim().trim_end_matches(']').trim();
            (name.trim().to_owned(), Some(unit.to_owned()))
        }
        None => (header.to_owned(), None),
    }
}

fn csv_error(path: &Path, row: usize, error: &csv::Error) -> ReadError {
    malformed(path, format!("row {row}"), &error.to_string())
}
