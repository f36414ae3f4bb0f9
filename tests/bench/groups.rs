//! Which sampler for sources that overlap: blends of 2, 5 and 10 components, 12 to 60 dimensions.
//!
//! `cargo bench --bench groups [-- COUNT... NAME...]` prints, for population Monte Carlo, chains by blocks (a call: as many
//! of the n (n + 1)/2 sums of single components and pairs as ln L is made of, as far as they are new),
//! nested slices (d or 3 d a point) and NUTS with analytic slopes (a call: ln L and slope): calls, effective
//! draws, calls for each of these, and how far the marginals are from those of a NUTS run ten times as long:
//! the largest error of a mean in sigma, and the largest relative error of a sigma, over all parameters.
//!
//! All but nested slices start from what detection knows beforehand: each component's posterior
//! for fixed neighbours.
#![allow(clippy::print_stdout, missing_docs)]

use nalgebra::{DMatrix, DVector};
use nuts_rs::{
    Chain, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::convert::Infallible;
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Instant;
use vis2cat::sampler::problems::Blend;
use vis2cat::sampler::{
    Blocks, BlocksConfig, Population, PopulationConfig, PosteriorSampler, Slice, SliceConfig, run,
};

/// Parameters of a component.
const N_PARAM: usize = 6;
/// Draws that NUTS tunes with, and keeps.
const N_TUNE: u64 = 300;
const N_NUTS: usize = 1000;
/// As in detection.
const N_SEED: usize = 1000;
const N_DRAW: usize = 4000;
const LEAST_ESS: f64 = 400.0;
const LEAST_CHAIN_ESS: f64 = 200.0;
const N_LIVE: usize = 100;

/// Names of samplers that can be asked for.
const ALL: [&str; 4] = ["population", "blocks", "slices", "with"];

fn main() {
    let counts: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let counts = if counts.is_empty() {
        vec![2, 5, 10]
    } else {
        counts
    };
    println!(
        "components  sampler       calls  effective  calls each  worst mean  worst sigma   time s"
    );
    for count in counts {
        let blend = Blend::new(count);
        let laplace = Laplace::new(&blend);
        let reference = nuts(&blend, &laplace, 10 * N_NUTS, 99);
        for seed in 1..=3 {
            let samplers: [(&str, &dyn Fn() -> Sample); 5] = [
                ("population", &|| population(&blend, &laplace, seed)),
                ("blocks", &|| blocks(&blend, &laplace, seed)),
                ("slices, d", &|| slices(&blend, 1, seed)),
                ("slices, 3 d", &|| slices(&blend, 3, seed)),
                ("with slopes", &|| nuts(&blend, &laplace, N_NUTS, seed)),
            ];
            let is_wanted = |name: &str| {
                std::env::args().skip(1).all(|a| !ALL.contains(&&*a))
                    || std::env::args().any(|a| name.starts_with(&a))
            };
            for (name, sampler) in samplers.into_iter().filter(|(name, _)| is_wanted(name)) {
                report(count, name, &reference, sampler);
            }
        }
    }
}

/// Weighted draws and what they cost.
struct Sample {
    u: Vec<Vec<f64>>,
    weight: Vec<f64>,
    ess: f64,
    n_eval: u64,
}

impl Sample {
    /// Means and standard deviations.
    fn moments(&self) -> (Vec<f64>, Vec<f64>) {
        let total: f64 = self.weight.iter().sum();
        let average = |f: &dyn Fn(&Vec<f64>) -> f64| {
            let terms = self.u.iter().zip(&self.weight);
            terms.map(|(u, w)| w * f(u)).sum::<f64>() / total
        };
        let n_dim = self.u[0].len();
        let mean: Vec<f64> = (0..n_dim).map(|i| average(&|u| u[i])).collect();
        let sigma = |i: usize| average(&|u| (u[i] - mean[i]).powi(2)).sqrt();
        let sigma = (0..n_dim).map(sigma).collect();
        (mean, sigma)
    }
}

fn report(count: usize, name: &str, reference: &Sample, sampler: &dyn Fn() -> Sample) {
    let start = Instant::now();
    let sample = sampler();
    let time_s = start.elapsed().as_secs_f64();
    let ((mean, sigma), (true_mean, true_sigma)) = (sample.moments(), reference.moments());
    let worst =
        |error: &dyn Fn(usize) -> f64| (0..mean.len()).map(|i| error(i).abs()).fold(0.0, f64::max);
    println!(
        "{count:10}  {name:11} {:7}  {:9.0}  {:10.0}  {:10.3}  {:11.3}  {time_s:7.2}",
        sample.n_eval,
        sample.ess,
        sample.n_eval as f64 / sample.ess,
        worst(&|i| (mean[i] - true_mean[i]) / true_sigma[i]),
        worst(&|i| sigma[i] / true_sigma[i] - 1.0),
    );
}

/// The Gaussian at the peak: its axes, and those of each component for fixed neighbours.
struct Laplace {
    peak: Vec<f64>,
    joint: DMatrix<f64>,
    conditional: Vec<DMatrix<f64>>,
}

impl Laplace {
    fn new(blend: &Blend) -> Self {
        const STEP: f64 = 1e-5;
        let (n_dim, peak) = (blend.n_dim(), blend.peak());
        let column = |i: usize| {
            let at = |step: f64| {
                let mut z = peak.clone();
                z[i] += step;
                DVector::from_vec(blend.log_l_and_slope(&z).1)
            };
            (at(-STEP) - at(STEP)) / (2.0 * STEP)
        };
        let columns: Vec<DVector<f64>> = (0..n_dim).map(column).collect();
        let curvature = DMatrix::from_columns(&columns);
        let curvature = 0.5 * (&curvature + curvature.transpose());
        // The prior's own.
        let curvature = curvature + DMatrix::identity(n_dim, n_dim);
        let axes = |curvature: DMatrix<f64>| {
            let covariance = curvature.try_inverse().expect("a peak");
            covariance.cholesky().expect("a peak").unpack()
        };
        let block = |k: usize| {
            let first = N_PARAM * k;
            axes(
                curvature
                    .view((first, first), (N_PARAM, N_PARAM))
                    .into_owned(),
            )
        };
        Self {
            conditional: (0..n_dim / N_PARAM).map(block).collect(),
            joint: axes(curvature),
            peak,
        }
    }

    /// What the samplers start from.
    fn seeds(&self, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..N_SEED)
            .flat_map(|_| self.conditional_draw(&mut rng))
            .collect()
    }

    /// A draw of every component for fixed neighbours, in the unit cube.
    fn conditional_draw(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mut z = self.peak.clone();
        for (axes, z) in self.conditional.iter().zip(z.chunks_exact_mut(N_PARAM)) {
            let normal = DVector::from_fn(N_PARAM, |_, _| StandardNormal.sample(rng));
            let moved: DVector<f64> = axes * normal;
            z.iter_mut()
                .zip(moved.iter())
                .for_each(|(z, moved)| *z += moved);
        }
        Blend::to_u(&z)
    }
}

fn population(blend: &Blend, laplace: &Laplace, seed: u64) -> Sample {
    let n_dim = blend.n_dim();
    let config = PopulationConfig {
        n_dim,
        n_draw: N_DRAW,
        least_ess: LEAST_ESS,
        seed,
    };
    let seeds = laplace.seeds(seed);
    let mut sampler = Population::new(config, &seeds);
    loop {
        let u = sampler.ask();
        if u.is_empty() {
            break;
        }
        let log_l: Vec<f64> = u.chunks_exact(n_dim).map(|u| blend.log_l(u)).collect();
        sampler.tell(&log_l).expect("numbers");
    }
    let draws = Box::new(sampler).finish();
    Sample {
        u: draws.u.chunks_exact(n_dim).map(<[f64]>::to_vec).collect(),
        weight: draws.weight,
        ess: draws.ess,
        n_eval: draws.n_eval,
    }
}

fn blocks(blend: &Blend, laplace: &Laplace, seed: u64) -> Sample {
    let n_dim = blend.n_dim();
    let n_block = n_dim / N_PARAM;
    let config = BlocksConfig {
        block_dim: N_PARAM,
        n_block,
        pairs: (1..n_block).map(|b| [b - 1, b]).collect(),
        least_ess: LEAST_CHAIN_ESS,
        seed,
    };
    let seeds = laplace.seeds(seed);
    let mut sampler = Blocks::new(config, &seeds);
    let (mut singles, mut pairs) = (HashSet::new(), HashSet::new());
    loop {
        let u = sampler.ask();
        if u.is_empty() {
            break;
        }
        for u in u.chunks_exact(n_dim) {
            let bits = |u: &[f64]| u.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let keys: Vec<Vec<u64>> = u.chunks_exact(N_PARAM).map(bits).collect();
            for (i, a) in keys.iter().enumerate() {
                singles.insert(a.clone());
                pairs.extend(keys[..i].iter().map(|b| (b.clone(), a.clone())));
            }
        }
        let log_l: Vec<f64> = u.chunks_exact(n_dim).map(|u| blend.log_l(u)).collect();
        sampler.tell(&log_l).expect("numbers");
    }
    let draws = Box::new(sampler).finish();
    let n_sum = singles.len() + pairs.len();
    Sample {
        u: draws.u.chunks_exact(n_dim).map(<[f64]>::to_vec).collect(),
        weight: draws.weight,
        ess: draws.ess,
        n_eval: (n_sum / (n_block * (n_block + 1) / 2)) as u64,
    }
}

/// The posterior of nested slices, `sweeps` of the dimensions a point.
fn slices(blend: &Blend, sweeps: usize, seed: u64) -> Sample {
    let n_dim = blend.n_dim();
    let config = SliceConfig {
        mode_dims: Vec::new(),
        n_repeats: sweeps * n_dim,
        seed,
        ..SliceConfig::new(n_dim, N_LIVE)
    };
    let log_l = |u: &[f64]| -> Result<Vec<f64>, Infallible> {
        Ok(u.chunks_exact(n_dim).map(|u| blend.log_l(u)).collect())
    };
    let sampler = Box::new(Slice::new(config).expect("options"));
    let run = run(sampler, log_l, |_| ControlFlow::Continue(())).expect("a finished run");
    let evidence = run.evidence();
    let log_w = run.log_weights();
    Sample {
        u: run.dead.iter().map(|dead| dead.u.clone()).collect(),
        weight: log_w.iter().map(|w| w.exp()).collect(),
        ess: evidence.ess,
        n_eval: run.n_eval,
    }
}

fn nuts(blend: &Blend, laplace: &Laplace, n_draw: usize, seed: u64) -> Sample {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let calls = Rc::new(Cell::new(0));
    let density = Density {
        blend: blend.clone(),
        peak: DVector::from_vec(laplace.peak.clone()),
        axes: laplace.joint.clone(),
        calls: Rc::clone(&calls),
    };
    let to_u = |y: &[f64]| Blend::to_u(density.z(y).as_slice());
    let settings = DiagNutsSettings {
        num_tune: N_TUNE,
        ..DiagNutsSettings::default()
    };
    let math = CpuMath::new(density.clone());
    let mut chain = settings.new_chain(0, math, &mut rng).expect("settings");
    let start: Vec<f64> = (0..blend.n_dim())
        .map(|_| rng.random_range(-0.5..0.5))
        .collect();
    chain.set_position(&start).expect("a place to start");
    let mut draws = Vec::with_capacity(n_draw);
    for k in 0..N_TUNE as usize + n_draw {
        let (y, _) = chain.draw().expect("a draw");
        if k >= N_TUNE as usize {
            draws.push(to_u(&y));
        }
    }
    Sample {
        weight: vec![1.0; draws.len()],
        ess: ess(&draws),
        u: draws,
        n_eval: calls.get(),
    }
}

/// The posterior in whitened z.
#[derive(Clone)]
struct Density {
    blend: Blend,
    peak: DVector<f64>,
    axes: DMatrix<f64>,
    calls: Rc<Cell<u64>>,
}

impl Density {
    fn z(&self, y: &[f64]) -> DVector<f64> {
        &self.peak + &self.axes * DVector::from_column_slice(y)
    }
}

#[derive(Debug, thiserror::Error)]
#[error("ln L is no number")]
struct NotFinite;

impl LogpError for NotFinite {
    fn is_recoverable(&self) -> bool {
        true
    }
}

impl HasDims for Density {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), self.dim() as u64)])
    }
}

impl CpuLogpFunc for Density {
    type LogpError = NotFinite;
    type ExpandedVector = Vec<f64>;
    type FlowParameters = ();

    fn dim(&self) -> usize {
        self.blend.n_dim()
    }

    fn logp(&mut self, y: &[f64], slope: &mut [f64]) -> Result<f64, NotFinite> {
        self.calls.set(self.calls.get() + 1);
        let z = self.z(y);
        let (log_l, by_z) = self.blend.log_l_and_slope(z.as_slice());
        let log_p = log_l - 0.5 * z.norm_squared();
        if !log_p.is_finite() {
            return Err(NotFinite);
        }
        let by_y = self.axes.transpose() * (DVector::from_vec(by_z) - z);
        slope.copy_from_slice(by_y.as_slice());
        Ok(log_p)
    }

    fn expand_vector<R: Rng + ?Sized>(
        &mut self,
        _rng: &mut R,
        position: &[f64],
    ) -> Result<Vec<f64>, CpuMathError> {
        Ok(position.to_vec())
    }
}

/// Effective number of draws of a chain, the least of all parameters (Geyer 1992: sums of neighbouring
/// autocorrelations as long as they are positive).
fn ess(draws: &[Vec<f64>]) -> f64 {
    let n = draws.len();
    let of = |i: usize| {
        let mean = draws.iter().map(|u| u[i]).sum::<f64>() / n as f64;
        let covariance = |lag: usize| {
            let pairs = draws.iter().zip(&draws[lag..]);
            pairs
                .map(|(a, b)| (a[i] - mean) * (b[i] - mean))
                .sum::<f64>()
                / n as f64
        };
        let variance = covariance(0);
        let pairs = (0..n / 4).map(|k| covariance(2 * k) + covariance(2 * k + 1));
        let sum: f64 = pairs.take_while(|pair| *pair > 0.0).sum();
        n as f64 / (2.0 * sum / variance - 1.0)
    };
    (0..draws[0].len()).map(of).fold(f64::INFINITY, f64::min)
}
