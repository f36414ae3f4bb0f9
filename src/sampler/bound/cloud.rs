//! Live points seen as a cloud, and the sums that ellipsoids are fitted from.

use nalgebra::DMatrix;

/// Points in the unit cube, row after row.
#[derive(Debug, Clone, Copy)]
pub(in crate::sampler) struct Cloud<'a> {
    /// Coordinates, axes (point, dimension).
    pub(in crate::sampler) u: &'a [f64],
    /// Dimensions.
    pub(in crate::sampler) n_dim: usize,
}

impl<'a> Cloud<'a> {
    /// Coordinates of point `i`.
    pub(in crate::sampler) fn row(&self, i: usize) -> &'a [f64] {
        &self.u[i * self.n_dim..(i + 1) * self.n_dim]
    }
}

/// Count, sum and sum of outer products about a fixed origin: additive, so that the moments of
/// "all but this fold" cost one subtraction.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    n: usize,
    origin: Vec<f64>,
    sum: Vec<f64>,
    /// Lower triangle, row after row.
    outer: Vec<f64>,
}

impl Moments {
    /// No points yet. An origin among the points keeps the differences well conditioned.
    pub(super) fn about(origin: &[f64]) -> Self {
        let n_dim = origin.len();
        Self {
            n: 0,
            origin: origin.to_vec(),
            sum: vec![0.0; n_dim],
            outer: vec![0.0; n_dim * (n_dim + 1) / 2],
        }
    }

    /// Moments of the points `index`.
    pub(super) fn of(cloud: Cloud, index: &[usize]) -> Self {
        let mut moments = Self::about(cloud.row(index[0]));
        for &i in index {
            moments.add(cloud.row(i));
        }
        moments
    }

    pub(super) fn add(&mut self, u: &[f64]) {
        self.n += 1;
        let mut outer = self.outer.as_mut_slice();
        for (i, (u_i, origin_i)) in u.iter().zip(&self.origin).enumerate() {
            let x = u_i - origin_i;
            self.sum[i] += x;
            let (row, rest) = outer.split_at_mut(i + 1);
            for (sum, (u_j, origin_j)) in row.iter_mut().zip(u.iter().zip(&self.origin)) {
                *sum += x * (u_j - origin_j);
            }
            outer = rest;
        }
    }

    /// Adds (`sign` = 1) or takes away (-1) the points of moments about the same origin.
    pub(super) fn combine(&mut self, other: &Self, sign: f64) {
        self.n = if sign > 0.0 {
            self.n + other.n
        } else {
            self.n - other.n
        };
        let pairs = self.sum.iter_mut().zip(&other.sum);
        pairs.for_each(|(a, b)| *a += sign * b);
        let pairs = self.outer.iter_mut().zip(&other.outer);
        pairs.for_each(|(a, b)| *a += sign * b);
    }

    pub(super) fn n(&self) -> usize {
        self.n
    }

    pub(super) fn mean(&self) -> Vec<f64> {
        let n = self.n.max(1) as f64;
        let pairs = self.origin.iter().zip(&self.sum);
        pairs.map(|(o, s)| o + s / n).collect()
    }

    /// Σ (u - mean)(u - mean)ᵀ, not yet divided by the degrees of freedom.
    pub(super) fn scatter(&self) -> DMatrix<f64> {
        let n_dim = self.sum.len();
        let n = self.n.max(1) as f64;
        DMatrix::from_fn(n_dim, n_dim, |i, j| {
            let (i, j) = (i.max(j), i.min(j));
            self.outer[i * (i + 1) / 2 + j] - self.sum[i] * self.sum[j] / n
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_all_but_a_fold_are_those_of_the_rest() {
        let u = [0.1, 0.2, 0.4, 0.1, 0.3, 0.9, 0.8, 0.7];
        let cloud = Cloud { u: &u, n_dim: 2 };
        let mut rest = Moments::of(cloud, &[0, 1, 2, 3]);
        let mut fold = Moments::about(cloud.row(0));
        fold.add(cloud.row(3));
        rest.combine(&fold, -1.0);
        let direct = Moments::of(cloud, &[0, 1, 2]);
        assert_eq!(rest.n(), 3);
        assert!((rest.scatter() - direct.scatter()).amax() < 1e-14);
        assert!((rest.mean()[0] - 0.8 / 3.0).abs() < 1e-14);
    }
}
