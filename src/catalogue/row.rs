//! Rows of the tables, in radians and janskys.

use super::posterior::Summary;
use crate::coords::{Lm, RaDec};
use crate::detect::Status;
use crate::rime::Source;

/// A mean with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub err: f64,
}

impl Estimate {
    /// Not known.
    pub const MISSING: Self = Self {
        mean: f64::NAN,
        err: f64::NAN,
    };
}

impl Default for Estimate {
    fn default() -> Self {
        Self::MISSING
    }
}

/// What a user must know before trusting a row, as bits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flags(pub i32);

impl Flags {
    /// Fewer than [`Flags::N_EFF_LIMIT`] effective samples: means and errors are rough.
    pub const LOW_N_EFF: Self = Self(1);
    /// The mode touches the border of its tile or of the field: part of it may be missing.
    pub const AT_BORDER: Self = Self(2);
    /// The data hardly narrow the prior of the scale-length: size and shape are the prior's.
    pub const SHAPE_FROM_PRIOR: Self = Self(4);
    /// The flux density piles up at an end of its prior range: widen the prior.
    pub const FLUX_AT_LIMIT: Self = Self(8);
    /// The fast engine differs from the exact one by more than 1 in ln L somewhere (`Max_dlogL`).
    pub const ENGINES_DIFFER: Self = Self(16);
    /// Sampling was stopped early: means, errors and evidence are rough.
    pub const UNFINISHED: Self = Self(32);
    /// The source is coupled to one that it was not sampled jointly with: its errors are those for
    /// a fixed neighbour, and more than 5% too small.
    pub const CONDITIONAL: Self = Self(64);

    /// Effective samples below which [`Flags::LOW_N_EFF`] is set.
    pub const N_EFF_LIMIT: f64 = 100.0;

    /// Every bit with what it says, as the header of `CATALOGUE` documents it.
    pub const MEANING: [(Self, &'static str); 7] = [
        (Self::LOW_N_EFF, "fewer than 100 effective samples"),
        (
            Self::AT_BORDER,
            "the mode touches the border of its tile or of the field",
        ),
        (
            Self::SHAPE_FROM_PRIOR,
            "size and shape are hardly narrower than their prior",
        ),
        (
            Self::FLUX_AT_LIMIT,
            "the flux density piles up at an end of its prior",
        ),
        (
            Self::ENGINES_DIFFER,
            "fast and exact ln L differ by more than 1 (Max_dlogL)",
        ),
        (Self::UNFINISHED, "sampling was stopped early: all is rough"),
        (
            Self::CONDITIONAL,
            "coupled to a source it was not sampled with: errors too small",
        ),
    ];

    /// These bits and those of `other`.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all bits of `other` are set.
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// One source of `CATALOGUE`.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceRow {
    /// Name after the position, see [`source_name`](super::source_name).
    pub name: String,
    /// Number within this catalogue, from 1.
    pub source_id: i64,
    /// Sources with the same number, that of the brightest, were sampled jointly: row k of each in
    /// `POSTERIOR` is one joint draw.
    pub group_id: i64,
    /// The mode in `MODES` that this source came from.
    pub mode_id: i64,
    /// Position, flux density and shape.
    pub posterior: Summary,
    /// Posterior mean of S sqrt(Y), the signal-to-noise ratio in the visibility domain.
    pub snr: f64,
    /// X / sqrt(Y) at the best sample.
    pub snr_peak: f64,
    /// Local log evidence against no source, and its error.
    pub log_z: Estimate,
    /// Probability that this is a source.
    pub p_source: f64,
    /// Probability that it is, and brighter than the flux cut; NaN where nobody asked.
    pub p_above: f64,
    /// The primary beam there; NaN where none was applied.
    pub pb_gain: f64,
    /// Largest difference of ln L, exact minus fast engine; NaN if there was no exact pass.
    pub max_dlog_l: f64,
    /// What to be careful about.
    pub flags: Flags,
    /// First row in `POSTERIOR`, from 0.
    pub post_row: i64,
    /// Number of rows in `POSTERIOR`.
    pub post_n: i64,
}

/// One mode of `MODES`.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeRow {
    /// Number of the mode.
    pub mode_id: i64,
    /// Tile in which it was found.
    pub tile_id: i64,
    /// Mean position.
    pub position: RaDec,
    /// Standard deviation of the position, the larger of both axes [rad].
    pub position_sigma_rad: f64,
    /// Mean direction cosines.
    pub lm: Lm,
    /// Total flux density [Jy].
    pub flux_jy: Estimate,
    /// As in [`SourceRow`].
    pub snr: f64,
    /// As in [`SourceRow`].
    pub snr_peak: f64,
    /// As in [`SourceRow`].
    pub log_z: Estimate,
    /// As in [`SourceRow`]; NaN where the evidence is out of date or another mode has it.
    pub p_source: f64,
    /// Number of samples.
    pub n_samples: i64,
    /// Effective number of samples.
    pub n_eff: f64,
    /// Kept, or why not.
    pub status: Status,
    /// The source it became, or whose duplicate it is.
    pub source_id: Option<i64>,
}

/// One line of `RUN`: an option, a version, a count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunEntry {
    /// Name, such as `sampler.n_live`.
    pub key: String,
    /// Value as text.
    pub value: String,
    /// Unit and meaning.
    pub comment: String,
}

impl RunEntry {
    /// An entry.
    pub fn new(key: &str, value: impl std::fmt::Display, comment: &str) -> Self {
        Self {
            key: key.to_owned(),
            value: value.to_string(),
            comment: comment.to_owned(),
        }
    }
}

/// One sample of `POSTERIOR`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosteriorRow {
    /// The source.
    pub source_id: i64,
    /// Its mode.
    pub mode_id: i64,
    /// Weight; those of one source sum to 1.
    pub weight: f64,
    /// ln L - ln L0.
    pub log_l: f64,
    /// Position on the sky.
    pub position: RaDec,
    /// The parameters.
    pub source: Source,
    /// Axes at half maximum, and position angle.
    pub ellipse: super::Ellipse,
}
