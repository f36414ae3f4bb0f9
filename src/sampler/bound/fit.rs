//! Fits an ellipsoid that holds not only the points, but the region that the points came from.
//!
//! The smallest ellipsoid around n live points cuts off part of the region they were drawn from:
//! in 6-D 40% of it for n = 20, 16% for 40, 5% for 80. Iteration after iteration that loss shrinks the
//! region too fast, and the evidence comes out too high. So points are left out of the fit in turn, and the
//! ellipsoid is enlarged until it holds every point that its fit had not seen: a quarter at a time of few
//! points, whose shape is made of more than themselves, and each by itself of many.
//!
//! # Source
//! Buchner 2016 (Statistics and Computing 26, 383) for the idea, with the bootstrap in place of folds.

use super::cloud::{Cloud, Moments};
use super::ellipsoid::Ellipsoid;
use nalgebra::DMatrix;

/// Parts of a set of few points that are left out in turn.
const N_FOLDS: usize = 4;

/// Points for each dimension that give a covariance of their own.
const FEW_PER_DIM: usize = 5;

/// Points for each dimension that show what is typical of small sets.
const TYPICAL_PER_DIM: usize = 10;

/// A set of points and the ellipsoid around it.
#[derive(Debug, Clone)]
pub(in crate::sampler) struct Cluster {
    /// The points.
    pub(in crate::sampler) index: Vec<usize>,
    /// Holds them and where they came from.
    pub(in crate::sampler) ellipsoid: Ellipsoid,
    /// Clusters with the same number are connected by their points.
    pub(in crate::sampler) part: usize,
    /// Of few points: the mixed covariance that the ellipsoid was made of.
    pub(in crate::sampler) covariance: Option<DMatrix<f64>>,
}

/// The ellipsoid for the points `index`, enlarged to hold left-out points and to a volume of at
/// least exp(`log_share`).
///
/// `prior` is the covariance that sets of few points are drawn towards (the pooled one of their
/// neighbours); without it, the diagonal of their own.
pub(super) fn fit(
    cloud: Cloud,
    index: Vec<usize>,
    prior: Option<&DMatrix<f64>>,
    log_share: f64,
) -> Cluster {
    let all = Moments::of(cloud, &index);
    let unit = gaussian(&all, prior);
    // A uniform ellipsoid ends at radius sqrt(d + 2); the mean of few points may lie off its centre.
    let off_centre = 1.0 + 1.0 / (index.len() as f64).sqrt();
    let mut radius2 = (cloud.n_dim as f64 + 2.0) * off_centre * off_centre;
    let are_few = scarcity(index.len(), cloud.n_dim) >= 1.0;
    radius2 = radius2.max(if are_few {
        farthest_of_folds(cloud, &index, &all, &unit, prior)
    } else {
        farthest_left_out(cloud, &index, &unit)
    });
    let covariance = are_few.then(|| unit.shape());
    let mut ellipsoid = unit;
    ellipsoid.grow(0.5 * cloud.n_dim as f64 * radius2.ln());
    ellipsoid.grow((log_share - ellipsoid.log_volume()).max(0.0));
    Cluster {
        index,
        ellipsoid,
        part: 0,
        covariance,
    }
}

/// The largest squared distance of a point from a fit to the others. Of many points, of which `unit` is the covariance.
///
/// # Formula
/// D² in the covariance of all n is D² (n - 2)/(n - 1) ρ²/(1 - ρ D²/(n - 1)) in that of the others about their mean,
/// with ρ = n/(n - 1) (Sherman & Morrison).
fn farthest_left_out(cloud: Cloud, index: &[usize], unit: &Ellipsoid) -> f64 {
    // A point that alone spans a dimension is infinitely far from the others.
    const SMALLEST: f64 = 1e-9;
    let n = index.len() as f64;
    let rho = n / (n - 1.0);
    let left_out = index.iter().map(|&i| {
        let part = rho * unit.distance2(cloud.row(i)) / (n - 1.0);
        (n - 2.0) * rho * part / (1.0 - part).max(SMALLEST)
    });
    left_out.fold(0.0, f64::max)
}

/// The largest squared distance of a point from the fit to all, and from a fit to the other parts than its own.
fn farthest_of_folds(
    cloud: Cloud,
    index: &[usize],
    all: &Moments,
    unit: &Ellipsoid,
    prior: Option<&DMatrix<f64>>,
) -> f64 {
    let distances = index.iter().map(|&i| unit.distance2(cloud.row(i)));
    let mut farthest2 = distances.fold(0.0, f64::max);
    for k in 0..N_FOLDS.min(index.len()) {
        let fold = || index.iter().skip(k).step_by(N_FOLDS);
        let mut left_out = Moments::about(cloud.row(index[0]));
        fold().for_each(|&i| left_out.add(cloud.row(i)));
        if left_out.n() == index.len() {
            break;
        }
        let mut kept = all.clone();
        kept.combine(&left_out, -1.0);
        let blind = gaussian(&kept, prior);
        for &i in fold() {
            farthest2 = farthest2.max(blind.distance2(cloud.row(i)));
        }
    }
    farthest2
}

/// From 1 on a set of points is so small that its covariance is mixed with another; of many points it is small.
pub(in crate::sampler) fn scarcity(n_point: usize, n_dim: usize) -> f64 {
    (FEW_PER_DIM * n_dim) as f64 / n_point as f64
}

/// The ellipsoid of Mahalanobis radius 1 of a regularised covariance.
///
/// Few points: the covariance is mixed with the prior's, scaled so that the
/// points have their expected distances in it.
fn gaussian(moments: &Moments, prior: Option<&DMatrix<f64>>) -> Ellipsoid {
    let scatter = moments.scatter();
    let n_dim = scatter.nrows();
    let dof = moments.n().saturating_sub(1) as f64;
    let own = &scatter / dof.max(1.0);
    let weight = (1.0 - dof / (FEW_PER_DIM * n_dim) as f64).max(0.0);
    let mut shape = own.clone();
    if weight > 0.0 {
        let (target, scale) = match prior {
            Some(prior) => (prior.clone(), relative_scale(prior, &scatter, dof)),
            None => (DMatrix::from_diagonal(&own.diagonal()), 1.0),
        };
        shape = own * (1.0 - weight) + target * (weight * scale);
    }
    for i in 0..n_dim {
        shape[(i, i)] = shape[(i, i)] * (1.0 + 1e-9) + 1e-28;
    }
    let mean = moments.mean();
    let diagonal = || DMatrix::from_diagonal(&shape.diagonal().map(|x| x.max(1e-28)));
    let fitted = Ellipsoid::new(&mean, &shape).or_else(|| Ellipsoid::new(&mean, &diagonal()));
    fitted.unwrap_or_else(|| Ellipsoid::unit_ball(&mean))
}

/// How much larger than `prior` a covariance of scatter/dof is: tr(prior⁻¹ scatter)/(dof d), drawn
/// to 1 with the weight of two points.
fn relative_scale(prior: &DMatrix<f64>, scatter: &DMatrix<f64>, dof: f64) -> f64 {
    let Some(cholesky) = prior.clone().cholesky() else {
        return 1.0;
    };
    let trace = cholesky.solve(scatter).trace() / prior.nrows() as f64;
    (trace + 2.0) / (dof + 2.0)
}

/// The pooled covariance of some sets about their own means; none if they have too few points.
pub(in crate::sampler) fn pooled<'a>(
    cloud: Cloud,
    sets: impl Iterator<Item = &'a [usize]>,
) -> Option<DMatrix<f64>> {
    let n_dim = cloud.n_dim;
    let mut sum = DMatrix::zeros(n_dim, n_dim);
    let mut dof = 0;
    for set in sets {
        sum += Moments::of(cloud, set).scatter();
        dof += set.len() - 1;
    }
    let covariance = sum / dof.max(1) as f64;
    (dof > n_dim && covariance.clone().cholesky().is_some()).then_some(covariance)
}

/// The pooled covariance of the smallest of some sets: what one of few points may look like.
///
/// Only as many as make a covariance: larger sets hold modes that are larger, or several.
pub(in crate::sampler) fn typical<'a>(
    cloud: Cloud,
    sets: impl Iterator<Item = &'a [usize]>,
) -> Option<DMatrix<f64>> {
    let mut sets: Vec<&[usize]> = sets.collect();
    sets.sort_by_key(|set| set.len());
    let mut dof = 0;
    let is_wanted = |set: &&&[usize]| {
        let is_wanted = dof < TYPICAL_PER_DIM * cloud.n_dim;
        dof += set.len() - 1;
        is_wanted
    };
    pooled(cloud, sets.iter().take_while(is_wanted).copied())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Fraction of a 6-D ball that the ellipsoid fitted to n of its points misses.
    fn missed(n: usize, seed: u64) -> f64 {
        let ball = Ellipsoid::unit_ball(&[0.5; 6]);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut u = vec![0.0; 6 * n];
        u.chunks_mut(6).for_each(|u| ball.sample(&mut rng, u));
        let cloud = Cloud { u: &u, n_dim: 6 };
        let e = fit(cloud, (0..n).collect(), None, f64::NEG_INFINITY).ellipsoid;
        let mut point = [0.0; 6];
        let outside = (0..4000).filter(|_| {
            ball.sample(&mut rng, &mut point);
            !e.contains(&point)
        });
        outside.count() as f64 / 4000.0
    }

    #[test]
    fn little_of_the_true_region_is_cut_off() {
        for n in [20, 80, 320] {
            let mean = (0..10).map(|seed| missed(n, seed)).sum::<f64>() / 10.0;
            assert!(mean < 0.025, "{n} points: {mean}");
        }
    }

    #[test]
    fn a_point_is_as_far_from_the_fit_to_the_others_as_that_says() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let shape = DMatrix::from_row_slice(2, 2, &[0.04, 0.03, 0.03, 0.09]);
        let whole = Ellipsoid::new(&[0.5, 0.5], &shape).unwrap();
        let mut u = vec![0.0; 60];
        u.chunks_mut(2).for_each(|u| whole.sample(&mut rng, u));
        let cloud = Cloud { u: &u, n_dim: 2 };
        let index: Vec<usize> = (0..30).collect();
        let alone = |i: usize| {
            let others: Vec<usize> = index.iter().copied().filter(|&j| j != i).collect();
            gaussian(&Moments::of(cloud, &others), None).distance2(cloud.row(i))
        };
        let exact = (0..30).map(alone).fold(0.0, f64::max);
        let unit = gaussian(&Moments::of(cloud, &index), None);
        let found = farthest_left_out(cloud, &index, &unit);
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
    }

    #[test]
    fn one_point_takes_the_shape_of_its_neighbours() {
        let u = [0.3, 0.7];
        let prior = DMatrix::from_row_slice(2, 2, &[1e-4, 0.0, 0.0, 4e-4]);
        let e = fit(Cloud { u: &u, n_dim: 2 }, vec![0], Some(&prior), -20.0).ellipsoid;
        assert!(e.contains(&[0.3, 0.77]) && !e.contains(&[0.37, 0.7]));
    }

    #[test]
    fn equal_points_do_not_break_the_fit() {
        let u = [0.25; 12];
        let e = fit(Cloud { u: &u, n_dim: 2 }, (0..6).collect(), None, -3.0).ellipsoid;
        assert!((e.log_volume() + 3.0).abs() < 1e-9);
    }

    #[test]
    fn volume_is_at_least_the_share() {
        let u = [0.1, 0.2, 0.1001, 0.2003, 0.1002, 0.2, 0.1, 0.2002];
        let e = fit(Cloud { u: &u, n_dim: 2 }, (0..4).collect(), None, -1.0).ellipsoid;
        assert!((e.log_volume() + 1.0).abs() < 1e-9);
    }

    #[test]
    fn typical_of_few_points_is_what_small_sets_look_like() {
        let row = |n: usize, step: f64| {
            (0..n).flat_map(move |i| [step * i as f64, step * (i * i % 7) as f64])
        };
        let u: Vec<f64> = row(100, 1e-2).chain(row(30, 1e-4)).collect();
        let cloud = Cloud { u: &u, n_dim: 2 };
        let (large, small): (Vec<usize>, Vec<usize>) = ((0..100).collect(), (100..130).collect());
        let of =
            |sets: [&Vec<usize>; 2]| typical(cloud, sets.into_iter().map(Vec::as_slice)).unwrap();
        let own = pooled(cloud, [small.as_slice()].into_iter()).unwrap();
        assert_eq!(of([&large, &small]), own);
        assert_eq!(of([&small, &large]), own);
    }
}
