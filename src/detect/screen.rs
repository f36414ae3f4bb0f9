//! Screening: which tiles can hold a source at all (branch and bound, method section 4).
//!
//! Over shape and flux density, the best ln L at a position is X²/(2Y). On a grid of positions,
//! for a few shapes, X/sqrt(Y) is therefore the signal-to-noise ratio that a source there could
//! have, but for what the grid and the shapes miss. A tile in which it stays below the cut by more
//! than that holds no mode that would be kept.

use super::{DetectError, Observer, Tile};
use crate::dataset::{Dataset, Extremes, Survey};

/// What is seen of each of `tiles`, and where it reaches `limit` and the part `part` of the highest.
pub(super) fn screen(
    dataset: &mut Dataset,
    survey: &mut Survey,
    tiles: &[Tile],
    limit: f64,
    part: f64,
    observer: &mut dyn Observer,
) -> Result<Vec<Extremes>, DetectError> {
    let holds = |i: &usize| {
        let facet = survey.facets()[*i];
        tiles.iter().any(|tile| facet.overlaps(&tile.core))
    };
    let which: Vec<usize> = (0..survey.facets().len()).filter(holds).collect();
    observer.stage("screening", which.len() as u64);
    let mut seen = vec![Extremes::NOTHING; tiles.len()];
    let mut n_done = 0;
    dataset.survey(survey, &which, |map| {
        for (seen, tile) in seen.iter_mut().zip(tiles) {
            if tile.core.overlaps(&map.region) {
                *seen = seen.and(map.extremes(&tile.core, limit, part));
            }
        }
        n_done += 1;
        observer.advance(n_done, 0);
    })?;
    Ok(seen)
}
