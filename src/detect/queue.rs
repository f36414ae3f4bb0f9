//! Which tiles to search next.
//!
//! The brightest first: a tile waits while an overlapping one is brighter, or while it is as faint
//! as the sidelobes of the brightest. Once those sources are subtracted it is screened again, and
//! mostly there is nothing left in it.

use super::screen::{SEEN_FRACTION, screen};
use super::{DetectError, Observer, Settings, Tile};
use crate::dataset::Dataset;

/// What is fainter than this part of the brightest waits until that is subtracted: more than the sidelobes of most arrays at
/// natural weight.
pub(super) const SIDELOBE: f64 = 0.25;

/// The tiles that are still to be searched.
pub(super) struct Queue {
    open: Vec<Tile>,
    /// Tiles that could not hold a source when they were last screened.
    faint: Vec<Tile>,
}

impl Queue {
    pub(super) fn new(tiles: &[Tile]) -> Self {
        Self {
            open: tiles.to_vec(),
            faint: Vec::new(),
        }
    }

    /// Looks at every tile again that was too faint before.
    pub(super) fn reopen_faint(&mut self) {
        self.open.append(&mut self.faint);
        self.open.sort_by_key(|tile| tile.id);
    }

    /// A tile that is to be searched again.
    pub(super) fn put_back(&mut self, tile: Tile) {
        self.open.push(tile);
    }

    /// The tiles to search now; none if no open tile can hold a source.
    pub(super) fn take(
        &mut self,
        dataset: &mut Dataset,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Vec<Tile>, DetectError> {
        let tiles = std::mem::take(&mut self.open);
        if !settings.screening {
            return Ok(tiles);
        }
        let beam_rad = settings.beam_rad;
        let seen = screen(dataset, &tiles, &settings.prior, beam_rad, observer)?;
        let faintest = SEEN_FRACTION * settings.cuts.snr;
        let brightest = seen.iter().copied().fold(0.0, f64::max);
        let (bright, faint): (Vec<_>, Vec<_>) = tiles
            .into_iter()
            .zip(seen)
            .partition(|(_, seen)| *seen >= faintest);
        self.faint.extend(faint.into_iter().map(|(tile, _)| tile));
        // Without subtraction there is nothing to wait for.
        let waits = |i: usize| settings.refine && waits(&bright, i, SIDELOBE * brightest);
        let (wait, now): (Vec<_>, Vec<_>) = (0..bright.len()).partition(|i| waits(*i));
        self.open.extend(wait.into_iter().map(|i| bright[i].0));
        tracing::info!(
            "{} tiles are searched now, {} wait; the brightest reaches {brightest:.1}",
            now.len(),
            self.open.len()
        );
        Ok(now.into_iter().map(|i| bright[i].0).collect())
    }
}

fn waits(tiles: &[(Tile, f64)], i: usize, limit: f64) -> bool {
    let (tile, seen) = tiles[i];
    let outshone = |(j, (other, other_seen)): (usize, &(Tile, f64))| {
        (*other_seen, j) > (seen, i) && other.region.overlaps(&tile.region)
    };
    seen < limit || tiles.iter().enumerate().any(outshone)
}
