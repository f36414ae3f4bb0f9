//! The selected samples of an observation, resident or streamed again from the file.
//!
//! The samples are cut into blocks of [`BLOCK_LEN`] in file order, whatever the memory budget, so
//! that the same sums come out whether they are held or streamed.

mod answers;
mod confusion;
mod cross;
mod evaluate;
mod faint;
mod ingest;
mod memo;
mod noise;
mod open;
mod overview;
mod resident;
mod snr_map;
mod stream;
mod survey;
mod uv_profile;
mod views;

pub use cross::JointView;
pub use evaluate::Request;
pub use faint::Faint;
pub use noise::{DifferenceMethod, NoiseReport, NoiseUsed};
pub use open::OpenOptions;
pub use overview::Overview;
pub use snr_map::Extremes;
pub use survey::Survey;
pub use views::{EngineOptions, View, ViewRequest};

use std::sync::Arc;

use vis2cat_formats::{Field, Observation};

use crate::checkpoint::{Checkpoint, CheckpointError};
use crate::coords::Lm;
use crate::likelihood::VisBlock;
use crate::rime::shape::Profile;
use crate::rime::{Instrument, Source};

/// Samples in a block: 36 bytes each, so that a block stays in a core's second-level cache.
pub const BLOCK_LEN: usize = 8192;
/// Bytes that a sample takes in a block.
pub const SAMPLE_BYTES: usize = 3 * size_of::<f64>() + 3 * size_of::<f32>();

/// Blocks that are copied and sorted at a time, to fill facets (19 MB).
const FEW_BLOCKS: usize = 64;

/// Something went wrong on the way from the file to the samples.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The file.
    #[error(transparent)]
    Read(#[from] vis2cat_formats::ReadError),
    /// The field of view that is wanted cannot be looked at.
    #[error("the field of view is too wide for these data, try a smaller --fov: {0}")]
    Field(String),
    /// The checkpoint.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The file is fine but there is nothing in it that we could use.
    #[error("{path}: {what}")]
    Unusable {
        /// File.
        path: std::path::PathBuf,
        /// Why, and what to try.
        what: String,
    },
}

/// Counts and scales of the selected samples.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DataInfo {
    /// Rows of the files.
    pub n_row: u64,
    /// Rows selected that are no autocorrelations.
    pub n_row_used: u64,
    /// Stokes I samples used.
    pub n_sample: u64,
    /// Stokes I samples lost to flags.
    pub n_flagged: u64,
    /// First time stamp [MJD].
    pub first_mjd: f64,
    /// Last time stamp [MJD].
    pub last_mjd: f64,
    /// Weighted mean frequency [Hz].
    pub mean_freq_hz: f64,
    /// Longest baseline used [wavelength].
    pub max_uv: f64,
    /// Largest |w| used [wavelength].
    pub max_w: f64,
    /// Largest change of what a smearing loss is the sinc of, with direction cosines [turn].
    pub max_blur: f64,
    /// Width (standard deviation) of the response to a typical source at natural weight [rad].
    pub beam_rad: f64,
    /// Noise level of each file and where it comes from.
    pub noise: Vec<NoiseReport>,
}

/// The selected samples, less the sources found so far.
pub struct Dataset {
    observation: Observation,
    info: DataInfo,
    profile: Profile,
    store: Store,
    removed: Vec<Source>,
    /// Those that are subtracted by now: the others when the samples are needed.
    subtracted: Vec<Source>,
    checkpoint: Option<Checkpoint>,
    n_eval: u64,
    engine: EngineOptions,
    memory_bytes: f64,
    sizes: Vec<views::FacetSize>,
    uv_profile: uv_profile::UvProfile,
    instrument: Option<Arc<Instrument>>,
}

enum Store {
    Resident(resident::Resident),
    Streamed(Box<stream::Stream>),
}

impl Dataset {
    /// What the files are about.
    pub fn observation(&self) -> &Observation {
        &self.observation
    }

    /// Counts and scales.
    pub fn info(&self) -> &DataInfo {
        &self.info
    }

    /// True if the samples are streamed from the file in every pass.
    pub fn is_streamed(&self) -> bool {
        matches!(self.store, Store::Streamed(_))
    }

    /// The phase centre that the data are selected for.
    pub fn phase_centre(&self) -> &Field {
        &self.observation.fields[0]
    }

    /// Frequency that flux densities are given at [Hz]: the middle of the band where terms of the
    /// instrument are asked for, else the weighted mean.
    pub fn ref_freq_hz(&self) -> f64 {
        let instrument = self.instrument.as_ref();
        instrument.map_or(self.info.mean_freq_hz, |i| i.ref_freq_hz())
    }

    /// The primary beam at `lm`, in the middle of the band; none without a beam.
    pub fn beam_at(&self, lm: Lm) -> Option<f64> {
        self.instrument.as_ref().and_then(|i| i.beam_at(lm))
    }

    /// Points evaluated so far.
    pub fn n_eval(&self) -> u64 {
        self.n_eval
    }

    /// Sets the sources that are subtracted from the data before anything is evaluated.
    pub fn set_removed(&mut self, sources: Vec<Source>) {
        self.removed = sources;
    }

    fn subtract_removed(&mut self) {
        if self.subtracted == self.removed {
            return;
        }
        let models = with_profile(&self.removed, self.profile);
        match &mut self.store {
            Store::Resident(resident) => resident.set_removed(&models),
            Store::Streamed(stream) => stream.removed = models,
        }
        self.subtracted.clone_from(&self.removed);
    }

    /// As [`Dataset::for_each_batch`], a few blocks at a time: for those who copy them.
    fn for_few_blocks(&mut self, mut visit: impl FnMut(&[VisBlock])) -> Result<(), DatasetError> {
        self.for_each_batch(|blocks| blocks.chunks(FEW_BLOCKS).for_each(&mut visit))
    }

    /// Things of `bytes` bytes that fit the memory budget at a time, at least one.
    fn at_a_time(&self, bytes: usize) -> usize {
        (self.memory_bytes / bytes as f64).max(1.0) as usize
    }

    /// Calls `visit` with the samples less the removed sources, batches of blocks in file order.
    pub(crate) fn for_each_batch(
        &mut self,
        mut visit: impl FnMut(&[VisBlock]),
    ) -> Result<(), DatasetError> {
        self.subtract_removed();
        match &mut self.store {
            Store::Resident(resident) => visit(&resident.blocks),
            Store::Streamed(stream) => stream.for_each_batch(visit)?,
        }
        Ok(())
    }
}

/// The sources, each with the shape that all have.
fn with_profile(sources: &[Source], profile: Profile) -> Vec<(Source, Profile)> {
    sources.iter().map(|source| (*source, profile)).collect()
}

/// The sources with their flux density negated: subtracting these adds them.
fn negated(sources: &[Source]) -> Vec<Source> {
    sources
        .iter()
        .map(|source| Source {
            flux_jy: -source.flux_jy,
            ..*source
        })
        .collect()
}
