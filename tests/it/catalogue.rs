//! The catalogue as others see it: bytes, tools, refusals.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use vis2cat::catalogue::{
    CatalogueHeader, CataloguePaths, CatalogueSource, Estimate, Flags, ModeRow, PosteriorRow,
    PriorRange, RunEntry, SourceRow, WeightedSample, posterior_rows, read_sources, source_name,
    summarise, summary_table, write, write_truth,
};
use vis2cat::coords::{Lm, RaDec};
use vis2cat::detect::Status;
use vis2cat::rime::Source;
use vis2cat::rime::shape::{Ellipticity, Profile};
use vis2cat::units::{ARCSEC, DEG, MICROJY};
use vis2cat_formats::WriteError;
use vis2cat_formats::fits::{Value, read_table};

fn header() -> CatalogueHeader {
    CatalogueHeader {
        telescope: Some("MeerKAT".into()),
        object: Some(
            "it's a field; with a very long name that needs more than one card to be told".into(),
        ),
        date_obs: Some("2024-02-29T12:00:00".into()),
        mjd_obs: Some(60369.5),
        ref_freq_hz: Some(1.4e9),
        phase_centre: centre(),
        profile: Profile::Exponential,
        seed: u64::MAX,
        has_beam: false,
        has_p_above: false,
        has_spectral_index: false,
        priors: vec![PriorRange {
            parameter: "Total_flux".into(),
            unit: "uJy".into(),
            low: 10.0,
            high: 200.0,
            form: "power law, index -1.34".into(),
        }],
        config: vec![
            "vis2cat find in.uvfits --output out.fits".into(),
            format!(
                "cut = {{ snr = 8.0 }} # {}",
                "µ and a long remark ".repeat(9)
            ),
            String::new(),
        ],
    }
}

fn centre() -> RaDec {
    RaDec {
        ra_rad: 0.001 * DEG,
        dec_rad: -30.0 * DEG,
    }
}

fn samples(l: f64, flux_jy: f64, n: usize) -> Vec<WeightedSample> {
    let sample = |i: usize| {
        let t = i as f64 / n as f64 - 0.5;
        let source = Source {
            lm: Lm {
                l: l + t * ARCSEC,
                m: 1e-3 + t * t * ARCSEC,
            },
            flux_jy: flux_jy * (1.0 + 0.1 * t),
            scale_rad: ARCSEC * (1.0 + t * t),
            e: Ellipticity {
                e1: 0.2 + 0.1 * t,
                e2: -0.1 * t,
            },
            tilt: -0.7,
        };
        WeightedSample {
            log_w: -1e4 - t * t,
            log_l: 40.0 - t * t,
            source,
        }
    };
    (0..n).map(sample).collect()
}

struct Found {
    sources: Vec<SourceRow>,
    modes: Vec<ModeRow>,
    posterior: Vec<PosteriorRow>,
}

/// Two sources, the second a point with much that is not defined, and a dropped mode.
fn found() -> Found {
    found_with(200)
}

/// As [`found`], the first source with `n` samples.
fn found_with(n: usize) -> Found {
    let mut found = Found {
        sources: Vec::new(),
        modes: Vec::new(),
        posterior: Vec::new(),
    };
    let sets = [
        (samples(-2e-3, 50e-6, n), Profile::Exponential),
        (samples(1e-3, 20e-6, 1), Profile::Point),
    ];
    for (id, (set, profile)) in (1_i64..).zip(sets) {
        let posterior = summarise(&set, centre(), profile).expect("samples with weight");
        let post_row = found.posterior.len() as i64;
        found
            .posterior
            .extend(posterior_rows(&set, id, id + 10, centre(), profile));
        found.sources.push(SourceRow {
            name: source_name("V2C", posterior.position),
            source_id: id,
            group_id: id,
            mode_id: id + 10,
            posterior,
            snr: 12.5,
            snr_peak: 13.0,
            log_z: Estimate {
                mean: 70.0,
                err: 0.2,
            },
            p_source: f64::NAN,
            p_above: f64::NAN,
            max_dlog_l: f64::NAN,
            flags: posterior.flags().with(Flags::AT_BORDER),
            post_row,
            pb_gain: f64::NAN,
            post_n: set.len() as i64,
        });
        found.modes.push(mode(id + 10, Status::Kept, Some(id)));
    }
    found.modes.push(mode(13, Status::BelowCut, None));
    found
}

fn mode(mode_id: i64, status: Status, source_id: Option<i64>) -> ModeRow {
    ModeRow {
        mode_id,
        tile_id: 3,
        position: centre(),
        position_sigma_rad: ARCSEC,
        lm: Lm::default(),
        flux_jy: Estimate {
            mean: 5e-6,
            err: 1e-6,
        },
        snr: 4.0,
        snr_peak: 4.5,
        log_z: Estimate::MISSING,
        p_source: f64::NAN,
        n_samples: 400,
        n_eff: 120.0,
        status,
        source_id,
    }
}

fn run_entries() -> Vec<RunEntry> {
    vec![
        RunEntry::new("sampler.n_live", 400, "live points"),
        RunEntry::new("input", "données.uvfits", ""),
        RunEntry::new("long", "v".repeat(300), "longer than any card"),
    ]
}

fn write_all(out: &Path, overwrite: bool, f: &Found) -> Result<CataloguePaths, WriteError> {
    let paths = CataloguePaths::new(out);
    let run = run_entries();
    write(
        &paths,
        overwrite,
        &header(),
        &f.sources,
        &f.modes,
        &run,
        &f.posterior,
    )?;
    Ok(paths)
}

fn nothing() -> Found {
    Found {
        sources: Vec::new(),
        modes: Vec::new(),
        posterior: Vec::new(),
    }
}

/// Runs `scripts/check_catalogue.py`; `VIS2CAT_PYTHON` names an interpreter that has astropy.
#[allow(clippy::print_stderr)] // What was skipped must be seen.
fn check_with_oracles(files: &[&Path]) {
    let python = std::env::var("VIS2CAT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/check_catalogue.py");
    let Ok(done) = Command::new(python).arg(script).args(files).output() else {
        eprintln!("no Python here: the catalogue is not checked by other tools");
        return;
    };
    let text = String::from_utf8_lossy(&done.stdout);
    let errors = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{text}\n{errors}");
    eprintln!("{text}");
}

#[test]
fn other_tools_read_catalogue_and_truth_without_a_warning() {
    let dir = tempfile::tempdir().unwrap();
    let full = write_all(&dir.path().join("full.fits"), false, &found()).unwrap();
    let empty = write_all(&dir.path().join("empty.fits"), false, &nothing()).unwrap();
    let truth = dir.path().join("truth.fits");
    write_truth(&truth, false, None, &[]).unwrap();
    check_with_oracles(&[
        &full.catalogue,
        &full.posterior,
        &empty.catalogue,
        &empty.posterior,
        &truth,
    ]);
}

#[test]
fn what_was_written_is_read_back_in_its_units() {
    let dir = tempfile::tempdir().unwrap();
    let f = found();
    let paths = write_all(&dir.path().join("out.fits"), false, &f).unwrap();
    let table = read_table(&paths.catalogue, None).unwrap();
    assert_eq!((table.rows(), table.columns().len()), (2, 38));
    assert_eq!(table.strings("source_name").unwrap()[0], f.sources[0].name);
    let ra_deg = table.numbers("RA").unwrap()[0];
    // West of a centre at 0.001 deg: across 0 h.
    assert!(
        ra_deg > 359.0 && (ra_deg * DEG - f.sources[0].posterior.position.ra_rad).abs() < 1e-15
    );
    let flux_ujy = table.numbers("Total_flux").unwrap()[0];
    assert!((flux_ujy * MICROJY / f.sources[0].posterior.flux_jy.mean - 1.0).abs() < 1e-14);
    assert!(table.numbers("PA").unwrap()[1].is_nan() && table.numbers("Maj").unwrap()[1] == 0.0);
    assert_eq!(table.numbers("Flags").unwrap(), [2.0, 3.0]);
    for (column, unit) in [
        ("RA", "deg"),
        ("E_RA", "arcsec"),
        ("Total_flux_lo", "uJy"),
        ("L", "rad"),
    ] {
        assert_eq!(table.column(column).unwrap().unit.as_deref(), Some(unit));
    }
    assert_eq!(table.keyword("RADESYS"), Some(&"ICRS".into()));
    assert_eq!(table.keyword("RESTFRQ"), Some(&1.4e9.into()));
    assert_eq!(table.keyword("SEED"), Some(&u64::MAX.into()));
    let object = header().object.map(Value::from);
    assert_eq!(table.keyword("OBJECT"), object.as_ref());
    assert!(table.keyword("EQUINOX").is_none() && table.keyword("DATE").is_none());
}

#[test]
fn modes_and_run_stand_behind_the_catalogue() {
    let dir = tempfile::tempdir().unwrap();
    let paths = write_all(&dir.path().join("out.fits"), false, &found()).unwrap();
    let modes = read_table(&paths.catalogue, Some("MODES")).unwrap();
    assert_eq!(
        modes.strings("Status").unwrap(),
        ["kept", "kept", "below_cut"]
    );
    assert!(modes.numbers("Source_id").unwrap()[2].is_nan());
    let run = read_table(&paths.catalogue, Some("RUN")).unwrap();
    assert_eq!(run.strings("KEY").unwrap()[0], "sampler.n_live");
    assert_eq!(run.strings("VALUE").unwrap()[0], "400");
    assert_eq!(run.strings("VALUE").unwrap()[2].len(), 300);
}

#[test]
fn a_sources_samples_are_its_slice_of_the_posterior() {
    let dir = tempfile::tempdir().unwrap();
    let f = found();
    let paths = write_all(&dir.path().join("out.fits"), false, &f).unwrap();
    let samples = read_table(&paths.posterior, None).unwrap();
    let (ids, flux) = (
        samples.numbers("Source_id").unwrap(),
        samples.numbers("flux").unwrap(),
    );
    let weight = samples.numbers("weight").unwrap();
    for source in &f.sources {
        let slice = source.post_row as usize..(source.post_row + source.post_n) as usize;
        assert!(
            ids[slice.clone()]
                .iter()
                .all(|&id| id == source.source_id as f64)
        );
        let mean: f64 = slice.map(|i| weight[i] * flux[i]).sum();
        assert!((mean * MICROJY / source.posterior.flux_jy.mean - 1.0).abs() < 1e-12);
    }
}

#[test]
fn samples_that_are_not_the_sources_own_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let mut f = found();
    f.sources[1].post_row -= 1;
    let refused = write_all(&dir.path().join("out.fits"), false, &f);
    assert!(matches!(refused, Err(WriteError::Parameter { .. })));
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn the_same_rows_give_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = |name: &str| {
        let paths = write_all(&dir.path().join(name), false, &found()).unwrap();
        (
            std::fs::read(paths.catalogue).unwrap(),
            std::fs::read(paths.posterior).unwrap(),
        )
    };
    assert!(bytes("a.fits") == bytes("b.fits"));
}

#[test]
fn neither_file_is_written_where_one_is_there_already() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out.fits");
    let paths = CataloguePaths::new(&out);
    std::fs::write(&paths.posterior, "precious").unwrap();
    assert!(matches!(
        write_all(&out, false, &found()),
        Err(WriteError::Exists { .. })
    ));
    assert!(!paths.catalogue.exists());
    assert_eq!(std::fs::read(&paths.posterior).unwrap(), b"precious");
    write_all(&out, true, &found()).unwrap();
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 2);
    assert_eq!(read_table(&paths.posterior, None).unwrap().rows(), 201);
}

/// Set for a copy of this test program that is to be killed: where it writes.
const KILL_DIR: &str = "VIS2CAT_TEST_KILL_DIR";

#[test]
fn a_killed_run_leaves_whole_files_or_none() {
    if let Some(dir) = std::env::var_os(KILL_DIR) {
        let found = found_with(100_000);
        println!("ready");
        write_all(&Path::new(&dir).join("out.fits"), false, &found).unwrap();
        return;
    }
    let mut cut_short = 0;
    for delay_ms in [0, 5, 10, 20, 30, 40, 60, 80, 120, 1000] {
        let dir = tempfile::tempdir().unwrap();
        let me = std::env::current_exe().unwrap();
        let mut child = Command::new(me)
            .args([
                "--exact",
                "--nocapture",
                "catalogue::a_killed_run_leaves_whole_files_or_none",
            ])
            .env(KILL_DIR, dir.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap()).lines();
        let ready = out.find(|line| line.as_ref().unwrap().ends_with("ready"));
        ready.unwrap().unwrap();
        std::thread::sleep(Duration::from_millis(delay_ms));
        child.kill().unwrap(); // SIGKILL
        child.wait().unwrap();
        let paths = CataloguePaths::new(&dir.path().join("out.fits"));
        cut_short += usize::from(!paths.catalogue.exists());
        for (path, rows) in [(paths.catalogue, 2), (paths.posterior, 100_001)] {
            assert!(!path.exists() || read_table(&path, None).unwrap().rows() == rows);
        }
    }
    assert!(cut_short > 0, "no kill came early enough to test anything");
}

#[test]
fn the_truth_comes_back_as_a_list_of_sources() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("truth.fits");
    let source = |i: usize| CatalogueSource {
        position: RaDec {
            ra_rad: 0.1 * i as f64,
            dec_rad: -0.5 + 0.01 * i as f64,
        },
        flux_jy: 10e-6 * (i + 1) as f64,
        scale_rad: 0.7 * ARCSEC * i as f64,
        e: Ellipticity {
            e1: 0.05 * i as f64,
            e2: -0.03,
        },
        spectral_index: -0.1 * i as f64,
        snr: if i == 0 { f64::NAN } else { 8.0 },
    };
    let truth: Vec<_> = (0..10).map(source).collect();
    write_truth(&path, false, Some(1.4e9), &truth).unwrap();
    let back = read_sources(&path).unwrap();
    let close = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * a.abs();
    assert_eq!(back.len(), truth.len());
    for (a, b) in truth.iter().zip(&back) {
        assert!(close(a.position.ra_rad, b.position.ra_rad));
        assert!(close(a.position.dec_rad, b.position.dec_rad));
        assert!(close(a.flux_jy, b.flux_jy) && close(a.scale_rad, b.scale_rad));
        assert!(a.e == b.e && (a.snr == b.snr || a.snr.is_nan() && b.snr.is_nan()));
    }
    assert!(matches!(
        write_truth(&path, false, None, &truth),
        Err(WriteError::Exists { .. })
    ));
}

#[test]
fn a_catalogue_is_itself_a_list_of_sources() {
    let dir = tempfile::tempdir().unwrap();
    let f = found();
    let paths = write_all(&dir.path().join("out.fits"), false, &f).unwrap();
    let sources = read_sources(&paths.catalogue).unwrap();
    assert_eq!(sources.len(), 2);
    assert!((sources[0].flux_jy / f.sources[0].posterior.flux_jy.mean - 1.0).abs() < 1e-14);
}

#[test]
fn the_closing_summary_is_aligned() {
    let text = summary_table(&found().sources);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3);
    let widths: Vec<usize> = lines.iter().map(|l| l.chars().count()).collect();
    assert!(widths.iter().all(|&w| w == widths[0]), "{text}");
    assert!(
        lines[1].starts_with("V2C J235928.") && lines[1].contains(" ± "),
        "{text}"
    );
}
