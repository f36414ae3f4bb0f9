//! Blends: elliptical Gaussians that overlap, all six parameters of each unknown.
//!
//! The data are the blend itself without noise, in units of it, so that the posterior peaks at the
//! truth:
//!
//! ```text
//! ln L = -1/2 |Σ_i g_i - Σ_k t_k|²,    ⟨g_a, g_b⟩ = 4π S_a S_b N(c_a - c_b; C_a + C_b)
//! ```
//!
//! with C = 1 + α² [[1 + e1, e2], [e2, 1 - e1]]: a point of flux S is seen with the width 1 and has the
//! signal-to-noise ratio S. Priors are like those of galaxies: flat for place and flux, log-normal for
//! the size, and peaked at round shapes. All is in z = Φ⁻¹(u), in which the prior is a normal one.

use crate::normal;
use nalgebra::{Matrix2, Vector2};

/// Parameters of a component: x, y, S, ln α, e1, e2.
const N_PARAM: usize = 6;
/// Range of x and y about the component's true place, and of S.
const SIDE: f64 = 1.5;
const MOST_FLUX: f64 = 100.0;
/// Standard deviation of ln α, about α = 1.
const LOG_SIZE: f64 = 0.3;
/// Largest |e1| and |e2|.
const MOST_E: f64 = 0.6;
/// Distance of neighbours.
const SPACING: f64 = 3.0;

/// A blend of components in a row.
#[derive(Debug, Clone, PartialEq)]
pub struct Blend {
    truth: Vec<Component>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Component {
    centre: Vector2<f64>,
    flux: f64,
    /// α².
    size2: f64,
    /// Covariance of the shape over α².
    form: Matrix2<f64>,
}

impl Component {
    fn new([x, y, flux, log_size, e1, e2]: [f64; N_PARAM]) -> Self {
        Self {
            centre: Vector2::new(x, y),
            flux,
            size2: (2.0 * log_size).exp(),
            form: Matrix2::new(1.0 + e1, e2, e2, 1.0 - e1),
        }
    }

    fn covariance(&self) -> Matrix2<f64> {
        Matrix2::identity() + self.size2 * self.form
    }

    /// ⟨a, b⟩, and its derivatives by the parameters of a.
    fn overlap(&self, other: &Self) -> (f64, [f64; N_PARAM]) {
        let covariance = self.covariance() + other.covariance();
        let determinant = covariance.determinant();
        let inverse = Matrix2::new(
            covariance.m22,
            -covariance.m12,
            -covariance.m21,
            covariance.m11,
        ) / determinant;
        let apart = self.centre - other.centre;
        let pull = inverse * apart;
        let value =
            2.0 * self.flux * other.flux / determinant.sqrt() * (-0.5 * apart.dot(&pull)).exp();
        let by_form = |change: Matrix2<f64>| {
            0.5 * value * (pull.dot(&(change * pull)) - (inverse * change).trace())
        };
        let slope = [
            -value * pull.x,
            -value * pull.y,
            value / self.flux,
            by_form(2.0 * self.size2 * self.form),
            by_form(self.size2 * Matrix2::new(1.0, 0.0, 0.0, -1.0)),
            by_form(self.size2 * Matrix2::new(0.0, 1.0, 1.0, 0.0)),
        ];
        (value, slope)
    }
}

impl Blend {
    /// `count` components in a row, their fluxes, sizes and shapes in turn.
    pub fn new(count: usize) -> Self {
        let component = |(k, z): (usize, &[f64])| at(k, z).0;
        let peak: Vec<f64> = (0..count).flat_map(true_component).collect();
        Self {
            truth: peak
                .chunks_exact(N_PARAM)
                .enumerate()
                .map(component)
                .collect(),
        }
    }

    /// Dimensions.
    pub fn n_dim(&self) -> usize {
        N_PARAM * self.truth.len()
    }

    /// The peak of the likelihood, in z.
    pub fn peak(&self) -> Vec<f64> {
        (0..self.truth.len()).flat_map(true_component).collect()
    }

    /// ln L of one point of the unit cube.
    pub fn log_l(&self, u: &[f64]) -> f64 {
        self.log_l_and_slope(&Self::to_z(u)).0
    }

    /// From z to the unit cube.
    pub fn to_u(z: &[f64]) -> Vec<f64> {
        z.iter().map(|&z| normal::cdf(z)).collect()
    }

    /// From the unit cube to z.
    pub fn to_z(u: &[f64]) -> Vec<f64> {
        u.iter().map(|&u| normal::quantile(u)).collect()
    }

    /// ln L of one point in z, and its derivatives by z.
    pub fn log_l_and_slope(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let model: Vec<(Component, [f64; N_PARAM])> = (z.chunks_exact(N_PARAM).enumerate())
            .map(|(k, z)| at(k, z))
            .collect();
        let mut log_l = 0.0;
        let mut slope = vec![0.0; z.len()];
        for ((a, by_z), slope) in model.iter().zip(slope.chunks_exact_mut(N_PARAM)) {
            let of_model = model.iter().map(|(b, _)| (-0.5, -1.0, b));
            let of_truth = self.truth.iter().map(|b| (1.0, 1.0, b));
            for (part, sign, b) in of_model.chain(of_truth) {
                let (value, by) = a.overlap(b);
                log_l += part * value;
                for ((slope, by), by_z) in slope.iter_mut().zip(by).zip(by_z) {
                    *slope += sign * by * by_z;
                }
            }
        }
        let truth = self.truth.iter();
        let power = truth.flat_map(|a| self.truth.iter().map(|b| a.overlap(b).0));
        (log_l - 0.5 * power.sum::<f64>(), slope)
    }
}

/// The truth of component `k`, in z.
fn true_component(k: usize) -> [f64; N_PARAM] {
    let turn = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    [0.0, 0.1 * turn, 0.2 * turn, 0.3 * turn, 0.8 * turn, 0.5]
}

/// Component `k` at z, and the derivatives of its parameters by z.
fn at(k: usize, z: &[f64]) -> (Component, [f64; N_PARAM]) {
    let flat = |i: usize| normal::cdf(z[i]);
    let density = |i: usize| (-0.5 * z[i] * z[i]).exp() / std::f64::consts::TAU.sqrt();
    let bounded = |i: usize| MOST_E * z[i] / (4.0 + z[i] * z[i]).sqrt();
    let by_bounded = |i: usize| 4.0 * MOST_E / (4.0 + z[i] * z[i]).powf(1.5);
    let component = Component::new([
        SPACING * k as f64 + SIDE * (flat(0) - 0.5),
        SIDE * (flat(1) - 0.5),
        MOST_FLUX * flat(2),
        LOG_SIZE * z[3],
        bounded(4),
        bounded(5),
    ]);
    let by_z = [
        SIDE * density(0),
        SIDE * density(1),
        MOST_FLUX * density(2),
        LOG_SIZE,
        by_bounded(4),
        by_bounded(5),
    ];
    (component, by_z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_the_truth_and_slopes_are_those_of_differences() {
        let blend = Blend::new(3);
        let mut z = blend.peak();
        let (log_l, slope) = blend.log_l_and_slope(&z);
        assert!(log_l.abs() < 1e-9 && slope.iter().all(|s| s.abs() < 1e-8));
        for (i, z) in z.iter_mut().enumerate() {
            *z += 0.1 * (i as f64).sin();
        }
        let (log_l, slope) = blend.log_l_and_slope(&z);
        assert!(log_l < -1.0);
        assert!((blend.log_l(&Blend::to_u(&z)) - log_l).abs() < 1e-6);
        for (i, slope) in slope.into_iter().enumerate() {
            let at = |step: f64| {
                let mut z = z.clone();
                z[i] += step;
                blend.log_l_and_slope(&z).0
            };
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!(
                (slope - difference).abs() < 1e-5 * (1.0 + difference.abs()),
                "{i}: {slope} {difference}"
            );
        }
    }

    #[test]
    fn a_point_has_its_flux_as_snr() {
        let point = Component::new([0.0, 0.0, 7.0, -20.0, 0.0, 0.0]);
        assert!((point.overlap(&point).0 - 49.0).abs() < 1e-9);
    }
}
