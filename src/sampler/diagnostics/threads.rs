//! Threads of a run, and the error of ln Z from bootstrapping them.
//!
//! A point that dies is followed by one born at its contour: a thread, which is a nested sampling run
//! with a single live point. A run is a set of independent threads; drawing as many of them again, with
//! replacement, tells how much ln Z depends on chance, whatever the volumes are thought to be.
//!
//! # Source
//! Higson, Handley, Hobson & Lasenby 2018 (Bayesian Analysis 13, 873).

use crate::sampler::evidence::spread;
use crate::sampler::{NestedRun, log_add};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The threads of a run.
struct Threads {
    /// Points of each, by index, in the order of death.
    points: Vec<Vec<usize>>,
    /// Where and when it began: the first live points, or those added where a mode split off.
    stratum: Vec<usize>,
    n_strata: usize,
}

impl NestedRun {
    /// Standard deviation of ln Z over `n` bootstraps of the run's threads: a check on
    /// [`Evidence::log_z_err`](crate::sampler::Evidence::log_z_err), which trusts the volumes.
    pub fn log_z_err_bootstrap(&self, n: usize) -> f64 {
        let threads = self.threads();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let log_z: Vec<f64> = (0..n)
            .map(|_| self.resampled(&threads, &mut rng).log_z_expected())
            .collect();
        spread(&log_z)
    }

    fn log_z_expected(&self) -> f64 {
        self.log_parts()
            .into_iter()
            .fold(f64::NEG_INFINITY, log_add)
    }

    /// Follows every point to the one that replaced it.
    fn threads(&self) -> Threads {
        let ancestry = self.ancestry();
        let mut by_birth: Vec<usize> = (0..self.dead.len()).collect();
        by_birth.sort_by(|&a, &b| {
            let births = (self.dead[a].log_l_birth, self.dead[b].log_l_birth);
            births.0.total_cmp(&births.1).then(a.cmp(&b))
        });
        let mut threads = Threads {
            points: Vec::new(),
            stratum: Vec::new(),
            n_strata: self.tree.len(),
        };
        let mut thread_of = vec![0; self.dead.len()];
        // Threads of each mode whose point has died and not been replaced yet.
        let mut open: Vec<Vec<usize>> = vec![Vec::new(); self.tree.len()];
        let mut n_dead = 0;
        for i in by_birth {
            let point = &self.dead[i];
            while n_dead < self.dead.len() && self.dead[n_dead].log_l <= point.log_l_birth {
                open[self.dead[n_dead].mode].push(n_dead);
                n_dead += 1;
            }
            let is_first = point.log_l_birth == f64::NEG_INFINITY;
            let there = |&&node: &&usize| self.tree[node].log_l_split < point.log_l_birth;
            let parent = ancestry[point.mode].iter().find(there).copied();
            let before = parent
                .filter(|_| !is_first)
                .and_then(|node| open[node].pop());
            thread_of[i] = before.map_or(threads.points.len(), |before| thread_of[before]);
            if before.is_none() {
                threads.points.push(Vec::new());
                threads.stratum.push(if is_first { 0 } else { point.mode });
            }
            threads.points[thread_of[i]].push(i);
        }
        threads
    }

    /// A run made of as many threads, drawn with replacement from those that began in the same place.
    fn resampled(&self, threads: &Threads, rng: &mut ChaCha8Rng) -> Self {
        let mut strata = vec![Vec::new(); threads.n_strata];
        for (k, &stratum) in threads.stratum.iter().enumerate() {
            strata[stratum].push(k);
        }
        let mut chosen: Vec<(usize, bool)> = Vec::with_capacity(self.dead.len());
        for stratum in strata.iter().filter(|s| !s.is_empty()) {
            for _ in 0..stratum.len() {
                let k = stratum[rng.random_range(0..stratum.len())];
                let points = threads.points[k].iter().enumerate();
                let is_added = threads.stratum[k] != 0;
                chosen.extend(points.map(|(at, &i)| (i, is_added && at == 0)));
            }
        }
        chosen.sort_unstable();
        let mut run = Self {
            n_dim: self.n_dim,
            n_eval: self.n_eval,
            dead: chosen.iter().map(|&(i, _)| self.dead[i].clone()).collect(),
            tree: self.tree.clone(),
        };
        run.count_splits(&chosen);
        run
    }

    /// Counts the live points that each mode took from its parent; `added` ones came after that.
    fn count_splits(&mut self, chosen: &[(usize, bool)]) {
        let ancestry = self.ancestry();
        let mut n_split = vec![0; self.tree.len()];
        for (dead, &(_, is_added)) in self.dead.iter().zip(chosen) {
            for &node in &ancestry[dead.mode] {
                let contour = self.tree[node].log_l_split;
                let is_added = is_added && dead.log_l_birth == contour;
                n_split[node] += usize::from(dead.log_l_birth <= contour && !is_added);
            }
        }
        for (node, n) in self.tree.iter_mut().zip(n_split) {
            node.n_split = n;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{DeadPoint, ModeNode};

    fn dead(log_l: f64, log_l_birth: f64, mode: usize) -> DeadPoint {
        DeadPoint {
            u: vec![0.5],
            log_l,
            log_l_birth,
            mode,
            leaf: mode,
        }
    }

    #[test]
    fn threads_follow_replacements_and_a_split_begins_new_ones_for_added_points() {
        const START: f64 = f64::NEG_INFINITY;
        let child = |n_split| ModeNode {
            parent: Some(0),
            n_split,
            log_l_split: 2.0,
        };
        let run = NestedRun {
            n_dim: 1,
            n_eval: 0,
            dead: vec![
                dead(1.0, START, 0),
                dead(2.0, START, 0),
                dead(3.0, 2.0, 1), // replaces the second
                dead(4.0, 1.0, 1), // replaces the first
                dead(5.0, 2.0, 2), // added
                dead(6.0, START, 2),
                dead(7.0, 3.0, 1),
            ],
            tree: vec![ModeNode::root(3), child(2), child(1)],
        };
        let threads = run.threads();
        assert_eq!(
            threads.points,
            [vec![0, 3], vec![1, 2, 6], vec![5], vec![4]]
        );
        assert_eq!(threads.stratum, [0, 0, 0, 2]);
        let chosen: Vec<_> = (0..7).map(|i| (i, i == 4)).collect();
        let mut counted = run.clone();
        counted.count_splits(&chosen);
        assert_eq!(counted.tree, run.tree);
    }
}
