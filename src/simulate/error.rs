//! What can go wrong in a simulation, by whose problem it is.

use std::path::PathBuf;

use vis2cat_formats::WriteError;

/// A simulation could not be set up or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimulateError {
    /// The operating system refused to hand over a table.
    #[error("cannot read {path}")]
    Io {
        /// File.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A table of antennas is at fault.
    #[error("{path}: {place}: {what}")]
    Malformed {
        /// File.
        path: PathBuf,
        /// Line and column.
        place: String,
        /// Expected and found, and what to try.
        what: String,
    },
    /// What was asked for makes no sense.
    #[error("{what}")]
    Parameter {
        /// Expected and found, and what to try.
        what: String,
    },
    /// The Earth's orientation is not known for this time.
    #[error(
        "UT1-UTC is not known for {utc} (the built-in table runs from {first} to {last}); \
         choose another --start or give --ut1-utc"
    )]
    NoEarthOrientation {
        /// Time asked for.
        utc: String,
        /// First day of the table.
        first: String,
        /// Last day of the table.
        last: String,
    },
    /// The visibilities could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl SimulateError {
    /// A [`SimulateError::Parameter`] that says `what`.
    pub(super) fn parameter(what: impl Into<String>) -> Self {
        Self::Parameter { what: what.into() }
    }
}
