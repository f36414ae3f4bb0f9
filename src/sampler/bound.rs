//! The region that proposals are drawn from: ellipsoids around the live points.

mod cloud;
mod decompose;
mod ellipsoid;
mod fit;
mod friends;
mod union;

pub(super) use cloud::Cloud;
pub(super) use decompose::{Decomposition, decompose, refit};
pub use ellipsoid::Ellipsoid;
pub(super) use union::Union;

use friends::Sets;

/// Groups of ellipsoids with no intersection between groups; groups in order of first member.
pub(super) fn separate(ellipsoids: &[Ellipsoid]) -> Vec<Vec<usize>> {
    let mut sets = Sets::new(ellipsoids.len());
    for i in 0..ellipsoids.len() {
        for j in 0..i {
            if sets.find(i) != sets.find(j) && ellipsoids[i].intersects(&ellipsoids[j]) {
                sets.join(i, j);
            }
        }
    }
    sets.parts()
}
