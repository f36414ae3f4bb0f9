//! Friends of friends: sets of points with no large gap inside them.

use super::cloud::{Cloud, Moments};
use super::ellipsoid::Ellipsoid;
use nalgebra::DMatrix;

/// A point's own scale is the distance to this neighbour, so a set of up to this many points
/// always joins another: smaller sets have no scale of their own.
const NEIGHBOUR: usize = 3;

/// Two points are friends if they are closer than this many scales of either: about 12 friends in a
/// uniform plane, where 4 already connect thousands of points (Balister et al. 2005).
const REACH2: f64 = 9.0;

/// Of a larger set the points reach as if their scale² were this many times the median one, at most: those in its skirts
/// are far from each other, and would bridge the gap to the next set.
const SKIRT2: f64 = 2.0;

/// A set of few follows a larger one that is closer than this many scales of the latter.
const FOLLOW2: f64 = 100.0;

/// Parts of `index` that are connected in the dimensions `dims`, whitened; each part ascending,
/// parts in the order of their first point.
///
/// The scale adapts to each point, so that a dense and a sparse part can stand beside each other.
pub(super) fn friends_of_friends(cloud: Cloud, index: &[usize], dims: &[usize]) -> Vec<Vec<usize>> {
    if index.len() < 2 * (NEIGHBOUR + 1) || dims.is_empty() {
        return vec![index.to_vec()];
    }
    let z = whiten(cloud, index, dims);
    let k = dims.len();
    let mut order: Vec<usize> = (0..index.len()).collect();
    order.sort_by(|&a, &b| z[a * k].total_cmp(&z[b * k]).then(a.cmp(&b)));
    let sorted: Vec<f64> = order
        .iter()
        .flat_map(|&i| &z[i * k..(i + 1) * k])
        .copied()
        .collect();
    collect(&mut link(&sorted, k), &order, index)
}

/// Sets of friends among points sorted along their first axis.
///
/// First mutual friends: a pair within the reach of both. What a set of few then reaches outside itself is not a
/// neighbour but a stranger, by which it would join several sets that are apart; so it may only follow a larger set
/// that it is close to by that set's own scale. Larger sets have scales of their own and reach by them.
///
/// Nearest neighbours are joined first: mostly they leave few points outside the largest set, from which alone the wide
/// sweeps start.
fn link(sorted: &[f64], k: usize) -> Sets {
    let n = sorted.len() / k;
    let mut sets = Sets::new(n);
    let near: Vec<_> = (0..n).map(|i| nearest(sorted, k, i)).collect();
    let scale2: Vec<f64> = near.iter().map(|near| near[NEIGHBOUR - 1].0).collect();
    for (i, near) in near.into_iter().enumerate() {
        for (d2, j) in near {
            if d2 <= REACH2 * scale2[j] {
                sets.join(i, j);
            }
        }
    }
    // By the reach of both, then of either.
    let both = |i: usize, j: usize| scale2[i].min(scale2[j]);
    join_friends(sorted, k, &mut sets, |i| scale2[i], both);
    let small = sets.small();
    let bounded = without_skirts(&scale2, sets.parts());
    let farthest2 = bounded.iter().copied().fold(0.0, f64::max);
    let either = |i: usize, j: usize| {
        if small[i] || small[j] {
            0.0
        } else {
            bounded[i].max(bounded[j])
        }
    };
    join_friends(sorted, k, &mut sets, |_| farthest2, either);
    let small = sets.small();
    for i in (0..n).filter(|&i| small[i]) {
        let mut host = (f64::INFINITY, i);
        sweep(sorted, k, i, f64::INFINITY, |j, d2, _| {
            if !small[j] && d2 < host.0 {
                host = (d2, j);
            }
            host.0
        });
        if host.0 <= FOLLOW2 * scale2[host.1] {
            sets.join(i, host.1);
        }
    }
    sets
}

/// Joins the sets of pairs that are within the reach of `scale2(i, j)`, which is at most `most2(i)`.
///
/// Of two points in different sets one is not in the largest: it finds the other, if it looks far enough.
fn join_friends(
    sorted: &[f64],
    k: usize,
    sets: &mut Sets,
    most2: impl Fn(usize) -> f64,
    scale2: impl Fn(usize, usize) -> f64,
) {
    for i in sets.outside_largest() {
        sweep(sorted, k, i, REACH2 * most2(i), |j, d2, limit| {
            if d2 <= REACH2 * scale2(i, j) {
                sets.join(i, j);
            }
            limit
        });
    }
}

/// The scales, bounded by the median one of their set.
fn without_skirts(scale2: &[f64], sets: Vec<Vec<usize>>) -> Vec<f64> {
    let mut bounded = scale2.to_vec();
    for set in sets {
        let mut sorted: Vec<f64> = set.iter().map(|&i| scale2[i]).collect();
        sorted.sort_by(f64::total_cmp);
        let most = SKIRT2 * sorted[sorted.len() / 2];
        for i in set {
            bounded[i] = bounded[i].min(most);
        }
    }
    bounded
}

/// Parts of a few points by single linkage at a scale given from outside: the dimensions `dims` of a
/// typical covariance. Uniform ellipsoids of that covariance have a diameter of 2 sqrt(d + 2), which
/// a gap must exceed by half.
pub(super) fn part_by_scale(
    cloud: Cloud,
    index: &[usize],
    dims: &[usize],
    typical: &DMatrix<f64>,
) -> Vec<Vec<usize>> {
    let shape = DMatrix::from_fn(dims.len(), dims.len(), |i, j| typical[(dims[i], dims[j])]);
    let reach2 = 9.0 * (cloud.n_dim + 2) as f64;
    let shadow = |i: usize| dims.iter().map(|&d| cloud.row(i)[d]).collect::<Vec<_>>();
    let mut sets = Sets::new(index.len());
    for (a, &i) in index.iter().enumerate() {
        let Some(scale) = Ellipsoid::new(&shadow(i), &shape) else {
            return vec![index.to_vec()];
        };
        for (b, &j) in index[..a].iter().enumerate() {
            if scale.distance2(&shadow(j)) <= reach2 {
                sets.join(a, b);
            }
        }
    }
    let parts = sets.parts().into_iter();
    parts
        .map(|part| part.into_iter().map(|a| index[a]).collect())
        .collect()
}

/// Coordinates `dims` of the points in units of their covariance.
pub(super) fn whiten(cloud: Cloud, index: &[usize], dims: &[usize]) -> Vec<f64> {
    let pick = |i: usize| dims.iter().map(move |&d| cloud.row(i)[d]);
    let flat: Vec<f64> = index.iter().flat_map(|&i| pick(i)).collect();
    let part = Cloud {
        u: &flat,
        n_dim: dims.len(),
    };
    let moments = Moments::of(part, &(0..index.len()).collect::<Vec<_>>());
    let mut shape = moments.scatter() / index.len() as f64;
    (0..dims.len()).for_each(|i| shape[(i, i)] = shape[(i, i)] * (1.0 + 1e-9) + 1e-30);
    let Some(cholesky) = shape.cholesky() else {
        return flat;
    };
    let points = DMatrix::from_column_slice(dims.len(), index.len(), &flat);
    match cholesky.l().solve_lower_triangular(&points) {
        Some(z) => z.as_slice().to_vec(),
        None => flat,
    }
}

/// The nearest neighbours of a point: squared distance and position, ascending.
fn nearest(sorted: &[f64], k: usize, i: usize) -> [(f64, usize); NEIGHBOUR] {
    let mut nearest = [(f64::INFINITY, i); NEIGHBOUR];
    sweep(sorted, k, i, f64::INFINITY, |j, d2, _| {
        let mut new = (d2, j);
        for old in &mut nearest {
            if new.0 < old.0 {
                std::mem::swap(old, &mut new);
            }
        }
        nearest[NEIGHBOUR - 1].0
    });
    nearest
}

/// Visits the neighbours of point `i` along the first axis, one way and then the other, until
/// that axis alone exceeds the limit, which `visit(j, distance², limit)` returns anew.
fn sweep(
    sorted: &[f64],
    k: usize,
    i: usize,
    mut limit: f64,
    mut visit: impl FnMut(usize, f64, f64) -> f64,
) {
    let here = &sorted[i * k..(i + 1) * k];
    let mut step = |j: usize| {
        let there = &sorted[j * k..(j + 1) * k];
        let mut d2 = (there[0] - here[0]).powi(2);
        if d2 > limit {
            return false;
        }
        for (a, b) in here[1..].iter().zip(&there[1..]) {
            d2 += (a - b) * (a - b);
        }
        limit = visit(j, d2, limit);
        true
    };
    let n = sorted.len() / k;
    let _ = (i + 1..n).all(&mut step);
    let _ = (0..i).rev().all(&mut step);
}

/// The parts as sets of the caller's indices.
fn collect(sets: &mut Sets, order: &[usize], index: &[usize]) -> Vec<Vec<usize>> {
    let mut root = vec![0; order.len()];
    for (position, &original) in order.iter().enumerate() {
        root[original] = sets.find(position);
    }
    group_by_root(&root)
        .into_iter()
        .map(|part| part.into_iter().map(|i| index[i]).collect())
        .collect()
}

/// Positions with the same root, in the order of first appearance.
fn group_by_root(root: &[usize]) -> Vec<Vec<usize>> {
    let mut place = vec![usize::MAX; root.len()];
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for (i, &r) in root.iter().enumerate() {
        if place[r] == usize::MAX {
            place[r] = parts.len();
            parts.push(Vec::new());
        }
        parts[place[r]].push(i);
    }
    parts
}

/// Disjoint sets with path halving.
#[derive(Debug)]
pub(super) struct Sets(Vec<usize>);

impl Sets {
    /// Every element on its own.
    pub(super) fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    pub(super) fn find(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    /// Joins the sets of two elements. The smaller root stays, so the result does not depend on the order of joins.
    pub(super) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b);
    }

    /// Of each element whether its set has too few of them for a scale.
    fn small(&mut self) -> Vec<bool> {
        let root: Vec<usize> = (0..self.0.len()).map(|i| self.find(i)).collect();
        let mut size = vec![0; root.len()];
        for &r in &root {
            size[r] += 1;
        }
        root.into_iter().map(|r| size[r] <= NEIGHBOUR).collect()
    }

    /// Elements that are not in the largest set, ascending.
    fn outside_largest(&mut self) -> Vec<usize> {
        let parts = self.parts();
        let largest = parts
            .iter()
            .max_by_key(|part| part.len())
            .map_or(0, |part| part[0]);
        let root = self.find(largest);
        (0..self.0.len())
            .filter(|&i| self.find(i) != root)
            .collect()
    }

    /// Elements of each set, sets in the order of their first element.
    pub(super) fn parts(&mut self) -> Vec<Vec<usize>> {
        let root: Vec<usize> = (0..self.0.len()).map(|i| self.find(i)).collect();
        group_by_root(&root)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    fn parts(u: &[f64]) -> Vec<usize> {
        let cloud = Cloud { u, n_dim: 2 };
        let index: Vec<usize> = (0..u.len() / 2).collect();
        let parts = friends_of_friends(cloud, &index, &[0, 1]);
        parts.iter().map(Vec::len).collect()
    }

    #[test]
    fn a_uniform_square_is_one_part() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for n in [20, 200, 2000] {
            for _ in 0..5 {
                let u: Vec<f64> = (0..2 * n).map(|_| rng.random()).collect();
                assert_eq!(parts(&u), [n]);
            }
        }
    }

    #[test]
    fn a_few_points_far_from_a_crowd_are_a_part_and_near_it_belong_to_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut u: Vec<f64> = (0..400).map(|_| 0.2 * rng.random::<f64>()).collect();
        u.extend((0..10).map(|_| 0.9 + 0.01 * rng.random::<f64>()));
        assert_eq!(parts(&u), [200, 5]);
        u.truncate(404);
        assert_eq!(parts(&u), [200, 2]);
        u.truncate(400);
        u.extend([0.22, 0.21]);
        assert_eq!(parts(&u), [201]);
    }

    #[test]
    fn skirts_of_two_crowds_do_not_bridge_the_gap() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut n_parted = 0;
        for _ in 0..50 {
            // Normal ones, 14 standard deviations apart: without a bound 4 of 50 are parted, with it 26.
            let mut near = |x: f64| {
                let mut normal = || rng.sample::<f64, _>(StandardNormal);
                [x + normal(), normal()]
            };
            let u: Vec<f64> = (0..200)
                .flat_map(|i| near(14.0 * f64::from(i % 2)))
                .collect();
            let large = parts(&u).into_iter().filter(|n| *n >= 90);
            n_parted += usize::from(large.count() == 2);
        }
        assert!(n_parted >= 20, "{n_parted} of 50");
    }

    #[test]
    fn strangers_between_crowds_are_no_bridge() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut crowd = |x: f64| -> Vec<f64> {
            let mut place = || 0.1 * rng.random::<f64>();
            (0..200).flat_map(|_| [x + place(), place()]).collect()
        };
        let mut u = crowd(0.0);
        u.extend([0.5, 0.05, 0.501, 0.05]);
        u.extend(crowd(0.9));
        assert_eq!(parts(&u), [200, 2, 200]);
    }
}
