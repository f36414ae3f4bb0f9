//! Which reader a path needs, by what stands in it and not by its name.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::uvfits::UvfitsReader;
use crate::uvh5::Uvh5Reader;
use crate::{Averaged, Averaging, Concatenated, ReadError, Selected, Selection, VisReader};

/// First bytes of an HDF5 file (HDF5 File Format Specification 3.0, section II.A).
const HDF5_SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// First bytes of a FITS file.
const FITS_SIGNATURE: &[u8] = b"SIMPLE  =";

/// What to read of a file, and how.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Column of visibilities of a Measurement Set; none = `CORRECTED_DATA` where it is filled,
    /// `DATA` otherwise.
    pub data_column: Option<String>,
    /// Which rows, channels and correlations.
    pub select: Selection,
    /// What is averaged of these.
    pub average: Averaging,
}

/// Opens a visibility file.
///
/// # Errors
/// The path cannot be read, is no visibility file, or is of a kind that is not read yet.
pub fn open(path: &Path) -> Result<Box<dyn VisReader>, ReadError> {
    open_with(path, &ReadOptions::default())
}

/// Opens a visibility file and chooses what is read.
///
/// # Errors
/// As [`open`], or the file has nothing to choose from.
pub fn open_with(path: &Path, options: &ReadOptions) -> Result<Box<dyn VisReader>, ReadError> {
    let mut reader = open_file(path, options)?;
    if !options.select.is_all() {
        reader = Box::new(Selected::new(path, reader, &options.select)?);
    }
    if !options.average.is_none() {
        reader = Box::new(Averaged::new(path, reader, &options.average)?);
    }
    Ok(reader)
}

/// Opens several files as one (see [`Concatenated`]); returns also the file, from 0, that each frequency
/// set-up is of. A column of visibilities is chosen in Measurement Sets only.
///
/// # Errors
/// As [`open_with`] for each of them, or they do not go together.
pub fn open_all(
    paths: &[PathBuf],
    options: &ReadOptions,
) -> Result<(Box<dyn VisReader>, Vec<u32>), ReadError> {
    if let [path] = paths {
        let reader = open_with(path, options)?;
        let files = vec![0; reader.observation().freq_setups.len()];
        return Ok((reader, files));
    }
    let has_set = paths.iter().any(|path| path.is_dir());
    let mut readers = Vec::new();
    for path in paths {
        let mut options = options.clone();
        if has_set && !path.is_dir() {
            options.data_column = None;
        }
        readers.push((path.clone(), open_with(path, &options)?));
    }
    let all = Concatenated::new(readers)?;
    let files = all.file_of_setup();
    Ok((Box::new(all), files))
}

fn open_file(path: &Path, options: &ReadOptions) -> Result<Box<dyn VisReader>, ReadError> {
    if path.is_dir() {
        return open_directory(path, options);
    }
    if options.data_column.is_some() {
        return Err(ReadError::Unsupported {
            path: path.to_owned(),
            place: "file".to_owned(),
            what: "only Measurement Sets have a choice of data columns".to_owned(),
        });
    }
    let start = first_bytes(path).map_err(|source| ReadError::Io {
        path: path.to_owned(),
        source,
    })?;
    if start.starts_with(FITS_SIGNATURE) {
        return Ok(Box::new(UvfitsReader::open(path)?));
    }
    if start.starts_with(HDF5_SIGNATURE) {
        return Ok(Box::new(Uvh5Reader::open(path)?));
    }
    Err(ReadError::Malformed {
        path: path.to_owned(),
        place: "file".to_owned(),
        what: if start.is_empty() {
            "is empty"
        } else {
            "is no visibility file: not FITS, not HDF5"
        }
        .to_owned(),
    })
}

/// Whether a path looks like a Measurement Set: a directory with a table of casacore in it.
pub fn is_measurement_set(path: &Path) -> bool {
    path.join("table.dat").is_file()
}

fn open_directory(path: &Path, options: &ReadOptions) -> Result<Box<dyn VisReader>, ReadError> {
    if !is_measurement_set(path) {
        return Err(ReadError::Unsupported {
            path: path.to_owned(),
            place: "directory".to_owned(),
            what: "is no Measurement Set (there is no table.dat in it)".to_owned(),
        });
    }
    open_measurement_set(path, options)
}

#[cfg(feature = "ms")]
fn open_measurement_set(
    path: &Path,
    options: &ReadOptions,
) -> Result<Box<dyn VisReader>, ReadError> {
    let reader =
        crate::ms::MsReader::open_with(path, options.data_column.as_deref(), &options.select.spws)?;
    Ok(Box::new(reader))
}

#[cfg(not(feature = "ms"))]
fn open_measurement_set(path: &Path, _: &ReadOptions) -> Result<Box<dyn VisReader>, ReadError> {
    Err(ReadError::Unsupported {
        path: path.to_owned(),
        place: "directory".to_owned(),
        what: "this build does not read Measurement Sets: build with the feature `ms`".to_owned(),
    })
}

fn first_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    File::open(path)?.take(16).read_to_end(&mut start)?;
    Ok(start)
}
