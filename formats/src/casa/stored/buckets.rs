//! Files that are cut into buckets of the same length, after a header.

use super::stream::Stream;

/// Where buckets begin.
pub(super) const HEADER_BYTES: u64 = 512;
/// Bytes of the number with which a bucket begins.
const START_BYTES: u64 = 8;
/// A bucket has fewer: casacore has 28 bits for a place in one.
const MAX_BYTES: u64 = 1 << 28;
/// Most buckets that are to be in memory at once; two, where nobody has asked for more.
const MAX_CACHED: u32 = 1 << 20;

/// How a file is cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct Buckets {
    /// Bytes of each.
    pub(super) n_byte: u64,
    pub(super) n: u64,
    /// How many the file has room for.
    pub(super) n_there: u64,
}

impl Buckets {
    /// Reads it where a header says so, in a file of so many bytes. casacore makes room for a number for each bucket,
    /// and for those that are to be in memory.
    pub(super) fn read(stream: &mut Stream, file_bytes: u64) -> Result<Self, String> {
        let (n_byte, n) = (u64::from(stream.u32()?), u64::from(stream.u32()?));
        let n_cached = stream.u32()?;
        if !(START_BYTES + 1..MAX_BYTES).contains(&n_byte) {
            return Err(format!("its buckets have {n_byte} bytes"));
        }
        // The last ones may not have been written.
        if n > file_bytes || (n > 0 && n_byte > file_bytes) {
            return Err(format!(
                "announces {n} buckets of {n_byte} bytes, has {file_bytes} bytes"
            ));
        }
        if n_cached > MAX_CACHED {
            return Err(format!("wants {n_cached} buckets in memory at once"));
        }
        let n_there = file_bytes / n_byte;
        Ok(Self { n_byte, n, n_there })
    }

    /// Where a bucket begins in the file.
    pub(super) fn start(&self, bucket: u64) -> u64 {
        HEADER_BYTES + bucket * self.n_byte
    }
}
