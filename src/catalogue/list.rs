//! A table of numbers with units: a binary table of a FITS file, a VOTable, or comma-separated values.

mod cells;
mod csv_table;
mod units;
mod vo_table;

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use vis2cat_formats::ReadError;
use vis2cat_formats::fits::{Table, Value, find_table, is_fits, read_table};

use self::cells::CellTable;
pub(super) use self::units::Unit;

/// A column's unit as the file gives it, and its values.
type Raw = (Option<String>, Vec<f64>);

/// A table whose columns are asked for by name, in any case, and come in radians and janskys.
pub(super) struct ListTable {
    path: PathBuf,
    /// The table's name, where it was asked for by name.
    name: Option<&'static str>,
    kind: Kind,
}

enum Kind {
    Fits(Box<Table>),
    Cells(CellTable),
}

impl ListTable {
    /// The first binary table of a FITS file, the first table of a VOTable, or the rows of a CSV file.
    pub(super) fn open(path: &Path) -> Result<Self, ReadError> {
        let kind = if is_fits(path)? {
            Kind::Fits(Box::new(read_table(path, None)?))
        } else if is_xml(path)? {
            Kind::Cells(vo_table::read(path)?)
        } else {
            Kind::Cells(csv_table::read(path)?)
        };
        Ok(Self {
            path: path.into(),
            name: None,
            kind,
        })
    }

    /// The binary table called `name`, if the file is FITS and has one.
    pub(super) fn find(path: &Path, name: &'static str) -> Result<Option<Self>, ReadError> {
        if !is_fits(path)? {
            return Ok(None);
        }
        let table = find_table(path, Some(name))?;
        Ok(table.map(|table| Self {
            path: path.into(),
            name: Some(name),
            kind: Kind::Fits(Box::new(table)),
        }))
    }

    pub(super) fn rows(&self) -> usize {
        match &self.kind {
            Kind::Fits(table) => table.rows(),
            Kind::Cells(table) => table.rows.len(),
        }
    }

    /// The value of a header keyword.
    pub(super) fn keyword(&self, key: &str) -> Option<&Value> {
        match &self.kind {
            Kind::Fits(table) => table.keyword(key),
            Kind::Cells(_) => None,
        }
    }

    /// Whether there is a column `name`.
    pub(super) fn has(&self, name: &str) -> bool {
        match &self.kind {
            Kind::Fits(table) => table.column(name).is_some(),
            Kind::Cells(table) => table.has(name),
        }
    }

    /// The column `name` in radians, janskys or as it is, if there is one.
    pub(super) fn column(&self, name: &str, unit: Unit) -> Result<Option<Vec<f64>>, ReadError> {
        let Some((given, mut values)) = self.raw(name)? else {
            return Ok(None);
        };
        let factor = unit.factor(given.as_deref());
        let factor = factor.map_err(|what| self.malformed(&format!("column {name}"), &what))?;
        for value in &mut values {
            *value *= factor;
        }
        Ok(Some(values))
    }

    /// The column `name`, or `default` in every row.
    pub(super) fn column_or(
        &self,
        name: &str,
        unit: Unit,
        default: f64,
    ) -> Result<Vec<f64>, ReadError> {
        let column = self.column(name, unit)?;
        Ok(column.unwrap_or_else(|| vec![default; self.rows()]))
    }

    /// The column `name`, which must be there.
    pub(super) fn need(&self, name: &str, unit: Unit) -> Result<Vec<f64>, ReadError> {
        self.column(name, unit)?.ok_or_else(|| self.missing(name))
    }

    /// The flux densities, which must be there: `Total_flux`, else `flux`.
    pub(super) fn need_flux(&self) -> Result<Vec<f64>, ReadError> {
        match self.column("Total_flux", Unit::FLUX)? {
            Some(flux_jy) => Ok(flux_jy),
            None => (self.column("flux", Unit::FLUX)?).ok_or_else(|| self.missing("Total_flux")),
        }
    }

    /// The texts of column `name`, if there is one.
    pub(super) fn strings(&self, name: &str) -> Result<Option<Vec<String>>, ReadError> {
        match &self.kind {
            Kind::Fits(table) if table.column(name).is_none() => Ok(None),
            Kind::Fits(table) => table.strings(name).map(Some),
            Kind::Cells(table) => table.strings(name),
        }
    }

    /// An error at `place` in this table.
    pub(super) fn malformed(&self, place: &str, what: &str) -> ReadError {
        let place = match self.name {
            Some(name) => format!("{name}, {place}"),
            None => place.to_owned(),
        };
        malformed(&self.path, place, what)
    }

    fn missing(&self, name: &str) -> ReadError {
        let what = match self.name {
            Some(_) => "there is none",
            None => "there is none; RA, DEC and Total_flux are needed",
        };
        self.malformed(&format!("column {name}"), what)
    }

    fn raw(&self, name: &str) -> Result<Option<Raw>, ReadError> {
        match &self.kind {
            Kind::Cells(table) => table.numbers(name),
            Kind::Fits(table) => {
                let Some(column) = table.column(name) else {
                    return Ok(None);
                };
                Ok(Some((column.unit.clone(), table.numbers(name)?)))
            }
        }
    }
}

/// Whether the file starts as XML does.
fn is_xml(path: &Path) -> Result<bool, ReadError> {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(64).read_to_end(&mut start));
    read.map_err(|source| ReadError::Io {
        path: path.into(),
        source,
    })?;
    let text = String::from_utf8_lossy(&start);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    Ok(text.starts_with("<?xml") || text.starts_with("<VOTABLE"))
}

pub(super) fn malformed(path: &Path, place: String, what: &str) -> ReadError {
    ReadError::Malformed {
        path: path.into(),
        place,
        what: what.to_owned(),
    }
}
