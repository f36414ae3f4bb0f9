//! Reading and writing take no more memory for a larger file.
//!
//! A binary of its own: the peak that the system keeps is that of the whole process.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

use std::path::Path;

use vis2cat_formats::{Antenna, Corr, Field, FreqSetup, Observation, VisChunk, create, open};

/// Rows in a chunk, and chunks in the file: 120 MB.
const N_ROW: usize = 1000;
const N_CHUNK: usize = 150;
const N_CHAN: usize = 64;
/// More than buffers of a megabyte and a chunk need, far less than the file.
const MAX_GROWTH_KB: u64 = 12_000;
/// casacore keeps some tiles of each of three columns, a megabyte each.
#[cfg(feature = "ms")]
const MAX_GROWTH_CASACORE_KB: u64 = 20_000;
/// HDF5 gathers chunks of a megabyte, of three arrays, and keeps caches of its own.
const MAX_GROWTH_HDF5_KB: u64 = 24_000;

/// One test for all formats: the peak never falls, so that the modest ones come first.
#[test]
fn memory_does_not_grow_with_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let observation = observation();
    let largest = [
        ("large.uvfits", MAX_GROWTH_KB),
        #[cfg(feature = "ms")]
        ("large.ms", MAX_GROWTH_CASACORE_KB),
        ("large.uvh5", MAX_GROWTH_HDF5_KB),
    ];
    for (name, max_growth_kb) in largest {
        check(&folder.path().join(name), max_growth_kb, &observation);
    }
}

fn check(path: &Path, max_growth_kb: u64, observation: &Observation) {
    let mut chunk = chunk();
    let before_kb = peak_kb();
    let mut writer = create(path, observation, false).unwrap();
    for i in 0..N_CHUNK {
        // Times of their own, as real rows have.
        chunk.time_mjd_r.fill(60_000.0 + i as f64 / 86_400.0);
        writer.write_chunk(&chunk).unwrap();
    }
    writer.finish().unwrap();
    let mut reader = open(path).unwrap();
    let mut n_row = 0;
    while reader.read_chunk(&mut chunk).unwrap() > 0 {
        n_row += chunk.n_row;
    }

    assert_eq!(n_row, N_ROW * N_CHUNK);
    let file_kb = bytes_of(path) / 1000;
    let growth_kb = peak_kb() - before_kb;
    assert!(file_kb > 3 * max_growth_kb, "{file_kb} kB");
    assert!(growth_kb < max_growth_kb, "grew by {growth_kb} kB");
}

/// Bytes of a file, or of all files of a directory.
fn bytes_of(path: &Path) -> u64 {
    if !path.is_dir() {
        return std::fs::metadata(path).unwrap().len();
    }
    let entries = std::fs::read_dir(path).unwrap();
    entries.map(|entry| bytes_of(&entry.unwrap().path())).sum()
}

fn peak_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status
        .lines()
        .find(|line| line.starts_with("VmHWM:"))
        .unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

fn observation() -> Observation {
    let antenna = |number| Antenna {
        number,
        ..Antenna::default()
    };
    Observation {
        antennas: vec![antenna(1), antenna(2)],
        fields: vec![Field::default()],
        freq_setups: vec![FreqSetup {
            freq_hz_f: (0..N_CHAN).map(|f| 1e9 + 1e6 * f as f64).collect(),
            chan_width_hz_f: vec![1e6; N_CHAN],
            n_if: 1,
        }],
        corrs: vec![Corr::Xx],
        ..Observation::default()
    }
}

fn chunk() -> VisChunk {
    let mut chunk = VisChunk::new(N_ROW);
    chunk.clear(N_CHAN, 1);
    chunk.n_row = N_ROW;
    chunk.uvw_m_r.resize(N_ROW, [1.0, 2.0, 3.0]);
    chunk.time_mjd_r.resize(N_ROW, 60_000.0);
    chunk.interval_s_r.resize(N_ROW, 1.0);
    chunk.ant1_r.resize(N_ROW, 0);
    chunk.ant2_r.resize(N_ROW, 1);
    chunk.field_r.resize(N_ROW, 0);
    chunk.freq_setup_r.resize(N_ROW, 0);
    chunk
        .vis_jy_rfp
        .resize(N_ROW * N_CHAN, num_complex::Complex::new(1.0, 0.0));
    chunk.weight_rfp.resize(N_ROW * N_CHAN, 1.0);
    chunk.flag_rfp.resize(N_ROW * N_CHAN, false);
    chunk
}
