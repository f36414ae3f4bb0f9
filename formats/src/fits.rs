//! What this package needs of FITS, with no radio meaning.
//!
//! Reading, structure first: `scan` walks the raw 2880-byte blocks, reads every header and proves
//! that each HDU fits into the file, before anything is allocated or any other code sees a byte. Only
//! then are binary tables handed, one at a time and from memory, to CFITSIO, which converts and
//! scales their cells. The payload of a random-groups HDU is read by its format, as a stream.
//!
//! Writing: headers are laid out here, cells and sums are CFITSIO's, again in memory. The bytes depend
//! on what is written and on nothing else, and a file gets its name only when it is whole.
//!
//! # What is not CFITSIO's
//! * Headers of files. Some keywords that it acts upon make CFITSIO 3.49 divide by zero, so it is
//!   only shown headers that come from here.
//! * Headers that are written. It cuts reals to 15 digits and dates its checksums; and some readers
//!   want `EXTNAME` before the columns, where it has it behind.
//!
//! # Source
//! FITS Standard 4.0 (IAU FITS Working Group, 2018): section 3 structure, 4 headers, 6 random
//! groups, 7.3 binary tables, appendix J checksums.

mod card;
mod cfitsio;
pub(crate) mod header;
#[cfg(test)]
mod round_trip;
pub(crate) mod scan;
mod spec;
mod table;
mod tform;
mod write;

pub use crate::pending::{PendingFile, refuse_existing};
pub use card::{Cards, Keyword, Value};
pub use spec::{Column, ColumnData, TableSpec};
pub use table::{ReadColumn, Table, find_table, is_fits, read_table};
pub use write::{prepare_tables, write_tables};

pub(crate) use write::extensions;

/// Bytes in a block (Standard, section 3.1).
pub(crate) const BLOCK_BYTES: usize = 2880;
/// Bytes in a header card (Standard, section 4.1).
pub(crate) const CARD_BYTES: usize = 80;

/// `bytes` rounded up to whole blocks; `None` on overflow.
fn padded(bytes: u64) -> Option<u64> {
    bytes.checked_next_multiple_of(BLOCK_BYTES as u64)
}
