//! Flux density: a power law between two ends.

/// p(S) ∝ S^index on [low, high].
///
/// # Source
/// Malyali et al. (2018): index -1.34, the VLA SWIRE deep field (Owen & Morrison 2008).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluxPrior {
    /// Faint end [Jy].
    pub low_jy: f64,
    /// Bright end [Jy].
    pub high_jy: f64,
    /// Exponent of the power law.
    pub index: f64,
}

impl FluxPrior {
    /// Inverse of the cumulative distribution.
    ///
    /// # Formula
    /// S = [low^g + u (high^g - low^g)]^(1/g), g = index + 1; low (high/low)^u at g = 0.
    pub fn from_unit(&self, u: f64) -> f64 {
        let g = self.index + 1.0;
        let ratio = self.high_jy / self.low_jy;
        if g.abs() < 1e-9 {
            return self.low_jy * ratio.powf(u);
        }
        self.low_jy * (1.0 + u * (ratio.powf(g) - 1.0)).powf(1.0 / g)
    }

    /// The cumulative distribution: the inverse of [`FluxPrior::from_unit`].
    pub fn to_unit(&self, flux_jy: f64) -> f64 {
        let g = self.index + 1.0;
        let (ratio, above) = (self.high_jy / self.low_jy, flux_jy / self.low_jy);
        if g.abs() < 1e-9 {
            return above.ln() / ratio.ln();
        }
        (above.powf(g) - 1.0) / (ratio.powf(g) - 1.0)
    }

    /// Mean flux density [Jy], by the mid-point rule over the unit interval.
    pub fn mean_jy(&self) -> f64 {
        let n = 10_000;
        (0..n)
            .map(|i| self.from_unit((f64::from(i) + 0.5) / f64::from(n)))
            .sum::<f64>()
            / f64::from(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_median_are_those_of_the_power_law() {
        let prior = FluxPrior {
            low_jy: 10e-6,
            high_jy: 200e-6,
            index: -1.34,
        };
        assert!((prior.from_unit(0.0) - 10e-6).abs() < 1e-18);
        assert!((prior.from_unit(1.0) - 200e-6).abs() < 1e-16);
        // Closed form: (10^-0.34 + 200^-0.34)/2 to the power -1/0.34.
        let median = f64::midpoint(10f64.powf(-0.34), 200f64.powf(-0.34)).powf(-1.0 / 0.34);
        assert!((prior.from_unit(0.5) * 1e6 - median).abs() < 1e-9);
    }

    #[test]
    fn the_way_back_leads_to_the_start() {
        for index in [-1.34, -1.0, 0.5] {
            let prior = FluxPrior {
                low_jy: 10e-6,
                high_jy: 200e-6,
                index,
            };
            for u in [0.0, 0.1, 0.7, 1.0] {
                assert!((prior.to_unit(prior.from_unit(u)) - u).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn index_minus_one_is_uniform_in_the_logarithm() {
        let prior = FluxPrior {
            low_jy: 1.0,
            high_jy: 100.0,
            index: -1.0,
        };
        assert!((prior.from_unit(0.5) - 10.0).abs() < 1e-9);
    }
}
