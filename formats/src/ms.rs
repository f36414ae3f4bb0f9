//! Measurement Sets, version 2: the visibilities and all about them as casacore tables.
//!
//! # Source
//! Kemball & Wieringa, "MeasurementSet definition version 2.0" (casacore note 229), cited below as
//! "note"; what CASA, pyuvdata and others make of it.
//!
//! # What is read
//! One column of visibilities, `CORRECTED_DATA` where it is filled and `DATA` otherwise, or the one
//! asked for; flags of samples, rows and antennas; any number of fields, spectral windows and data
//! descriptions. A row is of one spectral window, so windows become frequency set-ups; they may be of
//! any lengths, and the rows of a chunk have one length. All rows must have the same correlations.
//!
//! # Weights
//! The first of these that is there and filled: `WEIGHT_SPECTRUM`, `WEIGHT` for all channels alike,
//! 1/`SIGMA_SPECTRUM`², 1/`SIGMA`². Writers differ in what these are worth (`WEIGHT` is the weight
//! of a channel to CASA and the sum over channels to its importer of UVFITS), so the noise level is
//! better measured.
//!
//! # Signs
//! The note contradicts itself on which way baselines run. CASA, and pyuvdata after it, store
//! r(ANTENNA1) - r(ANTENNA2), as a [`VisChunk`](crate::VisChunk) has them: nothing is turned round in
//! reading or writing. A file whose coordinates go against the antenna positions is told of.
//!
//! # What is written
//! All the tables and columns that the note requires, `DATA` and `WEIGHT_SPECTRUM`, in tiles of many
//! rows. An IF becomes a spectral window, and what was one row of several IFs as many rows. Antennas
//! are known by their row, so that their numbers start at 0. `OBSERVATION.TELESCOPE_LOCATION` is
//! pyuvdata's.
//!
//! # Not read
//! Single-dish data (`FLOAT_DATA`), phase centres that move (polynomials, ephemerides) or are in
//! frames other than J2000, B1950 and ICRS, subtables outside of the set, sets of several parts
//! (concatenated tables).

mod antennas;
mod columns;
mod corrs;
mod describe;
mod fields;
mod layout;
mod reader;
mod rows;
mod samples;
mod tables;
mod windows;
mod writer;

pub use reader::MsReader;
pub use writer::MsWriter;

/// Seconds of a day: tables have times in seconds.
const DAY_S: f64 = 86_400.0;

/// Most rows of a subtable that are read.
const MAX_SUBTABLE_ROWS: u64 = 1 << 20;
