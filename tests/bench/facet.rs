//! Facets on the paper's set-up: cost of building and of a likelihood call, and the error of ln L
//! against the exact engine by place and shape.
//!
//! Run: `cargo bench --bench facet`; after `--`, the number of time samples (480) and the side of a
//! facet in arcsec (20).
#![allow(clippy::print_stdout)] // a benchmark prints

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;
use vis2cat::coords::Lm;
use vis2cat::likelihood::facet::{
    Facet, FacetBuilder, FacetNeeds, FacetPlan, Gains, Reach, TiltRange, W_TERM_MAX,
};
use vis2cat::likelihood::{VisBlock, subtract, xy_batch};
use vis2cat::prior::Region;
use vis2cat::rime::Source;
use vis2cat::rime::shape::{Ellipticity, Profile};
use vis2cat::simulate::{Array, Pointing, UvwFrame};
use vis2cat::units::{ARCSEC, SPEED_OF_LIGHT};

/// Corner of a field of 1 degree.
const CORNER: Lm = Lm {
    l: 0.0087,
    m: -0.0087,
};
/// Middle of an edge.
const EDGE: Lm = Lm {
    l: -0.0087,
    m: 0.002,
};
const CENTRE: Lm = Lm { l: 0.0, m: 0.0 };

/// Noise on the baselines of SKA1-MID, `n_time` samples over eight hours, one block each; sigma
/// such that the sensitivity is that of 480 samples.
fn observation(n_time: usize) -> Vec<VisBlock> {
    let array = Array::find("ska1-mid").expect("built in");
    let baselines = array.baselines();
    let sigma = 1.85e-3 * (n_time as f64 / 480.0).sqrt();
    let per_m = 1.4e9 / SPEED_OF_LIGHT;
    (0..n_time)
        .into_par_iter()
        .map(|t| {
            let mut rng = ChaCha8Rng::seed_from_u64(t as u64);
            let hour = 8.0 * ((t as f64 + 0.5) / n_time as f64 - 0.5);
            let frame = UvwFrame::new(&Pointing {
                gha_rad: hour / 24.0 * TAU - 21.44f64.to_radians(),
                dec_rad: -30f64.to_radians(),
                frame_pa_rad: 0.0,
                elevation_rad: 1.0,
            });
            let uvw: Vec<_> = array
                .dishes
                .iter()
                .map(|dish| frame.apply(dish.itrf_m).map(|x| x * per_m))
                .collect();
            let mut block = VisBlock::default();
            for &(i, j) in &baselines {
                let [p, q] = [uvw[i as usize], uvw[j as usize]];
                block.u.push(p[0] - q[0]);
                block.v.push(p[1] - q[1]);
                block.w.push(p[2] - q[2]);
                let [re, im]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
                block.weight.push((1.0 / (sigma * sigma)) as f32);
                block.weighted_re.push((re / sigma) as f32);
                block.weighted_im.push((im / sigma) as f32);
            }
            block
        })
        .collect()
}

/// `source` with the flux density that makes its signal-to-noise ratio `snr`.
fn with_snr(blocks: &[VisBlock], source: Source, snr: f64) -> Source {
    let y = xy_batch(blocks, &[source], Profile::Exponential)[0].y;
    Source {
        flux_jy: snr / y.sqrt(),
        ..source
    }
}

/// Adds galaxies of SNR 140 to the data: one in each facet, one outside at one to five widths.
fn add_sources(blocks: &mut [VisBlock], regions: &[Region], side: f64) {
    for (i, region) in regions.iter().enumerate() {
        for (place, far) in [(0.3, 0.0), (0.1, 1.3 + 1.5 * i as f64)] {
            let at = region.from_unit(0.5 + place, 0.5 - place);
            let galaxy = Source {
                lm: Lm {
                    l: at.l + 0.6 * far * side,
                    m: at.m - 0.8 * far * side,
                },
                flux_jy: 1.0,
                scale_rad: 1.3 * ARCSEC,
                e: Ellipticity { e1: 0.2, e2: -0.3 },
                tilt: 0.0,
            };
            let galaxy = with_snr(blocks, galaxy, 140.0);
            let negative = Source {
                flux_jy: -galaxy.flux_jy,
                ..galaxy
            };
            blocks
                .par_iter_mut()
                .for_each(|block| subtract(block, &[(negative, Profile::Exponential)]));
        }
    }
}

/// Sources of one class of shapes all over a region, its edges and corners included.
fn sources(region: &Region, count: usize, scale_arcsec: [f64; 2], e: [f64; 2]) -> Vec<Source> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    (0..count)
        .map(|i| {
            let [u, v]: [f64; 2] = std::array::from_fn(|_| match i % 4 {
                0 => f64::from(u8::from(rng.random::<bool>())),
                _ => rng.random(),
            });
            let (sin, cos) = (TAU * rng.random::<f64>()).sin_cos();
            let e = e[0] + (e[1] - e[0]) * rng.random::<f64>();
            let [low, high] = scale_arcsec;
            Source {
                lm: region.from_unit(u, v),
                flux_jy: 1.0,
                scale_rad: low * (high / low).powf(rng.random()) * ARCSEC,
                e: Ellipticity {
                    e1: e * cos,
                    e2: e * sin,
                },
                tilt: 0.0,
            }
        })
        .collect()
}

/// Prints the errors of a class of shapes: of X in units of sqrt(Y), which is the error of ln L per
/// SNR, of Y relative, and the worst |Δ ln L| over 1e-4 SNR²/2 + 0.01 for SNR of 8 and 200.
fn accuracy(blocks: &[VisBlock], facet: &Facet, what: &str, sources: &[Source]) {
    let exact = xy_batch(blocks, sources, Profile::Exponential);
    let got = facet.xy_batch(sources);
    let (mut x2, mut worst_x, mut worst_y) = (0.0, 0.0f64, 0.0f64);
    let mut worst = [0.0f64; 2];
    for (exact, got) in exact.iter().zip(&got) {
        let dx = (got.x - exact.x) / exact.y.sqrt();
        let dy = got.y / exact.y - 1.0;
        x2 += dx * dx;
        worst_x = worst_x.max(dx.abs());
        worst_y = worst_y.max(dy.abs());
        for (worst, snr) in worst.iter_mut().zip([8.0, 200.0]) {
            let error = snr * dx - 0.5 * snr * snr * dy;
            *worst = worst.max(error.abs() / (0.5e-4 * snr * snr + 0.01));
        }
    }
    println!(
        "{what:<24} {:>9.1e} {worst_x:>9.1e} {worst_y:>9.1e} {:>8.3} {:>8.3}",
        (x2 / sources.len() as f64).sqrt(),
        worst[0],
        worst[1]
    );
}

const CLASSES: [(&str, [f64; 2], [f64; 2]); 9] = [
    ("0.1-0.4\" round", [0.1, 0.4], [0.0, 0.3]),
    ("0.1-0.4\" e 0.6-0.8", [0.1, 0.4], [0.6, 0.8]),
    ("0.5-1\" e 0-0.3", [0.5, 1.0], [0.0, 0.3]),
    ("1-2\" e 0-0.3", [1.0, 2.0], [0.0, 0.3]),
    ("1-2\" e 0.3-0.6", [1.0, 2.0], [0.3, 0.6]),
    ("1-2\" e 0.6-0.8", [1.0, 2.0], [0.6, 0.8]),
    ("2-4\" e 0-0.5", [2.0, 4.0], [0.0, 0.5]),
    ("4-10\" e 0-0.5", [4.0, 10.0], [0.0, 0.5]),
    ("4-10\" e 0.6-0.8", [4.0, 10.0], [0.6, 0.8]),
];

fn build(plan: &Arc<FacetPlan>, centres: &[Lm], blocks: &[VisBlock]) -> Vec<Facet> {
    let mut builder = FacetBuilder::new(plan.clone(), centres);
    for blocks in blocks.chunks(16) {
        builder.add(blocks);
    }
    builder.finish()
}

/// Prints what a facet more costs, and what all have in common: sorting and weights.
fn building(plan: &Arc<FacetPlan>, blocks: &[VisBlock]) {
    let samples: usize = blocks.iter().map(VisBlock::len).sum();
    let seconds = |facets: usize, blocks: &[VisBlock]| {
        let start = Instant::now();
        black_box(build(plan, &vec![CORNER; facets], blocks));
        start.elapsed().as_secs_f64()
    };
    let finish = (seconds(8, &[]) - seconds(0, &[])) / 8.0;
    let (none, many) = (seconds(0, blocks), seconds(8, blocks));
    println!(
        "building, one core: {:.2} ns per visibility for each facet, {:.2} ns for all together; {:.0} ms more to finish a facet",
        1e9 * ((many - none) / 8.0 - finish) / samples as f64,
        1e9 * (none - finish) / samples as f64,
        1e3 * finish
    );
}

/// Cost of the exact engine [ns per visibility and source].
fn exact_ns(blocks: &[VisBlock]) -> f64 {
    let region = Region::square(CENTRE, 20.0 * ARCSEC);
    let sources = sources(&region, 256, [1.0, 2.0], [0.0, 0.3]);
    let blocks = &blocks[..blocks.len().min(4)];
    let samples: usize = blocks.iter().map(VisBlock::len).sum();
    let start = Instant::now();
    black_box(xy_batch(blocks, &sources, Profile::Exponential));
    1e9 * start.elapsed().as_secs_f64() / (samples * sources.len()) as f64
}

/// Prints the cost of a likelihood call for `sources`, on one core, and how many times that of the
/// exact engine is.
fn evaluation(facet: &Facet, what: &str, sources: &[Source], exact_us: f64) {
    let run = |_| {
        let start = Instant::now();
        black_box(facet.xy_batch(black_box(sources)));
        start.elapsed().as_secs_f64()
    };
    let best = (0..10).map(run).fold(f64::INFINITY, f64::min);
    let cells: usize = sources.iter().map(|s| facet.cells_of(s)).sum();
    let us = 1e6 * best / sources.len() as f64;
    println!(
        "{what:<24} {us:>7.2} {:>8} {:>8.3} {:>12.0}",
        cells / sources.len(),
        1e9 * best / cells as f64,
        exact_us / us
    );
}

fn main() {
    let numbers: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let n_time = numbers.first().map_or(480, |&n| n as usize);
    let side = numbers.get(1).copied().unwrap_or(20.0) * ARCSEC;
    let mut blocks = observation(n_time);
    let centres = [CENTRE, EDGE, CORNER];
    let regions = centres.map(|lm| Region::square(lm, side));
    add_sources(&mut blocks, &regions, side);
    let reach = blocks
        .iter()
        .map(Reach::of)
        .reduce(Reach::union)
        .unwrap_or_default();
    let samples: usize = blocks.iter().map(VisBlock::len).sum();
    println!("{samples} samples, {reach:?}");
    let plan = FacetPlan::new(FacetNeeds {
        side_rad: side,
        farthest: CORNER.l.hypot(CORNER.m),
        reach,
        longest_axis_rad: 10.0 / 0.196 * ARCSEC,
        profile: Profile::Exponential,
        w_term_max: W_TERM_MAX,
        gains: Gains::None,
        tilts: TiltRange::default(),
    });
    let plan = Arc::new(plan.expect("a facet of this size"));
    println!("{plan}");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.expect("one thread");
    pool.install(|| building(&plan, &blocks));
    let facets = build(&plan, &centres, &blocks);
    let ns = pool.install(|| exact_ns(&blocks));
    println!("exact engine: {ns:.3} ns per visibility and source, one core");
    let exact_us = 1e-3 * ns * samples as f64;

    println!("shapes                   rms X/sY     max X     max Y    SNR 8  SNR 200");
    for (name, region, facet) in [
        ("centre", &regions[0], &facets[0]),
        ("edge", &regions[1], &facets[1]),
        ("corner", &regions[2], &facets[2]),
    ] {
        println!("{name}");
        for (what, scale, e) in CLASSES {
            accuracy(&blocks, facet, what, &sources(region, 200, scale, e));
        }
    }
    println!("shapes                   us/call    cells  ns/cell  exact/facet");
    for (what, scale, e) in CLASSES {
        evaluation(
            &facets[2],
            what,
            &sources(&regions[2], 500, scale, e),
            exact_us,
        );
    }
}
