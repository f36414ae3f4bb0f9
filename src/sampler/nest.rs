//! What nested samplers with modes have in common: live points, the tree of modes, and what died.
//!
//! A sampler says where a mode's next points come from; the bookkeeping of volumes, contours, splits and
//! evidence is done here, once.

mod mode;
mod points;
mod territory;

pub(super) use mode::{Live, Mode};
pub(super) use points::Points;

use super::bound::{Cluster, Decomposition, Ellipsoid, decompose, separate, typical as typical_of};
use super::{DeadPoint, ModeNode, NestedRun, Progress, SamplerError, log_add};
use nalgebra::DMatrix;
use territory::Territory;

/// Clusters that become a mode, each with its ellipsoid's shadow in the mode dimensions.
pub(super) type Group = Vec<(Cluster, Ellipsoid)>;

/// Bookkeeping of a nested sampling run.
#[derive(Debug)]
pub(super) struct Nest {
    pub(super) points: Points,
    pub(super) territory: Territory,
    pub(super) tree: Vec<ModeNode>,
    pub(super) n_eval: u64,
    n_live: usize,
    mode_dims: Vec<usize>,
    max_eval: Option<u64>,
    dead: Vec<DeadPoint>,
    /// Evidence of all dead points.
    log_z: f64,
}

/// What a split leaves: a mode with its live points, the clusters they form, and a typical covariance.
pub(super) struct Child {
    pub(super) mode: Mode,
    pub(super) clusters: Vec<Cluster>,
    pub(super) typical: Option<DMatrix<f64>>,
}

impl Nest {
    /// No points yet.
    pub(super) fn new(
        n_dim: usize,
        n_live: usize,
        mode_dims: &[usize],
        wrapped: &[usize],
        max_eval: Option<u64>,
    ) -> Self {
        Self {
            points: Points::new(n_dim, wrapped),
            territory: Territory::new(mode_dims, wrapped),
            tree: vec![ModeNode::root(n_live)],
            n_eval: 0,
            n_live,
            mode_dims: mode_dims.to_vec(),
            max_eval,
            dead: Vec::new(),
            log_z: f64::NEG_INFINITY,
        }
    }

    /// Whether nothing has died or split yet.
    pub(super) fn is_untouched(&self) -> bool {
        self.dead.is_empty() && self.tree.len() == 1
    }

    /// Whether as much has been evaluated as is allowed.
    pub(super) fn check_budget(&self, contour: f64) -> Result<(), SamplerError> {
        if self.max_eval.is_none_or(|max| self.n_eval < max) {
            return Ok(());
        }
        Err(SamplerError::Stalled {
            n_eval: self.n_eval,
            log_l: contour,
            advice: "this is the most that max_eval allows".into(),
        })
    }

    /// Checks and counts what was told about the points that were asked.
    pub(super) fn check_told(&mut self, asked: &[f64], log_l: &[f64]) -> Result<(), SamplerError> {
        let n_dim = self.points.n_dim();
        if log_l.len() != asked.len() / n_dim {
            return Err(SamplerError::Protocol(format!(
                "told {} values, asked for {}",
                log_l.len(),
                asked.len() / n_dim
            )));
        }
        if let Some(k) = log_l.iter().position(|l| l.is_nan() || *l == f64::INFINITY) {
            let u = &asked[k * n_dim..(k + 1) * n_dim];
            return Err(SamplerError::Protocol(format!(
                "ln L is {} at u = {u:?}",
                log_l[k]
            )));
        }
        self.n_eval += log_l.len() as u64;
        Ok(())
    }

    /// The error of a mode that does not get on.
    pub(super) fn stalled(&self, mode: &Mode) -> SamplerError {
        SamplerError::Stalled {
            n_eval: self.n_eval,
            log_l: mode.contour(),
            advice: format!(
                "mode {} finds no better point; use more live points or smaller tiles, or look \
                 for a plateau or noise in the likelihood",
                mode.node
            ),
        }
    }

    /// The live points of a mode become dead points.
    pub(super) fn retire(&mut self, mut mode: Mode) {
        while mode.n_live() > 1 {
            self.kill(&mut mode);
        }
        // The last point stands for all the volume that is left.
        let log_x = mode.log_x;
        if let Some(last) = mode.pop() {
            self.log_z = log_add(self.log_z, log_x + last.log_l);
            self.bury(last, mode.node);
        }
    }

    /// The worst live point dies.
    pub(super) fn kill(&mut self, mode: &mut Mode) {
        let log_x = mode.log_x;
        if let Some(worst) = mode.pop() {
            let log_w = log_x + (-(mode.log_x - log_x).exp_m1()).ln();
            self.log_z = log_add(self.log_z, log_w + worst.log_l);
            self.bury(worst, mode.node);
        }
    }

    fn bury(&mut self, live: Live, mode: usize) {
        let mut u = self.points.cloud().row(live.slot).to_vec();
        self.points.wrap(&mut u);
        self.dead.push(DeadPoint {
            u,
            log_l: live.log_l,
            log_l_birth: self.points.log_l_birth[live.slot],
            mode,
            leaf: mode,
        });
        self.points.release(live.slot);
    }

    /// The live points of a mode as a decomposition problem.
    pub(super) fn problem<'a>(
        &'a self,
        mode: &Mode,
        typical: Option<&'a DMatrix<f64>>,
    ) -> Decomposition<'a> {
        Decomposition {
            cloud: self.points.cloud(),
            mode_dims: &self.mode_dims,
            log_share: mode.log_x - (mode.n_live() as f64).ln(),
            typical,
        }
    }

    /// Cuts the wrapped dimensions of a mode open where they are emptiest.
    pub(super) fn cut(&mut self, mode: &mut Mode) {
        mode.low = self.points.cut(&mode.slots());
    }

    /// Clusters of the live points of a mode.
    pub(super) fn clusters(
        &mut self,
        mode: &mut Mode,
        typical: Option<&DMatrix<f64>>,
    ) -> Vec<Cluster> {
        self.cut(mode);
        let slots = mode.slots();
        decompose(self.problem(mode, typical), slots)
    }

    /// Clusters in groups that are apart in the mode dimensions. The live points of each pair of `links`
    /// belong together.
    pub(super) fn groups(&self, clusters: &[Cluster], links: &[(usize, usize)]) -> Vec<Group> {
        let dims = &self.mode_dims;
        if dims.is_empty() || clusters.len() < 2 {
            return vec![];
        }
        let shadows: Option<Vec<_>> = clusters.iter().map(|c| c.ellipsoid.project(dims)).collect();
        let Some(shadows) = shadows else {
            return vec![];
        };
        let part: Vec<usize> = clusters.iter().map(|c| c.part).collect();
        let mut cluster_of = vec![0; self.points.n_slots()];
        for (k, cluster) in clusters.iter().enumerate() {
            cluster.index.iter().for_each(|&slot| cluster_of[slot] = k);
        }
        let links = links.iter().map(|&(a, b)| (cluster_of[a], cluster_of[b]));
        let groups = separate(&shadows, &part, &links.collect::<Vec<_>>());
        let member = |k: usize| (clusters[k].clone(), shadows[k].clone());
        groups
            .into_iter()
            .map(|group| group.into_iter().map(member).collect())
            .collect()
    }

    /// Replaces a mode by one for each group, which wants `n_live_mode` live points at least.
    pub(super) fn split(
        &mut self,
        mut parent: Mode,
        typical: Option<&DMatrix<f64>>,
        groups: Vec<Group>,
        n_live_mode: usize,
    ) -> Vec<Child> {
        let n = parent.n_live();
        let mut log_l = vec![0.0; self.points.n_slots()];
        for live in parent.drain() {
            log_l[live.slot] = live.log_l;
        }
        let members = |group: &Group| group.iter().flat_map(|(c, _)| c.index.clone()).collect();
        let sets: Vec<Vec<usize>> = groups.iter().map(members).collect();
        let sets = sets.iter().map(Vec::as_slice);
        let typical = typical_of(self.points.cloud(), sets).or_else(|| typical.cloned());
        let shadows = |group: &Group| group.iter().map(|(_, shadow)| shadow.clone()).collect();
        let first = self
            .territory
            .split(parent.node, groups.iter().map(shadows).collect());
        let mut children = Vec::with_capacity(groups.len());
        for (k, group) in groups.into_iter().enumerate() {
            let n_split = group.iter().map(|(cluster, _)| cluster.index.len()).sum();
            let log_x = parent.log_x + (n_split as f64 / n as f64).ln();
            let target = n_live_mode.min(self.n_live).max(n_split);
            let mut mode = Mode::new(first + k, log_x, parent.contour(), target);
            mode.low.clone_from(&parent.low);
            for &slot in group.iter().flat_map(|(cluster, _)| &cluster.index) {
                mode.push(Live {
                    log_l: log_l[slot],
                    slot,
                });
            }
            self.tree.push(ModeNode {
                parent: Some(parent.node),
                n_split,
                log_l_split: parent.contour(),
            });
            children.push(Child {
                mode,
                clusters: group.into_iter().map(|(cluster, _)| cluster).collect(),
                typical: typical.clone(),
            });
        }
        children
    }

    /// Where the run stands, given the modes that have live points.
    pub(super) fn progress<'a>(&self, modes: impl Iterator<Item = &'a Mode> + Clone) -> Progress {
        let remaining = modes.clone().map(Mode::log_z_remaining);
        Progress {
            n_eval: self.n_eval,
            n_dead: self.dead.len() as u64,
            log_z: self.log_z,
            log_z_remaining: remaining.fold(f64::NEG_INFINITY, log_add),
            n_live_modes: modes.count(),
        }
    }

    /// The run, given the modes that still have live points.
    pub(super) fn finish(mut self, modes: impl Iterator<Item = Mode>) -> NestedRun {
        modes.for_each(|mode| self.retire(mode));
        for dead in &mut self.dead {
            dead.leaf = self.territory.leaf(&dead.u);
        }
        self.dead.sort_by(|a, b| a.log_l.total_cmp(&b.log_l));
        NestedRun {
            n_dim: self.points.n_dim(),
            n_eval: self.n_eval,
            dead: self.dead,
            tree: self.tree,
        }
    }
}
