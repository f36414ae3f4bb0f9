//! Scale-length: a truncated log-normal whose median may follow the flux density.

use serde::{Deserialize, Serialize};

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
        let mean_log = self.intercept + self.slope * (flux_jy / MICROJY).ln();
        let z = |rad: f64| ((rad / ARCSEC).ln() - mean_log) / self.sigma_log;
        let (z_low, z_high) = (z(self.low_rad), z(self.high_rad));
        // Work in the tail that keeps its digits: both ends may lie far above the mean.
        let z = if z_low > 0.0 {
            let (q_low, q_high) = (normal_cdf(-z_low), normal_cdf(-z_high));
            -normal_quantile(q_low + u * (q_high - q_low))
        } else {
            let (p_low, p_high) = (normal_cdf(z_low), normal_cdf(z_high));
            normal_quantile(p_low + u * (p_high - p_low))
        };
        let alpha = (mean_log + self.sigma_log * z).exp() * ARCSEC;
        alpha.clamp(self.low_rad, self.high_rad)
    }
}

fn normal_cdf(z: f64) -> f64 {
    puruspe::erfc(-z / std::f64::consts::SQRT_2) / 2.0
}

fn normal_quantile(p: f64) -> f64 {
    -std::f64::consts::SQRT_2 * puruspe::inverfc(2.0 * p)
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
        }
    }
}
