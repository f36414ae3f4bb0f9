//! How fast a file is read and how much memory that takes: `read_speed FILE [ROWS_A_CHUNK]`.
//!
//! Prints a line of JSON: bytes of the file, rows, seconds of the fastest of five passes (the
//! first brings the file into the page cache), MB/s, and the peak memory of the process [MB] where
//! the system tells.

#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use vis2cat_formats::{VisChunk, open};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = Path::new(
        arguments
            .first()
            .ok_or("usage: read_speed FILE [ROWS_A_CHUNK]")?,
    );
    let max_row = arguments.get(1).map_or(Ok(4096), |rows| rows.parse())?;
    let bytes = bytes_of(path)?;
    let mut best_s = f64::INFINITY;
    let mut n_row = 0;
    let mut weight_sum = 0.0;
    for _ in 0..5 {
        let start = Instant::now();
        let mut reader = open(path)?;
        let mut chunk = VisChunk::new(max_row);
        n_row = 0;
        weight_sum = 0.0;
        while reader.read_chunk(&mut chunk)? > 0 {
            n_row += chunk.n_row;
            weight_sum += f64::from(chunk.weight_rfp[0]);
        }
        best_s = best_s.min(start.elapsed().as_secs_f64());
    }
    let line = serde_json::json!({
        "bytes": bytes,
        "rows": n_row,
        "seconds": best_s,
        "mb_per_s": bytes as f64 / 1e6 / best_s,
        "peak_mb": peak_mb(),
        "weight_sum": weight_sum,
    });
    println!("{line}");
    Ok(())
}

/// Bytes of a file, or of all files of a directory.
fn bytes_of(path: &Path) -> std::io::Result<u64> {
    if !path.is_dir() {
        return Ok(std::fs::metadata(path)?.len());
    }
    std::fs::read_dir(path)?
        .map(|entry| bytes_of(&entry?.path()))
        .sum()
}

/// Linux keeps the peak resident set in kB.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace()
        .nth(1)?
        .parse::<f64>()
        .ok()
        .map(|kb| kb / 1e3)
}
