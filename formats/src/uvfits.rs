//! UVFITS: visibilities as FITS random groups, with AIPS tables.
//!
//! # Source
//! Greisen, "AIPS FITS File Format", AIPS Memo 117 (2009, revised to 2017), cited below as "memo";
//! FITS Standard 4.0, section 6.
//!
//! # What is read
//! Random groups of BITPIX -32, -64, 32, 16 or 8 with their parameters in any order, repeated ones
//! summed; regular axes COMPLEX, STOKES, FREQ, IF, RA and DEC in any order; tables `AIPS AN` (all
//! subarrays), `AIPS FQ`, `AIPS SU`. Baselines as 256·a1 + a2, as 2048·a1 + a2 + 65536 (decided row by
//! row) or as ANTENNA1, ANTENNA2, SUBARRAY. Without INTTIM the integration time is NaN.
//!
//! # Signs
//! UVFITS stores r(ant1) - r(ant2) and the data that belong to it: both are taken, and written, as
//! they stand. See the crate's page for the phase convention, which holds for them. On opening, some
//! rows are set against the antenna positions, and a warning tells of files that go the other way.
//!
//! # What is written
//! BITPIX -32; DATE, UU, VV and WW each as a value and its remainder, so that nearly all of an f64
//! survives in readers that sum repeated parameters (readers that do not lose 1e-7 of the value);
//! ANTENNA1, ANTENNA2 and SUBARRAY always and BASELINE only while every number is below 256, because
//! readers take the larger encoding for garbage; absolute antenna positions with ARRAYX = 0, which
//! every reader understands alike; the time scale under both its spellings, TIMESYS and TIMSYS. The
//! antenna table comes last: a file cut short anywhere is seen to be.
//!
//! # Not read
//! `FITAB` (visibilities in a table, NAXIS1 = 777777701), flag and calibration tables, spacecraft
//! orbits, per-source frequency offsets (a warning tells).

mod antennas;
mod axes;
mod baseline;
mod frame;
mod frequencies;
mod groups;
mod parameters;
mod plan;
mod reader;
mod sources;
mod tables;
mod writer;

pub use reader::UvfitsReader;
pub use writer::UvfitsWriter;

/// Speed of light [m/s], exact.
const C_M_S: f64 = 299_792_458.0;
