//! Our simulated files as pyuvdata reads them.

use std::path::{Path, PathBuf};
use std::process::Command;

use vis2cat::catalogue::CataloguePaths;
use vis2cat_formats::VisChunk;
use vis2cat_formats::fits::read_table;

use crate::support::{
    has_command, in_repository, python_with, search, searched, simulate, skipped, vis2cat_ok,
};

fn run(python: &str, script: &str, args: &[&Path]) {
    let done = Command::new(python)
        .arg(in_repository(script))
        .args(args)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&done.stdout);
    let errors = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{text}\n{errors}");
}

/// Files of one and of several channels, of one and of two hands.
fn simulated(folder: &Path) -> Vec<PathBuf> {
    let wide = folder.join("wide.uvfits");
    let command = format!(
        "simulate {} --array vla-d --dec 40deg --sources 1 --channels 5 --hours 0.2 --hands rr-ll \
         --ra 100deg --start 2022-06-30T18:59:00",
        wide.display()
    );
    vis2cat_ok(command.split_whitespace());
    let stokes_i = folder.join("stokes_i.uvfits");
    let command = format!(
        "simulate {} --array meerkat --sources 2 --hours 0.05 --hands i --dec -20deg",
        stokes_i.display()
    );
    vis2cat_ok(command.split_whitespace());
    vec![wide, stokes_i, searched().data.clone()]
}

/// Values both ways, strict checks, and `fitsverify`: see `scripts/check_uvfits.py`.
#[test]
fn pyuvdata_reads_what_we_read_in_our_simulated_files() {
    if !has_command("fitsverify") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    check_with(
        "pyuvdata",
        "scripts/check_uvfits.py",
        &simulated(folder.path()),
    );
}

/// The same for UVH5, of simulated files and of what pyuvdata wrote: see `scripts/check_uvh5.py`.
#[test]
fn pyuvdata_reads_what_we_read_and_write_as_uvh5() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = simulated(folder.path());
    let entries = std::fs::read_dir(in_repository("fixtures/good")).unwrap();
    let fixtures = entries.map(|entry| entry.unwrap().path());
    files.extend(fixtures.filter(|path| path.extension().is_some_and(|e| e == "uvh5")));
    check_with("pyuvdata", "scripts/check_uvh5.py", &files);
}

/// The same for Measurement Sets, which pyuvdata reads over python-casacore: see
/// `scripts/check_ms.py`.
#[test]
fn pyuvdata_reads_what_we_read_and_write_as_measurement_sets() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = simulated(folder.path());
    // pyuvdata writes no Stokes I.
    files.retain(|path| !path.ends_with("stokes_i.uvfits"));
    files.push(in_repository("fixtures/good/uvh5_gzip.uvh5"));
    check_with("casacore", "scripts/check_ms.py", &files);
}

/// What is looked through before casacore reads it: see `scripts/check_tables.py`.
#[test]
fn no_table_that_casacore_writes_is_taken_for_a_damaged_one() {
    let Some(python) = python_with("casacore") else {
        return;
    };
    let program = Path::new(env!("CARGO_BIN_EXE_vis2cat"));
    let args = ["--seeds", "0", "40", "--program"].map(Path::new);
    run(
        &python,
        "scripts/check_tables.py",
        &[&args[..], &[program]].concat(),
    );
}

/// Parts and averages of a file as pyuvdata makes them: see `scripts/check_convert.py`.
#[test]
fn pyuvdata_selects_and_averages_as_we_do() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wide.uvfits");
    let command = format!(
        "simulate {} --array vla-d --dec 40deg --sources 1 --channels 8 --hours 0.2 --tint 30s",
        file.display()
    );
    vis2cat_ok(command.split_whitespace());
    check_with("pyuvdata", "scripts/check_convert.py", &[file]);
}

/// Runs a script that needs pyuvdata, or what comes with it, and the examples of the formats.
fn check_with(module: &str, script: &str, files: &[PathBuf]) {
    let Some(python) = python_with(module) else {
        return;
    };
    let build = Path::new(env!("CARGO_BIN_EXE_vis2cat")).parent().unwrap();
    if !["dump_vis", "rewrite_vis"]
        .iter()
        .all(|tool| build.join("examples").join(tool).is_file())
    {
        return skipped("the examples of vis2cat-formats are not built; test the whole workspace");
    }
    let mut args: Vec<&Path> = vec![Path::new("--target"), build];
    args.extend(files.iter().map(PathBuf::as_path));
    run(&python, script, &args);
}

/// To a millimetre: see `scripts/check_simulate_uvw.py`.
#[test]
fn pyuvdata_computes_the_same_baseline_coordinates_for_our_simulated_files() {
    let Some(python) = python_with("pyuvdata") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let files = simulated(folder.path());
    let args: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    run(&python, "scripts/check_simulate_uvw.py", &args);
}

/// A sky of another kind of file: the truth table that `--truth` writes is one for `--catalogue`.
#[test]
fn a_truth_table_simulates_the_same_file_again() {
    let folder = tempfile::tempdir().unwrap();
    let sky = "RA,DEC,Total_flux\n53.11,30.01,500\n";
    let first = std::fs::read(simulate(folder.path(), sky)).unwrap();
    let again = folder.path().join("again.uvfits");
    let command = format!(
        "simulate {} --array vla-b --dec 30deg --hours 6 --tint 10min --catalogue {}",
        again.display(),
        folder.path().join("truth.fits").display()
    );
    vis2cat_ok(command.split_whitespace());
    assert!(first == std::fs::read(again).unwrap());
}

/// One observation that pyuvdata wrote in three formats is the same visibilities, to the bit, and the same
/// catalogue.
#[test]
fn the_catalogue_does_not_depend_on_the_format() {
    if !cfg!(feature = "ms") {
        return;
    }
    let (Some(python), Some(_)) = (python_with("pyuvdata"), python_with("casacore")) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(
        &python,
        "scripts/write_formats.py",
        &[&searched().data, folder],
    );
    let found = ["a.uvfits", "a.uvh5", "a.ms"].map(|name| {
        let data = folder.join(name);
        let mut reader = vis2cat_formats::open(&data).unwrap();
        let mut rows = VisChunk::new(reader.observation().n_row as usize + 1);
        reader.read_chunk(&mut rows).unwrap();
        let paths = search(&data, &data.with_extension("fits"), &["--overwrite"]);
        (rows, paths)
    });
    let [(rows, paths), others @ ..] = &found;
    let table = |paths: &CataloguePaths, name| {
        let path = if name == "POSTERIOR" {
            &paths.posterior
        } else {
            &paths.catalogue
        };
        read_table(path, Some(name)).unwrap()
    };
    for (other_rows, other_paths) in others {
        assert_eq!(other_rows.vis_jy_rfp, rows.vis_jy_rfp);
        assert_eq!(other_rows.weight_rfp, rows.weight_rfp);
        assert_eq!(other_rows.uvw_m_r, rows.uvw_m_r);
        for (name, columns) in [
            ("CATALOGUE", ["RA", "Total_flux", "Log_Z"]),
            ("MODES", ["RA", "Total_flux", "Log_Z"]),
            ("POSTERIOR", ["ra", "flux", "log_l"]),
        ] {
            let (other, wanted) = (table(other_paths, name), table(paths, name));
            for column in columns {
                let wanted = wanted.numbers(column).unwrap();
                assert!(wanted.len() > 2);
                assert_eq!(other.numbers(column).unwrap(), wanted, "{name} {column}");
            }
        }
    }
}
