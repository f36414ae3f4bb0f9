//! The celestial frame of the header's and the source table's positions.

use crate::fits::header::Header;
use crate::{Frame, ReadError};

/// The frame that the header names.
///
/// RADESYS (old: PHSFRAME, written by pyuvdata), else the equinox alone: 1950 was FK4, any other
/// FK5; neither: ICRS.
///
/// # Source
/// FITS Standard 4.0, section 8.3 (RADESYS, EQUINOX, EPOCH), which has FK4 before 1984.
pub(super) fn read(header: &Header, warnings: &mut Vec<String>) -> Result<Frame, ReadError> {
    let equinox = match header.real("EQUINOX")? {
        None => header.real("EPOCH")?,
        some => some,
    };
    let name = ["RADESYS", "RADESYSA", "RADECSYS", "PHSFRAME"]
        .iter()
        .find_map(|k| header.text(k));
    Ok(match name.map(str::to_uppercase).as_deref() {
        Some("ICRS") => Frame::Icrs,
        Some("FK5") => Frame::Fk5(equinox.unwrap_or(2000.0)),
        Some("FK4") => Frame::Fk4(equinox.unwrap_or(1950.0)),
        Some(other) => {
            let frame = from_equinox(equinox);
            warnings.push(format!(
                "RADESYS '{other}' is not known; positions are taken as {frame:?}"
            ));
            frame
        }
        None => from_equinox(equinox),
    })
}

/// The frame of an equinox without a name.
pub(super) fn from_equinox(equinox: Option<f64>) -> Frame {
    match equinox {
        Some(1950.0) => Frame::Fk4(1950.0),
        // AIPS writes 0 where it does not know.
        Some(equinox) if equinox > 0.0 => Frame::Fk5(equinox),
        _ => Frame::Icrs,
    }
}
