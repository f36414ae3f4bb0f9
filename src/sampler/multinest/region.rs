//! One mode in progress: its live points, contour, volume and bound.

use crate::sampler::bound::{Neighbourhood, Union};
use crate::sampler::log_add;
use nalgebra::DMatrix;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A live point, ordered by ln L; equal ones by age.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Live {
    pub(super) log_l: f64,
    pub(super) slot: usize,
}

impl Eq for Live {}

impl Ord for Live {
    fn cmp(&self, other: &Self) -> Ordering {
        self.log_l
            .total_cmp(&other.log_l)
            .then(self.slot.cmp(&other.slot))
    }
}

impl PartialOrd for Live {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// A mode with live points.
#[derive(Debug)]
pub(super) struct Region {
    /// Its node in the tree of modes.
    pub(super) node: usize,
    /// Where proposals come from.
    pub(super) bound: Union,
    /// What of it is near a live point; none: all.
    pub(super) near: Option<Neighbourhood>,
    /// Expected ln X at the contour.
    pub(super) log_x: f64,
    /// Live points wanted before the contour moves (again).
    pub(super) target: usize,
    /// Deaths since the clusters were last searched for.
    pub(super) since_search: usize,
    /// Deaths since the ellipsoids were last fitted, and live points at that time.
    pub(super) since_fit: usize,
    pub(super) n_at_fit: usize,
    /// Evaluations since the ellipsoids were last fitted.
    pub(super) n_tried: u64,
    /// Few of the points that its ellipsoids propose are good.
    pub(super) is_curved: bool,
    /// Evaluations since a point was last accepted.
    pub(super) barren: u64,
    /// Covariance of the modes that it split off together with.
    pub(super) typical: Option<DMatrix<f64>>,
    live: BinaryHeap<Reverse<Live>>,
    contour: f64,
    ties: usize,
    log_z: f64,
    log_l_max: f64,
}

impl Region {
    /// A region without live points at a contour.
    pub(super) fn new(node: usize, log_x: f64, contour: f64, target: usize) -> Self {
        Self {
            node,
            bound: Union::default(),
            near: None,
            log_x,
            target,
            since_search: 0,
            since_fit: 0,
            n_at_fit: 0,
            n_tried: 0,
            is_curved: false,
            barren: 0,
            typical: None,
            live: BinaryHeap::new(),
            contour,
            ties: 0,
            log_z: f64::NEG_INFINITY,
            log_l_max: f64::NEG_INFINITY,
        }
    }

    pub(super) fn n_live(&self) -> usize {
        self.live.len()
    }

    /// Live points still missing.
    pub(super) fn missing(&self) -> usize {
        self.target.saturating_sub(self.live.len())
    }

    /// Every draw must exceed this.
    pub(super) fn contour(&self) -> f64 {
        self.contour
    }

    /// ln L of the worst live point.
    pub(super) fn worst(&self) -> Option<f64> {
        self.live.peek().map(|worst| worst.0.log_l)
    }

    /// Slots of the live points, ascending.
    pub(super) fn slots(&self) -> Vec<usize> {
        let mut slots: Vec<usize> = self.live.iter().map(|live| live.0.slot).collect();
        slots.sort_unstable();
        slots
    }

    /// All live points, which leave.
    pub(super) fn drain(&mut self) -> Vec<Live> {
        std::mem::take(&mut self.live)
            .into_iter()
            .map(|live| live.0)
            .collect()
    }

    /// Adds a live point.
    pub(super) fn push(&mut self, live: Live) {
        self.log_l_max = self.log_l_max.max(live.log_l);
        self.live.push(Reverse(live));
    }

    /// Takes the worst point out: the volume shrinks by 1/n and its evidence is added.
    ///
    /// Points of equal ln L leave together: the live count falls within them, whatever was drawn
    /// above them meanwhile (Fowlie, Handley & Su 2021, MNRAS 503, 1199).
    pub(super) fn pop(&mut self) -> Option<Live> {
        let worst = self.live.pop()?.0;
        self.ties = if worst.log_l == self.contour {
            self.ties + 1
        } else {
            0
        };
        let n_live = (self.live.len() + 1).saturating_sub(self.ties).max(1) as f64;
        let log_w = self.log_x + (-(-1.0 / n_live).exp_m1()).ln();
        self.log_x -= 1.0 / n_live;
        self.log_z = log_add(self.log_z, log_w + worst.log_l);
        self.contour = worst.log_l;
        self.since_search += 1;
        self.since_fit += 1;
        Some(worst)
    }

    /// The most that its live points may still add.
    pub(super) fn log_z_remaining(&self) -> f64 {
        self.log_x + self.log_l_max
    }

    /// Whether the rest is below `tolerance` of what its own dead points hold, or all live points
    /// lie on one plateau, from which nothing can climb.
    pub(super) fn is_finished(&self, tolerance: f64) -> bool {
        let flat = self.log_l_max.is_finite() && self.worst() == Some(self.log_l_max);
        flat || self.log_z_remaining() < self.log_z + tolerance.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_points_leave_with_a_falling_live_count() {
        let mut region = Region::new(0, 0.0, f64::NEG_INFINITY, 3);
        for (slot, log_l) in [1.0, 0.0, 0.0].into_iter().enumerate() {
            region.push(Live { log_l, slot });
        }
        region.pop();
        region.push(Live {
            log_l: 2.0,
            slot: 1,
        });
        region.pop();
        assert!((region.log_x + 1.0 / 3.0 + 1.0 / 2.0).abs() < 1e-12);
        region.push(Live {
            log_l: 2.0,
            slot: 2,
        });
        region.pop();
        assert!((region.log_x + 1.0 / 3.0 + 1.0 / 2.0 + 1.0 / 3.0).abs() < 1e-12);
    }
}
