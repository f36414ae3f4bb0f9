//! From modes to sources: duplicates, cuts, and the subtraction of the strongest first.

use super::mean_shift::mean_shift;
use super::queue::SIDELOBE;
use super::{DetectError, Mode, Status};
use crate::dataset::{Dataset, Request};
use crate::likelihood::Xy;
use crate::rime::Source;

/// What makes a mode a source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuts {
    /// Lowest matched-filter signal-to-noise ratio, unless there is a flux cut.
    pub snr: f64,
    /// Lowest posterior mean flux density [Jy].
    pub flux_jy: Option<f64>,
    /// Radius of the mean shift [rad]; none = each mode's own uncertainty.
    pub merge_radius_rad: Option<f64>,
    /// Floor of that uncertainty [rad].
    pub merge_floor_rad: f64,
    /// Modes nearer than this to a stronger one wait until that is subtracted [rad].
    pub near_rad: f64,
}

impl Cuts {
    fn passes(&self, mode: &Mode) -> bool {
        match self.flux_jy {
            Some(flux_jy) => mode.mean.flux_jy >= flux_jy,
            None => mode.snr_peak() >= self.snr,
        }
    }

    /// Is what the data still hold of a mode, at its best shape, above the cut?
    pub(super) fn passes_still(&self, xy: Xy) -> bool {
        match self.flux_jy {
            Some(flux_jy) => xy.x >= flux_jy * xy.y,
            None => xy.snr_peak() >= self.snr,
        }
    }
}

/// Sets the status of every mode; the sources already removed from `dataset` stay removed, and
/// those accepted here are removed too.
pub(super) fn accept(
    dataset: &mut Dataset,
    removed: &[Source],
    modes: &mut [Mode],
    cuts: &Cuts,
) -> Result<(), DetectError> {
    evaluate_best(dataset, modes)?;
    for mode in modes.iter_mut() {
        mode.status = if mode.best_log_l <= 0.0 {
            Status::WorseThanNoSource
        } else if cuts.passes(mode) {
            Status::Kept
        } else {
            Status::BelowCut
        };
    }
    drop_duplicates(modes, cuts);
    strongest_first(dataset, removed, modes, cuts)
}

/// X and Y of the best sample of every mode.
fn evaluate_best(dataset: &mut Dataset, modes: &mut [Mode]) -> Result<(), DetectError> {
    let points = modes.iter().map(|mode| mode.best).collect();
    let xy = dataset.evaluate(&[Request {
        points,
        restored: Vec::new(),
    }])?;
    for (mode, xy) in modes.iter_mut().zip(&xy[0]) {
        mode.best_xy = *xy;
    }
    Ok(())
}

/// Of the modes of one cluster the one with the highest local evidence stays.
fn drop_duplicates(modes: &mut [Mode], cuts: &Cuts) {
    let kept = indices(modes, Status::Kept);
    let positions: Vec<_> = kept.iter().map(|&i| modes[i].mean.lm).collect();
    let bandwidth: Vec<_> = kept
        .iter()
        .map(|&i| {
            let own = modes[i].position_sigma_rad.max(cuts.merge_floor_rad);
            cuts.merge_radius_rad.unwrap_or(own)
        })
        .collect();
    let cluster = mean_shift(&positions, &bandwidth);
    for (&i, &c) in kept.iter().zip(&cluster) {
        let same = kept.iter().zip(&cluster).filter(|(_, d)| c == **d);
        let best = same.map(|(&j, _)| j).max_by(|&j, &k| {
            let by_log_z = modes[j].log_z.total_cmp(&modes[k].log_z);
            by_log_z.then(k.cmp(&j))
        });
        if best != Some(i) {
            modes[i].status = Status::F1Duplicate;
            modes[i].explained_by = best;
        }
    }
}

/// Takes the strongest modes, subtracts them, looks at the others again, and so on.
fn strongest_first(
    dataset: &mut Dataset,
    removed: &[Source],
    modes: &mut [Mode],
    cuts: &Cuts,
) -> Result<(), DetectError> {
    let mut open = indices(modes, Status::Kept);
    let mut removed = removed.to_vec();
    let mut taken: Vec<usize> = Vec::new();
    while !open.is_empty() {
        let points = open.iter().map(|&i| modes[i].best).collect();
        let xy = dataset.evaluate(&[Request {
            points,
            restored: Vec::new(),
        }])?;
        for (&i, xy) in open.iter().zip(&xy[0]) {
            modes[i].best_xy = *xy;
            if !taken.is_empty() && !cuts.passes_still(*xy) {
                modes[i].status = Status::ExplainedByBrighter;
                modes[i].explained_by = nearest(modes, &taken, i);
            }
        }
        open.retain(|&i| modes[i].status == Status::Kept);
        taken = undisputed(modes, &open, cuts);
        open.retain(|i| !taken.contains(i));
        removed.extend(taken.iter().map(|&i| modes[i].mean));
        dataset.set_removed(removed.clone());
    }
    Ok(())
}

/// The strongest of the modes `open`, and those that are none of its sidelobes, nor near a
/// stronger one.
fn undisputed(modes: &[Mode], open: &[usize], cuts: &Cuts) -> Vec<usize> {
    let snr = |i: usize| modes[i].snr_peak();
    let strongest = open.iter().map(|&i| snr(i)).fold(f64::MIN, f64::max);
    let is_near = |i: usize, j: usize| {
        modes[i].mean.lm.distance(modes[j].mean.lm) < cuts.near_rad && (snr(j), i) > (snr(i), j)
    };
    let is_free = |&i: &usize| {
        let is_bright = snr(i) >= (SIDELOBE * strongest).min(strongest);
        is_bright && !open.iter().any(|&j| j != i && is_near(i, j))
    };
    open.iter().copied().filter(is_free).collect()
}

/// Which of the modes `taken` is the nearest to mode `i`.
fn nearest(modes: &[Mode], taken: &[usize], i: usize) -> Option<usize> {
    let distance = |j: usize| modes[i].mean.lm.distance(modes[j].mean.lm);
    let order = |&j: &usize, &k: &usize| distance(j).total_cmp(&distance(k));
    taken.iter().copied().min_by(order)
}

fn indices(modes: &[Mode], status: Status) -> Vec<usize> {
    (0..modes.len())
        .filter(|&i| modes[i].status == status)
        .collect()
}
