//! One chain: slices from a live point to a new one.

use crate::sampler::bound::Ellipsoid;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// A slice this narrow, of 2 at the start, leads nowhere.
const NARROW: f64 = 1e-14;

/// A walk through the region above a contour, by one evaluated point at a time.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    u: Vec<f64>,
    log_l: f64,
    /// Slices still to be taken.
    n_left: usize,
    has_moved: bool,
    /// Slot of the live point where it began.
    start: usize,
    /// Directions still to be used, row after row.
    basis: Vec<f64>,
    /// The slice in progress, in lengths of its direction from `u`.
    slice: Option<(f64, f64)>,
    proposal: Vec<f64>,
    at: f64,
}

impl Chain {
    /// A chain of `n_left` slices from a point `u` whose ln L is above the contour, and its slot.
    pub(super) fn new(u: Vec<f64>, log_l: f64, start: usize, n_left: usize) -> Self {
        Self {
            proposal: u.clone(),
            u,
            log_l,
            n_left,
            has_moved: false,
            start,
            basis: Vec::new(),
            slice: None,
            at: 0.0,
        }
    }

    pub(super) fn u(&self) -> &[f64] {
        &self.u
    }

    pub(super) fn log_l(&self) -> f64 {
        self.log_l
    }

    pub(super) fn start(&self) -> usize {
        self.start
    }

    pub(super) fn is_done(&self) -> bool {
        self.n_left == 0
    }

    /// Whether it is still where it began.
    pub(super) fn is_stuck(&self) -> bool {
        !self.has_moved
    }

    /// The point to evaluate.
    pub(super) fn proposal(&self) -> &[f64] {
        &self.proposal
    }

    /// Chooses the point to evaluate next, on the slice in progress or on a new one. `enter` brings a
    /// point into the cube if it can and says whether it is allowed; what is not is outside the slice.
    pub(super) fn propose(
        &mut self,
        rng: &mut impl Rng,
        shapes: &[(f64, Ellipsoid)],
        enter: impl Fn(&mut [f64]) -> bool,
    ) {
        let n_dim = self.u.len();
        loop {
            let (low, high) = *self.slice.get_or_insert_with(|| {
                self.basis.truncate(self.basis.len().saturating_sub(n_dim));
                if self.basis.is_empty() {
                    let shape = choose(rng, shapes);
                    self.basis = basis(rng, shape);
                }
                let low = -2.0 * rng.random::<f64>();
                (low, low + 2.0)
            });
            self.at = low + (high - low) * rng.random::<f64>();
            let direction = &self.basis[self.basis.len() - n_dim..];
            let line = self.u.iter().zip(direction).map(|(u, d)| u + self.at * d);
            self.proposal.clear();
            self.proposal.extend(line);
            // At 0 it is the point itself, wherever the walls are.
            if enter(&mut self.proposal) || !self.shrink() {
                return;
            }
        }
    }

    /// Takes ln L of the proposal: a point above the contour ends the slice, another shortens it.
    pub(super) fn take(&mut self, log_l: f64, contour: f64) {
        if log_l > contour {
            self.has_moved |= self.proposal != self.u;
            self.u.clone_from(&self.proposal);
            self.log_l = log_l;
        } else if self.shrink() {
            return;
        }
        self.slice = None;
        self.n_left -= 1;
    }

    /// Cuts the slice at the last place; false if nothing is left of it: the chain stays where it is.
    fn shrink(&mut self) -> bool {
        let Some((low, high)) = self.slice else {
            return false;
        };
        let (low, high) = if self.at < 0.0 {
            (self.at, high)
        } else {
            (low, self.at)
        };
        self.slice = Some((low, high));
        let is_open = high - low > NARROW;
        if !is_open {
            self.proposal.clone_from(&self.u);
        }
        is_open
    }
}

/// A shape with the probability of its share of the live points.
fn choose<'a>(rng: &mut impl Rng, shapes: &'a [(f64, Ellipsoid)]) -> &'a Ellipsoid {
    let x: f64 = rng.random();
    let k = shapes.partition_point(|(sum, _)| *sum <= x);
    &shapes[k.min(shapes.len() - 1)].1
}

/// Half-axes of an ellipsoid that are a random orthonormal basis where it is the unit ball, row after row.
fn basis(rng: &mut impl Rng, shape: &Ellipsoid) -> Vec<f64> {
    let n_dim = shape.n_dim();
    let mut rows: Vec<f64> = Vec::with_capacity(n_dim * n_dim);
    while rows.len() < n_dim * n_dim {
        let mut row: Vec<f64> = (0..n_dim).map(|_| StandardNormal.sample(rng)).collect();
        for other in rows.chunks_exact(n_dim) {
            let along: f64 = other.iter().zip(&row).map(|(a, b)| a * b).sum();
            row.iter_mut().zip(other).for_each(|(a, b)| *a -= along * b);
        }
        let norm = row.iter().map(|x| x * x).sum::<f64>().sqrt();
        // What is left of a normal vector is never this short, but by rounding.
        if norm > 1e-6 {
            rows.extend(row.iter().map(|x| x / norm));
        }
    }
    rows.chunks_exact_mut(n_dim)
        .for_each(|row| shape.stretch(row));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn disc() -> Vec<(f64, Ellipsoid)> {
        let shape = DMatrix::from_row_slice(2, 2, &[0.09, 0.03, 0.03, 0.04]);
        vec![(1.0, Ellipsoid::new(&[0.5, 0.5], &shape).unwrap())]
    }

    #[test]
    fn a_long_chain_fills_the_region_evenly() {
        // The region: the unit square without a disc in a corner.
        let is_in = |u: &[f64]| u[0].hypot(u[1]) > 0.5;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut chain = Chain::new(vec![0.6, 0.6], 0.0, 0, 400_000);
        let (mut seen, mut right, mut beside) = (0, 0, 0);
        while !chain.is_done() {
            chain.propose(&mut rng, &disc(), |u| {
                u.iter().all(|x| (0.0..1.0).contains(x))
            });
            let log_l = if is_in(chain.proposal()) { 0.0 } else { -1.0 };
            chain.take(log_l, -0.5);
            if log_l == 0.0 {
                seen += 1;
                right += usize::from(chain.u()[0] > 0.5);
                beside += usize::from(chain.u()[0] < 0.5 && chain.u()[1] < 0.5);
            }
        }
        let area = 1.0 - std::f64::consts::PI / 16.0;
        let share = |n: usize| n as f64 / seen as f64 * area;
        assert!((share(right) - 0.5).abs() < 0.01, "{}", share(right));
        let corner = 0.25 - std::f64::consts::PI / 16.0;
        assert!((share(beside) - corner).abs() < 0.01, "{}", share(beside));
    }

    #[test]
    fn a_point_without_a_way_out_stays_and_says_so() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut chain = Chain::new(vec![0.5, 0.5], 0.0, 0, 3);
        while !chain.is_done() {
            chain.propose(&mut rng, &disc(), |_| true);
            chain.take(-1.0, -0.5);
        }
        assert!(chain.is_stuck() && chain.u() == [0.5, 0.5]);
    }
}
