//! The samplers on problems with known answers.
//!
//! | `cargo bench --bench sampler -- ..` | prints |
//! |---|---|
//! | `study [NAME [N_LIVE [N_SEEDS [SAMPLER]]]]` | evidences, modes, calls of both samplers over 30 seeds |
//! | `overhead [SAMPLER]` | time for all but the likelihood, a dead point, in 6-D |
//! | `parallel` | efficiency of two threads where a likelihood takes 20 us |
#![allow(clippy::print_stdout, missing_docs)]

use rayon::prelude::*;
use std::convert::Infallible;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};
use vis2cat::sampler::problems::{self, Problem};
use vis2cat::sampler::{
    MultiNest, MultiNestConfig, NestedRun, RunError, Sampler, SamplerError, Slice, SliceConfig, run,
};

/// No run of the study takes more.
const MAX_EVAL: u64 = 10_000_000;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    MultiNest,
    Slice,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::MultiNest => "multinest",
            Self::Slice => "slice",
        }
    }

    fn sampler(self, problem: &Problem, n_live: usize, seed: u64) -> Box<dyn Sampler> {
        let mode_dims = problem.mode_dims.clone();
        let max_eval = Some(MAX_EVAL);
        let tolerance = tolerance(problem);
        let sampler: Result<Box<dyn Sampler>, SamplerError> = match self {
            Self::MultiNest => MultiNest::new(MultiNestConfig {
                mode_dims,
                seed,
                max_eval,
                tolerance,
                ..MultiNestConfig::new(problem.n_dim, n_live)
            })
            .map(|s| Box::new(s) as _),
            Self::Slice => Slice::new(SliceConfig {
                mode_dims,
                seed,
                max_eval,
                tolerance,
                n_repeats: repeats(problem.n_dim),
                ..SliceConfig::new(problem.n_dim, n_live)
            })
            .map(|s| Box::new(s) as _),
        };
        sampler.expect("options that make sense")
    }
}

/// The default, but where a spike of 100 times the evidence hides in 1e-13 of the mass of what is seen
/// around it: no sampler knows of it that stops before.
fn tolerance(problem: &Problem) -> f64 {
    if problem.name.starts_with("spike") {
        1e-14
    } else {
        0.5
    }
}

/// Slices a point: the default, or `REPEATS` times the dimensions.
fn repeats(n_dim: usize) -> usize {
    let per_dim = std::env::var("REPEATS").ok().and_then(|r| r.parse().ok());
    per_dim.map_or(SliceConfig::new(n_dim, 4).n_repeats, |r: usize| r * n_dim)
}

/// What one run gave.
struct Outcome {
    d: f64,
    err: f64,
    bootstrap: f64,
    p_insertion: f64,
    found: usize,
    spurious: usize,
    /// (local ln Z - exact, error) of the modes found.
    local: Vec<(f64, f64)>,
    n_eval: u64,
}

/// Known modes that were found, modes of the run that are none, local ln Z - exact with its error.
fn found(problem: &Problem, result: &NestedRun) -> (usize, usize, Vec<(f64, f64)>) {
    let modes = result.modes();
    if problem.modes.is_empty() {
        let n = modes.len().min(problem.n_modes);
        return (n, modes.len() - n, Vec::new());
    }
    let mut claimed = vec![false; modes.len()];
    let mut local = Vec::new();
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
            local.push((modes[m].log_z - known.log_z, modes[m].log_z_err));
        }
    }
    let spurious = claimed.iter().filter(|c| !**c).count();
    (local.len(), spurious, local)
}

fn solve(
    sampler: Box<dyn Sampler>,
    log_l: impl FnMut(&[f64]) -> Vec<f64>,
) -> Result<NestedRun, SamplerError> {
    let mut log_l = log_l;
    let log_l = |u: &[f64]| Ok::<_, Infallible>(log_l(u));
    match run(sampler, log_l, |_| ControlFlow::Continue(())) {
        Ok(result) => Ok(result),
        Err(RunError::Sampler(error)) => Err(error),
        Err(RunError::Likelihood(never)) => match never {},
    }
}

fn measure(kind: Kind, problem: &Problem, n_live: usize, seed: u64) -> Option<Outcome> {
    let sampler = kind.sampler(problem, n_live, seed);
    let result = match solve(sampler, |u| problem.log_l_batch(u)) {
        Ok(result) => result,
        Err(error) => {
            println!("  {} {n_live} seed {seed}: {error}", problem.name);
            return None;
        }
    };
    let evidence = result.evidence();
    let (found, spurious, local) = found(problem, &result);
    Some(Outcome {
        d: evidence.log_z - problem.log_z,
        err: evidence.log_z_err,
        bootstrap: result.log_z_err_bootstrap(50),
        p_insertion: result.insertion_test().p_value,
        found,
        spurious,
        local,
        n_eval: result.n_eval,
    })
}

/// What others scored on the same problem: d of several seeds (quoted error), calls.
fn peers(kind: Kind, name: &str, n_live: usize) -> &'static str {
    match (kind, name, n_live) {
        (Kind::MultiNest, "eggbox", 400) => "MultiNest 0.05, 0.25, -0.19 (0.12), 10 500",
        (Kind::MultiNest, "shells 2-D", 400) => "MultiNest -0.08, -0.05, -0.21 (0.08), 5 800",
        (Kind::MultiNest, "shells 6-D", 400) => {
            "MultiNest -0.23, 0.25, 0.18, 0.08, 0.01 (0.14), 13 200"
        }
        (Kind::MultiNest, "mix20", 400) => "MultiNest 0.8, 2.2, 1.6, 1.4, 1.4 (0.19), 48 000",
        (Kind::MultiNest, "mix20", 2000) => {
            "MultiNest 0.04, 0.48, 0.61 (0.09), 130 000; local pull 4 to 5"
        }
        (Kind::Slice, "eggbox", 400) => "PolyChord 0.09, 0.75 (0.13), 142 000",
        (Kind::Slice, "shells 2-D", 400) => "PolyChord 0.10, -0.02 (0.08), 85 000",
        (Kind::Slice, "shells 6-D", 400) => {
            "PolyChord -0.03, -0.15 (0.14), 493 000; dynesty 0.01, -0.04 (0.25), 24 000"
        }
        (Kind::Slice, "mix20", 400) => {
            "PolyChord -0.26 (0.24), 1 343 000; dynesty rslice -0.22 (0.32), 328 000"
        }
        _ => "",
    }
}

fn row(kind: Kind, problem: &Problem, n_live: usize, n_seeds: u64) {
    let outcomes: Vec<Outcome> = (1..=n_seeds)
        .into_par_iter()
        .filter_map(|seed| measure(kind, problem, n_live, seed))
        .collect();
    let n = outcomes.len() as f64;
    let mean = |f: &dyn Fn(&Outcome) -> f64| outcomes.iter().map(f).sum::<f64>() / n;
    let share = |f: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|o| f(o)).count();
    let d = mean(&|o| o.d);
    let scatter = (mean(&|o| (o.d - d).powi(2)) * n / (n - 1.0)).sqrt();
    let quoted = mean(&|o| o.err);
    let local: Vec<f64> = outcomes
        .iter()
        .flat_map(|o| &o.local)
        .map(|l| l.0 / l.1)
        .collect();
    let rms = (local.iter().map(|p| p * p).sum::<f64>() / local.len() as f64).sqrt();
    let local_good = share(&|o| {
        o.local.len() == problem.modes.len() && o.local.iter().all(|l| l.0.abs() < 3.0 * l.1)
    });
    let local = if local.is_empty() {
        "| ".to_string()
    } else {
        format!("{rms:.2} | {local_good}")
    };
    println!(
        "| {} | {n_live} | {} | {}/{n} | {d:.3} | {scatter:.3} | {quoted:.3} | {:.2} | {:.2} | {:.1}/{} | {:.1} | {local} | {} | {:.0} | {} |",
        problem.name,
        kind.name(),
        share(&|o| o.d.abs() < 3.0 * o.err),
        quoted / scatter,
        mean(&|o| o.bootstrap) / scatter,
        mean(&|o| o.found as f64),
        problem.n_modes,
        mean(&|o| o.spurious as f64),
        share(&|o| o.p_insertion < 0.01),
        mean(&|o| o.n_eval as f64),
        peers(kind, &problem.name, n_live),
    );
}

fn study(args: &[String]) {
    let name = args.first().map_or("", String::as_str);
    let only_n_live: Option<usize> = args.get(1).and_then(|a| a.parse().ok());
    let n_seeds = args.get(2).and_then(|a| a.parse().ok()).unwrap_or(30);
    let only_kind = args.get(3).map(String::as_str);
    println!(
        "| problem | N_live | sampler | within 3 errors | mean d | scatter | quoted | quoted/scatter | bootstrap/scatter | modes | spurious | local pull | all local within 3 | insertion p < 0.01 | calls | others: d (quoted), calls |"
    );
    println!("|{}", "---|".repeat(16));
    for (problem, n_lives) in [
        (problems::eggbox(), vec![400]),
        (problems::shells(2), vec![400]),
        (problems::shells(6), vec![400]),
        (problems::rosenbrock(), vec![400]),
        (problems::himmelblau(), vec![400]),
        (problems::loggamma(2), vec![400]),
        (problems::loggamma(10), vec![400]),
        (problems::correlated_gaussian(6), vec![400]),
        (problems::correlated_gaussian(20), vec![400]),
        (problems::spike_and_slab(), vec![400]),
        (problems::mix20(1), vec![400, 2000]),
    ] {
        for n_live in n_lives {
            for kind in [Kind::MultiNest, Kind::Slice] {
                if problem.name.starts_with(name)
                    && only_n_live.is_none_or(|only| only == n_live)
                    && only_kind.is_none_or(|only| only == kind.name())
                {
                    row(kind, &problem, n_live, n_seeds);
                }
            }
        }
    }
}

/// Time for all but the likelihood, without what is done once the run is finished.
fn overhead(args: &[String]) {
    let only_kind = args.first().map(String::as_str);
    println!("| problem | N_live | sampler | dead points | calls | us a dead point | us a call |");
    println!("|---|---|---|---|---|---|---|");
    for problem in [
        problems::correlated_gaussian(6),
        problems::shells(6),
        problems::mix20(1),
    ] {
        let kinds = [Kind::MultiNest, Kind::Slice].into_iter();
        for kind in kinds.filter(|kind| only_kind.is_none_or(|only| only == kind.name())) {
            let mut in_likelihood = Duration::ZERO;
            let start = Instant::now();
            let result = solve(kind.sampler(&problem, 2000, 1), |u| {
                let start = Instant::now();
                let log_l = problem.log_l_batch(u);
                in_likelihood += start.elapsed();
                log_l
            });
            let us = (start.elapsed().saturating_sub(in_likelihood)).as_secs_f64() * 1e6;
            if let Ok(result) = result {
                println!(
                    "| {} | 2000 | {} | {} | {} | {:.1} | {:.2} |",
                    problem.name,
                    kind.name(),
                    result.dead.len(),
                    result.n_eval,
                    us / result.dead.len() as f64,
                    us / result.n_eval as f64
                );
            }
        }
    }
}

/// The same run on one thread and on two.
fn parallel() {
    let slow = |problem: &Problem, u: &[f64]| {
        let start = Instant::now();
        let log_l = problem.log_l(u);
        while start.elapsed() < Duration::from_micros(20) {
            std::hint::spin_loop();
        }
        log_l
    };
    println!("| problem | N_live | sampler | 1 thread [s] | 2 threads [s] | efficiency |");
    println!("|---|---|---|---|---|---|");
    let problems = [problems::correlated_gaussian(6), problems::shells(6)];
    let kinds = [Kind::MultiNest, Kind::Slice];
    for (problem, kind) in problems.iter().flat_map(|p| kinds.map(|kind| (p, kind))) {
        let time = |n_threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(n_threads)
                .build()
                .expect("threads");
            let start = Instant::now();
            let result = pool.install(|| {
                solve(kind.sampler(problem, 2000, 1), |u| {
                    u.par_chunks(6).map(|u| slow(problem, u)).collect()
                })
            });
            assert!(result.is_ok());
            start.elapsed().as_secs_f64()
        };
        let (one, two) = (time(1), time(2));
        println!(
            "| {} | 2000 | {} | {one:.2} | {two:.2} | {:.0}% |",
            problem.name,
            kind.name(),
            50.0 * one / two
        );
    }
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
    match args.first().map(String::as_str) {
        Some("overhead") => overhead(&args[1..]),
        Some("parallel") => parallel(),
        Some("study") => study(&args[1..]),
        _ => study(&args),
    }
}
