//! The region that proposals are drawn from: ellipsoids around the live points.

mod cloud;
mod decompose;
mod ellipsoid;
mod fit;
mod friends;
mod linkage;
mod neighbourhood;
mod union;

pub(super) use cloud::Cloud;
pub(super) use decompose::{Decomposition, decompose, refit};
pub use ellipsoid::Ellipsoid;
pub(super) use fit::{Cluster, pooled, scarcity, typical};
pub(super) use neighbourhood::Neighbourhood;
pub(super) use union::Union;

use friends::Sets;

/// Groups of ellipsoids with no intersection between groups, and no friends either: ellipsoids
/// that cut a thin curve into arcs may stand apart where the points do not. Groups in order of first member.
///
/// `shadows` are the ellipsoids in the mode dimensions; those with the same number in `part` are
/// connected by their points, and so are the pairs of `links`.
pub(super) fn separate(
    shadows: &[Ellipsoid],
    part: &[usize],
    links: &[(usize, usize)],
) -> Vec<Vec<usize>> {
    let mut groups = Sets::new(shadows.len());
    for &(i, j) in links {
        groups.join(i, j);
    }
    for i in 0..shadows.len() {
        for j in 0..i {
            let apart = groups.find(i) != groups.find(j);
            if apart && (part[i] == part[j] || shadows[i].intersects(&shadows[j])) {
                groups.join(i, j);
            }
        }
    }
    groups.parts()
}
