//! Posteriors whose moments are known.

use super::super::problems::correlated_gaussian;
use super::*;
use nalgebra::DMatrix;

fn config(n_dim: usize, seed: u64) -> PopulationConfig {
    PopulationConfig {
        n_dim,
        n_draw: 4000,
        least_ess: 400.0,
        seed,
    }
}

fn sampled(config: PopulationConfig, seeds: &[f64], log_l: impl Fn(&[f64]) -> f64) -> Draws {
    let mut sampler = Population::new(config, seeds);
    loop {
        let u = sampler.ask();
        if u.is_empty() {
            return Box::new(sampler).finish();
        }
        let log_l: Vec<f64> = u.chunks_exact(config.n_dim).map(&log_l).collect();
        sampler.tell(&log_l).unwrap();
    }
}

/// Independent seeds of width about `sigma` around the middle of the cube.
fn seeds(n_dim: usize, sigma: f64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(99);
    let unit = Student::new(DVector::zeros(n_dim), DMatrix::identity(n_dim, n_dim)).unwrap();
    let point = |_| unit.draw(&mut rng).0;
    let points = (0..500).map(point);
    points
        .flat_map(|z| z.iter().map(|z| 0.5 + sigma * z).collect::<Vec<_>>())
        .collect()
}

fn mean_and_covariance(draws: &Draws, n_dim: usize) -> (DVector<f64>, DMatrix<f64>) {
    let points: Vec<_> = draws
        .u
        .chunks(n_dim)
        .map(DVector::from_column_slice)
        .collect();
    moments(&points, &draws.weight)
}

/// Seeds that know nothing of the correlation: conditional posteriors, four times narrower.
#[test]
fn a_correlated_gaussian_has_its_moments_and_its_evidence() {
    let problem = correlated_gaussian(12);
    for seed in 0..5 {
        let draws = sampled(config(12, seed), &seeds(12, 0.0125), |u| problem.log_l(u));
        assert!(draws.is_converged, "{draws:?}");
        assert!(
            draws.log_z.unwrap().abs() < 4.0 / draws.ess.sqrt(),
            "{:?}",
            draws.log_z
        );
        let (mean, covariance) = mean_and_covariance(&draws, 12);
        // Monte-Carlo errors of a mean and of a covariance, times five.
        let five = 5.0 / draws.ess.sqrt();
        for i in 0..12 {
            assert!((mean[i] - 0.5).abs() < five * 0.05);
            for j in 0..12 {
                let rho: f64 = if i == j { 1.0 } else { 0.95 };
                let error = covariance[(i, j)] / 0.0025 - rho;
                assert!(
                    error.abs() < five * (1.0 + rho * rho).sqrt(),
                    "{i} {j}: {error}"
                );
            }
        }
    }
}

/// Flat in half of the dimensions, piled up at a face in one: mean and spread in closed form.
#[test]
fn what_the_data_do_not_tell_is_the_prior() {
    let log_l = |u: &[f64]| -20.0 * u[0] - 0.5 * ((u[1] - 0.7) / 0.01).powi(2);
    let draws = sampled(config(4, 1), &seeds(4, 0.1), log_l);
    assert!(draws.is_converged, "{draws:?}");
    let (mean, covariance) = mean_and_covariance(&draws, 4);
    let close = |i: usize, wanted: f64, sigma: f64| {
        let spread = covariance[(i, i)].sqrt();
        assert!(
            (mean[i] - wanted).abs() < 5.0 * sigma / draws.ess.sqrt(),
            "{i}: {}",
            mean[i]
        );
        assert!((spread / sigma - 1.0).abs() < 0.1, "{i}: {spread}");
    };
    close(0, 0.05, 0.05);
    close(1, 0.7, 0.01);
    close(2, 0.5, 12f64.powf(-0.5));
    close(3, 0.5, 12f64.powf(-0.5));
}

#[test]
fn a_posterior_of_two_pieces_far_from_the_seeds_is_not_passed_off_as_known() {
    let peak =
        |u: &[f64], at: f64| -0.5 * u.iter().map(|u| ((u - at) / 0.003).powi(2)).sum::<f64>();
    let log_l = |u: &[f64]| peak(u, 0.2).max(peak(u, 0.8));
    let draws = sampled(config(12, 2), &seeds(12, 0.002), log_l);
    assert!(!draws.is_converged, "{draws:?}");
}

#[test]
fn the_same_seed_gives_the_same_draws() {
    let problem = correlated_gaussian(6);
    let run = |seed| sampled(config(6, seed), &seeds(6, 0.03), |u| problem.log_l(u));
    assert_eq!(run(7), run(7));
    assert_ne!(run(7).u, run(8).u);
}

#[test]
fn a_single_seed_gives_no_draws() {
    let draws = sampled(config(2, 1), &[0.5; 2], |_| 0.0);
    assert!(draws.u.is_empty() && !draws.is_converged);
}

#[test]
fn a_likelihood_that_is_no_number_is_an_error() {
    let mut sampler = Population::new(config(2, 1), &seeds(2, 0.1));
    let n = sampler.ask().len() / 2;
    assert!(sampler.tell(&vec![f64::NAN; n]).is_err());
    assert!(sampler.tell(&[0.0]).is_err());
}
