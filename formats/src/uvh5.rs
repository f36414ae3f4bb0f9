//! UVH5: the visibilities and metadata of pyuvdata's UVData as HDF5 datasets.
//!
//! # Source
//! La Plante and the pyuvdata team, "Memo: UVH5 file format" (2018, revised to version 1.2 of the
//! format), cited below as "memo"; the HDF5 layout of pyuvdata 3.2.
//!
//! # What is read
//! Shapes and phase centres as files before version 1.0 and since have them, told apart by what is
//! there and not by `version`; rows in any order; spectral windows of any lengths; visibilities as
//! compounds of integers or reals of any width and byte order; booleans as enumerations or whole
//! numbers; texts of fixed or variable length; members without a value. Filters: deflate, shuffle,
//! LZF and Fletcher32 are built in, others (bitshuffle) come as plugins of libhdf5.
//!
//! # Signs
//! UVH5 stores r(ant2) - r(ant1) and the data that belong to it; a [`VisChunk`](crate::VisChunk) has
//! baselines the other way. So (u, v, w) are negated and the data conjugated, both together and both
//! exactly, in reading and in writing: see the crate's page for why nothing else changes.
//!
//! # What is written
//! Version 1.2. Every array of visibilities is cut into chunks of whole rows of at most a megabyte.
//! flags, nsamples and all metadata of rows are shuffled and deflated, which makes them small;
//! visibilities are noise to a compressor (shuffle and deflate save a seventh of random ones and make
//! reading seven times slower) and stand as they are. Times in the file are Julian dates in an f64: 40 μs.
//!
//! # Limits
//! Sizes, types and places are checked here, but chunks are unpacked by libhdf5 (1.14.6), which does
//! not check that a packed chunk has as many bytes as it should: a file made for it can crash us.
//!
//! # Not read
//! Positions on the Moon, spectral windows of one polarization each, phase centres that move or are
//! none (drift scans): the error says what to do.

mod antennas;
mod apparent;
mod axes;
mod cube;
mod describe;
mod frequencies;
mod header;
mod layout;
mod nsamples;
mod phase_centres;
mod reader;
mod rows;
mod tile;
mod writer;

pub use reader::Uvh5Reader;
pub use writer::Uvh5Writer;
