//! Multimodal nested sampling from ellipsoids.

mod region;
mod territory;

use super::bound::{
    Cloud, Cluster, Decomposition, Ellipsoid, Neighbourhood, Union, decompose, pooled, refit,
    separate,
};
use super::{DeadPoint, ModeNode, NestedRun, Progress, Sampler, SamplerError, log_add};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use region::{Live, Region};
use territory::Territory;

/// Evaluations of one mode without an acceptable point that count as a stall.
const STALL: u64 = 1_000_000;

/// Tries at a proposal inside the cube and the mode's own part of it, before it is given up.
const MAX_TRIES: usize = 100_000;
/// Share of good points among all tried below which the ellipsoids of a mode do not follow its shape.
const CURVED: f64 = 0.12;
/// Live points of a mode whose draws are held to their neighbourhood: fewer do not show its shape,
/// and for more it takes too long to find.
const NEIGHBOURS: std::ops::RangeInclusive<usize> = 50..=1000;

/// Fewest points that can become a mode of their own: what a cluster needs to have a scale.
const MIN_MODE: usize = 4;

/// Options of [`MultiNest`].
#[derive(Debug, Clone, PartialEq)]
pub struct MultiNestConfig {
    /// Dimensions of the problem.
    pub n_dim: usize,
    /// Live points at the start; they are shared among the modes.
    pub n_live: usize,
    /// Live points that each mode is topped up to when it splits off with fewer, at most `n_live`.
    pub n_live_mode: usize,
    /// Ellipsoids are enlarged in volume by 1/`efficiency`.
    pub efficiency: f64,
    /// A mode is finished when its live points can add no more than this fraction to its evidence.
    pub tolerance: f64,
    /// Dimensions in which separate groups of ellipsoids are separate modes; empty: no modes.
    pub mode_dims: Vec<usize>,
    /// Proposals per `ask`, divided among the modes by live points (each gets at least one).
    pub batch: usize,
    /// All randomness derives from it.
    pub seed: u64,
    /// Most likelihood evaluations.
    pub max_eval: Option<u64>,
}

impl MultiNestConfig {
    /// The defaults: efficiency 0.8, tolerance 0.1, modes in all dimensions, 10 (d + 2) live
    /// points a mode at least, batches of an eighth of the live points.
    pub fn new(n_dim: usize, n_live: usize) -> Self {
        Self {
            n_dim,
            n_live,
            n_live_mode: (10 * (n_dim + 2)).min(n_live),
            efficiency: 0.8,
            tolerance: 0.1,
            mode_dims: (0..n_dim).collect(),
            batch: (n_live / 8).max(1),
            seed: 0,
            max_eval: None,
        }
    }

    /// What is wrong with the options, if anything.
    fn fault(&self) -> Option<&'static str> {
        let fraction = |x: f64| x > 0.0 && x <= 1.0;
        [
            (self.n_dim > 0, "n_dim is zero"),
            (self.n_live >= 4, "n_live is below 4"),
            (self.batch > 0, "batch is zero"),
            (fraction(self.efficiency), "efficiency is outside (0, 1]"),
            (self.tolerance > 0.0, "tolerance is not positive"),
            (
                self.mode_dims.iter().all(|&i| i < self.n_dim),
                "mode_dims has no such dimension",
            ),
        ]
        .into_iter()
        .find_map(|(good, fault)| (!good).then_some(fault))
    }
}

/// Multimodal nested sampling: live points are covered by ellipsoids from which new points are
/// drawn; groups of ellipsoids that do not intersect become modes that go on separately.
///
/// What is kept of MultiNest: the ellipsoidal decomposition, and modes as disjoint groups of ellipsoids in
/// chosen dimensions, each with its own contour, so that a faint mode is finished although a bright one
/// dominates. What differs:
/// - ellipsoids are enlarged to hold points left out of their fit, so that little is cut off;
/// - modes own disjoint parts of the cube, so their evidences add up whether or not a split was wise;
/// - a mode with few points is topped up to `n_live_mode`;
/// - a batch is drawn from one bound and accepted in order: a uniform draw from a superset of the
///   higher contour is uniform within it, so this is exact, and independent of threads.
///
/// # Source
/// Feroz & Hobson 2008; Feroz, Hobson & Bridges 2009 (MNRAS 398, 1601), section 5; Skilling 2006.
#[derive(Debug)]
pub struct MultiNest {
    config: MultiNestConfig,
    rng: ChaCha8Rng,
    points: Points,
    territory: Territory,
    tree: Vec<ModeNode>,
    regions: Vec<Region>,
    dead: Vec<DeadPoint>,
    asked: Vec<f64>,
    /// Region and ellipsoid of each point of `asked`.
    origin: Vec<(usize, usize)>,
    /// Evidence of all dead points.
    log_z: f64,
    n_eval: u64,
}

/// Storage of live points by slot.
#[derive(Debug, Default)]
struct Points {
    n_dim: usize,
    u: Vec<f64>,
    log_l_birth: Vec<f64>,
    cluster: Vec<usize>,
    free: Vec<usize>,
}

impl Points {
    fn insert(&mut self, u: &[f64], log_l_birth: f64, cluster: usize) -> usize {
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

    fn cloud(&self) -> Cloud<'_> {
        Cloud {
            u: &self.u,
            n_dim: self.n_dim,
        }
    }
}

/// Clusters that become a mode, each with its ellipsoid's shadow in the mode dimensions.
type Group = Vec<(Cluster, Ellipsoid)>;

impl MultiNest {
    /// A sampler that has not asked yet.
    ///
    /// # Errors
    /// Options that make no sense.
    pub fn new(config: MultiNestConfig) -> Result<Self, SamplerError> {
        if let Some(fault) = config.fault() {
            return Err(SamplerError::Protocol(fault.to_string()));
        }
        Ok(Self {
            rng: ChaCha8Rng::seed_from_u64(config.seed),
            points: Points {
                n_dim: config.n_dim,
                ..Points::default()
            },
            territory: Territory::new(&config.mode_dims),
            tree: vec![ModeNode::root(config.n_live)],
            regions: vec![Region::new(0, 0.0, f64::NEG_INFINITY, config.n_live)],
            dead: Vec::new(),
            asked: Vec::new(),
            origin: Vec::new(),
            log_z: f64::NEG_INFINITY,
            n_eval: 0,
            config,
        })
    }

    /// Whether the first live points are still being drawn: these are accepted whatever their ln L.
    fn is_starting(&self) -> bool {
        self.dead.is_empty()
            && self.tree.len() == 1
            && self.regions.first().is_some_and(|r| r.missing() > 0)
    }

    /// Ends finished modes, renews bounds, splits modes; new modes are at the end of `regions`.
    fn prepare(&mut self) {
        let mut i = 0;
        while i < self.regions.len() {
            if self.regions[i].missing() == 0 && self.regions[i].is_finished(self.config.tolerance)
            {
                let region = self.regions.remove(i);
                self.retire(region);
                continue;
            }
            if self.renew(i) {
                // Replaced by its children, which stand at the end.
                continue;
            }
            i += 1;
        }
    }

    /// The live points of a mode become dead points.
    fn retire(&mut self, mut region: Region) {
        while region.n_live() > 1 {
            self.kill(&mut region);
        }
        // The last point stands for all the volume that is left.
        let log_x = region.log_x;
        if let Some(last) = region.pop() {
            self.log_z = log_add(self.log_z, log_x + last.log_l);
            self.bury(last, region.node);
        }
    }

    /// The worst live point dies.
    fn kill(&mut self, region: &mut Region) {
        let log_x = region.log_x;
        if let Some(worst) = region.pop() {
            let log_w = log_x + (-(region.log_x - log_x).exp_m1()).ln();
            self.log_z = log_add(self.log_z, log_w + worst.log_l);
            self.bury(worst, region.node);
        }
    }

    fn bury(&mut self, live: Live, mode: usize) {
        self.dead.push(DeadPoint {
            u: self.points.cloud().row(live.slot).to_vec(),
            log_l: live.log_l,
            log_l_birth: self.points.log_l_birth[live.slot],
            mode,
            leaf: mode,
        });
        self.points.free.push(live.slot);
    }

    /// Fits or searches the ellipsoids of a region when due; true if it split and is gone.
    fn renew(&mut self, i: usize) -> bool {
        let region = &self.regions[i];
        let n = region.n_live();
        if n == 0 || self.is_starting() {
            return false;
        }
        if region.missing() > 0 {
            // While it is topped up the bound may tighten as points come, but nothing splits.
            return n >= MIN_MODE.max(2 * region.n_at_fit) && self.search(i, false);
        }
        if region.n_at_fit == 0 {
            // The first live points fill the cube evenly: there is nothing to search for.
            self.rebind(i, vec![]);
            return false;
        }
        if n != region.n_at_fit || 2 * region.since_search >= n {
            return self.search(i, true);
        }
        if 8 * region.since_fit >= n {
            self.refit(i);
        }
        false
    }

    /// Live points of a region as a decomposition problem.
    fn problem<'a>(
        config: &'a MultiNestConfig,
        points: &'a Points,
        region: &'a Region,
    ) -> Decomposition<'a> {
        Decomposition {
            cloud: points.cloud(),
            mode_dims: &config.mode_dims,
            log_share: region.log_x - (region.n_live() as f64).ln(),
            typical: region.typical.as_ref(),
        }
    }

    /// Fits the ellipsoids of a region anew, clusters as they are.
    fn refit(&mut self, i: usize) {
        let region = &self.regions[i];
        if region.bound.ellipsoids().is_empty() {
            return;
        }
        let mut sets = vec![Vec::new(); region.bound.ellipsoids().len()];
        for slot in region.slots() {
            sets[self.points.cluster[slot]].push(slot);
        }
        sets.retain(|set| !set.is_empty());
        let clusters = refit(Self::problem(&self.config, &self.points, region), sets);
        let clusters = self.enlarge(clusters);
        if is_cube(&self.regions[i], total_log_volume(&clusters)) {
            self.rebind(i, vec![]);
        } else {
            self.rebind(i, clusters);
        }
    }

    /// Searches for clusters; splits the region where they form separate groups (if `may_split`).
    fn search(&mut self, i: usize, may_split: bool) -> bool {
        let region = &self.regions[i];
        let problem = Self::problem(&self.config, &self.points, region);
        let clusters = self.enlarge(decompose(problem, region.slots()));
        self.regions[i].since_search = 0;
        if is_cube(&self.regions[i], total_log_volume(&clusters)) {
            self.rebind(i, vec![]);
            return false;
        }
        if may_split {
            let groups = self.groups(&clusters);
            if groups.len() > 1 {
                self.split(i, groups);
                return true;
            }
        }
        self.rebind(i, clusters);
        false
    }

    fn enlarge(&self, mut clusters: Vec<Cluster>) -> Vec<Cluster> {
        for cluster in &mut clusters {
            cluster.ellipsoid.grow(-self.config.efficiency.ln());
        }
        clusters
    }

    /// Gives a region its new ellipsoids; none: the whole cube.
    fn rebind(&mut self, i: usize, clusters: Vec<Cluster>) {
        let region = &mut self.regions[i];
        region.is_curved |= (region.since_fit as f64) < CURVED * region.n_tried as f64;
        region.n_tried = 0;
        region.since_fit = 0;
        region.n_at_fit = region.n_live();
        if clusters.is_empty() {
            for slot in region.slots() {
                self.points.cluster[slot] = 0;
            }
        }
        for (k, cluster) in clusters.iter().enumerate() {
            for &slot in &cluster.index {
                self.points.cluster[slot] = k;
            }
        }
        self.regions[i].near = self.neighbourhood(i, &clusters);
        let region = &mut self.regions[i];
        region.bound = Union::new(clusters.into_iter().map(|c| c.ellipsoid).collect());
    }

    /// The surroundings of a region's live points, where its ellipsoids do not follow its shape.
    fn neighbourhood(&mut self, i: usize, clusters: &[Cluster]) -> Option<Neighbourhood> {
        let region = &self.regions[i];
        if !region.is_curved || !NEIGHBOURS.contains(&region.n_live()) {
            return None;
        }
        let cloud = self.points.cloud();
        let covariance = pooled(cloud, clusters.iter().map(|c| c.index.as_slice()))?;
        Neighbourhood::new(cloud, &region.slots(), &covariance, &mut self.rng)
    }

    /// Clusters in groups that are apart in the mode dimensions; groups of fewer than `MIN_MODE`
    /// points stay with the nearest.
    fn groups(&self, clusters: &[Cluster]) -> Vec<Group> {
        let dims = &self.config.mode_dims;
        if dims.is_empty() || clusters.len() < 2 {
            return vec![];
        }
        let shadows: Option<Vec<_>> = clusters.iter().map(|c| c.ellipsoid.project(dims)).collect();
        let Some(shadows) = shadows else {
            return vec![];
        };
        let part: Vec<usize> = clusters.iter().map(|c| c.part).collect();
        let size = |group: &[usize]| {
            group
                .iter()
                .map(|&k| clusters[k].index.len())
                .sum::<usize>()
        };
        let groups = separate(&shadows, &part);
        let (mut groups, small): (Vec<_>, Vec<_>) = groups
            .into_iter()
            .partition(|group| size(group) >= MIN_MODE);
        for k in small.into_iter().flatten() {
            let gap = |group: &Vec<usize>| {
                let gaps = group
                    .iter()
                    .map(|&g| shadows[g].distance2(shadows[k].centre()));
                gaps.fold(f64::INFINITY, f64::min)
            };
            if let Some(nearest) = groups.iter_mut().min_by(|a, b| gap(a).total_cmp(&gap(b))) {
                nearest.push(k);
            }
        }
        let member = |k: usize| (clusters[k].clone(), shadows[k].clone());
        groups
            .into_iter()
            .map(|group| group.into_iter().map(member).collect())
            .collect()
    }

    /// Replaces a region by one for each group.
    fn split(&mut self, i: usize, groups: Vec<Group>) {
        let mut parent = self.regions.remove(i);
        let n = parent.n_live();
        let mut log_l = vec![0.0; self.points.cluster.len()];
        for live in parent.drain() {
            log_l[live.slot] = live.log_l;
        }
        let sets = groups
            .iter()
            .flatten()
            .map(|(cluster, _)| cluster.index.as_slice());
        let typical = pooled(self.points.cloud(), sets).or(parent.typical.take());
        let shadows = |group: &Group| group.iter().map(|(_, shadow)| shadow.clone()).collect();
        let first = self
            .territory
            .split(parent.node, groups.iter().map(shadows).collect());
        for (k, group) in groups.into_iter().enumerate() {
            let n_split = group.iter().map(|(cluster, _)| cluster.index.len()).sum();
            let log_x = parent.log_x + log_fraction(n_split, n);
            let target = self.config.n_live_mode.min(self.config.n_live).max(n_split);
            let mut region = Region::new(first + k, log_x, parent.contour(), target);
            region.typical.clone_from(&typical);
            for &slot in group.iter().flat_map(|(cluster, _)| &cluster.index) {
                region.push(Live {
                    log_l: log_l[slot],
                    slot,
                });
            }
            self.tree.push(ModeNode {
                parent: Some(parent.node),
                n_split,
                log_l_split: parent.contour(),
            });
            self.regions.push(region);
            let clusters = group.into_iter().map(|(cluster, _)| cluster).collect();
            self.rebind(self.regions.len() - 1, clusters);
        }
    }

    /// Draws the proposals of one region.
    fn propose(&mut self, i: usize) -> Result<(), SamplerError> {
        let region = &self.regions[i];
        let share = (self.config.batch * region.n_live()).div_ceil(self.config.n_live);
        let wanted = match region.missing() {
            0 => share.max(1),
            missing if self.tree.len() == 1 => missing,
            missing => 2 * missing,
        };
        let n_dim = self.config.n_dim;
        let mut u = vec![0.0; n_dim];
        let (mut found, mut tries) = (0, 0);
        while found < wanted && tries < MAX_TRIES * (found + 1) {
            tries += 1;
            let Some(cluster) = region.bound.draw(&mut self.rng, &mut u) else {
                continue;
            };
            let is_near = region.near.as_ref().is_none_or(|near| near.contains(&u));
            if is_near && self.territory.owns(region.node, &u) {
                self.asked.extend_from_slice(&u);
                self.origin.push((i, cluster));
                found += 1;
            }
        }
        if found == 0 || region.barren > STALL {
            return Err(self.stalled(region.contour(), region.node));
        }
        Ok(())
    }

    fn stalled(&self, log_l: f64, node: usize) -> SamplerError {
        SamplerError::Stalled {
            n_eval: self.n_eval,
            log_l,
            advice: format!(
                "mode {node} finds no better point; use more live points or smaller tiles, or look \
                 for a plateau or noise in the likelihood"
            ),
        }
    }

    /// Gives a region an evaluated point.
    fn offer(&mut self, k: usize, log_l: f64, starting: bool) {
        let (i, cluster) = self.origin[k];
        let n_dim = self.config.n_dim;
        let mut region = std::mem::replace(&mut self.regions[i], Region::new(0, 0.0, 0.0, 0));
        region.barren += 1;
        region.n_tried += 1;
        let filling = region.missing() > 0;
        let contour = if filling {
            Some(region.contour())
        } else {
            region.worst()
        };
        let initial = starting && filling;
        if initial || contour.is_some_and(|contour| log_l > contour) {
            if !filling {
                self.kill(&mut region);
            }
            // Drawn above a contour of -inf, but not from the whole prior.
            let birth = if initial {
                f64::NEG_INFINITY
            } else {
                region.contour().max(f64::MIN)
            };
            let u = &self.asked[k * n_dim..(k + 1) * n_dim];
            let slot = self.points.insert(u, birth, cluster);
            region.push(Live { log_l, slot });
            region.barren = 0;
        }
        self.regions[i] = region;
    }
}

/// Whether a region is better drawn from the whole cube: its ellipsoids are no smaller.
fn is_cube(region: &Region, log_volume: f64) -> bool {
    region.node == 0 && log_volume >= 0.0
}

/// ln of the summed volume of the ellipsoids.
fn total_log_volume(clusters: &[Cluster]) -> f64 {
    clusters.iter().fold(f64::NEG_INFINITY, |sum, c| {
        log_add(sum, c.ellipsoid.log_volume())
    })
}

/// Expected ln of the volume fraction of `n` of `total` points: ψ(n) - ψ(total).
fn log_fraction(n: usize, total: usize) -> f64 {
    -(n..total).map(|k| 1.0 / k as f64).sum::<f64>()
}

impl Sampler for MultiNest {
    fn ask(&mut self) -> Result<&[f64], SamplerError> {
        if !self.origin.is_empty() {
            return Err(SamplerError::Protocol(
                "asked twice without being told".into(),
            ));
        }
        self.asked.clear();
        if self.config.max_eval.is_some_and(|max| self.n_eval >= max) {
            let log_l = self.regions.first().map_or(f64::INFINITY, Region::contour);
            return Err(SamplerError::Stalled {
                n_eval: self.n_eval,
                log_l,
                advice: "this is the most that max_eval allows".into(),
            });
        }
        self.prepare();
        for i in 0..self.regions.len() {
            self.propose(i)?;
        }
        Ok(&self.asked)
    }

    fn tell(&mut self, log_l: &[f64]) -> Result<(), SamplerError> {
        if log_l.len() != self.origin.len() {
            let (told, asked) = (log_l.len(), self.origin.len());
            return Err(SamplerError::Protocol(format!(
                "told {told} values, asked for {asked}"
            )));
        }
        if let Some(k) = log_l.iter().position(|l| l.is_nan() || *l == f64::INFINITY) {
            let u = &self.asked[k * self.config.n_dim..(k + 1) * self.config.n_dim];
            return Err(SamplerError::Protocol(format!(
                "ln L is {} at u = {u:?}",
                log_l[k]
            )));
        }
        self.n_eval += log_l.len() as u64;
        let starting = self.is_starting();
        for (k, &log_l) in log_l.iter().enumerate() {
            self.offer(k, log_l, starting);
        }
        self.origin.clear();
        Ok(())
    }

    fn progress(&self) -> Progress {
        let remaining = self.regions.iter().map(Region::log_z_remaining);
        Progress {
            n_eval: self.n_eval,
            n_dead: self.dead.len() as u64,
            log_z: self.log_z,
            log_z_remaining: remaining.fold(f64::NEG_INFINITY, log_add),
            n_live_modes: self.regions.len(),
        }
    }

    fn finish(mut self: Box<Self>) -> NestedRun {
        for region in std::mem::take(&mut self.regions) {
            self.retire(region);
        }
        for dead in &mut self.dead {
            dead.leaf = self.territory.leaf(&dead.u);
        }
        self.dead.sort_by(|a, b| a.log_l.total_cmp(&b.log_l));
        NestedRun {
            n_dim: self.config.n_dim,
            n_eval: self.n_eval,
            dead: self.dead,
            tree: self.tree,
        }
    }
}
