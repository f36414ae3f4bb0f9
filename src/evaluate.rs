//! How good a catalogue is, where the truth is known.
//!
//! | file | answers |
//! |---|---|
//! | `matching.rs` | which row is which true source |
//! | `parameters.rs`, `interval.rs` | are estimates right, and errors honest: biases, pulls, coverage |
//! | `bins.rs` | what was found, and what is real, by SNR, flux density and size |
//! | `candidates.rs`, `curve.rs` | what another cut would have kept |
//! | `reliability.rs` | is `P_source` a probability |
//!
//! The numbers are in the units of the catalogue, which stand at the end of their names. What is not
//! defined, such as the purity of an empty catalogue, is NaN, and `null` in JSON.
//!
//! A true source outside the searched field can be matched, so that a row at the border is not called
//! false, but does not count where completeness is asked for.

mod bins;
mod candidates;
mod curve;
mod fraction;
mod interval;
mod matching;
mod parameters;
mod reliability;
mod report;

use crate::catalogue::{CatalogueSource, FoundCatalogue, FoundRow, SourceList};
use crate::coords::RaDec;

pub use bins::{Bin, Binned};
pub use candidates::Candidate;
pub use curve::{Curve, CurvePoint};
pub use fraction::{Fraction, Mean};
pub use interval::{Coverage, IntervalKind};
pub use matching::{MATCH_FLOOR_RAD, MATCH_N_SIGMA, Pair, Place, cross_match, match_radius_rad};
pub use parameters::{PARAMETERS, ParameterReport};
pub use reliability::ReliabilityBin;
pub use report::{Evaluation, FalseRow, MatchedRow, MissedSource};

/// Completeness is also told of the true sources with at least this signal-to-noise ratio, as in
/// Malyali et al. (2018), section 5.
pub const POPULATION_SNR: f64 = 5.0;

/// What was found beside what is true, and which is which.
struct Matched<'a> {
    found: &'a FoundCatalogue,
    truth: &'a SourceList,
    /// Rows of the catalogue with their true sources, in the order of rows.
    pairs: Vec<Pair>,
    /// Whether each true source lies in the searched field.
    in_field: Vec<bool>,
}

impl<'a> Matched<'a> {
    fn new(found: &'a FoundCatalogue, truth: &'a SourceList) -> Self {
        let places: Vec<Place> = found.rows.iter().map(place).collect();
        let contains = |position| found.field.is_none_or(|field| field.contains(position));
        let positions: Vec<RaDec> = truth.sources.iter().map(|s| s.position).collect();
        Self {
            found,
            truth,
            // The closest pair first, whichever row it is.
            pairs: cross_match(&places, &positions, |_| 0),
            in_field: positions.into_iter().map(contains).collect(),
        }
    }

    fn row(&self, pair: &Pair) -> &'a FoundRow {
        &self.found.rows[pair.row]
    }

    fn source(&self, pair: &Pair) -> &'a CatalogueSource {
        &self.truth.sources[pair.truth]
    }

    /// The true source of each row.
    fn truth_of_row(&self) -> Vec<Option<usize>> {
        let mut truth = vec![None; self.found.rows.len()];
        for pair in &self.pairs {
            truth[pair.row] = Some(pair.truth);
        }
        truth
    }

    /// Whether each true source was found.
    fn is_found(&self) -> Vec<bool> {
        let mut is_found = vec![false; self.truth.sources.len()];
        for pair in &self.pairs {
            is_found[pair.truth] = true;
        }
        is_found
    }

    /// The true sources in the searched field that `is_wanted`.
    fn population(&self, is_wanted: impl Fn(&CatalogueSource) -> bool) -> Vec<usize> {
        (0..self.in_field.len())
            .filter(|&i| self.in_field[i] && is_wanted(&self.truth.sources[i]))
            .collect()
    }
}

fn place(row: &FoundRow) -> Place {
    Place {
        position: row.position,
        radius_rad: match_radius_rad(row.e_ra_rad, row.e_dec_rad),
    }
}

/// Compares `found` with `truth`.
pub fn evaluate(found: &FoundCatalogue, truth: &SourceList) -> Evaluation {
    let matched = Matched::new(found, truth);
    let candidates = candidates::candidates(&matched);
    Evaluation {
        parameters: parameters::report(&matched),
        bins: bins::report(&matched),
        curves: curve::report(&candidates),
        reliability: reliability::report(&candidates),
        ..report::counts(&matched, &candidates)
    }
}
