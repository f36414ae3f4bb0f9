//! A table that is written.

use std::path::Path;

use rubbl_casatables::{
    Array, CasaDataType, CasaScalarData, GlueDataType, Table, TableCreateMode, TableDesc,
    TableDescCreateMode, TableError, TableRecord,
};

use super::{Handle, Value, lock, words};

/// Buckets of a storage manager that are kept in memory: 32 rows of all its columns each.
const N_BUCKET: u64 = 256;

/// What the cells of a column are.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    Bool,
    Int,
    Float,
    Double,
    Complex,
    Text,
}

/// A column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    name: &'static str,
    kind: Kind,
    cells: Cells,
    unit: Option<(&'static str, usize)>,
    measure: Option<(&'static str, &'static str)>,
}

/// The shape of the cells.
#[derive(Debug, Clone, Copy)]
enum Cells {
    One,
    /// The lengths of the axes, slowest first.
    Fixed(&'static [u64]),
    /// As many axes, of any lengths.
    Any(u64),
}

impl Column {
    /// A column of one value a row.
    pub(crate) const fn one(name: &'static str, kind: Kind) -> Self {
        Self::new(name, kind, Cells::One)
    }

    /// A column of arrays of a shape.
    pub(crate) const fn fixed(name: &'static str, kind: Kind, shape: &'static [u64]) -> Self {
        Self::new(name, kind, Cells::Fixed(shape))
    }

    /// A column of arrays of that many axes.
    pub(crate) const fn any(name: &'static str, kind: Kind, n_axis: u64) -> Self {
        Self::new(name, kind, Cells::Any(n_axis))
    }

    const fn new(name: &'static str, kind: Kind, cells: Cells) -> Self {
        Self {
            name,
            kind,
            cells,
            unit: None,
            measure: None,
        }
    }

    /// With the unit of its values, which is told once for each of `count` elements.
    pub(crate) const fn unit(mut self, unit: &'static str, count: usize) -> Self {
        self.unit = Some((unit, count));
        self
    }

    /// With what is measured, and the frame that it is measured in.
    pub(crate) const fn measure(mut self, what: &'static str, frame: &'static str) -> Self {
        self.measure = Some((what, frame));
        self
    }

    fn data_type(&self) -> GlueDataType {
        match self.kind {
            Kind::Bool => GlueDataType::TpBool,
            Kind::Int => GlueDataType::TpInt,
            Kind::Float => GlueDataType::TpFloat,
            Kind::Double => GlueDataType::TpDouble,
            Kind::Complex => GlueDataType::TpComplex,
            Kind::Text => GlueDataType::TpString,
        }
    }

    fn describe(&self, table: &mut TableDesc) -> Result<(), TableError> {
        let (kind, name) = (self.data_type(), self.name);
        match self.cells {
            Cells::One => table.add_scalar_column(kind, name, None, false, false),
            Cells::Fixed(shape) => {
                table.add_array_column(kind, name, None, Some(shape), true, false)
            }
            Cells::Any(n_axis) => {
                table.add_array_column(kind, name, None, None, false, false)?;
                table.set_ndims(name, n_axis)
            }
        }
    }

    fn explain(&self, table: &mut Table) -> Result<(), TableError> {
        if let Some((unit, count)) = self.unit {
            let units = vec![unit.to_owned(); count];
            table.put_column_keyword(self.name, "QuantumUnits", &units)?;
        }
        if let Some((what, frame)) = self.measure {
            let mut info = TableRecord::new()?;
            info.put_field("type", &what.to_owned())?;
            info.put_field("Ref", &frame.to_owned())?;
            table.put_column_keyword(self.name, "MEASINFO", &info)?;
        }
        Ok(())
    }
}

/// A table that is being written; errors are in words that name it.
pub(crate) struct NewTable {
    name: String,
    handle: Handle,
    n_row: u64,
}

impl std::fmt::Debug for NewTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (f.debug_struct("NewTable").field("name", &self.name)).finish_non_exhaustive()
    }
}

impl NewTable {
    /// Makes a table without rows.
    pub(crate) fn create(path: &Path, name: &str, columns: &[Column]) -> Result<Self, String> {
        let made = {
            let _alone = lock();
            create(path, columns).map_err(|e| format!("table {name}: {}", words(&e)))?
        };
        Ok(Self {
            name: name.to_owned(),
            handle: Handle::new(made),
            n_row: 0,
        })
    }

    /// Adds a column of matrices of which many rows are stored together in tiles of that shape
    /// (rows, slow axis, fast axis).
    pub(crate) fn add_tiled(&mut self, column: &Column, tile: [u64; 3]) -> Result<(), String> {
        let storage = format!("Tiled{}", column.name);
        self.call(column.name, |table| {
            let (kind, name) = (column.data_type(), column.name);
            table.add_tiled_array_column(kind, name, None, &tile[1..], &tile, &storage, false)?;
            column.explain(table)
        })
    }

    /// Adds rows of zeros, empty texts and no arrays; returns the first of them.
    pub(crate) fn add_rows(&mut self, count: usize) -> Result<u64, String> {
        self.call("", |table| Ok(table.add_rows(count)?))?;
        let first = self.n_row;
        self.n_row += count as u64;
        Ok(first)
    }

    /// Sets a cell.
    pub(crate) fn put<T: CasaDataType>(
        &mut self,
        column: &str,
        row: u64,
        value: &T,
    ) -> Result<(), String> {
        self.call(column, |table| Ok(table.put_cell(column, row, value)?))
    }

    /// Sets a cell to a matrix, of that many values a line.
    pub(crate) fn put_matrix<T: Value>(
        &mut self,
        column: &str,
        row: u64,
        values: &[T],
        n_fast: usize,
    ) -> Result<(), String> {
        let shape = (values.len() / n_fast.max(1), n_fast);
        let matrix = Array::from_shape_vec(shape, values.to_vec()).map_err(|e| e.to_string())?;
        self.put(column, row, &matrix)
    }

    /// Sets the cells from `row` on to one value each.
    pub(crate) fn put_range<T: CasaScalarData>(
        &mut self,
        column: &str,
        row: u64,
        values: &[T],
    ) -> Result<(), String> {
        self.call(column, |table| {
            Ok(table.put_column_range_scalar(column, row, values)?)
        })
    }

    /// Sets the cells from `row` on to vectors of `len` values.
    pub(crate) fn put_vectors<T: Value>(
        &mut self,
        column: &str,
        row: u64,
        values: Vec<T>,
        len: usize,
    ) -> Result<(), String> {
        let shape = (values.len() / len.max(1), len);
        let array = Array::from_shape_vec(shape, values).map_err(|e| e.to_string())?;
        self.call(column, |table| {
            Ok(table.put_column_range_array(column, row, &array)?)
        })
    }

    /// Sets the cells from `row` on to matrices of that shape.
    pub(crate) fn put_matrices<T: Value>(
        &mut self,
        column: &str,
        row: u64,
        values: Vec<T>,
        (n_slow, n_fast): (usize, usize),
    ) -> Result<(), String> {
        let n_row = values.len() / (n_slow * n_fast).max(1);
        let array = Array::from_shape_vec((n_row, n_slow, n_fast), values);
        let array = array.map_err(|e| e.to_string())?;
        self.call(column, |table| {
            Ok(table.put_column_range_array(column, row, &array)?)
        })
    }

    /// Sets a keyword of the table.
    pub(crate) fn put_keyword<T: CasaDataType>(
        &mut self,
        name: &str,
        value: &T,
    ) -> Result<(), String> {
        self.call(name, |table| Ok(table.put_keyword(name, value)?))
    }

    /// Sets a keyword of a column.
    pub(crate) fn put_column_keyword<T: CasaDataType>(
        &mut self,
        column: &str,
        name: &str,
        value: &T,
    ) -> Result<(), String> {
        self.call(column, |table| {
            Ok(table.put_column_keyword(column, name, value)?)
        })
    }

    /// Sets a record of keywords of a column, all texts but for the numbers of `codes`.
    pub(crate) fn put_reference_column(
        &mut self,
        column: &str,
        what: &str,
        codes_in: &str,
        codes: &[(u32, &str)],
    ) -> Result<(), String> {
        self.call(column, |table| {
            let mut info = TableRecord::new()?;
            info.put_field("type", &what.to_owned())?;
            info.put_field("VarRefCol", &codes_in.to_owned())?;
            let types: Vec<String> = codes.iter().map(|(_, name)| (*name).to_owned()).collect();
            let numbers: Vec<u32> = codes.iter().map(|(code, _)| *code).collect();
            info.put_field("TabRefTypes", &types)?;
            info.put_field("TabRefCodes", &numbers)?;
            Ok(table.put_column_keyword(column, "MEASINFO", &info)?)
        })
    }

    /// Makes another table known as a part of this one.
    pub(crate) fn attach(&mut self, part: NewTable) -> Result<(), String> {
        let NewTable {
            name, mut handle, ..
        } = part;
        let Some(table) = handle.table.take() else {
            return Ok(());
        };
        self.call(&name, |main| Ok(main.put_table_keyword(&name, table)?))
    }

    fn call<T>(
        &mut self,
        place: &str,
        call: impl FnOnce(&mut Table) -> Result<T, TableError>,
    ) -> Result<T, String> {
        let name = &self.name;
        (self.handle.with(call)).map_err(|what| format!("table {name}, {place}: {what}"))
    }
}

fn create(path: &Path, columns: &[Column]) -> Result<Table, TableError> {
    let mut description = TableDesc::new("", TableDescCreateMode::TDM_SCRATCH)?;
    for column in columns {
        column.describe(&mut description)?;
    }
    let mut table = Table::new(path, description, 0, TableCreateMode::NewNoReplace)?;
    for column in columns {
        column.explain(&mut table)?;
    }
    table.set_standard_stman_cache_size("StandardStMan", N_BUCKET)?;
    Ok(table)
}
