//! The numbers of an evaluation, in the units of the catalogue.

use serde::Serialize;

use super::candidates::Candidates;
use super::matching::{MATCH_FLOOR_RAD, MATCH_N_SIGMA};
use super::parameters::{PARAMETERS, difference};
use super::{
    Binned, Curve, Fraction, Matched, POPULATION_SNR, Pair, ParameterReport, ReliabilityBin,
};
use crate::catalogue::Estimate;
use crate::units::{ARCSEC, DEG, MICROJY};

/// How good a catalogue is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// Match radius in standard deviations of the position.
    pub match_n_sigma: f64,
    /// Smallest match radius [arcsec].
    pub match_floor_arcsec: f64,
    /// Rows of the catalogue.
    pub n_row: usize,
    /// True sources in the searched field.
    pub n_truth: usize,
    /// True sources outside it, which do not count for completeness.
    pub n_truth_outside: usize,
    /// True sources in the field that were found.
    pub completeness: Fraction,
    /// Those with a signal-to-noise ratio of at least [`POPULATION_SNR`].
    pub completeness_snr_5: Fraction,
    /// Rows that are true.
    pub purity: Fraction,
    /// Area that was searched [deg²]; NaN if the catalogue does not say.
    pub area_deg2: f64,
    /// Rows that are not true, for each square degree.
    pub false_per_deg2: f64,
    /// Biases, pulls and coverage.
    pub parameters: Vec<ParameterReport>,
    /// Completeness and purity by signal-to-noise ratio, flux density and size.
    pub bins: Vec<Binned>,
    /// Table of the modes that `curves` and `reliability` are of.
    pub modes_table: &'static str,
    /// Modes among them.
    pub n_mode: usize,
    /// Modes that are not: no cut makes them sources, or they are seen twice.
    pub n_mode_left_out: usize,
    /// What other cuts would have kept.
    pub curves: Vec<Curve>,
    /// Are probabilities what they say?
    pub reliability: Vec<ReliabilityBin>,
    /// Rows that are true, in the order of the catalogue.
    pub matched: Vec<MatchedRow>,
    /// True sources in the field that were not found.
    pub missed: Vec<MissedSource>,
    /// Rows that are not true.
    pub false_rows: Vec<FalseRow>,
}

/// A row with its true source; both are counted from 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MatchedRow {
    /// Row of the catalogue.
    pub row: usize,
    /// Row of the truth.
    pub truth_row: usize,
    /// Name of the source.
    pub name: String,
    /// Distance on the sky [arcsec].
    pub separation_arcsec: f64,
    /// True signal-to-noise ratio.
    pub true_snr: f64,
    /// True flux density [uJy].
    pub true_flux_ujy: f64,
    /// Estimate - truth of each of [`PARAMETERS`], in its unit.
    pub differences: [f64; PARAMETERS.len()],
    /// The same over the error.
    pub pulls: [f64; PARAMETERS.len()],
}

/// A true source that was not found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MissedSource {
    /// Row of the truth, from 1.
    pub truth_row: usize,
    /// Right ascension [deg].
    pub ra_deg: f64,
    /// Declination [deg].
    pub dec_deg: f64,
    /// Total flux density [uJy].
    pub flux_ujy: f64,
    /// Signal-to-noise ratio.
    pub snr: f64,
}

/// A row that is no true source.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FalseRow {
    /// Row of the catalogue, from 1.
    pub row: usize,
    /// Name of the source.
    pub name: String,
    /// Right ascension [deg].
    pub ra_deg: f64,
    /// Declination [deg].
    pub dec_deg: f64,
    /// Total flux density [uJy].
    pub flux_ujy: f64,
    /// Signal-to-noise ratio.
    pub snr: f64,
}

/// Everything that is counted or listed; the rest is empty.
pub(super) fn counts(matched: &Matched, candidates: &Candidates) -> Evaluation {
    let is_found = matched.is_found();
    let found_of =
        |population: Vec<usize>| Fraction::of(population.into_iter().map(|i| is_found[i]));
    let all = matched.population(|_| true);
    let (n_row, n_truth) = (matched.found.rows.len(), all.len());
    let area_deg2 = matched.found.field.map_or(f64::NAN, |f| f.area_deg2());
    let n_false = n_row - matched.pairs.len();
    Evaluation {
        match_n_sigma: MATCH_N_SIGMA,
        match_floor_arcsec: MATCH_FLOOR_RAD / ARCSEC,
        n_row,
        n_truth,
        n_truth_outside: matched.truth.sources.len() - n_truth,
        completeness: found_of(all),
        completeness_snr_5: found_of(matched.population(|s| s.snr >= POPULATION_SNR)),
        purity: Fraction::new(matched.pairs.len(), n_row),
        area_deg2,
        false_per_deg2: n_false as f64 / area_deg2,
        parameters: Vec::new(),
        bins: Vec::new(),
        modes_table: candidates.table,
        n_mode: candidates.list.len(),
        n_mode_left_out: candidates.n_left_out,
        curves: Vec::new(),
        reliability: Vec::new(),
        matched: matched
            .pairs
            .iter()
            .map(|p| matched_row(matched, p))
            .collect(),
        missed: missed(matched, &is_found),
        false_rows: false_rows(matched),
    }
}

fn matched_row(matched: &Matched, pair: &Pair) -> MatchedRow {
    let differences = std::array::from_fn(|which| difference(matched, pair, which));
    let pull = |difference: Estimate| {
        if difference.err > 0.0 {
            difference.mean / difference.err
        } else {
            f64::NAN
        }
    };
    MatchedRow {
        row: pair.row + 1,
        truth_row: pair.truth + 1,
        name: matched.row(pair).name.clone(),
        separation_arcsec: pair.separation_rad / ARCSEC,
        true_snr: matched.source(pair).snr,
        true_flux_ujy: matched.source(pair).flux_jy / MICROJY,
        differences: differences.map(|difference| difference.mean),
        pulls: differences.map(pull),
    }
}

fn missed(matched: &Matched, is_found: &[bool]) -> Vec<MissedSource> {
    let missed = matched.population(|_| true).into_iter();
    let source = |i: usize| {
        let source = &matched.truth.sources[i];
        MissedSource {
            truth_row: i + 1,
            ra_deg: source.position.ra_rad / DEG,
            dec_deg: source.position.dec_rad / DEG,
            flux_ujy: source.flux_jy / MICROJY,
            snr: source.snr,
        }
    };
    missed.filter(|&i| !is_found[i]).map(source).collect()
}

fn false_rows(matched: &Matched) -> Vec<FalseRow> {
    let truth_of_row = matched.truth_of_row();
    let rows = matched.found.rows.iter().enumerate();
    rows.filter(|(i, _)| truth_of_row[*i].is_none())
        .map(|(i, row)| FalseRow {
            row: i + 1,
            name: row.name.clone(),
            ra_deg: row.position.ra_rad / DEG,
            dec_deg: row.position.dec_rad / DEG,
            flux_ujy: row.flux_jy.mean / MICROJY,
            snr: row.snr,
        })
        .collect()
}
