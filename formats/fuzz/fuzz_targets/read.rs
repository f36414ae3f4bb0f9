//! What is done with every input.

use std::path::Path;

use vis2cat_formats::{Averaging, ReadOptions, VisChunk, VisReader, open_with};

/// Most rows that are read: an input that says it has more than it holds must be an error before.
const MAX_ROWS: u64 = 1 << 16;

/// Reads bytes as a file, if they begin as its format does.
#[allow(dead_code)] // not by every target
pub fn file(bytes: &[u8], signature: &[u8]) {
    if !bytes.starts_with(signature) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let name = folder.path().join("a");
    std::fs::write(&name, bytes).expect("room for a file");
    path(&name);
}

/// Reads to the end or the first error, and if it was the end once more, averaged.
pub fn path(path: &Path) {
    let Ok(mut reader) = open_with(path, &ReadOptions::default()) else {
        return;
    };
    let Some(n_row) = rows(reader.as_mut()) else {
        return;
    };
    let announced = reader.observation().n_row;
    assert_eq!(n_row, announced, "rows that are there are left out");
    // What is averaged was read just the same: now and then will do.
    if n_row % 8 != 0 {
        return;
    }
    let average = Averaging {
        time_s: Some(20.0),
        channels: None,
    };
    let options = ReadOptions {
        average,
        ..ReadOptions::default()
    };
    if let Ok(mut reader) = open_with(path, &options) {
        rows(reader.as_mut());
    }
}

/// Rows up to the end; nothing if there was an error or there are too many.
fn rows(reader: &mut dyn VisReader) -> Option<u64> {
    let mut chunk = VisChunk::new(64);
    let mut n_row = 0;
    while n_row < MAX_ROWS {
        match reader.read_chunk(&mut chunk) {
            Ok(0) => return Some(n_row),
            Ok(n) => n_row += n as u64,
            Err(_) => return None,
        }
        check(&chunk, reader);
    }
    None
}

/// What holds for every chunk, whatever it was read from.
fn check(chunk: &VisChunk, reader: &dyn VisReader) {
    assert_eq!(chunk.n_row, chunk.uvw_m_r.len());
    let n_value = chunk.n_row * chunk.values_per_row();
    assert_eq!(n_value, chunk.vis_jy_rfp.len());
    assert_eq!(n_value, chunk.weight_rfp.len());
    assert_eq!(n_value, chunk.flag_rfp.len());
    let seen = reader.observation();
    let mut places = chunk.ant1_r.iter().chain(&chunk.ant2_r);
    assert!(places.all(|&ant| (ant as usize) < seen.antennas.len()));
    let mut fields = chunk.field_r.iter();
    assert!(fields.all(|&field| (field as usize) < seen.fields.len()));
    let mut setups = chunk.freq_setup_r.iter();
    assert!(setups.all(|&s| seen.freq_setups[s as usize].freq_hz_f.len() == chunk.n_chan));
    assert!(chunk.uvw_m_r.iter().flatten().all(|x| x.is_finite()));
    let mut samples = chunk.vis_jy_rfp.iter().zip(&chunk.weight_rfp);
    assert!(samples.all(|(vis, weight)| vis.is_finite() && weight.is_finite() && *weight >= 0.0));
}
