//! Lists of sources: the truth of a simulation, or any catalogue with these columns.

use std::path::Path;

use vis2cat_formats::fits::{Keyword, TableSpec, write_tables};
use vis2cat_formats::{ReadError, WriteError};

use super::band::ucd_band;
use super::columns::{TRUTH, build, is_of_spectrum};
use super::header::minimal;
use super::list::{ListTable, Unit, malformed};
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
    /// Spectral index; NaN if not known.
    pub spectral_index: f64,
    /// Signal-to-noise ratio in the visibilities, S sqrt(Y); NaN if not known.
    pub snr: f64,
}

/// Writes `sources` as the table `TRUTH`: RA, DEC, Total_flux, Spectral_index where one is known,
/// Scale_length, E1, E2, SNR.
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
    let mut columns = build(TRUTH, sources, ucd_band(ref_freq_hz));
    let has_index = sources.iter().any(|s| s.spectral_index.is_finite());
    columns.retain(|column| has_index || !is_of_spectrum(&column.name));
    let table = TableSpec {
        extname: "TRUTH".to_owned(),
        columns,
        cards: cards.clone(),
    };
    write_tables(path, overwrite, &cards, &[table])
}

/// A list of sources, and which of its columns the file has.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SourceList {
    /// The sources.
    pub sources: Vec<CatalogueSource>,
    /// There is a column of scale-lengths; otherwise all are points.
    pub has_scale: bool,
    /// There are columns of ellipticities; otherwise all are round.
    pub has_ellipticity: bool,
}

/// Reads sources from the first binary table of a FITS file, or from CSV.
///
/// | column, in any case | unit, unless the table says another |
/// |---|---|
/// | `RA`, `DEC` | deg (also rad, arcmin, arcsec, mas) |
/// | `Total_flux` or `flux` | uJy (also Jy, mJy, nJy) |
/// | `Scale_length`: 0 if there is none | arcsec (also deg, rad, arcmin, mas) |
/// | `E1`, `E2`: 0 if there are none | |
/// | `Spectral_index`: NaN if there is none | |
/// | `SNR`: NaN if there is none | |
///
/// The unit is that of `TUNITn`, or in CSV follows the name: `Total_flux[mJy]`.
///
/// # Errors
/// The file cannot be read; a column or unit is missing or unknown; a position, flux density, size or
/// ellipticity is not finite or impossible. The error names column and row.
pub fn read_sources(path: &Path) -> Result<Vec<CatalogueSource>, ReadError> {
    Ok(read_source_list(path)?.sources)
}

/// As [`read_sources`], with what the file says of sizes and shapes.
///
/// # Errors
/// Those of [`read_sources`].
pub fn read_source_list(path: &Path) -> Result<SourceList, ReadError> {
    let table = ListTable::open(path)?;
    let columns = Columns::read(&table)?;
    let sources = (0..table.rows()).map(|row| columns.source(path, row));
    Ok(SourceList {
        sources: sources.collect::<Result<_, _>>()?,
        has_scale: table.has("Scale_length"),
        has_ellipticity: table.has("E1") && table.has("E2"),
    })
}

/// The columns that make a source, in radians and janskys.
struct Columns {
    ra_rad: Vec<f64>,
    dec_rad: Vec<f64>,
    flux_jy: Vec<f64>,
    scale_rad: Vec<f64>,
    e1: Vec<f64>,
    e2: Vec<f64>,
    spectral_index: Vec<f64>,
    snr: Vec<f64>,
}

impl Columns {
    fn read(table: &ListTable) -> Result<Self, ReadError> {
        Ok(Self {
            ra_rad: table.need("RA", Unit::angle("deg"))?,
            dec_rad: table.need("DEC", Unit::angle("deg"))?,
            flux_jy: table.need_flux()?,
            scale_rad: table.column_or("Scale_length", Unit::angle("arcsec"), 0.0)?,
            e1: table.column_or("E1", Unit::NONE, 0.0)?,
            e2: table.column_or("E2", Unit::NONE, 0.0)?,
            spectral_index: table.column_or("Spectral_index", Unit::NONE, f64::NAN)?,
            snr: table.column_or("SNR", Unit::NONE, f64::NAN)?,
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
            spectral_index: self.spectral_index[row],
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
