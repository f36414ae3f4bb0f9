//! One mode of [`super::MultiNest`]: its bound, and when that is due for renewal.

use crate::sampler::bound::{Cluster, Neighbourhood, Union};
use crate::sampler::nest::Mode;
use nalgebra::DMatrix;

/// Live points from which on a search takes so long that it waits for a reason.
const MANY: usize = 1000;
/// Growth of ln of the ellipsoids' volume over the expected one that is such a reason.
const DRIFT: f64 = 0.05;
/// ln of the ellipsoids' volume over the expected one from which on every fit of many points is a search.
const VAST: f64 = 3.0;
/// Draws from the cube, in live points, after which there is a search though few points have died.
const VAIN: u64 = 8;

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
    /// ln of the ellipsoids' volume over the expected one, at the last fit and at the last search.
    pub(super) excess: f64,
    pub(super) excess_at_search: f64,
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
            excess: 0.0,
            excess_at_search: 0.0,
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

    /// Whether clusters are to be searched for: after as many deaths as half the live points. Where these
    /// are many, only if there are no ellipsoids or they have got worse, or after as many again.
    ///
    /// Sooner where most draws are in vain, from the cube or for many points: faint modes die within a small part
    /// of the volume that bright ones have, and have to be seen before.
    pub(super) fn is_search_due(&self) -> bool {
        let n = self.mode.n_live();
        let half = 2 * self.since_search() >= n;
        let is_worse = self.excess > self.excess_at_search + DRIFT;
        let is_cube = self.bound.ellipsoids().is_empty();
        let is_vain = if is_cube {
            self.n_tried >= VAIN * n as u64
        } else {
            n > MANY && self.excess > VAST && 8 * self.since_search() >= n
        };
        is_vain || half && (n <= MANY || is_worse || is_cube || self.since_search() >= n)
    }

    /// A mode of few points leans on the shape that it had last: it shrinks more in some dimensions than in
    /// others, and that of its siblings at the split soon fits it no more.
    pub(super) fn follow(&mut self, clusters: &[Cluster]) {
        if let [whole] = clusters
            && let Some(covariance) = &whole.covariance
        {
            self.typical = Some(covariance.clone());
        }
    }

    /// Deaths since the ellipsoids were last fitted.
    pub(super) fn since_fit(&self) -> usize {
        self.mode.n_dead() - self.dead_at_fit
    }
}
