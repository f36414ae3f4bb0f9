//! Nested slice sampling: new points come from chains that walk through the live region.

mod chain;

use super::bound::{Cluster, Ellipsoid};
use super::nest::{Child, Live, Mode, Nest};
use super::{NestedRun, Progress, Sampler, SamplerError};
use chain::Chain;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Options of [`Slice`].
#[derive(Debug, Clone, PartialEq)]
pub struct SliceConfig {
    /// Dimensions of the problem.
    pub n_dim: usize,
    /// Live points at the start; they are shared among the modes.
    pub n_live: usize,
    /// Live points that each mode is topped up to when it splits off with fewer, at most `n_live`.
    pub n_live_mode: usize,
    /// Slices from a live point to a new one.
    pub n_repeats: usize,
    /// Share of a mode's live points that are replaced at a time, by chains side by side.
    pub replaced: f64,
    /// A mode is finished when its live points can add no more than this fraction to its evidence.
    pub tolerance: f64,
    /// Dimensions in which separate groups of points are separate modes; empty: no modes.
    pub mode_dims: Vec<usize>,
    /// Dimensions that are circles: 0 and 1 are the same place.
    pub wrapped: Vec<usize>,
    /// All randomness derives from it.
    pub seed: u64,
    /// Most likelihood evaluations.
    pub max_eval: Option<u64>,
}

impl SliceConfig {
    /// The defaults: 3 d slices a point, 12 at least, a quarter of the live points at a time, tolerance 0.5, modes
    /// in all dimensions, 10 (d + 2) live points a mode at least.
    pub fn new(n_dim: usize, n_live: usize) -> Self {
        Self {
            n_dim,
            n_live,
            n_live_mode: (10 * (n_dim + 2)).min(n_live),
            n_repeats: (3 * n_dim).max(12),
            replaced: 0.25,
            tolerance: 0.5,
            mode_dims: (0..n_dim).collect(),
            wrapped: Vec::new(),
            seed: 0,
            max_eval: None,
        }
    }

    /// What is wrong with the options, if anything.
    fn fault(&self) -> Option<&'static str> {
        let known = |dims: &[usize]| dims.iter().all(|&i| i < self.n_dim);
        [
            (self.n_dim > 0, "n_dim is zero"),
            (self.n_live >= 4, "n_live is below 4"),
            (self.n_repeats > 0, "n_repeats is zero"),
            (
                self.replaced > 0.0 && self.replaced <= 0.5,
                "replaced is outside (0, 0.5]",
            ),
            (self.tolerance > 0.0, "tolerance is not positive"),
            (
                known(&self.mode_dims),
                "mode_dims names a dimension that is not there",
            ),
            (
                known(&self.wrapped),
                "wrapped names a dimension that is not there",
            ),
        ]
        .into_iter()
        .find_map(|(good, fault)| (!good).then_some(fault))
    }
}

/// Multimodal nested sampling by slices: costs more likelihood calls than ellipsoids where these follow
/// the shape, but neither the calls nor the bias grow steeply with the dimension.
///
/// Of each mode, the worst quarter of the live points dies at once; as many chains start from
/// survivors, no two from the same if there are enough, and advance side by side: an `ask` holds the next
/// point of every chain of every mode. A slice is taken along a direction of a random orthonormal basis
/// in the space in which a cluster of live points is a ball, its width the diameter of that ball. It is not
/// stepped out but only shrunk (Neal 2003, section 4.1 and fig. 5, which holds for any width that does not
/// depend on the state): half the calls, and a chain may cross to another part of a curved region. Which
/// cluster gives the shape is drawn anew for each basis, whatever the state, so that all moves are
/// reversible. Places outside the cube or the mode's own part of it cost no call. Groups of live points that
/// look separate become modes once no chain goes from one to the other.
///
/// # Source
/// Neal 2003 (Ann. Statist. 31, 705); Handley, Hobson & Lasenby 2015 (MNRAS 453, 4384); many points at
/// a time: Henderson & Goggans 2014 (AIP Conf. Proc. 1636, 100).
#[derive(Debug)]
pub struct Slice {
    config: SliceConfig,
    rng: ChaCha8Rng,
    nest: Nest,
    regions: Vec<Region>,
    asked: Vec<f64>,
    /// Region and chain of each point of `asked`.
    origin: Vec<(usize, usize)>,
}

/// A mode with its chains.
#[derive(Debug)]
struct Region {
    mode: Mode,
    /// Its clusters: live points up to and including this one, over all; shape.
    shapes: Vec<(f64, Ellipsoid)>,
    /// Covariance of the modes that it split off together with.
    typical: Option<DMatrix<f64>>,
    chains: Vec<Chain>,
    /// Where the last chains began and ended: a mode is not divided while chains cross.
    links: Vec<(usize, usize)>,
}

impl Region {
    fn new(mode: Mode, clusters: Vec<Cluster>, typical: Option<DMatrix<f64>>) -> Self {
        let total: usize = clusters.iter().map(|c| c.index.len()).sum();
        let mut sum = 0;
        let shape = |cluster: Cluster| {
            sum += cluster.index.len();
            (sum as f64 / total as f64, cluster.ellipsoid)
        };
        Self {
            shapes: clusters.into_iter().map(shape).collect(),
            mode,
            typical,
            chains: Vec::new(),
            links: Vec::new(),
        }
    }
}

impl Slice {
    /// A sampler that has not asked yet.
    ///
    /// # Errors
    /// Options that make no sense.
    pub fn new(config: SliceConfig) -> Result<Self, SamplerError> {
        if let Some(fault) = config.fault() {
            return Err(SamplerError::Protocol(fault.to_string()));
        }
        let mode = Mode::whole(config.n_live);
        Ok(Self {
            rng: ChaCha8Rng::seed_from_u64(config.seed),
            nest: Nest::new(
                config.n_dim,
                config.n_live,
                &config.mode_dims,
                &config.wrapped,
                config.max_eval,
            ),
            regions: vec![Region::new(mode, vec![], None)],
            asked: Vec::new(),
            origin: Vec::new(),
            config,
        })
    }

    /// Whether the first live points are to be drawn from the whole cube.
    fn is_starting(&self) -> bool {
        self.nest.is_untouched() && self.regions.first().is_some_and(|r| r.mode.n_live() == 0)
    }

    /// Starts chains in every mode whose last ones have ended; finished modes end, others may split.
    fn prepare(&mut self) -> Result<(), SamplerError> {
        let (mut waiting, running): (Vec<_>, Vec<_>) = std::mem::take(&mut self.regions)
            .into_iter()
            .partition(|region| region.chains.is_empty());
        self.regions = running;
        while let Some(region) = waiting.pop() {
            let complete = region.mode.missing() == 0;
            if complete && region.mode.is_finished(self.config.tolerance) {
                self.nest.retire(region.mode);
                continue;
            }
            match self.renew(region, complete) {
                Renewed::One(region) => {
                    let region = self.start(region)?;
                    self.regions.push(region);
                }
                Renewed::Several(children) => waiting.extend(children),
            }
        }
        self.regions.sort_by_key(|region| region.mode.node);
        Ok(())
    }

    /// Finds the clusters of a mode, and splits it where they are apart.
    fn renew(&mut self, mut region: Region, may_split: bool) -> Renewed {
        if !may_split && !region.shapes.is_empty() {
            return Renewed::One(region);
        }
        let typical = region.typical.take();
        let clusters = self.nest.clusters(&mut region.mode, typical.as_ref());
        let groups = if may_split {
            self.nest.groups(&clusters, &region.links)
        } else {
            vec![]
        };
        if groups.len() < 2 {
            return Renewed::One(Region::new(region.mode, clusters, typical));
        }
        let n_live_mode = self.config.n_live_mode;
        let children = self
            .nest
            .split(region.mode, typical.as_ref(), groups, n_live_mode);
        let child = |c: Child| Region::new(c.mode, c.clusters, c.typical);
        Renewed::Several(children.into_iter().map(child).collect())
    }

    /// The worst points of a mode die, unless it still lacks some; chains start from the others.
    fn start(&mut self, mut region: Region) -> Result<Region, SamplerError> {
        let mode = &mut region.mode;
        if mode.missing() == 0 {
            let n_worst = (mode.n_live() as f64 * self.config.replaced) as usize;
            for _ in 0..n_worst.max(1) {
                self.nest.kill(mode);
            }
            // What lies on the new contour goes as well: a plateau leaves as one.
            while mode.worst().is_some_and(|worst| worst <= mode.contour()) {
                self.nest.kill(mode);
            }
        }
        let mut seeds = mode.points();
        if seeds.is_empty() {
            return Err(self.nest.stalled(mode));
        }
        let n_seeds = seeds.len();
        for k in 0..mode.missing() {
            // Each survivor once, in random order; then again.
            let k = k % n_seeds;
            let other = self.rng.random_range(k..n_seeds);
            seeds.swap(k, other);
            let Live { log_l, slot } = seeds[k];
            let mut u = self.nest.points.cloud().row(slot).to_vec();
            self.nest.points.wrap(&mut u);
            region
                .chains
                .push(Chain::new(u, log_l, slot, self.config.n_repeats));
        }
        Ok(region)
    }

    /// The next point of each chain.
    fn propose(&mut self) {
        let Self {
            regions,
            nest,
            rng,
            asked,
            origin,
            ..
        } = self;
        for (i, region) in regions.iter_mut().enumerate() {
            let node = region.mode.node;
            let running = region.chains.iter_mut().enumerate();
            for (k, chain) in running.filter(|(_, chain)| !chain.is_done()) {
                chain.propose(rng, &region.shapes, |u| {
                    nest.points.wrap(u) && nest.territory.owns(node, u)
                });
                asked.extend_from_slice(chain.proposal());
                origin.push((i, k));
            }
        }
    }

    /// Chains that have made all their steps end as live points.
    fn collect(&mut self) -> Result<(), SamplerError> {
        for region in &mut self.regions {
            let mode = &mut region.mode;
            // They become live together: until then the contour stays where it is.
            if region.chains.is_empty() || region.chains.iter().any(|c| !c.is_done()) {
                continue;
            }
            if region.chains.iter().all(Chain::is_stuck) {
                return Err(self.nest.stalled(mode));
            }
            let birth = mode.contour().max(f64::MIN);
            region.links.clear();
            for chain in region.chains.drain(..) {
                let slot = self.nest.points.insert(chain.u(), birth, 0);
                let log_l = chain.log_l();
                mode.push(Live { log_l, slot });
                region.links.push((chain.start(), slot));
            }
        }
        Ok(())
    }
}

/// What a mode is after its clusters were looked for.
enum Renewed {
    One(Region),
    Several(Vec<Region>),
}

impl Sampler for Slice {
    fn ask(&mut self) -> Result<&[f64], SamplerError> {
        if !self.origin.is_empty() {
            return Err(SamplerError::Protocol(
                "asked twice without being told".into(),
            ));
        }
        self.asked.clear();
        let contour = self.regions.first().map(|r| r.mode.contour());
        self.nest.check_budget(contour.unwrap_or(f64::INFINITY))?;
        if self.is_starting() {
            let n = self.config.n_live * self.config.n_dim;
            self.asked.extend((0..n).map(|_| self.rng.random::<f64>()));
            self.origin = vec![(0, 0); self.config.n_live];
            return Ok(&self.asked);
        }
        self.prepare()?;
        self.propose();
        Ok(&self.asked)
    }

    fn tell(&mut self, log_l: &[f64]) -> Result<(), SamplerError> {
        self.nest.check_told(&self.asked, log_l)?;
        let starting = self.is_starting();
        let n_dim = self.config.n_dim;
        for (k, (i, chain)) in std::mem::take(&mut self.origin).into_iter().enumerate() {
            let Region { mode, chains, .. } = &mut self.regions[i];
            if starting {
                let u = &self.asked[k * n_dim..(k + 1) * n_dim];
                let slot = self.nest.points.insert(u, f64::NEG_INFINITY, 0);
                let log_l = log_l[k];
                mode.push(Live { log_l, slot });
            } else {
                chains[chain].take(log_l[k], mode.contour());
            }
        }
        self.collect()
    }

    fn progress(&self) -> Progress {
        self.nest.progress(self.regions.iter().map(|r| &r.mode))
    }

    fn finish(self: Box<Self>) -> NestedRun {
        self.nest.finish(self.regions.into_iter().map(|r| r.mode))
    }
}
