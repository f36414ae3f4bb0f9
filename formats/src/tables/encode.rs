//! Tables as bytes: headers, big-endian rows, sums.

use std::io::{self, Write};
use std::path::Path;

use super::card::{Keyword, Value, end_card, text_cards, to_ascii};
use super::checksum::{BLANK, Checksum, encode as encode_checksum};
use super::pending::PendingFile;
use super::table::{Cards, Column, ColumnData, TableSpec};
use super::{BLOCK, CARD};
use crate::WriteError;

/// Most columns of a table (FITS 4.0 section 7.3.1).
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
    let fault = check_cards(primary).or_else(|| tables.iter().find_map(check_table));
    if let Some(what) = fault {
        return Err(WriteError::Parameter {
            path: path.into(),
            what,
        });
    }
    PendingFile::prepare(path, overwrite, |out| {
        write_hdu(out, &primary_keywords(), primary, None)?;
        for table in tables {
            let columns: Vec<Encoder> = table.columns.iter().map(Encoder::new).collect();
            let structure = table_keywords(table, &columns);
            write_hdu(
                out,
                &structure,
                &table.cards,
                Some((&columns, table.rows())),
            )?;
        }
        Ok(())
    })
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

fn check_cards(cards: &Cards) -> Option<String> {
    cards.keywords.iter().find_map(Keyword::fault)
}

/// Why `table` cannot be written, if it cannot.
fn check_table(table: &TableSpec) -> Option<String> {
    let name = &table.extname;
    if table.columns.len() > MAX_COLUMNS {
        return Some(format!("table {name} has more than {MAX_COLUMNS} columns"));
    }
    for (i, column) in table.columns.iter().enumerate() {
        let legal = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let at = format!("table {name}, column {:?}", column.name);
        if column.name.is_empty() || !column.name.chars().all(legal) {
            return Some(format!("{at}: a name has letters, digits and _ only"));
        }
        if table.columns[..i]
            .iter()
            .any(|c| c.name.eq_ignore_ascii_case(&column.name))
        {
            return Some(format!("{at} stands twice"));
        }
        if column.data.len() != table.rows() {
            let (rows, first) = (column.data.len(), table.rows());
            return Some(format!("{at} has {rows} rows, the first column {first}"));
        }
        if let ColumnData::I64 { values, null } = &column.data
            && values
                .iter()
                .any(|v| v.is_none() && null.is_none() || v.is_some() && v == null)
        {
            return Some(format!(
                "{at}: a value is missing without a null, or equals it"
            ));
        }
    }
    check_cards(&table.cards)
}

fn primary_keywords() -> Vec<Keyword> {
    vec![
        Keyword::new("SIMPLE", true, "FITS standard 4.0"),
        Keyword::new("BITPIX", 8_i64, "no data in this HDU"),
        Keyword::new("NAXIS", 0_i64, "no data in this HDU"),
        Keyword::new("EXTEND", true, "tables follow"),
    ]
}

/// The keywords that say how the rows are laid out, and what the columns mean.
fn table_keywords(table: &TableSpec, columns: &[Encoder]) -> Vec<Keyword> {
    let width: usize = columns.iter().map(|c| c.width).sum();
    let mut keywords = vec![
        Keyword::new("XTENSION", "BINTABLE", "binary table"),
        Keyword::new("BITPIX", 8_i64, "bytes"),
        Keyword::new("NAXIS", 2_i64, "columns and rows"),
        Keyword::new("NAXIS1", width, "bytes in a row"),
        Keyword::new("NAXIS2", table.rows(), "rows"),
        Keyword::new("PCOUNT", 0_i64, "no heap"),
        Keyword::new("GCOUNT", 1_i64, "one table"),
        Keyword::new("TFIELDS", table.columns.len(), "columns"),
        Keyword::new("EXTNAME", to_ascii(&table.extname), "name of this table"),
    ];
    for (i, encoder) in columns.iter().enumerate() {
        column_keywords(&mut keywords, i + 1, encoder);
    }
    keywords
}

fn column_keywords(keywords: &mut Vec<Keyword>, n: usize, encoder: &Encoder) {
    let column = encoder.column;
    let mut push = |key: &str, value: Value, comment: &str| {
        keywords.push(Keyword::new(&format!("{key}{n}"), value, comment));
    };
    push("TTYPE", column.name.as_str().into(), "");
    push("TFORM", encoder.form.as_str().into(), "");
    if let Some(unit) = &column.unit {
        push("TUNIT", unit.as_str().into(), "");
    }
    if let ColumnData::I64 {
        null: Some(null), ..
    } = column.data
    {
        push("TNULL", null.into(), "missing");
    }
    if let Some(ucd) = &column.ucd {
        push("TUCD", ucd.as_str().into(), "");
    }
    if !column.description.is_empty() {
        push("TCOMM", column.description.as_str().into(), "");
    }
}

/// Writes header and rows with their sums.
fn write_hdu(
    out: &mut dyn Write,
    structure: &[Keyword],
    cards: &Cards,
    data: Option<(&[Encoder], usize)>,
) -> io::Result<()> {
    let mut data_sum = Checksum::default();
    if let Some((columns, rows)) = data {
        write_rows(&mut data_sum, columns, rows)?;
    }
    let mut header = header_cards(structure, cards);
    let checksum_at = header.len();
    header.extend(checksum_card(BLANK));
    let data_sum = data_sum.value();
    let sum_text = data_sum.to_string();
    let sum_card = Keyword::new("DATASUM", sum_text, "data unit sum");
    header.extend(sum_card.cards().concat());
    header.extend(end_card());
    pad(&mut header, b' ');
    let mut sum = Checksum::default();
    sum.write_all(&header)?;
    sum.write_all(&data_sum.to_be_bytes())?;
    header[checksum_at..checksum_at + CARD]
        .copy_from_slice(&checksum_card(&encode_checksum(sum.value())));
    out.write_all(&header)?;
    match data {
        Some((columns, rows)) => write_rows(out, columns, rows),
        None => Ok(()),
    }
}

fn header_cards(structure: &[Keyword], cards: &Cards) -> Vec<u8> {
    let keywords = structure.iter().chain(&cards.keywords);
    let comments = cards.comments.iter().map(|text| ("COMMENT", text));
    let history = cards.history.iter().map(|text| ("HISTORY", text));
    let mut bytes = Vec::new();
    let mut announced = false;
    for keyword in keywords {
        let cards = keyword.cards();
        if cards.len() > 1 && !announced {
            // No part of FITS 4.0, but checkers of older conventions ask for it.
            let note = Keyword::new("LONGSTRN", "OGIP 1.0", "strings may continue");
            bytes.extend(note.cards().concat());
            announced = true;
        }
        bytes.extend(cards.concat());
    }
    for (key, text) in comments.chain(history) {
        bytes.extend(text_cards(key, text).concat());
    }
    bytes
}

fn checksum_card(code: &str) -> [u8; CARD] {
    Keyword::new("CHECKSUM", code, "HDU checksum").cards()[0]
}

fn pad(bytes: &mut Vec<u8>, with: u8) {
    bytes.resize(bytes.len().next_multiple_of(BLOCK), with);
}

/// Writes all rows, and zeros up to the end of the block.
fn write_rows(out: &mut dyn Write, columns: &[Encoder], rows: usize) -> io::Result<()> {
    let mut row = Vec::new();
    let mut written = 0_usize;
    for i in 0..rows {
        row.clear();
        for column in columns {
            column.put(i, &mut row);
        }
        out.write_all(&row)?;
        written += row.len();
    }
    out.write_all(&vec![0; written.next_multiple_of(BLOCK) - written])
}

/// A column with its place in a row worked out.
struct Encoder<'a> {
    column: &'a Column,
    /// `TFORMn` (FITS 4.0 table 18).
    form: String,
    /// Bytes in a row.
    width: usize,
}

impl<'a> Encoder<'a> {
    fn new(column: &'a Column) -> Self {
        let (form, width) = match &column.data {
            ColumnData::F64(_) => ("D".to_owned(), 8),
            ColumnData::F32(_) => ("E".to_owned(), 4),
            ColumnData::I64 { .. } => ("K".to_owned(), 8),
            ColumnData::I32(_) => ("J".to_owned(), 4),
            ColumnData::Bool(_) => ("L".to_owned(), 1),
            ColumnData::Str(values) => {
                let longest = values.iter().map(|s| s.chars().count()).max();
                let width = longest.unwrap_or(0).max(1);
                (format!("{width}A"), width)
            }
        };
        Self {
            column,
            form,
            width,
        }
    }

    fn put(&self, i: usize, row: &mut Vec<u8>) {
        match &self.column.data {
            ColumnData::F64(v) => row.extend(v[i].to_be_bytes()),
            ColumnData::F32(v) => row.extend(v[i].to_be_bytes()),
            ColumnData::I64 { values, null } => {
                let value = values[i].or(*null).unwrap_or_default();
                row.extend(value.to_be_bytes());
            }
            ColumnData::I32(v) => row.extend(v[i].to_be_bytes()),
            ColumnData::Bool(v) => row.push(if v[i] { b'T' } else { b'F' }),
            ColumnData::Str(v) => {
                let text = to_ascii(&v[i]);
                row.extend(text.bytes());
                row.resize(row.len() + self.width - text.len(), 0);
            }
        }
    }
}
