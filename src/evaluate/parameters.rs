//! Are estimates right, and their errors honest?

use serde::Serialize;

use super::interval::{Cases, Coverage, rank};
use super::{Matched, Mean, Pair};
use crate::catalogue::{CatalogueSource, Estimate, FoundRow, FoundSamples};
use crate::coords::RaDec;
use crate::units::{ARCSEC, MICROJY};

/// Columns whose estimates are compared with the truth, with their units. RA and DEC are offsets on
/// the sky towards east and north.
pub const PARAMETERS: [(&str, &str); 7] = [
    ("RA", "arcsec"),
    ("DEC", "arcsec"),
    ("Total_flux", "uJy"),
    ("Scale_length", "arcsec"),
    ("E1", ""),
    ("E2", ""),
    ("Spectral_index", ""),
];

/// Pulls beyond this are counted: a good error leaves none.
const FAR_PULL: f64 = 5.0;

/// How one parameter of all matched rows compares with the truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterReport {
    /// Column of the catalogue.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Mean of estimate minus truth, in that unit.
    pub bias: Mean,
    /// Mean of the pulls, (estimate - truth) / error, which should be 0.
    pub pull_mean: f64,
    /// Root mean square of the pulls, which should be 1.
    pub pull_rms: f64,
    /// The pull that is furthest from 0.
    pub pull_largest: f64,
    /// Pulls beyond five standard deviations.
    pub n_beyond_5_sigma: usize,
    /// Intervals of 68% and of 95%.
    pub coverage: [Coverage; 2],
}

/// Estimate minus truth, and the error, of parameter `which` in its unit; NaN where one is not known.
pub(super) fn difference(matched: &Matched, pair: &Pair, which: usize) -> Estimate {
    let (row, source) = (matched.row(pair), matched.source(pair));
    let offset = row.position.to_lm(source.position);
    let known = |is_known: bool, truth: f64| if is_known { truth } else { f64::NAN };
    let has = matched.truth;
    let minus = |estimate: Estimate, truth: f64, unit: f64| Estimate {
        mean: (estimate.mean - truth) / unit,
        err: estimate.err / unit,
    };
    let towards = |mean: f64, err: f64| minus(Estimate { mean, err }, 0.0, ARCSEC);
    match which {
        0 => towards(offset.l, row.e_ra_rad),
        1 => towards(offset.m, row.e_dec_rad),
        2 => minus(row.flux_jy, source.flux_jy, MICROJY),
        3 => minus(
            row.scale_rad,
            known(has.has_scale, source.scale_rad),
            ARCSEC,
        ),
        4 => minus(row.e1, known(has.has_ellipticity, source.e.e1), 1.0),
        5 => minus(row.e2, known(has.has_ellipticity, source.e.e2), 1.0),
        _ => minus(row.spectral_index, source.spectral_index, 1.0),
    }
}

/// One report for each of [`PARAMETERS`] that both files have.
pub(super) fn report(matched: &Matched) -> Vec<ParameterReport> {
    (0..PARAMETERS.len())
        .filter_map(|which| one(matched, which))
        .collect()
}

fn one(matched: &Matched, which: usize) -> Option<ParameterReport> {
    let known = |pair: &&Pair| difference(matched, pair, which).mean.is_finite();
    let pairs: Vec<&Pair> = matched.pairs.iter().filter(known).collect();
    let differences = |pair: &&Pair| difference(matched, pair, which);
    let biases: Vec<f64> = pairs.iter().map(|pair| differences(pair).mean).collect();
    let pulls: Vec<f64> = pairs
        .iter()
        .map(differences)
        .filter(|d| d.err > 0.0)
        .map(|d| d.mean / d.err)
        .collect();
    let n = pulls.len() as f64;
    let (name, unit) = PARAMETERS[which];
    (!pairs.is_empty()).then(|| ParameterReport {
        name,
        unit,
        bias: Mean::of(&biases),
        pull_mean: pulls.iter().sum::<f64>() / n,
        pull_rms: (pulls.iter().map(|p| p * p).sum::<f64>() / n).sqrt(),
        pull_largest: (pulls.iter().copied())
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
            .unwrap_or(f64::NAN),
        n_beyond_5_sigma: pulls.iter().filter(|p| p.abs() > FAR_PULL).count(),
        coverage: cases(matched, &pairs, which, pulls).coverage(),
    })
}

fn cases(matched: &Matched, pairs: &[&Pair], which: usize, pulls: Vec<f64>) -> Cases {
    let ranks = |samples| {
        let rank = |pair: &&Pair| {
            let (row, source) = (matched.row(pair), matched.source(pair));
            rank_of_truth(samples, row, source, which)
        };
        pairs.iter().map(rank).collect()
    };
    let column = |pair: &&Pair| {
        let [low, high] = matched.row(pair).flux_lo_hi_jy;
        let inside = (low..=high).contains(&matched.source(pair).flux_jy);
        (which == 2 && low.is_finite() && high.is_finite()).then_some(inside)
    };
    Cases {
        pulls,
        ranks: matched.found.samples.as_ref().map(ranks),
        in_columns: pairs.iter().map(column).collect(),
    }
}

/// Fraction of the posterior of `row` that lies below the truth.
fn rank_of_truth(
    samples: &FoundSamples,
    row: &FoundRow,
    source: &CatalogueSource,
    which: usize,
) -> f64 {
    let own = row.samples.clone();
    let offset = |i: usize| {
        let position = RaDec {
            ra_rad: samples.ra_rad[i],
            dec_rad: samples.dec_rad[i],
        };
        position.to_lm(source.position)
    };
    let value = |i: usize| match which {
        0 => offset(i).l,
        1 => offset(i).m,
        2 => samples.flux_jy[i] - source.flux_jy,
        3 => samples.scale_rad[i] - source.scale_rad,
        4 => samples.e1[i] - source.e.e1,
        5 => samples.e2[i] - source.e.e2,
        _ => samples.spectral_index[i] - source.spectral_index,
    };
    let weights = own.clone().map(|i| samples.weight[i]);
    rank(own.map(value), weights, 0.0)
}
