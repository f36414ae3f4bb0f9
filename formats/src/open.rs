//! Which reader a path needs, by what stands in it and not by its name.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::uvfits::UvfitsReader;
use crate::uvh5::Uvh5Reader;
use crate::{ReadError, VisReader};

/// First bytes of an HDF5 file (HDF5 File Format Specification 3.0, section II.A).
const HDF5_SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// First bytes of a FITS file.
const FITS_SIGNATURE: &[u8] = b"SIMPLE  =";

/// Opens a visibility file.
///
/// # Errors
/// The path cannot be read, is no visibility file, or is of a kind that is not read yet.
pub fn open(path: &Path) -> Result<Box<dyn VisReader>, ReadError> {
    let unsupported = |place: &str, what: &str| ReadError::Unsupported {
        path: path.to_owned(),
        place: place.to_owned(),
        what: what.to_owned(),
    };
    if path.is_dir() {
        return Err(if path.join("table.dat").is_file() {
            unsupported(
                "directory",
                "Measurement Sets are not read yet; write UVFITS",
            )
        } else {
            unsupported(
                "directory",
                "is no Measurement Set (there is no table.dat in it)",
            )
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

fn first_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    File::open(path)?.take(16).read_to_end(&mut start)?;
    Ok(start)
}
