//! A list of sources as comma-separated values.

use std::path::{Path, PathBuf};

use vis2cat_formats::ReadError;

use super::{Raw, malformed};

/// The cells of a CSV file; lines that start with `#` are skipped.
pub(super) struct CsvTable {
    path: PathBuf,
    /// Name and, in brackets behind it, unit.
    columns: Vec<(String, Option<String>)>,
    records: Vec<csv::StringRecord>,
}

impl CsvTable {
    pub(super) fn read(path: &Path) -> Result<Self, ReadError> {
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
        let mut records = Vec::new();
        for record in reader.into_records() {
            let record = record.map_err(|e| csv_error(path, records.len() + 1, &e))?;
            records.push(record);
        }
        Ok(Self {
            path: path.into(),
            columns,
            records,
        })
    }

    pub(super) fn rows(&self) -> usize {
        self.records.len()
    }

    /// The column `name`, in any case, that stands there once.
    fn find(&self, name: &str) -> Result<Option<usize>, ReadError> {
        let mut found = (self.columns.iter().enumerate())
            .filter(|(_, (column, _))| column.eq_ignore_ascii_case(name));
        let at = found.next().map(|(at, _)| at);
        if found.next().is_some() {
            let place = format!("column {name}");
            return Err(malformed(&self.path, place, "it stands there twice"));
        }
        Ok(at)
    }

    /// Whether there is a column `name`, in any case.
    pub(super) fn has(&self, name: &str) -> bool {
        let mut names = self.columns.iter();
        names.any(|(column, _)| column.eq_ignore_ascii_case(name))
    }

    /// The cells of the column `name`, in any case.
    pub(super) fn strings(&self, name: &str) -> Result<Option<Vec<String>>, ReadError> {
        let cell = |at| {
            let text = |record: &csv::StringRecord| record.get(at).unwrap_or_default().to_owned();
            self.records.iter().map(text).collect()
        };
        Ok(self.find(name)?.map(cell))
    }

    /// Unit and numbers of the column `name`, in any case; an empty cell is NaN.
    pub(super) fn numbers(&self, name: &str) -> Result<Option<Raw>, ReadError> {
        let Some(at) = self.find(name)? else {
            return Ok(None);
        };
        let number = |(row, record): (usize, &csv::StringRecord)| {
            let text = record.get(at).unwrap_or_default();
            if text.is_empty() {
                return Ok(f64::NAN);
            }
            text.parse().map_err(|_| {
                let place = format!("row {}, column {name}", row + 1);
                malformed(&self.path, place, &format!("{text:?} is not a number"))
            })
        };
        let numbers = self.records.iter().enumerate().map(number);
        let unit = self.columns[at].1.clone();
        Ok(Some((unit, numbers.collect::<Result<_, _>>()?)))
    }
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
