//! Do the visibilities look as the catalogue says that they should?
//!
//! A single visibility is mostly noise, and the mean of its amplitude mostly noise as well. So the data d
//! of a bin of baseline lengths are rotated by the phases of the model m, and weighted by its amplitude,
//!
//! ```text
//! A = Σ w Re(d m*) / sqrt(Σ w Σ w |m|²)      σ_A = 1/sqrt(Σ w)
//! ```
//!
//! which for the model itself is its root mean square amplitude, and for data that are the model and noise
//! is the same on the mean, whatever the noise. With a draw from the posterior in the place of d it is what
//! the posterior predicts. What is left is measured by χ² = Σ w |d - m|² over two a sample.

mod draws;
mod model;
mod sums;

use std::path::PathBuf;

use vis2cat_formats::ReadOptions;

use self::draws::draws;
use self::model::{configuration, open};
use self::sums::{Sums, merged};
use super::Contents;
use super::contents::file_name;
use crate::coords::{IcrsCentre, RaDec};
use crate::run::{RunError, digest};
use crate::units::MICROJY;

/// Draws from the posterior.
const N_DRAW: usize = 24;

/// Which visibilities, and what of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CheckOptions {
    /// The files.
    pub inputs: Vec<PathBuf>,
    /// Field, windows and column, where they are others than those of the run.
    pub read: ReadOptions,
}

/// The visibilities beside what the catalogue predicts.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Names of the files.
    pub inputs: Vec<String>,
    /// Whether they are what the catalogue was made of, where it says so.
    pub is_same_input: Option<bool>,
    /// Draws from the posterior; 0 where there are no samples, and predictions are the model's.
    pub n_draw: usize,
    /// Stokes I samples.
    pub n_sample: u64,
    /// χ² over two a sample, of what is left.
    pub chi2: f64,
    /// The same of the data as they are.
    pub chi2_of_data: f64,
    /// By baseline length, short to long.
    pub bins: Vec<UvBin>,
}

/// Baselines of similar length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UvBin {
    /// Shortest and longest [wavelength].
    pub ends: [f64; 2],
    /// Stokes I samples.
    pub n_sample: u64,
    /// Amplitude of the data along the model [uJy].
    pub data_ujy: f64,
    /// Its error [uJy].
    pub err_ujy: f64,
    /// Amplitude of the model [uJy].
    pub model_ujy: f64,
    /// What the posterior predicts: mean and standard deviation, without noise [uJy].
    pub predicted_ujy: [f64; 2],
    /// χ² over two a sample.
    pub chi2: f64,
}

impl UvBin {
    /// Data less prediction, in standard deviations of noise and posterior together.
    pub fn pull(&self) -> f64 {
        let [mean, deviation] = self.predicted_ujy;
        (self.data_ujy - mean) / self.err_ujy.hypot(deviation)
    }

    /// Expected standard deviation of `chi2`.
    pub fn chi2_err(&self) -> f64 {
        1.0 / (self.n_sample as f64).sqrt()
    }
}

/// Compares visibilities with the catalogue, in two passes over the files: noise as in a search, then the
/// comparison. `progress` is told the stage, and how much of it is done.
///
/// # Errors
/// A file cannot be read, or is of another part of the sky.
pub fn check(
    contents: &Contents,
    options: &CheckOptions,
    progress: &mut dyn FnMut(&'static str, u64, u64),
) -> Result<Check, RunError> {
    let config = configuration(&contents.details)?;
    let digests = options.inputs.iter().map(|input| digest(input));
    let digests = digests.collect::<Result<Vec<String>, _>>()?;
    let mut dataset = open(contents, options, &config, progress)?;
    let field = dataset.phase_centre();
    let native = RaDec {
        ra_rad: field.ra_rad,
        dec_rad: field.dec_rad,
    };
    let frame = IcrsCentre::new(native, field.frame);
    let draws = draws(contents, &config, frame, N_DRAW);
    let mut sums = Sums::new(config.prior.profile, draws);
    let n_sample = dataset.info().n_sample;
    let mut n_done = 0;
    dataset.for_each_batch(|blocks| {
        sums.add(blocks);
        n_done += blocks.iter().map(|block| block.len() as u64).sum::<u64>();
        progress("comparing", n_done, n_sample);
    })?;
    let whole = sums.whole();
    let degrees = 2.0 * whole.n_sample as f64;
    Ok(Check {
        inputs: options
            .inputs
            .iter()
            .map(|input| file_name(input))
            .collect(),
        is_same_input: is_same_input(contents, &digests),
        n_draw: sums.n_draw(),
        n_sample: whole.n_sample,
        chi2: whole.left / degrees,
        chi2_of_data: whole.data / degrees,
        bins: merged(&sums)
            .iter()
            .map(|(ends, sum)| sum.bin(*ends))
            .collect(),
    })
}

/// Whether `RUN` has the digests of the same bytes.
fn is_same_input(contents: &Contents, digests: &[String]) -> Option<bool> {
    let is_digest = |key: &str| key.starts_with("input.") && key.ends_with("blake3");
    let entries = contents
        .details
        .run
        .iter()
        .filter(|entry| is_digest(&entry.key));
    let mut known: Vec<&str> = entries.map(|entry| entry.value.as_str()).collect();
    let mut given: Vec<&str> = digests.iter().map(String::as_str).collect();
    known.sort_unstable();
    given.sort_unstable();
    (!known.is_empty()).then(|| known == given)
}

/// Janskys to microjanskys.
fn ujy(jy: f64) -> f64 {
    jy / MICROJY
}
