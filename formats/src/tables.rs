//! FITS binary tables, written and read: no radio meaning here.
//!
//! Specification: the FITS Standard 4.0 (Pence et al. 2010, A&A 524, A42, and the 2018 edition of the
//! IAU FITS working group), sections 4 (headers), 7.3 (binary tables) and appendix J (checksums).
//!
//! Written: a primary HDU without data, then any number of `BINTABLE`s of scalar columns and fixed
//! strings, with `TUNITn`, `TUCDn` and `TCOMMn` (the last two are what TOPCAT and STILTS read) and
//! `CHECKSUM`/`DATASUM` in every HDU. The bytes depend on what is written and on nothing else: no
//! clock, no library version. That, and a file that gets its name only when it is whole, is why the
//! bytes are laid out here and not by CFITSIO, which dates its checksums.
//!
//! Read: scalar columns of any `BINTABLE` with `TSCALn`, `TZEROn`, `TNULLn` applied. Array and
//! variable-length columns are listed but have no values; compressed files are not read.

mod card;
mod checksum;
mod encode;
mod pending;
mod read;
#[cfg(test)]
mod round_trip;
mod table;

pub use card::{Keyword, Value};
pub use encode::{prepare_tables, write_tables};
pub use pending::{PendingFile, refuse_existing};
pub use read::{ReadColumn, Table, is_fits, read_table};
pub use table::{Cards, Column, ColumnData, TableSpec};

/// Length of a header or data block [bytes] (FITS 4.0 section 3.1).
const BLOCK: usize = 2880;
/// Length of a header card [bytes] (FITS 4.0 section 3.3.1).
const CARD: usize = 80;
