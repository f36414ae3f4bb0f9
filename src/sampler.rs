//! Nested sampling of any problem on the unit cube; nothing here has heard of radio.
//!
//! A sampler is asked for points and told their likelihoods, so that whoever owns the data decides
//! how points are evaluated: one pass over the data can serve the batches of many samplers.
//!
//! ```text
//! MultiNest, Slice: ask -> points -> ln L -> tell, until ask is empty; finish -> NestedRun
//! NestedRun: dead points with birth contours + the tree of modes
//!     -> evidence(): log Z, its error, information, ess    -> log_weights()
//!     -> modes(): the same for every mode, with its posterior samples
//!     -> insertion_test(), log_z_err_bootstrap(), efficiency(), live_history(), health(): is it to be trusted?
//!     -> merge(): several runs as one
//! Population, Blocks: the same protocol, where a posterior of one piece is roughly known -> Draws
//! ```
//!
//! # Examples
//! ```
//! use std::ops::ControlFlow;
//! use vis2cat::sampler::{MultiNest, MultiNestConfig, run};
//!
//! // Two peaks in the unit square; the likelihood takes a batch of points, row after row.
//! let log_l = |u: &[f64]| -> Result<Vec<f64>, std::convert::Infallible> {
//!     let peak = |u: &[f64], x: f64| -((u[0] - x).powi(2) + (u[1] - 0.5).powi(2)) / 2e-4;
//!     Ok(u.chunks(2).map(|u| peak(u, 0.2).max(peak(u, 0.8) - 1.0)).collect())
//! };
//! let config = MultiNestConfig { seed: 1, ..MultiNestConfig::new(2, 200) };
//! let sampler = Box::new(MultiNest::new(config)?);
//! let result = run(sampler, log_l, |_| ControlFlow::Continue(()))?;
//!
//! let evidence = result.evidence();
//! let exact = (2e-4 * std::f64::consts::PI * (1.0 + f64::exp(-1.0))).ln();
//! assert!((evidence.log_z - exact).abs() < 4.0 * evidence.log_z_err);
//! let mut modes = result.modes();
//! modes.sort_by(|a, b| b.log_z.total_cmp(&a.log_z));
//! assert_eq!(modes.len(), 2);
//! assert!((modes[0].mean[0] - 0.2).abs() < 0.01 && (modes[1].mean[0] - 0.8).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod blocks;
mod bound;
mod diagnostics;
mod evidence;
mod merge;
mod modes;
mod multinest;
mod nest;
mod pareto;
mod population;
pub mod problems;
mod run;
mod slice;
mod student;

pub use blocks::{Blocks, BlocksConfig};
pub use bound::Ellipsoid;
pub use diagnostics::{Health, InsertionTest, ModeHistory};
pub use evidence::Evidence;
pub use merge::MergeError;
pub use modes::ModeSummary;
pub use multinest::{MultiNest, MultiNestConfig};
pub use population::{Population, PopulationConfig};
pub use run::{RunError, run};
pub use slice::{Slice, SliceConfig};

/// A nested sampler, driven from outside: `ask`, evaluate, `tell`, until `ask` brings nothing.
///
/// | function | meaning |
/// |---|---|
/// | `ask` | the points to evaluate next, row after row of `n_dim` coordinates in [0, 1); empty = finished |
/// | `tell` | ln L of each point of the last `ask`, in its order; -inf is allowed, NaN is an error |
/// | `progress` | where the run stands, for an observer |
/// | `finish` | the dead points (live ones added) and their modes |
pub trait Sampler: Send {
    /// Points to evaluate next, axes (point, dimension); empty when the run is finished.
    ///
    /// # Errors
    /// The run cannot go on (a stall), with advice.
    fn ask(&mut self) -> Result<&[f64], SamplerError>;

    /// Takes ln L of the points of the last `ask`.
    ///
    /// # Errors
    /// Wrong number of values, or NaN.
    fn tell(&mut self, log_l: &[f64]) -> Result<(), SamplerError>;

    /// Where the run stands.
    fn progress(&self) -> Progress;

    /// Ends the run: the live points become dead points.
    fn finish(self: Box<Self>) -> NestedRun;
}

/// A sampler of a posterior of one piece that is roughly known, driven like a [`Sampler`].
pub trait PosteriorSampler: Send {
    /// Points to evaluate next, axes (point, dimension); empty when the run is finished.
    fn ask(&mut self) -> &[f64];

    /// Takes ln L of the points of the last `ask`.
    ///
    /// # Errors
    /// Wrong number of values, or NaN.
    fn tell(&mut self, log_l: &[f64]) -> Result<(), SamplerError>;

    /// The draws; none of them if the run is not finished.
    fn finish(self: Box<Self>) -> Draws;
}

/// What a [`PosteriorSampler`] leaves: weighted draws.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Draws {
    /// Points in the unit cube, axes (point, dimension).
    pub u: Vec<f64>,
    /// ln L of each.
    pub log_l: Vec<f64>,
    /// Posterior weight of each, summing to one.
    pub weight: Vec<f64>,
    /// ln of the evidence, if the sampler brings it.
    pub log_z: Option<f64>,
    /// Effective number of points.
    pub ess: f64,
    /// Index of the tail of the weights; none if they have no tail.
    pub tail_index: Option<f64>,
    /// Likelihood evaluations, all included.
    pub n_eval: u64,
    /// There are enough effective points, and the sampler's own test of them has passed.
    pub is_converged: bool,
}

/// Where a run stands.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Progress {
    /// Likelihood evaluations so far.
    pub n_eval: u64,
    /// Dead points so far.
    pub n_dead: u64,
    /// Evidence accumulated.
    pub log_z: f64,
    /// Evidence that the live points may still add.
    pub log_z_remaining: f64,
    /// Modes that have live points.
    pub n_live_modes: usize,
}

/// A sampler cannot go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SamplerError {
    /// No acceptable point was found in a very long time.
    #[error(
        "the sampler stalled after {n_eval} likelihood evaluations at ln L = {log_l}: {advice}"
    )]
    Stalled {
        /// Likelihood evaluations so far.
        n_eval: u64,
        /// Contour it could not leave.
        log_l: f64,
        /// What to try.
        advice: String,
    },
    /// The caller broke the ask-tell protocol or the likelihood returned NaN.
    #[error("{0}")]
    Protocol(String),
}

/// A point that has left the live set.
#[derive(Debug, Clone, PartialEq)]
pub struct DeadPoint {
    /// Coordinates in the unit cube.
    pub u: Vec<f64>,
    /// ln L.
    pub log_l: f64,
    /// The contour above which the point was drawn; -inf for the first live points.
    pub log_l_birth: f64,
    /// Mode that the point died in: index into [`NestedRun::tree`].
    pub mode: usize,
    /// Undivided mode in whose part of the cube the point lies; `mode` itself or a descendant.
    pub leaf: usize,
}

/// A mode in the tree of splits; node 0 is the whole problem.
///
/// A parent lives until its live points part into groups, `n_split` of them in this one, at the
/// contour `log_l_split`; from there each child has its own contour.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeNode {
    /// The mode that it split from, always earlier in the tree.
    pub parent: Option<usize>,
    /// Live points that it took from the parent.
    pub n_split: usize,
    /// Contour at the split.
    pub log_l_split: f64,
}

impl ModeNode {
    /// The whole problem.
    pub fn root(n_live: usize) -> Self {
        Self {
            parent: None,
            n_split: n_live,
            log_l_split: f64::NEG_INFINITY,
        }
    }
}

/// All that a run leaves; evidence, weights and modes are functions of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NestedRun {
    /// Dimensions of the problem.
    pub n_dim: usize,
    /// Likelihood evaluations.
    pub n_eval: u64,
    /// Dead points, ln L ascending.
    pub dead: Vec<DeadPoint>,
    /// Modes and how they split; undivided ones are what [`NestedRun::modes`] reports.
    pub tree: Vec<ModeNode>,
}

/// ln(exp(a) + exp(b)).
pub(crate) fn log_add(a: f64, b: f64) -> f64 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY {
        return high;
    }
    high + (low - high).exp().ln_1p()
}
