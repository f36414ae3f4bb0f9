//! Sampling of a posterior of one piece, about which much is known beforehand: points are drawn from
//! a t distribution, weighted, and the t distribution is fitted to them, until it fits.
//!
//! All is done in z, u = Φ(z): the flat prior of the unit cube is then a normal one, so that a
//! posterior is close to a Gaussian both in the coordinates that the data tell and in those that
//! they do not.
//!
//! # Source
//! Population Monte Carlo: Cappé, Guillin, Marin & Robert 2004 (J. Comput. Graph. Stat. 13, 907);
//! weights that are flattened while the fit is poor: Koblents & Míguez 2015 (Stat. Comput. 25, 407).

use super::pareto::{RELIABLE, tail_index};
use super::student::{Student, moments};
use super::{Draws, PosteriorSampler, SamplerError};
use crate::normal;
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Points of a round of fitting, a dimension: the axes of the fit are then good to 10%.
const POINTS_PER_DIM: usize = 100;
/// Least part of the points of a round that must count: weights are flattened until it does.
const LEAST_SHARE: f64 = 0.2;
/// The fit is good when a round has made the effective part of the points larger by less than this.
const GAIN: f64 = 0.03;
/// Rounds after which the fit is taken as it is.
const MOST_ROUNDS: usize = 20;
/// How much larger than that of the seeds the first covariance is.
const FIRST_GROWTH: f64 = 2.0;

/// Options of [`Population`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PopulationConfig {
    /// Dimensions of the problem.
    pub n_dim: usize,
    /// Points drawn in the end.
    pub n_draw: usize,
    /// Effective ones that must be among them.
    pub least_ess: f64,
    /// Seed of the random stream.
    pub seed: u64,
}

/// The sampler: `ask`, evaluate, `tell`, until `ask` brings nothing, as for any other.
#[derive(Debug)]
pub struct Population {
    config: PopulationConfig,
    rng: ChaCha8Rng,
    proposal: Option<Student>,
    /// Points that wait for their ln L: z, ln(prior/proposal), and u row after row.
    z: Vec<DVector<f64>>,
    log_ratio: Vec<f64>,
    u: Vec<f64>,
    stage: Stage,
    n_eval: u64,
    draws: Draws,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    /// Fitting: rounds done, and the effective part of the points in the last one.
    Fitting {
        round: usize,
        share: f64,
    },
    Drawing,
    Finished,
}

impl Population {
    /// A sampler that starts from `seeds`, points of the unit cube, axes (point, dimension), spread
    /// roughly as the posterior.
    pub fn new(config: PopulationConfig, seeds: &[f64]) -> Self {
        let z: Vec<DVector<f64>> = seeds
            .chunks_exact(config.n_dim)
            .map(|u| DVector::from_iterator(config.n_dim, u.iter().map(|&u| normal::from_unit(u))))
            .collect();
        let (mean, covariance) = moments(&z, &vec![1.0 / z.len() as f64; z.len()]);
        Self {
            config,
            rng: ChaCha8Rng::seed_from_u64(config.seed),
            proposal: Student::new(mean, covariance * FIRST_GROWTH),
            z: Vec::new(),
            log_ratio: Vec::new(),
            u: Vec::new(),
            stage: Stage::Fitting {
                round: 0,
                share: 0.0,
            },
            n_eval: 0,
            draws: Draws::default(),
        }
    }

    /// Draws `n` points; none without a proposal.
    fn propose(&mut self, n: usize) {
        self.log_ratio.clear();
        let Some(proposal) = &self.proposal else {
            return;
        };
        for _ in 0..n {
            let (z, log_q) = proposal.draw(&mut self.rng);
            let log_prior = -0.5 * (z.norm_squared() + z.len() as f64 * TAU.ln());
            self.log_ratio.push(log_prior - log_q);
            self.u.extend(z.iter().map(|&z| normal::to_unit(z)));
            self.z.push(z);
        }
    }

    /// Fits the proposal to the points.
    fn fit(&mut self, log_w: &[f64], round: usize, last_share: f64) {
        let (weights, flattening) = flattened(log_w);
        let (mean, covariance) = moments(&self.z, &weights);
        let refitted = Student::new(mean, covariance);
        let share = ess(&normalised(log_w, 1.0)) / log_w.len() as f64;
        tracing::debug!("round {round}: weights to the power of {flattening:.3}, {share:.3} count");
        let is_good = flattening == 1.0 && share < last_share + GAIN;
        self.stage = if is_good || refitted.is_none() || round + 1 >= MOST_ROUNDS {
            Stage::Drawing
        } else {
            let round = round + 1;
            Stage::Fitting { round, share }
        };
        self.proposal = refitted.or(self.proposal.take());
    }

    fn keep(&mut self, log_l: &[f64], log_w: &[f64]) {
        let top = log_w.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = log_w.iter().map(|w| (w - top).exp()).sum();
        let weight = normalised(log_w, 1.0);
        let (ess, tail_index) = (ess(&weight), tail_index(&weight));
        self.stage = Stage::Finished;
        self.draws = Draws {
            u: std::mem::take(&mut self.u),
            log_l: log_l.to_vec(),
            log_z: Some(top + (sum / log_w.len() as f64).ln()),
            ess,
            tail_index,
            n_eval: 0,
            is_converged: ess >= self.config.least_ess && tail_index.is_none_or(|k| k < RELIABLE),
            weight,
        };
    }
}

impl PosteriorSampler for Population {
    fn ask(&mut self) -> &[f64] {
        if self.z.is_empty() {
            let n = match self.stage {
                Stage::Fitting { .. } => POINTS_PER_DIM * self.config.n_dim,
                Stage::Drawing => self.config.n_draw,
                Stage::Finished => 0,
            };
            self.propose(n);
        }
        &self.u
    }

    fn tell(&mut self, log_l: &[f64]) -> Result<(), SamplerError> {
        if log_l.len() != self.z.len() || log_l.iter().any(|l| l.is_nan()) {
            let what = format!("{} numbers for {} points", log_l.len(), self.z.len());
            return Err(SamplerError::Protocol(what));
        }
        self.n_eval += log_l.len() as u64;
        let log_w: Vec<f64> = (self.log_ratio.iter().zip(log_l))
            .map(|(r, l)| r + l)
            .collect();
        match self.stage {
            Stage::Fitting { round, share } => self.fit(&log_w, round, share),
            _ => self.keep(log_l, &log_w),
        }
        self.z.clear();
        self.u.clear();
        Ok(())
    }

    fn finish(self: Box<Self>) -> Draws {
        Draws {
            n_eval: self.n_eval,
            ..self.draws
        }
    }
}

/// Weights summing to one, to the highest power up to one that lets [`LEAST_SHARE`] of them count,
/// and that power.
fn flattened(log_w: &[f64]) -> (Vec<f64>, f64) {
    let least = LEAST_SHARE * log_w.len() as f64;
    let is_enough = |power: f64| ess(&normalised(log_w, power)) >= least;
    if is_enough(1.0) {
        return (normalised(log_w, 1.0), 1.0);
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if is_enough(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    (normalised(log_w, low), low)
}

/// exp(power ln w), summing to one; all equal if none is finite.
fn normalised(log_w: &[f64], power: f64) -> Vec<f64> {
    let top = log_w.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !top.is_finite() {
        return vec![1.0 / log_w.len() as f64; log_w.len()];
    }
    let weights = log_w.iter().map(|w| (power * (w - top)).exp());
    // 0 x -inf: a point outside counts for nothing, whatever the power.
    let weights: Vec<f64> = weights.map(|w| if w.is_nan() { 0.0 } else { w }).collect();
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / total).collect()
}

/// Effective number of points (Kish 1965).
fn ess(weights: &[f64]) -> f64 {
    1.0 / weights.iter().map(|w| w * w).sum::<f64>()
}

#[cfg(test)]
mod tests;
