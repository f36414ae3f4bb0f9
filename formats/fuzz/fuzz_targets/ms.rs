//! Any archive of a directory as a Measurement Set: an error or rows, nothing else.

#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use tar::{Archive, EntryType, Header};

#[path = "read.rs"]
mod read;

const BLOCK_BYTES: usize = 512;
/// Most bytes by which a file grows at once.
const MAX_GROWTH: usize = 64;

fuzz_target!(|bytes: &[u8]| {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    if Archive::new(bytes).unpack(folder.path()).is_err() {
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder.path()) else {
        return;
    };
    for entry in entries.flatten().filter(|entry| entry.path().is_dir()) {
        read::path(&entry.path());
    }
});

// One file of the archive, whose headers have checksums.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    match files(&data[..size]).as_slice() {
        [] => fuzzer_mutate(data, size, max_size),
        files => {
            let (header, bytes) = files[seed as usize % files.len()];
            change(data, size, max_size, header, bytes)
        }
    }
});

/// Where the headers of files stand, and how long these are.
fn files(tar: &[u8]) -> Vec<(usize, usize)> {
    let mut archive = Archive::new(tar);
    let Ok(entries) = archive.entries() else {
        return Vec::new();
    };
    let files = entries
        .map_while(Result::ok)
        .filter(|entry| entry.header().entry_type() == EntryType::Regular);
    let places = files.map(|entry| (entry.raw_header_position() as usize, entry.size() as usize));
    places
        .filter(|(header, bytes)| tar.len() >= header + BLOCK_BYTES + bytes)
        .collect()
}

/// Changes a file and gives it a header that agrees; returns the bytes of the archive.
fn change(data: &mut [u8], size: usize, max_size: usize, header: usize, bytes: usize) -> usize {
    let start = header + BLOCK_BYTES;
    let next = (start + bytes.next_multiple_of(BLOCK_BYTES)).min(size);
    let rest = data[next..size].to_vec();
    let mut file = data[start..start + bytes].to_vec();
    file.resize(bytes + MAX_GROWTH, 0);
    let changed = fuzzer_mutate(&mut file, bytes, bytes + MAX_GROWTH);
    file.truncate(changed);
    let padded = changed.next_multiple_of(BLOCK_BYTES);
    file.resize(padded, 0);
    let end = start + padded + rest.len();
    if end > max_size.min(data.len()) {
        return size;
    }
    let mut described = Header::from_byte_slice(&data[header..start]).clone();
    described.set_size(changed as u64);
    described.set_cksum();
    data[header..start].copy_from_slice(described.as_bytes());
    data[start..start + padded].copy_from_slice(&file);
    data[start + padded..end].copy_from_slice(&rest);
    end
}
