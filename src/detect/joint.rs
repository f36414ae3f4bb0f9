//! Sources that overlap, sampled together: groups of those that are coupled (`coupling`).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::certify::{Certificate, certify};
use super::coupling::{Coupling, groups};
use super::explore::{NO_WEIGHT, in_region};
use super::pipeline::stream_seed;
use super::refine::{Found, Refinement, means};
use super::{DetectError, Mode, ModeSample, Observer};
use crate::dataset::{Dataset, JointView, ViewRequest};
use crate::prior::Region;
use crate::rime::Source;
use crate::sampler::{Blocks, BlocksConfig, Draws, Population, PopulationConfig, PosteriorSampler};

/// Couplings above this one make a region no wider.
const MOST_COUPLING: f64 = 0.97;
/// Groups sampled at a time.
const IN_FLIGHT: usize = 16;
/// Joint samples that the sampler starts from.
const N_SEED: usize = 1000;
/// Joint draws, and effective ones that must be among them.
const N_DRAW: usize = 4000;
const LEAST_ESS: f64 = 400.0;
/// Effective draws from which sampling can be begun again.
const FEWEST_ESS: f64 = 30.0;
/// Times that a group is sampled before it is left as it was.
const MOST_ATTEMPTS: u64 = 4;

/// The same where chains draw, of the coordinate that has fewest.
const LEAST_CHAIN_ESS: f64 = 200.0;
/// Weighted draws are for groups of at most so many; these get chains from this attempt on.
const MOST_WEIGHTED: usize = 3;
const FIRST_ATTEMPT_BY_CHAINS: u64 = 2;

/// How groups are sampled.
#[derive(Debug, Clone, Copy)]
struct How {
    attempt: u64,
    /// By all visibilities.
    is_exact: bool,
}

impl How {
    /// Chains take thousands of steps, each of which would be a pass over all visibilities.
    fn is_by_chains(self, n_member: usize) -> bool {
        let is_hard = n_member > MOST_WEIGHTED || self.attempt >= FIRST_ATTEMPT_BY_CHAINS;
        is_hard && !self.is_exact
    }
}

/// Who was sampled with whom.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Joined {
    /// The first member of each source's group; its own index where it was sampled alone.
    pub(super) group: Vec<usize>,
    /// Whether it is coupled to a source outside of its group: its errors are too small.
    pub(super) is_conditional: Vec<bool>,
}

impl Joined {
    /// `count` sources, each sampled alone.
    pub(super) fn alone(count: usize) -> Self {
        Self {
            group: (0..count).collect(),
            is_conditional: vec![false; count],
        }
    }

    /// Marks what is coupled beyond its group.
    fn mark_conditional(&mut self, couplings: &[Coupling]) {
        for Coupling { pair: [i, j], .. } in couplings {
            if self.group[*i] != self.group[*j] {
                self.is_conditional[*i] = true;
                self.is_conditional[*j] = true;
            }
        }
    }
}

impl Refinement<'_> {
    /// Samples groups of coupled sources jointly; `certificates` of their members are brought up
    /// to date. Groups whose sampling does not converge, or does not stand against all
    /// visibilities, keep the posteriors that they have.
    pub(super) fn join(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Found],
        certificates: &mut [Certificate],
        observer: &mut dyn Observer,
    ) -> Result<Joined, DetectError> {
        let couplings = self.couplings(dataset, sources)?;
        let mut joined = Joined::alone(sources.len());
        let mut waiting = groups(sources.len(), &couplings);
        for is_exact in [false, true] {
            if waiting.is_empty() || is_exact && !dataset.views_take_a_pass() {
                break;
            }
            let before = sources.to_vec();
            let sampled =
                self.sample_until_good(dataset, sources, &waiting, &couplings, is_exact, observer)?;
            let looked_at = certify(dataset, sources, &sampled)?;
            waiting.clear();
            for (group, looked_at) in sampled.into_iter().zip(looked_at) {
                if looked_at.iter().all(|certificate| certificate.is_valid) {
                    for (&i, certificate) in group.iter().zip(looked_at) {
                        certificates[i] = certificate;
                        joined.group[i] = group[0];
                    }
                } else {
                    for &i in &group {
                        sources[i] = before[i].clone();
                    }
                    waiting.push(group);
                }
            }
        }
        dataset.set_removed(means(sources));
        joined.mark_conditional(&couplings);
        Ok(joined)
    }

    /// Samples `groups` jointly, those that did not come out well again from what came out: where
    /// strongly coupled sources had not come to rest, the joint posterior lies elsewhere. The
    /// posteriors of those that converged take the place of the old ones. Returns these.
    fn sample_until_good(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Found],
        groups: &[Vec<usize>],
        couplings: &[Coupling],
        is_exact: bool,
        observer: &mut dyn Observer,
    ) -> Result<Vec<Vec<usize>>, DetectError> {
        let before = sources.to_vec();
        let (mut good, mut poor) = (Vec::new(), groups.to_vec());
        for attempt in 0..MOST_ATTEMPTS {
            if poor.is_empty() {
                break;
            }
            observer.stage("sampling groups", poor.len() as u64);
            let refinement = Refinement {
                seed: stream_seed(self.seed, [6, attempt, 0]),
                ..*self
            };
            let how = How { attempt, is_exact };
            let sampled =
                refinement.sample_groups(dataset, sources, &poor, couplings, how, observer)?;
            poor.retain(|group| !sampled.contains(group));
            good.extend(sampled);
        }
        for &i in poor.iter().flatten() {
            sources[i] = before[i].clone();
        }
        Ok(good)
    }

    /// Samples `groups` jointly; what comes out takes the place of the old posteriors. Returns
    /// those that converged.
    fn sample_groups(
        &self,
        dataset: &mut Dataset,
        sources: &mut [Found],
        groups: &[Vec<usize>],
        couplings: &[Coupling],
        how: How,
        observer: &mut dyn Observer,
    ) -> Result<Vec<Vec<usize>>, DetectError> {
        let mut converged = Vec::new();
        for (n_done, groups) in groups.chunks(IN_FLIGHT).enumerate() {
            dataset.set_removed(means(sources));
            let regions = |group: &Vec<usize>| self.regions(sources, group, couplings);
            let regions: Vec<Vec<Region>> = groups.iter().map(regions).collect();
            let request = |(group, regions): (&Vec<usize>, &Vec<Region>)| {
                let restored: Vec<Source> = group.iter().map(|&i| sources[i].mode.mean).collect();
                let request = |region: &Region| ViewRequest {
                    region: *region,
                    restored: restored.clone(),
                    is_exact: how.is_exact,
                };
                regions.iter().map(request).collect::<Vec<_>>()
            };
            let requests = groups.iter().zip(&regions).map(request);
            let views: Vec<JointView> = requests.map(JointView::new).collect();
            let start =
                |((group, regions), view): ((&Vec<usize>, Vec<Region>), JointView)| Active {
                    sampler: self.sampler(sources, group, &regions, couplings, how),
                    group: group.clone(),
                    regions,
                    view,
                };
            let together = groups.iter().zip(regions).zip(views);
            let mut active: Vec<Active> = together.map(start).collect();
            self.sample(dataset, &mut active)?;
            for active in active {
                converged.extend(self.take_over(sources, active));
            }
            observer.advance((n_done * IN_FLIGHT + groups.len()) as u64, dataset.n_eval());
        }
        Ok(converged)
    }

    /// The regions of the members of a group, wider the more their errors will grow.
    fn regions(&self, sources: &[Found], group: &[usize], couplings: &[Coupling]) -> Vec<Region> {
        let region = |&i: &usize| {
            let of_it = couplings.iter().filter(|c| c.pair.contains(&i));
            let strongest = of_it.fold(0.0f64, |most, c| most.max(c.strength));
            let rho = strongest.min(MOST_COUPLING);
            self.region(&sources[i].mode, 1.0 / (1.0 - rho * rho).sqrt())
        };
        group.iter().map(region).collect()
    }

    /// A sampler that starts from independent samples of the members: weighted draws for few of them, chains for
    /// many, whose steps do not all change all of ln L.
    fn sampler(
        &self,
        sources: &[Found],
        group: &[usize],
        regions: &[Region],
        couplings: &[Coupling],
        how: How,
    ) -> Box<dyn PosteriorSampler> {
        let seed = stream_seed(self.seed, [group[0] as u64, group.len() as u64, 0]);
        let mut rng = ChaCha8Rng::seed_from_u64(stream_seed(seed, [0, 0, 0]));
        let mut seeds = Vec::with_capacity(N_SEED * self.prior.n_dim() * group.len());
        for _ in 0..N_SEED {
            for (&i, region) in group.iter().zip(regions) {
                let source = draw(&sources[i].mode.samples, rng.random());
                seeds.extend(self.prior.unit(region, &source));
            }
        }
        let (block_dim, n_block) = (self.prior.n_dim(), group.len());
        if how.is_by_chains(n_block) {
            let member = |i: usize| group.iter().position(|&j| j == i);
            let inside = |c: &Coupling| Some([member(c.pair[0])?, member(c.pair[1])?]);
            let config = BlocksConfig {
                block_dim,
                n_block,
                pairs: couplings.iter().filter_map(inside).collect(),
                least_ess: LEAST_CHAIN_ESS,
                seed,
            };
            return Box::new(Blocks::new(config, &seeds));
        }
        let config = PopulationConfig {
            n_dim: block_dim * n_block,
            n_draw: N_DRAW,
            least_ess: LEAST_ESS,
            seed,
        };
        Box::new(Population::new(config, &seeds))
    }

    /// Runs the samplers side by side until all are finished.
    fn sample(&self, dataset: &mut Dataset, active: &mut [Active]) -> Result<(), DetectError> {
        loop {
            let points: Vec<Vec<Source>> = active
                .par_iter_mut()
                .map(|a| sources_at(self, &a.regions, a.sampler.ask()))
                .collect();
            if points.iter().all(Vec::is_empty) {
                return Ok(());
            }
            let jobs: Vec<(&JointView, &[Source])> = (active.iter().zip(&points))
                .map(|(a, points)| (&a.view, points.as_slice()))
                .collect();
            let log_l = dataset.evaluate_joint_views(&jobs)?;
            for (a, log_l) in active.iter_mut().zip(log_l) {
                if !log_l.is_empty() {
                    let told = a.sampler.tell(&log_l);
                    told.map_err(|e| in_region(&a.regions[0], e))?;
                }
            }
        }
    }

    /// Makes the draws of a finished group the posteriors of its members, unless they are too few
    /// to tell anything; gives the group if they are good enough to stay.
    fn take_over(&self, sources: &mut [Found], active: Active) -> Option<Vec<usize>> {
        let Active {
            group,
            regions,
            sampler,
            ..
        } = active;
        let draws = sampler.finish();
        tracing::debug!(
            "sources {group:?} together: {:.0} effective of {} draws, tail index {:?}, {} evaluations",
            draws.ess,
            draws.log_l.len(),
            draws.tail_index,
            draws.n_eval
        );
        if draws.u.is_empty() || draws.ess < FEWEST_ESS {
            return None;
        }
        let drawn = sources_at(self, &regions, &draws.u);
        let mode = |(k, &i): (usize, &usize)| {
            let drawn = drawn.iter().skip(k).step_by(group.len());
            marginal(&sources[i].mode, drawn, &draws)
        };
        let modes: Vec<Mode> = group.iter().enumerate().map(mode).collect();
        let is_cut_off = |(mode, region): (&Mode, &Region)| self.is_cut_off(mode, region);
        let is_good = draws.is_converged && !modes.iter().zip(&regions).any(is_cut_off);
        for (&i, mode) in group.iter().zip(modes) {
            sources[i].mode = mode;
        }
        is_good.then_some(group)
    }
}

/// A group that is being sampled.
struct Active {
    group: Vec<usize>,
    regions: Vec<Region>,
    view: JointView,
    sampler: Box<dyn PosteriorSampler>,
}

/// The sources at `u`, one for each region and point.
fn sources_at(refinement: &Refinement, regions: &[Region], u: &[f64]) -> Vec<Source> {
    let (prior, regions) = (refinement.prior, regions.iter().cycle());
    let at = |(u, region): (&[f64], &Region)| prior.source(region, u);
    u.chunks_exact(prior.n_dim()).zip(regions).map(at).collect()
}

/// The posterior of one member: its part of all joint draws, which carry the joint ln L.
fn marginal<'a>(old: &Mode, drawn: impl Iterator<Item = &'a Source>, draws: &Draws) -> Mode {
    let sample = |(source, (&log_l, &weight)): (&Source, (&f64, &f64))| ModeSample {
        source: *source,
        log_l,
        weight,
    };
    let samples = drawn
        .zip(draws.log_l.iter().zip(&draws.weight))
        .map(sample)
        .filter(|sample| sample.weight > NO_WEIGHT)
        .collect();
    let mut mode = Mode::new(old.tile, samples, old.log_z, old.log_z_err);
    mode.mean_log_l = old.mean_log_l;
    mode.best_xy = old.best_xy;
    mode.is_unfinished = old.is_unfinished;
    mode
}

/// The sample below which a share `u` of the weight lies.
fn draw(samples: &[ModeSample], u: f64) -> Source {
    let mut below = 0.0;
    let is_it = |sample: &&ModeSample| {
        below += sample.weight;
        below > u
    };
    let found = samples.iter().find(is_it).or(samples.last());
    found.map_or_else(Source::default, |sample| sample.source)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_coupled_beyond_their_group_are_marked() {
        let mut joined = Joined::alone(4);
        joined.group[1] = 0;
        let coupling = |pair, strength| Coupling { pair, strength };
        joined.mark_conditional(&[coupling([0, 1], 0.9), coupling([1, 2], 0.4)]);
        assert_eq!(joined.is_conditional, [false, true, true, false]);
    }
}
