//! A union of ellipsoids as one region to draw from uniformly.

use super::ellipsoid::Ellipsoid;
use rand::{Rng, RngExt};

/// Ellipsoids that may overlap; none means the whole unit cube.
#[derive(Debug, Clone, Default)]
pub(in crate::sampler) struct Union {
    ellipsoids: Vec<Ellipsoid>,
    /// Running sum of volumes over their total.
    cumulative: Vec<f64>,
    /// Where each dimension of the cube begins.
    low: Vec<f64>,
}

impl Union {
    /// Takes ellipsoids, and where each dimension of the cube begins: 0, or where a circle is cut open.
    pub(in crate::sampler) fn new(ellipsoids: Vec<Ellipsoid>, low: &[f64]) -> Self {
        let logs = || ellipsoids.iter().map(Ellipsoid::log_volume);
        let max = logs().fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = logs()
            .map(|log| {
                sum += (log - max).exp();
                sum
            })
            .collect();
        for x in &mut cumulative {
            *x /= sum;
        }
        Self {
            ellipsoids,
            cumulative,
            low: low.to_vec(),
        }
    }

    /// The ellipsoids.
    pub(in crate::sampler) fn ellipsoids(&self) -> &[Ellipsoid] {
        &self.ellipsoids
    }

    /// One try to draw a point uniformly from the union: the ellipsoid it came from, or none
    /// when the try failed.
    ///
    /// An ellipsoid is chosen by volume, a point in q ellipsoids is kept with probability 1/q
    /// (FHB09 section 5.3), and a point outside the unit cube is not kept.
    pub(in crate::sampler) fn draw(&self, rng: &mut impl Rng, u: &mut [f64]) -> Option<usize> {
        if self.ellipsoids.is_empty() {
            u.fill_with(|| rng.random());
            return Some(0);
        }
        let choice: f64 = rng.random();
        let chosen = self
            .cumulative
            .partition_point(|&c| c <= choice)
            .min(self.ellipsoids.len() - 1);
        self.ellipsoids[chosen].sample(rng, u);
        let mut inside = u.iter().zip(&self.low);
        if !inside.all(|(x, low)| (0.0..1.0).contains(&(x - low))) {
            return None;
        }
        let others = self.ellipsoids.iter().enumerate();
        let count = 1 + others
            .filter(|(i, e)| *i != chosen && e.contains(u))
            .count();
        (count == 1 || rng.random::<f64>() * (count as f64) < 1.0).then_some(chosen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn overlapping_discs_are_drawn_uniformly() {
        let disc =
            |x: f64, r: f64| Ellipsoid::new(&[x, 0.5], &(DMatrix::identity(2, 2) * r * r)).unwrap();
        let union = Union::new(
            vec![disc(0.4, 0.2), disc(0.5, 0.2), disc(0.9, 0.2)],
            &[0.0; 2],
        );
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut u = [0.0; 2];
        // Two boxes of equal size: one in the overlap, one in a single disc.
        let (mut double, mut single) = (0, 0);
        for _ in 0..200_000 {
            if union.draw(&mut rng, &mut u).is_some() {
                assert!(u[0] < 1.0, "outside the cube");
                double += usize::from((u[0] - 0.45).abs() < 0.05 && (u[1] - 0.5).abs() < 0.05);
                single += usize::from((u[0] - 0.9).abs() < 0.05 && (u[1] - 0.5).abs() < 0.05);
            }
        }
        let (a, b) = (double as f64, single as f64);
        assert!((a - b).abs() < 4.0 * (a + b).sqrt(), "{a} {b}");
    }
}
