//! Facets against the exact engine.

use super::*;
use crate::likelihood::samples::{noise, seen};
use crate::likelihood::{VisBlock, subtract, xy_batch};
use crate::rime::shape::{Ellipticity, Profile};
use crate::simulate::{Array, Pointing, UvwFrame};
use crate::units::ARCSEC;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Corner of a field of 1 degree.
pub(super) const CORNER: Lm = Lm {
    l: 0.0087,
    m: -0.0087,
};
pub(super) const CENTRE: Lm = Lm { l: 0.0, m: 0.0 };

/// Longest major axis of the prior [rad]: 10 arcsec, |e| = 0.804.
const LONGEST: f64 = 51.1 * ARCSEC;

pub(super) fn needs(side_arcsec: f64, reach: Reach, profile: Profile) -> FacetNeeds {
    FacetNeeds {
        side_rad: side_arcsec * ARCSEC,
        farthest: CORNER.l.hypot(CORNER.m),
        reach,
        longest_axis_rad: LONGEST,
        profile,
        w_term_max: W_TERM_MAX,
        gains: Gains::None,
        tilts: TiltRange::default(),
    }
}

/// A plan for facets of `side_arcsec` over the made-up samples of this room.
pub(super) fn plan(side_arcsec: f64) -> Arc<FacetPlan> {
    let reach = Reach {
        uv: 7.5e5,
        w: 3e5,
        blur: 0.0,
    };
    Arc::new(FacetPlan::new(needs(side_arcsec, reach, Profile::Exponential)).unwrap())
}

/// The 19 306 baselines of SKA1-MID at `n_time` times over eight hours, -30 degrees, 1.4 GHz, with
/// noise that gives the whole the sensitivity of the paper's observation.
pub(super) fn ska1_mid(n_time: usize) -> Vec<VisBlock> {
    observed("ska1-mid", n_time, 1.4e9 / crate::units::SPEED_OF_LIGHT)
}

/// The baselines of an array times `per_m`, as above.
fn observed(array: &str, n_time: usize, per_m: f64) -> Vec<VisBlock> {
    let array = Array::find(array).unwrap();
    let scale = 480.0 / n_time as f64;
    let block = |t: usize| {
        let hour = 8.0 * ((t as f64 + 0.5) / n_time as f64 - 0.5);
        let frame = UvwFrame::new(&Pointing {
            gha_rad: hour / 24.0 * TAU - 0.374,
            dec_rad: -30.0 * crate::units::DEG,
            ..Pointing::default()
        });
        let place = |dish: &crate::simulate::Dish| frame.apply(dish.itrf_m).map(|x| x * per_m);
        let uvw: Vec<_> = array.dishes.iter().map(place).collect();
        let baselines = array.baselines();
        let mut block = noise(baselines.len(), t as u64);
        for (k, &(i, j)) in baselines.iter().enumerate() {
            let [p, q] = [uvw[i as usize], uvw[j as usize]];
            [block.u[k], block.v[k], block.w[k]] = std::array::from_fn(|d| p[d] - q[d]);
            block.weight[k] *= scale as f32;
            block.weighted_re[k] *= scale.sqrt() as f32;
            block.weighted_im[k] *= scale.sqrt() as f32;
        }
        block
    };
    (0..n_time).map(block).collect()
}

pub(super) fn reach(blocks: &[VisBlock]) -> Reach {
    blocks
        .iter()
        .map(Reach::of)
        .fold(Reach::default(), Reach::union)
}

fn build(plan: &Arc<FacetPlan>, centres: &[Lm], blocks: &[VisBlock]) -> Vec<Facet> {
    let mut builder = FacetBuilder::new(plan.clone(), centres);
    builder.add(blocks);
    builder.finish()
}

/// Adds a galaxy of 1.3 arcsec and signal-to-noise ratio `snr` at `lm`.
fn add_galaxy(blocks: &mut [VisBlock], lm: Lm, snr: f64) {
    let mut galaxy = Source {
        lm,
        flux_jy: 1.0,
        scale_rad: 1.3 * ARCSEC,
        e: Ellipticity { e1: 0.2, e2: -0.3 },
        tilt: 0.0,
    };
    let y = xy_batch(blocks, &[galaxy], Profile::Exponential)[0].y;
    galaxy.flux_jy = -snr / y.sqrt();
    for block in blocks {
        subtract(block, &[(galaxy, Profile::Exponential)]);
    }
}

/// Sources all over `region`, every fourth in a corner, of sizes log-uniform in `scale_arcsec`, and
/// |e| to `e_max`.
pub(super) fn sources(
    region: &Region,
    count: usize,
    scale_arcsec: [f64; 2],
    e_max: f64,
) -> Vec<Source> {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let source = |i: usize| {
        let [u, v]: [f64; 2] = std::array::from_fn(|_| match i % 4 {
            0 => f64::from(u8::from(rng.random::<bool>())),
            _ => rng.random(),
        });
        let (sin, cos) = (TAU * rng.random::<f64>()).sin_cos();
        let e = e_max * rng.random::<f64>();
        let [low, high] = scale_arcsec;
        Source {
            lm: region.from_unit(u, v),
            flux_jy: 1e-4,
            scale_rad: low * (high / low).powf(rng.random()) * ARCSEC,
            e: Ellipticity {
                e1: e * cos,
                e2: e * sin,
            },
            tilt: 0.0,
        }
    };
    (0..count).map(source).collect()
}

/// The same sources with all spectral indices of `tilts`.
fn tilted(mut sources: Vec<Source>, tilts: TiltRange) -> Vec<Source> {
    let n = sources.len() as f64;
    for (i, source) in sources.iter_mut().enumerate() {
        source.tilt = tilts.most * (2.0 * (i as f64 + 0.5) / n - 1.0);
    }
    sources
}

/// Indices that are free by one to either side, over the band of [`meerkat`].
const FREE: TiltRange = TiltRange {
    most: 1.0,
    half_band_ln: 0.406,
};

/// Largest |Δ ln L| over 1e-4 SNR²/2 + 0.01, the bound asked for, at a flux density that makes the
/// signal-to-noise ratio of each of `sources` `snr`.
fn worst(facet: &Facet, blocks: &[VisBlock], sources: &[Source], snr: f64) -> f64 {
    let exact = xy_batch(blocks, sources, facet.plan.needs.profile);
    let error = |(got, exact): (Xy, Xy)| {
        let flux_jy = snr / exact.y.sqrt();
        let error = (got.log_l(flux_jy) - exact.log_l(flux_jy)).abs();
        error / (0.5e-4 * snr * snr + 0.01)
    };
    let pairs = facet.xy_batch(sources).into_iter().zip(exact);
    pairs.map(error).fold(0.0, f64::max)
}

/// Data with a source of SNR 140 in each facet and another one or two widths away.
fn crowded(centres: &[Lm], side_rad: f64) -> Vec<VisBlock> {
    let mut blocks = ska1_mid(6);
    for (i, lm) in centres.iter().enumerate() {
        let at = |dl: f64, dm: f64| Lm {
            l: lm.l + dl * side_rad,
            m: lm.m + dm * side_rad,
        };
        add_galaxy(&mut blocks, at(0.3, -0.3), 140.0);
        add_galaxy(&mut blocks, at(1.0 + i as f64, 0.4), 140.0);
    }
    blocks
}

#[test]
fn log_l_agrees_with_the_exact_engine_all_over_the_prior() {
    let centres = [CENTRE, CORNER];
    let blocks = crowded(&centres, 20.0 * ARCSEC);
    let needs = needs(20.0, reach(&blocks), Profile::Exponential);
    let plan = Arc::new(FacetPlan::new(needs).unwrap());
    let facets = build(&plan, &centres, &blocks);
    // At the corner w changes the shapes of the sources, in Y to first order.
    for (facet, [faint, bright]) in facets.iter().zip([[0.1, 0.02], [0.2, 0.3]]) {
        for (scale_arcsec, e_max) in [([0.1, 1.0], 0.804), ([1.0, 2.0], 0.6), ([1.0, 10.0], 0.804)]
        {
            let sources = sources(&facet.region(), 100, scale_arcsec, e_max);
            for (snr, bound) in [(8.0, faint), (200.0, bright)] {
                let worst = worst(facet, &blocks, &sources, snr);
                assert!(
                    worst < bound,
                    "{:?} {scale_arcsec:?} {snr}: {worst}",
                    facet.centre()
                );
            }
        }
    }
}

#[test]
fn faint_fields_agree_at_the_corner_too() {
    let mut blocks = ska1_mid(6);
    add_galaxy(&mut blocks, CORNER, 12.0);
    let plan = Arc::new(FacetPlan::new(needs(20.0, reach(&blocks), Profile::Exponential)).unwrap());
    let facet = &build(&plan, &[CORNER], &blocks)[0];
    let sources = sources(&facet.region(), 200, [0.1, 10.0], 0.804);
    for snr in [5.0, 12.0, 200.0] {
        let worst = worst(facet, &blocks, &sources, snr);
        assert!(worst < 1.0, "{snr}: {worst}");
    }
}

#[test]
fn gaussians_and_points_agree_too() {
    for profile in [Profile::Gaussian, Profile::Point] {
        let blocks = crowded(&[CENTRE], 15.0 * ARCSEC);
        let plan = Arc::new(FacetPlan::new(needs(15.0, reach(&blocks), profile)).unwrap());
        let facet = &build(&plan, &[CENTRE], &blocks)[0];
        let sources = sources(&facet.region(), 100, [0.1, 10.0], 0.8);
        for snr in [8.0, 200.0] {
            let worst = worst(facet, &blocks, &sources, snr);
            assert!(worst < 1.0, "{profile:?} {snr}: {worst}");
        }
    }
}

#[test]
fn every_kernel_gives_the_same_sums() {
    let (plan, blocks) = (plan(20.0), [noise(20_000, 1)]);
    for profile in [Profile::Exponential, Profile::Gaussian, Profile::Point] {
        let needs = FacetNeeds {
            profile,
            ..plan.needs
        };
        let plan = Arc::new(FacetPlan::new(needs).unwrap());
        let mut facet = build(&plan, &[CORNER], &blocks).remove(0);
        let sources = sources(&facet.region(), 40, [0.1, 10.0], 0.8);
        facet.isa = Isa::Portable;
        let reference = facet.xy_batch(&sources);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            facet.isa = isa;
            for (a, b) in facet.xy_batch(&sources).iter().zip(&reference) {
                assert!((a.x - b.x).abs() < 1e-5 * b.y.sqrt(), "{isa:?} {profile:?}");
                assert!((a.y / b.y - 1.0).abs() < 2e-6, "{isa:?} {profile:?}");
            }
        }
    }
}

#[test]
fn a_map_holds_the_sums_of_a_round_source_at_every_position() {
    let (plan, blocks) = (plan(20.0), [noise(20_000, 1)]);
    let n_side = 17;
    for profile in [Profile::Exponential, Profile::Gaussian, Profile::Point] {
        let needs = FacetNeeds {
            profile,
            ..plan.needs
        };
        let plan = Arc::new(FacetPlan::new(needs).unwrap());
        let mut facet = build(&plan, &[CENTRE], &blocks).remove(0);
        for (scale_rad, isa) in [0.3, 2.0, 6.0].iter().flat_map(|scale| {
            let there = Isa::ALL.into_iter().filter(|isa| isa.is_available());
            there.map(move |isa| (scale * ARCSEC, isa))
        }) {
            facet.isa = isa;
            let map = facet.map(scale_rad, n_side);
            for i in [0, 5, 40, 200, 288] {
                let middle = |i: usize| (i as f64 + 0.5) / n_side as f64;
                let source = Source {
                    lm: facet
                        .region()
                        .from_unit(middle(i % n_side), middle(i / n_side)),
                    flux_jy: 1.0,
                    scale_rad,
                    ..Source::default()
                };
                let xy = facet.xy_batch(&[source])[0];
                // The map has the shape that the middle of the facet sees.
                let off = (f64::from(map.x[i]) - xy.x).abs() / xy.y.sqrt();
                assert!(off < 1e-3, "{profile:?} {isa:?} {i}: {off}");
                let off = (map.y / xy.y - 1.0).abs();
                assert!(off < 1e-3, "{profile:?} {isa:?} {i}: {off}");
            }
        }
    }
}

#[test]
fn every_kernel_fills_the_same_grids() {
    use super::fill::{Target, fill};
    let (plan, block) = (plan(12.0), noise(30_000, 2));
    let samples = super::sorted::Sorted::new(&plan, &block);
    let target = Target::new(&plan, &Centre::new(CORNER));
    let filled = |isa: Isa| {
        let mut grid = vec![0.0; plan.build_bytes() / 4];
        let data = [
            &samples.block.weighted_re[..],
            &samples.block.weighted_im[..],
        ];
        fill(isa, &plan.spread, &target, &samples, data, &mut grid);
        grid
    };
    let reference = filled(Isa::Portable);
    let rms = (reference.iter().map(|x| x * x).sum::<f32>() / reference.len() as f32).sqrt();
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        let differences = filled(isa)
            .into_iter()
            .zip(&reference)
            .map(|(a, b)| (a - b).abs());
        assert!(differences.fold(0.0, f32::max) < 1e-4 * rms, "{isa:?}");
    }
}

#[test]
fn any_number_of_threads_and_any_cut_of_the_stream_give_the_same_bits() {
    let (plan, whole) = (plan(12.0), noise(40_000, 3));
    let centres = [
        CENTRE,
        CORNER,
        Lm {
            l: -0.004,
            m: 0.001,
        },
    ];
    let with_threads = |threads: usize, blocks: &[VisBlock]| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let facets = pool.install(|| {
            let mut builder = FacetBuilder::new(plan.clone(), &centres);
            for block in blocks {
                builder.add(std::slice::from_ref(block));
            }
            builder.finish()
        });
        let xy = |facet: &Facet| facet.xy_batch(&sources(&facet.region(), 20, [0.1, 5.0], 0.8));
        facets.iter().map(xy).collect::<Vec<_>>()
    };
    let part = |range: std::ops::Range<usize>| VisBlock {
        u: whole.u[range.clone()].to_vec(),
        v: whole.v[range.clone()].to_vec(),
        w: whole.w[range.clone()].to_vec(),
        weighted_re: whole.weighted_re[range.clone()].to_vec(),
        weighted_im: whole.weighted_im[range.clone()].to_vec(),
        weight: whole.weight[range].to_vec(),
        ..VisBlock::default()
    };
    let one = with_threads(1, std::slice::from_ref(&whole));
    assert_eq!(
        one,
        with_threads(3, &[part(0..7), part(7..25_000), part(25_000..40_000)])
    );
}

#[test]
fn sums_do_not_depend_on_the_company_in_the_batch() {
    let facet = build(&plan(20.0), &[CORNER], &[noise(10_000, 4)]).remove(0);
    let sources = sources(&facet.region(), 21, [0.1, 10.0], 0.8);
    let together = facet.xy_batch(&sources);
    for size in [1, 2, 7, 20] {
        let apart: Vec<_> = sources
            .chunks(size)
            .flat_map(|sources| facet.xy_batch(sources))
            .collect();
        assert_eq!(together, apart, "batches of {size}");
    }
    assert!(facet.xy_batch(&[]).is_empty());
}

#[test]
fn weights_are_used_again_after_a_subtraction() {
    let (plan, mut blocks) = (plan(20.0), [noise(10_000, 5)]);
    let before = build(&plan, &[CENTRE], &blocks).remove(0);
    add_galaxy(&mut blocks, Lm { l: 1e-5, m: 2e-5 }, 30.0);
    let mut builder =
        FacetBuilder::with_weights(plan.clone(), &[CENTRE], before.weights().unwrap());
    builder.add(&blocks);
    let after = builder.finish().remove(0);
    let fresh = build(&plan, &[CENTRE], &blocks).remove(0);
    let sources = sources(&after.region(), 10, [0.5, 3.0], 0.5);
    assert_eq!(after.xy_batch(&sources), fresh.xy_batch(&sources));
    assert_ne!(after.xy_batch(&sources), before.xy_batch(&sources));
}

#[test]
fn no_samples_give_no_sums() {
    let facet = build(&plan(20.0), &[CENTRE], &[VisBlock::default()]).remove(0);
    let sources = sources(&facet.region(), 3, [0.5, 3.0], 0.5);
    assert_eq!(facet.xy_batch(&sources), [Xy::default(); 3]);
}

#[test]
#[should_panic(expected = "samples reach to")]
fn samples_beyond_the_plan_are_refused() {
    let mut block = noise(100, 6);
    block.u[50] = 9e5;
    FacetBuilder::new(plan(20.0), &[CENTRE]).add(&[block]);
}

#[test]
fn facets_too_large_for_the_w_term_are_refused() {
    let reach = Reach {
        uv: 7e5,
        w: 5e5,
        blur: 0.0,
    };
    let error = FacetPlan::new(needs(60.0, reach, Profile::Exponential)).unwrap_err();
    let FacetError::WTerm { largest_rad, .. } = error else {
        panic!("{error}");
    };
    let largest = needs(0.999 * largest_rad / ARCSEC, reach, Profile::Exponential);
    assert!(FacetPlan::new(largest).is_ok());
    let none = needs(20.0, Reach::default(), Profile::Exponential);
    assert_eq!(FacetPlan::new(none).unwrap_err(), FacetError::Parameter);
}

#[test]
fn windows_of_the_levels_add_up_to_one() {
    let plan = plan(20.0);
    for i in 0..1000 {
        let uv = plan.uv_max * f64::from(i) / 1000.0;
        for last in 0..plan.levels {
            let bands: f64 = (0..last)
                .map(|level| plan.low_pass(level, uv) - plan.low_pass(level + 1, uv))
                .sum();
            assert!((bands + plan.low_pass(last, uv) - 1.0).abs() < 1e-12);
        }
    }
}

/// A sample is a wave over the image; so must its cells be, on every level that it reaches.
#[test]
fn the_cells_of_a_sample_are_its_wave() {
    let plan = plan(20.0);
    for (u, v) in [(6e5, 1e5), (-1e5, 2.3e5), (3e4, 1.0), (100.0, -700.0)] {
        let block = VisBlock {
            u: vec![u],
            v: vec![v],
            w: vec![0.0],
            weighted_re: vec![2.0],
            weighted_im: vec![-1.0],
            weight: vec![1.0],
            ..VisBlock::default()
        };
        let facet = build(&plan, &[CENTRE], std::slice::from_ref(&block)).remove(0);
        for source in sources(&facet.region(), 20, [0.01, 0.02], 0.0) {
            let (got, exact) = (
                facet.xy_batch(&[source])[0],
                xy_batch(
                    std::slice::from_ref(&block),
                    &[source],
                    Profile::Exponential,
                )[0],
            );
            assert!((got.x - exact.x).abs() < 2e-3, "{u} {v}: {got:?} {exact:?}");
            assert!((got.y - exact.y).abs() < 2e-3, "{u} {v}: {got:?} {exact:?}");
        }
    }
}

/// MeerKAT through all terms of the instrument: its 2016 baselines at `n_time` times over eight hours,
/// each in one of 64 channels over an octave.
fn meerkat(n_time: usize) -> Vec<VisBlock> {
    let mut blocks = observed("meerkat", n_time, 1.0);
    for block in &mut blocks {
        *block = seen(block.clone(), 1.0);
        for k in 0..block.len() {
            let freq_hz = block.extents.freq_hz(k);
            for of in [&mut block.u, &mut block.v, &mut block.w] {
                of[k] *= freq_hz / crate::units::SPEED_OF_LIGHT;
            }
        }
    }
    blocks
}

/// At 0.7 degrees from the phase centre, in facets that take three places and six, the second as large as
/// the change of smearing allows.
#[test]
fn factors_of_the_instrument_are_followed_over_a_facet() {
    let centre = Lm {
        l: 0.0086,
        m: -0.0086,
    };
    let blocks = meerkat(40);
    let fixed = TiltRange::default();
    let needs = |side_arcsec, tilts| FacetNeeds {
        gains: Gains::Followed(GAIN_TERM_MAX),
        farthest: 0.02,
        tilts,
        ..needs(side_arcsec, reach(&blocks), Profile::Exponential)
    };
    let Err(FacetError::Gains { largest_rad, .. }) = FacetPlan::new(needs(200.0, fixed)) else {
        panic!("200 arcsec are too large")
    };
    let widest_arcsec = 0.999 * largest_rad / ARCSEC;
    for (side_arcsec, tilts, n_look) in [
        (20.0, fixed, 3),
        (20.0, FREE, 12),
        (widest_arcsec, fixed, 6),
    ] {
        let plan = Arc::new(FacetPlan::new(needs(side_arcsec, tilts)).unwrap());
        assert_eq!(plan.n_look(), n_look, "{side_arcsec}");
        let region = Region::square(centre, side_arcsec * ARCSEC);
        for snr in [10.0, 30.0, 100.0] {
            let mut blocks = blocks.clone();
            add_galaxy(&mut blocks, region.from_unit(0.7, 0.4), snr);
            let facet = &build(&plan, &[centre], &blocks)[0];
            assert!(facet.weights().is_none());
            let sources = tilted(sources(&region, 60, [0.5, 5.0], 0.6), tilts);
            // Up to 0.5.
            let worst = worst(facet, &blocks, &sources, snr);
            assert!(worst < 1.0, "{side_arcsec}, {snr}: {worst}");
        }
    }
}

#[test]
fn pairs_in_a_facet_have_the_factors_of_both() {
    let centre = Lm {
        l: 0.0086,
        m: -0.0086,
    };
    let blocks = meerkat(20);
    let needs = FacetNeeds {
        gains: Gains::Followed(GAIN_TERM_MAX),
        farthest: 0.02,
        tilts: FREE,
        ..needs(10.0, reach(&blocks), Profile::Exponential)
    };
    let plan = Arc::new(FacetPlan::new(CrossFacet::needs(needs)).unwrap());
    let mut builder = CrossBuilder::new(plan, &[centre]);
    builder.add(&blocks);
    let facet = builder.finish().remove(0);
    let region = Region::square(centre, 10.0 * ARCSEC);
    let sources = tilted(sources(&region, 20, [0.5, 5.0], 0.6), FREE);
    for pair in sources.chunks(2).map(|two| [two[0], two[1]]) {
        let exact: f64 = (blocks.iter())
            .map(|b| crate::likelihood::plain_cross(b, &pair, Profile::Exponential))
            .sum();
        let [a, b] = xy_batch(&blocks, &pair, Profile::Exponential)[..] else {
            panic!("two sums")
        };
        let error = (facet.cross_batch(&[pair])[0] - exact).abs() / (a.y * b.y).sqrt();
        assert!(error < 1e-4, "{error:e}");
    }
}

/// By plain sums over the samples.
#[test]
fn what_is_not_summed_does_not_matter() {
    let blocks = ska1_mid(2);
    for profile in [Profile::Exponential, Profile::Gaussian, Profile::Point] {
        let plan = FacetPlan::new(needs(10.0, reach(&blocks), profile)).unwrap();
        let facet = build(&Arc::new(plan), &[CENTRE], &blocks).remove(0);
        let region = Region::square(CENTRE, 10.0 * ARCSEC);
        let mut n_cut = 0;
        for source in sources(&region, 40, [0.1, 10.0], 0.804) {
            let term = facet.term(&facet.looks[0], &source);
            let (mut all, mut left_out) = (0.0, 0.0);
            for block in &blocks {
                for k in 0..block.len() {
                    let (u, v) = (block.u[k], block.v[k]);
                    let q = (term.p * u + term.r * v).powi(2) + term.s * v * v;
                    let factor = crate::rime::predict(
                        &Source {
                            lm: CENTRE,
                            flux_jy: 1.0,
                            ..source
                        },
                        profile,
                        u,
                        v,
                        0.0,
                    );
                    let y = f64::from(block.weight[k]) * factor.norm_sqr();
                    all += y;
                    left_out += if q > term.q_max { y } else { 0.0 };
                }
            }
            assert!(left_out <= 1e-8 * all, "{source:?}: {:e}", left_out / all);
            n_cut += usize::from(left_out > 0.0);
        }
        let is_point = profile == Profile::Point;
        assert_eq!(n_cut == 0, is_point, "{profile:?}: {n_cut} of 40");
    }
}
