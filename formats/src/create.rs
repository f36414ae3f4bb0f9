//! Which writer a path needs, by its extension.

use std::path::Path;

use crate::uvfits::UvfitsWriter;
use crate::uvh5::Uvh5Writer;
use crate::{Observation, VisWriter, WriteError};

/// Starts a visibility file: a Measurement Set if the name ends in `.ms`, UVH5 if in `.uvh5`, UVFITS
/// otherwise.
///
/// # Errors
/// The target exists and `overwrite` is false, its folder cannot be written, or the observation
/// cannot be put into a file of that format.
pub fn create(
    path: &Path,
    observation: &Observation,
    overwrite: bool,
) -> Result<Box<dyn VisWriter>, WriteError> {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("ms") => create_measurement_set(path, observation, overwrite),
        Some("uvh5") => Ok(Box::new(Uvh5Writer::create(path, observation, overwrite)?)),
        _ => Ok(Box::new(UvfitsWriter::create(
            path,
            observation,
            overwrite,
        )?)),
    }
}

#[cfg(feature = "ms")]
fn create_measurement_set(
    path: &Path,
    observation: &Observation,
    overwrite: bool,
) -> Result<Box<dyn VisWriter>, WriteError> {
    let writer = crate::ms::MsWriter::create(path, observation, overwrite)?;
    Ok(Box::new(writer))
}

#[cfg(not(feature = "ms"))]
fn create_measurement_set(
    path: &Path,
    _: &Observation,
    _: bool,
) -> Result<Box<dyn VisWriter>, WriteError> {
    Err(WriteError::Parameter {
        path: path.to_owned(),
        what: "this build writes no Measurement Sets: build with the feature `ms`".to_owned(),
    })
}
