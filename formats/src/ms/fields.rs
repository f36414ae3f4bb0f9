//! What the data are phased to: table `FIELD`.
//!
//! # Source
//! Note, section on FIELD; casacore's manual, class MDirection, Types.

use std::path::Path;

use super::MAX_SUBTABLE_ROWS;
use crate::casa::{Reference, Table};
use crate::{Field, Frame, ReadError};

/// casacore's codes of frames, where a table does not say what its codes mean.
const CODES: [(u32, &str); 3] = [(0, "J2000"), (4, "B1950"), (21, "ICRS")];

/// The phase centres, and how to find one.
#[derive(Debug)]
pub(super) struct Fields {
    pub(super) list: Vec<Field>,
    /// Place in the list of each row, or why it is no phase centre: nothing is wrong as long as no
    /// data are of it.
    places: Vec<Result<u32, String>>,
}

impl Fields {
    pub(super) fn read(root: &Path) -> Result<Self, ReadError> {
        let mut table = Table::open_sub(root, "FIELD")?;
        if table.n_row > MAX_SUBTABLE_ROWS {
            return Err(table.malformed(format!("has {} rows", table.n_row)));
        }
        let reference = table.reference("PHASE_DIR")?;
        let mut fields = Self {
            list: Vec::new(),
            places: Vec::new(),
        };
        for row in 0..table.n_row {
            let place = fields.list.len() as u32;
            let found = read_row(&mut table, row, &reference)?;
            fields.places.push(found.map(|field| {
                fields.list.push(field);
                place
            }));
        }
        if !fields.list.is_empty() {
            return Ok(fields);
        }
        match fields.places.into_iter().find_map(Result::err) {
            Some(why) => Err(table.unsupported("PHASE_DIR", 0, why)),
            None => Err(table.malformed("has no field")),
        }
    }

    /// The place in the list of the field of that row; errors in words.
    pub(super) fn find(&self, number: i32) -> Result<u32, String> {
        let row = usize::try_from(number).ok();
        match row.and_then(|row| self.places.get(row)) {
            Some(place) => place.clone(),
            None => Err(format!("field {number} is not in table FIELD")),
        }
    }
}

/// A row; why it is no phase centre is told in words.
fn read_row(
    table: &mut Table,
    row: u64,
    reference: &Reference,
) -> Result<Result<Field, String>, ReadError> {
    let name = table.text("NAME", row)?.trim().to_owned();
    if table.has("EPHEMERIS_ID") && table.scalar::<i32>("EPHEMERIS_ID", row)? >= 0 {
        let why =
            format!("field '{name}' moves by an ephemeris; only fixed phase centres are read");
        return Ok(Err(why));
    }
    let frame_name = frame_name(table, row, reference)?;
    let frame = match frame_name.as_str() {
        "J2000" => Frame::Fk5(2000.0),
        "B1950" => Frame::Fk4(1950.0),
        "ICRS" => Frame::Icrs,
        other => {
            let why = format!(
                "field '{name}' is in frame '{other}'; J2000, B1950 and ICRS are read: phase the \
                 data to one of these, with CASA's phaseshift"
            );
            return Ok(Err(why));
        }
    };
    let (shape, terms) = table.array::<f64>("PHASE_DIR", row)?;
    let &[n_term, 2] = shape.as_slice() else {
        let what = format!("has shape {shape:?}, must be (NUM_POLY + 1, 2)");
        return Err(table.cell_error("PHASE_DIR", row, what));
    };
    if n_term == 0 || terms[2..].iter().any(|&term| term != 0.0) {
        return Ok(Err(format!(
            "field '{name}' moves by a polynomial in time; only fixed phase centres are read"
        )));
    }
    let (ra_rad, dec_rad) = (terms[0], terms[1]);
    if !ra_rad.is_finite() || dec_rad.is_nan() || dec_rad.abs() > std::f64::consts::FRAC_PI_2 {
        let what = format!("({ra_rad}, {dec_rad}) rad is no direction");
        return Err(table.cell_error("PHASE_DIR", row, what));
    }
    Ok(Ok(Field {
        name,
        ra_rad: ra_rad.rem_euclid(std::f64::consts::TAU),
        dec_rad,
        frame,
        drifts: false,
    }))
}

/// The name of the frame of a row; J2000 where nothing is said, as the note has it.
fn frame_name(table: &mut Table, row: u64, reference: &Reference) -> Result<String, ReadError> {
    let Some(column) = &reference.column else {
        return Ok(reference.frame.clone().unwrap_or_else(|| "J2000".into()));
    };
    let code = table.scalar::<i32>(column, row)?;
    let own = reference
        .codes
        .iter()
        .map(|(code, name)| (*code, name.as_str()));
    let known = if reference.codes.is_empty() {
        CODES
            .into_iter()
            .find(|known| i64::from(known.0) == i64::from(code))
    } else {
        own.into_iter()
            .find(|known| i64::from(known.0) == i64::from(code))
    };
    Ok(known.map_or_else(|| format!("number {code}"), |known| known.1.to_owned()))
}
