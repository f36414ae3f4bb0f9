//! Ellipticity: a tabulated distribution of |e|, any orientation.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use crate::rime::shape::Ellipticity;

const N_TABLE: usize = 2048;

/// p(e) ∝ e (1 - exp((e - e_max)/a)) / ((1 + e) sqrt(e² + e0²)) on [0, e_max].
///
/// # Source
/// Malyali et al. (2018), section 3.2, fitted to VLA-COSMOS (Rivi et al. 2016): e_max = 0.804,
/// e0 = 0.0732, a = 0.2298.
#[derive(Debug, Clone, PartialEq)]
pub struct EllipticityPrior {
    e_max: f64,
    /// Cumulative distribution at i/(N_TABLE - 1) of e_max.
    cdf: Vec<f64>,
}

impl EllipticityPrior {
    /// The distribution with these constants.
    pub fn new(e_max: f64, e_0: f64, a: f64) -> Self {
        let step = e_max / (N_TABLE - 1) as f64;
        let density =
            |e: f64| e * -((e - e_max) / a).exp_m1() / ((1.0 + e) * (e * e + e_0 * e_0).sqrt());
        let mut cdf = vec![0.0; N_TABLE];
        for i in 1..N_TABLE {
            let e = i as f64 * step;
            let simpson = density(e - step) + 4.0 * density(e - 0.5 * step) + density(e);
            cdf[i] = cdf[i - 1] + simpson * step / 6.0;
        }
        let total = cdf[N_TABLE - 1];
        for p in &mut cdf {
            *p /= total;
        }
        Self { e_max, cdf }
    }

    /// |e| at cumulative probability `p`.
    pub fn quantile(&self, p: f64) -> f64 {
        let i = self.cdf.partition_point(|&c| c < p).clamp(1, N_TABLE - 1);
        let (c0, c1) = (self.cdf[i - 1], self.cdf[i]);
        let step = self.e_max / (N_TABLE - 1) as f64;
        // The density starts linearly, so the first cell's cumulative is a parabola.
        let t = ((p - c0) / (c1 - c0)).clamp(0.0, 1.0);
        let t = if i == 1 { t.sqrt() } else { t };
        (i as f64 - 1.0 + t) * step
    }

    /// Cumulative probability of |e|: the inverse of [`EllipticityPrior::quantile`].
    fn probability(&self, e: f64) -> f64 {
        let place = e / self.e_max * (N_TABLE - 1) as f64;
        let i = (place as usize + 1).clamp(1, N_TABLE - 1);
        let t = (place - (i as f64 - 1.0)).clamp(0.0, 1.0);
        let t = if i == 1 { t * t } else { t };
        self.cdf[i - 1] + t * (self.cdf[i] - self.cdf[i - 1])
    }

    /// The point of the unit square: the inverse of [`EllipticityPrior::from_unit`].
    pub fn to_unit(&self, e: Ellipticity) -> [f64; 2] {
        let radius = self.probability(e.modulus()).sqrt();
        let (x, y) = if e.e1.abs() > e.e2.abs() {
            let x = radius * e.e1.signum();
            (x, x * (e.e2 / e.e1).atan() / FRAC_PI_4)
        } else if e.e2 == 0.0 {
            (0.0, 0.0)
        } else {
            let y = radius * e.e2.signum();
            (y * (e.e1 / e.e2).atan() / FRAC_PI_4, y)
        };
        [0.5 * (x + 1.0), 0.5 * (y + 1.0)]
    }

    /// Ellipticity at (u, v) of the unit square.
    ///
    /// The square is first mapped onto the disc by the concentric map of Shirley & Chiu (1997),
    /// which keeps areas and neighbours: no seam at orientation zero, no crowding at e = 0, so
    /// that a compact posterior is compact in the unit cube too.
    pub fn from_unit(&self, u: f64, v: f64) -> Ellipticity {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        if x == 0.0 && y == 0.0 {
            return Ellipticity::default();
        }
        let (radius, angle) = if x.abs() > y.abs() {
            (x, FRAC_PI_4 * (y / x))
        } else {
            (y, FRAC_PI_2 - FRAC_PI_4 * (x / y))
        };
        // Area is uniform on the disc, so radius² is the cumulative probability.
        let e = self.quantile((radius * radius).min(1.0)) * radius.signum();
        Ellipticity {
            e1: e * angle.cos(),
            e2: e * angle.sin(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cosmos() -> EllipticityPrior {
        EllipticityPrior::new(0.804, 0.0732, 0.2298)
    }

    #[test]
    fn the_distribution_has_the_published_shape() {
        let prior = cosmos();
        // Quadrature of the density to 0.2 done independently in closed trapezium sums.
        let density = |e: f64| {
            2.57837 * e * (1.0 - ((e - 0.804) / 0.2298f64).exp())
                / ((1.0 + e) * (e * e + 0.0732f64.powi(2)).sqrt())
        };
        let n = 200_000;
        let p: f64 = (0..n)
            .map(|i| density((f64::from(i) + 0.5) * 0.2 / f64::from(n)) * 0.2 / f64::from(n))
            .sum();
        assert!(
            (prior.quantile(p) - 0.2).abs() < 1e-4,
            "{} at {p}",
            prior.quantile(p)
        );
        assert!((prior.quantile(1.0) - 0.804).abs() < 1e-9);
    }

    #[test]
    fn orientation_is_uniform_and_modulus_follows_the_quantiles() {
        let prior = cosmos();
        let n = 400;
        let (mut e1, mut e2, mut below) = (0.0, 0.0, 0);
        let median = prior.quantile(0.5);
        for i in 0..n {
            for j in 0..n {
                let e = prior.from_unit(
                    (f64::from(i) + 0.5) / f64::from(n),
                    (f64::from(j) + 0.5) / f64::from(n),
                );
                e1 += e.e1;
                e2 += e.e2;
                below += i32::from(e.e1.hypot(e.e2) < median);
            }
        }
        let total = f64::from(n * n);
        assert!((e1 / total).abs() < 1e-3 && (e2 / total).abs() < 1e-3);
        assert!((f64::from(below) / total - 0.5).abs() < 5e-3);
    }

    #[test]
    fn the_way_back_leads_to_the_start() {
        let prior = cosmos();
        for u in [0.0, 0.1, 0.3, 0.499, 0.5, 0.501, 0.9, 1.0] {
            for v in [0.0, 0.2, 0.4, 0.5, 0.51, 0.7, 1.0] {
                let [x, y] = prior.to_unit(prior.from_unit(u, v));
                assert!((x - u).hypot(y - v) < 1e-6, "({u}, {v}): ({x}, {y})");
            }
        }
    }

    #[test]
    fn neighbours_stay_neighbours_across_the_diagonals() {
        let prior = cosmos();
        for t in [0.1, 0.3, 0.45, 0.55, 0.8, 0.95] {
            for (u, v) in [(t, t), (t, 1.0 - t)] {
                let (a, b) = (prior.from_unit(u + 1e-9, v), prior.from_unit(u - 1e-9, v));
                assert!((a.e1 - b.e1).hypot(a.e2 - b.e2) < 1e-5);
            }
        }
    }
}
