//! What a run says about each mode.

use super::NestedRun;
use super::evidence::{Simulated, moments, spread};

/// An undivided mode: its evidence, and its posterior.
///
/// Points that died before the mode split off are shared out by place: each counts for the mode
/// in whose part of the cube it lies. So `log_z` is the integral of L over that part, whatever else is
/// in it: over all modes it sums to Z, and a flat background around a faint peak counts too. `strict`
/// values, the mean and the standard deviation use the mode's own dead points only: these hold
/// nothing of a background or a neighbour, but leave out the outer skirt of a peak that split off late.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeSummary {
    /// Its index in [`NestedRun::tree`].
    pub node: usize,
    /// Local ln Z, shared points included: ln of the integral of L over the mode's part of the prior.
    pub log_z: f64,
    /// Standard deviation of `log_z` over simulated volumes, splits included.
    pub log_z_err: f64,
    /// ln Z of the mode's own dead points.
    pub log_z_strict: f64,
    /// Standard deviation of `log_z_strict`.
    pub log_z_strict_err: f64,
    /// Information of the mode's posterior against the whole prior, in nat.
    pub kl_nats: f64,
    /// Effective sample size (Σw)²/Σw².
    pub ess: f64,
    /// Live points when it split off, before it was topped up.
    pub n_split: usize,
    /// Dead points that are its own.
    pub n_points: usize,
    /// Posterior mean in the unit cube (own points).
    pub mean: Vec<f64>,
    /// Posterior standard deviation in the unit cube (own points).
    pub std: Vec<f64>,
    /// Index of the point of highest ln L in [`NestedRun::dead`].
    pub best: usize,
    /// Posterior samples, shared points included: index into [`NestedRun::dead`] and ln weight;
    /// weights sum to 1.
    pub samples: Vec<(usize, f64)>,
    /// The same of the mode's own points: an own normalisation, for `log_z_strict`.
    pub samples_strict: Vec<(usize, f64)>,
}

impl NestedRun {
    /// The undivided modes, in the order of the tree.
    pub fn modes(&self) -> Vec<ModeSummary> {
        let log_w = self.log_parts();
        let simulated = Simulated::of(self, &log_w);
        let mut samples = vec![Vec::new(); self.tree.len()];
        for (i, (dead, &w)) in self.dead.iter().zip(&log_w).enumerate() {
            samples[dead.leaf].push((i, w));
        }
        let mut is_leaf = vec![true; self.tree.len()];
        self.tree
            .iter()
            .filter_map(|node| node.parent)
            .for_each(|parent| is_leaf[parent] = false);
        let leaves = samples
            .into_iter()
            .enumerate()
            .filter(|(node, _)| is_leaf[*node]);
        leaves
            .filter_map(|(node, samples)| self.summary(node, samples, &simulated))
            .collect()
    }

    /// Summary of one mode, given its points with ln(w L); none if it has no points.
    fn summary(
        &self,
        node: usize,
        mut samples: Vec<(usize, f64)>,
        simulated: &Simulated,
    ) -> Option<ModeSummary> {
        let best = samples.last()?.0;
        let points = samples.iter().map(|&(i, w)| (self.dead[i].log_l, w));
        let own = samples.iter().filter(|(i, _)| self.dead[*i].mode == node);
        let mut samples_strict: Vec<(usize, f64)> = own.copied().collect();
        let n_points = samples_strict.len();
        let own = samples_strict.iter().map(|&(i, w)| (self.dead[i].log_l, w));
        let (log_z_strict, ..) = moments(own);
        let (log_z, kl_nats, ess) = moments(points);
        for (_, w) in &mut samples {
            *w -= log_z;
        }
        for (_, w) in &mut samples_strict {
            *w -= log_z_strict;
        }
        let (mean, std) = self.mean_and_std(&samples_strict);
        Some(ModeSummary {
            node,
            log_z,
            log_z_err: spread(&simulated.shared[node]),
            log_z_strict,
            log_z_strict_err: spread(&simulated.strict[node]),
            kl_nats,
            ess,
            n_split: self.tree[node].n_split,
            n_points,
            mean,
            std,
            best,
            samples,
            samples_strict,
        })
    }

    /// Weighted mean and standard deviation of each coordinate.
    fn mean_and_std(&self, samples: &[(usize, f64)]) -> (Vec<f64>, Vec<f64>) {
        let average = |f: &dyn Fn(&[f64]) -> f64| -> f64 {
            samples
                .iter()
                .map(|&(i, w)| w.exp() * f(&self.dead[i].u))
                .sum()
        };
        let mean: Vec<f64> = (0..self.n_dim).map(|d| average(&|u| u[d])).collect();
        let std = (0..self.n_dim).map(|d| average(&|u| (u[d] - mean[d]).powi(2)).sqrt());
        let std = std.collect();
        (mean, std)
    }
}
