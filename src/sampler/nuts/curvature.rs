//! The curvature of ln p, by differences.

use nalgebra::{DMatrix, DVector};

/// Length of a difference, in standard deviations of the seeds.
const STEP: f64 = 0.3;
/// Least curvature that is believed, in units of that of the seeds.
const LEAST: f64 = 3e-3;

/// Where ln p is wanted: about a point, along its coordinates.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curvature {
    centre: DVector<f64>,
    step: DVector<f64>,
}

impl Curvature {
    /// About `centre`, where seeds are `width` wide.
    pub(super) fn new(centre: &DVector<f64>, width: &DVector<f64>) -> Self {
        Self {
            centre: centre.clone(),
            step: STEP * width,
        }
    }

    /// The centre, two points for each coordinate, and four for each pair.
    pub(super) fn points(&self) -> Vec<DVector<f64>> {
        let at = |moves: &[(usize, f64)]| {
            let mut point = self.centre.clone();
            for &(i, sign) in moves {
                point[i] += sign * self.step[i];
            }
            point
        };
        let mut points = vec![self.centre.clone()];
        for i in 0..self.centre.len() {
            points.extend([1.0, -1.0].map(|a| at(&[(i, a)])));
            for j in 0..i {
                let signs = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];
                points.extend(signs.map(|(a, b)| at(&[(i, a), (j, b)])));
            }
        }
        points
    }

    /// Axes A of the Gaussian of that curvature, covariance A Aᵀ, by `log_p` of the points; none if there is
    /// no such Gaussian.
    pub(super) fn axes(&self, log_p: &[f64]) -> Option<DMatrix<f64>> {
        let n_dim = self.centre.len();
        let (centre, mut rest) = log_p.split_first()?;
        let mut curvature = DMatrix::zeros(n_dim, n_dim);
        for i in 0..n_dim {
            let (two, after) = rest.split_at_checked(2)?;
            curvature[(i, i)] = (2.0 * centre - two[0] - two[1]) / STEP.powi(2);
            rest = after;
            for j in 0..i {
                let (four, after) = rest.split_at_checked(4)?;
                let mixed = (four[2] + four[3] - four[0] - four[1]) / (2.0 * STEP).powi(2);
                (curvature[(i, j)], curvature[(j, i)]) = (mixed, mixed);
                rest = after;
            }
        }
        if curvature.iter().any(|c| !c.is_finite()) {
            return None;
        }
        let mut eigen = curvature.symmetric_eigen();
        eigen.eigenvalues.apply(|c| *c = 1.0 / c.max(LEAST));
        let width = DMatrix::from_diagonal(&(&self.step / STEP));
        let covariance = &width * eigen.recompose() * &width;
        Some(covariance.cholesky()?.unpack())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gaussian_has_its_own_axes() {
        let covariance =
            DMatrix::from_row_slice(3, 3, &[4.0, 1.8, 0.1, 1.8, 1.0, 0.0, 0.1, 0.0, 9.0]);
        let inverse = covariance.clone().try_inverse().unwrap();
        let centre = DVector::from_vec(vec![1.0, -2.0, 0.5]);
        let width = DVector::from_vec(vec![1.0, 0.5, 2.0]);
        let curvature = Curvature::new(&centre, &width);
        let log_p = |x: &DVector<f64>| -0.5 * (x.transpose() * &inverse * x)[(0, 0)];
        let log_p: Vec<f64> = curvature.points().iter().map(log_p).collect();
        let axes = curvature.axes(&log_p).unwrap();
        assert!((&axes * axes.transpose() - covariance).norm() < 1e-6);
        assert!(curvature.axes(&vec![f64::NAN; log_p.len()]).is_none());
    }
}
