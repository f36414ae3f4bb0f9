//! Sampling of a posterior of one piece whose many dimensions come in blocks, each of which depends
//! directly on few others: sources that overlap their neighbours.
//!
//! Chains move a block at a time (Metropolis within Gibbs), so that most of ln L need not be worked out
//! again; coupled blocks two at a time, which carries them along what they share; and now and then all
//! together. How far, is told by the covariance of what all chains have seen, which is fitted in rounds. The
//! last round keeps it as it is, and brings the draws.
//!
//! All is done in z, u = Φ(z): the flat prior of the unit cube is then a normal one, without walls.
//!
//! # Source
//! Tierney 1994 (Ann. Statist. 22, 1701), section 2.4; adaptation that ends: Haario, Saksman & Tamminen 2001
//! (Bernoulli 7, 223).

mod block;

use super::diagnostics::{chain_ess, split_r_hat};
use super::student::moments;
use super::{Draws, PosteriorSampler, SamplerError};
use crate::normal;
use block::{Block, Kind};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Chains.
const N_CHAIN: usize = 8;
/// Sweeps of the rounds of fitting.
const FITTING: [usize; 4] = [100, 200, 400, 800];
/// Sweeps of the last round after which it is seen whether there are enough, and the most that there may be.
const N_SWEEP: usize = 250;
const MOST_SWEEPS: usize = 4000;
/// Steps of all blocks together in a sweep.
const N_TOGETHER: usize = 3;
/// Chains agree if split R-hat of all coordinates is below this.
const MOST_R_HAT: f64 = 1.05;
/// What is taken off the covariance of blocks with each other, as it is known from few draws.
const SHRINKAGE: f64 = 0.05;
/// Draws that are kept.
const MOST_DRAWS: usize = 4000;

/// Options of [`Blocks`].
#[derive(Debug, Clone, PartialEq)]
pub struct BlocksConfig {
    /// Dimensions of a block.
    pub block_dim: usize,
    /// Blocks.
    pub n_block: usize,
    /// Blocks that are coupled.
    pub pairs: Vec<[usize; 2]>,
    /// Effective draws that are wanted of every coordinate.
    pub least_ess: f64,
    /// Seed of the random streams.
    pub seed: u64,
}

impl BlocksConfig {
    fn n_dim(&self) -> usize {
        self.block_dim * self.n_block
    }

    /// Coordinates of some blocks.
    fn coordinates(&self, blocks: &[usize]) -> Vec<usize> {
        let d = self.block_dim;
        blocks.iter().flat_map(|b| b * d..(b + 1) * d).collect()
    }
}

/// The sampler: `ask`, evaluate, `tell`, until `ask` brings nothing, as for any other.
#[derive(Debug)]
pub struct Blocks {
    config: BlocksConfig,
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    /// One sweep.
    steps: Vec<(Block, Kind)>,
    chains: Vec<Chain>,
    stage: Stage,
    u: Vec<f64>,
    n_eval: u64,
    draws: Draws,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The chains wait for ln p where they start.
    Starting,
    /// They wait for that of a step of a round.
    Walking {
        round: usize,
        step: usize,
    },
    Finished,
}

/// A chain, and where it would go.
#[derive(Debug)]
struct Chain {
    z: DVector<f64>,
    log_l: f64,
    proposed: DVector<f64>,
    log_ratio: f64,
    rng: ChaCha8Rng,
    /// Where it was after each sweep of the round, with ln L.
    seen: Vec<(DVector<f64>, f64)>,
}

impl Chain {
    fn propose(&mut self, (block, kind): &(Block, Kind)) {
        (self.proposed, self.log_ratio) = block.propose(&self.z, *kind, &mut self.rng);
    }

    /// Goes there or stays.
    fn decide(&mut self, log_l: f64) {
        let log_prior = |z: &DVector<f64>| -0.5 * z.norm_squared();
        let gain = log_l - self.log_l + log_prior(&self.proposed) - log_prior(&self.z);
        if self.rng.random::<f64>().ln() < gain + self.log_ratio {
            self.z.copy_from(&self.proposed);
            self.log_l = log_l;
        }
    }
}

impl Blocks {
    /// A sampler that starts from `seeds`, points of the unit cube, axes (point, dimension): draws of each
    /// block for fixed others.
    pub fn new(config: BlocksConfig, seeds: &[f64]) -> Self {
        let n_dim = config.n_dim();
        let seeds: Vec<DVector<f64>> = (seeds.chunks_exact(n_dim))
            .map(|u| DVector::from_iterator(n_dim, u.iter().map(|&u| normal::from_unit(u))))
            .collect();
        let (mean, covariance) = moments(&seeds, &vec![1.0 / seeds.len() as f64; seeds.len()]);
        let chain = |k: usize| {
            let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
            rng.set_stream(k as u64);
            let start = seeds[rng.random_range(0..seeds.len())].clone();
            Chain {
                z: start.clone(),
                log_l: f64::NEG_INFINITY,
                proposed: start,
                log_ratio: 0.0,
                rng,
                seen: Vec::new(),
            }
        };
        let mut sampler = Self {
            chains: (0..N_CHAIN).map(chain).collect(),
            mean,
            covariance,
            steps: Vec::new(),
            stage: Stage::Starting,
            u: Vec::new(),
            n_eval: 0,
            draws: Draws::default(),
            config,
        };
        // Seeds of different blocks have nothing to do with each other.
        sampler.shrink(1.0);
        sampler.plan();
        sampler.want();
        sampler
    }

    /// Takes a part off the covariance of blocks with each other.
    fn shrink(&mut self, part: f64) {
        let d = self.config.block_dim;
        let n_dim = self.config.n_dim();
        for (i, j) in (0..n_dim).flat_map(|i| (0..n_dim).map(move |j| (i, j))) {
            if i / d != j / d {
                self.covariance[(i, j)] *= 1.0 - part;
            }
        }
    }

    /// The steps of a sweep, by the covariance; none if that is none.
    fn plan(&mut self) {
        let precision = self.covariance.clone().cholesky().map(|c| c.inverse());
        let config = &self.config;
        let singles = (0..config.n_block).map(|b| config.coordinates(&[b]));
        let pairs = config.pairs.iter().map(|pair| config.coordinates(pair));
        let blocks: Option<Vec<Block>> = precision.and_then(|precision| {
            let all = std::iter::once((0..config.n_dim()).collect());
            let own = singles.chain(pairs).chain(all);
            own.map(|own| Block::new(own, &self.mean, &precision))
                .collect()
        });
        let mut blocks = blocks.unwrap_or_default();
        self.steps.clear();
        let Some(all) = blocks.pop() else {
            self.stage = Stage::Finished;
            return;
        };
        for block in blocks {
            self.steps.push((block.clone(), Kind::Walk));
            self.steps.push((block, Kind::Anew));
        }
        self.steps
            .extend(std::iter::repeat_n((all, Kind::Walk), N_TOGETHER));
    }

    /// Asks for ln L where the chains would go.
    fn want(&mut self) {
        self.u.clear();
        if self.stage != Stage::Finished {
            let proposed = self.chains.iter().flat_map(|chain| chain.proposed.iter());
            self.u.extend(proposed.map(|&z| normal::to_unit(z)));
        }
    }

    /// The step after this one.
    fn advance(&mut self, round: usize, step: usize) {
        let is_swept = step + 1 == self.steps.len();
        if is_swept {
            for chain in &mut self.chains {
                chain.seen.push((chain.z.clone(), chain.log_l));
            }
        }
        let step = (step + 1) % self.steps.len();
        self.stage = Stage::Walking { round, step };
        let n_sweep = self.chains[0].seen.len();
        match FITTING.get(round) {
            Some(&length) if is_swept && n_sweep == length => self.refit(round),
            None if is_swept && n_sweep.is_multiple_of(N_SWEEP) => self.judge(n_sweep),
            _ => {}
        }
    }

    /// Fits the covariance to what was seen in a round, without its beginning.
    fn refit(&mut self, round: usize) {
        let late = |chain: &Chain| {
            let first = chain.seen.len() / 4;
            let late = chain.seen[first..].iter();
            late.map(|(z, _)| z.clone()).collect::<Vec<_>>()
        };
        let seen: Vec<DVector<f64>> = self.chains.iter().flat_map(late).collect();
        (self.mean, self.covariance) = moments(&seen, &vec![1.0 / seen.len() as f64; seen.len()]);
        self.shrink(SHRINKAGE);
        for chain in &mut self.chains {
            chain.seen.clear();
        }
        self.stage = Stage::Walking {
            round: round + 1,
            step: 0,
        };
        self.plan();
    }

    /// Ends the last round if it has brought enough, or is too long.
    fn judge(&mut self, n_sweep: usize) {
        let (mut ess, mut r_hat) = (f64::INFINITY, 0.0f64);
        for i in 0..self.config.n_dim() {
            let of_chain = |chain: &Chain| chain.seen.iter().map(|(z, _)| z[i]).collect();
            let chains: Vec<Vec<f64>> = self.chains.iter().map(of_chain).collect();
            ess = ess.min(chain_ess(&chains));
            r_hat = r_hat.max(split_r_hat(&chains));
        }
        tracing::debug!("{n_sweep} sweeps: {ess:.0} effective draws, split R-hat {r_hat:.3}");
        let is_converged = ess >= self.config.least_ess && r_hat < MOST_R_HAT;
        if is_converged || n_sweep >= MOST_SWEEPS {
            self.keep(ess, is_converged);
        }
    }

    fn keep(&mut self, ess: f64, is_converged: bool) {
        let n_seen: usize = self.chains.iter().map(|chain| chain.seen.len()).sum();
        let seen = self.chains.iter().flat_map(|chain| &chain.seen);
        let kept: Vec<_> = seen.step_by(n_seen.div_ceil(MOST_DRAWS)).collect();
        let to_u = |&z: &f64| normal::to_unit(z);
        self.draws = Draws {
            u: kept.iter().flat_map(|(z, _)| z.iter().map(to_u)).collect(),
            log_l: kept.iter().map(|(_, log_l)| *log_l).collect(),
            weight: vec![1.0 / kept.len() as f64; kept.len()],
            ess,
            is_converged,
            ..Draws::default()
        };
        self.stage = Stage::Finished;
    }
}

impl PosteriorSampler for Blocks {
    fn ask(&mut self) -> &[f64] {
        &self.u
    }

    fn tell(&mut self, log_l: &[f64]) -> Result<(), SamplerError> {
        if log_l.len() * self.config.n_dim() != self.u.len() || log_l.iter().any(|l| l.is_nan()) {
            let what = format!("{} numbers for {} chains", log_l.len(), self.chains.len());
            return Err(SamplerError::Protocol(what));
        }
        self.n_eval += log_l.len() as u64;
        match self.stage {
            Stage::Starting => {
                for (chain, &log_l) in self.chains.iter_mut().zip(log_l) {
                    chain.log_l = log_l;
                }
                self.stage = Stage::Walking { round: 0, step: 0 };
                if log_l.contains(&f64::NEG_INFINITY) {
                    self.stage = Stage::Finished;
                }
            }
            Stage::Walking { round, step } => {
                for (chain, &log_l) in self.chains.iter_mut().zip(log_l) {
                    chain.decide(log_l);
                }
                self.advance(round, step);
            }
            Stage::Finished => {}
        }
        if let Stage::Walking { step, .. } = self.stage {
            for chain in &mut self.chains {
                chain.propose(&self.steps[step]);
            }
        }
        self.want();
        Ok(())
    }

    fn finish(self: Box<Self>) -> Draws {
        Draws {
            n_eval: self.n_eval,
            ..self.draws
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::problems::{Blend, correlated_gaussian};

    fn sampled(config: &BlocksConfig, seeds: &[f64], log_l: impl Fn(&[f64]) -> f64) -> Draws {
        let mut sampler = Box::new(Blocks::new(config.clone(), seeds));
        loop {
            let u = sampler.ask();
            if u.is_empty() {
                return sampler.finish();
            }
            let log_l: Vec<f64> = u.chunks_exact(config.n_dim()).map(&log_l).collect();
            sampler.tell(&log_l).unwrap();
        }
    }

    fn config(block_dim: usize, n_block: usize, seed: u64) -> BlocksConfig {
        BlocksConfig {
            block_dim,
            n_block,
            pairs: (1..n_block).map(|b| [b - 1, b]).collect(),
            least_ess: 200.0,
            seed,
        }
    }

    /// 500 points of the cube's middle, `side` wide.
    fn seeds(n_dim: usize, side: f64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(99);
        let coordinate = |_| 0.5 + side * (rng.random::<f64>() - 0.5);
        (0..500 * n_dim).map(coordinate).collect()
    }

    fn assert_moments(draws: &Draws, n_dim: usize, mean: f64, sigma: f64) {
        let five = 5.0 / draws.ess.sqrt();
        for i in 0..n_dim {
            let x = || draws.u.iter().skip(i).step_by(n_dim);
            let n = x().count() as f64;
            let found = x().sum::<f64>() / n;
            assert!((found - mean).abs() < five * sigma, "mean of {i}: {found}");
            let spread = (x().map(|x| (x - found).powi(2)).sum::<f64>() / n).sqrt();
            assert!(
                (spread / sigma - 1.0).abs() < five,
                "spread of {i}: {spread}"
            );
        }
    }

    /// Seeds that know nothing of the correlation, and are too narrow.
    #[test]
    fn a_correlated_gaussian_has_its_moments() {
        let problem = correlated_gaussian(18);
        let log_l = |u: &[f64]| problem.log_l(u);
        let draws = sampled(&config(6, 3, 1), &seeds(18, 0.05), log_l);
        assert!(draws.is_converged, "{} effective", draws.ess);
        assert_moments(&draws, 18, 0.5, 0.05);
    }

    #[test]
    fn what_the_data_do_not_tell_is_the_prior() {
        let draws = sampled(&config(3, 2, 1), &seeds(6, 0.5), |_| 0.0);
        assert!(draws.is_converged);
        assert_moments(&draws, 6, 0.5, 1.0 / 12f64.sqrt());
    }

    /// Three sources that overlap: two seeds agree on all means and widths.
    #[test]
    fn a_blend_of_three_is_sampled() {
        let blend = Blend::new(3);
        let peak = blend.peak();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut near = |_| {
            let z: Vec<f64> = peak
                .iter()
                .map(|z| z + 0.04 * (rng.random::<f64>() - 0.5))
                .collect();
            Blend::to_u(&z)
        };
        let seeds: Vec<f64> = (0..500).flat_map(&mut near).collect();
        let run = |seed| sampled(&config(6, 3, seed), &seeds, |u| blend.log_l(u));
        let (a, b) = (run(1), run(2));
        assert!(a.is_converged && b.is_converged, "{} {}", a.ess, b.ess);
        for i in 0..18 {
            let moments = |draws: &Draws| {
                let x = || {
                    draws
                        .u
                        .iter()
                        .skip(i)
                        .step_by(18)
                        .map(|&u| normal::quantile(u))
                };
                let n = x().count() as f64;
                let mean = x().sum::<f64>() / n;
                (
                    mean,
                    (x().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt(),
                )
            };
            let ((mean_a, sigma_a), (mean_b, sigma_b)) = (moments(&a), moments(&b));
            let error = (1.0 / a.ess + 1.0 / b.ess).sqrt();
            assert!(
                (mean_a - mean_b).abs() < 5.0 * error * sigma_a,
                "mean of {i}"
            );
            assert!(
                (sigma_a / sigma_b - 1.0).abs() < 5.0 * error,
                "sigma of {i}"
            );
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_draws() {
        let problem = correlated_gaussian(6);
        let run = |seed| sampled(&config(3, 2, seed), &seeds(6, 0.05), |u| problem.log_l(u));
        assert_eq!(run(7), run(7));
        assert_ne!(run(7).u, run(8).u);
    }

    #[test]
    fn a_likelihood_that_is_no_number_is_an_error_and_one_that_is_zero_ends_the_run() {
        let mut sampler = Blocks::new(config(1, 2, 1), &seeds(2, 0.5));
        let n = sampler.ask().len() / 2;
        assert!(sampler.tell(&vec![f64::NAN; n]).is_err());
        let draws = sampled(&config(1, 2, 1), &seeds(2, 0.5), |_| f64::NEG_INFINITY);
        assert!(draws.u.is_empty() && !draws.is_converged);
    }
}
