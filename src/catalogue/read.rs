//! A catalogue read back: rows, modes and posterior samples.

mod modes;
mod samples;

use std::ops::Range;
use std::path::Path;

use vis2cat_formats::ReadError;
use vis2cat_formats::fits::Value;

use super::list::{ListTable, Unit};
use super::row::Estimate;
use super::write::CataloguePaths;
use crate::coords::{Lm, RaDec};
use crate::units::{ARCSEC, DEG};

pub use modes::FoundMode;
pub use samples::FoundSamples;

/// What a catalogue says that was found; what it does not say is NaN or `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FoundCatalogue {
    /// Its sources, in the order of the file.
    pub rows: Vec<FoundRow>,
    /// `MODES`, where there is such a table.
    pub modes: Option<Vec<FoundMode>>,
    /// The posterior samples of all rows, where they lie beside the catalogue.
    pub samples: Option<FoundSamples>,
    /// The field that was searched.
    pub field: Option<SearchedField>,
}

/// One source of a catalogue.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundRow {
    /// Name; empty if it has none.
    pub name: String,
    /// Number within the catalogue.
    pub source_id: Option<i64>,
    /// Position, ICRS.
    pub position: RaDec,
    /// Standard deviation of the position towards east on the sky [rad].
    pub e_ra_rad: f64,
    /// Standard deviation towards north [rad].
    pub e_dec_rad: f64,
    /// Total flux density [Jy].
    pub flux_jy: Estimate,
    /// Its 16th and 84th percentile [Jy].
    pub flux_lo_hi_jy: [f64; 2],
    /// Scale-length [rad].
    pub scale_rad: Estimate,
    /// Ellipticity along l.
    pub e1: Estimate,
    /// Ellipticity along the diagonal.
    pub e2: Estimate,
    /// Spectral index.
    pub spectral_index: Estimate,
    /// Signal-to-noise ratio in the visibilities, S sqrt(Y).
    pub snr: f64,
    /// Matched-filter signal-to-noise ratio at the best sample.
    pub snr_peak: f64,
    /// Probability that this is a source.
    pub p_source: f64,
    /// Its rows in [`FoundCatalogue::samples`]; empty if there are none.
    pub samples: Range<usize>,
}

/// The square on the sky that was searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchedField {
    /// Where l = m = 0, ICRS.
    pub centre: RaDec,
    /// Lowest l and m [rad].
    pub low: Lm,
    /// Highest l and m [rad].
    pub high: Lm,
}

impl SearchedField {
    /// Whether `position` lies in it.
    pub fn contains(&self, position: RaDec) -> bool {
        let lm = position.to_lm(self.centre);
        // The far side of the sky has the same direction cosines.
        position.separation_rad(self.centre) < std::f64::consts::FRAC_PI_2
            && (self.low.l..=self.high.l).contains(&lm.l)
            && (self.low.m..=self.high.m).contains(&lm.m)
    }

    /// Its area [deg²], as seen in the (l, m) plane.
    pub fn area_deg2(&self) -> f64 {
        (self.high.l - self.low.l) / DEG * ((self.high.m - self.low.m) / DEG)
    }
}

/// Reads `path`, a FITS catalogue of vis2cat or any FITS, VOTable or CSV table with RA, DEC and Total_flux, and
/// the posterior samples beside it if they are there.
///
/// Columns are named as in `CATALOGUE`; angles may be in deg, rad, arcmin, arcsec or mas, flux
/// densities in Jy, mJy, uJy or nJy, as the table says.
///
/// # Errors
/// A file cannot be read; RA, DEC or Total_flux is missing; a unit or a status is unknown; a position
/// is not finite; or the samples are not those of the catalogue. The error names table, column and
/// row.
pub fn read_catalogue(path: &Path) -> Result<FoundCatalogue, ReadError> {
    let table = ListTable::open(path)?;
    let mut rows = rows(&table)?;
    let modes = ListTable::find(path, "MODES")?;
    let modes = modes.map(|table| modes::read(&table)).transpose()?;
    let beside = CataloguePaths::new(path).posterior;
    let samples = if table.has("Post_row") && beside.exists() {
        Some(samples::read(&beside, &table, &mut rows)?)
    } else {
        None
    };
    Ok(FoundCatalogue {
        rows,
        modes,
        samples,
        field: field(&table),
    })
}

fn rows(table: &ListTable) -> Result<Vec<FoundRow>, ReadError> {
    let angle = |name: &str, unit| table.column_or(name, Unit::angle(unit), f64::NAN);
    let number = |name: &str| table.column_or(name, Unit::NONE, f64::NAN);
    let flux = |name: &str| table.column_or(name, Unit::FLUX, f64::NAN);
    let positions = positions(table)?;
    let names = table.strings("Source_name")?;
    let source_id = number("Source_id")?;
    let (e_ra_rad, e_dec_rad) = (angle("E_RA", "arcsec")?, angle("E_DEC", "arcsec")?);
    let (flux_jy, e_flux_jy) = (table.need_flux()?, flux("E_Total_flux")?);
    let (low_jy, high_jy) = (flux("Total_flux_lo")?, flux("Total_flux_hi")?);
    let scale_rad = angle("Scale_length", "arcsec")?;
    let e_scale_rad = angle("E_Scale_length", "arcsec")?;
    let [e1, e_e1, e2, e_e2] = [
        number("E1")?,
        number("E_E1")?,
        number("E2")?,
        number("E_E2")?,
    ];
    let (index, e_index) = (number("Spectral_index")?, number("E_Spectral_index")?);
    let (snr, snr_peak, p_source) = (number("SNR")?, number("SNR_peak")?, number("P_source")?);
    let estimate = |mean: &[f64], err: &[f64], i: usize| Estimate {
        mean: mean[i],
        err: err[i],
    };
    let row = |(i, position): (usize, RaDec)| FoundRow {
        name: names.as_ref().map_or_else(String::new, |n| n[i].clone()),
        source_id: whole(source_id[i]),
        position,
        e_ra_rad: e_ra_rad[i],
        e_dec_rad: e_dec_rad[i],
        flux_jy: estimate(&flux_jy, &e_flux_jy, i),
        flux_lo_hi_jy: [low_jy[i], high_jy[i]],
        scale_rad: estimate(&scale_rad, &e_scale_rad, i),
        e1: estimate(&e1, &e_e1, i),
        e2: estimate(&e2, &e_e2, i),
        spectral_index: estimate(&index, &e_index, i),
        snr: snr[i],
        snr_peak: snr_peak[i],
        p_source: p_source[i],
        samples: 0..0,
    };
    Ok(positions.into_iter().enumerate().map(row).collect())
}

/// The columns RA and DEC, every value finite.
fn positions(table: &ListTable) -> Result<Vec<RaDec>, ReadError> {
    let ra_rad = table.need("RA", Unit::angle("deg"))?;
    let dec_rad = table.need("DEC", Unit::angle("deg"))?;
    let position = |(row, (ra_rad, dec_rad)): (usize, (f64, f64))| {
        if ra_rad.is_finite() && dec_rad.is_finite() {
            return Ok(RaDec { ra_rad, dec_rad });
        }
        let place = format!("row {}, columns RA and DEC", row + 1);
        Err(table.malformed(&place, "not finite"))
    };
    ra_rad
        .into_iter()
        .zip(dec_rad)
        .enumerate()
        .map(position)
        .collect()
}

/// An identifier; NaN and what `TNULL` declares are none.
fn whole(value: f64) -> Option<i64> {
    (value.is_finite() && value >= 0.0).then_some(value as i64)
}

/// The field that the header tells of: `PHASERA`, `PHASEDEC` and the priors of L and M [arcsec].
fn field(table: &ListTable) -> Option<SearchedField> {
    let real = |key: &str| match table.keyword(key)? {
        Value::Real(value) => Some(*value),
        Value::Integer(value) => Some(*value as f64),
        _ => None,
    };
    let range = |name: &str| {
        let is_it = |n: &u32| {
            let value = table.keyword(&format!("PRNAM{n}"));
            matches!(value, Some(Value::Text(text)) if text == name)
        };
        let n = (1..100).find(is_it)?;
        let end = |stem: &str| Some(real(&format!("{stem}{n}"))? * ARCSEC);
        Some([end("PRMIN")?, end("PRMAX")?])
    };
    let ([l_low, l_high], [m_low, m_high]) = (range("L")?, range("M")?);
    Some(SearchedField {
        centre: RaDec {
            ra_rad: real("PHASERA")? * DEG,
            dec_rad: real("PHASEDEC")? * DEG,
        },
        low: Lm { l: l_low, m: m_low },
        high: Lm {
            l: l_high,
            m: m_high,
        },
    })
}
