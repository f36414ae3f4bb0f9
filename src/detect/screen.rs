//! Screening: which tiles can hold a source at all (branch and bound, method section 4).
//!
//! Over shape and flux density, the best ln L at a position is X²/(2Y). On a grid of positions,
//! for a few shapes, X/sqrt(Y) is therefore the signal-to-noise ratio that a source there could
//! have, but for what the grid and the shapes miss. A tile in which it stays below the cut by more
//! than that holds no mode that would be kept.

use super::{DetectError, Observer, Tile};
use crate::dataset::{Dataset, Extremes, Survey};
use crate::prior::Region;

/// What is seen of each of `tiles`, and where it reaches `limit` and the part `part` of the highest.
pub(super) fn screen(
    dataset: &mut Dataset,
    survey: &mut Survey,
    tiles: &[Tile],
    limit: f64,
    part: f64,
    observer: &mut dyn Observer,
) -> Result<Vec<Extremes>, DetectError> {
    let cores: Vec<Region> = tiles.iter().map(|tile| tile.core).collect();
    let mut progress = |n_done, n_facet| {
        if n_done == 0 {
            observer.stage("screening", n_facet);
        }
        observer.advance(n_done, 0);
    };
    Ok(dataset.survey(survey, &cores, [limit, part], &mut progress)?)
}
