//! `--chains`: what is written, and what the programs that it is written for make of it.

use std::process::Command;

use crate::support::{errors, in_repository, program, search, searched};

/// With getdist and anesthetic where they are installed; MultiNest's files are always looked into.
#[test]
fn chains_are_loaded_by_the_programs_they_are_for() {
    let run = searched();
    let folder = tempfile::tempdir().unwrap();
    let chains = folder.path().join("chains");
    let flags = ["--chains", chains.to_str().unwrap()];
    let paths = search(&run.data, &folder.path().join("out.fits"), &flags);
    let n_source = run.table("CATALOGUE").rows();
    let n_file = std::fs::read_dir(&chains).unwrap().count();
    assert_eq!(n_file, 7 * n_source);
    let same = |a, b| std::fs::read(a).unwrap() == std::fs::read(b).unwrap();
    assert!(same(&paths.catalogue, &run.paths.catalogue));

    // They are not replaced unless told.
    std::fs::remove_file(&paths.catalogue).unwrap();
    std::fs::remove_file(&paths.posterior).unwrap();
    let again = program()
        .arg(&run.data)
        .arg(&paths.catalogue)
        .args(flags)
        .output()
        .unwrap();
    assert_eq!(again.status.code(), Some(4));
    assert!(errors(&again).contains("--overwrite"), "{}", errors(&again));

    let Some(python) = crate::support::python_with("numpy") else {
        return;
    };
    let done = Command::new(python)
        .arg(in_repository("scripts/check_chains.py"))
        .arg(&chains)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success(), "{text}\n{}", errors(&done));
    let lines = |start: &str| text.lines().filter(|line| line.starts_with(start)).count();
    assert_eq!(lines("ok multinest"), n_source);
    let n_missing = lines("SKIPPED");
    assert_eq!(lines("ok"), (3 - n_missing) * n_source, "{text}");
}
