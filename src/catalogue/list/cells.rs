//! A table of cells that are texts.

use std::path::PathBuf;

use vis2cat_formats::ReadError;

use super::{Raw, malformed};

/// Columns with names and units, and rows of texts.
pub(super) struct CellTable {
    pub(super) path: PathBuf,
    /// Name and unit.
    pub(super) columns: Vec<(String, Option<String>)>,
    /// Rows may be shorter than there are columns: what is missing is empty.
    pub(super) rows: Vec<Vec<String>>,
}

impl CellTable {
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

    fn column(&self, at: usize) -> impl Iterator<Item = &str> {
        let rows = self.rows.iter();
        rows.map(move |row| row.get(at).map_or("", String::as_str))
    }

    /// The cells of the column `name`, in any case.
    pub(super) fn strings(&self, name: &str) -> Result<Option<Vec<String>>, ReadError> {
        let column = self.find(name)?;
        Ok(column.map(|at| self.column(at).map(str::to_owned).collect()))
    }

    /// Unit and numbers of the column `name`, in any case; an empty cell is NaN.
    pub(super) fn numbers(&self, name: &str) -> Result<Option<Raw>, ReadError> {
        let Some(at) = self.find(name)? else {
            return Ok(None);
        };
        let number = |(row, text): (usize, &str)| {
            if text.is_empty() {
                return Ok(f64::NAN);
            }
            text.parse().map_err(|_| {
                let place = format!("row {}, column {name}", row + 1);
                malformed(&self.path, place, &format!("{text:?} is not a number"))
            })
        };
        let numbers = self.column(at).enumerate().map(number);
        let unit = self.columns[at].1.clone();
        Ok(Some((unit, numbers.collect::<Result<_, _>>()?)))
    }
}
