//! Moments and quantiles of weighted samples.

use std::f64::consts::PI;

use super::super::row::Estimate;
use super::ellipse::half_turn;

/// Weights that sum to 1.
pub(super) struct Weights(Vec<f64>);

impl Weights {
    /// Normalised exp(log w); `None` if all are zero or one is not a number.
    pub(super) fn from_logs(logs: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        let largest = logs.clone().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = logs.map(|log_w| (log_w - largest).exp()).collect();
        let sum: f64 = weights.iter().sum();
        (largest.is_finite() && sum.is_finite())
            .then(|| Self(weights.iter().map(|w| w / sum).collect()))
    }

    /// One weight a sample.
    pub(super) fn each(&self) -> &[f64] {
        &self.0
    }

    /// (Σ w)² / Σ w² (Kish 1965).
    pub(super) fn n_eff(&self) -> f64 {
        1.0 / self.0.iter().map(|w| w * w).sum::<f64>()
    }

    /// Σ w x; samples without weight do not count, whatever their value.
    fn mean(&self, values: impl Iterator<Item = f64>) -> f64 {
        let weighted = self.0.iter().zip(values).filter(|(w, _)| **w > 0.0);
        weighted.map(|(w, x)| w * x).sum()
    }

    /// Mean and standard deviation.
    pub(super) fn estimate(&self, values: impl Iterator<Item = f64> + Clone) -> Estimate {
        let mean = self.mean(values.clone());
        let variance = self.mean(values.map(|x| (x - mean).powi(2)));
        Estimate {
            mean,
            err: variance.sqrt(),
        }
    }
}

/// Pearson's correlation of two parameters; NaN where one does not vary.
pub(super) fn correlation(
    weights: &Weights,
    x: impl Iterator<Item = f64> + Clone,
    y: impl Iterator<Item = f64> + Clone,
) -> f64 {
    let (x_est, y_est) = (weights.estimate(x.clone()), weights.estimate(y.clone()));
    let product = x.zip(y).map(|(x, y)| (x - x_est.mean) * (y - y_est.mean));
    let covariance = weights.mean(product);
    // A spread of rounding errors is no spread.
    let varies = |e: Estimate| e.err > 1e-12 * e.mean.abs();
    if varies(x_est) && varies(y_est) {
        (covariance / (x_est.err * y_est.err)).clamp(-1.0, 1.0)
    } else {
        f64::NAN
    }
}

/// The value below which a fraction `q` of the weight lies: linear between the samples, each of which
/// stands at the middle of its own weight.
pub(super) fn quantile(weights: &Weights, values: &[f64], q: f64) -> f64 {
    let mut sorted: Vec<(f64, f64)> = (values.iter().copied())
        .zip(weights.each().iter().copied())
        .filter(|(_, w)| *w > 0.0)
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = 0.0;
    let mut last: Option<(f64, f64)> = None;
    for (value, weight) in sorted {
        let middle = below + 0.5 * weight;
        if middle >= q {
            return match last {
                Some((x, p)) => x + (value - x) * (q - p) / (middle - p),
                None => value,
            };
        }
        below += weight;
        last = Some((value, middle));
    }
    last.map_or(f64::NAN, |(value, _)| value)
}

/// Circular mean and standard deviation [rad] of axes, which repeat after π; NaN counts for nothing.
///
/// With R the mean resultant length of the doubled angles the deviation is sqrt(-2 ln R)/2, at most
/// π/sqrt(12), that of axes in all directions. (Mardia & Jupp 2000, section 2.3.)
pub(super) fn circular_axis(
    weights: &Weights,
    angles: &(impl Iterator<Item = f64> + Clone),
) -> Estimate {
    let known = weights.mean(angles.clone().map(|a| f64::from(!a.is_nan())));
    if known <= 0.0 {
        return Estimate::MISSING;
    }
    let part = |f: fn(f64) -> f64| {
        let parts = angles.clone().map(|a| f(2.0 * a));
        weights.mean(parts.map(|x| if x.is_nan() { 0.0 } else { x })) / known
    };
    let (cos, sin) = (part(f64::cos), part(f64::sin));
    let resultant = cos.hypot(sin).min(1.0);
    Estimate {
        mean: half_turn(0.5 * sin.atan2(cos)),
        err: (0.5 * (-2.0 * resultant.ln()).max(0.0).sqrt()).min(PI / 12.0_f64.sqrt()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::DEG;

    fn equal(n: usize) -> Weights {
        Weights::from_logs(std::iter::repeat_n(-700.0, n)).unwrap()
    }

    #[test]
    fn a_uniform_grid_has_uniform_quantiles() {
        let values: Vec<f64> = (0..1000).map(|i| (f64::from(i) + 0.5) / 1000.0).collect();
        let w = equal(1000);
        for q in [0.16, 0.5, 0.84] {
            assert!((quantile(&w, &values, q) - q).abs() < 1e-12);
        }
        assert!((w.n_eff() - 1000.0).abs() < 1e-6);
        let estimate = w.estimate(values.iter().copied());
        assert!((estimate.err - 1.0 / 12.0_f64.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn quantiles_follow_the_weights_and_not_the_order() {
        let w = Weights::from_logs([0.9_f64.ln(), 0.1_f64.ln()].into_iter()).unwrap();
        assert_eq!(quantile(&w, &[5.0, 1.0], 0.01), 1.0);
        assert_eq!(quantile(&w, &[5.0, 1.0], 0.99), 5.0);
        assert_eq!(quantile(&equal(1), &[3.0], 0.16), 3.0);
    }

    #[test]
    fn axes_on_both_sides_of_north_average_to_north() {
        let angles = [2.0 * DEG, 178.0 * DEG];
        let mean = circular_axis(&equal(2), &angles.into_iter());
        assert!(mean.mean.min(PI - mean.mean) < 1e-12);
        assert!((mean.err / DEG - 2.0).abs() < 0.01);
    }

    #[test]
    fn axes_in_all_directions_have_the_largest_error() {
        let angles = (0..180).map(|i| f64::from(i) * DEG);
        let spread = circular_axis(&equal(180), &angles);
        assert!((spread.err - PI / 12.0_f64.sqrt()).abs() < 1e-12);
        let circles = circular_axis(&equal(3), &[f64::NAN; 3].into_iter());
        assert!(circles.mean.is_nan() && circles.err.is_nan());
    }

    #[test]
    fn correlation_is_exact_on_a_line_and_nan_on_a_constant() {
        let x = [1.0, 2.0, 4.0];
        let w = equal(3);
        let down = correlation(&w, x.into_iter(), x.into_iter().map(|x| -3.0 * x));
        assert!((down + 1.0).abs() < 1e-12);
        assert!(correlation(&w, x.into_iter(), [0.1; 3].into_iter()).is_nan());
    }

    #[test]
    fn a_sample_without_weight_does_not_count() {
        let w = Weights::from_logs([0.0, f64::NEG_INFINITY].into_iter()).unwrap();
        let estimate = w.estimate([2.0, f64::INFINITY].into_iter());
        assert_eq!((estimate.mean, estimate.err), (2.0, 0.0));
    }
}
