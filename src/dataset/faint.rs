//! How many sources stay below a cut.

use std::f64::consts::FRAC_1_SQRT_2;

use super::Dataset;
use crate::prior::SourcePrior;
use crate::rime::Source;

/// Sources drawn from the prior to see how many of them stay below a cut.
const N_DRAW: usize = 1000;

/// A source of the prior, and whether it is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Faint {
    /// The source, at the phase centre.
    pub source: Source,
    /// Its Y [Jy⁻²].
    pub y: f64,
    /// Probability that it stays below the cut.
    pub probability: f64,
}

impl Faint {
    /// S² Y, the square of its signal-to-noise ratio.
    pub fn snr2(&self) -> f64 {
        self.source.flux_jy.powi(2) * self.y
    }
}

impl Dataset {
    /// `n` sources that cover `prior` evenly, each with the probability that it stays below a matched-filter
    /// signal-to-noise ratio of `cut`.
    ///
    /// A source of ratio ρ shows sqrt(ρ² + 2) on average, as its position follows the noise, with a
    /// scatter of 1.
    pub fn below(&self, cut: f64, prior: &SourcePrior, n: usize) -> Vec<Faint> {
        let faint = |source: Source| {
            let profile = &self.uv_profile;
            let y = profile.y(&profile.binned(self.profile, source.scale_rad, source.e));
            let snr2 = source.flux_jy * source.flux_jy * y;
            Faint {
                source,
                y,
                probability: 0.5 * puruspe::erfc(((snr2 + 2.0).sqrt() - cut) * FRAC_1_SQRT_2),
            }
        };
        prior.evenly(n).map(faint).collect()
    }

    /// Part of the sources of `prior` that are expected to stay below `cut`.
    pub fn part_below(&self, cut: f64, prior: &SourcePrior) -> f64 {
        let below = self.below(cut, prior, N_DRAW);
        below.iter().map(|faint| faint.probability).sum::<f64>() / N_DRAW as f64
    }
}
