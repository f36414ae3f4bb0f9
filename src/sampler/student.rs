//! Student's t distribution in many dimensions.

use nalgebra::{DMatrix, DVector};
use rand::Rng;
use rand_distr::{Distribution, Gamma, StandardNormal};
use std::f64::consts::TAU;

/// Degrees of freedom a dimension: lighter tails waste fewer points on a Gaussian, heavier ones keep
/// more of a skewed posterior in reach. As many as dimensions cost a Gaussian one point in seven.
const DOF_PER_DIM: f64 = 1.0;

/// A t distribution of as many degrees of freedom as dimensions.
#[derive(Debug, Clone)]
pub(super) struct Student {
    mean: DVector<f64>,
    /// Lower triangle of the Cholesky decomposition of the scale matrix.
    root: DMatrix<f64>,
    dof: f64,
    log_norm: f64,
}

impl Student {
    /// The one that has `mean` and, but for a factor dof/(dof - 2), `covariance`; none if this is
    /// not positive definite.
    pub(super) fn new(mean: DVector<f64>, covariance: DMatrix<f64>) -> Option<Self> {
        let n_dim = mean.len() as f64;
        let dof = DOF_PER_DIM * n_dim;
        let root = covariance.cholesky()?.unpack();
        let log_det: f64 = root.diagonal().iter().map(|x| x.ln()).sum();
        let gamma = |x: f64| puruspe::ln_gamma(0.5 * x);
        let log_norm =
            gamma(dof + n_dim) - gamma(dof) - 0.5 * n_dim * (0.5 * dof * TAU).ln() - log_det;
        log_norm.is_finite().then_some(Self {
            mean,
            root,
            dof,
            log_norm,
        })
    }

    /// A point and ln of the density there.
    pub(super) fn draw(&self, rng: &mut impl Rng) -> (DVector<f64>, f64) {
        let normal = DVector::from_fn(self.mean.len(), |_, _| StandardNormal.sample(rng));
        // A shape of at least 1/2 is always valid.
        let gamma = Gamma::new(0.5 * self.dof, 2.0 / self.dof);
        let scale: f64 = gamma.map_or(1.0, |gamma| gamma.sample(rng));
        let offset = normal / scale.max(f64::MIN_POSITIVE).sqrt();
        let power = 0.5 * (self.dof + self.mean.len() as f64);
        let log_density = self.log_norm - power * (offset.norm_squared() / self.dof).ln_1p();
        (&self.mean + &self.root * offset, log_density)
    }
}

/// Mean and covariance of `points` with `weights` that sum to one.
pub(super) fn moments(points: &[DVector<f64>], weights: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
    let n_dim = points.first().map_or(0, DVector::len);
    let weighted = || points.iter().zip(weights);
    let mean = weighted().fold(DVector::zeros(n_dim), |sum, (x, w)| sum + x * *w);
    let covariance = weighted().fold(DMatrix::zeros(n_dim, n_dim), |mut sum, (x, w)| {
        let offset = x - &mean;
        sum.ger(*w, &offset, &offset, 1.0);
        sum
    });
    (mean, covariance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn draws_have_the_moments_and_the_density_that_they_should() {
        let mean = DVector::from_vec(vec![1.0, -2.0, 0.5, 0.0, 3.0, 1.0]);
        let mut covariance = DMatrix::identity(6, 6);
        (covariance[(0, 1)], covariance[(1, 0)]) = (0.8, 0.8);
        let student = Student::new(mean.clone(), covariance.clone()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let draws: Vec<_> = (0..40_000).map(|_| student.draw(&mut rng)).collect();
        let points: Vec<_> = draws.iter().map(|(x, _)| x.clone()).collect();
        let (got_mean, got) = moments(&points, &vec![1.0 / 40_000.0; 40_000]);
        assert!((got_mean - mean).norm() < 0.05);
        assert!((got - covariance * 1.5).norm() < 0.15, "dof/(dof - 2)");
        // The mean of N/q over draws from q is one.
        let ratio = |(x, log_q): &(DVector<f64>, f64)| {
            let z = &student
                .root
                .clone()
                .solve_lower_triangular(&(x - &student.mean))
                .unwrap();
            let log_det: f64 = student.root.diagonal().iter().map(|x| x.ln()).sum();
            (-0.5 * z.norm_squared() - 3.0 * TAU.ln() - log_det - log_q).exp()
        };
        let mean = draws.iter().map(ratio).sum::<f64>() / draws.len() as f64;
        assert!((mean - 1.0).abs() < 0.01, "{mean}");
    }

    #[test]
    fn no_spread_is_no_distribution() {
        assert!(Student::new(DVector::zeros(2), DMatrix::zeros(2, 2)).is_none());
    }
}
