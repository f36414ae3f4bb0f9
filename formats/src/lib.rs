//! Streaming readers and writers for radio-interferometer visibility files.
//!
//! A reader fills a caller-owned [`VisChunk`] again and again; memory does not depend on the size
//! of the file. What a file is about (antennas, frequencies, phase centres) is its [`Observation`].
//!
//! # Formats
//! | format | read | write | how it is known |
//! |---|---|---|---|
//! | UVFITS (random groups, AIPS Memo 117) | [`UvfitsReader`] | [`UvfitsWriter`] | `SIMPLE` and `GROUPS = T` |
//! | UVH5 (pyuvdata's HDF5, all versions) | [`Uvh5Reader`] | [`Uvh5Writer`] | HDF5 signature, groups `Header` and `Data` |
//! | Measurement Set 2 (casacore tables; feature `ms`) | [`MsReader`] | [`MsWriter`] | a directory with `table.dat` |
//! | UVFITS in a table (AIPS `FITAB`) | no: an error names it | no | `NAXIS1 = 777777701` |
//!
//! [`open`] goes by what stands in a file, never by its name; [`create`] goes by the extension. [`stokes_i`] makes total intensity of
//! whatever correlations there are, with the weights that belong to it.
//!
//! # The phase convention
//! Written once, here. With (u, v, w) **as held in a [`VisChunk`] beside the data**, in wavelengths,
//! a source of flux density S at direction cosines l (east), m (north), n = sqrt(1 - l² - m²) adds
//!
//! ```text
//! V(u, v, w) = S exp(+2πi (u l + v m + w (n - 1)))
//! ```
//!
//! The formats differ in the sense of a baseline and conjugate the data with it, so this holds for
//! each of them with the stored values.
//!
//! # The sense of a baseline
//! In a [`VisChunk`] (u, v, w) are those of r(ant1) - r(ant2), as in UVFITS and in Measurement Sets. UVH5 has them the other way:
//! its reader and its writer negate (u, v, w) and conjugate the data, always both, which changes signs
//! only, loses nothing, and leaves the phase convention as it is. Beyond that nothing is turned round:
//! a file whose coordinates go against its own format is told of in a warning, not repaired.

mod average;
#[cfg(feature = "ms")]
mod casa;
mod chunk;
mod concat;
mod create;
mod date;
mod direction;
mod error;
pub mod fits;
mod frame;
mod h5;
#[cfg(feature = "ms")]
mod ms;
mod observation;
mod odd;
mod open;
mod pending;
#[cfg(feature = "ms")]
mod pending_dir;
mod reader;
mod select;
mod stokes;
mod uvfits;
mod uvh5;
mod window;

pub use average::{Averaged, Averaging};
pub use chunk::VisChunk;
pub use concat::Concatenated;
pub use create::create;
pub use error::{ReadError, WriteError};
#[cfg(feature = "ms")]
pub use ms::{MsReader, MsWriter};
pub use observation::{
    Antenna, Corr, EarthOrientation, Field, Frame, FreqSetup, MsNotes, Observation, TimeScale,
    Uvh5Notes,
};
pub use open::{ReadOptions, is_measurement_set, open, open_all, open_with};
pub use pending::PendingFile;
pub use reader::{VisReader, VisWriter};
pub use select::{Selected, Selection};
pub use stokes::{NoStokesI, StokesIRule, stokes_i};
pub use uvfits::{UvfitsReader, UvfitsWriter};
pub use uvh5::{Uvh5Reader, Uvh5Writer};
pub use window::Window;
