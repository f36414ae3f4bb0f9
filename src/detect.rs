//! Detection: one-source posteriors with many modes, and which of these modes are sources.
//!
//! 1. The field is cut into `tiles`; those that can hold a source (`screen`) are explored by
//!    nested sampling (`explore`), the brightest first.
//! 2. Every mode of every tile becomes a `Mode`; duplicates are found by `mean_shift`.
//! 3. `accept` takes the strongest mode, subtracts it from the data, and looks again at the
//!    others: a mode that was only the sidelobe of a brighter source does not survive this.
//! 4. `refine` samples each source anew with all the others removed; `prune` takes out those
//!    that are only a part of a close neighbour; the tiles are screened again without them.
//! 5. `certify` weights the samples anew by all visibilities; sources that overlap are sampled
//!    again together (`joint`). Where probabilities are to tell, `select` has the last word.

mod accept;
mod certify;
mod coupling;
mod density;
mod explore;
mod joint;
mod leftover;
mod mean_shift;
mod mode;
mod pipeline;
mod prune;
mod queue;
mod refine;
mod screen;
mod select;
mod tiles;

pub use accept::Cuts;
pub use density::Census;
pub use explore::{SamplerFactory, SamplerSettings, Task};
pub use mode::{Mode, ModeSample, Status};
pub use pipeline::{Detected, Detection, Screening, Settings, detect};
pub use select::Likely;
pub use tiles::{Tile, field_of_view, side_for_basin, tiles};

use crate::dataset::DatasetError;
use crate::sampler::SamplerError;

/// Detection could not be completed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DetectError {
    /// The data can no longer be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A sampler cannot go on.
    #[error("in the region at l = {l_arcsec:.1} arcsec, m = {m_arcsec:.1} arcsec")]
    Sampler {
        /// Centre of the region [arcsec].
        l_arcsec: f64,
        /// Centre of the region [arcsec].
        m_arcsec: f64,
        /// Why.
        source: SamplerError,
    },
}

/// Looks on while detection runs.
pub trait Observer: Send {
    /// A stage of `n_step` steps begins.
    fn stage(&mut self, _name: &str, _n_step: u64) {}
    /// Steps of the stage done so far, and likelihood evaluations times samples so far.
    fn advance(&mut self, _n_done: u64, _n_eval: u64) {}
}

/// Nobody looks on.
pub struct NoObserver;
impl Observer for NoObserver {}
