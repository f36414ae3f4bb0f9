//! Drives one sampler on one problem.

use super::{NestedRun, Progress, Sampler, SamplerError};
use std::ops::ControlFlow;

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError<E> {
    /// The sampler cannot go on.
    #[error(transparent)]
    Sampler(#[from] SamplerError),
    /// The likelihood failed.
    #[error("the likelihood failed")]
    Likelihood(#[source] E),
}

/// Asks, evaluates and tells until the sampler is finished or `observe` breaks off; then finishes.
///
/// `log_likelihood` takes points, axes (point, dimension), and gives ln L of each.
///
/// # Errors
/// A stall, or an error of the likelihood.
pub fn run<E>(
    mut sampler: Box<dyn Sampler>,
    mut log_likelihood: impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
    mut observe: impl FnMut(&Progress) -> ControlFlow<()>,
) -> Result<NestedRun, RunError<E>> {
    loop {
        let u = sampler.ask()?;
        if u.is_empty() {
            break;
        }
        let log_l = log_likelihood(u).map_err(RunError::Likelihood)?;
        sampler.tell(&log_l)?;
        if observe(&sampler.progress()).is_break() {
            break;
        }
    }
    Ok(sampler.finish())
}
