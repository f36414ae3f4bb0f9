//! Simulated observations against pyuvdata, formulas and statistics.

#![allow(clippy::unwrap_used)] // helpers of tests are tests

mod reference;

use num_complex::Complex;
use vis2cat::coords::{Lm, RaDec};
use vis2cat::rime::Source;
use vis2cat::rime::shape::Ellipticity;
use vis2cat::simulate::{
    Array, EarthTable, Pointing, SimulateConfig, Simulation, SimulationSummary, Site, UvwFrame,
    format_utc, observation, simulate,
};
use vis2cat::units::{ARCSEC, DEG, SPEED_OF_LIGHT};
use vis2cat_formats::{Corr, Observation, VisChunk, VisWriter, WriteError};

/// Keeps every chunk.
#[derive(Default)]
struct Keep {
    chunks: Vec<VisChunk>,
}

impl VisWriter for Keep {
    fn write_chunk(&mut self, chunk: &VisChunk) -> Result<(), WriteError> {
        self.chunks.push(chunk.clone());
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), WriteError> {
        Ok(())
    }
}

fn config() -> SimulateConfig {
    SimulateConfig {
        array: Array::find("atca-6a").unwrap(),
        centre: RaDec {
            ra_rad: 53.1 * DEG,
            dec_rad: -30.0 * DEG,
        },
        duration_s: 3600.0,
        sefd_jy: Some(400.0),
        seed: 11,
        ..SimulateConfig::default()
    }
}

fn source() -> Source {
    Source {
        lm: Lm { l: 4e-3, m: -2e-3 },
        flux_jy: 0.1,
        scale_rad: 0.5 * ARCSEC,
        e: Ellipticity { e1: 0.2, e2: 0.1 },
        tilt: 0.0,
    }
}

fn run(config: &SimulateConfig, sources: &[Source]) -> (Keep, SimulationSummary) {
    let mut writer = Keep::default();
    let summary = simulate(config, sources, &mut writer, &mut |_, _| {}).unwrap();
    (writer, summary)
}

#[test]
fn chunks_fit_the_observation() {
    let config = SimulateConfig {
        n_chan: 3,
        ..config()
    };
    let seen: Observation = observation(&config).unwrap();
    let mut progress = Vec::new();
    let mut writer = Keep::default();
    let summary = simulate(&config, &[source()], &mut writer, &mut |done, all| {
        progress.push((done, all));
    })
    .unwrap();
    assert_eq!(seen.n_row, 15 * 60);
    assert_eq!(summary.n_row, seen.n_row);
    assert_eq!(summary.n_vis, 15 * 60 * 3 * 2);
    assert_eq!(progress.last(), Some(&(900, 900)));
    assert_eq!(seen.freq_setups[0].freq_hz_f.len(), 3);
    assert_eq!(seen.antennas[0].number, 1);
    assert_eq!(
        writer.chunks.iter().map(|chunk| chunk.n_row).sum::<usize>(),
        900
    );
    for chunk in &writer.chunks {
        assert_eq!(chunk.vis_jy_rfp.len(), chunk.n_row * 6);
        assert_eq!(chunk.weight_rfp.len(), chunk.n_row * 6);
        assert_eq!(chunk.flag_rfp.len(), chunk.n_row * 6);
        assert_eq!(chunk.interval_s_r, vec![60.0; chunk.n_row]);
        assert!(chunk.ant1_r.iter().zip(&chunk.ant2_r).all(|(i, j)| i < j));
    }
}

#[test]
fn the_default_time_is_centred_on_transit() {
    let config = SimulateConfig {
        duration_s: 8.0 * 3600.0,
        ..config()
    };
    let (_, summary) = run(&config, &[]);
    let site = Site::from_itrf(config.array.centre_m()).unwrap();
    let middle_mjd = 0.5 * (summary.start_mjd + summary.end_mjd);
    let earth = EarthTable::builtin().unwrap().at(middle_mjd).unwrap();
    let pointing = Pointing::at(config.centre, site, middle_mjd, earth).unwrap();
    let turns = (pointing.gha_rad + site.lon_rad) / std::f64::consts::TAU;
    let hour_angle_s = (turns - turns.round()) * 86164.1;
    assert!(hour_angle_s.abs() < 0.6, "{hour_angle_s}");
    assert!(format_utc(middle_mjd).starts_with("2020-01-01"));
    // it transits within half a degree of the zenith of Narrabri, latitude -30.3
    assert!((summary.elevation_rad[1] / DEG - 90.0).abs() < 0.5);
}

#[test]
fn without_noise_the_visibilities_are_the_model_and_both_hands_agree() {
    let config = SimulateConfig {
        noise: false,
        n_chan: 2,
        ..config()
    };
    let (writer, _) = run(&config, &[source()]);
    let s = source();
    for chunk in &writer.chunks {
        for (row, uvw_m) in chunk.uvw_m_r.iter().enumerate() {
            for (chan, freq_hz) in config.freq_hz_f().into_iter().enumerate() {
                let [u, v, w] = uvw_m.map(|x| x * freq_hz / SPEED_OF_LIGHT);
                let phase =
                    std::f64::consts::TAU * (u * s.lm.l + v * s.lm.m + w * s.lm.n_minus_1());
                let at = (row * 2 + chan) * 2;
                let vis_jy = chunk.vis_jy_rfp[at];
                assert_eq!(vis_jy, chunk.vis_jy_rfp[at + 1]);
                let turned = Complex::new(f64::from(vis_jy.re), f64::from(vis_jy.im))
                    * Complex::from_polar(1.0, -phase);
                // a disk's F is positive: turned back, the visibility is real and between 0 and S
                assert!(turned.im.abs() < 1e-7 && turned.re > 0.0 && turned.re < 0.1 + 1e-7);
            }
        }
    }
}

#[test]
fn noise_adds_what_the_weights_say() {
    let config = SimulateConfig {
        n_chan: 8,
        ..config()
    };
    let (noisy, _) = run(&config, &[source()]);
    let quiet_config = SimulateConfig {
        noise: false,
        ..config
    };
    let (quiet, _) = run(&quiet_config, &[source()]);
    let (mut n, mut sum, mut sum_hands) = (0.0, 0.0, 0.0);
    for (noisy, quiet) in noisy.chunks.iter().zip(&quiet.chunks) {
        assert_eq!(noisy.weight_rfp, quiet.weight_rfp);
        let pulls: Vec<_> = noisy
            .vis_jy_rfp
            .iter()
            .zip(&quiet.vis_jy_rfp)
            .zip(&noisy.weight_rfp)
            .map(|((noisy, quiet), weight)| (noisy - quiet) * weight.sqrt())
            .collect();
        for hands in pulls.chunks(2) {
            n += 2.0;
            sum += f64::from(hands[0].norm_sqr() + hands[1].norm_sqr());
            sum_hands += f64::from((hands[0] * hands[1].conj()).re);
        }
    }
    // the mean of n values of |pull|^2, of mean 2 and variance 4, and the hands' correlation
    assert!((sum / n - 2.0_f64).abs() < 4.0 * 2.0 / f64::sqrt(n));
    assert!(f64::abs(sum_hands / n) < 4.0 * 1.5 / f64::sqrt(n));
}

#[test]
fn the_signal_to_noise_ratio_is_that_of_the_weights() {
    let point = Source {
        scale_rad: 0.0,
        ..source()
    };
    let (writer, summary) = run(&config(), &[point, source()]);
    let sum_w: f64 = writer
        .chunks
        .iter()
        .flat_map(|chunk| &chunk.weight_rfp)
        .map(|weight| f64::from(*weight))
        .sum();
    assert!((summary.snr_s[0] / (0.1 * sum_w.sqrt()) - 1.0).abs() < 1e-6);
    assert!(summary.snr_s[1] < summary.snr_s[0]);
    // one hand has 1/sqrt(2) of it, and Stokes I all
    let snr = |corrs: &[Corr]| {
        let corrs = corrs.to_vec();
        let config = SimulateConfig { corrs, ..config() };
        run(&config, &[point]).1.snr_s[0]
    };
    assert!((snr(&[Corr::Xx]) * 2f64.sqrt() / summary.snr_s[0] - 1.0).abs() < 1e-12);
    assert!((snr(&[Corr::I]) / summary.snr_s[0] - 1.0).abs() < 1e-12);
}

#[test]
fn the_outcome_does_not_depend_on_the_number_of_threads() {
    let with_threads = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build();
        pool.unwrap().install(|| run(&config(), &[source()]))
    };
    let (one, one_summary) = with_threads(1);
    let (three, three_summary) = with_threads(3);
    assert_eq!(one.chunks, three.chunks);
    assert_eq!(one_summary, three_summary);
    let other_seed = SimulateConfig {
        seed: 12,
        ..config()
    };
    assert_ne!(one.chunks, run(&other_seed, &[source()]).0.chunks);
}

#[test]
fn a_field_below_the_horizon_is_an_error_and_one_that_sets_a_warning() {
    let never = SimulateConfig {
        centre: RaDec {
            ra_rad: 1.0,
            dec_rad: 80.0 * DEG,
        },
        ..config()
    };
    let message = Simulation::new(&never).unwrap_err().to_string();
    assert!(message.contains("below the horizon of ATCA"), "{message}");
    let sets = SimulateConfig {
        duration_s: 20.0 * 3600.0,
        interval_s: 600.0,
        ..config()
    };
    let warnings = run(&sets, &[]).1.warnings;
    assert!(warnings[0].contains("of 120 samples"), "{warnings:?}");
}

#[test]
fn a_time_outside_the_earth_table_asks_for_ut1_utc() {
    let late = SimulateConfig {
        start_mjd: Some(62000.0),
        ..config()
    };
    let message = Simulation::new(&late).unwrap_err().to_string();
    assert!(message.contains("--ut1-utc"), "{message}");
    let given = SimulateConfig {
        ut1_utc_s: Some(0.1),
        duration_s: 86400.0,
        ..late
    };
    let seen = Simulation::new(&given).unwrap();
    assert_eq!(seen.observation().earth.ut1_utc_s, Some(0.1));
}
