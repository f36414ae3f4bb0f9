//! The last look at every source, or group of sources: its posterior samples by all visibilities.
//!
//! Whatever engine the samples were drawn with, they are weighted in the end as the exact likelihood
//! wants. Where evaluating all of them would take longer than the run, an even choice is evaluated;
//! the difference of the engines, which is smooth over a posterior, is taken to the others by a
//! plane through it.

use nalgebra::{DMatrix, DVector};

use super::refine::{Found, means};
use super::{DetectError, Mode, ModeSample};
use crate::dataset::{Dataset, Request};
use crate::likelihood::{Xy, joint_log_l, pairs, xy_without_others};
use crate::prior::MAX_DIM;
use crate::rime::Source;

/// Samples times visibilities that are worth evaluating: half a minute of a core.
const AFFORDABLE: f64 = 1e11;
/// Fewest samples of a source that are evaluated.
const FEWEST: f64 = 100.0;
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

/// Joint samples of a group of sources, and what all visibilities say of them.
struct Draws {
    /// Which samples of the members.
    chosen: Vec<usize>,
    /// The members there, axes (sample, member).
    sources: Vec<Vec<Source>>,
    /// X and Y of each, with all members in the data.
    xy: Vec<Vec<Xy>>,
    /// Y_ij of the pairs of members, axes (sample, pair).
    cross: Vec<Vec<f64>>,
}

impl Draws {
    /// Even choices of the samples of all `groups`, in one pass for X and Y and one for Y_ij.
    fn look_at(
        dataset: &mut Dataset,
        sources: &[Found],
        groups: &[Vec<usize>],
    ) -> Result<Vec<Self>, DetectError> {
        let n_sum: usize = groups
            .iter()
            .map(|g| g.len() + pairs(g.len()).count())
            .sum();
        let affordable = AFFORDABLE / (dataset.info().n_sample as f64 * n_sum as f64);
        let most = affordable.max(FEWEST) as usize;
        let mut draws: Vec<Self> = groups
            .iter()
            .map(|group| Self::choose(sources, group, most))
            .collect();
        let requests: Vec<Request> = (draws.iter().zip(groups))
            .map(|(draws, group)| Request {
                points: draws.sources.concat(),
                restored: group.iter().map(|&i| sources[i].mode.mean).collect(),
            })
            .collect();
        let wanted: Vec<[Source; 2]> = draws.iter().flat_map(Self::pairs).collect();
        let xy = dataset.evaluate(&requests)?;
        let mut cross = dataset.cross(&wanted)?.into_iter();
        for ((draws, group), xy) in draws.iter_mut().zip(groups).zip(xy) {
            let n_pair = pairs(group.len()).count();
            draws.xy = xy.chunks(group.len()).map(<[Xy]>::to_vec).collect();
            draws.cross = (draws.chosen.iter())
                .map(|_| cross.by_ref().take(n_pair).collect())
                .collect();
        }
        Ok(draws)
    }

    fn choose(sources: &[Found], group: &[usize], most: usize) -> Self {
        let chosen = choose(&sources[group[0]].mode.samples, most);
        let at = |&k: &usize| -> Vec<Source> {
            let members = group.iter();
            members
                .map(|&i| sources[i].mode.samples[k].source)
                .collect()
        };
        Self {
            sources: chosen.iter().map(at).collect(),
            chosen,
            xy: Vec::new(),
            cross: Vec::new(),
        }
    }

    fn pairs(&self) -> impl Iterator<Item = [Source; 2]> {
        let of_draw =
            |s: &Vec<Source>| -> Vec<_> { pairs(s.len()).map(|[i, j]| [s[i], s[j]]).collect() };
        self.sources.iter().flat_map(of_draw)
    }

    /// Joint ln L of each.
    fn log_l(&self) -> impl Iterator<Item = f64> {
        let sums = self.xy.iter().zip(&self.cross);
        let sums = self.sources.iter().zip(sums);
        sums.map(|(sources, (xy, cross))| joint_log_l(sources, xy, cross))
    }

    /// X and Y of a member in the last one, the one of highest ln L, with the others removed.
    fn best_xy(&self, member: usize) -> Option<Xy> {
        let (xy, cross) = (self.xy.last()?, self.cross.last()?);
        Some(xy_without_others(member, self.sources.last()?, xy, cross))
    }
}

/// Weights the samples of all `groups` of sources anew, each group with all others removed; sample
/// k of one member belongs to sample k of the others. Gives a certificate for every member.
pub(super) fn certify(
    dataset: &mut Dataset,
    sources: &mut [Found],
    groups: &[Vec<usize>],
) -> Result<Vec<Vec<Certificate>>, DetectError> {
    dataset.set_removed(means(sources));
    let draws = Draws::look_at(dataset, sources, groups)?;
    let mut certificates = Vec::with_capacity(groups.len());
    for (group, draws) in groups.iter().zip(draws) {
        let mut modes: Vec<Mode> = group.iter().map(|&i| sources[i].mode.clone()).collect();
        certificates.push(weigh(&mut modes, &draws));
        for (&i, mode) in group.iter().zip(modes) {
            sources[i].mode = mode;
        }
    }
    Ok(certificates)
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

/// Weights the joint samples of `modes`, the members of a group, by the exact sums of some of them.
fn weigh(modes: &mut [Mode], draws: &Draws) -> Vec<Certificate> {
    let (chosen, samples) = (&draws.chosen, &modes[0].samples);
    let exact_less: Vec<f64> = (draws.log_l().zip(chosen))
        .map(|(log_l, &k)| log_l - samples[k].log_l)
        .collect();
    let max_dlog_l = exact_less.iter().fold(0.0, |max: f64, d| max.max(d.abs()));
    let is_all = chosen.len() > samples.len();
    let (mut correction, scatter) = plane(modes, chosen, &exact_less);
    if is_all {
        for (&k, d) in chosen.iter().zip(&exact_less) {
            correction[k] = *d;
        }
    }
    let n_eff = modes[0].n_eff;
    let is_alone = modes.len() == 1;
    for (member, mode) in modes.iter_mut().enumerate() {
        mode.best_xy = draws.best_xy(member).unwrap_or(mode.best_xy);
        *mode = reweighted(mode, &correction, is_alone);
        tracing::debug!(
            "SNR {:.1}: ln L differs by up to {max_dlog_l:.3}, {scatter:.3} about a plane",
            mode.best_xy.snr_peak()
        );
    }
    let is_valid = modes[0].n_eff > LEAST_KEPT * n_eff && (is_all || scatter < LARGEST_SCATTER);
    let certificate = |(member, mode): (usize, &Mode)| Certificate {
        max_dlog_l,
        snr: mean_snr(mode, member, draws, is_all),
        is_valid,
    };
    modes.iter().enumerate().map(certificate).collect()
}

/// Posterior mean of S sqrt(Y) of a member; `is_all`: all its samples were looked at.
fn mean_snr(mode: &Mode, member: usize, draws: &Draws, is_all: bool) -> f64 {
    let chosen = &draws.chosen;
    let total: f64 = chosen.iter().map(|&k| mode.samples[k].weight).sum();
    let snr = chosen.iter().zip(&draws.xy).map(|(&k, xy)| {
        let share = if is_all {
            mode.samples[k].weight / total
        } else {
            1.0 / chosen.len() as f64
        };
        share * xy[member].snr(mode.samples[k].source.flux_jy)
    });
    snr.sum()
}

/// The plane through the differences at the samples `chosen`, at every sample, and the scatter
/// about it.
fn plane(modes: &[Mode], chosen: &[usize], exact_less: &[f64]) -> (Vec<f64>, f64) {
    let (n_sample, n_chosen) = (modes[0].samples.len(), chosen.len() as f64);
    let n_coefficient = 1 + MAX_DIM * modes.len();
    let mean = exact_less.iter().sum::<f64>() / n_chosen.max(1.0);
    let flat = (vec![mean; n_sample], f64::INFINITY);
    if chosen.len() <= 2 * n_coefficient {
        return flat;
    }
    let row = |k: usize| {
        let members = modes.iter();
        let members = members.flat_map(move |mode| coordinates(&mode.samples[k].source, mode));
        std::iter::once(1.0).chain(members)
    };
    let cells = chosen.iter().flat_map(|&k| row(k));
    let rows = DMatrix::from_row_iterator(chosen.len(), n_coefficient, cells);
    let wanted = DVector::from_column_slice(exact_less);
    let Ok(fit) = rows.clone().svd(true, true).solve(&wanted, 1e-9) else {
        return flat;
    };
    let scatter = (&rows * &fit - &wanted).norm() / (n_chosen - n_coefficient as f64).sqrt();
    let at = |k: usize| row(k).zip(fit.iter()).map(|(x, c)| x * c).sum();
    ((0..n_sample).map(at).collect(), scatter)
}

/// The parameters about their means, of order one.
fn coordinates(source: &Source, mode: &Mode) -> [f64; MAX_DIM] {
    let mean = &mode.mean;
    let position = mode.position_sigma_rad.max(f64::MIN_POSITIVE);
    [
        (source.lm.l - mean.lm.l) / position,
        (source.lm.m - mean.lm.m) / position,
        (source.flux_jy - mean.flux_jy) / mode.flux_sigma_jy.max(f64::MIN_POSITIVE),
        source.scale_rad / mean.scale_rad - 1.0,
        source.e.e1 - mean.e.e1,
        source.e.e2 - mean.e.e2,
        source.tilt - mean.tilt,
    ]
}

/// The mode with `correction` added to the ln L of its samples; only that of a source sampled alone
/// says something of its evidence.
fn reweighted(mode: &Mode, correction: &[f64], is_alone: bool) -> Mode {
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
    let gain = if is_alone { highest + total.ln() } else { 0.0 };
    let new = Mode::new(mode.tile, samples, mode.log_z + gain, mode.log_z_err);
    Mode {
        best_xy: mode.best_xy,
        mean_log_l: if is_alone {
            new.mean_log_l
        } else {
            mode.mean_log_l
        },
        is_unfinished: mode.is_unfinished,
        status: mode.status,
        ..new
    }
}
