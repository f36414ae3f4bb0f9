//! Cost of the exact likelihood: ns per visibility and point on one core, for every instruction
//! set, and the ratio to a plain scalar f64 loop compiled with the same flags.
//!
//! Run: `cargo bench --bench likelihood`
#![allow(clippy::print_stdout)] // a benchmark prints

use std::hint::black_box;
use std::time::Instant;
use vis2cat::coords::Lm;
use vis2cat::likelihood::kernel::accumulate;
use vis2cat::likelihood::{Isa, SourceTerm, VisBlock, Xy, plain_xy, xy_batch};
use vis2cat::rime::Source;
use vis2cat::rime::shape::{Ellipticity, Profile};
use vis2cat::units::ARCSEC;

const SAMPLES: usize = 32_768;
const SOURCES: usize = 256;
const REPEATS: usize = 40;

/// A number in [0, 1) that looks random: the fractional part of i times an irrational.
fn spread(i: usize, irrational: f64) -> f64 {
    (i as f64 * irrational).fract()
}

/// Noise on baselines up to 750 000 wavelengths.
fn block(samples: usize) -> VisBlock {
    let axis = |irrational: f64, reach: f64| {
        (0..samples)
            .map(|i| reach * (2.0 * spread(i, irrational) - 1.0))
            .collect()
    };
    let single = |irrational: f64| {
        (0..samples)
            .map(|i| (540.0 * (2.0 * spread(i, irrational) - 1.0)) as f32)
            .collect()
    };
    VisBlock {
        u: axis(2f64.sqrt(), 7.5e5),
        v: axis(3f64.sqrt(), 7.5e5),
        w: axis(5f64.sqrt(), 3e5),
        weighted_re: single(7f64.sqrt()),
        weighted_im: single(11f64.sqrt()),
        weight: vec![2.9e5; samples],
    }
}

/// Sources all over the field and the prior.
fn sources(count: usize) -> Vec<Source> {
    (0..count)
        .map(|i| Source {
            lm: Lm {
                l: 0.0175 * (2.0 * spread(i, 13f64.sqrt()) - 1.0),
                m: 0.0175 * (2.0 * spread(i, 17f64.sqrt()) - 1.0),
            },
            flux_jy: 1e-4,
            scale_rad: ARCSEC * (0.1 + 3.0 * spread(i, 19f64.sqrt())),
            e: Ellipticity {
                e1: 0.5 * (2.0 * spread(i, 23f64.sqrt()) - 1.0),
                e2: 0.5 * (2.0 * spread(i, 29f64.sqrt()) - 1.0),
            },
        })
        .collect()
}

/// Shortest of `repeats` runs [s].
fn best_s(repeats: usize, mut run: impl FnMut()) -> f64 {
    (0..repeats)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

/// ns per visibility and point of a kernel.
fn kernel_ns(isa: Isa, profile: Profile, block: &VisBlock, sources: &[Source]) -> f64 {
    let terms: Vec<_> = sources
        .iter()
        .map(|s| SourceTerm::new(s, profile))
        .collect();
    let mut out = vec![Xy::default(); terms.len()];
    let seconds = best_s(REPEATS, || {
        accumulate(isa, black_box(block), &terms, &mut out);
    });
    black_box(out);
    1e9 * seconds / (block.len() * sources.len()) as f64
}

/// ns per visibility and point of the plain loop.
fn plain_ns(profile: Profile, block: &VisBlock, sources: &[Source]) -> f64 {
    let seconds = best_s(REPEATS / 4, || {
        for source in sources {
            black_box(plain_xy(black_box(block), source, profile));
        }
    });
    1e9 * seconds / (block.len() * sources.len()) as f64
}

/// The processor's name, where the system tells.
fn processor() -> String {
    std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split(':').nth(1)?.trim().to_owned())
        })
        .unwrap_or_else(|| "unknown processor".to_owned())
}

fn main() {
    let block = block(SAMPLES);
    let sources = sources(SOURCES);
    println!("{}, detected {:?}", processor(), Isa::detect());
    println!("{SAMPLES} visibilities x {SOURCES} points, one core, best of {REPEATS}");
    println!("profile      kernel      ns/(vis point)   ratio to plain");
    for profile in [Profile::Exponential, Profile::Gaussian, Profile::Point] {
        let plain = plain_ns(profile, &block, &sources[..8]);
        println!(
            "{:<12} {:<10} {plain:>10.3}        1.0",
            format!("{profile:?}"),
            "plain f64"
        );
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            let ns = kernel_ns(isa, profile, &block, &sources);
            println!(
                "{:<12} {:<10} {ns:>10.3}  {:>9.1}",
                "",
                format!("{isa:?}"),
                plain / ns
            );
        }
    }
    println!("batch size, exponential, detected kernel: ns/(vis point)");
    for batch in [1, 4, 16, 64, 256] {
        let ns = kernel_ns(
            Isa::detect(),
            Profile::Exponential,
            &block,
            &sources[..batch],
        );
        println!("{batch:>6} {ns:>8.3}");
    }
    all_cores(&block, &sources);
}

/// Prints the cost on all threads of the pool together.
fn all_cores(block: &VisBlock, sources: &[Source]) {
    let blocks = vec![block.clone(); 8];
    let seconds = best_s(5, || {
        black_box(xy_batch(black_box(&blocks), sources, Profile::Exponential));
    });
    let points = (8 * block.len() * sources.len()) as f64;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!(
        "{threads} threads together: {:.3} ns/(vis point)",
        1e9 * seconds / points
    );
}
