//! Screening: which tiles can hold a source at all (branch and bound, method section 4).
//!
//! Over shape and flux density, the best ln L at a position is X²/(2Y). On a grid of positions,
//! for a few shapes, X/sqrt(Y) is therefore the signal-to-noise ratio that a source there could
//! have, but for what the grid and the shapes miss. A tile in which it stays below the cut by more
//! than that holds no mode that would be kept.

use super::{DetectError, Observer, Tile};
use crate::dataset::{Dataset, Survey};

/// What a look at tiles gave.
pub(super) struct Seen {
    /// Highest X/sqrt(Y) in each.
    pub(super) high: Vec<f64>,
    /// Lowest: as far below zero as noise and sidelobes go above it.
    pub(super) low: Vec<f64>,
}

/// Looks at `tiles`.
pub(super) fn screen(
    dataset: &mut Dataset,
    survey: &mut Survey,
    tiles: &[Tile],
    observer: &mut dyn Observer,
) -> Result<Seen, DetectError> {
    let holds = |i: &usize| {
        let facet = survey.facets()[*i];
        tiles.iter().any(|tile| facet.overlaps(&tile.core))
    };
    let which: Vec<usize> = (0..survey.facets().len()).filter(holds).collect();
    observer.stage("screening", which.len() as u64);
    let mut seen = Seen {
        high: vec![f64::NEG_INFINITY; tiles.len()],
        low: vec![f64::INFINITY; tiles.len()],
    };
    let mut n_done = 0;
    dataset.survey(survey, &which, |map| {
        for (i, tile) in tiles.iter().enumerate() {
            if tile.core.overlaps(&map.region) {
                let [high, low] = map.extremes(&tile.core);
                seen.high[i] = seen.high[i].max(high);
                seen.low[i] = seen.low[i].min(low);
            }
        }
        n_done += 1;
        observer.advance(n_done, 0);
    })?;
    Ok(seen)
}
