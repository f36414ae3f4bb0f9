//! Visibilities as detection sees them: in memory or streamed, a part of them or all.

use std::path::{Path, PathBuf};

use vis2cat::catalogue::{CatalogueSource, read_sources};
use vis2cat::config::{Config, Engine, NoiseSource};
use vis2cat::coords::{Lm, RaDec};
use vis2cat::dataset::{Dataset, EngineOptions, OpenOptions, Request};
use vis2cat::detect::{
    Cuts, Detection, NoObserver, SamplerSettings, Settings, Task, detect, field_of_view, tiles,
};
use vis2cat::likelihood::Xy;
use vis2cat::prior::MODE_DIMS;
use vis2cat::rime::shape::Profile;
use vis2cat::rime::{InstrumentTerms, Source};
use vis2cat::sampler::{MultiNest, MultiNestConfig, Sampler, SamplerError};
use vis2cat::units::ARCSEC;
use vis2cat_formats::ReadOptions;

use crate::detect::ONE;
use crate::support::{in_repository, simulate, vis2cat_ok};

fn open(path: &Path, memory_bytes: f64) -> Dataset {
    open_all(&[path.to_owned()], memory_bytes)
}

fn open_all(paths: &[PathBuf], memory_bytes: f64) -> Dataset {
    let options = OpenOptions {
        read: ReadOptions::default(),
        noise: NoiseSource::Auto,
        memory_bytes,
        profile: Profile::Exponential,
        typical_scale_rad: ARCSEC,
        instrument: InstrumentTerms::default(),
        engine: EngineOptions {
            engine: Engine::Exact,
            farthest: 0.0,
            longest_axis_rad: 0.0,
            most_tilt: 0.0,
        },
    };
    Dataset::open(paths, &options, &mut |_, _| {}).unwrap()
}

/// The file, its model and its geometry are pyuvdata's, not ours: see `scripts/make_field.py`.
#[test]
fn a_file_of_pyuvdata_holds_its_sources_where_its_truth_says_and_not_mirrored() {
    let mut data = open(&in_repository("fixtures/ska30.uvfits"), 1e9);
    let truth = read_sources(&in_repository("fixtures/ska30_truth.csv")).unwrap();
    let field = data.phase_centre();
    let centre = RaDec {
        ra_rad: field.ra_rad,
        dec_rad: field.dec_rad,
    };
    let source = |s: &CatalogueSource| Source {
        lm: s.position.to_lm(centre),
        flux_jy: s.flux_jy,
        scale_rad: s.scale_rad,
        e: s.e,
        tilt: 0.0,
    };
    let sources: Vec<Source> = truth.iter().map(source).collect();
    data.set_removed(sources.clone());
    let mirrored = |l: f64, m: f64, s: &Source| Source {
        lm: Lm {
            l: l * s.lm.l,
            m: m * s.lm.m,
        },
        ..*s
    };
    let requests: Vec<Request> = sources
        .iter()
        .map(|s| Request {
            points: vec![
                *s,
                mirrored(-1.0, 1.0, s),
                mirrored(1.0, -1.0, s),
                mirrored(-1.0, -1.0, s),
            ],
            restored: vec![*s],
        })
        .collect();
    let xy = data.evaluate(&requests).unwrap();
    for (xy, truth) in xy.iter().zip(&truth) {
        let snr = xy[0].snr_peak();
        assert!((snr - truth.snr).abs() < 5.0, "{snr} for {}", truth.snr);
        // What is elsewhere is noise and sidelobes.
        let elsewhere = xy[1..].iter().map(|xy| xy.snr_peak());
        assert!(elsewhere.fold(0.0, f64::max) < 0.6 * snr);
    }
}

/// The command line wants at least 16 MB; here two blocks must do.
#[test]
fn data_streamed_from_the_file_give_the_same_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = simulate(folder.path(), ONE);
    let (mut held, mut streamed) = (open(&path, 1e9), open(&path, 1e5));
    assert!(!held.is_streamed() && streamed.is_streamed());
    assert_eq!(held.info(), streamed.info());
    let found = find(&mut held);
    assert_eq!(found.sources.len(), 1);
    assert!(found.sources[0].snr > 20.0);
    assert!(found == find(&mut streamed));
    // Several files, too.
    let twice = [path.clone(), path];
    let (mut held, mut streamed) = (open_all(&twice, 1e9), open_all(&twice, 1e5));
    assert!(!held.is_streamed() && streamed.is_streamed());
    assert_eq!(held.info(), streamed.info());
    let doubled = find(&mut held);
    assert!(doubled.sources[0].snr > 1.3 * found.sources[0].snr);
    assert!(doubled == find(&mut streamed));
}

/// A search of four tiles with few live points.
fn find(data: &mut Dataset) -> Detection {
    let config: Config = Config::default();
    let field = field_of_view(30.0 * ARCSEC);
    let beam_rad = data.info().beam_rad;
    let factory = |settings: SamplerSettings| -> Result<Box<dyn Sampler>, SamplerError> {
        Ok(Box::new(MultiNest::new(MultiNestConfig {
            mode_dims: if settings.task == Task::Search {
                MODE_DIMS.to_vec()
            } else {
                Vec::new()
            },
            seed: settings.seed,
            ..MultiNestConfig::new(settings.n_dim, settings.n_live)
        })?))
    };
    let mut prior = config.source_prior();
    (prior.flux.low_jy, prior.flux.high_jy) = (50e-6, 1e-3);
    let settings = Settings {
        field,
        tiles: tiles(&field, 4, beam_rad),
        beam_rad,
        is_global: false,
        screening: true,
        prior,
        cuts: Cuts {
            snr: 6.0,
            flux_jy: None,
            merge_radius_rad: None,
            merge_floor_rad: 0.4 * ARCSEC,
            near_rad: 12.0 * beam_rad,
        },
        likely: None,
        factory: &factory,
        n_live: 50,
        n_live_source: 60,
        refine: true,
        seed: 1,
    };
    detect(data, &settings, &mut NoObserver).unwrap()
}

/// 300 sources without noise: what each adds to the ratio seen at random places.
#[test]
fn the_confusion_by_faint_sources_is_what_they_add_to_the_noise() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("faint.uvfits");
    let command = format!(
        "simulate {} --array meerkat --tint 3600s --fov 20arcmin --sources 300 --flux 8uJy:16uJy --no-noise --quiet",
        path.display()
    );
    vis2cat_ok(command.split_whitespace());
    let mut data = open(&path, 1e9);
    let config = Config::default();
    let mut prior = config.prior.clone();
    (prior.flux.low.0, prior.flux.high.0) = (8e-6, 16e-6);
    let (prior, field) = (
        prior.source_prior(None),
        field_of_view(20.0 * 60.0 * ARCSEC),
    );
    let (all_are_below, beam_rad) = (100.0, data.info().beam_rad);
    let predicted = 300.0
        * data
            .confusion_of_one(&prior, all_are_below, &field, 0.05 * beam_rad)
            .unwrap();
    let at = |(i, source): (usize, Source)| {
        let [x, y] = [0.754_877_666, 0.569_840_291].map(|step: f64| (step * i as f64).fract());
        Source {
            lm: field.from_unit(x, y),
            ..source
        }
    };
    let points: Vec<Source> = prior.evenly(20_000).enumerate().map(at).collect();
    let n_point = points.len() as f64;
    let request = Request {
        points,
        restored: Vec::new(),
    };
    let xy = data.evaluate(&[request]).unwrap();
    let seen = xy[0].iter().map(|xy| xy.x * xy.x / xy.y).sum::<f64>() / n_point;
    assert!((predicted / seen - 1.0).abs() < 0.25, "{predicted} {seen}");
}

/// What a source does to the ln L of points beside it when it is removed, by a part of four million
/// samples and by all of them.
#[test]
fn a_glimpse_sees_what_changes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.uvfits");
    let command = format!(
        "simulate {} --array meerkat --tint 120s --channels 8 --sources 1 --quiet",
        path.display()
    );
    vis2cat_ok(command.split_whitespace());
    let mut data = open(&path, 1e9);
    assert!(data.info().n_sample > 3_500_000);
    let field = field_of_view(60.0 * ARCSEC);
    let prior = Config::default().source_prior();
    let point = |i: usize| prior.source(&field, &[0.1 * i as f64, 0.3, 0.5, 0.5, 0.4, 0.6]);
    let points: Vec<Source> = (0..10).map(point).collect();
    let neighbour = Source {
        flux_jy: 1e-4,
        ..prior.source(&field, &[0.5, 0.4, 0.5, 0.5, 0.6, 0.6])
    };
    let request = [Request {
        points: points.clone(),
        restored: Vec::new(),
    }];
    let log_l = |xy: Vec<Vec<Xy>>| -> Vec<f64> {
        let each = points.iter().zip(&xy[0]);
        each.map(|(point, xy)| xy.log_l(point.flux_jy)).collect()
    };
    let all = log_l(data.evaluate(&request).unwrap());
    let some = log_l(data.glimpse(&request).unwrap());
    data.set_removed(vec![neighbour]);
    let all_then = log_l(data.evaluate(&request).unwrap());
    let some_then = log_l(data.glimpse(&request).unwrap());
    let change = |now: &[f64], then: &[f64]| -> Vec<f64> {
        now.iter().zip(then).map(|(now, then)| now - then).collect()
    };
    let (all, some) = (change(&all, &all_then), change(&some, &some_then));
    let largest = all.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(largest > 1.0, "{all:?}");
    assert_ne!(all, some);
    for (all, some) in all.iter().zip(&some) {
        assert!((all - some).abs() < 0.05 * largest, "{all} {some}");
    }
}
