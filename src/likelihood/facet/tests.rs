//! Facets against the exact engine.

use super::*;
use crate::rime::shape::Profile;
use crate::units::ARCSEC;

/// A plan for facets of `side_arcsec` over the made-up samples of this room.
pub(super) fn plan(side_arcsec: f64) -> Arc<FacetPlan> {
    let needs = FacetNeeds {
        side_rad: side_arcsec * ARCSEC,
        farthest: 0.0125,
        reach: Reach { uv: 7.5e5, w: 3e5 },
        longest_axis_rad: 51.0 * ARCSEC,
        profile: Profile::Exponential,
    };
    Arc::new(FacetPlan::new(needs).unwrap())
}
