//! Each source sampled anew with all others removed, until the sources stand still.

use super::explore::{Explored, SamplerFactory, SamplerSettings, Target, explore, samples};
use super::{DetectError, Mode, Observer};
use crate::dataset::Dataset;
use crate::prior::{Region, SourcePrior};
use crate::rime::Source;

/// Half the side of the region about a source, in standard deviations of its position.
const REGION_SIGMAS: f64 = 8.0;
/// Sources stand still when none moves by more than this, in its own standard deviations.
const STANDSTILL_SIGMAS: f64 = 0.15;
/// Rounds after which they are taken as they are.
const MOST_ROUNDS: usize = 3;

/// Where and how sources are sampled again.
pub(super) struct Refinement<'a> {
    pub(super) field: &'a Region,
    pub(super) prior: &'a SourcePrior,
    pub(super) factory: &'a SamplerFactory<'a>,
    pub(super) n_live: usize,
    pub(super) seed: u64,
}

impl Refinement<'_> {
    /// Replaces each mode from `first` on by the posterior with all the others removed; `dataset` is left with
    /// all of them removed. Returns the likelihood evaluations.
    pub(super) fn run(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Mode],
        first: usize,
        observer: &mut dyn Observer,
    ) -> Result<u64, DetectError> {
        let mut n_eval = 0;
        for round in 0..MOST_ROUNDS {
            observer.stage("refining sources", (sources.len() - first) as u64);
            dataset.set_removed(means(sources));
            let before = sources.to_vec();
            n_eval += self.round(dataset, &mut sources[first..], round, observer)?;
            if before
                .iter()
                .zip(&*sources)
                .all(|(old, new)| stands_still(old, new))
            {
                break;
            }
        }
        dataset.set_removed(means(sources));
        Ok(n_eval)
    }

    fn round(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Mode],
        round: usize,
        observer: &mut dyn Observer,
    ) -> Result<u64, DetectError> {
        let targets = sources
            .iter()
            .enumerate()
            .map(|(i, mode)| Target {
                region: self.region(mode),
                restored: vec![mode.mean],
                sampler: SamplerSettings {
                    n_live: self.n_live,
                    modes: false,
                    seed: super::pipeline::stream_seed(self.seed, [2, round as u64, i as u64]),
                },
            })
            .collect();
        explore(
            dataset,
            self.prior,
            self.factory,
            targets,
            observer,
            &mut |explored| {
                let old = &sources[explored.index];
                sources[explored.index] = self.refined(old, &explored);
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
