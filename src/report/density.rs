//! How weighted samples are spread: histograms, and contours that hold a part of all weight.

use contour::ContourBuilder;

/// A range that is cut into equal bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bins {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) n: usize,
}

impl Bins {
    /// The bin of a value, none outside.
    fn of(&self, value: f64) -> Option<usize> {
        let along = (value - self.low) / (self.high - self.low);
        (0.0..1.0)
            .contains(&along)
            .then_some((along * self.n as f64) as usize)
    }
}

/// Values below which the parts `parts` of the weight lie; `None` without weight.
pub(super) fn quantiles<const N: usize>(
    values: &[f64],
    weights: &[f64],
    parts: [f64; N],
) -> Option<[f64; N]> {
    let mut order: Vec<usize> = (0..values.len()).filter(|&i| weights[i] > 0.0).collect();
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    let last = *order.last()?;
    let total: f64 = order.iter().map(|&i| weights[i]).sum();
    Some(parts.map(|part| {
        let mut below = 0.0;
        let reached = |i: &&usize| {
            below += weights[**i];
            below >= part * total
        };
        order
            .iter()
            .find(reached)
            .map_or(values[last], |&i| values[i])
    }))
}

/// The weight in each bin.
pub(super) fn histogram(values: &[f64], weights: &[f64], bins: Bins) -> Vec<f64> {
    let mut counts = vec![0.0; bins.n];
    for (value, weight) in values.iter().zip(weights) {
        if let Some(bin) = bins.of(*value) {
            counts[bin] += weight;
        }
    }
    counts
}

/// Weights in the cells of two ranges, smoothed; x runs fastest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Density {
    n: [usize; 2],
    cells: Vec<f64>,
}

impl Density {
    /// The density of samples over `bins` of x and of y, smoothed as befits so many of them.
    ///
    /// # Source
    /// Scott 1992, "Multivariate density estimation", equation 6.42, for two dimensions.
    pub(super) fn new([xs, ys]: [&[f64]; 2], weights: &[f64], bins: [Bins; 2]) -> Self {
        let n = bins.map(|b| b.n);
        let mut cells = vec![0.0; n[0] * n[1]];
        for ((x, y), weight) in xs.iter().zip(ys).zip(weights) {
            if let (Some(i), Some(j)) = (bins[0].of(*x), bins[1].of(*y)) {
                cells[j * n[0] + i] += weight;
            }
        }
        let (sum, squares) = (weights.iter()).fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        let n_eff = if squares > 0.0 {
            sum * sum / squares
        } else {
            1.0
        };
        let scott = n_eff.powf(-1.0 / 6.0);
        let width = |values: &[f64], bins: Bins| {
            scott * deviation(values, weights) * bins.n as f64 / (bins.high - bins.low)
        };
        let [width_x, width_y] = [width(xs, bins[0]), width(ys, bins[1])];
        let mut density = Self { n, cells };
        density.smooth(width_x, 1, n[0]);
        density.smooth(width_y, n[0], n[1]);
        density
    }

    /// Smooths lines of `length` cells that are `step` apart by a Gaussian of `width` cells; nothing
    /// leaves the grid.
    fn smooth(&mut self, width: f64, step: usize, length: usize) {
        if width <= 0.0 || !width.is_finite() {
            return;
        }
        let reach = (3.0 * width).ceil() as usize;
        let kernel: Vec<f64> = (0..=reach)
            .map(|i| (-0.5 * (i as f64 / width).powi(2)).exp())
            .collect();
        let old = self.cells.clone();
        self.cells.fill(0.0);
        for (at, &value) in old.iter().enumerate().filter(|(_, value)| **value > 0.0) {
            let along = at / step % length;
            let first = at - along * step;
            let near = along.saturating_sub(reach)..(along + reach + 1).min(length);
            let sum: f64 = near.clone().map(|k| kernel[k.abs_diff(along)]).sum();
            for k in near {
                self.cells[first + k * step] += value * kernel[k.abs_diff(along)] / sum;
            }
        }
    }

    /// The density above which the part `part` of all weight lies.
    fn level(&self, part: f64) -> f64 {
        let mut sorted = self.cells.clone();
        sorted.sort_by(|a, b| b.total_cmp(a));
        let wanted = part * sorted.iter().sum::<f64>();
        let mut sum = 0.0;
        let reached = |cell: &&f64| {
            sum += **cell;
            sum >= wanted
        };
        sorted.iter().find(reached).copied().unwrap_or(0.0)
    }

    /// Closed lines about the densest part that holds `part` of all weight, in units of the whole
    /// range; the first point is not repeated.
    pub(super) fn contour(&self, part: f64) -> Vec<Vec<[f64; 2]>> {
        let level = self.level(part);
        let n = self.n;
        let found = ContourBuilder::new(n[0], n[1], true).contours(&self.cells, &[level]);
        let mut lines = Vec::new();
        for polygon in found.iter().flatten().flat_map(contour::Contour::geometry) {
            for ring in std::iter::once(polygon.exterior()).chain(polygon.interiors()) {
                let points = ring
                    .0
                    .iter()
                    .map(|p| [p.x / n[0] as f64, p.y / n[1] as f64]);
                let mut points: Vec<[f64; 2]> = points.collect();
                points.pop();
                lines.push(points);
            }
        }
        lines
    }
}

/// Weighted standard deviation.
fn deviation(values: &[f64], weights: &[f64]) -> f64 {
    let total: f64 = weights.iter().sum();
    let mean = values.iter().zip(weights).map(|(v, w)| v * w).sum::<f64>() / total;
    let squares = values
        .iter()
        .zip(weights)
        .map(|(v, w)| w * (v - mean).powi(2));
    (squares.sum::<f64>() / total).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn quantiles_by_hand() {
        let q = quantiles(&[3.0, 1.0, 2.0], &[1.0, 1.0, 2.0], [0.25, 0.5, 1.0]);
        assert_eq!(q, Some([1.0, 2.0, 3.0]));
        assert_eq!(quantiles(&[1.0], &[0.0], [0.5]), None);
    }

    #[test]
    fn the_weight_stays_and_falls_into_its_bins() {
        let bins = Bins {
            low: 0.0,
            high: 4.0,
            n: 4,
        };
        assert_eq!(
            histogram(
                &[0.5, 0.6, 3.9, 4.0, -1.0],
                &[1.0, 2.0, 3.0, 4.0, 5.0],
                bins
            ),
            [3.0, 0.0, 0.0, 3.0]
        );
        let density = Density::new([&[0.1, 3.9], &[0.1, 2.0]], &[0.25, 0.75], [bins; 2]);
        assert!((density.cells.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    /// Of a circular Gaussian, 1 - exp(-r²/2) lies within r standard deviations: half within 1.177.
    #[test]
    fn half_of_a_gaussian_lies_within_its_contour() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut draw = || -> Vec<f64> {
            (0..20_000)
                .map(|_| StandardNormal.sample(&mut rng))
                .collect()
        };
        let (xs, ys) = (draw(), draw());
        let bins = Bins {
            low: -4.0,
            high: 4.0,
            n: 32,
        };
        let density = Density::new([&xs, &ys], &vec![1.0; xs.len()], [bins; 2]);
        let lines = density.contour(0.5);
        assert_eq!(lines.len(), 1);
        for [x, y] in &lines[0] {
            let radius = (8.0 * x - 4.0).hypot(8.0 * y - 4.0);
            assert!((radius - 1.177).abs() < 0.25, "{radius}");
        }
    }
}
