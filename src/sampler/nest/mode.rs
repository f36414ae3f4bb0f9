//! One mode in progress: its live points, contour and volume.

use crate::sampler::log_add;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A live point, ordered by ln L; equal ones by age.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::sampler) struct Live {
    pub(in crate::sampler) log_l: f64,
    pub(in crate::sampler) slot: usize,
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
pub(in crate::sampler) struct Mode {
    /// Its node in the tree of modes.
    pub(in crate::sampler) node: usize,
    /// Expected ln X at the contour.
    pub(in crate::sampler) log_x: f64,
    /// Live points wanted before the contour moves (again).
    pub(in crate::sampler) target: usize,
    /// Where each dimension begins: 0, or the cut of a circle.
    pub(in crate::sampler) low: Vec<f64>,
    live: BinaryHeap<Reverse<Live>>,
    n_dead: usize,
    contour: f64,
    ties: usize,
    log_z: f64,
    log_l_max: f64,
}

impl Mode {
    /// A mode without live points at a contour.
    pub(in crate::sampler) fn new(node: usize, log_x: f64, contour: f64, target: usize) -> Self {
        Self {
            node,
            log_x,
            target,
            low: Vec::new(),
            live: BinaryHeap::new(),
            n_dead: 0,
            contour,
            ties: 0,
            log_z: f64::NEG_INFINITY,
            log_l_max: f64::NEG_INFINITY,
        }
    }

    /// The whole cube, before any point is drawn.
    pub(in crate::sampler) fn whole(n_live: usize) -> Self {
        Self::new(0, 0.0, f64::NEG_INFINITY, n_live)
    }

    /// Points that have died in it.
    pub(in crate::sampler) fn n_dead(&self) -> usize {
        self.n_dead
    }

    pub(in crate::sampler) fn n_live(&self) -> usize {
        self.live.len()
    }

    /// Live points still missing.
    pub(in crate::sampler) fn missing(&self) -> usize {
        self.target.saturating_sub(self.live.len())
    }

    /// Every draw must exceed this.
    pub(in crate::sampler) fn contour(&self) -> f64 {
        self.contour
    }

    /// ln L of the worst live point.
    pub(in crate::sampler) fn worst(&self) -> Option<f64> {
        self.live.peek().map(|worst| worst.0.log_l)
    }

    /// Slots of the live points, ascending.
    pub(in crate::sampler) fn slots(&self) -> Vec<usize> {
        let mut slots: Vec<usize> = self.live.iter().map(|live| live.0.slot).collect();
        slots.sort_unstable();
        slots
    }

    /// The live points, by slot.
    pub(in crate::sampler) fn points(&self) -> Vec<Live> {
        let mut points: Vec<Live> = self.live.iter().map(|live| live.0).collect();
        points.sort_unstable_by_key(|live| live.slot);
        points
    }

    /// All live points, which leave.
    pub(in crate::sampler) fn drain(&mut self) -> Vec<Live> {
        std::mem::take(&mut self.live)
            .into_iter()
            .map(|live| live.0)
            .collect()
    }

    /// Adds a live point.
    pub(in crate::sampler) fn push(&mut self, live: Live) {
        self.log_l_max = self.log_l_max.max(live.log_l);
        self.live.push(Reverse(live));
    }

    /// Takes the worst point out: the volume shrinks by 1/n and its evidence is added.
    ///
    /// Points of equal ln L leave together: the live count falls within them, whatever was drawn
    /// above them meanwhile (Fowlie, Handley & Su 2021, MNRAS 503, 1199).
    pub(in crate::sampler) fn pop(&mut self) -> Option<Live> {
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
        self.n_dead += 1;
        Some(worst)
    }

    /// The most that its live points may still add.
    pub(in crate::sampler) fn log_z_remaining(&self) -> f64 {
        self.log_x + self.log_l_max
    }

    /// Whether the rest is below `tolerance` of what its own dead points hold, or all live points
    /// lie on one plateau, from which nothing can climb.
    pub(in crate::sampler) fn is_finished(&self, tolerance: f64) -> bool {
        let flat = self.log_l_max.is_finite() && self.worst() == Some(self.log_l_max);
        flat || self.log_z_remaining() < self.log_z + tolerance.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_points_leave_with_a_falling_live_count() {
        let mut mode = Mode::new(0, 0.0, f64::NEG_INFINITY, 3);
        for (slot, log_l) in [1.0, 0.0, 0.0].into_iter().enumerate() {
            mode.push(Live { log_l, slot });
        }
        mode.pop();
        mode.push(Live {
            log_l: 2.0,
            slot: 1,
        });
        mode.pop();
        assert!((mode.log_x + 1.0 / 3.0 + 1.0 / 2.0).abs() < 1e-12);
        mode.push(Live {
            log_l: 2.0,
            slot: 2,
        });
        mode.pop();
        assert!((mode.log_x + 1.0 / 3.0 + 1.0 / 2.0 + 1.0 / 3.0).abs() < 1e-12);
    }
}
