//! How the weight of the samples is spread over baseline lengths.

use std::f64::consts::PI;

use crate::rime::shape::{Ellipticity, Profile, QuadraticForm};

/// Bins per octave of baseline length.
const PER_OCTAVE: f64 = 8.0;
/// Bins: from below one wavelength to beyond any array.
const N_BIN: usize = 8 * 40;
/// Directions that an elliptical shape is averaged over.
const N_ANGLE: usize = 16;

/// Weight [Jy⁻²] and largest |w| by sqrt(u² + v²), in logarithmic bins. Directions are taken as evenly
/// covered.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct UvProfile {
    weight: Vec<f64>,
    max_w: Vec<f64>,
}

impl Default for UvProfile {
    fn default() -> Self {
        Self {
            weight: vec![0.0; N_BIN],
            max_w: vec![0.0; N_BIN],
        }
    }
}

/// A shape as the bins see it: mean of F and of F² over directions.
pub(super) struct Binned {
    mean: Vec<f64>,
    mean_square: Vec<f64>,
}

impl UvProfile {
    pub(super) fn add(&mut self, [u, v, w]: [f64; 3], weight: f64) {
        let octaves = (u * u + v * v).max(1.0).log2() * 0.5;
        let bin = ((octaves * PER_OCTAVE) as usize).min(N_BIN - 1);
        self.weight[bin] += weight;
        self.max_w[bin] = self.max_w[bin].max(w.abs());
    }

    /// Adds another with all its weights multiplied by `scale`.
    pub(super) fn add_scaled(&mut self, other: &Self, scale: f64) {
        for (weight, more) in self.weight.iter_mut().zip(&other.weight) {
            *weight += scale * more;
        }
        for (max_w, other) in self.max_w.iter_mut().zip(&other.max_w) {
            *max_w = max_w.max(*other);
        }
    }

    /// Y of a shape [Jy⁻²].
    pub(super) fn y(&self, shape: &Binned) -> f64 {
        let terms = self.weight.iter().zip(&shape.mean_square);
        terms.map(|(weight, square)| weight * square).sum()
    }

    /// The shape in every bin.
    pub(super) fn binned(&self, profile: Profile, scale_rad: f64, e: Ellipticity) -> Binned {
        let (form, shape) = (QuadraticForm::new(scale_rad, e), profile.shape());
        let (mut mean, mut mean_square) = (vec![0.0; N_BIN], vec![0.0; N_BIN]);
        let filled = (0..N_BIN).filter(|&bin| self.weight[bin] > 0.0);
        for (bin, angle) in filled.flat_map(|bin| (0..N_ANGLE).map(move |angle| (bin, angle))) {
            let (sin, cos) = (PI * (angle as f64 + 0.5) / N_ANGLE as f64).sin_cos();
            let uv = middle(bin);
            let factor = shape.factor(form.at(uv * cos, uv * sin));
            mean[bin] += factor / N_ANGLE as f64;
            mean_square[bin] += factor * factor / N_ANGLE as f64;
        }
        Binned { mean, mean_square }
    }

    /// The baseline length that the part `part` of the Y of a shape lies below [wavelength], and the
    /// largest |w| there.
    pub(super) fn reach(&self, shape: &Binned, part: f64) -> (f64, f64) {
        let terms = || (0..N_BIN).map(|bin| self.weight[bin] * shape.mean_square[bin]);
        let wanted = part * terms().sum::<f64>();
        let (mut sum, mut w) = (0.0, 0.0f64);
        for (bin, term) in terms().enumerate() {
            sum += term;
            w = w.max(self.max_w[bin]);
            if sum >= wanted {
                return (2f64.powf((bin + 1) as f64 / PER_OCTAVE), w);
            }
        }
        (2f64.powf(N_BIN as f64 / PER_OCTAVE), w)
    }

    /// Part of its signal-to-noise ratio that a source of one shape keeps under a round template, of
    /// which only baselines below `reach` [wavelength] are used.
    pub(super) fn seen(&self, source: &Binned, template: &Binned, reach: f64) -> f64 {
        let below = |bin: &usize| middle(*bin) < reach;
        let sum = |f: &dyn Fn(usize) -> f64| -> f64 {
            (0..N_BIN)
                .filter(below)
                .map(|bin| self.weight[bin] * f(bin))
                .sum()
        };
        let cross = sum(&|bin| source.mean[bin] * template.mean[bin]);
        let own = sum(&|bin| template.mean_square[bin]);
        let whole = (0..N_BIN).map(|bin| self.weight[bin] * source.mean_square[bin]);
        cross / (own * whole.sum::<f64>()).sqrt()
    }
}

/// Baseline length in the middle of a bin [wavelength].
fn middle(bin: usize) -> f64 {
    2f64.powf((bin as f64 + 0.5) / PER_OCTAVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_sees_itself_and_less_of_others() {
        let mut profile = UvProfile::default();
        (1..2000).for_each(|i| profile.add([100.0 * f64::from(i), 0.0, f64::from(i)], 1.0));
        let shape = |scale: f64, e1: f64| {
            let e = Ellipticity { e1, e2: 0.0 };
            profile.binned(Profile::Exponential, scale, e)
        };
        let (small, large, long) = (shape(2e-6, 0.0), shape(2e-5, 0.0), shape(2e-6, 0.7));
        let all = 1e9;
        let whole = profile.y(&shape(1e-12, 0.0));
        assert!((whole / 1999.0 - 1.0).abs() < 1e-6 && profile.y(&large) < 0.1 * whole);
        let mut twice = UvProfile::default();
        twice.add_scaled(&profile, 2.0);
        assert_eq!(twice.y(&small), 2.0 * profile.y(&small));
        assert!((profile.seen(&small, &small, all) - 1.0).abs() < 1e-12);
        assert!(profile.seen(&large, &small, all) < 0.8);
        let seen = profile.seen(&long, &small, all);
        assert!(seen < 0.999 && seen > 0.5);
        let (reach, w) = profile.reach(&small, 0.5);
        let half = profile.seen(&small, &small, reach);
        assert!((half * half - 0.5).abs() < 0.1, "{half}");
        assert!(w > 0.0 && w < 2000.0);
    }
}
