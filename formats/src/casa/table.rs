//! A table that is read.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use rubbl_casatables::{TableError, TableOpenMode, TableRecord};

use super::cell::{Cell, Value};
use super::range::{Ranges, Read};
use super::{Handle, lock, stored, words};
use crate::ReadError;

/// What the main table is called in messages.
const MAIN: &str = "MAIN";

/// A table, open for reading.
pub(crate) struct Table {
    /// The directory of the main table.
    root: PathBuf,
    /// `MAIN`, or the name of a subtable.
    name: String,
    handle: Handle,
    /// For reading many cells at once.
    ranges: Ranges,
    columns: BTreeSet<String>,
    /// Rows.
    pub(crate) n_row: u64,
}

impl std::fmt::Debug for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Table")
            .field("root", &self.root)
            .field("name", &self.name)
            .field("n_row", &self.n_row)
            .finish_non_exhaustive()
    }
}

/// What the values of a column refer to: its keyword `MEASINFO`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Reference {
    /// The reference frame of all rows.
    pub(crate) frame: Option<String>,
    /// The column that holds a code for the frame of each row.
    pub(crate) column: Option<String>,
    /// What the codes mean, where that is said.
    pub(crate) codes: Vec<(u32, String)>,
}

impl Table {
    /// Opens the main table.
    pub(crate) fn open(root: &Path) -> Result<Self, ReadError> {
        Self::open_in(root, MAIN, root)
    }

    /// Opens a subtable.
    pub(crate) fn open_sub(root: &Path, name: &str) -> Result<Self, ReadError> {
        Self::open_in(root, name, &root.join(name))
    }

    fn open_in(root: &Path, name: &str, path: &Path) -> Result<Self, ReadError> {
        let malformed = |what: String| ReadError::Malformed {
            path: root.to_owned(),
            place: format!("table {name}"),
            what,
        };
        if !path.join("table.dat").is_file() {
            return Err(malformed("is missing: there is no table.dat of it".into()));
        }
        stored::check(path).map_err(|what| malformed(unreadable(&what)))?;
        // First as we open it: there casacore may throw what it will.
        let ranges = Ranges::open(path).map_err(|what| malformed(unreadable(&what)))?;
        let opened = {
            let _alone = lock();
            rubbl_casatables::Table::open(path, TableOpenMode::Read).map_err(|e| words(&e))
        };
        let mut handle = Handle::new(opened.map_err(|what| malformed(unreadable(&what)))?);
        let known = handle.with(|table| Ok((table.column_names()?, table.n_rows())));
        let (columns, n_row) = known.map_err(|what| malformed(unreadable(&what)))?;
        Ok(Self {
            columns: columns.into_iter().collect(),
            n_row,
            root: root.to_owned(),
            name: name.to_owned(),
            handle,
            ranges,
        })
    }

    /// The directory in which the subtables are: the main table's, or, where that refers to rows of another set, as
    /// a selection does, that of the other.
    pub(crate) fn home(&self) -> Result<PathBuf, ReadError> {
        if self.root.join("ANTENNA").is_dir() {
            return Ok(self.root.clone());
        }
        let other = self.ranges.named(c"ANTENNA");
        let Some(home) = other.as_deref().and_then(Path::parent) else {
            return Err(self.malformed("has no subtables: there is no table ANTENNA"));
        };
        Ok(home.to_owned())
    }

    /// Whether there is a column of that name.
    pub(crate) fn has(&self, column: &str) -> bool {
        self.columns.contains(column)
    }

    /// The value of a cell that must hold one.
    pub(crate) fn scalar<T: Value>(&mut self, column: &str, row: u64) -> Result<T, ReadError> {
        let cell = self.cell::<T>(column, row)?;
        match (cell.shape.as_slice(), cell.values.as_slice()) {
            ([], &[value]) => Ok(value),
            (shape, _) => {
                let what = format!("has shape {shape:?}, must be one value");
                Err(self.cell_error(column, row, what))
            }
        }
    }

    /// The values of a cell and the lengths of its axes, slowest first.
    pub(crate) fn array<T: Value>(
        &mut self,
        column: &str,
        row: u64,
    ) -> Result<(Vec<u64>, Vec<T>), ReadError> {
        let cell = self.cell::<T>(column, row)?;
        if cell.shape.is_empty() {
            return Err(self.cell_error(column, row, "must be an array".into()));
        }
        Ok((cell.shape, cell.values))
    }

    /// The values of a cell that must have that shape, slowest axis first.
    pub(crate) fn shaped<T: Value>(
        &mut self,
        column: &str,
        row: u64,
        wanted: &[usize],
    ) -> Result<Vec<T>, ReadError> {
        let (shape, values) = self.array(column, row)?;
        if !shape
            .iter()
            .copied()
            .eq(wanted.iter().map(|&len| len as u64))
        {
            let what = format!("has shape {shape:?}, must be {wanted:?}");
            return Err(self.cell_error(column, row, what));
        }
        Ok(values)
    }

    /// The values of the cells of some rows, which must all have that shape, slowest axis first; none
    /// where a cell is one value.
    pub(crate) fn rows<T: Value>(
        &mut self,
        column: &str,
        rows: Range<u64>,
        shape: &[usize],
    ) -> Result<Vec<T>, ReadError> {
        self.check_place(column, rows.end.saturating_sub(1))?;
        let per_row: usize = shape.iter().product();
        let n_row = (rows.end - rows.start) as usize;
        let mut values = vec![T::default(); n_row * per_row];
        match self.read_range(column, rows.start, shape, &mut values) {
            Read::Fine => return Ok(values),
            Read::Failed(what) => {
                self.handle.broken = Some(what.clone());
                return Err(self.cell_error(column, rows.start, unreadable(&what)));
            }
            Read::Irregular => {}
        }
        // Which cell it is, and what about it, is found one by one.
        values.clear();
        for row in rows {
            if shape.is_empty() {
                values.push(self.scalar(column, row)?);
            } else {
                values.extend(self.shaped::<T>(column, row, shape)?);
            }
        }
        Ok(values)
    }

    fn read_range<T: Value>(
        &mut self,
        column: &str,
        row: u64,
        shape: &[usize],
        values: &mut [T],
    ) -> Read {
        if let Some(why) = &self.handle.broken {
            return Read::Failed(why.clone());
        }
        self.ranges.read(column, row, shape, values)
    }

    /// The text of a cell.
    pub(crate) fn text(&mut self, column: &str, row: u64) -> Result<String, ReadError> {
        self.check_place(column, row)?;
        let text = self
            .handle
            .with(|table| table.get_cell::<String>(column, row));
        text.map_err(|what| self.cell_error(column, row, unreadable(&what)))
    }

    /// The unit of a column's values, where it says so.
    pub(crate) fn unit(&mut self, column: &str) -> Result<Option<String>, ReadError> {
        let name = "QuantumUnits";
        let units = self.keyword(column, name, |keywords| {
            // One text in some tables, one for each element of a cell in others.
            match keywords.get_field::<Vec<String>>(name) {
                Ok(units) => Ok(units),
                Err(_) => keywords.get_field::<String>(name).map(|unit| vec![unit]),
            }
        })?;
        Ok(units.and_then(|units| units.into_iter().next()))
    }

    /// What a column's values refer to; nothing where it does not say.
    pub(crate) fn reference(&mut self, column: &str) -> Result<Reference, ReadError> {
        let found = self.keyword(column, "MEASINFO", reference)?;
        Ok(found.unwrap_or_default())
    }

    /// What `read` makes of the keywords of a column, if there is one of that name.
    fn keyword<T>(
        &mut self,
        column: &str,
        name: &str,
        read: impl FnOnce(&mut TableRecord) -> Result<T, TableError>,
    ) -> Result<Option<T>, ReadError> {
        if !self.has(column) {
            return Err(self.column_error(column, "is missing".into()));
        }
        let found = self.handle.with(|table| {
            let mut keywords = table.get_column_keyword_record(column)?;
            if !keywords.keyword_names()?.iter().any(|there| there == name) {
                return Ok(None);
            }
            read(&mut keywords).map(Some)
        });
        found.map_err(|what| self.column_error(column, unreadable(&what)))
    }

    fn cell<T: Value>(&mut self, column: &str, row: u64) -> Result<Cell<T>, ReadError> {
        self.check_place(column, row)?;
        let cell = self
            .handle
            .with(|table| table.get_cell::<Cell<T>>(column, row));
        cell.map_err(|what| self.cell_error(column, row, unreadable(&what)))
    }

    fn check_place(&self, column: &str, row: u64) -> Result<(), ReadError> {
        if !self.has(column) {
            return Err(self.column_error(column, "is missing".into()));
        }
        if row >= self.n_row {
            return Err(self.malformed(format!(
                "has {} rows, no row {}",
                self.n_row,
                row.saturating_add(1)
            )));
        }
        Ok(())
    }

    /// The table is at fault.
    pub(crate) fn malformed(&self, what: impl Into<String>) -> ReadError {
        ReadError::Malformed {
            path: self.root.clone(),
            place: format!("table {}", self.name),
            what: what.into(),
        }
    }

    /// A column is at fault.
    pub(crate) fn column_error(&self, column: &str, what: String) -> ReadError {
        ReadError::Malformed {
            path: self.root.clone(),
            place: format!("table {}, column {column}", self.name),
            what,
        }
    }

    /// A cell is at fault.
    pub(crate) fn cell_error(&self, column: &str, row: u64, what: String) -> ReadError {
        ReadError::Malformed {
            path: self.root.clone(),
            place: self.cell_place(column, row),
            what,
        }
    }

    /// We cannot read what a cell says.
    pub(crate) fn unsupported(&self, column: &str, row: u64, what: String) -> ReadError {
        ReadError::Unsupported {
            path: self.root.clone(),
            place: self.cell_place(column, row),
            what,
        }
    }

    fn cell_place(&self, column: &str, row: u64) -> String {
        let Self { name, n_row, .. } = self;
        format!("table {name}, column {column}, row {} of {n_row}", row + 1)
    }
}

/// The record `MEASINFO` of a column's keywords.
fn reference(keywords: &mut TableRecord) -> Result<Reference, TableError> {
    let mut info = keywords.get_field::<TableRecord>("MEASINFO")?;
    let names = info.keyword_names()?;
    let has = |name: &str| names.iter().any(|there| there == name);
    let mut text = |name: &str| {
        let there = has(name);
        there.then(|| info.get_field::<String>(name)).transpose()
    };
    let (frame, column) = (text("Ref")?, text("VarRefCol")?);
    let mut codes = Vec::new();
    if has("TabRefCodes") {
        let numbers = info.get_field::<Vec<u32>>("TabRefCodes")?;
        let types = info.get_field::<Vec<String>>("TabRefTypes")?;
        codes = numbers.into_iter().zip(types).collect();
    }
    Ok(Reference {
        frame,
        column,
        codes,
    })
}

fn unreadable(what: &str) -> String {
    format!("cannot be read ({what})")
}
