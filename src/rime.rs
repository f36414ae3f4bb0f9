//! The measurement equation, one term a file: what a source adds to a visibility.
//!
//! The phase convention is that of [`vis2cat_formats`].

mod beam;
mod instrument;
mod predict;
pub mod shape;
mod smearing;
mod source;
mod spectrum;

pub use beam::{Beam, BeamError};
pub use instrument::{Extent, Instrument, InstrumentTerms};
pub use predict::{phase_turns, predict};
pub use smearing::{EARTH_RAD_PER_S, Smearing, pole_of, sinc};
pub use source::{Ray, Source};
pub use spectrum::{SpectralIndex, SpectralIndexError, Spectrum};
