//! A part of the unit cube of one source.

use super::MAX_DIM;

/// A box in the unit cube: what a search looks into. Its volume is its share of the prior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    low: [f64; MAX_DIM],
    high: [f64; MAX_DIM],
}

/// Share of the prior of the scale-length that is compact: below two standard deviations.
const COMPACT_SCALE: f64 = 0.977;
/// Share of the prior of the ellipticity that is compact: |e| below about 0.5.
const COMPACT_ELLIPTICITY: f64 = 0.8;

impl Window {
    /// The whole prior.
    pub const FULL: Self = Self {
        low: [0.0; MAX_DIM],
        high: [1.0; MAX_DIM],
    };

    /// All positions and flux densities, without the longest shapes.
    ///
    /// A thin disk of many arcseconds can bridge two sources and fit them better than a disk on
    /// either, so it would be found in their place. Sources that are so long lose a few per cent
    /// of their signal-to-noise ratio in a search without such shapes, and get them back when
    /// they are sampled by themselves.
    pub fn compact() -> Self {
        // The square maps onto the disc of ellipticities, squares onto discs of the same share.
        let margin = 0.5 * (1.0 - COMPACT_ELLIPTICITY.sqrt());
        Self {
            low: [0.0, 0.0, 0.0, 0.0, margin, margin, 0.0],
            high: [
                1.0,
                1.0,
                1.0,
                COMPACT_SCALE,
                1.0 - margin,
                1.0 - margin,
                1.0,
            ],
        }
    }

    /// The point of the window at `u` of the unit cube.
    pub fn place(&self, u: &[f64]) -> Vec<f64> {
        let ends = self.low.iter().zip(&self.high);
        ends.zip(u)
            .map(|((low, high), u)| low + u * (high - low))
            .collect()
    }

    /// ln of the share of the prior that lies in the window.
    pub fn log_volume(&self) -> f64 {
        (0..MAX_DIM)
            .map(|d| (self.high[d] - self.low[d]).ln())
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prior::EllipticityPrior;

    #[test]
    fn the_compact_window_holds_its_share_of_ellipticities() {
        let prior = EllipticityPrior::new(0.804, 0.0732, 0.2298);
        let limit = prior.quantile(COMPACT_ELLIPTICITY);
        let window = Window::compact();
        for i in 0..=20 {
            let at = window.place(&[0.5, 0.5, 0.5, 0.5, f64::from(i) / 20.0, 1.0]);
            let e = prior.from_unit(at[4], at[5]);
            assert!((e.e1.hypot(e.e2) - limit).abs() < 1e-9);
        }
        let share = COMPACT_SCALE * COMPACT_ELLIPTICITY;
        assert!((window.log_volume() - share.ln()).abs() < 1e-12);
        assert_eq!(Window::FULL.log_volume(), 0.0);
    }
}
