//! A binary table from a file.

mod column;
mod header;

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use self::column::{Layout, Values};
use self::header::Header;
use crate::ReadError;

/// A binary table read whole.
#[derive(Debug, Clone)]
pub struct Table {
    path: PathBuf,
    place: String,
    header: Header,
    rows: usize,
    columns: Vec<ReadColumn>,
}

/// One column as read.
#[derive(Debug, Clone)]
pub struct ReadColumn {
    /// `TTYPEn`, or empty.
    pub name: String,
    /// `TUNITn`.
    pub unit: Option<String>,
    values: Values,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// All columns in order.
    pub fn columns(&self) -> &[ReadColumn] {
        &self.columns
    }

    /// The value of a header keyword as text, strings without their quotes.
    pub fn keyword(&self, key: &str) -> Option<&str> {
        self.header.get(key)
    }

    /// The column called `name` in any case, if there is one.
    pub fn column(&self, name: &str) -> Option<&ReadColumn> {
        self.columns
            .iter()
            .find(|c| c.name.eq_ignore_ascii_case(name))
    }

    /// The numbers of column `name`; integers above 2^53 are rounded, missing values are NaN.
    ///
    /// # Errors
    /// There is no such column, or it does not hold one number a row.
    pub fn numbers(&self, name: &str) -> Result<&[f64], ReadError> {
        match &self.existing(name)?.values {
            Values::Numbers(values) => Ok(values),
            other => Err(self.wrong_kind(name, "one number a row", other)),
        }
    }

    /// The strings of column `name`, without trailing spaces.
    ///
    /// # Errors
    /// There is no such column, or it holds no strings.
    pub fn strings(&self, name: &str) -> Result<&[String], ReadError> {
        match &self.existing(name)?.values {
            Values::Strings(values) => Ok(values),
            other => Err(self.wrong_kind(name, "strings", other)),
        }
    }

    fn existing(&self, name: &str) -> Result<&ReadColumn, ReadError> {
        self.column(name).ok_or_else(|| {
            let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
            ReadError::Malformed {
                path: self.path.clone(),
                place: self.place.clone(),
                what: format!("no column {name}; there are {}", names.join(", ")),
            }
        })
    }

    fn wrong_kind(&self, name: &str, wanted: &str, found: &Values) -> ReadError {
        ReadError::Malformed {
            path: self.path.clone(),
            place: format!("{}, column {name}", self.place),
            what: format!("expected {wanted}, found {}", found.kind()),
        }
    }
}

/// Whether the file starts as FITS does.
///
/// # Errors
/// The file cannot be read.
pub fn is_fits(path: &Path) -> Result<bool, ReadError> {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(9).read_to_end(&mut start));
    read.map_err(|source| io_error(path, source))?;
    Ok(start == b"SIMPLE  =")
}

/// The binary table called `extname` in any case, or the first one.
///
/// # Errors
/// The file cannot be read, is cut short, is no FITS, or has no such table; the error names HDU and
/// column.
pub fn read_table(path: &Path, extname: Option<&str>) -> Result<Table, ReadError> {
    let mut file = File::open(path).map_err(|source| io_error(path, source))?;
    let metadata = file.metadata().map_err(|source| io_error(path, source))?;
    let mut left = metadata.len();
    for hdu in 0.. {
        let place = format!("HDU {hdu}");
        if hdu > 0 && left == 0 {
            break;
        }
        let (header, used) = Header::read(&mut file, left)
            .map_err(|source| io_error(path, source))?
            .map_err(|what| malformed(path, &place, what))?;
        if !header.starts_hdu(hdu == 0) {
            let what = if hdu == 0 {
                "this is not a FITS file"
            } else {
                "no XTENSION here"
            };
            return Err(malformed(path, &place, what.into()));
        }
        left -= used;
        let size = header
            .data_size()
            .map_err(|what| malformed(path, &place, what))?;
        if size > left {
            let what = format!("the file is cut: {size} bytes of data expected, {left} are there");
            return Err(malformed(path, &place, what));
        }
        if is_wanted(&header, extname) {
            return read_hdu(path, &mut file, header, place);
        }
        left -= size;
        file.seek(SeekFrom::Current(size as i64))
            .map_err(|source| io_error(path, source))?;
    }
    let what = match extname {
        Some(name) => format!("no binary table called {name}"),
        None => "no binary table".to_owned(),
    };
    Err(malformed(path, "all HDUs", what))
}

fn is_wanted(header: &Header, extname: Option<&str>) -> bool {
    let is_table = header.get("XTENSION") == Some("BINTABLE");
    let compressed = header.get("ZIMAGE") == Some("T");
    match extname {
        Some(wanted) => {
            let name = header.get("EXTNAME").unwrap_or_default();
            is_table && name.eq_ignore_ascii_case(wanted)
        }
        None => is_table && !compressed,
    }
}

/// Reads the rows that the file now stands at; their size has been checked against the file.
fn read_hdu(path: &Path, file: &mut File, header: Header, hdu: String) -> Result<Table, ReadError> {
    let place = match header.get("EXTNAME") {
        Some(name) => format!("{hdu} {name}"),
        None => hdu,
    };
    if header.get("ZTABLE") == Some("T") {
        return Err(ReadError::Unsupported {
            path: path.into(),
            place,
            what: "compressed tables are not read; uncompress it with funpack".into(),
        });
    }
    let layout = Layout::from_header(&header).map_err(|what| malformed(path, &place, what))?;
    let mut bytes = vec![0; layout.row_bytes * layout.rows];
    file.read_exact(&mut bytes)
        .map_err(|source| io_error(path, source))?;
    let columns = layout.columns.iter().map(|c| ReadColumn {
        name: c.name.clone(),
        unit: c.unit.clone(),
        values: c.decode(&bytes, layout.row_bytes),
    });
    Ok(Table {
        columns: columns.collect(),
        rows: layout.rows,
        path: path.into(),
        place,
        header,
    })
}

fn io_error(path: &Path, source: std::io::Error) -> ReadError {
    ReadError::Io {
        path: path.into(),
        source,
    }
}

fn malformed(path: &Path, place: &str, what: String) -> ReadError {
    ReadError::Malformed {
        path: path.into(),
        place: place.to_owned(),
        what,
    }
}
