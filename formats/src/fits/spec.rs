//! What a binary table consists of, before it becomes bytes.

use super::card::print::to_ascii;
use super::tform::Tform;
use super::{Cards, Keyword};

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

/// Values of a column, row after row.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnData {
    /// 8-byte floats; NaN where missing.
    F64(Vec<f64>),
    /// 8-byte integers; `None` where missing, written as `null` under `TNULLn`.
    I64 {
        /// Value of each row.
        values: Vec<Option<i64>>,
        /// The number that stands for a missing one; without it none may be missing.
        null: Option<i64>,
    },
    /// 4-byte integers, none missing.
    I32(Vec<i32>),
    /// Numbers stored under a `TFORMn` of their own, such as `1E` or `3D`.
    Cells {
        /// `TFORMn`.
        form: String,
        /// As many for each row as `form` says.
        values: Vec<f64>,
    },
    /// Strings; the column is as wide as the longest. Characters outside ASCII are replaced.
    Text(Vec<String>),
}

impl ColumnData {
    /// Number of rows; `None` where cells are empty.
    pub(super) fn rows(&self) -> Option<usize> {
        match self {
            Self::F64(v) => Some(v.len()),
            Self::I64 { values, .. } => Some(values.len()),
            Self::I32(v) => Some(v.len()),
            Self::Cells { form, values } => {
                let repeat = Tform::parse(form)?.repeat as usize;
                values.len().checked_div(repeat)
            }
            Self::Text(v) => Some(v.len()),
        }
    }

    /// `TFORMn` (Standard, table 18).
    pub(super) fn form(&self) -> String {
        match self {
            Self::F64(_) => "D".to_owned(),
            Self::I64 { .. } => "K".to_owned(),
            Self::I32(_) => "J".to_owned(),
            Self::Cells { form, .. } => form.clone(),
            Self::Text(values) => {
                let longest = values.iter().map(|s| s.chars().count()).max();
                format!("{}A", longest.unwrap_or(0).max(1))
            }
        }
    }
}

impl TableSpec {
    /// Number of rows: that of the first column.
    pub fn rows(&self) -> usize {
        let first = self.columns.first();
        first.and_then(|c| c.data.rows()).unwrap_or(0)
    }

    /// Bytes in a row.
    pub(super) fn row_bytes(&self) -> usize {
        let forms = self.columns.iter().map(|c| c.data.form());
        let bytes = forms.filter_map(|form| Tform::parse(&form).and_then(Tform::bytes));
        bytes.sum::<u64>() as usize
    }

    /// The whole header: layout, meaning of the columns, own cards, room for the sums.
    pub(super) fn header(&self) -> Cards {
        let mut cards = extension(self.row_bytes(), self.rows(), 0, self.columns.len());
        cards.push("EXTNAME", to_ascii(&self.extname), "name of this table");
        for (n, column) in (1..).zip(&self.columns) {
            column.describe(n, &mut cards);
        }
        cards.keywords.extend(self.cards.keywords.iter().cloned());
        cards.comments.clone_from(&self.cards.comments);
        cards.history.clone_from(&self.cards.history);
        cards
    }
}

impl Column {
    fn describe(&self, n: usize, cards: &mut Cards) {
        let mut push = |key: &str, value: &str| cards.push(&format!("{key}{n}"), value, "");
        push("TTYPE", &self.name);
        push("TFORM", &self.data.form());
        for (key, value) in [("TUNIT", &self.unit), ("TUCD", &self.ucd)] {
            if let Some(value) = value {
                push(key, value);
            }
        }
        if !self.description.is_empty() {
            push("TCOMM", &self.description);
        }
        if let ColumnData::I64 {
            null: Some(null), ..
        } = self.data
        {
            cards.push(&format!("TNULL{n}"), null, "missing");
        }
    }
}

/// The keywords that every binary table starts with.
pub(super) fn extension(row_bytes: usize, rows: usize, heap: usize, columns: usize) -> Cards {
    let keywords = vec![
        Keyword::new("XTENSION", "BINTABLE", "binary table"),
        Keyword::new("BITPIX", 8, "bytes"),
        Keyword::new("NAXIS", 2, "columns and rows"),
        Keyword::new("NAXIS1", row_bytes, "bytes in a row"),
        Keyword::new("NAXIS2", rows, "rows"),
        Keyword::new("PCOUNT", heap, "bytes behind the rows"),
        Keyword::new("GCOUNT", 1, "one table"),
        Keyword::new("TFIELDS", columns, "columns"),
    ];
    Cards {
        keywords,
        ..Cards::default()
    }
}

/// The keywords of a primary HDU without data, before tables.
pub(super) fn empty_primary() -> Cards {
    let keywords = vec![
        Keyword::new("SIMPLE", true, "FITS standard 4.0"),
        Keyword::new("BITPIX", 8, "no data in this HDU"),
        Keyword::new("NAXIS", 0, "no data in this HDU"),
        Keyword::new("EXTEND", true, "tables follow"),
    ];
    Cards {
        keywords,
        ..Cards::default()
    }
}
