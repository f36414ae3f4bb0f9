//! Multimodal nested sampling from ellipsoids.
//!
//! Importance nested sampling (Feroz et al. 2019), which weights every point that was ever evaluated by the
//! ellipsoids that it was drawn from, is not offered: it takes separate modes away, and these are what the sampler is for.

mod region;

use super::bound::{Cluster, Neighbourhood, Union, pooled, refit, scarcity};
use super::nest::{Child, Group, Live, Mode, Nest};
use super::{NestedRun, Progress, Sampler, SamplerError, log_add};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use region::Region;

/// Evaluations of one mode without an acceptable point that count as a stall.
const STALL: u64 = 1_000_000;

/// Tries at a proposal inside the cube and the mode's own part of it, before it is given up.
const MAX_TRIES: usize = 100_000;
/// Share of good points among all tried below which the ellipsoids of a mode do not follow its shape.
const CURVED: f64 = 0.12;
/// Live points of a mode whose draws are held to their neighbourhood: fewer do not show its shape,
/// and for more it takes too long to find.
const NEIGHBOURS: std::ops::RangeInclusive<usize> = 50..=1000;

/// Options of [`MultiNest`].
#[derive(Debug, Clone, PartialEq)]
pub struct MultiNestConfig {
    /// Dimensions of the problem.
    pub n_dim: usize,
    /// Live points at the start; they are shared among the modes.
    pub n_live: usize,
    /// Live points that each mode is topped up to when it splits off with fewer, at most `n_live`.
    pub n_live_mode: usize,
    /// Ellipsoids of few points are enlarged in volume by 1/`efficiency`, those of more than five for each dimension by less.
    pub efficiency: f64,
    /// A mode is finished when its live points can add no more than this fraction to its evidence.
    pub tolerance: f64,
    /// Dimensions in which separate groups of ellipsoids are separate modes; empty: no modes.
    pub mode_dims: Vec<usize>,
    /// Dimensions that are circles: 0 and 1 are the same place.
    pub wrapped: Vec<usize>,
    /// Proposals per `ask`, divided among the modes by live points (each gets at least one).
    pub batch: usize,
    /// All randomness derives from it.
    pub seed: u64,
    /// Most likelihood evaluations.
    pub max_eval: Option<u64>,
}

impl MultiNestConfig {
    /// The defaults: efficiency 0.8, tolerance 0.5, modes in all dimensions, 10 (d + 2) live
    /// points a mode at least, batches of an eighth of the live points.
    pub fn new(n_dim: usize, n_live: usize) -> Self {
        Self {
            n_dim,
            n_live,
            n_live_mode: (10 * (n_dim + 2)).min(n_live),
            efficiency: 0.8,
            tolerance: 0.5,
            mode_dims: (0..n_dim).collect(),
            wrapped: Vec::new(),
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
                "mode_dims names a dimension that is not there",
            ),
            (
                self.wrapped.iter().all(|&i| i < self.n_dim),
                "wrapped names a dimension that is not there",
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
    nest: Nest,
    regions: Vec<Region>,
    asked: Vec<f64>,
    /// Region and ellipsoid of each point of `asked`.
    origin: Vec<(usize, usize)>,
}

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
            nest: Nest::new(
                config.n_dim,
                config.n_live,
                &config.mode_dims,
                &config.wrapped,
                config.max_eval,
            ),
            regions: vec![Region::new(Mode::whole(config.n_live))],
            asked: Vec::new(),
            origin: Vec::new(),
            config,
        })
    }

    /// Whether the first live points are still being drawn: these are accepted whatever their ln L.
    fn is_starting(&self) -> bool {
        self.nest.is_untouched() && self.regions.first().is_some_and(|r| r.mode.missing() > 0)
    }

    /// Ends finished modes, renews bounds, splits modes; new modes are at the end of `regions`.
    fn prepare(&mut self) {
        let mut i = 0;
        while i < self.regions.len() {
            let mode = &self.regions[i].mode;
            if mode.missing() == 0 && mode.is_finished(self.config.tolerance) {
                let region = self.regions.remove(i);
                self.nest.retire(region.mode);
                continue;
            }
            if self.renew(i) {
                // Replaced by its children, which stand at the end.
                continue;
            }
            i += 1;
        }
    }

    /// Fits or searches the ellipsoids of a region when due; true if it split and is gone.
    fn renew(&mut self, i: usize) -> bool {
        let region = &self.regions[i];
        let n = region.mode.n_live();
        if n == 0 || self.is_starting() {
            return false;
        }
        if region.mode.missing() > 0 {
            // While it is topped up the bound may tighten as points come, but nothing splits.
            return n >= 2 * region.n_at_fit && self.search(i, false);
        }
        if region.n_at_fit == 0 {
            // The first live points fill the cube evenly: there is nothing to search for.
            self.rebind(i, vec![]);
            return false;
        }
        if n != region.n_at_fit || region.is_search_due() {
            return self.search(i, true);
        }
        if 8 * region.since_fit() >= n {
            self.refit(i);
        }
        false
    }

    /// Fits the ellipsoids of a region anew, clusters as they are.
    fn refit(&mut self, i: usize) {
        let region = &mut self.regions[i];
        if region.bound.ellipsoids().is_empty() {
            return;
        }
        let mut sets = vec![Vec::new(); region.bound.ellipsoids().len()];
        for slot in region.mode.slots() {
            sets[self.nest.points.cluster[slot]].push(slot);
        }
        sets.retain(|set| !set.is_empty());
        self.nest.cut(&mut region.mode);
        let clusters = refit(
            self.nest.problem(&region.mode, region.typical.as_ref()),
            sets,
        );
        let clusters = self.enlarge(clusters);
        let log_volume = total_log_volume(&clusters);
        self.regions[i].excess = log_volume - self.regions[i].mode.log_x;
        if is_cube(&self.regions[i], log_volume) {
            self.rebind(i, vec![]);
        } else {
            self.rebind(i, clusters);
        }
    }

    /// Searches for clusters; splits the region where they form separate groups (if `may_split`).
    fn search(&mut self, i: usize, may_split: bool) -> bool {
        let region = &mut self.regions[i];
        let clusters = self
            .nest
            .clusters(&mut region.mode, region.typical.as_ref());
        region.dead_at_search = region.mode.n_dead();
        let clusters = self.enlarge(clusters);
        let log_volume = total_log_volume(&clusters);
        let region = &mut self.regions[i];
        region.excess = log_volume - region.mode.log_x;
        region.excess_at_search = region.excess;
        if is_cube(region, log_volume) {
            self.rebind(i, vec![]);
            return false;
        }
        if may_split {
            let groups = self.nest.groups(&clusters, &[]);
            if groups.len() > 1 {
                self.split(i, groups);
                return true;
            }
        }
        self.rebind(i, clusters);
        false
    }

    /// Enlarges ellipsoids for what their fit has not seen: of many points that is little.
    fn enlarge(&self, mut clusters: Vec<Cluster>) -> Vec<Cluster> {
        for cluster in &mut clusters {
            let scarcity = scarcity(cluster.index.len(), self.config.n_dim).min(1.0);
            cluster
                .ellipsoid
                .grow(-self.config.efficiency.ln() * scarcity);
        }
        clusters
    }

    /// Gives a region its new ellipsoids; none: the whole cube.
    fn rebind(&mut self, i: usize, clusters: Vec<Cluster>) {
        let region = &mut self.regions[i];
        region.is_curved |= (region.since_fit() as f64) < CURVED * region.n_tried as f64;
        region.n_tried = 0;
        region.dead_at_fit = region.mode.n_dead();
        region.n_at_fit = region.mode.n_live();
        if clusters.is_empty() {
            for slot in region.mode.slots() {
                self.nest.points.cluster[slot] = 0;
            }
        }
        for (k, cluster) in clusters.iter().enumerate() {
            for &slot in &cluster.index {
                self.nest.points.cluster[slot] = k;
            }
        }
        self.regions[i].near = self.neighbourhood(i, &clusters);
        let region = &mut self.regions[i];
        region.follow(&clusters);
        let ellipsoids = clusters.into_iter().map(|c| c.ellipsoid).collect();
        region.bound = Union::new(ellipsoids, &region.mode.low);
    }

    /// The surroundings of a region's live points, where its ellipsoids do not follow its shape.
    fn neighbourhood(&mut self, i: usize, clusters: &[Cluster]) -> Option<Neighbourhood> {
        let region = &self.regions[i];
        if !region.is_curved || !NEIGHBOURS.contains(&region.mode.n_live()) {
            return None;
        }
        let cloud = self.nest.points.cloud();
        let covariance = pooled(cloud, clusters.iter().map(|c| c.index.as_slice()))?;
        let slots = region.mode.slots();
        Neighbourhood::new(cloud, &slots, &covariance, &mut self.rng)
    }

    /// Replaces a region by one for each group.
    fn split(&mut self, i: usize, groups: Vec<Group>) {
        let Region { mode, typical, .. } = self.regions.remove(i);
        let n_live_mode = self.config.n_live_mode;
        let children = self.nest.split(mode, typical.as_ref(), groups, n_live_mode);
        for Child {
            mode,
            clusters,
            typical,
        } in children
        {
            let excess = total_log_volume(&clusters) - mode.log_x;
            self.regions.push(Region {
                typical,
                excess,
                excess_at_search: excess,
                ..Region::new(mode)
            });
            self.rebind(self.regions.len() - 1, clusters);
        }
    }

    /// Draws the proposals of one region.
    fn propose(&mut self, i: usize) -> Result<(), SamplerError> {
        let region = &self.regions[i];
        let share = (self.config.batch * region.mode.n_live()).div_ceil(self.config.n_live);
        let wanted = match region.mode.missing() {
            0 => share.max(1),
            missing if self.nest.tree.len() == 1 => missing,
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
            if is_near && self.nest.territory.owns(region.mode.node, &u) {
                self.nest.points.wrap(&mut u);
                self.asked.extend_from_slice(&u);
                self.origin.push((i, cluster));
                found += 1;
            }
        }
        if found == 0 || region.barren > STALL {
            return Err(self.nest.stalled(&region.mode));
        }
        Ok(())
    }

    /// Gives a region an evaluated point.
    fn offer(&mut self, k: usize, log_l: f64, starting: bool) {
        let (i, cluster) = self.origin[k];
        let n_dim = self.config.n_dim;
        let region = &mut self.regions[i];
        region.barren += 1;
        region.n_tried += 1;
        let filling = region.mode.missing() > 0;
        let contour = if filling {
            Some(region.mode.contour())
        } else {
            region.mode.worst()
        };
        let initial = starting && filling;
        if initial || contour.is_some_and(|contour| log_l > contour) {
            if !filling {
                self.nest.kill(&mut region.mode);
            }
            // Drawn above a contour of -inf, but not from the whole prior.
            let birth = if initial {
                f64::NEG_INFINITY
            } else {
                region.mode.contour().max(f64::MIN)
            };
            let u = &self.asked[k * n_dim..(k + 1) * n_dim];
            let slot = self.nest.points.insert(u, birth, cluster);
            region.mode.push(Live { log_l, slot });
            region.barren = 0;
        }
    }
}

/// Whether a region is better drawn from the whole cube: its ellipsoids are no smaller.
fn is_cube(region: &Region, log_volume: f64) -> bool {
    region.mode.node == 0 && log_volume >= 0.0
}

/// ln of the summed volume of the ellipsoids.
fn total_log_volume(clusters: &[Cluster]) -> f64 {
    clusters.iter().fold(f64::NEG_INFINITY, |sum, c| {
        log_add(sum, c.ellipsoid.log_volume())
    })
}

impl Sampler for MultiNest {
    fn ask(&mut self) -> Result<&[f64], SamplerError> {
        if !self.origin.is_empty() {
            return Err(SamplerError::Protocol(
                "asked twice without being told".into(),
            ));
        }
        self.asked.clear();
        let contour = self.regions.first().map(|r| r.mode.contour());
        self.nest.check_budget(contour.unwrap_or(f64::INFINITY))?;
        self.prepare();
        for i in 0..self.regions.len() {
            self.propose(i)?;
        }
        Ok(&self.asked)
    }

    fn tell(&mut self, log_l: &[f64]) -> Result<(), SamplerError> {
        self.nest.check_told(&self.asked, log_l)?;
        let starting = self.is_starting();
        for (k, &log_l) in log_l.iter().enumerate() {
            self.offer(k, log_l, starting);
        }
        self.origin.clear();
        Ok(())
    }

    fn progress(&self) -> Progress {
        self.nest.progress(self.regions.iter().map(|r| &r.mode))
    }

    fn finish(self: Box<Self>) -> NestedRun {
        self.nest.finish(self.regions.into_iter().map(|r| r.mode))
    }
}
