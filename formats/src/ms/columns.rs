//! Which columns the visibilities and their weights are taken from.
//!
//! # Source
//! Note, section on MAIN. A column may be there without any cells (`WEIGHT_SPECTRUM` mostly is), and
//! what casacore does to tell costs a megabyte that is never given back: the first row stands for
//! all, and is asked once.

use crate::ReadError;
use crate::casa::Table;

/// The column of visibilities: the one asked for, or `CORRECTED_DATA`, or `DATA`.
pub(super) fn data(main: &mut Table, wanted: Option<&str>) -> Result<String, ReadError> {
    if let Some(name) = wanted {
        main.array::<num_complex::Complex<f32>>(name, 0)?;
        return Ok(name.to_owned());
    }
    let corrected = "CORRECTED_DATA";
    if main.has(corrected)
        && main
            .array::<num_complex::Complex<f32>>(corrected, 0)
            .is_ok()
    {
        return Ok(corrected.to_owned());
    }
    if !main.has("DATA") && main.has("FLOAT_DATA") {
        let what = "there is FLOAT_DATA but no DATA: single-dish spectra are not read";
        return Err(main.unsupported("FLOAT_DATA", 0, what.into()));
    }
    Ok("DATA".to_owned())
}

/// Where weights come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Weights {
    pub(super) column: &'static str,
    /// Whether each channel has its own.
    pub(super) by_channel: bool,
    /// Whether the column has standard deviations, which make weights of 1/σ².
    pub(super) is_sigma: bool,
}

/// In the order in which they are preferred.
const WEIGHTS: [Weights; 4] = [
    weights("WEIGHT_SPECTRUM", true, false),
    weights("WEIGHT", false, false),
    weights("SIGMA_SPECTRUM", true, true),
    weights("SIGMA", false, true),
];

const fn weights(column: &'static str, by_channel: bool, is_sigma: bool) -> Weights {
    Weights {
        column,
        by_channel,
        is_sigma,
    }
}

impl Weights {
    /// The first that is filled.
    pub(super) fn choose(main: &mut Table) -> Result<Self, ReadError> {
        let filled = WEIGHTS
            .into_iter()
            .find(|w| main.has(w.column) && main.array::<f32>(w.column, 0).is_ok());
        filled.ok_or_else(|| {
            main.malformed("has no weights: WEIGHT_SPECTRUM, WEIGHT, SIGMA_SPECTRUM and SIGMA are missing or empty")
        })
    }

    /// Weight of a value of the column.
    pub(super) fn weight(&self, value: f32) -> f32 {
        match (self.is_sigma, value > 0.0) {
            (false, _) => value,
            (true, true) => 1.0 / (value * value),
            (true, false) => 0.0,
        }
    }
}
