//! Binary tables, whole, from and to memory, through CFITSIO.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use super::BLOCK_BYTES;
use super::card::{Cards, printable};
use super::cfitsio::{CfitsioError, MemoryFits};
use super::header::{Header, Place};
use super::scan::Hdu;
use super::tform::Tform;
use crate::ReadError;

/// Largest table that is read whole; real antenna and source tables are a thousandth of it.
const MAX_TABLE_BYTES: u64 = 256 << 20;

/// A binary table of an open file.
pub(crate) struct Table<'a> {
    /// Its header.
    pub(crate) header: &'a Header,
    /// Rows.
    pub(crate) n_row: usize,
    fits: MemoryFits,
}

/// A column of numbers.
#[derive(Debug)]
pub(crate) struct Numbers {
    /// Elements in a cell.
    pub(crate) repeat: usize,
    /// Row after row.
    pub(crate) values: Vec<f64>,
}

impl Numbers {
    /// The elements of one row.
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.repeat..(row + 1) * self.repeat]
    }
}

impl<'a> Table<'a> {
    /// Takes the table of `hdu`, which the scan has measured, into memory.
    pub(crate) fn read(file: &mut File, hdu: &'a Hdu) -> Result<Self, ReadError> {
        let place = &hdu.header.place;
        if hdu.header.text("XTENSION") != Some("BINTABLE") {
            return Err(place.malformed("XTENSION", "must be a BINTABLE"));
        }
        let bytes = hdu.data_bytes;
        if bytes > MAX_TABLE_BYTES {
            let what = format!("has {bytes} bytes, more than {MAX_TABLE_BYTES} are not read");
            return Err(place.unsupported("NAXIS2", what));
        }
        let mut image = clean_header(hdu)?;
        let whole = image.len() + (bytes as usize).next_multiple_of(BLOCK_BYTES);
        file.seek(SeekFrom::Start(hdu.data_offset))
            .map_err(|e| place.io(e))?;
        file.by_ref()
            .take(bytes)
            .read_to_end(&mut image)
            .map_err(|e| place.io(e))?;
        image.resize(whole, 0);
        let row_bytes = hdu.axes[0];
        let n_row = if row_bytes == 0 {
            0
        } else {
            hdu.axes[1] as usize
        };
        Ok(Self {
            header: &hdu.header,
            n_row,
            fits: MemoryFits::open(image).map_err(|e| refused(place, "table", &e))?,
        })
    }

    /// A column of numbers; `None` where there is none of that name.
    pub(crate) fn numbers(&mut self, name: &str) -> Result<Option<Numbers>, ReadError> {
        let Some((column, tform)) = self.column(name) else {
            return Ok(None);
        };
        let place = &self.header.place;
        if !tform.is_number() {
            let what = format!(
                "column {column} holds type {}, not numbers",
                tform.letter as char
            );
            return Err(place.malformed(name, what));
        }
        let repeat = tform.repeat as usize;
        let count = repeat * self.n_row;
        let values = if count == 0 {
            Vec::new()
        } else {
            self.fits
                .read_numbers(column, count)
                .map_err(|e| refused(place, name, &e))?
        };
        Ok(Some(Numbers { repeat, values }))
    }

    /// A column of numbers that must be there with at least `repeat` elements in each cell.
    pub(crate) fn need_numbers(&mut self, name: &str, repeat: usize) -> Result<Numbers, ReadError> {
        let place = &self.header.place;
        match self.numbers(name)? {
            None => Err(place.malformed(name, "column is missing")),
            Some(numbers) if numbers.repeat < repeat => {
                let found = numbers.repeat;
                let what = format!("column has {found} elements a row, needs {repeat}");
                Err(place.malformed(name, what))
            }
            Some(numbers) => Ok(numbers),
        }
    }

    /// A column of strings, unprintable bytes dropped; `None` where there is none of that name.
    pub(crate) fn texts(&mut self, name: &str) -> Result<Option<Vec<String>>, ReadError> {
        let Some((column, tform)) = self.column(name) else {
            return Ok(None);
        };
        let place = &self.header.place;
        if tform.letter != b'A' {
            let what = format!(
                "column {column} holds type {}, not text",
                tform.letter as char
            );
            return Err(place.malformed(name, what));
        }
        let mut texts = Vec::new();
        if tform.repeat == 0 {
            return Ok(None);
        }
        for row in 0..self.n_row {
            let mut text = self
                .fits
                .read_text(column, row, tform.repeat as usize)
                .map_err(|e| refused(place, name, &e))?;
            text.retain(|b| (b' '..=b'~').contains(b));
            texts.push(printable(&text).trim().to_owned());
        }
        Ok(Some(texts))
    }

    /// Number, from 1, and format of the column of that name.
    fn column(&self, name: &str) -> Option<(usize, Tform)> {
        let n_column = self.header.integer("TFIELDS").ok().flatten().unwrap_or(0) as usize;
        let is_it = |i: &usize| {
            self.header
                .text(&format!("TTYPE{i}"))
                .is_some_and(|text| text.trim().eq_ignore_ascii_case(name))
        };
        let column = (1..=n_column).find(is_it)?;
        let tform = Tform::parse(self.header.text(&format!("TFORM{column}"))?)?;
        Some((column, tform))
    }
}

fn refused(place: &Place, at: &str, error: &CfitsioError) -> ReadError {
    place.malformed(at, error.0.clone())
}

/// The headers of a file that is only this table, written anew from what the scan has checked.
///
/// CFITSIO never sees the file's own header: of the many keywords that it acts upon, some divide
/// by zero when they are wrong. Columns that are neither numbers nor text are declared as bytes.
fn clean_header(hdu: &Hdu) -> Result<Vec<u8>, ReadError> {
    let header = &hdu.header;
    let mut cards = Cards::default();
    cards.logical("SIMPLE", true, "");
    cards.integer("BITPIX", 8, "");
    cards.integer("NAXIS", 0, "");
    cards.logical("EXTEND", true, "");
    let mut bytes = cards.end();

    let n_column = header.need_count("TFIELDS")?;
    let mut cards = Cards::default();
    cards.text("XTENSION", "BINTABLE", "");
    for (key, value) in [("BITPIX", 8), ("NAXIS", 2)] {
        cards.integer(key, value, "");
    }
    cards.integer("NAXIS1", hdu.axes[0] as i64, "");
    let n_row = if hdu.axes[0] == 0 { 0 } else { hdu.axes[1] };
    cards.integer("NAXIS2", n_row as i64, "");
    // What PCOUNT counts lies behind the rows, and is read as padding.
    cards.integer("PCOUNT", header.need_count("PCOUNT")? as i64, "");
    cards.integer("GCOUNT", 1, "");
    cards.integer("TFIELDS", n_column as i64, "");
    for i in 1..=n_column {
        let key = format!("TFORM{i}");
        let tform = header.text(&key).and_then(Tform::parse);
        let tform = tform.ok_or_else(|| header.place.malformed(&key, "is no format"))?;
        cards.text(&key, &tform.plain(), "");
        if tform.is_number() {
            for key in [format!("TSCAL{i}"), format!("TZERO{i}")] {
                if let Some(value) = header.real(&key)? {
                    cards.real(&key, value, "");
                }
            }
        }
    }
    bytes.extend(cards.end());
    Ok(bytes)
}

/// One column to be written.
pub(crate) struct Column {
    /// TTYPE.
    pub(crate) name: &'static str,
    /// TFORM.
    pub(crate) form: String,
    /// TUNIT.
    pub(crate) unit: &'static str,
    /// Values, row after row.
    pub(crate) cells: Cells,
}

/// Values of a column.
pub(crate) enum Cells {
    /// As many strings as rows.
    Text(Vec<String>),
    /// Rows times elements.
    Numbers(Vec<f64>),
}

/// A binary table HDU as bytes: `cards` after the columns' own, then the data, padded.
///
/// # Errors
/// CFITSIO's words.
pub(crate) fn table_bytes(
    name: &str,
    n_row: usize,
    columns: &[Column],
    cards: &Cards,
) -> Result<Vec<u8>, String> {
    build(name, n_row, columns, cards).map_err(|error| error.0)
}

fn build(
    name: &str,
    n_row: usize,
    columns: &[Column],
    cards: &Cards,
) -> Result<Vec<u8>, CfitsioError> {
    let row_bytes: u64 = columns
        .iter()
        .filter_map(|column| Tform::parse(&column.form).and_then(Tform::bytes))
        .sum();
    let header_bytes = (20 + columns.len() * 3) * 80 + cards.bytes.len();
    let data_bytes = row_bytes as usize * n_row;
    let mut fits = MemoryFits::create(header_bytes + data_bytes + 6 * BLOCK_BYTES)?;
    let shape: Vec<_> = columns
        .iter()
        .map(|c| (c.name, c.form.as_str(), c.unit))
        .collect();
    fits.create_table(name, n_row, &shape)?;
    for card in cards.bytes.chunks_exact(super::CARD_BYTES) {
        fits.write_card(card)?;
    }
    for (i, column) in columns.iter().enumerate() {
        match &column.cells {
            Cells::Text(texts) => fits.write_texts(i + 1, texts)?,
            Cells::Numbers(values) if values.is_empty() => {}
            Cells::Numbers(values) => fits.write_numbers(i + 1, values)?,
        }
    }
    fits.current_hdu()
}
