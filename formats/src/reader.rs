//! The two traits that every format stands behind.

use crate::{Observation, ReadError, VisChunk, WriteError};

/// Reads a visibility file from front to back, as often as wanted.
///
/// | function | meaning |
/// |---|---|
/// | `observation` | what the rows have in common; known as soon as the file is open |
/// | `read_chunk` | the next rows into the caller's chunk; 0 rows is the end |
/// | `rewind` | the next read starts from the first row again |
/// | `n_row_read` | rows of the file that are done, wanted or not: for progress |
pub trait VisReader: Send {
    /// What the rows have in common.
    fn observation(&self) -> &Observation;

    /// Fills `chunk` with the next rows, at most `chunk.max_row`, and returns how many came.
    ///
    /// # Errors
    /// The file is damaged or cannot be read; the error names HDU or dataset, row and field.
    fn read_chunk(&mut self, chunk: &mut VisChunk) -> Result<usize, ReadError>;

    /// Goes back to the first row.
    ///
    /// # Errors
    /// The file cannot be positioned any more.
    fn rewind(&mut self) -> Result<(), ReadError>;

    /// Rows taken from the file since its start, of the `n_row` of the observation.
    fn n_row_read(&self) -> u64;
}

/// Writes a visibility file chunk by chunk.
///
/// The file stands under its final name only after `finish`.
pub trait VisWriter {
    /// Appends the rows of `chunk`, whose shape must be that of the observation.
    ///
    /// # Errors
    /// The chunk does not fit the observation or the device is full.
    fn write_chunk(&mut self, chunk: &VisChunk) -> Result<(), WriteError>;

    /// Completes the file and moves it to its final name.
    ///
    /// # Errors
    /// The rows announced and written differ, or the file cannot be completed.
    fn finish(self: Box<Self>) -> Result<(), WriteError>;
}
