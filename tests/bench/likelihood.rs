//! Cost of the exact likelihood: ns per visibility and point on one core, for every instruction
//! set, and the ratio to a plain scalar f64 loop compiled with the same flags.
//!
//! Run: `cargo bench --bench likelihood`
#![allow(clippy::print_stdout)] // a benchmark prints

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;
use vis2cat::coords::Lm;
use vis2cat::likelihood::kernel::accumulate;
use vis2cat::likelihood::{Extents, Isa, SourceTerm, VisBlock, Xy, plain_xy, subtract, xy_batch};
use vis2cat::rime::shape::{Ellipticity, Profile};
use vis2cat::rime::{Extent, Instrument, InstrumentTerms, Source};
use vis2cat::units::ARCSEC;

const SAMPLES: usize = 16_384;
const SOURCES: usize = 256;
const REPEATS: usize = 20;

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
        ..VisBlock::default()
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
            tilt: 0.0,
        })
        .collect()
}

/// Time `run` takes [s].
fn time_s(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

/// Shortest of `REPEATS` runs [s].
fn best_s(mut run: impl FnMut()) -> f64 {
    (0..REPEATS)
        .map(|_| time_s(&mut run))
        .fold(f64::INFINITY, f64::min)
}

fn terms(sources: &[Source], profile: Profile) -> Vec<SourceTerm> {
    let term = |source| SourceTerm::new(source, profile);
    sources.iter().map(term).collect()
}

/// Time of one pass of a kernel [s].
fn kernel_s(isa: Isa, block: &VisBlock, terms: &[SourceTerm]) -> f64 {
    let mut out = vec![Xy::default(); terms.len()];
    let seconds = time_s(|| accumulate(isa, black_box(block), terms, &mut out));
    black_box(out);
    seconds
}

/// Prints the cost of the plain loop and of every kernel, measured in turns so that a busy
/// machine slows all of them alike.
fn kernels(profile: Profile, block: &VisBlock, sources: &[Source]) {
    let isas: Vec<Isa> = Isa::ALL
        .into_iter()
        .filter(|isa| isa.is_available())
        .collect();
    let terms = terms(sources, profile);
    let few = &sources[..8];
    let (mut plain, mut best) = (f64::INFINITY, vec![f64::INFINITY; isas.len()]);
    for _ in 0..REPEATS {
        plain = plain.min(time_s(|| {
            for source in few {
                black_box(plain_xy(black_box(block), source, profile));
            }
        }));
        for (best, &isa) in best.iter_mut().zip(&isas) {
            *best = best.min(kernel_s(isa, block, &terms));
        }
    }
    let plain = 1e9 * plain / (block.len() * few.len()) as f64;
    println!(
        "{:<12} plain f64  {plain:>10.3}        1.0",
        format!("{profile:?}")
    );
    for (isa, best) in isas.iter().zip(best) {
        let ns = 1e9 * best / (block.len() * sources.len()) as f64;
        println!(
            "{:<12} {:<10} {ns:>10.3}  {:>9.1}",
            "",
            format!("{isa:?}"),
            plain / ns
        );
    }
}

/// The same samples as an instrument with all its terms sees them, over an octave.
fn seen(mut block: VisBlock) -> VisBlock {
    let terms = InstrumentTerms {
        smearing: true,
        beam: "meerkat".parse().ok(),
        spectral_index: "-0.7".parse().ok(),
    };
    let instrument = Instrument::new(&terms, [0.856e9, 1.712e9], [0.0, 0.75f64.sqrt(), -0.5]);
    block.extents = Extents::of(instrument.map(Arc::new));
    for k in 0..block.len() {
        block.extents.push(Extent {
            freq_hz: 0.856e9 * (1.0 + (k % 64) as f64 / 63.0),
            width_hz: 13.4e6,
            interval_s: 8.0,
        });
    }
    block
}

/// Prints how the cost of a point falls with the size of the batch.
fn batches(block: &VisBlock, sources: &[Source]) {
    println!("batch, exponential, detected kernel: ns/(vis point)");
    for batch in [1, 4, 16, 64, SOURCES] {
        let terms = terms(&sources[..batch], Profile::Exponential);
        let seconds = (0..REPEATS).map(|_| kernel_s(Isa::detect(), block, &terms));
        let seconds = seconds.fold(f64::INFINITY, f64::min);
        println!(
            "{batch:>6} {:>8.3}",
            1e9 * seconds / (block.len() * batch) as f64
        );
    }
}

/// Prints the cost on all threads of the pool together.
fn all_cores(block: &VisBlock, sources: &[Source]) {
    let blocks = vec![block.clone(); 4];
    let seconds = best_s(|| {
        black_box(xy_batch(black_box(&blocks), sources, Profile::Exponential));
    });
    let points = (blocks.len() * block.len() * sources.len()) as f64;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!(
        "{threads} threads together: {:.3} ns/(vis point)",
        1e9 * seconds / points
    );
}

/// Prints the cost of taking 50 sources out of a block.
fn subtraction(block: &VisBlock, sources: &[Source]) {
    let models: Vec<_> = sources[..50]
        .iter()
        .map(|&s| (s, Profile::Exponential))
        .collect();
    let mut block = block.clone();
    let seconds = best_s(|| subtract(black_box(&mut block), &models));
    let points = (block.len() * models.len()) as f64;
    println!(
        "subtraction of 50 sources: {:.3} ns/(vis source)",
        1e9 * seconds / points
    );
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
        kernels(profile, &block, &sources);
    }
    println!("with smearing, primary beam and spectral index");
    kernels(Profile::Exponential, &seen(block.clone()), &sources);
    batches(&block, &sources);
    all_cores(&block, &sources);
    subtraction(&block, &sources);
}
