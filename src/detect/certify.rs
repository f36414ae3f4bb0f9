//! The last look at every source: its posterior samples by all visibilities.
//!
//! Whatever engine the samples were drawn with, they are weighted in the end as the exact likelihood
//! wants. Where evaluating all of them would take longer than the run, an even choice is evaluated;
//! the difference of the engines, which is smooth over a posterior, is taken to the others by a
//! plane through it.

use nalgebra::{DMatrix, DVector};

use super::refine::{Found, means};
use super::{DetectError, Mode, ModeSample};
use crate::dataset::{Dataset, Request};
use crate::likelihood::Xy;
use crate::rime::Source;

/// Samples times visibilities that are worth evaluating: half a minute of a core.
const AFFORDABLE: f64 = 1e11;
/// Fewest samples of a source that are evaluated.
const FEWEST: f64 = 100.0;
/// Parameters of a source, and one: the coefficients of a plane.
const N_COEFFICIENT: usize = 7;
/// Largest scatter of the difference about the plane, in ln L, with which samples count as certified.
const LARGEST_SCATTER: f64 = 0.5;
/// Least part of the effective samples that must be left.
const LEAST_KEPT: f64 = 0.5;

/// What the last look at a source gave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Certificate {
    /// Largest |ln L - ln L of the engine that drew the samples|.
    pub(super) max_dlog_l: f64,
    /// Posterior mean of S sqrt(Y).
    pub(super) snr: f64,
    /// The samples are good for the exact likelihood.
    pub(super) is_valid: bool,
}

/// Weights the samples of all sources anew, each with all the others removed.
pub(super) fn certify(
    dataset: &mut Dataset,
    sources: &mut [Found],
) -> Result<Vec<Certificate>, DetectError> {
    dataset.set_removed(means(sources));
    let affordable = AFFORDABLE / (dataset.info().n_sample as f64 * sources.len() as f64);
    let most = affordable.max(FEWEST) as usize;
    let chosen: Vec<Vec<usize>> = sources
        .iter()
        .map(|s| choose(&s.mode.samples, most))
        .collect();
    let requests: Vec<Request> = sources
        .iter()
        .zip(&chosen)
        .map(|(found, chosen)| Request {
            points: chosen
                .iter()
                .map(|&i| found.mode.samples[i].source)
                .collect(),
            restored: vec![found.mode.mean],
        })
        .collect();
    let xy = dataset.evaluate(&requests)?;
    let sources = sources.iter_mut().zip(chosen.iter().zip(&xy));
    Ok(sources
        .map(|(found, (chosen, xy))| weigh(&mut found.mode, chosen, xy))
        .collect())
}

/// All samples if they are not more than `most`, else as many spread evenly over the weight; the one
/// of highest ln L is always last.
pub(super) fn choose(samples: &[ModeSample], most: usize) -> Vec<usize> {
    let best = (0..samples.len()).max_by(|&i, &j| samples[i].log_l.total_cmp(&samples[j].log_l));
    let mut chosen: Vec<usize> = if samples.len() <= most {
        (0..samples.len()).collect()
    } else {
        let mut below = 0.0;
        let step = |i: usize| {
            let before = below;
            below += samples[i].weight * most as f64;
            (below.floor() > f64::floor(before)).then_some(i)
        };
        (0..samples.len()).filter_map(step).collect()
    };
    chosen.extend(best);
    chosen
}

/// Weights the samples of `mode` by the exact sums `xy` of those `chosen`.
fn weigh(mode: &mut Mode, chosen: &[usize], xy: &[Xy]) -> Certificate {
    let samples = &mode.samples;
    let difference =
        |(&i, xy): (&usize, &Xy)| xy.log_l(samples[i].source.flux_jy) - samples[i].log_l;
    let exact_less: Vec<f64> = chosen.iter().zip(xy).map(difference).collect();
    let max_dlog_l = exact_less.iter().fold(0.0, |max: f64, d| max.max(d.abs()));
    mode.best_xy = xy.last().copied().unwrap_or(mode.best_xy);
    let is_all = chosen.len() > samples.len();
    let (mut correction, scatter) = plane(mode, chosen, &exact_less);
    if is_all {
        for (&i, d) in chosen.iter().zip(&exact_less) {
            correction[i] = *d;
        }
    }
    tracing::debug!(
        "SNR {:.1}: ln L differs by up to {max_dlog_l:.3}, {scatter:.3} about a plane",
        mode.best_xy.snr_peak()
    );
    let n_eff = mode.n_eff;
    *mode = reweighted(mode, &correction);
    let total: f64 = chosen.iter().map(|&i| mode.samples[i].weight).sum();
    let snr = chosen.iter().zip(xy).map(|(&i, xy)| {
        let share = if is_all {
            mode.samples[i].weight / total
        } else {
            1.0 / chosen.len() as f64
        };
        share * xy.snr(mode.samples[i].source.flux_jy)
    });
    Certificate {
        max_dlog_l,
        snr: snr.sum(),
        is_valid: mode.n_eff > LEAST_KEPT * n_eff && (is_all || scatter < LARGEST_SCATTER),
    }
}

/// The plane through the differences at the samples `chosen`, at every sample, and the scatter
/// about it.
fn plane(mode: &Mode, chosen: &[usize], exact_less: &[f64]) -> (Vec<f64>, f64) {
    let n_eff = chosen.len() as f64;
    let mean = exact_less.iter().sum::<f64>() / n_eff.max(1.0);
    let flat = (vec![mean; mode.samples.len()], f64::INFINITY);
    if chosen.len() <= 2 * N_COEFFICIENT {
        return flat;
    }
    let row = |i: usize| coordinates(&mode.samples[i].source, mode);
    let rows = DMatrix::from_fn(chosen.len(), N_COEFFICIENT, |k, c| row(chosen[k])[c]);
    let wanted = DVector::from_column_slice(exact_less);
    let Ok(fit) = rows.clone().svd(true, true).solve(&wanted, 1e-9) else {
        return flat;
    };
    let scatter = (&rows * &fit - &wanted).norm() / (n_eff - N_COEFFICIENT as f64).sqrt();
    let at = |i: usize| row(i).iter().zip(fit.iter()).map(|(x, c)| x * c).sum();
    ((0..mode.samples.len()).map(at).collect(), scatter)
}

/// One, and the parameters about their means, of order one.
fn coordinates(source: &Source, mode: &Mode) -> [f64; N_COEFFICIENT] {
    let mean = &mode.mean;
    let position = mode.position_sigma_rad.max(f64::MIN_POSITIVE);
    [
        1.0,
        (source.lm.l - mean.lm.l) / position,
        (source.lm.m - mean.lm.m) / position,
        (source.flux_jy - mean.flux_jy) / mode.flux_sigma_jy.max(f64::MIN_POSITIVE),
        source.scale_rad / mean.scale_rad - 1.0,
        source.e.e1 - mean.e.e1,
        source.e.e2 - mean.e.e2,
    ]
}

/// The mode with `correction` added to the ln L of its samples.
fn reweighted(mode: &Mode, correction: &[f64]) -> Mode {
    let highest = correction.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights = mode.samples.iter().zip(correction);
    let weights: Vec<f64> = weights
        .map(|(s, d)| s.weight * (d - highest).exp())
        .collect();
    let total: f64 = weights.iter().sum();
    let samples = mode.samples.iter().zip(weights.iter().zip(correction));
    let samples: Vec<ModeSample> = samples
        .map(|(sample, (weight, d))| ModeSample {
            log_l: sample.log_l + d,
            weight: weight / total,
            ..*sample
        })
        .collect();
    let log_z = mode.log_z + highest + total.ln();
    Mode {
        best_xy: mode.best_xy,
        is_unfinished: mode.is_unfinished,
        status: mode.status,
        ..Mode::new(mode.tile, samples, log_z, mode.log_z_err)
    }
}
