//! What a binary table consists of, before it becomes bytes.

use super::card::Keyword;

/// The free part of a header: keywords, then comments, then history.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cards {
    /// Keywords in the order they are written.
    pub keywords: Vec<Keyword>,
    /// `COMMENT` lines; long ones are split.
    pub comments: Vec<String>,
    /// `HISTORY` lines; long ones are split.
    pub history: Vec<String>,
}

/// One binary table with its header.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TableSpec {
    /// `EXTNAME`.
    pub extname: String,
    /// Columns of equal length, in order.
    pub columns: Vec<Column>,
    /// The rest of the header.
    pub cards: Cards,
}

/// One column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// `TTYPEn`.
    pub name: String,
    /// `TUNITn`, as FITS 4.0 section 4.3 spells units.
    pub unit: Option<String>,
    /// `TUCDn`: what the column means, in words of the IVOA list UCD1+.
    pub ucd: Option<String>,
    /// `TCOMMn`: the same for people.
    pub description: String,
    /// The values.
    pub data: ColumnData,
}

/// Values of a column, one a row.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnData {
    /// 8-byte floats; NaN where missing.
    F64(Vec<f64>),
    /// 4-byte floats; NaN where missing.
    F32(Vec<f32>),
    /// 8-byte integers; `None` where missing, written as `null` under `TNULLn`.
    I64 {
        /// Value of each row.
        values: Vec<Option<i64>>,
        /// The number that stands for a missing one; without it none may be missing.
        null: Option<i64>,
    },
    /// 4-byte integers, none missing.
    I32(Vec<i32>),
    /// Truth values.
    Bool(Vec<bool>),
    /// Strings; the column is as wide as the longest. Characters outside ASCII are replaced.
    Str(Vec<String>),
}

impl ColumnData {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::I64 { values, .. } => values.len(),
            Self::I32(v) => v.len(),
            Self::Bool(v) => v.len(),
            Self::Str(v) => v.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl TableSpec {
    /// Number of rows: that of the first column.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.data.len())
    }
}
