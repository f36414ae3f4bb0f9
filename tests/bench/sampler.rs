//! Evidence, modes, likelihood calls and overhead of the sampler on problems with known answers.
//!
//! `cargo bench --bench sampler [-- NAME [N_LIVE [N_SEEDS]]]` prints a table: d = ln Z - exact (mean and
//! scatter over seeds), the quoted error, the modes found, the calls, and the time per accepted point.
#![allow(clippy::print_stdout, missing_docs)]

use std::ops::ControlFlow;
use std::time::{Duration, Instant};
use vis2cat::sampler::problems::{self, Problem};
use vis2cat::sampler::{MultiNest, MultiNestConfig, NestedRun, RunError, run};

/// What one run gave.
struct Outcome {
    d: f64,
    err: f64,
    found: usize,
    spurious: usize,
    /// rms of (local ln Z - exact) / error over the modes found.
    local_pull: f64,
    /// Mean of local ln Z - exact.
    local_d: f64,
    n_eval: u64,
    overhead_us: f64,
}

/// Modes of the run at each known place: indices into `modes()`.
fn found(problem: &Problem, result: &NestedRun) -> (usize, usize, f64, f64) {
    let modes = result.modes();
    if problem.modes.is_empty() {
        return (modes.len(), 0, f64::NAN, f64::NAN);
    }
    let mut claimed = vec![false; modes.len()];
    let (mut n_found, mut pulls, mut ds) = (0, 0.0, 0.0);
    for known in &problem.modes {
        let at = |u: &[f64]| {
            problem
                .mode_dims
                .iter()
                .all(|&i| (u[i] - known.centre[i]).abs() < 4.0 * known.sigma[i])
        };
        let here = (0..modes.len()).filter(|&m| at(&modes[m].mean));
        let best = here.max_by(|&a, &b| modes[a].log_z.total_cmp(&modes[b].log_z));
        if let Some(m) = best {
            claimed[m] = true;
            n_found += 1;
            let d = modes[m].log_z - known.log_z;
            pulls += (d / modes[m].log_z_err).powi(2);
            ds += d;
        }
    }
    let n = n_found as f64;
    let spurious = claimed.iter().filter(|c| !**c).count();
    (n_found, spurious, (pulls / n).sqrt(), ds / n)
}

fn measure(problem: &Problem, n_live: usize, seed: u64) -> Option<Outcome> {
    let config = MultiNestConfig {
        mode_dims: problem.mode_dims.clone(),
        seed,
        max_eval: Some(20_000_000),
        ..MultiNestConfig::new(problem.n_dim, n_live)
    };
    let mut in_likelihood = Duration::ZERO;
    let log_l = |u: &[f64]| -> Result<Vec<f64>, std::convert::Infallible> {
        let start = Instant::now();
        let log_l = problem.log_l_batch(u);
        in_likelihood += start.elapsed();
        Ok(log_l)
    };
    let start = Instant::now();
    let sampler = Box::new(MultiNest::new(config).ok()?);
    let result = match run(sampler, log_l, |_| ControlFlow::Continue(())) {
        Ok(result) => result,
        Err(RunError::Sampler(error)) => {
            println!("  {} {n_live} seed {seed}: {error}", problem.name);
            return None;
        }
        Err(RunError::Likelihood(never)) => match never {},
    };
    let overhead = start.elapsed().saturating_sub(in_likelihood);
    let evidence = result.evidence();
    let (found, spurious, local_pull, local_d) = found(problem, &result);
    Some(Outcome {
        d: evidence.log_z - problem.log_z,
        err: evidence.log_z_err,
        found,
        spurious,
        local_pull,
        local_d,
        n_eval: result.n_eval,
        overhead_us: overhead.as_secs_f64() * 1e6 / result.dead.len() as f64,
    })
}

/// What MultiNest (efficiency 0.3) scored on the same problem: d of several seeds, its quoted error, calls.
fn multinest(name: &str, n_live: usize) -> &'static str {
    match (name, n_live) {
        ("eggbox", 400) => "0.05, 0.25, -0.19 (0.12), 10 500",
        ("shells 2-D", 400) => "-0.08, -0.05, -0.21 (0.08), 5 800",
        ("shells 6-D", 400) => "-0.23, 0.25, 0.18, 0.08, 0.01 (0.14), 13 200",
        ("shells 6-D", 2000) => "0.09, -0.02, -0.04 (0.06), 62 000",
        ("mix20", 400) => "0.8, 2.2, 1.6, 1.4, 1.4 (0.19), 48 000",
        ("mix20", 2000) => "0.04, 0.48, 0.61 (0.09), 130 000; local 4-5 errors off",
        ("mix20", 8000) => "0.18, 0.22 (0.04), 460 000",
        ("gal20", 400) => "-93 in 4 of 5, -74 (0.07): none found",
        ("gal20", 2000) => "-93, -13, -49 (0.1), to 3.6 million; 0, 9, 8 found",
        ("gal20", 8000) => "more than 1800 s",
        _ => "",
    }
}

fn row(problem: &Problem, n_live: usize, n_seeds: u64) {
    let outcomes: Vec<Outcome> = (1..=n_seeds)
        .filter_map(|seed| measure(problem, n_live, seed))
        .collect();
    let n = outcomes.len() as f64;
    let mean = |f: &dyn Fn(&Outcome) -> f64| outcomes.iter().map(f).sum::<f64>() / n;
    let d = mean(&|o| o.d);
    let scatter = mean(&|o| (o.d - d).powi(2)).sqrt();
    let worst = outcomes
        .iter()
        .map(|o| (o.d / o.err).abs())
        .fold(0.0, f64::max);
    println!(
        "| {:<14} | {n_live:>5} | {:>2} | {d:>7.3} | {scatter:.3} | {:.3} | {worst:>5.1} | {:>5.1}/{} | {:>4.1} | {:>6.2} | {:>6.2} | {:>9.0} | {:>6.1} | {} |",
        problem.name,
        outcomes.len(),
        mean(&|o| o.err),
        mean(&|o| o.found as f64),
        problem.n_modes,
        mean(&|o| o.spurious as f64),
        mean(&|o| o.local_d),
        mean(&|o| o.local_pull),
        mean(&|o| o.n_eval as f64),
        mean(&|o| o.overhead_us),
        multinest(&problem.name, n_live),
    );
}

fn main() {
    if !std::env::args().any(|a| a == "--bench") {
        println!("measures for minutes: run it with `cargo bench`");
        return;
    }
    let args: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let name = args.first().map_or("", String::as_str);
    let n_live: Option<usize> = args.get(1).and_then(|a| a.parse().ok());
    let n_seeds: Option<u64> = args.get(2).and_then(|a| a.parse().ok());
    let table: Vec<(Problem, Vec<usize>, u64)> = vec![
        (problems::eggbox(), vec![400, 2000], 10),
        (problems::shells(2), vec![400, 2000], 10),
        (problems::shells(6), vec![400, 2000], 10),
        (problems::shells(10), vec![400], 5),
        (problems::rosenbrock(), vec![400], 10),
        (problems::himmelblau(), vec![400], 10),
        (problems::loggamma(2), vec![400], 10),
        (problems::loggamma(10), vec![400], 5),
        (problems::correlated_gaussian(6), vec![400, 2000], 10),
        (problems::mix20(1), vec![400, 2000, 8000], 10),
        (problems::gal20(1), vec![400, 2000, 8000], 4),
    ];
    println!(
        "| problem | n_live | runs | mean d | scatter | quoted | worst pull | found | spurious | local d | local pull | calls | us/point | MultiNest: d (quoted), calls |"
    );
    for (problem, n_lives, seeds) in table {
        if problem.name.starts_with(name) {
            for n in n_lives
                .into_iter()
                .filter(|n| n_live.is_none_or(|only| only == *n))
            {
                row(&problem, n, n_seeds.unwrap_or(seeds));
            }
        }
    }
}
