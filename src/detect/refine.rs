//! Each source sampled anew with all others removed, until the sources stand still.

use super::explore::{Explored, SamplerFactory, SamplerSettings, Target, explore, samples};
use super::{DetectError, Mode, Observer};
use crate::coords::Lm;
use crate::dataset::Dataset;
use crate::prior::{Region, SourcePrior};
use crate::rime::Source;

/// Half the side of the region about a source, in standard deviations of its position.
const REGION_SIGMAS: f64 = 8.0;
/// Sources stand still when none moves by more than this, in its own standard deviations.
const STANDSTILL_SIGMAS: f64 = 0.15;
/// Rounds after which they are taken as they are.
const MOST_ROUNDS: usize = 12;
/// Sources nearer than this many widths of the beam disturb each other.
const NEAR_BEAMS: f64 = 6.0;

/// Where and how sources are sampled again.
pub(super) struct Refinement<'a> {
    pub(super) field: &'a Region,
    pub(super) prior: &'a SourcePrior,
    pub(super) factory: &'a SamplerFactory<'a>,
    /// Width of the beam [rad].
    pub(super) beam_rad: f64,
    pub(super) n_live: usize,
    pub(super) seed: u64,
}

impl Refinement<'_> {
    /// Replaces each mode from `first` on by the posterior with all the others removed; `dataset`
    /// is left with all of them removed. Returns the likelihood evaluations.
    pub(super) fn run(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Mode],
        first: usize,
        observer: &mut dyn Observer,
    ) -> Result<u64, DetectError> {
        let mut n_eval = 0;
        let mut moving: Vec<usize> = (first..sources.len()).collect();
        for round in 0..MOST_ROUNDS {
            observer.stage("refining sources", moving.len() as u64);
            let before = sources.to_vec();
            for group in self.apart(sources, &moving) {
                dataset.set_removed(means(sources));
                n_eval += self.sample(dataset, sources, &group, round, observer)?;
            }
            // A source is sampled again only if a neighbour has moved since.
            let moved: Vec<usize> = moving
                .iter()
                .copied()
                .filter(|&i| !stands_still(&before[i], &sources[i]))
                .collect();
            moving.retain(|&i| {
                let here = sources[i].mean.lm;
                moved
                    .iter()
                    .any(|&j| j != i && self.are_near(sources[j].mean.lm, here))
            });
            if moving.is_empty() {
                break;
            }
        }
        dataset.set_removed(means(sources));
        Ok(n_eval)
    }

    fn are_near(&self, a: Lm, b: Lm) -> bool {
        (a.l - b.l).hypot(a.m - b.m) < NEAR_BEAMS * self.beam_rad
    }

    /// Groups of sources that can be sampled at the same time: near ones come one after the
    /// other, so that each sees the latest of its neighbours.
    fn apart(&self, sources: &[Mode], which: &[usize]) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for &i in which {
            let is_clear = |group: &&mut Vec<usize>| {
                !group
                    .iter()
                    .any(|&j| self.are_near(sources[i].mean.lm, sources[j].mean.lm))
            };
            match groups.iter_mut().find(is_clear) {
                Some(group) => group.push(i),
                None => groups.push(vec![i]),
            }
        }
        groups
    }

    fn sample(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Mode],
        group: &[usize],
        round: usize,
        observer: &mut dyn Observer,
    ) -> Result<u64, DetectError> {
        let target = |&i: &usize| Target {
            region: self.region(&sources[i]),
            restored: vec![sources[i].mean],
            sampler: SamplerSettings {
                n_live: self.n_live,
                modes: false,
                seed: super::pipeline::stream_seed(self.seed, [2, round as u64, i as u64]),
            },
        };
        let targets = group.iter().map(target).collect();
        explore(
            dataset,
            self.prior,
            self.factory,
            targets,
            observer,
            &mut |explored| {
                let i = group[explored.index];
                sources[i] = self.refined(&sources[i], &explored);
            },
        )
    }

    fn region(&self, mode: &Mode) -> Region {
        let half = REGION_SIGMAS * mode.position_sigma_rad;
        Region::square(mode.mean.lm, 2.0 * half).clipped(self.field)
    }

    /// The whole run about a source is its posterior.
    fn refined(&self, old: &Mode, explored: &Explored) -> Mode {
        let Explored { region, run, .. } = explored;
        let evidence = run.evidence();
        let log_w = run
            .log_weights()
            .into_iter()
            .map(|log_w| log_w - evidence.log_z);
        let samples = samples(run, log_w.enumerate(), region, self.prior);
        let log_share = (region.area() / self.field.area()).ln();
        let mut mode = Mode::new(
            old.tile,
            samples,
            evidence.log_z + log_share,
            evidence.log_z_err,
        );
        mode.best_xy = old.best_xy;
        mode
    }
}

fn means(sources: &[Mode]) -> Vec<Source> {
    sources.iter().map(|mode| mode.mean).collect()
}

fn stands_still(old: &Mode, new: &Mode) -> bool {
    let moved = (old.mean.lm.l - new.mean.lm.l).hypot(old.mean.lm.m - new.mean.lm.m);
    moved < STANDSTILL_SIGMAS * new.position_sigma_rad
        && (old.mean.flux_jy - new.mean.flux_jy).abs() < STANDSTILL_SIGMAS * new.flux_sigma_jy
}
