//! The spectrum of sources: power laws.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Indices beyond this are mistakes.
const MOST_INDEX: f64 = 10.0;

/// What is known of spectral indices β, S ∝ ν^β: one for all sources, or a range in which each has its own.
///
/// Written `-0.7`, `-1.5:0.5`, or `free` for a range of one to either side of -0.7, which is typical of
/// synchrotron radiation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Text", into = "String")]
pub struct SpectralIndex {
    low: f64,
    high: f64,
}

impl SpectralIndex {
    /// Whatever radio sources usually have.
    const FREE: Self = Self {
        low: -1.7,
        high: 0.3,
    };
    /// The same flux density at all frequencies.
    pub const FLAT: Self = Self {
        low: 0.0,
        high: 0.0,
    };

    /// Lowest and highest index.
    pub fn ends(self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The middle of the range.
    pub fn middle(self) -> f64 {
        f64::midpoint(self.low, self.high)
    }

    /// Half the width of the range: 0 where the index is fixed.
    pub fn half_width(self) -> f64 {
        0.5 * (self.high - self.low)
    }

    /// True where each source has its own index.
    pub fn is_free(self) -> bool {
        self.high > self.low
    }
}

/// A text that is no spectral index.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{0}' is no spectral index; use a number from -10 to 10 like -0.7, a range like -1.5:0.5, or free"
)]
pub struct SpectralIndexError(String);

impl FromStr for SpectralIndex {
    type Err = SpectralIndexError;
    fn from_str(text: &str) -> Result<Self, SpectralIndexError> {
        if text == "free" {
            return Ok(Self::FREE);
        }
        let number = |text: &str| text.trim().parse::<f64>().ok();
        let (low, high) = text.split_once(':').unwrap_or((text, text));
        match (number(low), number(high)) {
            (Some(low), Some(high)) if -MOST_INDEX <= low && low <= high && high <= MOST_INDEX => {
                Ok(Self { low, high })
            }
            _ => Err(SpectralIndexError(text.into())),
        }
    }
}

impl fmt::Display for SpectralIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_free() {
            write!(f, "{}:{}", self.low, self.high)
        } else {
            write!(f, "{}", self.low)
        }
    }
}

/// How a configuration file may spell it.
#[derive(Deserialize)]
#[serde(untagged)]
enum Text {
    Number(f64),
    Text(String),
}

impl TryFrom<Text> for SpectralIndex {
    type Error = SpectralIndexError;
    fn try_from(text: Text) -> Result<Self, SpectralIndexError> {
        match text {
            Text::Number(index) => index.to_string().parse(),
            Text::Text(text) => text.parse(),
        }
    }
}

impl From<SpectralIndex> for String {
    fn from(index: SpectralIndex) -> Self {
        index.to_string()
    }
}

/// S(ν) = S (ν/ν0)^β.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrum {
    /// Spectral index β of sources without a tilt of their own.
    pub index: f64,
    /// Frequency that flux densities are given at [Hz].
    pub ref_freq_hz: f64,
}

impl Spectrum {
    /// Flux density at `freq_hz` over that at the reference frequency, of a source whose index is larger by
    /// `tilt`.
    pub fn factor(self, freq_hz: f64, tilt: f64) -> f64 {
        (freq_hz / self.ref_freq_hz).powf(self.index + tilt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steep_spectrum_is_fainter_at_high_frequencies() {
        let spectrum = Spectrum {
            index: -0.5,
            ref_freq_hz: 1.4e9,
        };
        assert_eq!(spectrum.factor(1.4e9, -0.2), 1.0);
        assert!((spectrum.factor(2.8e9, -0.2) - 0.615_572_206_672_458).abs() < 1e-14);
    }

    #[test]
    fn an_index_is_a_number_or_a_range() {
        let parse = |text: &str| text.parse::<SpectralIndex>();
        let fixed = parse("-0.7").unwrap();
        assert!(!fixed.is_free() && fixed.middle() == -0.7);
        let free = parse("-1.5:0.5").unwrap();
        assert_eq!((free.middle(), free.half_width()), (-0.5, 1.0));
        assert_eq!(parse("free"), parse("-1.7:0.3"));
        for index in [fixed, free] {
            assert_eq!(parse(&index.to_string()), Ok(index));
        }
        for wrong in ["", "steep", "0.5:-1.5", "-0.7:", "nan", "11"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
