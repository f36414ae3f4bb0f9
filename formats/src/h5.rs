//! What this package needs of HDF5 over libhdf5, with no radio meaning.
//!
//! Structure first: a dataset is looked at (shape, type, layout, filters, bytes in the file) and its
//! size proven to be in the file before anything of that size is allocated. All input and output is
//! the library's. What leads out of the file, or needs a filter that is not there, is refused with
//! an error that says what to do.
//!
//! libhdf5 is not made for threads: the crate over it holds one lock for the whole process.
//!
//! # Source
//! HDF5 File Format Specification 3.0; HDF5 1.14 Reference Manual.

mod chunks;
mod collections;
mod dataset;
mod filter;
mod group;
mod lzf;
mod names;
mod number;
mod raw;
mod raw_file;
mod text;
mod unpack;
mod write;

pub(crate) use chunks::Plain;
pub(crate) use dataset::{Dataset, Kind};
pub(crate) use group::Group;
pub(crate) use write::{Growing, NewFile, NewGroup, Packing};

/// What to do about a file that is damaged.
const COPY_AGAIN: &str = "the file is damaged or truncated: copy it again";

/// The library's words, in one line.
fn words(error: &hdf5::Error) -> String {
    error.to_string().replace('\n', " ")
}

/// Whether another process has the file for itself.
fn is_locked(error: &hdf5::Error) -> bool {
    words(error).contains("unable to lock file")
}

/// What cannot be read, and what to do about it.
fn unreadable(error: &hdf5::Error) -> String {
    let words = words(error);
    // What every part of a file says first is the version of its layout.
    let advice = if words.contains("bad version number") {
        "it is damaged, or of a newer layout than HDF5 1.14 knows: rewrite it with h5repack --high=v114"
    } else if is_locked(error) {
        "another program writes it, or its file system has no locks: wait, or set HDF5_USE_FILE_LOCKING=FALSE"
    } else {
        COPY_AGAIN
    };
    format!("cannot be read ({words}); {advice}")
}
