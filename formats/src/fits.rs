//! What visibilities need of FITS, with no radio meaning.
//!
//! Structure first: [`scan`] walks the raw 2880-byte blocks, reads every header and proves that each
//! HDU fits into the file, before anything is allocated or any other code sees a byte. Only then
//! are binary tables handed, one at a time and from memory, to CFITSIO ([`table`]), which converts
//! and scales their cells. The payload of a random-groups HDU is read by its format, as a stream.
//!
//! # Source
//! FITS Standard 4.0 (IAU FITS Working Group, 2018): section 3 structure, 4 headers, 6 random
//! groups, 7.3 binary tables.

pub(crate) mod card;
mod cfitsio;
pub(crate) mod header;
pub(crate) mod scan;
pub(crate) mod table;
pub(crate) mod tform;

/// Bytes in a FITS block (Standard, section 3.1).
pub(crate) const BLOCK_BYTES: usize = 2880;
/// Bytes in a header card (Standard, section 4.1).
pub(crate) const CARD_BYTES: usize = 80;

/// `bytes` rounded up to whole blocks; `None` on overflow.
pub(crate) fn padded(bytes: u64) -> Option<u64> {
    bytes
        .div_ceil(BLOCK_BYTES as u64)
        .checked_mul(BLOCK_BYTES as u64)
}
