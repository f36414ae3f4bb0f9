//! Covers live points by few ellipsoids of small total volume.
//!
//! # Source
//! Feroz, Hobson & Bridges 2009 (MNRAS 398, 1601), algorithm 1: split in two, move points to the
//! ellipsoid with the lower h, keep the split if the volume falls, recurse. Ours differs in that
//! sets are first parted at gaps in the mode dimensions, and that the volumes compared are those of
//! ellipsoids enlarged for what they have not seen ([`super::fit`]), which penalises splits of few points.

use super::cloud::{Cloud, Moments};
use super::ellipsoid::Ellipsoid;
use super::fit::{Cluster, fit, pooled, typical};
use super::friends::{friends_of_friends, part_by_scale, whiten};
use super::linkage::partitions;
use crate::sampler::log_add;
use nalgebra::DMatrix;

/// What the recursion needs to know at each level.
#[derive(Debug, Clone, Copy)]
pub(in crate::sampler) struct Decomposition<'a> {
    /// The points.
    pub(in crate::sampler) cloud: Cloud<'a>,
    /// Dimensions in which gaps part the points.
    pub(in crate::sampler) mode_dims: &'a [usize],
    /// ln of the prior volume that each live point stands for, X/N.
    pub(in crate::sampler) log_share: f64,
    /// Covariance of a typical mode, for sets of few points.
    pub(in crate::sampler) typical: Option<&'a DMatrix<f64>>,
}

/// Volume (against the share) above which a set is worth looking into more deeply although its
/// halves are no smaller. 2 in the paper; ellipsoids of few points are larger here.
const WASTEFUL: f64 = 3.0;

/// ln of the volume (against the share) below which a set is not split: 2, as in the paper.
const TIDY: f64 = std::f64::consts::LN_2;

/// Rounds of parting by the typical covariance; each may make it smaller.
const MAX_ROUNDS: usize = 8;

/// ln of the volume (against the share) above which a set is searched for clumps, and of what
/// they must save: chance does not explain a factor of 10.
const VAST: f64 = 2.3;

/// Most points for a method of quadratic cost.
const MAX_LINKED: usize = 1000;

/// Most points by which a split is found; of larger sets, that of an even sample divides all.
const MAX_SETTLED: usize = 500;

/// A split is kept if ln of the volume falls by this much: less is often chance, and what was chosen for being small by
/// chance cuts off.
const KEEP: f64 = 0.5;

/// Ellipsoids around the points `index`; clusters of one `part` are connected by their points.
pub(in crate::sampler) fn decompose(problem: Decomposition, index: Vec<usize>) -> Vec<Cluster> {
    let whole = problem.fit(index, problem.typical);
    if problem.excess(&whole) < TIDY {
        return vec![whole];
    }
    let parts = problem.part(&whole, problem.typical);
    let parts = parts.unwrap_or_else(|| vec![whole]);
    let prior = problem.pooled(parts.iter().map(|c| c.index.as_slice()));
    let prior = prior.as_ref().or(problem.typical);
    let divide = |(part, whole)| {
        let clusters = problem.halve(whole, prior).into_iter();
        clusters.map(move |c| Cluster { part, ..c })
    };
    parts.into_iter().enumerate().flat_map(divide).collect()
}

/// Refits the ellipsoids to clusters that are already known.
pub(in crate::sampler) fn refit(problem: Decomposition, sets: Vec<Vec<usize>>) -> Vec<Cluster> {
    let prior = problem.pooled(sets.iter().map(Vec::as_slice));
    let prior = prior.as_ref().or(problem.typical);
    sets.into_iter()
        .map(|index| problem.fit(index, prior))
        .collect()
}

impl Decomposition<'_> {
    fn fit(&self, index: Vec<usize>, prior: Option<&DMatrix<f64>>) -> Cluster {
        let log_share = self.log_share + (index.len() as f64).ln();
        fit(self.cloud, index, prior, log_share)
    }

    /// ln of a cluster's volume over that which its points stand for.
    fn excess(&self, cluster: &Cluster) -> f64 {
        cluster.ellipsoid.log_volume() - self.log_share - (cluster.index.len() as f64).ln()
    }

    fn pooled<'b>(&self, sets: impl Iterator<Item = &'b [usize]>) -> Option<DMatrix<f64>> {
        pooled(self.cloud, sets)
    }

    /// The parts of a set between gaps in the mode dimensions, if there are several and they are
    /// smaller than the whole.
    ///
    /// A part of few points has no scale of its own, so it is parted again by that of its neighbours:
    /// two faint modes of two or three points each would otherwise share one vast ellipsoid.
    fn part(&self, whole: &Cluster, prior: Option<&DMatrix<f64>>) -> Option<Vec<Cluster>> {
        if self.mode_dims.is_empty() {
            return None;
        }
        let mut parts = friends_of_friends(self.cloud, &whole.index, self.mode_dims);
        let mut typical = prior.cloned();
        // Each round takes pairs of modes apart that had inflated the typical covariance.
        for _ in 0..MAX_ROUNDS {
            if parts.len() > 1 {
                let sets = parts.iter().map(Vec::as_slice);
                typical = self::typical(self.cloud, sets).or(typical);
            }
            let n_parts = parts.len();
            parts = parts
                .into_iter()
                .flat_map(|part| self.part_few(part, typical.as_ref()))
                .collect();
            if parts.len() == n_parts {
                break;
            }
        }
        let fitted = parts
            .into_iter()
            .map(|part| self.fit(part, typical.as_ref()));
        let parts: Vec<Cluster> = fitted
            .flat_map(|part| self.unclump(part, typical.as_ref()))
            .collect();
        let smaller = log_volume(&parts) < whole.ellipsoid.log_volume();
        (parts.len() > 1 && smaller).then_some(parts)
    }

    /// Parts a set by the typical scale if it has few points.
    fn part_few(&self, part: Vec<usize>, typical: Option<&DMatrix<f64>>) -> Vec<Vec<usize>> {
        match typical {
            Some(typical) if part.len() < 2 * (self.cloud.n_dim + 2) => {
                part_by_scale(self.cloud, &part, self.mode_dims, typical)
            }
            _ => vec![part],
        }
    }

    /// Clumps of a set whose ellipsoid is far too large, if they save most of its volume: faint
    /// modes of a few points each, which friends of friends cannot tell apart.
    fn unclump(&self, whole: Cluster, prior: Option<&DMatrix<f64>>) -> Vec<Cluster> {
        let n = whole.index.len();
        if self.excess(&whole) < VAST || !(3..=MAX_LINKED).contains(&n) || self.mode_dims.is_empty()
        {
            return vec![whole];
        }
        let z = whiten(self.cloud, &whole.index, self.mode_dims);
        let fit_parts = |parts: Vec<Vec<usize>>| {
            let parts = parts
                .into_iter()
                .map(|p| p.into_iter().map(|a| whole.index[a]).collect());
            let parts: Vec<Vec<usize>> = parts.collect();
            let pooled = self.pooled(parts.iter().map(Vec::as_slice));
            let prior = pooled.as_ref().or(prior)?;
            let clusters = parts.into_iter().map(|part| self.fit(part, Some(prior)));
            let clusters: Vec<Cluster> = clusters.collect();
            Some((log_volume(&clusters), clusters))
        };
        let fits = partitions(&z, self.mode_dims.len())
            .into_iter()
            .filter_map(fit_parts);
        match fits.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((log_volume, parts)) if log_volume < whole.ellipsoid.log_volume() - VAST => parts,
            _ => vec![whole],
        }
    }

    /// The set as one cluster or as several, whichever is smaller.
    fn divide(&self, whole: Cluster, prior: Option<&DMatrix<f64>>) -> Vec<Cluster> {
        let Some(parts) = self.part(&whole, prior) else {
            return self.halve(whole, prior);
        };
        let pooled = self.pooled(parts.iter().map(|c| c.index.as_slice()));
        let prior = pooled.as_ref().or(prior);
        parts
            .into_iter()
            .flat_map(|part| self.halve(part, prior))
            .collect()
    }

    /// Splits in two if that is smaller now, or after further splits of a wasteful set.
    fn halve(&self, whole: Cluster, prior: Option<&DMatrix<f64>>) -> Vec<Cluster> {
        let log_whole = whole.ellipsoid.log_volume();
        let excess = self.excess(&whole);
        let smallest = 2 * (self.cloud.n_dim + 2);
        if whole.index.len() < smallest || excess < TIDY {
            return vec![whole];
        }
        let Some(halves) = two_parts(self.cloud, &whole) else {
            return vec![whole];
        };
        let pooled = self.pooled(halves.iter().map(Vec::as_slice));
        let prior = pooled.as_ref().or(prior);
        let halves = halves.map(|half| self.fit(half, prior));
        let better = log_volume(&halves) < log_whole - KEEP;
        if !better && (excess < WASTEFUL.ln() || whole.index.len() < 2 * smallest) {
            return vec![whole];
        }
        let divided: Vec<_> = halves
            .into_iter()
            .flat_map(|half| self.divide(half, prior))
            .collect();
        if better || log_volume(&divided) < log_whole - KEEP {
            divided
        } else {
            vec![whole]
        }
    }
}

/// ln of the summed volume.
fn log_volume(clusters: &[Cluster]) -> f64 {
    clusters.iter().fold(f64::NEG_INFINITY, |sum, c| {
        log_add(sum, c.ellipsoid.log_volume())
    })
}

/// The better of two ways to part a set in two: 2-means in its whitened space, which sees narrow
/// dimensions, and in the cube's own, which sees two sets beside each other in a narrow band.
fn two_parts(cloud: Cloud, whole: &Cluster) -> Option<[Vec<usize>; 2]> {
    let stride = whole.index.len().div_ceil(MAX_SETTLED);
    if stride > 1 {
        let sample = Cluster {
            index: whole.index.iter().step_by(stride).copied().collect(),
            ..whole.clone()
        };
        let halves = two_parts(cloud, &sample)?;
        return share_out(cloud, whole, &halves);
    }
    let plain = whole.index.iter().flat_map(|&i| cloud.row(i)).copied();
    let white = whole
        .index
        .iter()
        .flat_map(|&i| whole.ellipsoid.whiten(cloud.row(i)));
    let ways = [
        two_means(&plain.collect::<Vec<_>>(), cloud.n_dim),
        two_means(&white.collect::<Vec<_>>(), cloud.n_dim),
    ];
    let parted = ways
        .into_iter()
        .filter_map(|side| settle(cloud, whole, side));
    let best = parted.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, halves)| halves)
}

/// The points of a set by which ellipsoid of two samples of it has the lower h.
fn share_out(cloud: Cloud, whole: &Cluster, halves: &[Vec<usize>; 2]) -> Option<[Vec<usize>; 2]> {
    let (a, b) = (tight(cloud, &halves[0])?, tight(cloud, &halves[1])?);
    let is_in_b = is_in_second(&a, &b);
    let side = whole.index.iter().map(|&i| is_in_b(cloud.row(i)));
    sides(whole, &side.collect::<Vec<_>>(), cloud.n_dim + 2)
}

/// Moves points to the ellipsoid with the lower h = V(E)/n x Mahalanobis distance (FHB09 eq. 22),
/// until none moves: ln of the volume, and the parts; none if one gets smaller than d + 2 points.
fn settle(cloud: Cloud, whole: &Cluster, mut side: Vec<bool>) -> Option<(f64, [Vec<usize>; 2])> {
    let smallest = cloud.n_dim + 2;
    let mut log_volume = f64::INFINITY;
    for _ in 0..5 {
        let halves = sides(whole, &side, smallest)?;
        let [Some(a), Some(b)] = halves.each_ref().map(|half| tight(cloud, half)) else {
            break;
        };
        log_volume = log_add(a.0.log_volume(), b.0.log_volume());
        let mut moved = false;
        let is_in_b = is_in_second(&a, &b);
        for (&i, side) in whole.index.iter().zip(&mut side) {
            let now = is_in_b(cloud.row(i));
            moved |= now != *side;
            *side = now;
        }
        if !moved {
            break;
        }
    }
    Some((log_volume, sides(whole, &side, smallest)?))
}

/// Which of two ellipsoids, each with its ln(V/n), a point has the lower h in.
fn is_in_second(a: &(Ellipsoid, f64), b: &(Ellipsoid, f64)) -> impl Fn(&[f64]) -> bool {
    let ratio = (b.1 - a.1).exp();
    move |u| ratio * b.0.distance2(u) < a.0.distance2(u)
}

/// The two parts, each of at least `smallest` points.
fn sides(whole: &Cluster, side: &[bool], smallest: usize) -> Option<[Vec<usize>; 2]> {
    let mut parts = [Vec::new(), Vec::new()];
    for (&i, &side) in whole.index.iter().zip(side) {
        parts[usize::from(side)].push(i);
    }
    (parts[0].len().min(parts[1].len()) >= smallest).then_some(parts)
}

/// The ellipsoid just around the points, and ln(V/n).
fn tight(cloud: Cloud, index: &[usize]) -> Option<(Ellipsoid, f64)> {
    let moments = Moments::of(cloud, index);
    let covariance = moments.scatter() / index.len() as f64;
    let mut ellipsoid = Ellipsoid::new(&moments.mean(), &covariance)?;
    let radius2 = index
        .iter()
        .map(|&i| ellipsoid.distance2(cloud.row(i)))
        .fold(0.0, f64::max);
    ellipsoid.grow(0.5 * cloud.n_dim as f64 * radius2.ln());
    let log_h = ellipsoid.log_volume() - (index.len() as f64).ln();
    Some((ellipsoid, log_h))
}

/// Lloyd's 2-means from two far points: the one farthest from the centre, and the one farthest
/// from that.
fn two_means(z: &[f64], n_dim: usize) -> Vec<bool> {
    let farthest = |from: &[f64]| {
        let far = z
            .chunks_exact(n_dim)
            .max_by(|a, b| gap2(a, from).total_cmp(&gap2(b, from)));
        far.map_or_else(|| from.to_vec(), <[f64]>::to_vec)
    };
    let first = farthest(&centre(z, n_dim));
    let mut centres = [farthest(&first), first];
    let mut side = vec![false; z.len() / n_dim];
    for _ in 0..10 {
        let mut sums = [vec![0.0; n_dim], vec![0.0; n_dim]];
        let mut counts = [0.0; 2];
        let mut moved = false;
        for (z, side) in z.chunks_exact(n_dim).zip(&mut side) {
            let now = gap2(z, &centres[1]) < gap2(z, &centres[0]);
            moved |= now != *side;
            *side = now;
            counts[usize::from(now)] += 1.0;
            sums[usize::from(now)]
                .iter_mut()
                .zip(z)
                .for_each(|(s, z)| *s += z);
        }
        if !moved || counts[0] == 0.0 || counts[1] == 0.0 {
            break;
        }
        for ((centre, sum), count) in centres.iter_mut().zip(sums).zip(counts) {
            *centre = sum.into_iter().map(|s| s / count).collect();
        }
    }
    side
}

/// Mean of rows of coordinates.
fn centre(z: &[f64], n_dim: usize) -> Vec<f64> {
    let mut sum = vec![0.0; n_dim];
    for z in z.chunks_exact(n_dim) {
        sum.iter_mut().zip(z).for_each(|(s, z)| *s += z);
    }
    let n = (z.len() / n_dim) as f64;
    sum.into_iter().map(|s| s / n).collect()
}

fn gap2(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
mod tests {
    use super::super::separate;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// `n` points in each of some discs of radius 0.05.
    fn discs(centres: &[[f64; 2]], n: usize) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let shape = DMatrix::identity(2, 2) * 0.0025;
        let discs = centres.iter().map(|c| Ellipsoid::new(c, &shape).unwrap());
        let mut points = Vec::new();
        for disc in discs {
            for _ in 0..n {
                let mut u = [0.0; 2];
                disc.sample(&mut rng, &mut u);
                points.extend(u);
            }
        }
        points
    }

    fn run(u: &[f64], mode_dims: &[usize]) -> Vec<Cluster> {
        // Four discs at most.
        let log_share = (0.01 * std::f64::consts::PI / (u.len() / 2) as f64).ln();
        let problem = Decomposition {
            cloud: Cloud { u, n_dim: 2 },
            mode_dims,
            log_share,
            typical: None,
        };
        decompose(problem, (0..u.len() / 2).collect())
    }

    #[test]
    fn four_discs_become_four_ellipsoids_with_and_without_mode_dimensions() {
        let u = discs(&[[0.2, 0.2], [0.8, 0.2], [0.5, 0.7], [0.8, 0.8]], 60);
        for dims in [&[0, 1][..], &[]] {
            let found = run(&u, dims);
            assert_eq!(found.len(), 4);
            let shadows: Vec<_> = found.iter().map(|c| c.ellipsoid.clone()).collect();
            assert_eq!(separate(&shadows, &[0, 1, 2, 3], &[]).len(), 4);
            assert_eq!(separate(&shadows, &[0, 0, 2, 3], &[]).len(), 3);
            assert_eq!(separate(&shadows, &[0, 0, 2, 3], &[(3, 1)]).len(), 2);
        }
    }

    #[test]
    fn one_disc_stays_one() {
        assert_eq!(run(&discs(&[[0.5, 0.5]], 300), &[0, 1]).len(), 1);
    }

    #[test]
    fn six_points_beside_a_crowd_get_their_own_ellipsoid() {
        let mut u = discs(&[[0.2, 0.2]], 200);
        u.extend(discs(&[[0.8, 0.8]], 6));
        let found = run(&u, &[0, 1]);
        assert_eq!(
            found.iter().map(|c| c.index.len()).collect::<Vec<_>>(),
            [200, 6]
        );
    }
}
