//! One mode of [`super::MultiNest`]: its bound, and when that is due for renewal.

use crate::sampler::bound::{Neighbourhood, Union};
use crate::sampler::nest::Mode;
use nalgebra::DMatrix;

/// A mode with the region that its proposals come from.
#[derive(Debug)]
pub(super) struct Region {
    pub(super) mode: Mode,
    /// Where proposals come from.
    pub(super) bound: Union,
    /// What of it is near a live point; none: all.
    pub(super) near: Option<Neighbourhood>,
    /// Its deaths when the clusters were last searched for.
    pub(super) dead_at_search: usize,
    /// Its deaths and its live points when the ellipsoids were last fitted.
    pub(super) dead_at_fit: usize,
    pub(super) n_at_fit: usize,
    /// Evaluations since the ellipsoids were last fitted.
    pub(super) n_tried: u64,
    /// Few of the points that its ellipsoids propose are good.
    pub(super) is_curved: bool,
    /// Evaluations since a point was last accepted.
    pub(super) barren: u64,
    /// Covariance of the modes that it split off together with.
    pub(super) typical: Option<DMatrix<f64>>,
}

impl Region {
    /// The whole cube.
    pub(super) fn new(mode: Mode) -> Self {
        Self {
            mode,
            bound: Union::default(),
            near: None,
            dead_at_search: 0,
            dead_at_fit: 0,
            n_at_fit: 0,
            n_tried: 0,
            is_curved: false,
            barren: 0,
            typical: None,
        }
    }

    /// Deaths since the clusters were last searched for.
    pub(super) fn since_search(&self) -> usize {
        self.mode.n_dead() - self.dead_at_search
    }

    /// Deaths since the ellipsoids were last fitted.
    pub(super) fn since_fit(&self) -> usize {
        self.mode.n_dead() - self.dead_at_fit
    }
}
