//! The places near a live point: what of an ellipsoid is worth a try.
//!
//! A curved region fills only a small part of the ellipsoid around it. Balls about the live points, in
//! the metric of their covariance and just large enough, follow the curve; a draw that lies in none
//! of them is not evaluated.
//!
//! # Source
//! RadFriends and MLFriends: Buchner 2016 (Statistics and Computing 26, 383), 2019 (PASP 131, 108005).

use super::cloud::Cloud;
use super::ellipsoid::Ellipsoid;
use nalgebra::DMatrix;
use rand::{Rng, RngExt};

/// Times that a part of the points is left out.
const N_BOOTSTRAP: usize = 30;

/// The union of equal balls about the live points, in the metric of a covariance.
#[derive(Debug, Clone)]
pub(in crate::sampler) struct Neighbourhood {
    metric: Ellipsoid,
    /// Whitened points, sorted by their first coordinate, row after row.
    centres: Vec<f64>,
    radius2: f64,
}

impl Neighbourhood {
    /// Balls about the points `index` whose radius is the largest that a point left out of a
    /// bootstrap sample needs to be in the ball of a point that is in it; none if the covariance
    /// is singular or there are fewer than two points.
    pub(in crate::sampler) fn new(
        cloud: Cloud,
        index: &[usize],
        covariance: &DMatrix<f64>,
        rng: &mut impl Rng,
    ) -> Option<Self> {
        let metric = Ellipsoid::new(cloud.row(*index.first()?), covariance)?;
        let mut points: Vec<Vec<f64>> =
            index.iter().map(|&i| metric.whiten(cloud.row(i))).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let centres = points.concat();
        let radius2 = bootstrap(&centres, metric.n_dim(), rng);
        (radius2 > 0.0).then_some(Self {
            metric,
            centres,
            radius2,
        })
    }

    /// Whether `u` is in a ball.
    pub(in crate::sampler) fn contains(&self, u: &[f64]) -> bool {
        let z = self.metric.whiten(u);
        let radius = self.radius2.sqrt();
        let mut near = within(&self.centres, &z, radius);
        near.any(|centre| distance2(centre, &z) <= self.radius2)
    }
}

/// The largest squared distance, over bootstrap samples, from a point left out to the nearest one
/// that is in the sample.
fn bootstrap(points: &[f64], d: usize, rng: &mut impl Rng) -> f64 {
    let n = points.len() / d;
    let mut radius2: f64 = 0.0;
    for _ in 0..N_BOOTSTRAP {
        let mut is_in = vec![false; n];
        (0..n).for_each(|_| is_in[rng.random_range(0..n)] = true);
        for i in (0..n).filter(|&i| !is_in[i]) {
            radius2 = radius2.max(nearest2(points, d, i, &is_in, radius2));
        }
    }
    radius2
}

/// The squared distance from point `i` to the nearest of those that are in a sample, or to any that is no farther than
/// `enough2`.
fn nearest2(points: &[f64], d: usize, i: usize, is_in: &[bool], enough2: f64) -> f64 {
    let n = is_in.len();
    let here = &points[i * d..(i + 1) * d];
    let mut nearest2 = f64::INFINITY;
    // From near to far in the coordinate that they are sorted by: mostly the first few will do.
    for step in 1..n {
        for j in [i.wrapping_sub(step), i + step] {
            if is_in.get(j) == Some(&true) {
                nearest2 = nearest2.min(distance2(&points[j * d..(j + 1) * d], here));
            }
        }
        if nearest2 <= enough2 {
            break;
        }
    }
    nearest2
}

/// The points whose first coordinate is within `radius` of that of `z`.
fn within<'a>(points: &'a [f64], z: &[f64], radius: f64) -> impl Iterator<Item = &'a [f64]> {
    let (d, end) = (z.len(), z[0] + radius);
    let first = first_at_least(points, d, z[0] - radius);
    points[first * d..]
        .chunks_exact(d)
        .take_while(move |point| point[0] <= end)
}

/// Number of points whose first coordinate is below `x`.
fn first_at_least(points: &[f64], d: usize, x: f64) -> usize {
    let (mut low, mut high) = (0, points.len() / d);
    while low < high {
        let middle = usize::midpoint(low, high);
        if points[middle * d] < x {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

fn distance2(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
mod tests {
    use super::super::cloud::Moments;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// A point of a thin ring about (0.5, 0.5).
    fn on_ring(rng: &mut ChaCha8Rng) -> [f64; 2] {
        let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
        let radius = 0.3 + 0.02 * rng.random::<f64>();
        [0.5 + radius * cos, 0.5 + radius * sin]
    }

    #[test]
    fn a_ring_is_held_and_its_hole_is_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let u: Vec<f64> = (0..300).flat_map(|_| on_ring(&mut rng)).collect();
        let cloud = Cloud { u: &u, n_dim: 2 };
        let index: Vec<usize> = (0..300).collect();
        let covariance = Moments::of(cloud, &index).scatter() / 299.0;
        let near = Neighbourhood::new(cloud, &index, &covariance, &mut rng).unwrap();
        let missed = (0..10_000).filter(|_| !near.contains(&on_ring(&mut rng)));
        assert!(missed.count() < 20);
        assert!(!near.contains(&[0.5, 0.5]) && !near.contains(&[0.9, 0.9]));
    }

    #[test]
    fn equal_points_have_no_neighbourhood() {
        let u = [0.5; 8];
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let metric = DMatrix::identity(2, 2);
        let cloud = Cloud { u: &u, n_dim: 2 };
        assert!(Neighbourhood::new(cloud, &[0, 1, 2, 3], &metric, &mut rng).is_none());
        assert!(Neighbourhood::new(cloud, &[], &metric, &mut rng).is_none());
    }
}
