//! Binary tables, read from memory through CFITSIO.

use std::cell::RefCell;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::BLOCK_BYTES;
use super::card::Value;
use super::card::parse::printable;
use super::cfitsio::{CfitsioError, MemoryFits};
use super::header::{Header, Place};
use super::scan::{self, Hdu};
use super::spec::{empty_primary, extension};
use super::tform::Tform;
use crate::ReadError;

/// Largest table that is read: it is held in memory.
const MAX_TABLE_BYTES: u64 = 1 << 30;

/// A binary table in memory; cells are decoded when they are asked for.
pub struct Table {
    /// Its header.
    pub(crate) header: Header,
    /// Rows.
    pub(crate) n_row: usize,
    columns: Vec<ReadColumn>,
    /// Reading moves CFITSIO's own position; nothing else of the table changes.
    fits: RefCell<MemoryFits>,
}

/// What the header says of one column.
#[derive(Debug, Clone)]
pub struct ReadColumn {
    /// `TTYPEn`, or empty.
    pub name: String,
    /// `TUNITn`.
    pub unit: Option<String>,
    form: Tform,
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

/// Whether the file starts as FITS does.
///
/// # Errors
/// The file cannot be read.
pub fn is_fits(path: &Path) -> Result<bool, ReadError> {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(9).read_to_end(&mut start));
    read.map_err(|e| Place::file(path).io(e))?;
    Ok(start == b"SIMPLE  =")
}

/// The binary table called `extname` in any case, or the first one that is no compressed image.
///
/// # Errors
/// The file cannot be read, is cut short, is no FITS, or has no such table; the error names HDU and
/// column.
pub fn read_table(path: &Path, extname: Option<&str>) -> Result<Table, ReadError> {
    find_table(path, extname)?.ok_or_else(|| {
        let what = match extname {
            Some(name) => format!("there is no binary table called {name}"),
            None => "there is no binary table".to_owned(),
        };
        Place::file(path).malformed("", what)
    })
}

/// As [`read_table`], or `None` where the file has no such table.
///
/// # Errors
/// The file cannot be read, is cut short, or is no FITS.
pub fn find_table(path: &Path, extname: Option<&str>) -> Result<Option<Table>, ReadError> {
    let mut file = File::open(path).map_err(|e| Place::file(path).io(e))?;
    let hdus = scan::scan(path, &mut file)?;
    let is_wanted = |hdu: &&Hdu| {
        hdu.header.text("XTENSION") == Some("BINTABLE")
            && match extname {
                Some(name) => hdu.is_named(name),
                None => !hdu.header.logical("ZIMAGE"),
            }
    };
    let Some(hdu) = hdus.iter().find(is_wanted) else {
        return Ok(None);
    };
    if hdu.header.logical("ZTABLE") {
        let what = "compressed tables are not read; uncompress it with funpack";
        return Err(hdu.header.place.unsupported("ZTABLE", what));
    }
    Table::read(&mut file, hdu).map(Some)
}

impl Table {
    /// Takes the table of `hdu`, which the scan has measured, into memory.
    pub(crate) fn read(file: &mut File, hdu: &Hdu) -> Result<Self, ReadError> {
        let place = &hdu.header.place;
        if hdu.header.text("XTENSION") != Some("BINTABLE") {
            return Err(place.malformed("XTENSION", "must be a BINTABLE"));
        }
        let bytes = hdu.data_bytes;
        if bytes > MAX_TABLE_BYTES {
            let what = format!("has {bytes} bytes, more than {MAX_TABLE_BYTES} are not read");
            return Err(place.unsupported("NAXIS2", what));
        }
        let columns = read_columns(&hdu.header)?;
        // A row without width has no rows worth counting, however many the header claims.
        let n_row = if hdu.axes[0] == 0 { 0 } else { hdu.axes[1] } as usize;
        let mut image = clean_header(hdu, n_row, &columns)?;
        let whole = image.len() + (bytes as usize).next_multiple_of(BLOCK_BYTES);
        file.seek(SeekFrom::Start(hdu.data_offset))
            .map_err(|e| place.io(e))?;
        file.by_ref()
            .take(bytes)
            .read_to_end(&mut image)
            .map_err(|e| place.io(e))?;
        image.resize(whole, 0);
        Ok(Self {
            header: hdu.header.clone(),
            n_row,
            columns,
            fits: RefCell::new(MemoryFits::read(image).map_err(|e| refused(place, "table", &e))?),
        })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.n_row
    }

    /// All columns in order.
    pub fn columns(&self) -> &[ReadColumn] {
        &self.columns
    }

    /// The value of a header keyword.
    pub fn keyword(&self, key: &str) -> Option<&Value> {
        self.header.value(key)
    }

    /// The column called `name` in any case, if there is one.
    pub fn column(&self, name: &str) -> Option<&ReadColumn> {
        self.find(name).map(|i| &self.columns[i])
    }

    /// The numbers of column `name`; integers above 2^53 are rounded, missing values are NaN.
    ///
    /// # Errors
    /// There is no such column, or it does not hold one number a row.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, ReadError> {
        match self.cells(name)? {
            None => Err(self.no_column(name)),
            Some(cells) if cells.repeat == 1 => Ok(cells.values),
            Some(cells) => {
                let what = format!("column has {} elements a row, expected one", cells.repeat);
                Err(self.header.place.malformed(name, what))
            }
        }
    }

    /// The strings of column `name`, without blanks at either end.
    ///
    /// # Errors
    /// There is no such column, or it holds no strings.
    pub fn strings(&self, name: &str) -> Result<Vec<String>, ReadError> {
        self.texts(name)?.ok_or_else(|| self.no_column(name))
    }

    /// Elements of a column of numbers; `None` where there is none of that name.
    pub(crate) fn cells(&self, name: &str) -> Result<Option<Numbers>, ReadError> {
        let Some(column) = self.find(name) else {
            return Ok(None);
        };
        let (place, form) = (&self.header.place, self.columns[column].form);
        if !form.is_number() {
            let (n, letter) = (column + 1, form.letter as char);
            let what = format!("column {n} holds type {letter}, not numbers");
            return Err(place.malformed(name, what));
        }
        let repeat = form.repeat as usize;
        let count = repeat * self.n_row;
        if count == 0 {
            let values = Vec::new();
            return Ok(Some(Numbers { repeat, values }));
        }
        // Missing floats are NaN already; looking for them makes CFITSIO round subnormals to 0.
        let missing = if form.is_integer() { f64::NAN } else { 0.0 };
        let values = self
            .fits
            .borrow_mut()
            .read_numbers(column + 1, count, missing);
        let mut values = values.map_err(|e| refused(place, name, &e))?;
        if form.letter == b'L' {
            for value in &mut values {
                *value = truth(*value);
            }
        }
        Ok(Some(Numbers { repeat, values }))
    }

    /// A column of numbers that must be there with at least `repeat` elements in each cell.
    pub(crate) fn need_cells(&self, name: &str, repeat: usize) -> Result<Numbers, ReadError> {
        let cells = self.cells(name)?;
        let place = &self.header.place;
        match cells {
            None => Err(place.malformed(name, "column is missing")),
            Some(cells) if cells.repeat < repeat => {
                let found = cells.repeat;
                let what = format!("column has {found} elements a row, needs {repeat}");
                Err(place.malformed(name, what))
            }
            Some(cells) => Ok(cells),
        }
    }

    /// A column of strings, unprintable bytes dropped; `None` where there is none of that name.
    pub(crate) fn texts(&self, name: &str) -> Result<Option<Vec<String>>, ReadError> {
        let Some(column) = self.find(name) else {
            return Ok(None);
        };
        let (place, form) = (&self.header.place, self.columns[column].form);
        if form.letter != b'A' {
            let (n, letter) = (column + 1, form.letter as char);
            let what = format!("column {n} holds type {letter}, not text");
            return Err(place.malformed(name, what));
        }
        if form.repeat == 0 {
            return Ok(None);
        }
        let cell = |row| {
            let text = self
                .fits
                .borrow_mut()
                .read_text(column + 1, row, form.repeat as usize);
            let mut text = text.map_err(|e| refused(place, name, &e))?;
            text.retain(|b| (b' '..=b'~').contains(b));
            Ok(printable(&text).trim().to_owned())
        };
        (0..self.n_row)
            .map(cell)
            .collect::<Result<_, _>>()
            .map(Some)
    }

    fn find(&self, name: &str) -> Option<usize> {
        let is_it = |column: &ReadColumn| column.name.eq_ignore_ascii_case(name);
        self.columns.iter().position(is_it)
    }

    fn no_column(&self, name: &str) -> ReadError {
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        let what = format!("no column {name}; there are {}", names.join(", "));
        self.header.place.malformed("columns", what)
    }
}

/// What a byte of a logical column stands for.
fn truth(byte: f64) -> f64 {
    match byte as u8 {
        b'T' => 1.0,
        b'F' => 0.0,
        _ => f64::NAN,
    }
}

fn refused(place: &Place, at: &str, error: &CfitsioError) -> ReadError {
    place.malformed(at, error.0.clone())
}

fn read_columns(header: &Header) -> Result<Vec<ReadColumn>, ReadError> {
    let column = |i| {
        let key = format!("TFORM{i}");
        let form = header.text(&key).and_then(Tform::parse);
        let name = header.text(&format!("TTYPE{i}")).unwrap_or_default();
        Ok(ReadColumn {
            name: name.to_owned(),
            unit: header.text(&format!("TUNIT{i}")).map(str::to_owned),
            form: form.ok_or_else(|| header.place.malformed(&key, "is no format"))?,
        })
    };
    (1..=header.need_count("TFIELDS")?).map(column).collect()
}

/// The headers of a file that is only this table, written anew from what the scan has checked.
///
/// CFITSIO never sees the file's own header: of the many keywords that it acts upon, some divide
/// by zero when they are wrong. Columns that are neither numbers nor text are declared as bytes.
fn clean_header(hdu: &Hdu, n_row: usize, columns: &[ReadColumn]) -> Result<Vec<u8>, ReadError> {
    let header = &hdu.header;
    let mut bytes = empty_primary().header();
    // What PCOUNT counts lies behind the rows, and is read as padding.
    let heap = header.need_count("PCOUNT")? as usize;
    let mut cards = extension(hdu.axes[0] as usize, n_row, heap, columns.len());
    for (i, column) in (1..).zip(columns) {
        let form = column.form;
        cards.push(&format!("TFORM{i}"), form.plain(), "");
        if form.is_number() && form.letter != b'L' {
            for key in [format!("TSCAL{i}"), format!("TZERO{i}")] {
                if let Some(value) = header.real(&key)? {
                    cards.push(&key, value, "");
                }
            }
        }
        let key = format!("TNULL{i}");
        if let (true, Some(null)) = (form.is_integer(), header.integer(&key)?) {
            cards.push(&key, null, "");
        }
    }
    bytes.extend(cards.header());
    Ok(bytes)
}
