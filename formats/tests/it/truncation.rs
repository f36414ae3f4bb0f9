//! Every fixture cut short, at many lengths: an error, or what is read is as of the whole.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use vis2cat_formats::{Observation, VisChunk};

use crate::support::{
    Fixture, Shape, chunk, files, files_below, fixtures, observation, read, visibility_files, write,
};

/// Rows read at a time.
const MAX_ROW: usize = 100;
const FITS_BLOCK_BYTES: usize = 2880;

/// Lengths to cut a file of `n_byte` at: all near its ends, and every `step`th between, longest first.
fn lengths(n_byte: usize, ends: usize, step: usize) -> Vec<usize> {
    let near = (0..ends.min(n_byte)).chain(n_byte.saturating_sub(ends)..n_byte);
    let lengths: BTreeSet<usize> = near.chain((0..n_byte).step_by(step)).collect();
    lengths.into_iter().rev().collect()
}

/// Shortens a copy of a file to each of the lengths and reads `what` it is part of.
fn cut(
    file: &Path,
    what: &Path,
    lengths: Vec<usize>,
    mut check: impl FnMut(usize, Option<(Observation, VisChunk)>),
) {
    let whole = std::fs::read(file).unwrap();
    let open = std::fs::OpenOptions::new().write(true).open(file).unwrap();
    for len in lengths {
        open.set_len(len as u64).unwrap();
        check(len, read(what, MAX_ROW).ok());
    }
    std::fs::write(file, whole).unwrap();
}

/// Copies a file into a folder and cuts it there; only lengths that `may_pass` may be read, and then
/// nothing may be missing.
fn cut_file(path: &Path, ends: usize, step: usize, may_pass: impl Fn(usize) -> bool) {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join(path.file_name().unwrap());
    std::fs::write(&copy, std::fs::read(path).unwrap()).unwrap();
    let wanted = read(&copy, MAX_ROW).unwrap();
    let n_byte = std::fs::metadata(&copy).unwrap().len() as usize;
    cut(&copy, &copy, lengths(n_byte, ends, step), |len, found| {
        if let Some(mut found) = found {
            // That something is missed is told of.
            found.0.warnings.clone_from(&wanted.0.warnings);
            assert!(may_pass(len), "{len} bytes of {}", path.display());
            assert_eq!(found, wanted, "{len} bytes of {}", path.display());
        }
    });
}

/// A file of ours, with more than one of everything.
fn ours(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    let shape = Shape {
        n_if: 2,
        n_field: 2,
        ..Shape::default()
    };
    write(&path, &observation(&shape), &chunk(&shape));
    path
}

/// Ours end in the antenna table, so that no cut goes unseen.
#[test]
fn every_cut_of_uvfits_is_an_error_unless_a_whole_table_is_missed_by_nobody() {
    let folder = tempfile::tempdir().unwrap();
    cut_file(&ours(folder.path(), "ours.uvfits"), usize::MAX, 1, |_| {
        false
    });
    // pyuvdata ends in tables that need not be there.
    let is_whole = |len| len % FITS_BLOCK_BYTES == 0;
    cut_file(&fixtures("ska30.uvfits"), 100, 14_399, is_whole);
    for path in files(&fixtures("good"), "uvfits") {
        cut_file(&path, 400, 29, is_whole);
    }
}

/// A file says at its start how long it is.
#[test]
fn every_cut_of_uvh5_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    cut_file(&ours(folder.path(), "ours.uvh5"), 4096, 61, |_| false);
    for path in files(&fixtures("good"), "uvh5") {
        cut_file(&path, 300, 97, |_| false);
    }
}

/// Tables of a set that are not read: any cut of them is as good as none.
const LEFT_OUT: [&str; 6] = [
    "FEED/",
    "FLAG_CMD/",
    "POINTING/",
    "PROCESSOR/",
    "SOURCE/",
    "STATE/",
];

/// Padding and what is not read are in many of a set's files.
#[test]
fn every_cut_of_a_set_is_an_error_or_makes_no_difference() {
    let sets = visibility_files(&fixtures("good"));
    for Fixture { path: set, .. } in sets.iter().filter(|set| set.path.is_dir()) {
        let whole = read(set, MAX_ROW).unwrap();
        for (name, bytes) in files_below(set) {
            cut_part(set, &name, bytes.len(), &whole);
            std::fs::remove_file(set.join(&name)).unwrap();
            if let Ok((_, rows)) = read(set, MAX_ROW) {
                assert_eq!(rows, whole.1, "without {name} of {}", set.display());
            }
            std::fs::write(set.join(&name), &bytes).unwrap();
        }
        assert_eq!(read(set, MAX_ROW).unwrap(), whole);
    }
}

fn cut_part(set: &Path, name: &str, n_byte: usize, whole: &(Observation, VisChunk)) {
    let is_read = !LEFT_OUT.iter().any(|table| name.starts_with(table));
    let (ends, n_cut) = if is_read { (2, 4) } else { (1, 1) };
    let step = n_byte.div_ceil(n_cut).max(1);
    let lengths = lengths(n_byte, ends, step);
    cut(&set.join(name), set, lengths, |len, found| {
        if let Some((mut observation, rows)) = found {
            // The table of the history need not be there.
            observation.history.clone_from(&whole.0.history);
            let found = (observation, rows);
            assert_eq!(&found, whole, "{len} bytes of {name} of {}", set.display());
        }
    });
}
