//! Scale-length: a truncated log-normal whose median may follow the flux density.

use serde::{Deserialize, Serialize};

use crate::normal;
use crate::units::{ARCSEC, MICROJY};

/// How the median scale-length depends on the flux density.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScaleRelation {
    /// mean of ln(α/arcsec) = intercept + slope ln(S/µJy).
    #[default]
    FluxDependent,
    /// mean of ln(α/arcsec) = constant, as in the paper.
    Paper,
}

/// ln α is normal about `mean_log`, truncated to [low, high].
///
/// # Source
/// Malyali et al. (2018), section 3.2: standard deviation 0.3136; the flux-dependent relation is
/// that of the simulated populations (Rivi et al. 2016).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScalePrior {
    /// Shortest [rad].
    pub low_rad: f64,
    /// Longest [rad].
    pub high_rad: f64,
    /// Standard deviation of ln α.
    pub sigma_log: f64,
    /// Mean of ln(α/arcsec) at 1 µJy.
    pub intercept: f64,
    /// Growth of that mean with ln(S/µJy); 0 = independent of the flux density.
    pub slope: f64,
}

impl ScalePrior {
    /// Inverse of the cumulative distribution at flux density `flux_jy`; [rad].
    pub fn from_unit(&self, u: f64, flux_jy: f64) -> f64 {
        let tail = Tail::new(self, flux_jy);
        let alpha = (self.log_median(flux_jy) + self.sigma_log * tail.z(u)).exp() * ARCSEC;
        alpha.clamp(self.low_rad, self.high_rad)
    }

    /// The cumulative distribution at flux density `flux_jy`: the inverse of
    /// [`ScalePrior::from_unit`].
    pub fn to_unit(&self, scale_rad: f64, flux_jy: f64) -> f64 {
        Tail::new(self, flux_jy).unit(self.z(scale_rad, flux_jy))
    }

    /// ln of the median [arcsec], were there no ends.
    fn log_median(&self, flux_jy: f64) -> f64 {
        self.intercept + self.slope * (flux_jy / MICROJY).ln()
    }

    /// Standard deviations above the median.
    fn z(&self, scale_rad: f64, flux_jy: f64) -> f64 {
        ((scale_rad / ARCSEC).ln() - self.log_median(flux_jy)) / self.sigma_log
    }
}

/// The part of a normal distribution between two ends, by the tail that keeps its digits: both ends
/// may lie far above the mean.
struct Tail {
    /// Probabilities below the ends or, if the ends lie above the mean, above them.
    ends: [f64; 2],
    is_upper: bool,
}

impl Tail {
    fn new(prior: &ScalePrior, flux_jy: f64) -> Self {
        let ends = [prior.low_rad, prior.high_rad].map(|rad| prior.z(rad, flux_jy));
        let is_upper = ends[0] > 0.0;
        let ends = ends.map(|z| normal::cdf(if is_upper { -z } else { z }));
        Self { ends, is_upper }
    }

    fn z(&self, u: f64) -> f64 {
        let [low, high] = self.ends;
        let z = normal::quantile(low + u * (high - low));
        if self.is_upper { -z } else { z }
    }

    fn unit(&self, z: f64) -> f64 {
        let [low, high] = self.ends;
        (normal::cdf(if self.is_upper { -z } else { z }) - low) / (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRIOR: ScalePrior = ScalePrior {
        low_rad: 0.1 * ARCSEC,
        high_rad: 10.0 * ARCSEC,
        sigma_log: 0.3136,
        intercept: -0.93,
        slope: 0.33,
    };

    #[test]
    fn the_median_follows_the_relation() {
        let alpha = PRIOR.from_unit(0.5, 100e-6) / ARCSEC;
        assert!((alpha.ln() - (-0.93 + 0.33 * 100f64.ln())).abs() < 1e-6);
    }

    #[test]
    fn one_sigma_quantiles_are_one_sigma_away() {
        let at = |u| (PRIOR.from_unit(u, 50e-6) / ARCSEC).ln();
        assert!((at(0.841_344_746) - at(0.5) - 0.3136).abs() < 1e-5);
        assert!((at(0.5) - at(0.158_655_254) - 0.3136).abs() < 1e-5);
    }

    #[test]
    fn ends_are_the_truncation_even_far_from_the_mean() {
        for prior in [
            PRIOR,
            ScalePrior {
                low_rad: 5.0 * ARCSEC,
                ..PRIOR
            },
        ] {
            assert!((prior.from_unit(0.0, 20e-6) / prior.low_rad - 1.0).abs() < 1e-3);
            assert!(prior.from_unit(1.0, 20e-6) <= prior.high_rad);
            let values: Vec<f64> = (0..=100)
                .map(|i| prior.from_unit(f64::from(i) / 100.0, 20e-6))
                .collect();
            assert!(values.windows(2).all(|w| w[0] <= w[1]));
            for (i, value) in values.iter().enumerate() {
                let u = prior.to_unit(*value, 20e-6);
                assert!((u - i as f64 / 100.0).abs() < 1e-6, "{u} {i}");
            }
        }
    }
}
