//! The modes of a run as candidates for sources, at whatever cut.

use super::matching::{Place, cross_match, match_radius_rad};
use super::{Matched, place};
use crate::catalogue::{FoundCatalogue, FoundMode, FoundRow};
use crate::coords::RaDec;
use crate::detect::Status;
use crate::units::MICROJY;

/// A mode that some cut would have kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Matched-filter signal-to-noise ratio; that of the estimate where no row has the former.
    pub snr: f64,
    /// Total flux density [uJy]; NaN where it is out of date.
    pub flux_ujy: f64,
    /// Local log evidence; NaN where it is out of date.
    pub log_z: f64,
    /// Probability of a source; NaN where it is out of date.
    pub p_source: f64,
    /// The true source that it is.
    pub truth: Option<usize>,
}

/// The candidates of one catalogue.
pub(super) struct Candidates {
    /// The table that they come from.
    pub(super) table: &'static str,
    /// Its column of signal-to-noise ratios.
    pub(super) snr_column: &'static str,
    /// The strongest first.
    pub(super) list: Vec<Candidate>,
    /// Modes that are not among them: no cut makes them sources, or they are seen twice.
    pub(super) n_left_out: usize,
    /// Whether each true source lies in the searched field.
    pub(super) in_field: Vec<bool>,
    /// Whether each true source is of the population of [`POPULATION_SNR`](super::POPULATION_SNR).
    pub(super) in_population: Vec<bool>,
}

/// The modes that may be sources, each one time, and which true source each of them is; the rows
/// of the catalogue, where there is no table of modes.
///
/// A kept mode stands where its row of the catalogue says. Modes that a run drops at any cut do not
/// count: duplicates, parts of a neighbour, and those worse than no source. Where the match radius of
/// a mode that was not kept reaches a stronger one, it is taken for the same thing seen again, as
/// overlapping tiles and later rounds of a search do. The strongest mode is matched first, so that
/// whether one is true does not depend on any that is weaker, and so on no cut.
pub(super) fn candidates(matched: &Matched) -> Candidates {
    let rows = &matched.found.rows;
    let has_peak = rows.iter().any(|row| !row.snr_peak.is_nan());
    let (table, snr_column, n_all, seen) = match &matched.found.modes {
        Some(modes) => (
            "MODES",
            "SNR_peak",
            modes.len(),
            of_modes(matched.found, modes),
        ),
        None if has_peak => (
            "CATALOGUE",
            "SNR_peak",
            rows.len(),
            of_rows(rows, |row| row.snr_peak),
        ),
        None => ("CATALOGUE", "SNR", rows.len(), of_rows(rows, |row| row.snr)),
    };
    let seen = once(seen);
    let places: Vec<Place> = seen.iter().map(|s| s.place).collect();
    let positions: Vec<RaDec> = (matched.truth.sources.iter())
        .map(|source| source.position)
        .collect();
    let mut list: Vec<Candidate> = seen.into_iter().map(|s| s.candidate).collect();
    for pair in cross_match(&places, &positions, |row| row) {
        list[pair.row].truth = Some(pair.truth);
    }
    Candidates {
        table,
        snr_column,
        n_left_out: n_all - list.len(),
        list,
        in_field: matched.in_field.clone(),
        in_population: (matched.truth.sources.iter().zip(&matched.in_field))
            .map(|(source, in_field)| *in_field && source.snr >= super::POPULATION_SNR)
            .collect(),
    }
}

/// A candidate, where it was seen, and whether it is a source of the catalogue.
struct Seen {
    place: Place,
    is_kept: bool,
    candidate: Candidate,
}

fn of_rows(rows: &[FoundRow], snr: fn(&FoundRow) -> f64) -> Vec<Seen> {
    let seen = |row: &FoundRow| Seen {
        place: place(row),
        is_kept: true,
        candidate: Candidate {
            snr: snr(row),
            flux_ujy: row.flux_jy.mean / MICROJY,
            log_z: f64::NAN,
            p_source: row.p_source,
            truth: None,
        },
    };
    rows.iter().map(seen).collect()
}

fn of_modes(found: &FoundCatalogue, modes: &[FoundMode]) -> Vec<Seen> {
    let seen = |mode: &FoundMode| {
        // What a brighter source explains is weighed again once that is subtracted, but for the
        // signal-to-noise ratio alone.
        let is_current = match mode.status {
            Status::Kept | Status::BelowCut | Status::Unlikely => true,
            Status::ExplainedByBrighter => false,
            Status::F1Duplicate | Status::PartOfNeighbour | Status::WorseThanNoSource => {
                return None;
            }
        };
        let current = |value: f64| if is_current { value } else { f64::NAN };
        let is_kept = mode.status == Status::Kept;
        let row = (found.rows.iter())
            .find(|row| is_kept && mode.source_id.is_some() && row.source_id == mode.source_id);
        let sigma_rad = mode.position_sigma_rad;
        let own_place = Place {
            position: mode.position,
            radius_rad: match_radius_rad(sigma_rad, sigma_rad),
        };
        Some(Seen {
            place: row.map_or(own_place, place),
            is_kept,
            candidate: Candidate {
                snr: mode.snr_peak,
                flux_ujy: current(mode.flux_jy / MICROJY),
                log_z: current(mode.log_z),
                p_source: current(row.map_or(mode.p_source, |row| row.p_source)),
                truth: None,
            },
        })
    };
    modes.iter().filter_map(seen).collect()
}

/// The strongest first, without those that are a stronger one seen again.
fn once(mut seen: Vec<Seen>) -> Vec<Seen> {
    let strength = |s: &Seen| {
        if s.candidate.snr.is_nan() {
            f64::NEG_INFINITY
        } else {
            s.candidate.snr
        }
    };
    // Stable: equal ones stay in the order of the file.
    seen.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    let mut once: Vec<Seen> = Vec::new();
    for next in seen {
        let radius_rad = next.place.radius_rad;
        let is_same = |other: &Seen| {
            let (a, b) = (other.place.position, next.place.position);
            // The difference in declination is the cheaper question.
            (a.dec_rad - b.dec_rad).abs() <= radius_rad && a.separation_rad(b) <= radius_rad
        };
        if next.is_kept || !once.iter().any(is_same) {
            once.push(next);
        }
    }
    once
}
