//! The command line: exit codes, refusals, what is printed, and what is left behind.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use serde_json::Value;
use vis2cat_formats::fits::read_table;

use crate::support::{errors, in_repository, program, searched, simulate, vis2cat, vis2cat_ok};

/// Runs `command`, which must fail with `code` and say `wanted`.
fn fails(command: &str, code: i32, wanted: &str) {
    let done = vis2cat(command.split_whitespace());
    let text = errors(&done);
    assert_eq!(done.status.code(), Some(code), "{command}: {text}");
    assert!(text.contains(wanted), "{command}: {text}");
    assert!(done.stdout.is_empty(), "{command}");
}

fn n_files(folder: &Path) -> usize {
    std::fs::read_dir(folder).unwrap().count()
}

fn fixture() -> String {
    in_repository("fixtures/ska30.uvfits").display().to_string()
}

#[test]
fn help_shows_examples_and_exit_codes() {
    let text = vis2cat_ok(["--help"]);
    for wanted in [
        "Examples:",
        "vis2cat field.uvfits sources.fits",
        "Exit codes:",
    ] {
        assert!(text.contains(wanted), "{text}");
    }
    assert!(vis2cat_ok(["simulate", "--help"]).contains("--array ska1-mid"));
    assert!(vis2cat_ok(["evaluate", "--help"]).contains("evaluate sources.fits truth.fits"));
    assert!(vis2cat_ok(["--version"]).starts_with("vis2cat "));
}

#[test]
fn a_wrong_command_line_is_2_and_says_what_to_write() {
    fails("", 2, "OUT.fits");
    fails("a.uvfits", 2, "OUT.fits");
    fails("a.uvfits b.fits --fov 10", 2, "as in 0.5arcsec");
    fails("a.uvfits b.fits --flux 10uJy", 2, "10uJy:200uJy");
    fails("a.uvfits b.fits --flux 20uJy:10uJy", 2, "empty");
    fails("a.uvfits b.fits --noise loud", 2, "sefd=400Jy");
    fails(
        "a.uvfits b.fits --tiles 4 --tile-size 1deg",
        2,
        "cannot be used with",
    );
    fails("a.uvfits b.fits --efficiency 2", 2, "efficiency = 2");
    fails("a.uvfits b.fits --memory 1MB", 2, "at least 16MB");
    fails("a.uvfits b.fits --colour", 2, "--colour");
    fails(
        "simulate a.uvfits --array nowhere --sources 1",
        2,
        "meerkat",
    );
    fails("simulate a.uvfits --array meerkat", 2, "--sources");
    fails("evaluate sources.fits", 2, "TRUTH");
}

#[test]
fn a_wrong_configuration_is_2_and_names_the_key() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.toml");
    for (text, named) in [
        ("snr-cutt = 5", "snr-cutt"),
        ("snr-cut = -5", "snr-cut"),
        ("fov = 10", "fov"),
        ("[prior]\ncolour = 1", "colour"),
        ("fov = [", "run.toml"),
    ] {
        std::fs::write(&path, text).unwrap();
        let command = format!("a.uvfits b.fits --config {}", path.display());
        fails(&command, 2, named);
    }
    fails("a.uvfits b.fits --config no.toml", 2, "no.toml");
}

/// The configuration in the README is read without complaint: the run fails later, for its input.
#[test]
fn the_configuration_that_the_readme_shows_is_valid() {
    let readme = std::fs::read_to_string(in_repository("README.md")).unwrap();
    let (_, rest) = readme.split_once("```toml\n").unwrap();
    let (example, _) = rest.split_once("```").unwrap();
    assert!(example.contains("[prior]"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.toml");
    std::fs::write(&path, example).unwrap();
    let command = format!("nothing.uvfits b.fits --config {}", path.display());
    fails(&command, 3, "nothing.uvfits");
}

#[test]
fn an_input_that_cannot_be_used_is_3_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.fits");
    for (input, wanted) in [
        ("fixtures/nothing.uvfits", "cannot read"),
        ("README.md", "no visibility file"),
        ("fixtures/bad/cut_in_data.uvfits", "cut_in_data.uvfits"),
        ("fixtures/bad/image.uvfits", "image.uvfits"),
        ("fixtures/good/pyuvdata_ifs_sources.uvfits", "--field"),
    ] {
        let input = in_repository(input);
        let command = format!("{} {}", input.display(), out.display());
        fails(&command, 3, wanted);
    }
    let command = format!("{} {} --field nobody", fixture(), out.display());
    fails(&command, 3, "FIELD");
    fails("info fixtures/nothing.uvfits", 3, "cannot read");
    assert_eq!(n_files(folder.path()), 0);
}

#[test]
fn an_output_that_exists_is_4_and_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.fits");
    for name in ["out.fits", "out.posterior.fits"] {
        let precious = folder.path().join(name);
        std::fs::write(&precious, "precious").unwrap();
        fails(
            &format!("{} {}", fixture(), out.display()),
            4,
            "--overwrite",
        );
        let command = format!(
            "simulate {} --array vla-d --sources 1 --dec 30deg",
            precious.display()
        );
        fails(&command, 4, "--overwrite");
        assert_eq!(std::fs::read(&precious).unwrap(), b"precious");
        assert_eq!(n_files(folder.path()), 1);
        std::fs::remove_file(precious).unwrap();
    }
}

/// The outputs are looked at before the input: nobody computes for hours to be told this.
#[test]
fn an_output_in_no_folder_is_4_at_once() {
    fails(
        "nothing.uvfits no/such/folder/out.fits",
        4,
        "no/such/folder",
    );
    let command = "simulate no/such/folder/a.uvfits --array vla-d --dec 30deg --sources 1";
    fails(command, 4, "no/such/folder");
}

#[test]
fn finding_nothing_is_0_and_an_empty_catalogue_and_flags_win_over_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let (config, out) = (
        folder.path().join("run.toml"),
        folder.path().join("out.fits"),
    );
    let text = "snr-cut = 1e6\nfov = \"1deg\"\nseed = 7\n[prior]\nflux = \"20uJy:1mJy\"\n";
    std::fs::write(&config, text).unwrap();
    let command = format!(
        "{} {} --config {} --fov 20arcsec --tiles 4 --seed 8",
        searched().data.display(),
        out.display(),
        config.display()
    );
    let text = vis2cat_ok(command.split_whitespace());
    assert!(text.contains("0 sources"), "{text}");
    assert_eq!(read_table(&out, None).unwrap().rows(), 0);
    let run = read_table(&out, Some("RUN")).unwrap();
    let value = |key: &str| {
        let row = run.strings("KEY").unwrap().iter().position(|k| k == key);
        run.strings("VALUE").unwrap()[row.unwrap()].clone()
    };
    assert_eq!(value("config.fov"), "20arcsec");
    assert_eq!(value("config.seed"), "8");
    assert_eq!(value("config.snr-cut"), "1000000.0");
    assert_eq!(value("config.prior.flux"), "20uJy:1000uJy");
    // And now the outputs are there.
    fails(&command, 4, "--overwrite");
    vis2cat_ok(format!("{command} --overwrite").split_whitespace());
}

#[test]
fn quiet_is_silent_and_colourless_logs_go_to_standard_error() {
    let folder = tempfile::tempdir().unwrap();
    // Weights of 1, which is worth a warning.
    let out = folder.path().join("out.fits");
    let command = format!(
        "{} {} --fov 10arcsec --tiles 4 --snr-cut 1e6 --overwrite",
        fixture(),
        out.display()
    );
    let loud = vis2cat(command.split_whitespace());
    assert!(loud.status.success() && !loud.stdout.is_empty());
    let log = errors(&loud);
    assert!(log.contains("WARN") && log.contains("--noise"), "{log}");
    assert!(!log.contains('\u{1b}'), "{log:?}");
    let quiet = vis2cat(format!("{command} --quiet").split_whitespace());
    assert!(quiet.status.success() && quiet.stdout.is_empty() && quiet.stderr.is_empty());
}

#[test]
fn info_counts_what_is_in_a_file() {
    let path = in_repository("fixtures/good/pyuvdata_ifs_sources.uvfits");
    let wanted = std::fs::read_to_string(path.with_extension("json")).unwrap();
    let wanted: Value = serde_json::from_str(&wanted).unwrap();
    let found = vis2cat_ok(["info".as_ref(), "--json".as_ref(), path.as_os_str()]);
    let found: Value = serde_json::from_str(&found).unwrap();
    let (n_chan, n_corr) = (&wanted["n_chan"], &wanted["n_corr"]);
    let observation = &found["observation"];
    assert_eq!(found["n_row"], wanted["n_row"]);
    assert_eq!(found["n_flagged"], wanted["n_flagged"]);
    let n_value = ["n_row", "n_chan", "n_corr"].map(|key| wanted[key].as_u64().unwrap());
    assert_eq!(found["n_value"], n_value.iter().product::<u64>());
    let length = |value: &Value| Value::from(value.as_array().unwrap().len());
    assert_eq!(length(&observation["freq_setups"][0]["freq_hz_f"]), *n_chan);
    assert_eq!(length(&observation["corrs"]), *n_corr);
    assert_eq!(length(&observation["antennas"]), wanted["n_antenna"]);
    assert_eq!(length(&observation["fields"]), length(&wanted["fields"]));
    // Three antennas make three baselines, and three more of each with itself; four times.
    assert_eq!(found["n_baseline"], 6);
    assert_eq!(found["n_row_auto"], 12);
    assert_eq!(found["n_time"], 4);

    let text = vis2cat_ok(["info".as_ref(), path.as_os_str()]);
    for wanted in ["SRC0", "SRC1", "RR LL RL LR", "24 (12 autocorrelations)"] {
        assert!(text.contains(wanted), "{text}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let mut child = program()
        .args(["info", "--json", &fixture()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let done = child.wait_with_output().unwrap();
    assert!(!errors(&done).contains("panicked"), "{}", errors(&done));
}

/// Kills the program after several delays and hands `check` the folder each time; tells how often it
/// was still running.
fn kill_early(command: &str, delays_ms: &[u64], check: impl Fn()) -> usize {
    let mut n_early = 0;
    for delay_ms in delays_ms {
        let mut child = program()
            .args(command.split_whitespace())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(*delay_ms));
        n_early += usize::from(child.try_wait().unwrap().is_none());
        child.kill().unwrap(); // SIGKILL
        child.wait().unwrap();
        check();
    }
    n_early
}

#[test]
fn a_killed_search_leaves_whole_files_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let sky = "RA,DEC,Total_flux,Scale_length\n53.1035,30.0025,300,2\n";
    let data = simulate(folder.path(), sky);
    let out = folder.path().join("out.fits");
    let posterior = folder.path().join("out.posterior.fits");
    let command = format!(
        "{} {} --fov 20arcsec --tiles 4 --n-live 50 --flux 50uJy:1mJy --overwrite",
        data.display(),
        out.display()
    );
    let n_early = kill_early(&command, &[0, 30, 100, 300, 800], || {
        for path in [&out, &posterior] {
            assert!(!path.exists() || read_table(path, None).unwrap().rows() > 0);
        }
        assert!(!out.exists() || posterior.exists());
    });
    assert!(n_early > 0, "no kill came early enough to test anything");
    // What was killed is in nobody's way.
    vis2cat_ok(command.split_whitespace());
    assert_eq!(read_table(&out, None).unwrap().rows(), 1);
}

#[test]
fn a_killed_simulation_leaves_a_whole_file_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("field.uvfits");
    let command = format!(
        "simulate {} --array meerkat --sources 3 --hours 1 --channels 8 --overwrite",
        out.display()
    );
    let n_early = kill_early(&command, &[0, 20, 60, 120, 250], || {
        if out.exists() {
            vis2cat_ok(["info".as_ref(), out.as_os_str()]);
        }
    });
    assert!(n_early > 0, "no kill came early enough to test anything");
    vis2cat_ok(command.split_whitespace());
    vis2cat_ok(["info".as_ref(), out.as_os_str()]);
}
