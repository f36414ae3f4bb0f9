//! Nested sampling of any problem on the unit cube; nothing here has heard of radio.
//!
//! A sampler is asked for points and told their likelihoods, so that whoever owns the data decides
//! how points are evaluated: one pass over the data can serve the batches of many samplers.

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
    /// Mode that the point belongs to: index into [`NestedRun::modes`].
    pub mode: usize,
}

/// All that a run leaves; evidence, weights and posterior are functions of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NestedRun {
    /// Dimensions of the problem.
    pub n_dim: usize,
    /// Dead points, ln L ascending.
    pub dead: Vec<DeadPoint>,
}
