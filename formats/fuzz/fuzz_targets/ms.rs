//! Any archive of a directory as a Measurement Set: an error or rows, nothing else. Corpora are the
//! unpacked tars of `fixtures/good/*.ms.tar.gz`.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "read.rs"]
mod read;

fuzz_target!(|bytes: &[u8]| {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    if tar::Archive::new(bytes).unpack(folder.path()).is_err() {
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder.path()) else {
        return;
    };
    for entry in entries.flatten().filter(|entry| entry.path().is_dir()) {
        read::path(&entry.path());
    }
});
