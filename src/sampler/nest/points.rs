//! Live points by slot.

use crate::sampler::bound::Cloud;

/// Storage of live points.
///
/// Wrapped dimensions are circles of length 1. Each set of points that is looked at together is cut open
/// at its widest gap: coordinates are then in [cut, cut + 1), so that nothing that is connected lies
/// on both sides of the edge.
#[derive(Debug, Default)]
pub(in crate::sampler) struct Points {
    n_dim: usize,
    wrapped: Vec<usize>,
    u: Vec<f64>,
    pub(in crate::sampler) log_l_birth: Vec<f64>,
    pub(in crate::sampler) cluster: Vec<usize>,
    free: Vec<usize>,
}

impl Points {
    pub(super) fn new(n_dim: usize, wrapped: &[usize]) -> Self {
        Self {
            n_dim,
            wrapped: wrapped.to_vec(),
            ..Self::default()
        }
    }

    pub(in crate::sampler) fn n_dim(&self) -> usize {
        self.n_dim
    }

    pub(super) fn n_slots(&self) -> usize {
        self.cluster.len()
    }

    pub(in crate::sampler) fn insert(
        &mut self,
        u: &[f64],
        log_l_birth: f64,
        cluster: usize,
    ) -> usize {
        if let Some(slot) = self.free.pop() {
            self.u[slot * self.n_dim..(slot + 1) * self.n_dim].copy_from_slice(u);
            self.log_l_birth[slot] = log_l_birth;
            self.cluster[slot] = cluster;
            return slot;
        }
        self.u.extend_from_slice(u);
        self.log_l_birth.push(log_l_birth);
        self.cluster.push(cluster);
        self.cluster.len() - 1
    }

    pub(super) fn release(&mut self, slot: usize) {
        self.free.push(slot);
    }

    pub(in crate::sampler) fn cloud(&self) -> Cloud<'_> {
        Cloud {
            u: &self.u,
            n_dim: self.n_dim,
        }
    }

    /// Brings `u` into the unit cube along wrapped dimensions; whether it is inside then.
    pub(in crate::sampler) fn wrap(&self, u: &mut [f64]) -> bool {
        for &d in &self.wrapped {
            u[d] = onto_circle(u[d]);
        }
        u.iter().all(|x| (0.0..1.0).contains(x))
    }

    /// Cuts the wrapped dimensions open at the widest gap between some points, whose coordinates change;
    /// where each dimension begins then.
    pub(super) fn cut(&mut self, slots: &[usize]) -> Vec<f64> {
        let mut low = vec![0.0; self.n_dim];
        for &d in &self.wrapped {
            let mut x: Vec<f64> = slots
                .iter()
                .map(|&s| onto_circle(self.u[s * self.n_dim + d]))
                .collect();
            x.sort_by(f64::total_cmp);
            let Some((&first, &last)) = x.first().zip(x.last()) else {
                continue;
            };
            let mut widest = (first + 1.0 - last, first);
            for pair in x.windows(2) {
                if pair[1] - pair[0] > widest.0 {
                    widest = (pair[1] - pair[0], pair[1]);
                }
            }
            let cut = widest.1 - widest.0 / 2.0;
            for &s in slots {
                let x = &mut self.u[s * self.n_dim + d];
                *x = cut + onto_circle(*x - cut);
            }
            low[d] = cut;
        }
        low
    }
}

/// `x` modulo 1, in [0, 1).
fn onto_circle(x: f64) -> f64 {
    let x = x - x.floor();
    // The difference of a tiny negative number rounds to 1.
    if x < 1.0 { x } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cluster_across_the_edge_is_in_one_piece_after_the_cut() {
        let mut points = Points::new(2, &[1]);
        let slots: Vec<usize> = [0.9, 0.95, 0.05, 0.1]
            .into_iter()
            .map(|y| points.insert(&[0.5, y], 0.0, 0))
            .collect();
        points.cut(&slots);
        let y: Vec<f64> = slots.iter().map(|&s| points.cloud().row(s)[1]).collect();
        let spread =
            y.iter().fold(f64::MIN, |a, &b| a.max(b)) - y.iter().fold(f64::MAX, |a, &b| a.min(b));
        assert!((spread - 0.2).abs() < 1e-12, "{y:?}");
        let mut u = points.cloud().row(slots[2]).to_vec();
        assert!(points.wrap(&mut u) && (u[1] - 0.05).abs() < 1e-12);
    }

    #[test]
    fn a_tiny_negative_number_stays_on_the_circle() {
        assert!(onto_circle(-1e-20) < 1.0);
    }
}
