//! Several files in one likelihood.

use std::path::{Path, PathBuf};

use vis2cat_formats::fits::read_table;

use crate::support::{SEARCH, errors, in_repository, searched, vis2cat, vis2cat_ok};

/// Converts with more flags.
fn convert(from: &Path, to: PathBuf, more: &str) -> PathBuf {
    let command = format!("convert {} {} {more}", from.display(), to.display());
    vis2cat_ok(command.split_whitespace());
    to
}

fn find(inputs: &[&Path], out: &Path) {
    let mut args: Vec<String> = inputs
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    args.push(out.display().to_string());
    args.extend(
        SEARCH
            .iter()
            .chain(&["--quiet"])
            .map(|&flag| flag.to_owned()),
    );
    vis2cat_ok(args);
}

/// The two halves of an observation, in two formats, are the observation.
#[test]
fn halves_of_an_observation_give_the_catalogue_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let times = searched().data.as_path();
    let all = convert(times, at("all.uvh5"), "");
    let mut reader = vis2cat_formats::open(&all).unwrap();
    let mut chunk = vis2cat_formats::VisChunk::new(1 << 20);
    reader.read_chunk(&mut chunk).unwrap();
    let middle = 0.5 * (chunk.time_mjd_r[0] + chunk.time_mjd_r[chunk.n_row - 1]);
    let name = if cfg!(feature = "ms") {
        "a.ms"
    } else {
        "a.uvh5"
    };
    let first = convert(&all, at(name), &format!("--times ..{middle}"));
    let second = convert(&all, at("b.uvh5"), &format!("--times {middle}.."));
    find(&[&all], &at("all.fits"));
    find(&[&first, &second], &at("both.fits"));
    let column = |name: &str, column: &str| {
        let table = read_table(&at(name), None).unwrap();
        table.numbers(column).unwrap().clone()
    };
    for name in [
        "RA",
        "DEC",
        "Total_flux",
        "E_Total_flux",
        "Scale_length",
        "Log_Z",
    ] {
        let wanted = column("all.fits", name);
        assert_eq!(wanted.len(), 3);
        for (found, wanted) in column("both.fits", name).iter().zip(wanted) {
            assert!((found - wanted).abs() <= 1e-6 * wanted.abs(), "{name}");
        }
    }
    let run = read_table(&at("both.fits"), Some("RUN")).unwrap();
    let keys = run.strings("KEY").unwrap();
    for key in [
        "input.1.blake3",
        "input.2.blake3",
        "noise.1.weights",
        "noise.2.weights",
    ] {
        assert!(keys.iter().any(|there| there.trim() == key), "{key}");
    }
}

#[test]
fn files_of_other_phase_centres_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.fits");
    let done = vis2cat([
        searched().data.as_os_str(),
        in_repository("fixtures/ska30.uvfits").as_os_str(),
        out.as_os_str(),
    ]);
    assert_eq!(done.status.code(), Some(3));
    let said = errors(&done);
    assert!(
        said.contains("ska30.uvfits") && said.contains("phaseshift"),
        "{said}"
    );
    assert!(!out.exists());
}
