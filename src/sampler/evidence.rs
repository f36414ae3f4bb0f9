//! Volumes, weights and evidence as functions of dead points with birth contours.
//!
//! # Formula
//! Within a mode, dead point i of n_i live ones shrinks the volume by t_i ~ Beta(n_i, 1), so
//! ⟨ln t⟩ = -1/n; its weight is w_i = X_{i-1} - X_i, and Z = Σ w_i L_i. The last point of a mode takes all
//! the volume that is left. Where a mode with n live points splits, the shares of its children are
//! Dirichlet(n_1, n_2, ..), ⟨share⟩ = n_k/n. Values come from these means, errors from
//! simulating all shrinkages and shares some hundred times. Independent errors σ of the ln Z of modes make the
//! ln of their sum too large by up to σ²/2, and by the same again in the simulations, which so tell what to take off.
//!
//! # Source
//! Skilling 2006, Bayesian Analysis 1, 833; splits: Handley, Hobson & Lasenby 2015 (MNRAS 453,
//! 4384), section 4.6.

use super::{NestedRun, log_add};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp1, Gamma};

/// Simulated volume histories: the error of the error is 4%.
const N_SIMULATIONS: usize = 300;

/// ln of a term, against the largest expected one, that no sum will notice.
const NEGLIGIBLE: f64 = -60.0;

/// Evidence of a run and what its posterior amounts to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// ln Z; not quite that of the sum over [`NestedRun::modes`], which is biased upwards.
    pub log_z: f64,
    /// Its standard deviation over simulated volumes.
    pub log_z_err: f64,
    /// Information: mean of ln(L/Z) over the posterior, in nat.
    pub kl_nats: f64,
    /// Effective sample size (Σw)²/Σw².
    pub ess: f64,
}

impl NestedRun {
    /// Live points when each dead point died, itself included.
    ///
    /// A point counts for its mode from its birth, in the mode or an ancestor, to its death, in the mode
    /// or a descendant. Points of equal ln L leave one after the other.
    pub fn live_counts(&self) -> Vec<usize> {
        let mut births: Vec<Vec<f64>> = vec![Vec::new(); self.tree.len()];
        for dead in &self.dead {
            let mut node = Some(dead.mode);
            while let Some(i) = node {
                births[i].push(dead.log_l_birth);
                node = self.tree[i].parent;
            }
        }
        for births in &mut births {
            births.sort_by(f64::total_cmp);
        }
        let mut n_born = vec![0; self.tree.len()];
        let mut n_dead = vec![0; self.tree.len()];
        let count = |dead: &super::DeadPoint| {
            let (i, born) = (dead.mode, &mut n_born[dead.mode]);
            while births[i]
                .get(*born)
                .is_some_and(|b| *b < dead.log_l || *b == f64::NEG_INFINITY)
            {
                *born += 1;
            }
            n_dead[i] += 1;
            *born + 1 - n_dead[i]
        };
        self.dead.iter().map(count).collect()
    }

    /// ln of the posterior weight of each dead point; the weights sum to 1.
    pub fn log_weights(&self) -> Vec<f64> {
        let mut log_w = self.log_parts();
        let total = log_w.iter().copied().fold(f64::NEG_INFINITY, log_add);
        for log_w in &mut log_w {
            *log_w -= total;
        }
        log_w
    }

    /// Expected ln of w L of each dead point, its part of Z.
    pub(super) fn log_parts(&self) -> Vec<f64> {
        let mut log_w = vec![f64::NEG_INFINITY; self.dead.len()];
        Volumes::of(self).visit(self, &mut Expected, |i, log_x, part| {
            log_w[i] = log_x + part.ln() + self.dead[i].log_l;
        });
        log_w
    }

    /// Evidence, its error, information and effective sample size.
    pub fn evidence(&self) -> Evidence {
        let log_w = self.log_parts();
        let simulated = Simulated::of(self, &log_w);
        let totals: Vec<f64> = (0..N_SIMULATIONS)
            .map(|s| {
                simulated
                    .shared
                    .iter()
                    .map(|leaf| leaf[s])
                    .fold(f64::NEG_INFINITY, log_add)
            })
            .collect();
        let all = self
            .dead
            .iter()
            .zip(&log_w)
            .map(|(dead, &w)| (dead.log_l, w));
        let (log_z, kl_nats, ess) = moments(all);
        let excess = totals.iter().filter(|t| t.is_finite()).map(|t| t - log_z);
        Evidence {
            log_z: log_z - excess.sum::<f64>() / N_SIMULATIONS as f64,
            log_z_err: spread(&totals),
            kl_nats,
            ess,
        }
    }
}

/// ln Z, information and effective sample size of points (ln L, ln wL).
pub(super) fn moments(points: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, f64, f64) {
    let log_z = points
        .clone()
        .map(|(_, w)| w)
        .fold(f64::NEG_INFINITY, log_add);
    let (mut kl, mut squares) = (0.0, 0.0);
    for (log_l, log_w) in points {
        let p = (log_w - log_z).exp();
        if p > 0.0 {
            kl += p * (log_l - log_z);
            squares += p * p;
        }
    }
    (log_z, kl, 1.0 / squares)
}

/// Standard deviation of the finite values.
pub(super) fn spread(values: &[f64]) -> f64 {
    let finite = || values.iter().filter(|x| x.is_finite());
    let n = finite().count() as f64;
    let mean = finite().sum::<f64>() / n;
    (finite().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt()
}

/// 1 - exp(-x); most of x are 1/n, where four terms of the series give 10 digits in a fraction of the time.
fn one_minus_exp(x: f64) -> f64 {
    if x < 0.03 {
        x * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0))))
    } else {
        -(-x).exp_m1()
    }
}

/// Where the shrinkages come from.
pub(super) trait Shrinkage {
    /// ln of a Beta(n, 1) variable.
    fn log_t(&mut self, n_live: usize) -> f64;
    /// ln of the shares of a split.
    fn log_shares(&mut self, n_split: &[usize]) -> Vec<f64>;
}

/// Means of ln t, and of shares.
pub(super) struct Expected;

impl Shrinkage for Expected {
    fn log_t(&mut self, n_live: usize) -> f64 {
        -1.0 / n_live as f64
    }

    fn log_shares(&mut self, n_split: &[usize]) -> Vec<f64> {
        let total: usize = n_split.iter().sum();
        let log_share = |&n: &usize| (n as f64 / total as f64).ln();
        n_split.iter().map(log_share).collect()
    }
}

/// Random draws.
struct Drawn(ChaCha8Rng);

impl Shrinkage for Drawn {
    fn log_t(&mut self, n_live: usize) -> f64 {
        let e: f64 = Exp1.sample(&mut self.0);
        -e / n_live as f64
    }

    fn log_shares(&mut self, n_split: &[usize]) -> Vec<f64> {
        let mut draw = |n: usize| {
            // A shape of at least 1 is always valid.
            Gamma::new(n.max(1) as f64, 1.0).map_or(n as f64, |gamma| gamma.sample(&mut self.0))
        };
        let gammas: Vec<f64> = n_split.iter().map(|&n| draw(n)).collect();
        let total: f64 = gammas.iter().sum();
        gammas.iter().map(|g| (g / total).ln()).collect()
    }
}

/// What the volumes depend on.
pub(super) struct Volumes {
    /// Dead points of each mode, ln L ascending.
    order: Vec<Vec<usize>>,
    children: Vec<Vec<usize>>,
    /// Live points at each death.
    pub(super) n_live: Vec<usize>,
}

impl Volumes {
    pub(super) fn of(run: &NestedRun) -> Self {
        let mut order = vec![Vec::new(); run.tree.len()];
        run.dead
            .iter()
            .enumerate()
            .for_each(|(i, dead)| order[dead.mode].push(i));
        let mut children = vec![Vec::new(); run.tree.len()];
        for (i, node) in run.tree.iter().enumerate() {
            if let Some(parent) = node.parent {
                children[parent].push(i);
            }
        }
        Self {
            order,
            children,
            n_live: run.live_counts(),
        }
    }

    /// Visits every dead point under one history of shrinkages: its index, ln X before it died, and the
    /// part of X that is its weight.
    pub(super) fn visit(
        &self,
        run: &NestedRun,
        shrinkage: &mut impl Shrinkage,
        mut visit: impl FnMut(usize, f64, f64),
    ) {
        let mut log_x = vec![0.0; run.tree.len()];
        for node in 0..run.tree.len() {
            let mut here = log_x[node];
            let is_leaf = self.children[node].is_empty();
            for (k, &i) in self.order[node].iter().enumerate() {
                let last = is_leaf && k + 1 == self.order[node].len();
                let log_t = shrinkage.log_t(self.n_live[i]);
                visit(i, here, if last { 1.0 } else { one_minus_exp(-log_t) });
                here += log_t;
            }
            let n_split: Vec<_> = self.children[node]
                .iter()
                .map(|&c| run.tree[c].n_split)
                .collect();
            let shares = shrinkage.log_shares(&n_split);
            for (&child, share) in self.children[node].iter().zip(shares) {
                log_x[child] = here + share;
            }
        }
    }
}

/// Evidence of each mode under simulated volumes.
pub(super) struct Simulated {
    /// ln Z by mode and simulation, from all points in the mode's part of the cube.
    pub(super) shared: Vec<Vec<f64>>,
    /// The same from points that died in the mode itself.
    pub(super) strict: Vec<Vec<f64>>,
}

impl Simulated {
    /// Simulates the volumes; `log_w`, the expected weights, set the scale of each sum.
    pub(super) fn of(run: &NestedRun, log_w: &[f64]) -> Self {
        let n_modes = run.tree.len();
        let mut scale = vec![f64::NEG_INFINITY; n_modes];
        for (dead, &w) in run.dead.iter().zip(log_w) {
            scale[dead.leaf] = scale[dead.leaf].max(w);
        }
        let volumes = Volumes::of(run);
        let mut drawn = Drawn(ChaCha8Rng::seed_from_u64(0));
        let mut simulated = Self {
            shared: vec![Vec::with_capacity(N_SIMULATIONS); n_modes],
            strict: vec![Vec::with_capacity(N_SIMULATIONS); n_modes],
        };
        for _ in 0..N_SIMULATIONS {
            let mut sums = vec![[0.0; 2]; n_modes];
            volumes.visit(run, &mut drawn, |i, log_x, part| {
                let dead = &run.dead[i];
                let log_term = log_x + dead.log_l - scale[dead.leaf];
                if log_term > NEGLIGIBLE {
                    let term = part * log_term.exp();
                    sums[dead.leaf][0] += term;
                    sums[dead.leaf][1] += if dead.leaf == dead.mode { term } else { 0.0 };
                }
            });
            for (mode, [shared, strict]) in sums.into_iter().enumerate() {
                simulated.shared[mode].push(shared.ln() + scale[mode]);
                simulated.strict[mode].push(strict.ln() + scale[mode]);
            }
        }
        simulated
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DeadPoint, ModeNode};
    use super::*;
    use rand::RngExt;

    fn dead(log_l: f64, log_l_birth: f64, mode: usize, leaf: usize) -> DeadPoint {
        DeadPoint {
            u: vec![0.5],
            log_l,
            log_l_birth,
            mode,
            leaf,
        }
    }

    fn run(dead: Vec<DeadPoint>, tree: Vec<ModeNode>) -> NestedRun {
        NestedRun {
            n_dim: 1,
            n_eval: 0,
            dead,
            tree,
        }
    }

    const START: f64 = f64::NEG_INFINITY;

    #[test]
    fn one_minus_exp_is_accurate_on_both_branches() {
        for x in [1e-9f64, 1e-3, 0.0299, 0.0301, 2.0] {
            assert!((one_minus_exp(x) / -(-x).exp_m1() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn live_counts_follow_births_and_deaths() {
        let points = vec![
            dead(1.0, START, 0, 0),
            dead(2.0, START, 0, 0),
            dead(3.0, 1.0, 0, 0),
            dead(4.0, START, 0, 0),
        ];
        assert_eq!(
            run(points, vec![ModeNode::root(3)]).live_counts(),
            [3, 3, 2, 1]
        );
    }

    #[test]
    fn a_plateau_leaves_with_falling_counts() {
        // Two points at -inf leave, each replaced from above the plateau.
        let points = vec![
            dead(START, START, 0, 0),
            dead(START, START, 0, 0),
            dead(1.0, f64::MIN, 0, 0),
            dead(2.0, START, 0, 0),
            dead(3.0, f64::MIN, 0, 0),
        ];
        assert_eq!(
            run(points, vec![ModeNode::root(3)]).live_counts(),
            [3, 2, 3, 2, 1]
        );
    }

    #[test]
    fn counts_of_a_split_are_the_childrens_own() {
        let child = |n_split| ModeNode {
            parent: Some(0),
            n_split,
            log_l_split: 1.0,
        };
        let points = vec![
            dead(1.0, START, 0, 1),
            dead(2.0, START, 1, 1),
            dead(2.5, 1.0, 2, 2), // topped up at the split
            dead(3.0, START, 2, 2),
            dead(4.0, START, 1, 1),
        ];
        let run = run(points, vec![ModeNode::root(4), child(2), child(1)]);
        assert_eq!(run.live_counts(), [4, 2, 2, 1, 1]);
    }

    #[test]
    fn a_flat_likelihood_has_its_value_as_evidence() {
        let points = (0..50).map(|_| dead(-3.0, START, 0, 0)).collect();
        let evidence = run(points, vec![ModeNode::root(50)]).evidence();
        assert!((evidence.log_z + 3.0).abs() < 1e-9);
        assert!(evidence.log_z_err < 1e-9 && evidence.kl_nats.abs() < 1e-9);
    }

    /// A run in which each of 16 equal modes has about 20 live points; within a mode ln L = -1000 x, x being the
    /// fraction of its volume in which L is higher.
    fn sixteen_modes(rng: &mut ChaCha8Rng) -> NestedRun {
        let mut n_split = [0; 16];
        (0..320).for_each(|_| n_split[rng.random_range(0..16)] += 1);
        let mut tree = vec![ModeNode::root(320)];
        let mut points = Vec::new();
        for (k, &n) in n_split.iter().enumerate() {
            let mut live: Vec<(f64, f64)> = (0..n).map(|_| (rng.random(), START)).collect();
            let mut die = |(x, birth): (f64, f64)| points.push(dead(-1e3 * x, birth, k + 1, k + 1));
            for _ in 0..8 * n {
                let worst = (0..n).max_by(|&a, &b| live[a].0.total_cmp(&live[b].0));
                let worst = worst.expect("a live point");
                let x = live[worst].0;
                die(live[worst]);
                live[worst] = (x * rng.random::<f64>(), -1e3 * x);
            }
            live.into_iter().for_each(die);
            tree.push(ModeNode {
                parent: Some(0),
                n_split: n,
                log_l_split: START,
            });
        }
        points.sort_by(|a, b| a.log_l.total_cmp(&b.log_l));
        run(points, tree)
    }

    #[test]
    fn the_sum_of_many_modes_is_not_too_high() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut corrected, mut plain) = (0.0, 0.0);
        for _ in 0..40 {
            let run = sixteen_modes(&mut rng);
            let sum = run.log_parts().into_iter().fold(START, log_add);
            corrected += (run.evidence().log_z + 1000f64.ln()) / 40.0;
            plain += (sum + 1000f64.ln()) / 40.0;
        }
        // Each mean is good to 0.023.
        assert!(corrected.abs() < 0.06, "{corrected}");
        assert!(plain > 0.07, "{plain}: so there is something to correct");
    }

    #[test]
    fn weights_sum_to_one() {
        let run = sixteen_modes(&mut ChaCha8Rng::seed_from_u64(2));
        let sum: f64 = run.log_weights().iter().map(|w| w.exp()).sum();
        assert!((sum - 1.0).abs() < 1e-9);
    }

    #[test]
    fn error_of_a_mode_carries_the_split() {
        // One mode holds n of N points, all at one ln L: ln Z scatters as ln Beta(n, N - n).
        let child = |n_split| ModeNode {
            parent: Some(0),
            n_split,
            log_l_split: -1.0,
        };
        let mut points = vec![dead(-1.0, START, 0, 1)];
        points.extend((0..10).map(|_| dead(0.0, START, 1, 1)));
        points.extend((0..90).map(|_| dead(0.0, START, 2, 2)));
        let run = run(points, vec![ModeNode::root(101), child(10), child(90)]);
        let modes = run.modes();
        let exact = (1.0 / 10.0f64 - 1.0 / 100.0).sqrt();
        assert!(
            (modes[0].log_z_strict_err / exact - 1.0).abs() < 0.2,
            "{modes:?}"
        );
        assert!((modes[0].log_z_strict - 0.1f64.ln()).abs() < 0.1);
    }
}
