//! Flags for what multiplies the model of a source; the same in the search and in simulations.

use clap::Args;

use crate::rime::{Beam, BeamError, InstrumentTerms, SpectralIndex};

/// Terms of the instrument, each off unless it is asked for.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(super) struct InstrumentArgs {
    /// Model time and bandwidth smearing
    #[arg(long)]
    pub(super) smearing: bool,
    /// Primary beam, by dish diameter: meerkat (L band), airy=13.5m, gaussian=13.5m or none; flux
    /// densities are then those outside the beam [default: none]
    #[arg(long, value_name = "BEAM")]
    pub(super) beam: Option<BeamChoice>,
    /// Spectral index of all sources; free (-1.7:0.3) or =LOW:HIGH if each has its own; flux densities are then
    /// those in the middle of the band [no value: -0.7] [default: the same in all channels]
    #[arg(
        long,
        value_name = "INDEX",
        num_args = 0..=1,
        default_missing_value = "-0.7",
        allow_negative_numbers = true
    )]
    pub(super) spectral_index: Option<SpectralIndex>,
}

/// A beam, or none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BeamChoice(pub(super) Option<Beam>);

impl std::str::FromStr for BeamChoice {
    type Err = BeamError;
    fn from_str(text: &str) -> Result<Self, BeamError> {
        if text == "none" {
            return Ok(Self(None));
        }
        text.parse().map(|beam| Self(Some(beam)))
    }
}

impl InstrumentArgs {
    /// The terms.
    pub(super) fn terms(&self) -> InstrumentTerms {
        InstrumentTerms {
            smearing: self.smearing,
            beam: self.beam.and_then(|choice| choice.0),
            spectral_index: self.spectral_index,
        }
    }
}
