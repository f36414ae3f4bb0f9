//! What the diagnostics of one run or of many together say.

use crate::sampler::NestedRun;

/// Bootstraps of each run: the error of their spread is 16%, and less over many runs.
const N_BOOTSTRAP: usize = 20;
/// A run has failed its insertion test if this is improbable, given how many were tested.
const SUSPECT_P: f64 = 1e-3;
/// The mean rank, which is 1/2 in fair runs, from which a failed test matters: ln Z is then too high by
/// some 4% of the information.
const SUSPECT_MEAN: f64 = 0.02;

/// The health of one run, or of several added up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Health {
    /// Runs.
    pub n_run: usize,
    /// Likelihood evaluations of all.
    pub n_eval: u64,
    /// Dead points of all.
    pub n_dead: u64,
    /// Points with an insertion rank.
    pub n_rank: usize,
    /// Fewest live points with which an undivided mode began, over all runs; 0 without runs.
    pub fewest_live: usize,
    least_p: f64,
    rank_sum: f64,
    quoted_variance: f64,
    bootstrap_variance: f64,
}

impl NestedRun {
    /// The diagnostics of this run; costs about as much as a second evidence.
    pub fn health(&self, log_z_err: f64) -> Health {
        let test = self.insertion_test();
        let is_parent = |node: usize| self.tree.iter().any(|child| child.parent == Some(node));
        let leaves = (0..self.tree.len()).filter(|&node| !is_parent(node));
        Health {
            n_run: 1,
            n_eval: self.n_eval,
            n_dead: self.dead.len() as u64,
            n_rank: test.n,
            fewest_live: leaves
                .map(|node| self.tree[node].n_split)
                .min()
                .unwrap_or(0),
            least_p: test.p_value.min(test.p_value_parts),
            rank_sum: test.mean * test.n as f64,
            quoted_variance: log_z_err.powi(2),
            bootstrap_variance: self.log_z_err_bootstrap(N_BOOTSTRAP).powi(2),
        }
    }
}

impl Health {
    /// Dead points per likelihood evaluation.
    pub fn efficiency(&self) -> f64 {
        self.n_dead as f64 / self.n_eval.max(1) as f64
    }

    /// The least probability of any run's insertion test, times the number of tests.
    pub fn insertion_p(&self) -> f64 {
        // Of a run, the test of the whole and of its parts.
        (2.0 * self.n_run as f64 * self.least_p).min(1.0)
    }

    /// Mean insertion rank, from 0 to 1: 1/2 if all is well.
    pub fn insertion_mean(&self) -> f64 {
        self.rank_sum / self.n_rank as f64
    }

    /// Standard deviation of ln Z as quoted, rms over runs.
    pub fn log_z_err(&self) -> f64 {
        (self.quoted_variance / self.n_run as f64).sqrt()
    }

    /// Standard deviation of ln Z over bootstraps of the threads, rms over runs.
    pub fn log_z_err_bootstrap(&self) -> f64 {
        (self.bootstrap_variance / self.n_run as f64).sqrt()
    }

    /// Whether new points did not come to lie evenly among the live ones: the evidences are then biased.
    pub fn is_suspect(&self) -> bool {
        self.insertion_p() < SUSPECT_P && (self.insertion_mean() - 0.5).abs() > SUSPECT_MEAN
    }
}

impl std::ops::AddAssign for Health {
    fn add_assign(&mut self, other: Self) {
        if self.n_run == 0 || other.n_run == 0 {
            *self = if self.n_run == 0 { other } else { *self };
            return;
        }
        self.n_run += other.n_run;
        self.n_eval += other.n_eval;
        self.n_dead += other.n_dead;
        self.n_rank += other.n_rank;
        self.fewest_live = self.fewest_live.min(other.fewest_live);
        self.least_p = self.least_p.min(other.least_p);
        self.rank_sum += other.rank_sum;
        self.quoted_variance += other.quoted_variance;
        self.bootstrap_variance += other.bootstrap_variance;
    }
}

impl std::iter::Sum for Health {
    fn sum<I: Iterator<Item = Self>>(each: I) -> Self {
        each.fold(Self::default(), |mut all, one| {
            all += one;
            all
        })
    }
}

impl std::fmt::Display for Health {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} runs, {:.3} dead points an evaluation, insertion test: mean rank {:.4}, p {:.2}; ln Z good to \
             {:.3} ({:.3} by bootstrap); modes began with {} live points or more",
            self.n_run,
            self.efficiency(),
            self.insertion_mean(),
            self.insertion_p(),
            self.log_z_err(),
            self.log_z_err_bootstrap(),
            self.fewest_live,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::problems;
    use crate::sampler::{MultiNest, MultiNestConfig, run};
    use std::convert::Infallible;
    use std::ops::ControlFlow;

    fn finished(seed: u64) -> NestedRun {
        let problem = problems::shells(2);
        let config = MultiNestConfig {
            seed,
            ..MultiNestConfig::new(2, 200)
        };
        let log_l =
            |u: &[f64]| Ok::<_, Infallible>(u.chunks(2).map(|u| problem.log_l(u)).collect());
        let sampler = Box::new(MultiNest::new(config).unwrap());
        run(sampler, log_l, |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn fair_runs_are_healthy_and_add_up() {
        let runs = [1, 2, 3].map(finished);
        let each = runs
            .each_ref()
            .map(|run| run.health(run.evidence().log_z_err));
        let all: Health = each.iter().copied().sum();
        assert_eq!(
            (all.n_run, all.n_eval),
            (3, runs.iter().map(|r| r.n_eval).sum())
        );
        assert!(!all.is_suspect(), "{all}");
        assert!((all.insertion_mean() - 0.5).abs() < 0.02, "{all}");
        let ratio = all.log_z_err_bootstrap() / all.log_z_err();
        assert!((0.6..1.6).contains(&ratio), "{all}");
        // Two shells: each began with about half of the live points.
        assert!((60..=100).contains(&all.fewest_live), "{all}");
        let doubled: Health = [all, Health::default()].into_iter().sum();
        assert_eq!(doubled, all);
    }

    #[test]
    fn a_run_that_draws_too_well_is_suspect() {
        let mut run = finished(1);
        // As if every point had been drawn above a contour that many of the live points lay below.
        let log_l: Vec<f64> = run.dead.iter().map(|dead| dead.log_l).collect();
        for dead in run
            .dead
            .iter_mut()
            .filter(|dead| dead.log_l_birth.is_finite())
        {
            let place = log_l.partition_point(|l| *l < dead.log_l_birth);
            dead.log_l_birth = log_l[place.saturating_sub(100)];
        }
        assert!(run.health(0.1).is_suspect());
    }
}
