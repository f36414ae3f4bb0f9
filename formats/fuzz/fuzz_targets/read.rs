//! What is done with every input.

use std::path::Path;

use vis2cat_formats::{Averaging, ReadOptions, VisChunk, open_with};

/// Most rows that are read: an input that says it has more than it holds must be an error before.
const MAX_ROWS: usize = 1 << 16;

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

/// Reads to the end or the first error, as it is and averaged.
pub fn path(path: &Path) {
    for time_s in [None, Some(20.0)] {
        let options = ReadOptions {
            average: Averaging {
                time_s,
                channels: None,
            },
            ..ReadOptions::default()
        };
        let Ok(mut reader) = open_with(path, &options) else {
            return;
        };
        let mut chunk = VisChunk::new(64);
        let mut n_row = 0;
        while n_row < MAX_ROWS {
            match reader.read_chunk(&mut chunk) {
                Ok(0) | Err(_) => break,
                Ok(n) => n_row += n,
            }
            assert_eq!(chunk.n_row, chunk.uvw_m_r.len());
            assert_eq!(chunk.n_row * chunk.values_per_row(), chunk.vis_jy_rfp.len());
        }
    }
}
