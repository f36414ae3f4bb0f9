//! Lists of sources: the truth of a simulation, or any catalogue with these columns.

mod csv_table;
mod units;

use std::path::Path;

use vis2cat_formats::fits::{Keyword, Table, TableSpec, is_fits, read_table, write_tables};
use vis2cat_formats::{ReadError, WriteError};

use self::csv_table::CsvTable;
use self::units::{Dimension, Unit};
use super::band::ucd_band;
use super::columns::{TRUTH, build};
use super::header::minimal;
use crate::coords::RaDec;
use crate::rime::shape::Ellipticity;

/// One source of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CatalogueSource {
    /// Position, ICRS.
    pub position: RaDec,
    /// Total flux density [Jy].
    pub flux_jy: f64,
    /// Scale-length [rad]; 0 is a point.
    pub scale_rad: f64,
    /// Ellipticity.
    pub e: Ellipticity,
    /// Signal-to-noise ratio in the visibilities, S sqrt(Y); NaN if not known.
    pub snr: f64,
}

/// Writes `sources` as the table `TRUTH`: RA, DEC, Total_flux, Scale_length, E1, E2, SNR.
///
/// # Errors
/// The file exists and `overwrite` is false, or it cannot be written.
pub fn write_truth(
    path: &Path,
    overwrite: bool,
    ref_freq_hz: Option<f64>,
    sources: &[CatalogueSource],
) -> Result<(), WriteError> {
    let mut cards = minimal();
    cards
        .keywords
        .push(Keyword::new("RADESYS", "ICRS", "frame of all positions"));
    let table = TableSpec {
        extname: "TRUTH".to_owned(),
        columns: build(TRUTH, sources, ucd_band(ref_freq_hz)),
        cards: cards.clone(),
    };
    write_tables(path, overwrite, &cards, &[table])
}

/// Reads sources from the first binary table of a FITS file, or from CSV.
///
/// | column, in any case | unit, unless the table says another |
/// |---|---|
/// | `RA`, `DEC` | deg (also rad, arcmin, arcsec, mas) |
/// | `Total_flux` | uJy (also Jy, mJy, nJy) |
/// | `Scale_length`: 0 if there is none | arcsec (also deg, rad, arcmin, mas) |
/// | `E1`, `E2`: 0 if there are none | |
/// | `SNR`: NaN if there is none | |
///
/// The unit is that of `TUNITn`, or in CSV follows the name: `Total_flux[mJy]`.
///
/// # Errors
/// The file cannot be read; a column or unit is missing or unknown; a position, flux density, size or
/// ellipticity is not finite or impossible. The error names column and row.
pub fn read_sources(path: &Path) -> Result<Vec<CatalogueSource>, ReadError> {
    let columns = if is_fits(path)? {
        let table = read_table(path, None)?;
        Columns::collect(path, table.rows(), |wanted| from_fits(&table, wanted))?
    } else {
        let table = CsvTable::read(path)?;
        Columns::collect(path, table.rows(), |wanted| table.numbers(wanted))?
    };
    (0..columns.rows)
        .map(|row| columns.source(path, row))
        .collect()
}

/// A column's unit as the file gives it, and its values.
type Raw = (Option<String>, Vec<f64>);

fn from_fits(table: &Table, name: &str) -> Result<Option<Raw>, ReadError> {
    let Some(column) = table.column(name) else {
        return Ok(None);
    };
    Ok(Some((column.unit.clone(), table.numbers(name)?)))
}

/// The columns that make a source, in radians and janskys.
struct Columns {
    rows: usize,
    ra_rad: Vec<f64>,
    dec_rad: Vec<f64>,
    flux_jy: Vec<f64>,
    scale_rad: Vec<f64>,
    e1: Vec<f64>,
    e2: Vec<f64>,
    snr: Vec<f64>,
}

impl Columns {
    fn collect(
        path: &Path,
        rows: usize,
        mut get: impl FnMut(&str) -> Result<Option<Raw>, ReadError>,
    ) -> Result<Self, ReadError> {
        let mut column = |name: &str, unit: Unit, default: Option<f64>| {
            let Some((given, mut values)) = get(name)? else {
                return match default {
                    Some(value) => Ok(vec![value; rows]),
                    None => Err(malformed(
                        path,
                        format!("column {name}"),
                        "there is none; RA, DEC and Total_flux are needed",
                    )),
                };
            };
            let factor = unit.factor(given.as_deref());
            let factor = factor.map_err(|what| malformed(path, format!("column {name}"), &what))?;
            for value in &mut values {
                *value *= factor;
            }
            Ok(values)
        };
        let number = Unit::none();
        Ok(Self {
            rows,
            ra_rad: column("RA", Unit::new(Dimension::Angle, "deg"), None)?,
            dec_rad: column("DEC", Unit::new(Dimension::Angle, "deg"), None)?,
            flux_jy: column("Total_flux", Unit::new(Dimension::Flux, "uJy"), None)?,
            scale_rad: column(
                "Scale_length",
                Unit::new(Dimension::Angle, "arcsec"),
                Some(0.0),
            )?,
            e1: column("E1", number, Some(0.0))?,
            e2: column("E2", number, Some(0.0))?,
            snr: column("SNR", number, Some(f64::NAN))?,
        })
    }

    fn source(&self, path: &Path, row: usize) -> Result<CatalogueSource, ReadError> {
        let source = CatalogueSource {
            position: RaDec {
                ra_rad: self.ra_rad[row],
                dec_rad: self.dec_rad[row],
            },
            flux_jy: self.flux_jy[row],
            scale_rad: self.scale_rad[row],
            e: Ellipticity {
                e1: self.e1[row],
                e2: self.e2[row],
            },
            snr: self.snr[row],
        };
        match fault(&source) {
            None => Ok(source),
            Some((column, what)) => {
                let place = format!("row {}, column {column}", row + 1);
                Err(malformed(path, place, what))
            }
        }
    }
}

/// The column that no source can have, and why.
fn fault(source: &CatalogueSource) -> Option<(&'static str, &'static str)> {
    // A hair more than a right angle: degrees to radians and back may round.
    let pole = std::f64::consts::FRAC_PI_2 * (1.0 + 1e-12);
    let e = source.e.e1.hypot(source.e.e2);
    let checks = [
        ("RA", source.position.ra_rad.is_finite(), "not finite"),
        (
            "DEC",
            (-pole..=pole).contains(&source.position.dec_rad),
            "not within 90 degrees of the equator",
        ),
        ("Total_flux", source.flux_jy.is_finite(), "not finite"),
        (
            "Scale_length",
            (0.0..f64::INFINITY).contains(&source.scale_rad),
            "not a size",
        ),
        (
            "E1",
            (0.0..1.0).contains(&e),
            "the ellipticity (E1, E2) must be shorter than 1",
        ),
    ];
    let failed = checks.into_iter().find(|(_, fine, _)| !fine);
    failed.map(|(column, _, what)| (column, what))
}

fn malformed(path: &Path, place: String, what: &str) -> ReadError {
    ReadError::Malformed {
        path: path.into(),
        place,
        what: what.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{ARCSEC, DEG};

    fn read(text: &str) -> Result<Vec<CatalogueSource>, ReadError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("sources.csv");
        std::fs::write(&path, text).unwrap();
        read_sources(&path)
    }

    #[test]
    fn csv_with_default_units_and_nothing_but_positions_gives_points() {
        let sources = read("# made by hand\nra, Dec ,TOTAL_FLUX\n10,-30,25\n").unwrap();
        assert_eq!(sources.len(), 1);
        let s = sources[0];
        assert!((s.position.ra_rad - 10.0 * DEG).abs() < 1e-15);
        assert!((s.flux_jy - 25e-6).abs() < 1e-18);
        assert!(s.scale_rad == 0.0 && s.e == Ellipticity::default() && s.snr.is_nan());
    }

    #[test]
    fn csv_units_stand_in_the_names() {
        let text = "RA[rad],DEC [deg],Total_flux[mJy],Scale_length[deg],E1,E2,SNR\n\
                    1.0,2.0,3.0,0.001,0.1,-0.2,9\n";
        let s = read(text).unwrap()[0];
        assert!(s.position.ra_rad == 1.0 && (s.flux_jy - 3e-3).abs() < 1e-17);
        assert!((s.scale_rad / ARCSEC - 3.6).abs() < 1e-9);
        assert!(s.e.e2 == -0.2 && s.snr == 9.0);
    }

    #[test]
    fn both_characters_for_micro_are_understood() {
        for micro in ['u', '\u{b5}', '\u{3bc}'] {
            let sources = read(&format!("RA,DEC,Total_flux[{micro}Jy]\n1,2,3\n")).unwrap();
            assert!((sources[0].flux_jy - 3e-6).abs() < 1e-20);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, named) in [
            ("RA,DEC\n1,2\n", "Total_flux"),
            ("RA,DEC,Total_flux[K]\n1,2,3\n", "K"),
            ("RA,DEC,Total_flux\n1,x,3\n", "row 1, column DEC"),
            ("RA,DEC,Total_flux\n1,2\n", "row 1"),
            ("RA,DEC,Total_flux\n1,95,3\n", "row 1, column DEC"),
            ("RA,DEC,Total_flux\n1,2,\n", "row 1, column Total_flux"),
            ("RA,DEC,Total_flux,E1\n1,2,3,1.5\n", "column E1"),
            ("RA,ra,DEC,Total_flux\n1,1,2,3\n", "twice"),
            ("", "column RA"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(named), "{text:?}: {error}");
        }
    }
}
