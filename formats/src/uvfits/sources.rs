//! Phase centres: the header's RA and DEC axes, or the `AIPS SU` table of a multi-source file.
//!
//! # Source
//! Memo, section 4.13.

use std::fs::File;

use super::axes::Axes;
use super::frame;
use crate::fits::Table;
use crate::fits::scan::Hdu;
use crate::{Field, ReadError};

/// The fields and the `ID. NO.` of each; no numbers where the header's position is the only one.
#[derive(Debug, Default)]
pub(super) struct Sources {
    pub(super) fields: Vec<Field>,
    numbers: Vec<i64>,
}

impl Sources {
    /// Index of the field that SOURCE names.
    pub(super) fn find(&self, number: i64) -> Option<u32> {
        if self.numbers.is_empty() {
            return Some(0);
        }
        self.numbers
            .iter()
            .position(|&n| n == number)
            .map(|i| i as u32)
    }

    /// Reads the table where rows have a SOURCE and there is one, the header otherwise.
    pub(super) fn read(
        file: &mut File,
        hdus: &[Hdu],
        axes: &Axes,
        rows_have_source: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Self, ReadError> {
        let table = hdus.iter().find(|hdu| hdu.is_named("AIPS SU"));
        if let (true, Some(hdu)) = (rows_have_source, table) {
            return from_table(&Table::read(file, hdu)?, &hdus[0], warnings);
        }
        if rows_have_source {
            warnings.push("rows have a SOURCE but there is no AIPS SU table: one source".into());
        }
        Ok(Self {
            fields: vec![from_header(&hdus[0], axes, warnings)?],
            numbers: Vec::new(),
        })
    }
}

fn from_header(hdu: &Hdu, axes: &Axes, warnings: &mut Vec<String>) -> Result<Field, ReadError> {
    let header = &hdu.header;
    let coordinate = |number: usize, pointing: &str, warnings: &mut Vec<String>| {
        let key = format!("CRVAL{number}");
        if let Some(deg) = header.real(&key)? {
            return Ok(deg);
        }
        let deg = header.real(pointing)?.ok_or_else(|| {
            let what = format!("no phase centre: neither an axis value nor {pointing}");
            header
                .place
                .malformed(if number == 0 { "CTYPE" } else { &key }, what)
        })?;
        warnings.push(format!("the phase centre is taken from {pointing}"));
        Ok(deg)
    };
    let ra_deg = coordinate(axes.ra.number, "OBSRA", warnings)?;
    let dec_deg = coordinate(axes.dec.number, "OBSDEC", warnings)?;
    if dec_deg.abs() > 90.0 {
        let key = format!("CRVAL{}", axes.dec.number);
        return Err(header
            .place
            .malformed(&key, format!("declination {dec_deg} deg")));
    }
    Ok(Field {
        name: header.text("OBJECT").unwrap_or("").to_owned(),
        ra_rad: ra_deg.to_radians(),
        dec_rad: dec_deg.to_radians(),
        frame: frame::read(header, warnings)?,
        drifts: false,
    })
}

fn from_table(
    table: &Table,
    primary: &Hdu,
    warnings: &mut Vec<String>,
) -> Result<Sources, ReadError> {
    let place = table.header.place.clone();
    let numbers = table.need_cells("ID. NO.", 1)?;
    let ra_deg = table.need_cells("RAEPO", 1)?;
    let dec_deg = table.need_cells("DECEPO", 1)?;
    let epochs = match table.cells("EPOCH")? {
        None => table.cells("EQUINOX")?,
        some => some,
    };
    let names = table.texts("SOURCE")?.unwrap_or_default();
    if table.n_row == 0 {
        return Err(place.malformed("NAXIS2", "is 0: there is no source"));
    }
    if table
        .cells("FREQOFF")?
        .is_some_and(|column| column.values.iter().any(|&f| f != 0.0))
    {
        warnings
            .push("AIPS SU: FREQOFF is not zero; per-source frequency offsets are ignored".into());
    }
    let named = ["RADESYS", "RADESYSA", "RADECSYS", "PHSFRAME"]
        .iter()
        .any(|key| primary.header.text(key).is_some());
    let header_frame = frame::read(&primary.header, warnings)?;
    let mut sources = Sources::default();
    for row in 0..table.n_row {
        let (ra, dec) = (ra_deg.row(row)[0], dec_deg.row(row)[0]);
        if !(ra.is_finite() && dec.abs() <= 90.0) {
            let what = format!("row {}: ({ra}, {dec}) deg is no position", row + 1);
            return Err(place.malformed("RAEPO, DECEPO", what));
        }
        let epoch = epochs
            .as_ref()
            .filter(|c| c.repeat > 0)
            .map(|column| column.row(row)[0]);
        sources.fields.push(Field {
            name: names.get(row).cloned().unwrap_or_default(),
            ra_rad: ra.to_radians(),
            dec_rad: dec.to_radians(),
            frame: if named {
                header_frame
            } else {
                frame::from_equinox(epoch)
            },
            drifts: false,
        });
        sources.numbers.push(numbers.row(row)[0] as i64);
    }
    Ok(sources)
}
