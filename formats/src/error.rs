//! What can go wrong, by whose problem it is.

use std::path::PathBuf;

/// A visibility file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system refused.
    #[error("cannot read {path}")]
    Io {
        /// File.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is at fault.
    #[error("{path}: {place}: {what}")]
    Malformed {
        /// File.
        path: PathBuf,
        /// HDU or dataset, and keyword, group or row.
        place: String,
        /// Expected and found, and what to try.
        what: String,
    },
    /// The file may be fine; we cannot read it.
    #[error("{path}: {place}: {what}")]
    Unsupported {
        /// File.
        path: PathBuf,
        /// HDU or dataset, and keyword, group or row.
        place: String,
        /// What is not supported, and what to try.
        what: String,
    },
}

/// A visibility file could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The operating system refused.
    #[error("cannot write {path}")]
    Io {
        /// File.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is there already.
    #[error("{path} exists; use --overwrite to replace it")]
    Exists {
        /// File.
        path: PathBuf,
    },
    /// What was handed over does not fit the format or the observation.
    #[error("{path}: {what}")]
    Parameter {
        /// File.
        path: PathBuf,
        /// What does not fit.
        what: String,
    },
}
