//! One ellipsoid: { c + L z : |z| <= 1 }, L lower triangular.

use nalgebra::DMatrix;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// An ellipsoid in `n_dim` dimensions.
#[derive(Debug, Clone, PartialEq)]
pub struct Ellipsoid {
    centre: Vec<f64>,
    /// L, row after row, so that L Lᵀ is the shape matrix.
    axes: Vec<f64>,
    /// L⁻¹, row after row.
    inverse: Vec<f64>,
    log_volume: f64,
}

impl Ellipsoid {
    /// The points with (u - centre)ᵀ shape⁻¹ (u - centre) <= 1; none if `shape` (`n_dim` x `n_dim`)
    /// is not positive definite.
    pub fn new(centre: &[f64], shape: &DMatrix<f64>) -> Option<Self> {
        let n_dim = centre.len();
        let axes = shape.clone().cholesky()?.unpack();
        let inverse = axes.solve_lower_triangular(&DMatrix::identity(n_dim, n_dim))?;
        let log_det: f64 = axes.diagonal().iter().map(|x| x.ln()).sum();
        let log_volume = log_unit_ball_volume(n_dim) + log_det;
        log_volume.is_finite().then(|| Self {
            centre: centre.to_vec(),
            axes: axes.transpose().as_slice().to_vec(),
            inverse: inverse.transpose().as_slice().to_vec(),
            log_volume,
        })
    }

    /// The ball of radius 1.
    pub fn unit_ball(centre: &[f64]) -> Self {
        let n_dim = centre.len();
        let mut axes = vec![0.0; n_dim * n_dim];
        axes.iter_mut().step_by(n_dim + 1).for_each(|x| *x = 1.0);
        Self {
            centre: centre.to_vec(),
            inverse: axes.clone(),
            axes,
            log_volume: log_unit_ball_volume(n_dim),
        }
    }

    /// Number of dimensions.
    pub fn n_dim(&self) -> usize {
        self.centre.len()
    }

    /// Its centre.
    pub fn centre(&self) -> &[f64] {
        &self.centre
    }

    /// ln of its volume.
    pub fn log_volume(&self) -> f64 {
        self.log_volume
    }

    /// Squared distance from the centre in units of the radius: at most 1 inside.
    pub fn distance2(&self, u: &[f64]) -> f64 {
        let n_dim = self.centre.len();
        let mut sum = 0.0;
        for (i, row) in self.inverse.chunks_exact(n_dim).enumerate() {
            let mut z = 0.0;
            for j in 0..=i {
                z += row[j] * (u[j] - self.centre[j]);
            }
            sum += z * z;
        }
        sum
    }

    /// `u` in the coordinates in which the ellipsoid is the unit ball.
    pub fn whiten(&self, u: &[f64]) -> Vec<f64> {
        let n_dim = self.centre.len();
        let rows = self.inverse.chunks_exact(n_dim);
        rows.map(|row| (0..n_dim).map(|j| row[j] * (u[j] - self.centre[j])).sum())
            .collect()
    }

    /// Turns a vector of the coordinates in which the ellipsoid is the unit ball into one of the cube.
    pub(in crate::sampler) fn stretch(&self, z: &mut [f64]) {
        let n_dim = self.centre.len();
        // From the last row up, so that each row still reads the z of the rows above it.
        for i in (0..n_dim).rev() {
            let row = &self.axes[i * n_dim..=i * n_dim + i];
            z[i] = row.iter().zip(z.iter()).map(|(a, z)| a * z).sum();
        }
    }

    /// Whether `u` lies inside.
    pub fn contains(&self, u: &[f64]) -> bool {
        let n_dim = self.centre.len();
        let mut sum = 0.0;
        for (i, row) in self.inverse.chunks_exact(n_dim).enumerate() {
            let mut z = 0.0;
            for j in 0..=i {
                z += row[j] * (u[j] - self.centre[j]);
            }
            sum += z * z;
            // Mostly it is clear after a few dimensions.
            if sum > 1.0 {
                return false;
            }
        }
        true
    }

    /// The same ellipsoid with its volume multiplied by exp(`log_factor`).
    pub fn grow(&mut self, log_factor: f64) {
        let radius = (log_factor / self.centre.len() as f64).exp();
        self.axes.iter_mut().for_each(|x| *x *= radius);
        self.inverse.iter_mut().for_each(|x| *x /= radius);
        self.log_volume += log_factor;
    }

    /// Draws a point uniformly: direction from a normal vector, radius r^(1/d).
    pub fn sample(&self, rng: &mut impl Rng, u: &mut [f64]) {
        let n_dim = self.centre.len();
        let mut norm2 = 0.0_f64;
        for x in u.iter_mut() {
            *x = StandardNormal.sample(rng);
            norm2 += *x * *x;
        }
        let radius = rng.random::<f64>().powf(1.0 / n_dim as f64) / norm2.sqrt();
        self.stretch(u);
        for (u, centre) in u.iter_mut().zip(&self.centre) {
            *u = centre + radius * *u;
        }
    }

    /// The shape matrix L Lᵀ.
    pub fn shape(&self) -> DMatrix<f64> {
        let n_dim = self.centre.len();
        let axes = DMatrix::from_row_slice(n_dim, n_dim, &self.axes);
        &axes * axes.transpose()
    }

    /// Its shadow on some dimensions: the sub-vector of the centre, the sub-matrix of the shape.
    pub fn project(&self, dims: &[usize]) -> Option<Self> {
        let shape = self.shape();
        let centre: Vec<f64> = dims.iter().map(|&i| self.centre[i]).collect();
        let sub = DMatrix::from_fn(dims.len(), dims.len(), |i, j| shape[(dims[i], dims[j])]);
        Self::new(&centre, &sub)
    }

    /// Whether two ellipsoids have a point in common.
    ///
    /// # Formula
    /// They are disjoint if max over s in (0, 1) of dᵀ (A/(1-s) + B/s)⁻¹ d exceeds 1, with d the
    /// distance of the centres and A, B the shapes; the function is concave in s.
    ///
    /// # Source
    /// Perram & Wertheim 1985, J. Comput. Phys. 58, 409.
    pub fn intersects(&self, other: &Self) -> bool {
        let (a, b) = (self.shape(), other.shape());
        let n_dim = self.n_dim();
        let gap = |i: usize| (self.centre[i] - other.centre[i]).abs();
        if (0..n_dim).any(|i| gap(i) > a[(i, i)].sqrt() + b[(i, i)].sqrt()) {
            return false;
        }
        let d = nalgebra::DVector::from_fn(n_dim, |i, _| self.centre[i] - other.centre[i]);
        let contact = |s: f64| {
            let sum = &a / (1.0 - s) + &b / s;
            sum.cholesky().map_or(0.0, |c| d.dot(&c.solve(&d)))
        };
        !exceeds_one(contact)
    }
}

/// Whether a concave function on (0, 1) exceeds 1 anywhere: golden-section search.
fn exceeds_one(f: impl Fn(f64) -> f64) -> bool {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut x1, mut x2) = (1.0 - GOLDEN, GOLDEN);
    let (mut f1, mut f2) = (f(x1), f(x2));
    for _ in 0..30 {
        if f1 > 1.0 || f2 > 1.0 {
            return true;
        }
        if f1 > f2 {
            (high, x2, f2) = (x2, x1, f1);
            x1 = high - GOLDEN * (high - low);
            f1 = f(x1);
        } else {
            (low, x1, f1) = (x1, x2, f2);
            x2 = low + GOLDEN * (high - low);
            f2 = f(x2);
        }
    }
    false
}

/// ln of the volume of the unit ball: V(d) = V(d-2) 2π/d.
fn log_unit_ball_volume(n_dim: usize) -> f64 {
    let start = if n_dim.is_multiple_of(2) {
        0.0
    } else {
        2f64.ln()
    };
    (n_dim % 2 + 2..=n_dim).step_by(2).fold(start, |sum, d| {
        sum + (std::f64::consts::TAU / d as f64).ln()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn tilted() -> Ellipsoid {
        let shape = DMatrix::from_row_slice(2, 2, &[0.04, 0.03, 0.03, 0.09]);
        Ellipsoid::new(&[0.5, 0.4], &shape).unwrap()
    }

    fn disc(x: f64, radius: f64) -> Ellipsoid {
        Ellipsoid::new(&[x, 0.0], &(DMatrix::identity(2, 2) * radius * radius)).unwrap()
    }

    #[test]
    fn unit_ball_volumes_are_the_known_ones() {
        let pi = std::f64::consts::PI;
        for (d, v) in [
            (1, 2.0),
            (2, pi),
            (3, 4.0 / 3.0 * pi),
            (6, pi.powi(3) / 6.0),
        ] {
            assert!((log_unit_ball_volume(d).exp() - v).abs() < 1e-12, "{d}");
        }
    }

    #[test]
    fn volume_is_pi_root_det() {
        let v = std::f64::consts::PI * (0.04f64 * 0.09 - 0.0009).sqrt();
        assert!((tilted().log_volume() - v.ln()).abs() < 1e-12);
    }

    #[test]
    fn samples_are_uniform_inside() {
        let e = tilted();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut u, mut inner, mut right) = ([0.0; 2], 0, 0);
        for _ in 0..20_000 {
            e.sample(&mut rng, &mut u);
            let d2 = e.distance2(&u);
            assert!(d2 <= 1.0 + 1e-12);
            inner += usize::from(d2 < 0.25);
            right += usize::from(u[0] > 0.5);
        }
        assert!((inner as f64 - 5000.0).abs() < 5.0 * 61.0, "{inner}");
        assert!((right as f64 - 10_000.0).abs() < 5.0 * 71.0, "{right}");
    }

    #[test]
    fn growing_scales_volume_and_reach() {
        let mut e = disc(0.0, 1.0);
        e.grow(4f64.ln());
        assert!(e.contains(&[1.99, 0.0]) && !e.contains(&[2.01, 0.0]));
        assert!((e.log_volume() - (4.0 * std::f64::consts::PI).ln()).abs() < 1e-12);
    }

    #[test]
    fn projection_keeps_the_extent() {
        let shape = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 0.5, 1.0, 9.0, 2.0, 0.5, 2.0, 1.0]);
        let e = Ellipsoid::new(&[0.0; 3], &shape).unwrap();
        let shadow = e.project(&[1]).unwrap();
        assert!(shadow.contains(&[2.999]) && !shadow.contains(&[3.001]));
    }

    #[test]
    fn discs_intersect_when_closer_than_their_radii() {
        let a = disc(0.0, 1.0);
        assert!(a.intersects(&disc(1.49, 0.5)));
        assert!(!a.intersects(&disc(1.51, 0.5)));
        assert!(a.intersects(&disc(0.1, 0.2)), "one inside the other");
    }

    #[test]
    fn crossing_needles_intersect_and_parallel_ones_do_not() {
        let needle = |y: f64, tilt: f64| {
            let (s, c) = tilt.sin_cos();
            let axis = DMatrix::from_row_slice(2, 2, &[c, -s, s, c]);
            let long = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 1e-4]);
            Ellipsoid::new(&[0.0, y], &(&axis * long * axis.transpose())).unwrap()
        };
        assert!(needle(0.0, 0.7).intersects(&needle(0.3, -0.7)));
        assert!(!needle(0.0, 0.7).intersects(&needle(0.3, 0.7)));
    }
}
