//! Whether a run can be trusted: functions of its dead points.

mod chains;
mod health;
mod insertion;
mod threads;

pub(super) use chains::{chain_ess, split_r_hat};
pub use health::Health;
pub use insertion::InsertionTest;

use super::NestedRun;
use super::evidence::{Expected, Volumes};

/// How many live points a mode had, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeHistory {
    /// The mode: index into [`NestedRun::tree`].
    pub node: usize,
    /// At the death of each of its points: ln L, expected ln X before it died, live points.
    pub steps: Vec<(f64, f64, usize)>,
}

impl std::fmt::Display for ModeHistory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { node, steps } = self;
        let most = steps.iter().map(|(.., n_live)| *n_live).max();
        match (steps.first(), steps.last(), most) {
            (Some(first), Some(last), Some(most)) => write!(
                f,
                "mode {node}: ln L {:.2} to {:.2}, ln X {:.2} to {:.2}, {} live points at first, {most} at most",
                first.0, last.0, first.1, last.1, first.2
            ),
            _ => write!(f, "mode {node}: no points of its own"),
        }
    }
}

impl NestedRun {
    /// Dead points per likelihood evaluation.
    pub fn efficiency(&self) -> f64 {
        self.dead.len() as f64 / self.n_eval.max(1) as f64
    }

    /// Live points along the life of every mode, in the order of the tree, ln L ascending.
    pub fn live_history(&self) -> Vec<ModeHistory> {
        let history = |node| ModeHistory {
            node,
            steps: Vec::new(),
        };
        let mut histories: Vec<ModeHistory> = (0..self.tree.len()).map(history).collect();
        let volumes = Volumes::of(self);
        let n_live = volumes.n_live.clone();
        volumes.visit(self, &mut Expected, |i, log_x, _| {
            let dead = &self.dead[i];
            histories[dead.mode]
                .steps
                .push((dead.log_l, log_x, n_live[i]));
        });
        histories
    }

    /// For each mode, the modes that it descends from, itself first.
    fn ancestry(&self) -> Vec<Vec<usize>> {
        let up = |node: usize| std::iter::successors(Some(node), |&i| self.tree[i].parent);
        (0..self.tree.len())
            .map(|node| up(node).collect())
            .collect()
    }
}
