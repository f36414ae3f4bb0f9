//! For which spectral indices a facet has grids, and what it takes sources in between for.
//!
//! X is a sum of (ν/ν0)^t over samples, an exponential of the tilt t, and sqrt(Y) the length of such: both are
//! on the polynomial through their values at a few tilts.
//!
//! # Formula
//! Of n Chebyshev nodes on |t| <= T, exp(t x) leaves out (T x)^n / (2^(n-1) n!) at most.

use std::f64::consts::PI;

/// Most of what is left out of a source at the ends of the band.
const LEFT_OUT_MAX: f64 = 5e-4;
/// Most grids: enough for three octaves and indices from -2.5 to 1.
pub(super) const TILTS_MAX: usize = 8;

/// Which spectral indices sources have.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TiltRange {
    /// Largest |[`Source::tilt`](crate::rime::Source::tilt)|.
    pub most: f64,
    /// Largest |ln(ν/ν0)| of the samples.
    pub half_band_ln: f64,
}

/// The tilts that there are grids for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tilts {
    nodes: [f64; TILTS_MAX],
    len: usize,
}

impl Tilts {
    /// As many as it takes.
    pub(super) fn new(range: TiltRange) -> Tilts {
        let reach = range.most * range.half_band_ln;
        let left_out = |n: usize| {
            let factorial: f64 = (1..=n).map(|i| i as f64).product();
            reach.powi(n as i32) / (2f64.powi(n as i32 - 1) * factorial)
        };
        let is_enough = |n: &usize| reach == 0.0 || left_out(*n) <= LEFT_OUT_MAX;
        let len = (1..TILTS_MAX).find(is_enough).unwrap_or(TILTS_MAX);
        let node = |i: usize| range.most * (PI * (i as f64 + 0.5) / len as f64).cos();
        let mut nodes = [0.0; TILTS_MAX];
        if len > 1 {
            nodes = std::array::from_fn(|i| if i < len { node(i) } else { 0.0 });
        }
        Tilts { nodes, len }
    }

    /// The tilts.
    pub(super) fn nodes(&self) -> &[f64] {
        &self.nodes[..self.len]
    }

    /// What the value at each counts at `tilt`: Lagrange's polynomials.
    pub(super) fn shares(&self, tilt: f64) -> [f64; TILTS_MAX] {
        let mut shares = [0.0; TILTS_MAX];
        for (i, share) in shares[..self.len].iter_mut().enumerate() {
            let others = (0..self.len).filter(|&j| j != i);
            let factor = |j: usize| (tilt - self.nodes[j]) / (self.nodes[i] - self.nodes[j]);
            *share = others.map(factor).product();
        }
        shares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_are_followed() {
        for (most, half_band_ln, len) in [
            (1.0, 0.41, 4),
            (1.0, 0.1, 3),
            (2.0, 0.005, 2),
            (1.75, 1.04, 7),
        ] {
            let range = TiltRange { most, half_band_ln };
            let tilts = Tilts::new(range);
            assert_eq!(tilts.nodes().len(), len, "{range:?}");
            for k in 0..=20 {
                let tilt = most * (f64::from(k) / 10.0 - 1.0);
                let values = tilts.nodes().iter().map(|t| (t * half_band_ln).exp());
                let sum: f64 = values.zip(tilts.shares(tilt)).map(|(v, s)| v * s).sum();
                let wanted = (tilt * half_band_ln).exp();
                assert!(
                    (sum - wanted).abs() < 1.1 * LEFT_OUT_MAX * wanted.max(1.0),
                    "{range:?} {tilt}"
                );
            }
        }
    }

    #[test]
    fn one_grid_does_where_indices_are_fixed() {
        let tilts = Tilts::new(TiltRange {
            most: 0.0,
            half_band_ln: 0.4,
        });
        assert_eq!((tilts.nodes(), tilts.shares(0.0)[0]), (&[0.0][..], 1.0));
    }
}
