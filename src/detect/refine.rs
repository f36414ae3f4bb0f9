//! Each source sampled anew with all others removed, until the sources stand still.

use super::certify::choose;
use super::explore::{Explored, SamplerFactory, SamplerSettings, Target, Task, explore};
use super::pipeline::stream_seed;
use super::{DetectError, Mode, Observer};
use crate::dataset::{Dataset, Request};
use crate::prior::{Region, SourcePrior, Window};
use crate::rime::Source;
use crate::sampler::Health;

/// Half the side of the region about a source, in standard deviations of its position.
const REGION_SIGMAS: f64 = 8.0;
/// A posterior closer than this many standard deviations to the edge of its region is cut off.
const EDGE_SIGMAS: f64 = 3.0;
/// How much larger the region is then made.
const WIDER: f64 = 4.0;
/// Samples of a source that are looked at again when others have changed.
const N_WITNESS: usize = 8;
/// Rounds after which they are taken as they are.
const MOST_ROUNDS: usize = 12;
/// Nearer than this many widths of the beam the model of one source may stand for two.
pub(super) const CLOSE_BEAMS: f64 = 4.0;
/// Sources nearer than this many widths of the beam are sampled one after the other.
const NEAR_BEAMS: f64 = 6.0;

/// A source on its way: the mode that it is now.
#[derive(Debug, Clone)]
pub(super) struct Found {
    /// Index of the mode that it was found as.
    pub(super) origin: usize,
    /// Its posterior as it stands.
    pub(super) mode: Mode,
    /// Some of its samples with their ln L, at a glimpse, in the data that they were drawn from; none as long
    /// as it was not sampled with the others removed.
    witnesses: Vec<(Source, f64)>,
    /// Its posterior is good enough for the catalogue, as long as nothing changes about it.
    pub(super) is_full: bool,
    /// How well the sampler did that drew its posterior.
    pub(super) health: Health,
    /// The model of a neighbour had taken it in.
    pub(super) is_leftover: bool,
    /// How many times larger than usual the region about it is: its posterior reached the edge.
    widening: f64,
}

impl Found {
    pub(super) fn new(origin: usize, mode: Mode) -> Self {
        let witnesses = Vec::new();
        Self {
            origin,
            mode,
            witnesses,
            is_full: false,
            health: Health::default(),
            is_leftover: false,
            widening: 1.0,
        }
    }

    /// The same source with another posterior, which is a draft.
    pub(super) fn redrafted(&self, mode: Mode) -> Self {
        Self {
            mode,
            is_full: false,
            ..self.clone()
        }
    }

    fn witness_request(&self, restored: Source) -> Request {
        Request {
            points: self.witnesses.iter().map(|(source, _)| *source).collect(),
            restored: vec![restored],
        }
    }
}

/// How thoroughly a source is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Depth {
    /// Well enough to subtract it; neighbours that it could bridge to may still be unknown.
    Draft,
    /// For the catalogue.
    Full,
    /// The same by all visibilities.
    Exact,
}

impl Depth {
    fn window(self) -> Window {
        match self {
            Self::Draft => Window::compact(),
            Self::Full | Self::Exact => Window::FULL,
        }
    }

    /// A source is sampled again when its ln L has changed so that the change scatters by more than
    /// this over its samples: its posterior would move by as many standard deviations.
    fn disturbed(self) -> f64 {
        match self {
            Self::Draft => 0.5,
            Self::Full | Self::Exact => 0.15,
        }
    }
}

/// Where and how sources are sampled again.
pub(super) struct Refinement<'a> {
    pub(super) field: &'a Region,
    pub(super) prior: &'a SourcePrior,
    pub(super) factory: &'a SamplerFactory<'a>,
    /// Width of the beam [rad].
    pub(super) beam_rad: f64,
    /// Live points while sources still move.
    pub(super) n_live_draft: usize,
    /// Live points in the end.
    pub(super) n_live: usize,
    pub(super) seed: u64,
}

impl Refinement<'_> {
    /// Samples the sources from `first` on with all the others removed, roughly, until they stand
    /// still; `dataset` is left with all of them removed.
    pub(super) fn settle(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Found],
        first: usize,
        observer: &mut dyn Observer,
    ) -> Result<(), DetectError> {
        let seed = stream_seed(self.seed, [1, first as u64, 0]);
        let which = (first..sources.len()).collect();
        self.repeat(dataset, sources, which, Depth::Draft, seed, observer)
    }

    /// Samples every source in full with all the others removed, unless it was and nothing has changed
    /// about it since.
    pub(super) fn finish(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Found],
        observer: &mut dyn Observer,
    ) -> Result<(), DetectError> {
        let seed = stream_seed(self.seed, [2, 0, 0]);
        let changed = disturbed(dataset, sources, Depth::Full.disturbed())?;
        let is_wanted = |i: &usize| !sources[*i].is_full || changed.contains(i);
        let which = (0..sources.len()).filter(is_wanted).collect();
        self.repeat(dataset, sources, which, Depth::Full, seed, observer)
    }

    /// Rounds over the sources `which` and all that others disturb, until nothing has changed
    /// about any since it was sampled.
    fn repeat(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Found],
        mut which: Vec<usize>,
        depth: Depth,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<(), DetectError> {
        for round in 0..MOST_ROUNDS {
            let seed = stream_seed(seed, [round as u64, 0, 0]);
            self.round(dataset, sources, &which, depth, seed, observer)?;
            which = disturbed(dataset, sources, depth.disturbed())?;
            let is_cut_off = |i: &usize| sources[*i].widening > 1.0 && !which.contains(i);
            let cut_off: Vec<usize> = (0..sources.len()).filter(is_cut_off).collect();
            which.extend(cut_off);
            which.sort_unstable();
            if which.is_empty() {
                break;
            }
            tracing::debug!(
                "{} sources are disturbed by what changed about others",
                which.len()
            );
        }
        Ok(())
    }

    /// The same for the sources `which`, by all visibilities.
    pub(super) fn finish_exactly(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Found],
        which: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<(), DetectError> {
        let seed = stream_seed(self.seed, [5, 0, 0]);
        self.round(dataset, sources, which, Depth::Exact, seed, observer)
    }

    /// One pass over the sources `which`: near ones come one after the other, so that each sees
    /// the latest of its neighbours.
    pub(super) fn round(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Found],
        which: &[usize],
        depth: Depth,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<(), DetectError> {
        observer.stage("sampling sources", which.len() as u64);
        for group in self.apart(sources, which) {
            dataset.set_removed(means(sources));
            let target = |&i: &usize| Target {
                region: self.region(&sources[i].mode, sources[i].widening),
                window: depth.window(),
                restored: vec![sources[i].mode.mean],
                is_exact: depth == Depth::Exact,
                sampler: SamplerSettings {
                    n_dim: self.prior.n_dim(),
                    n_live: match depth {
                        Depth::Draft => self.n_live_draft,
                        Depth::Full | Depth::Exact => self.n_live,
                    },
                    task: Task::Posterior,
                    seed: stream_seed(seed, [i as u64, 0, 0]),
                },
            };
            let targets = group.iter().map(target).collect();
            let old: Vec<Source> = group.iter().map(|&i| sources[i].mode.mean).collect();
            let mut note = |explored: Explored| {
                let found = &mut sources[group[explored.index]];
                let is_widest = explored.region == self.region(&found.mode, f64::INFINITY);
                found.mode = self.refined(&found.mode, &explored);
                found.health = explored.health;
                found.is_full = depth != Depth::Draft;
                found.widening = if self.is_cut_off(&found.mode, &explored.region) && !is_widest {
                    WIDER * found.widening
                } else {
                    1.0
                };
            };
            explore(
                dataset,
                self.prior,
                self.factory,
                targets,
                observer,
                &mut note,
            )?;
            call_witnesses(dataset, sources, &group, &old)?;
        }
        dataset.set_removed(means(sources));
        Ok(())
    }

    /// Groups of sources that can be sampled at the same time.
    fn apart(&self, sources: &[Found], which: &[usize]) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for &i in which {
            let is_clear =
                |group: &&mut Vec<usize>| !group.iter().any(|&j| self.are_near(sources, i, j));
            match groups.iter_mut().find(is_clear) {
                Some(group) => group.push(i),
                None => groups.push(vec![i]),
            }
        }
        groups
    }

    fn are_near(&self, sources: &[Found], i: usize, j: usize) -> bool {
        let (a, b) = (sources[i].mode.mean.lm, sources[j].mode.mean.lm);
        a.distance(b) < NEAR_BEAMS * self.beam_rad
    }

    /// Where the posterior of a source lies. A mode that was left before it was narrow, or after
    /// it had become a single point, has at least the error that its signal-to-noise ratio allows.
    pub(super) fn region(&self, mode: &Mode, widening: f64) -> Region {
        let least = self.beam_rad / mode.snr_peak().max(1.0);
        let half = widening * REGION_SIGMAS * mode.position_sigma_rad.max(least);
        let half = half.min(self.widest(mode));
        Region::square(mode.mean.lm, 2.0 * half).clipped(self.field)
    }

    /// Half the side of the largest region of a source: in a larger one a faint source would share its
    /// posterior with peaks of the noise, which would ask for a larger one still.
    fn widest(&self, mode: &Mode) -> f64 {
        CLOSE_BEAMS * self.beam_rad.hypot(mode.mean.scale_rad)
    }

    /// Does the posterior end at an edge of `region` that is none of the field? The source lay
    /// elsewhere when its neighbours were not yet known.
    pub(super) fn is_cut_off(&self, mode: &Mode, region: &Region) -> bool {
        let reach = EDGE_SIGMAS * mode.position_sigma_rad;
        let least = self.beam_rad / mode.snr_peak().max(1.0);
        region.distance_to_edge(mode.mean.lm) < reach.max(least)
            && self.field.distance_to_edge(mode.mean.lm) >= reach.max(least)
    }

    /// The whole run about a source is its posterior.
    pub(super) fn refined(&self, old: &Mode, explored: &Explored) -> Mode {
        let evidence = explored.evidence;
        let log_w = explored.run.log_weights().into_iter();
        let samples = explored.samples(log_w.enumerate(), self.prior);
        let log_z = evidence.log_z + explored.log_share(self.field);
        let mut mode = Mode::new(old.tile, samples, log_z, evidence.log_z_err);
        mode.best_xy = old.best_xy;
        mode.is_unfinished = explored.is_unfinished;
        mode
    }
}

pub(super) fn means(sources: &[Found]) -> Vec<Source> {
    sources.iter().map(|found| found.mode.mean).collect()
}

/// Takes the ln L, by part of the visibilities, of some samples of the sources `group`, in the data that they were drawn
/// from: with the `old` models of these sources among the removed.
fn call_witnesses(
    dataset: &mut Dataset,
    sources: &mut [Found],
    group: &[usize],
    old: &[Source],
) -> Result<(), DetectError> {
    for &i in group {
        let samples = &sources[i].mode.samples;
        let chosen = choose(samples, N_WITNESS);
        sources[i].witnesses = chosen
            .into_iter()
            .map(|k| (samples[k].source, 0.0))
            .collect();
    }
    let requests: Vec<Request> = group
        .iter()
        .zip(old)
        .map(|(&i, old)| sources[i].witness_request(*old))
        .collect();
    let xy = dataset.glimpse(&requests)?;
    for (&i, xy) in group.iter().zip(&xy) {
        for ((source, log_l), xy) in sources[i].witnesses.iter_mut().zip(xy) {
            *log_l = xy.log_l(source.flux_jy);
        }
    }
    Ok(())
}

/// The sources about which the data have changed since they were sampled: so much that their
/// ln L scatters by more than `limit`. They are left out of the data.
fn disturbed(
    dataset: &mut Dataset,
    sources: &[Found],
    limit: f64,
) -> Result<Vec<usize>, DetectError> {
    dataset.set_removed(means(sources));
    let requests: Vec<Request> = sources
        .iter()
        .map(|found| found.witness_request(found.mode.mean))
        .collect();
    let xy = dataset.glimpse(&requests)?;
    let is_disturbed = |&i: &usize| {
        let witnesses = sources[i].witnesses.iter().zip(&xy[i]);
        let change: Vec<f64> = witnesses
            .map(|((source, log_l), xy)| xy.log_l(source.flux_jy) - log_l)
            .collect();
        scatter(&change) > limit
    };
    Ok((0..sources.len()).filter(is_disturbed).collect())
}

fn scatter(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::coords::Lm;
    use crate::detect::mode::ModeSample;

    /// A mode at the phase centre whose position scatters by `sigma_rad`.
    fn mode(sigma_rad: f64) -> Mode {
        let sample = |side: f64| ModeSample {
            source: Source {
                lm: Lm {
                    l: side * sigma_rad,
                    m: 0.0,
                },
                flux_jy: 1e-5,
                scale_rad: 3e-6,
                ..Source::default()
            },
            log_l: 10.0,
            weight: 0.5,
        };
        Mode::new(0, vec![sample(-1.0), sample(1.0)], 0.0, 0.1)
    }

    #[test]
    fn the_region_of_a_source_follows_its_posterior_up_to_a_few_beams() {
        let prior = Config::default().source_prior();
        let field = Region::square(Lm::default(), 0.01);
        let beam_rad = 4e-6;
        let refinement = Refinement {
            field: &field,
            prior: &prior,
            factory: &|_| unreachable!("nothing is sampled"),
            beam_rad,
            n_live_draft: 1,
            n_live: 1,
            seed: 1,
        };
        let half_of = |sigma_rad: f64, widening: f64| {
            let mut mode = mode(sigma_rad);
            mode.best_xy = crate::likelihood::Xy { x: 1e6, y: 1e10 };
            assert_eq!(mode.snr_peak(), 10.0);
            0.5 * (refinement.region(&mode, widening).high.l
                - refinement.region(&mode, widening).low.l)
        };
        let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(close(half_of(1e-6, 1.0), REGION_SIGMAS * 1e-6));
        // At least the error that the signal-to-noise ratio allows.
        assert!(close(half_of(1e-9, 1.0), REGION_SIGMAS * beam_rad / 10.0));
        // With beams of 4e-6 and a size of 3e-6.
        let widest = CLOSE_BEAMS * 5e-6;
        assert!(close(half_of(1e-4, 1.0), widest));
        assert!(close(half_of(1e-6, f64::INFINITY), widest));
    }
}
