//! The insertion-index test: where among the live points do new ones come to lie?
//!
//! A new point drawn from the prior above a contour has each rank among the live points there with the
//! same probability. A bound that cuts something off, or a chain that is too short, gives too many high or
//! too many low ranks.
//!
//! # Source
//! Fowlie, Handley & Su 2020 (MNRAS 497, 5256).

use crate::sampler::NestedRun;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Outcome of the test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsertionTest {
    /// Points with a rank: all but the first live ones and those on plateaus.
    pub n: usize,
    /// Kolmogorov-Smirnov distance of the ranks from uniform ones.
    pub distance: f64,
    /// Mean of the ranks, from 0 to 1: 1/2 if they are uniform, more where the points are too good.
    pub mean: f64,
    /// Probability of a larger distance if all is well.
    pub p_value: f64,
    /// The smallest such probability among runs of as many points as were live at first, in the order
    /// of birth, times the number of these: what is wrong for part of the run only.
    pub p_value_parts: f64,
}

/// A point's rank among the live points when it was born.
struct Insertion {
    log_l_birth: f64,
    rank: usize,
    n_live: usize,
}

impl NestedRun {
    /// Tests the ranks with which new points came to lie among the live ones of their mode.
    pub fn insertion_test(&self) -> InsertionTest {
        let mut insertions = self.insertions();
        insertions.sort_by(|a, b| a.log_l_birth.total_cmp(&b.log_l_birth));
        // A rank is a whole number: spread within its step, so that many small live sets make a uniform.
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let spread = |i: &Insertion| {
            let step: f64 = rng.random();
            (i.rank as f64 + step) / (i.n_live + 1) as f64
        };
        let ranks: Vec<f64> = insertions.iter().map(spread).collect();
        let part = self.tree.first().map_or(1, |root| root.n_split.max(1));
        let parts = ranks.chunks(part).filter(|c| c.len() == part);
        let n_parts = parts.clone().count().max(1) as f64;
        let least = parts.map(|c| p_value(distance(c), c.len()));
        let distance = distance(&ranks);
        InsertionTest {
            n: ranks.len(),
            distance,
            mean: ranks.iter().sum::<f64>() / ranks.len().max(1) as f64,
            p_value: p_value(distance, ranks.len()),
            p_value_parts: (least.fold(1.0, f64::min) * n_parts).min(1.0),
        }
    }

    /// Ranks of all points, mode by mode.
    fn insertions(&self) -> Vec<Insertion> {
        let ancestry = self.ancestry();
        let mut members = vec![Vec::new(); self.tree.len()];
        for (i, dead) in self.dead.iter().enumerate() {
            for &node in &ancestry[dead.mode] {
                members[node].push(i);
            }
        }
        // Born in the last mode of the ancestry that was there at the birth contour.
        let birthplace = |i: usize| {
            let dead = &self.dead[i];
            let mut nodes = ancestry[dead.mode].iter().copied();
            nodes.find(|&node| self.tree[node].log_l_split <= dead.log_l_birth)
        };
        let in_mode = |(node, members): (usize, &Vec<usize>)| {
            let is_born_here = |i: usize| birthplace(i) == Some(node);
            self.ranks(members, is_born_here)
        };
        members.iter().enumerate().flat_map(in_mode).collect()
    }

    /// Ranks of those of `members`, ln L ascending, for which `is_born_here`, among the members that were live.
    fn ranks(&self, members: &[usize], is_born_here: impl Fn(usize) -> bool) -> Vec<Insertion> {
        let log_l = |place: usize| self.dead[members[place]].log_l;
        let birth = |place: usize| self.dead[members[place]].log_l_birth;
        let mut by_birth: Vec<usize> = (0..members.len()).collect();
        by_birth.sort_by(|&a, &b| birth(a).total_cmp(&birth(b)).then(a.cmp(&b)));
        let mut live = Counts::new(members.len());
        let (mut n_born, mut n_dead) = (0, 0);
        let mut ranks = Vec::new();
        for &place in &by_birth {
            let contour = birth(place);
            if contour == f64::NEG_INFINITY {
                continue;
            }
            // Those of the same birth contour are its siblings, not what it was compared with.
            while n_born < by_birth.len() && birth(by_birth[n_born]) < contour {
                live.add(by_birth[n_born], 1);
                n_born += 1;
            }
            while n_dead < members.len() && log_l(n_dead) <= contour {
                live.add(n_dead, -1);
                n_dead += 1;
            }
            let is_tied = [place.wrapping_sub(1), place + 1]
                .iter()
                .any(|&p| p < members.len() && log_l(p) == log_l(place));
            let n_live = live.below(members.len());
            if !is_tied && n_live > 0 && is_born_here(members[place]) {
                ranks.push(Insertion {
                    log_l_birth: contour,
                    rank: live.below(place),
                    n_live,
                });
            }
        }
        ranks
    }
}

/// Counts by place, with fast sums (a Fenwick tree).
struct Counts(Vec<i64>);

impl Counts {
    fn new(n: usize) -> Self {
        Self(vec![0; n + 1])
    }

    fn add(&mut self, place: usize, by: i64) {
        let mut i = place + 1;
        while i < self.0.len() {
            self.0[i] += by;
            i += i & i.wrapping_neg();
        }
    }

    /// Sum over the places before `end`.
    fn below(&self, end: usize) -> usize {
        let (mut i, mut sum) = (end, 0);
        while i > 0 {
            sum += self.0[i];
            i &= i - 1;
        }
        sum.max(0) as usize
    }
}

/// Largest distance between the distribution of `x` and the uniform one.
fn distance(x: &[f64]) -> f64 {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let gaps = sorted.iter().enumerate();
    gaps.map(|(i, x)| (x - i as f64 / n).max((i + 1) as f64 / n - x))
        .fold(0.0, f64::max)
}

/// Probability that `n` uniform numbers are farther than `distance` from uniform: Kolmogorov's series
/// 2 Σ (-1)^(k-1) exp(-2 k² λ²), with Stephens' λ for finite n (Press et al. 2007, eq. 14.3.18).
fn p_value(distance: f64, n: usize) -> f64 {
    let root = (n as f64).sqrt();
    let lambda = (root + 0.12 + 0.11 / root.max(1.0)) * distance;
    if lambda < 0.2 {
        return 1.0;
    }
    let term = |k: i32| {
        let sign = if k % 2 == 1 { 2.0 } else { -2.0 };
        sign * (-2.0 * f64::from(k * k) * lambda * lambda).exp()
    };
    (1..=100).map(term).sum::<f64>().clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{DeadPoint, ModeNode};

    /// A run of `n_live` points whose new ones lie at `place(x)` of the volume above the contour, x uniform.
    fn run(n_live: usize, place: impl Fn(f64) -> f64) -> NestedRun {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        // ln L = -X: live points by volume.
        let mut live: Vec<(f64, f64)> = (0..n_live)
            .map(|_| (rng.random(), f64::NEG_INFINITY))
            .collect();
        let mut dead = Vec::new();
        let mut bury = |(x, log_l_birth): (f64, f64)| {
            dead.push(DeadPoint {
                u: vec![x],
                log_l: -x,
                log_l_birth,
                mode: 0,
                leaf: 0,
            });
        };
        for _ in 0..20 * n_live {
            live.sort_by(|a, b| a.0.total_cmp(&b.0));
            let worst = live.pop().unwrap();
            bury(worst);
            live.push((worst.0 * place(rng.random()), -worst.0));
        }
        live.sort_by(|a, b| b.0.total_cmp(&a.0));
        live.into_iter().for_each(bury);
        NestedRun {
            n_dim: 1,
            n_eval: 0,
            dead,
            tree: vec![ModeNode::root(n_live)],
        }
    }

    #[test]
    fn kolmogorov_has_its_tabulated_quantiles() {
        // λ = 1.3581 and 1.6276 are the 5% and 1% points.
        let n = 1_000_000;
        for (lambda, p) in [(1.3581, 0.05), (1.6276, 0.01)] {
            assert!((p_value(lambda / 1000.0, n) - p).abs() < 2e-4);
        }
    }

    #[test]
    fn fair_draws_pass_and_a_cut_off_rim_does_not() {
        let fair = run(100, |x| x).insertion_test();
        assert_eq!(fair.n, 2000);
        assert!(fair.p_value > 0.01 && fair.p_value_parts > 0.01, "{fair:?}");
        assert!((fair.mean - 0.5).abs() < 0.03);
        let cut = run(100, |x| 0.9 * x).insertion_test();
        assert!(cut.p_value < 1e-3 && cut.mean > 0.53, "{cut:?}");
    }
}
