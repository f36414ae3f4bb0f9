//! Coordinates that move together, and how.

use nalgebra::{DMatrix, DVector};
use rand::Rng;
use rand_distr::{Distribution, Gamma, StandardNormal};

/// Standard deviation of a step from where a chain is, in those of the posterior over the root of the
/// number of coordinates: 2.38 is best for a Gaussian, less where posteriors are bent.
const STRIDE: f64 = 2.0;

/// How a block moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// From where it is.
    Walk,
    /// To a place that does not depend on where it is, but on all other coordinates.
    Anew,
}

/// Some coordinates z_b, and what the Gaussian of all says of them for given others z_r:
///
/// ```text
/// z_b ~ N(μ_b + G (z_r - μ_r), R Rᵀ)      R Rᵀ = (Λ_bb)⁻¹      G = -(Λ_bb)⁻¹ Λ_br      Λ = Σ⁻¹
/// ```
#[derive(Debug, Clone)]
pub(super) struct Block {
    own: Vec<usize>,
    rest: Vec<usize>,
    mean: DVector<f64>,
    root: DMatrix<f64>,
    gain: DMatrix<f64>,
}

impl Block {
    /// The coordinates `own`; none if `precision`, Λ, is not positive definite.
    pub(super) fn new(
        own: Vec<usize>,
        mean: &DVector<f64>,
        precision: &DMatrix<f64>,
    ) -> Option<Self> {
        let rest: Vec<usize> = (0..mean.len()).filter(|i| !own.contains(i)).collect();
        let part = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
                precision[(rows[i], columns[j])]
            })
        };
        let covariance = part(&own, &own).cholesky()?.inverse();
        let gain = -&covariance * part(&own, &rest);
        Some(Self {
            root: covariance.cholesky()?.unpack(),
            mean: mean.clone(),
            own,
            rest,
            gain,
        })
    }

    /// A step from `z`: where to, and ln of the density of the step back over that of this one.
    pub(super) fn propose(
        &self,
        z: &DVector<f64>,
        kind: Kind,
        rng: &mut impl Rng,
    ) -> (DVector<f64>, f64) {
        let n = self.own.len() as f64;
        let normal = DVector::from_fn(self.own.len(), |_, _| StandardNormal.sample(rng));
        let here = z.select_rows(&self.own);
        let (there, log_ratio) = match kind {
            Kind::Walk => (&here + &self.root * normal * (STRIDE / n.sqrt()), 0.0),
            Kind::Anew => {
                // As many degrees of freedom as coordinates.
                let gamma = Gamma::new(0.5 * n, 2.0 / n);
                let scale: f64 = gamma.map_or(1.0, |gamma| gamma.sample(rng));
                let middle = self.middle(z);
                let there = &middle + &self.root * normal / scale.max(f64::MIN_POSITIVE).sqrt();
                let log_ratio =
                    self.log_density(&(here - &middle)) - self.log_density(&(&there - middle));
                (there, log_ratio)
            }
        };
        let mut to = z.clone();
        for (&i, value) in self.own.iter().zip(there.iter()) {
            to[i] = *value;
        }
        (to, log_ratio)
    }

    /// The mean for given others.
    fn middle(&self, z: &DVector<f64>) -> DVector<f64> {
        let offset = z.select_rows(&self.rest) - self.mean.select_rows(&self.rest);
        self.mean.select_rows(&self.own) + &self.gain * offset
    }

    /// ln of the t distribution at `offset` from its middle, up to a constant.
    fn log_density(&self, offset: &DVector<f64>) -> f64 {
        let n = self.own.len() as f64;
        let distance2 = match self.root.solve_lower_triangular(offset) {
            Some(scaled) => scaled.norm_squared(),
            None => f64::INFINITY,
        };
        -n * (distance2 / n).ln_1p()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::student::moments;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Both kinds of steps keep a Gaussian of correlated blocks, the covariance being a wrong one.
    #[test]
    fn steps_keep_the_posterior() {
        let covariance =
            DMatrix::from_row_slice(3, 3, &[1.0, 0.6, 0.5, 0.6, 1.0, 0.4, 0.5, 0.4, 2.0]);
        let precision = covariance.clone().try_inverse().unwrap();
        let log_p = |z: &DVector<f64>| -0.5 * z.dot(&(&precision * z));
        let wrong = DMatrix::from_diagonal_element(3, 3, 1.5);
        let mean = DVector::from_element(3, 0.2);
        let blocks = [vec![0], vec![1, 2]].map(|own| Block::new(own, &mean, &wrong).unwrap());
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut z = DVector::zeros(3);
        let mut drawn = Vec::new();
        for step in 0..40_000 {
            let kind = if step % 4 < 2 { Kind::Walk } else { Kind::Anew };
            let (to, log_ratio) = blocks[step % 2].propose(&z, kind, &mut rng);
            if rng.random::<f64>().ln() < log_p(&to) - log_p(&z) + log_ratio {
                z = to;
            }
            drawn.push(z.clone());
        }
        let (got_mean, got) = moments(&drawn, &vec![1.0 / drawn.len() as f64; drawn.len()]);
        assert!(got_mean.norm() < 0.1, "{got_mean}");
        assert!((got - &covariance).norm() < 0.2, "{covariance}");
    }
}
