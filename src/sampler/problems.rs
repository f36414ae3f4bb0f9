//! Problems with known evidence, for tests and measurements.
//!
//! All have a flat prior on the unit cube. Sources: eggbox, shells: Feroz & Hobson 2008 (MNRAS 384, 449),
//! section 6; loggamma: Beaujean & Caldwell 2013 (arXiv 1304.7808), eq. 32; spike and slab: Skilling
//! 2006 (Bayesian Analysis 1, 833), section 18; the mixtures are ours, with the evidence in closed form.

mod blend;

pub use blend::Blend;

use super::log_add;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

type LogL = Box<dyn Fn(&[f64]) -> f64 + Send + Sync>;

/// A likelihood with known evidence.
pub struct Problem {
    /// What it is called in tables.
    pub name: String,
    /// Dimensions.
    pub n_dim: usize,
    /// Dimensions that tell the modes apart.
    pub mode_dims: Vec<usize>,
    /// ln Z, exact or by quadrature.
    pub log_z: f64,
    /// Number of modes.
    pub n_modes: usize,
    /// Modes whose place and local evidence are known.
    pub modes: Vec<KnownMode>,
    log_l: LogL,
}

/// Where a mode is and what evidence it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownMode {
    /// Its peak in the unit cube.
    pub centre: Vec<f64>,
    /// Its widths.
    pub sigma: Vec<f64>,
    /// Its local ln Z.
    pub log_z: f64,
}

impl Problem {
    fn new(
        name: impl Into<String>,
        n_dim: usize,
        log_z: f64,
        n_modes: usize,
        log_l: impl Fn(&[f64]) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            n_dim,
            mode_dims: (0..n_dim.min(2)).collect(),
            log_z,
            n_modes,
            modes: Vec::new(),
            log_l: Box::new(log_l),
        }
    }

    /// ln L of one point.
    pub fn log_l(&self, u: &[f64]) -> f64 {
        (self.log_l)(u)
    }

    /// ln L of points, axes (point, dimension).
    pub fn log_l_batch(&self, u: &[f64]) -> Vec<f64> {
        u.chunks_exact(self.n_dim).map(&self.log_l).collect()
    }
}

/// (2 + cos(x1/2) cos(x2/2))^5 with x = 10 π u: 18 equal peaks.
pub fn eggbox() -> Problem {
    Problem::new("eggbox", 2, 235.855940, 18, |u| {
        let cos = |x: f64| (5.0 * PI * x).cos();
        (2.0 + cos(u[0]) * cos(u[1])).powi(5)
    })
}

/// Two Gaussian shells of radius 2 and width 0.1 about (±3.5, 0, ..) in [-6, 6]^d; the evidence is
/// known for d = 2, 6, 10, NaN for others.
pub fn shells(n_dim: usize) -> Problem {
    let log_z = match n_dim {
        2 => -1.745642,
        6 => -7.291583,
        10 => -14.590491,
        _ => f64::NAN,
    };
    Problem::new(format!("shells {n_dim}-D"), n_dim, log_z, 2, |u| {
        let rest: f64 = u[1..].iter().map(|x| (12.0 * x - 6.0).powi(2)).sum();
        let shell = |centre: f64| {
            let r = ((12.0 * u[0] - 6.0 - centre).powi(2) + rest).sqrt();
            -(r - 2.0).powi(2) / 0.02 - 0.5 * (TAU * 0.01).ln()
        };
        log_add(shell(-3.5), shell(3.5))
    })
}

/// Rosenbrock's banana in [-5, 5]^2.
pub fn rosenbrock() -> Problem {
    Problem::new("rosenbrock", 2, -5.804132, 1, |u| {
        let (x, y) = (10.0 * u[0] - 5.0, 10.0 * u[1] - 5.0);
        -(100.0 * (y - x * x).powi(2) + (1.0 - x).powi(2))
    })
}

/// Himmelblau's function in [-5, 5]^2: four equal peaks.
pub fn himmelblau() -> Problem {
    Problem::new("himmelblau", 2, -5.503849, 4, |u| {
        let (x, y) = (10.0 * u[0] - 5.0, 10.0 * u[1] - 5.0);
        -(x * x + y - 11.0).powi(2) - (x + y * y - 7.0).powi(2)
    })
}

/// Four modes in the first two dimensions, skewed and Gaussian factors in the others.
pub fn loggamma(n_dim: usize) -> Problem {
    const WIDTH: f64 = 1.0 / 30.0;
    let skewed = |x: f64, at: f64| {
        let y = (x - at) / WIDTH;
        y - y.exp() - WIDTH.ln()
    };
    let normal = |x: f64, at: f64| {
        let y = (x - at) / WIDTH;
        -0.5 * y * y - (WIDTH * TAU.sqrt()).ln()
    };
    let log_z = if n_dim == 2 { -2.27e-5 } else { -2.271e-5 };
    Problem::new(format!("loggamma {n_dim}-D"), n_dim, log_z, 4, move |u| {
        let (low, high) = (1.0 / 3.0, 2.0 / 3.0);
        let first = log_add(skewed(u[0], low), skewed(u[0], high)) - 2f64.ln();
        let second = log_add(normal(u[1], low), normal(u[1], high)) - 2f64.ln();
        let n_skewed = u.len() / 2 + 1;
        let factor = |(i, &x): (usize, &f64)| match i {
            0 | 1 => 0.0,
            i if i < n_skewed => skewed(x, high),
            _ => normal(x, high),
        };
        first + second + u.iter().enumerate().map(factor).sum::<f64>()
    })
}

/// One normalised Gaussian of width 0.05 in the middle, correlation 0.95 between all dimensions.
pub fn correlated_gaussian(n_dim: usize) -> Problem {
    const SIGMA: f64 = 0.05;
    const RHO: f64 = 0.95;
    let d = n_dim as f64;
    // Eigenvalues: 1 - ρ, and 1 + (d-1) ρ along the diagonal.
    let (across, along) = (1.0 - RHO, 1.0 + (d - 1.0) * RHO);
    let log_det = (d - 1.0) * across.ln() + along.ln() + 2.0 * d * SIGMA.ln();
    Problem::new(format!("gaussian {n_dim}-D"), n_dim, 0.0, 1, move |u| {
        let z = || u.iter().map(|x| (x - 0.5) / SIGMA);
        let square: f64 = z().map(|z| z * z).sum();
        let mean2 = z().sum::<f64>().powi(2) / d;
        -0.5 * ((square - mean2) / across + mean2 / along + log_det + d * TAU.ln())
    })
}

/// A narrow Gaussian with 100 times the weight of a wide one around it, in 20 dimensions.
pub fn spike_and_slab() -> Problem {
    Problem::new("spike and slab", 20, 4.615120, 1, |u| {
        let r2: f64 = u.iter().map(|x| (x - 0.5) * (x - 0.5)).sum();
        let normal = |s: f64| -0.5 * r2 / (s * s) - 20.0 * (s * TAU.sqrt()).ln();
        log_add(100f64.ln() + normal(0.01), normal(0.1))
    })
}

/// A sum of Gaussian peaks of given heights, and its evidence.
fn mixture(name: &str, peaks: Vec<(KnownMode, f64)>) -> Problem {
    let modes: Vec<KnownMode> = peaks.iter().map(|(mode, _)| mode.clone()).collect();
    let log_z = modes
        .iter()
        .map(|m| m.log_z)
        .fold(f64::NEG_INFINITY, log_add);
    let mut problem = Problem::new(name, modes[0].centre.len(), log_z, modes.len(), move |u| {
        let peak = |(mode, height): &(KnownMode, f64)| {
            let pairs = u.iter().zip(mode.centre.iter().zip(&mode.sigma));
            height - 0.5 * pairs.map(|(u, (c, s))| ((u - c) / s).powi(2)).sum::<f64>()
        };
        peaks.iter().map(peak).fold(f64::NEG_INFINITY, log_add)
    });
    problem.modes = modes;
    problem
}

/// A Gaussian peak with its evidence: height + Σ ln(σ sqrt(2π) x the part inside the cube).
fn gaussian_peak(centre: Vec<f64>, sigma: Vec<f64>, height: f64) -> (KnownMode, f64) {
    let inside =
        |c: f64, s: f64| 0.5 * (erf((1.0 - c) / s * FRAC_1_SQRT_2) + erf(c / s * FRAC_1_SQRT_2));
    let factors = centre
        .iter()
        .zip(&sigma)
        .map(|(&c, &s)| (s * TAU.sqrt() * inside(c, s)).ln());
    let log_z = height + factors.sum::<f64>();
    (
        KnownMode {
            centre,
            sigma,
            log_z,
        },
        height,
    )
}

/// Twenty places in the plane, at least 0.04 apart.
fn places(rng: &mut ChaCha8Rng) -> Vec<[f64; 2]> {
    let mut places: Vec<[f64; 2]> = Vec::new();
    while places.len() < 20 {
        let [x, y]: [f64; 2] = [
            0.02 + 0.96 * rng.random::<f64>(),
            0.02 + 0.96 * rng.random::<f64>(),
        ];
        if places.iter().all(|p| (p[0] - x).hypot(p[1] - y) >= 0.04) {
            places.push([x, y]);
        }
    }
    places
}

/// Twenty Gaussians in 6-D: very narrow in two dimensions, ln-heights spread evenly over 0 to 6.
pub fn mix20(seed: u64) -> Problem {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let places = places(&mut rng);
    let peaks = places.into_iter().enumerate().map(|(k, [x, y])| {
        let mut centre = vec![x, y];
        let mut sigma = vec![1e-3; 2];
        for _ in 0..4 {
            centre.push(0.3 + 0.4 * rng.random::<f64>());
            sigma.push(0.035 + 0.03 * rng.random::<f64>());
        }
        gaussian_peak(centre, sigma, 6.0 * k as f64 / 19.0)
    });
    mixture("mix20", peaks.collect())
}

/// The likeness of a field with 20 sources of signal-to-noise ratio 5 to 15 on a floor that
/// prefers no flux: widths 0.01/SNR in place, 0.05 in flux (mean 0.05 SNR), 0.5/SNR in three shapes, height
/// SNR²/2. The floor's evidence is in `log_z`, but it is no mode.
pub fn gal20(seed: u64) -> Problem {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let places = places(&mut rng);
    let peaks = places.into_iter().enumerate().map(|(k, [x, y])| {
        let snr = 5.0 * 3f64.powf(k as f64 / 19.0);
        let mut centre = vec![x, y, 0.05 * snr];
        let mut sigma = vec![0.01 / snr, 0.01 / snr, 0.05];
        for _ in 0..3 {
            centre.push(0.3 + 0.4 * rng.random::<f64>());
            sigma.push(0.5 / snr);
        }
        gaussian_peak(centre, sigma, 0.5 * snr * snr)
    });
    let mut problem = mixture("gal20", peaks.collect());
    let peaks = problem.log_l;
    problem.log_l = Box::new(move |u| log_add(peaks(u), -0.5 * (u[2] / 0.05).powi(2)));
    problem.log_z = log_add(problem.log_z, (0.5 * 0.05 * TAU.sqrt()).ln());
    problem
}

/// erf x = 2/sqrt(π) exp(-x²) Σ 2^n x^(2n+1) / (1 3 .. (2n+1)) (Abramowitz & Stegun 7.1.6).
fn erf(x: f64) -> f64 {
    if x.abs() > 6.0 {
        return x.signum();
    }
    let mut term = x;
    let mut sum = x;
    for n in 1..200 {
        term *= 2.0 * x * x / (2 * n + 1) as f64;
        sum += term;
    }
    2.0 / PI.sqrt() * (-x * x).exp() * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ln Z in 2-D by the midpoint rule.
    fn quadrature(problem: &Problem, n: usize) -> f64 {
        let at = |i: usize| (i as f64 + 0.5) / n as f64;
        let rows = (0..n).map(|i| {
            let row = (0..n).map(|j| problem.log_l(&[at(i), at(j)]));
            row.fold(f64::NEG_INFINITY, log_add)
        });
        rows.fold(f64::NEG_INFINITY, log_add) - 2.0 * (n as f64).ln()
    }

    #[test]
    fn evidences_in_two_dimensions_agree_with_quadrature() {
        for problem in [
            eggbox(),
            shells(2),
            rosenbrock(),
            himmelblau(),
            loggamma(2),
            correlated_gaussian(2),
        ] {
            let log_z = quadrature(&problem, 1000);
            assert!(
                (log_z - problem.log_z).abs() < 2e-4,
                "{}: {log_z}",
                problem.name
            );
        }
    }

    #[test]
    fn erf_has_its_tabulated_values() {
        for (x, y) in [
            (0.5, 0.5204998778),
            (1.0, 0.8427007929),
            (2.5, 0.9995930480),
            (-3.0, -0.9999779095),
        ] {
            assert!((erf(x) - y).abs() < 1e-9);
        }
    }

    #[test]
    fn peaks_of_the_mixtures_stand_where_they_say() {
        for problem in [mix20(1), gal20(1)] {
            for (k, mode) in problem.modes.iter().enumerate() {
                let mut beside = mode.centre.clone();
                beside[0] += mode.sigma[0];
                let drop = problem.log_l(&mode.centre) - problem.log_l(&beside);
                assert!((drop - 0.5).abs() < 0.01, "{} {k}: {drop}", problem.name);
            }
        }
    }
}
