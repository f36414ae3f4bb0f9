//! The outputs of a whole run in the hands of other programs.

use std::process::Command;

use crate::support::{in_repository, oracles_are_required, python_with, searched, skipped};

/// `fitsverify`, checksums and units by astropy, and STILTS: see `scripts/check_catalogue.py`.
#[test]
fn other_programs_open_catalogue_posterior_and_truth_without_complaint() {
    let Some(python) = python_with("sys") else {
        return;
    };
    let run = searched();
    let done = Command::new(python)
        .arg(in_repository("scripts/check_catalogue.py"))
        .args([&run.paths.catalogue, &run.paths.posterior, &run.truth])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&done.stdout);
    let errors = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{text}\n{errors}");
    for line in text.lines().filter(|line| line.starts_with("SKIPPED")) {
        skipped(line);
    }
    if oracles_are_required() {
        assert_eq!(text.lines().filter(|l| l.starts_with("ok")).count(), 9);
    }
}
