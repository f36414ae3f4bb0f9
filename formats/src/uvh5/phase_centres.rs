//! What the data are phased to, in the words of old and new files.
//!
//! Which words a file uses is decided by what is in it, not by its `version`: real files have the
//! one with the number of the other.
//!
//! # Source
//! Memo, section 3.1 (phase_center_catalog, phase_center_id_array), and its edition of 2018
//! (phase_type, phase_center_ra, phase_center_dec, phase_center_epoch, object_name).

use crate::h5::Group;
use crate::{Field, Frame, ReadError};

/// The phase centres, and how to find one.
#[derive(Debug)]
pub(super) struct PhaseCentres {
    pub(super) fields: Vec<Field>,
    /// Whether rows say which of them they are of.
    pub(super) has_ids: bool,
    /// Number in the file, and the place in `fields` or why there is none.
    entries: Vec<(i64, Result<u32, String>)>,
}

/// What stands for a phase centre where the data are not phased.
fn drifting(name: Option<String>) -> Field {
    Field {
        name: name.unwrap_or_default(),
        drifts: true,
        ..Field::default()
    }
}

impl PhaseCentres {
    pub(super) fn read(header: &Group, warnings: &mut Vec<String>) -> Result<Self, ReadError> {
        if header.is_dataset("phase_center_catalog") {
            let what = "is a text, as files of version 1.0 have it, which is not read; read and \
                        write the file with pyuvdata";
            return Err(header.unsupported("phase_center_catalog", what));
        }
        match header.group("phase_center_catalog")? {
            Some(catalog) => Self::catalog(header, &catalog, warnings),
            None => Self::old(header),
        }
    }

    /// The place in `fields` of the phase centre with that number; errors in words.
    pub(super) fn find(&self, id: i64) -> Result<u32, String> {
        match self.entries.iter().find(|entry| entry.0 == id) {
            Some((_, Ok(field))) => Ok(*field),
            Some((_, Err(why))) => Err(why.clone()),
            None => Err(format!("{id} is not in phase_center_catalog")),
        }
    }

    fn catalog(
        header: &Group,
        catalog: &Group,
        warnings: &mut Vec<String>,
    ) -> Result<Self, ReadError> {
        let mut centres = Self {
            fields: Vec::new(),
            has_ids: true,
            entries: Vec::new(),
        };
        for name in catalog.names() {
            let id = name
                .parse::<i64>()
                .map_err(|_| catalog.malformed(name, "is no number of a phase centre"))?;
            let Some(entry) = catalog.group(name)? else {
                continue;
            };
            let place = centres.fields.len() as u32;
            let found = match read_entry(&entry, warnings)? {
                Ok(field) => {
                    centres.fields.push(field);
                    Ok(place)
                }
                Err(why) => Err(why),
            };
            centres.entries.push((id, found));
        }
        if !centres.fields.is_empty() {
            return Ok(centres);
        }
        let why = centres
            .entries
            .iter()
            .find_map(|entry| entry.1.clone().err());
        let what = why.unwrap_or_else(|| "is empty".into());
        Err(header.unsupported("phase_center_catalog", what))
    }

    fn old(header: &Group) -> Result<Self, ReadError> {
        let kind = header.need("phase_type")?.text()?;
        if matches!(kind.as_str(), "drift" | "unknown") {
            return Ok(Self {
                fields: vec![drifting(text(header, "object_name")?)],
                has_ids: false,
                entries: vec![(0, Ok(0))],
            });
        }
        if kind != "phased" {
            let what = format!("is '{kind}', must be 'phased', 'drift' or 'unknown'");
            return Err(header.unsupported("phase_type", what));
        }
        let frame_name = text(header, "phase_center_frame")?;
        let epoch = real(header, "phase_center_epoch")?;
        let frame = match frame_name.as_deref() {
            Some(name) => {
                frame(name, epoch).map_err(|what| header.unsupported("phase_center_frame", what))?
            }
            // Before there was phase_center_frame, positions were FK5 of their epoch.
            None => Frame::Fk5(epoch.unwrap_or(2000.0)),
        };
        let field = Field {
            name: text(header, "object_name")?.unwrap_or_default(),
            ra_rad: angle_rad(header, "phase_center_ra", std::f64::consts::TAU)?,
            dec_rad: angle_rad(header, "phase_center_dec", std::f64::consts::FRAC_PI_2)?,
            frame,
            drifts: false,
        };
        Ok(Self {
            fields: vec![field],
            has_ids: false,
            entries: vec![(0, Ok(0))],
        })
    }
}

/// An entry of the catalogue; why it is no phase centre is told in words, since nothing is wrong as
/// long as no row is of it.
fn read_entry(
    entry: &Group,
    warnings: &mut Vec<String>,
) -> Result<Result<Field, String>, ReadError> {
    let name = entry.need("cat_name")?.text()?;
    let kind = entry.need("cat_type")?.text()?;
    if matches!(kind.as_str(), "unprojected" | "driftscan") {
        return Ok(Ok(drifting(Some(name))));
    }
    if kind != "sidereal" {
        return Ok(Err(format!(
            "'{name}' is of type '{kind}': only sidereal phase centres are read; phase the data to one, \
             with pyuvdata's UVData.phase"
        )));
    }
    let frame_name = entry.need("cat_frame")?.text()?;
    let frame = match frame(&frame_name, real(entry, "cat_epoch")?) {
        Ok(frame) => frame,
        Err(why) => return Ok(Err(format!("'{name}': {why}"))),
    };
    let moves = [real(entry, "cat_pm_ra")?, real(entry, "cat_pm_dec")?];
    if moves.iter().flatten().any(|&mas_yr| mas_yr != 0.0) {
        warnings.push(format!(
            "the proper motion of phase centre '{name}' is ignored"
        ));
    }
    Ok(Ok(Field {
        ra_rad: angle_rad(entry, "cat_lon", std::f64::consts::TAU)?,
        dec_rad: angle_rad(entry, "cat_lat", std::f64::consts::FRAC_PI_2)?,
        name,
        frame,
        drifts: false,
    }))
}

/// A frame by the name that astropy has for it.
fn frame(name: &str, epoch: Option<f64>) -> Result<Frame, String> {
    match name.to_lowercase().as_str() {
        "icrs" => Ok(Frame::Icrs),
        "fk5" => Ok(Frame::Fk5(epoch.unwrap_or(2000.0))),
        "fk4" => Ok(Frame::Fk4(epoch.unwrap_or(1950.0))),
        other => Err(format!(
            "is in frame '{other}'; icrs, fk5 and fk4 are read: phase the data to one of these, \
             with pyuvdata's UVData.phase"
        )),
    }
}

fn angle_rad(group: &Group, name: &str, largest_rad: f64) -> Result<f64, ReadError> {
    let value = group.need(name)?.real()?;
    if value.is_finite() && value.abs() <= largest_rad + 1e-9 {
        return Ok(value);
    }
    Err(group.malformed(name, format!("{value} rad is no such angle")))
}

fn real(group: &Group, name: &str) -> Result<Option<f64>, ReadError> {
    group
        .dataset(name)?
        .map(|dataset| dataset.real())
        .transpose()
}

fn text(group: &Group, name: &str) -> Result<Option<String>, ReadError> {
    group
        .dataset(name)?
        .map(|dataset| dataset.text())
        .transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_have_their_usual_equinoxes() {
        assert_eq!(frame("icrs", Some(2000.0)), Ok(Frame::Icrs));
        assert_eq!(frame("FK5", None), Ok(Frame::Fk5(2000.0)));
        assert_eq!(frame("fk4", None), Ok(Frame::Fk4(1950.0)));
        assert!(frame("altaz", None).is_err());
    }
}
