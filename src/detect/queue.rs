//! Which tiles to search next.
//!
//! The brightest first: a tile waits while an overlapping one is brighter, or while it is as faint
//! as the sidelobes of the brightest. Once those sources are subtracted it is screened again, and
//! mostly there is nothing left in it.

use std::collections::BTreeMap;

use super::refine::{CLOSE_BEAMS, Found};
use super::screen::screen;
use super::{DetectError, Observer, Screening, Settings, Tile, leftover};
use crate::dataset::{Dataset, Extremes, Survey};
use crate::prior::Region;

/// What is fainter than this part of the brightest waits until that is subtracted: more than the sidelobes of most arrays at
/// natural weight.
pub(super) const SIDELOBE: f64 = 0.25;

/// A tile is searched where at least this part of its highest value is seen.
const PART_OF_BRIGHTEST: f64 = 0.5;
/// Sky in widths of the beam that is searched about what can hold a source: a mode lies whole in it.
const SEARCH_BEAMS: f64 = 1.5;

/// The tiles that are still to be searched.
pub(super) struct Queue {
    open: Vec<Tile>,
    /// Tiles that could not hold a source when they were last screened.
    faint: Vec<Tile>,
    /// How they are screened; none: they are not.
    survey: Option<Survey>,
    /// Area of each tile that was searched, by its number [rad²].
    searched: BTreeMap<usize, f64>,
    /// Tiles in which, last time, something as far below zero as the cut was above it.
    n_negative: usize,
}

impl Queue {
    pub(super) fn new(dataset: &Dataset, settings: &Settings) -> Result<Self, DetectError> {
        let plan = || dataset.plan_survey(&settings.field, &settings.prior);
        Ok(Self {
            open: settings.tiles.clone(),
            faint: Vec::new(),
            searched: BTreeMap::new(),
            survey: settings.screening.then(plan).transpose()?,
            n_negative: 0,
        })
    }

    /// What came of the screening: the part of the field left out, the part of its signal-to-noise
    /// ratio that a source shows, tiles with a negative peak as high as the cut.
    pub(super) fn screening(&self, field: &Region) -> Option<Screening> {
        self.survey.as_ref().map(|survey| Screening {
            skipped: 1.0 - self.searched.values().sum::<f64>() / field.area(),
            seen: survey.seen(),
            n_negative: self.n_negative,
        })
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

    /// What to search now; nothing if no open tile can hold a source, or something that the model of
    /// one of `settled` leaves.
    pub(super) fn take(
        &mut self,
        dataset: &mut Dataset,
        settings: &Settings,
        settled: &[Found],
        observer: &mut dyn Observer,
    ) -> Result<Vec<Search>, DetectError> {
        let tiles = std::mem::take(&mut self.open);
        let Some(survey) = &mut self.survey else {
            return Ok(tiles.into_iter().map(Search::whole).collect());
        };
        let faintest = survey.seen() * settings.cuts.snr;
        // What is fainter is searched once the brighter is subtracted.
        let part = if settings.refine {
            PART_OF_BRIGHTEST
        } else {
            0.0
        };
        let faintest_left = faintest.min(survey.seen() * leftover::LEAST_SNR);
        let limit = |tile: &Tile| {
            let about = tile.core.grown(CLOSE_BEAMS * settings.beam_rad);
            let is_beside = |found: &Found| about.contains(found.mode.mean.lm);
            if settled.iter().any(is_beside) {
                faintest_left
            } else {
                faintest
            }
        };
        let lowest = if settled.is_empty() {
            faintest
        } else {
            faintest_left
        };
        let seen = screen(dataset, survey, &tiles, lowest, part, observer)?;
        let is_negative = |seen: &&Extremes| seen.low <= -settings.cuts.snr;
        self.n_negative = seen.iter().filter(is_negative).count();
        let brightest = seen.iter().map(|seen| seen.high).fold(0.0, f64::max);
        let (bright, faint): (Vec<_>, Vec<_>) = tiles
            .into_iter()
            .zip(seen)
            .partition(|(tile, seen)| seen.high >= limit(tile));
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
        let margin_rad = SEARCH_BEAMS * settings.beam_rad;
        let search = |i: usize| Search::around(&bright[i].0, &bright[i].1, margin_rad);
        let searches: Vec<Search> = now.into_iter().map(search).collect();
        for Search { tile, region } in &searches {
            let area = self.searched.entry(tile.id).or_default();
            *area = area.max(region.clipped(&tile.core).area());
        }
        Ok(searches)
    }
}

/// What is searched of a tile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    pub(super) tile: Tile,
    pub(super) region: Region,
}

impl Search {
    fn whole(tile: Tile) -> Self {
        let region = tile.region;
        Self { tile, region }
    }

    /// The part of the tile that can hold a source.
    fn around(tile: &Tile, seen: &Extremes, margin_rad: f64) -> Self {
        let bright = seen.above.unwrap_or(tile.region);
        let region = bright.grown(margin_rad).clipped(&tile.region);
        Self {
            tile: *tile,
            region,
        }
    }
}

fn waits(tiles: &[(Tile, Extremes)], i: usize, limit: f64) -> bool {
    let (tile, seen) = &tiles[i];
    let outshone = |(j, (other, other_seen)): (usize, &(Tile, Extremes))| {
        (other_seen.high, j) > (seen.high, i) && other.region.overlaps(&tile.region)
    };
    seen.high < limit || tiles.iter().enumerate().any(outshone)
}
