//! Sampling of a posterior of one piece in many dimensions by Hamiltonian trajectories (nuts-rs).
//!
//! Slopes are differences of ln L: a leapfrog step keeps volumes and can be taken back whatever the field
//! that kicks is, so that the draws are right and only the step length suffers. Chains run in threads of
//! their own, each of which waits for the ln L about its place: an `ask` holds the points of all of them. They walk
//! in axes that make the posterior round, by its curvature in the middle of what it starts from.
//!
//! All is done in z, u = Φ(z): the flat prior of the unit cube is then a normal one, without walls. A
//! difference changes one coordinate only, so that what depends on few of them need not be worked out again.
//!
//! # Source
//! Hoffman & Gelman 2014 (J. Mach. Learn. Res. 15, 1593).

mod curvature;
mod walker;

use super::diagnostics::{chain_ess, split_r_hat};
use super::student::moments;
use super::{Draws, PosteriorSampler, SamplerError};
use crate::normal;
use curvature::Curvature;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use walker::Walker;

/// Chains.
const N_CHAIN: usize = 4;
/// Draws of each after which it is seen whether there are enough, and the most that there may be.
const N_ROUND: usize = 100;
const MOST_DRAWS: usize = 600;
/// Chains agree if split R-hat of all coordinates is below this.
const MOST_R_HAT: f64 = 1.05;
/// Half the length of a difference, in standard deviations of the seeds. Differences to one side only would
/// shift the field by far more where coordinates are strongly correlated.
const STEP: f64 = 0.1;
/// Coordinates are kept this far from the faces of the cube.
const FACE: f64 = 1e-14;

/// Options of [`Nuts`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NutsConfig {
    /// Dimensions of the problem.
    pub n_dim: usize,
    /// Effective draws that are wanted of every coordinate.
    pub least_ess: f64,
    /// Seed of the random streams.
    pub seed: u64,
}

/// The sampler: `ask`, evaluate, `tell`, until `ask` brings nothing, as for any other.
#[derive(Debug)]
pub struct Nuts {
    config: NutsConfig,
    /// Middle of the seeds in z, length of a difference, and axes of the posterior as its curvature there
    /// tells, in units of which the chains walk: z = centre + axes y.
    centre: DVector<f64>,
    step: DVector<f64>,
    axes: DMatrix<f64>,
    chains: Vec<Walker>,
    stage: Stage,
    /// Points that wait for their ln L: z, and u row after row.
    z: Vec<DVector<f64>>,
    u: Vec<f64>,
    n_eval: u64,
    draws: Draws,
}

#[derive(Debug, Clone, PartialEq)]
enum Stage {
    /// Curvature at the middle of the seeds; where the chains will start.
    Measuring(Curvature, Vec<DVector<f64>>),
    /// All chains wait for ln p and its slope.
    Walking,
    /// ln L of the draws is wanted: what is known of them.
    Weighing(f64, bool),
    Finished,
}

impl Nuts {
    /// A sampler that starts from `seeds`, points of the unit cube, axes (point, dimension), spread
    /// roughly as the posterior.
    pub fn new(config: NutsConfig, seeds: &[f64]) -> Self {
        let n_dim = config.n_dim;
        let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
        let to_z = |u: &f64| normal::quantile(u.clamp(FACE, 1.0 - FACE));
        let seeds: Vec<DVector<f64>> = (seeds.chunks_exact(n_dim))
            .map(|u| DVector::from_iterator(n_dim, u.iter().map(to_z)))
            .collect();
        let (centre, covariance) = moments(&seeds, &vec![1.0 / seeds.len() as f64; seeds.len()]);
        let width = covariance.diagonal().map(f64::sqrt);
        let mut sampler = Self {
            chains: Vec::new(),
            stage: Stage::Finished,
            z: Vec::new(),
            u: Vec::new(),
            n_eval: 0,
            draws: Draws::default(),
            step: STEP * &width,
            axes: DMatrix::zeros(n_dim, n_dim),
            centre,
            config,
        };
        if width.iter().all(|width| *width > 0.0) {
            let curvature = Curvature::new(&sampler.centre, &width);
            sampler.want(curvature.points());
            let start = |_| seeds[rng.random_range(0..seeds.len())].clone();
            let starts = (0..N_CHAIN).map(start).collect();
            sampler.stage = Stage::Measuring(curvature, starts);
        }
        sampler
    }

    /// Points to be evaluated.
    fn want(&mut self, z: Vec<DVector<f64>>) {
        let to_u = |&z: &f64| normal::cdf(z).clamp(FACE, 1.0 - FACE);
        self.u = z.iter().flat_map(DVector::iter).map(to_u).collect();
        self.z = z;
    }

    fn to_z(&self, y: &DVector<f64>) -> DVector<f64> {
        &self.centre + &self.axes * y
    }

    /// Sets chains going, if the axes are any good.
    fn start(&mut self, axes: Option<DMatrix<f64>>, starts: Vec<DVector<f64>>) {
        let Some(axes) = axes else {
            return;
        };
        for (k, start) in starts.into_iter().enumerate() {
            let Some(start) = axes.solve_lower_triangular(&(start - &self.centre)) else {
                return;
            };
            self.chains.push(Walker::start(start, self.config.seed, k));
        }
        self.axes = axes;
        self.walk();
    }

    /// Lets every chain go on to the next place whose slope it wants.
    fn walk(&mut self) {
        let places: Option<Vec<_>> = self.chains.iter_mut().map(Walker::next_place).collect();
        let Some(places) = places else {
            // Something is wrong with ln L, and a chain has given up.
            return;
        };
        let n_draw = self.chains.iter().map(Walker::n_draw).min().unwrap_or(0);
        let n_draw = n_draw / N_ROUND * N_ROUND;
        if let Some((ess, is_good)) = self.convergence(n_draw)
            && (is_good || n_draw >= MOST_DRAWS)
        {
            let draws = self.chains.iter().flat_map(|chain| chain.draws(n_draw));
            self.want(draws.map(|y| self.to_z(y)).collect());
            self.stage = Stage::Weighing(ess, is_good);
            self.chains.clear();
        } else {
            let stencils = places.iter().flat_map(|y| self.stencil(self.to_z(y)));
            self.want(stencils.collect());
            self.stage = Stage::Walking;
        }
    }

    /// A place, and those on both sides of it in each coordinate.
    fn stencil(&self, z: DVector<f64>) -> Vec<DVector<f64>> {
        let mut stencil = vec![z; 2 * self.config.n_dim + 1];
        for (i, sides) in stencil[1..].chunks_exact_mut(2).enumerate() {
            sides[0][i] += self.step[i];
            sides[1][i] -= self.step[i];
        }
        stencil
    }

    /// Effective draws of the coordinate that has fewest, among the first `n_draw` of each chain, and
    /// whether these will do.
    fn convergence(&self, n_draw: usize) -> Option<(f64, bool)> {
        if n_draw < N_ROUND {
            return None;
        }
        let (mut ess, mut r_hat) = (f64::INFINITY, 0.0f64);
        for i in 0..self.config.n_dim {
            let of_chain = |chain: &Walker| chain.draws(n_draw).map(|y| y[i]).collect();
            let chains: Vec<Vec<f64>> = self.chains.iter().map(of_chain).collect();
            ess = ess.min(chain_ess(&chains));
            r_hat = r_hat.max(split_r_hat(&chains));
        }
        let is_good = ess >= self.config.least_ess && r_hat < MOST_R_HAT;
        Some((ess, is_good))
    }

    /// Tells the chains ln p at their places and its slope there.
    fn answer(&mut self, log_p: &[f64]) {
        let n_dim = self.config.n_dim;
        for (chain, log_p) in self.chains.iter().zip(log_p.chunks_exact(2 * n_dim + 1)) {
            let sides = log_p[1..].chunks_exact(2);
            let differences = sides.map(|sides| 0.5 * (sides[0] - sides[1]));
            let by_z = DVector::from_iterator(n_dim, differences).component_div(&self.step);
            chain.answer(log_p[0], self.axes.tr_mul(&by_z).data.into());
        }
    }
}

impl PosteriorSampler for Nuts {
    fn ask(&mut self) -> &[f64] {
        &self.u
    }

    fn tell(&mut self, log_l: &[f64]) -> Result<(), SamplerError> {
        if log_l.len() != self.z.len() || log_l.iter().any(|l| l.is_nan()) {
            let what = format!("{} numbers for {} points", log_l.len(), self.z.len());
            return Err(SamplerError::Protocol(what));
        }
        self.n_eval += log_l.len() as u64;
        let u = std::mem::take(&mut self.u);
        let with_prior = |(z, l): (&DVector<f64>, &f64)| l - 0.5 * z.norm_squared();
        let log_p: Vec<f64> = self.z.iter().zip(log_l).map(with_prior).collect();
        match std::mem::replace(&mut self.stage, Stage::Finished) {
            Stage::Measuring(curvature, starts) => self.start(curvature.axes(&log_p), starts),
            Stage::Walking => {
                self.answer(&log_p);
                self.walk();
            }
            Stage::Weighing(ess, is_converged) => {
                self.draws = Draws {
                    u,
                    log_l: log_l.to_vec(),
                    weight: vec![1.0 / log_l.len() as f64; log_l.len()],
                    ess,
                    is_converged,
                    ..Draws::default()
                };
            }
            Stage::Finished => {}
        }
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
    use crate::sampler::problems::correlated_gaussian;

    fn sampled(config: NutsConfig, seeds: &[f64], log_l: impl Fn(&[f64]) -> f64) -> Draws {
        let mut sampler = Box::new(Nuts::new(config, seeds));
        loop {
            let u = sampler.ask();
            if u.is_empty() {
                return sampler.finish();
            }
            let log_l: Vec<f64> = u.chunks_exact(config.n_dim).map(&log_l).collect();
            sampler.tell(&log_l).unwrap();
        }
    }

    /// 500 points of the cube's middle, `side` wide.
    fn seeds(n_dim: usize, side: f64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(99);
        let coordinate = |_| 0.5 + side * (rng.random::<f64>() - 0.5);
        (0..500 * n_dim).map(coordinate).collect()
    }

    fn config(n_dim: usize, seed: u64) -> NutsConfig {
        NutsConfig {
            n_dim,
            least_ess: 200.0,
            seed,
        }
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
        let draws = sampled(config(18, 1), &seeds(18, 0.05), |u| problem.log_l(u));
        assert!(draws.is_converged, "{} effective", draws.ess);
        assert_moments(&draws, 18, 0.5, 0.05);
    }

    #[test]
    fn what_the_data_do_not_tell_is_the_prior() {
        let draws = sampled(config(6, 1), &seeds(6, 0.5), |_| 0.0);
        assert!(draws.is_converged);
        assert_moments(&draws, 6, 0.5, 1.0 / 12f64.sqrt());
    }

    #[test]
    fn chains_in_two_far_pieces_have_not_converged() {
        let log_l = |u: &[f64]| -((u[0] - 0.5).abs() - 0.4).powi(2) / 2e-4;
        let mut seeds = seeds(4, 0.5);
        for (k, u) in seeds.chunks_exact_mut(4).enumerate() {
            u[0] = if k % 2 == 0 { 0.1 } else { 0.9 };
        }
        // Of four chains, all begin in one piece with one seed in eight.
        let draws = sampled(config(4, 2), &seeds, log_l);
        assert!(!draws.is_converged && draws.ess < 100.0, "{}", draws.ess);
    }

    #[test]
    fn the_same_seed_gives_the_same_draws() {
        let problem = correlated_gaussian(6);
        let run = |seed| sampled(config(6, seed), &seeds(6, 0.05), |u| problem.log_l(u));
        assert_eq!(run(7), run(7));
        assert_ne!(run(7).u, run(8).u);
    }

    #[test]
    fn a_likelihood_that_is_no_number_is_an_error_and_one_that_is_zero_ends_the_run() {
        let mut sampler = Nuts::new(config(2, 1), &seeds(2, 0.5));
        let n = sampler.ask().len() / 2;
        assert!(sampler.tell(&vec![f64::NAN; n]).is_err());
        let draws = sampled(config(2, 1), &seeds(2, 0.5), |_| f64::NEG_INFINITY);
        assert!(draws.u.is_empty() && !draws.is_converged);
    }
}
