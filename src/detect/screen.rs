//! Screening: which tiles can hold a source at all (branch and bound, method section 4).
//!
//! Over shape and flux density, the best ln L at a position is X²/(2Y). On a grid of positions,
//! for a few shapes, X/sqrt(Y) is therefore the signal-to-noise ratio that a source there could
//! have, but for what the grid and the shapes miss. A tile in which it stays below the cut by more
//! than that holds no mode that would be kept.

use super::{DetectError, Observer, Tile};
use crate::coords::Lm;
use crate::dataset::{Dataset, Request};
use crate::prior::{Region, SourcePrior};
use crate::rime::Source;
use crate::rime::shape::Ellipticity;

/// Spacing of the grid in widths of the beam.
const SPACING_BEAMS: f64 = 0.9;
/// Part of its signal-to-noise ratio that a source keeps at the nearest grid point (at least 0.82,
/// half a cell's diagonal or 0.64 beams away) under the nearest template (0.9 for the longest
/// disks), and a little to spare.
pub(super) const SEEN_FRACTION: f64 = 0.7;
/// Points evaluated at a time.
const BATCH: usize = 1 << 16;

/// Best X/sqrt(Y) seen in each tile.
pub(super) fn screen(
    dataset: &mut Dataset,
    tiles: &[Tile],
    prior: &SourcePrior,
    beam_rad: f64,
    observer: &mut dyn Observer,
) -> Result<Vec<f64>, DetectError> {
    observer.stage("screening tiles", tiles.len() as u64);
    let shapes = [prior.flux.low_jy, prior.flux.high_jy].map(|s| prior.scale.from_unit(0.5, s));
    let mut best = vec![f64::NEG_INFINITY; tiles.len()];
    let mut batch: Vec<(usize, Source)> = Vec::new();
    let n_eval_before = dataset.n_eval();
    for (i, tile) in tiles.iter().enumerate() {
        for lm in grid(&tile.core, SPACING_BEAMS * beam_rad) {
            let template = |scale_rad| Source {
                lm,
                flux_jy: 1.0,
                scale_rad,
                e: Ellipticity::default(),
            };
            batch.extend(shapes.map(|scale_rad| (i, template(scale_rad))));
        }
        if batch.len() >= BATCH || i + 1 == tiles.len() {
            note(dataset, &std::mem::take(&mut batch), &mut best)?;
            observer.advance(i as u64 + 1, dataset.n_eval() - n_eval_before);
        }
    }
    Ok(best)
}

fn note(
    dataset: &mut Dataset,
    batch: &[(usize, Source)],
    best: &mut [f64],
) -> Result<(), DetectError> {
    let points = batch.iter().map(|(_, source)| *source).collect();
    let xy = dataset.evaluate(&[Request {
        points,
        restored: Vec::new(),
    }])?;
    for ((tile, _), xy) in batch.iter().zip(&xy[0]) {
        best[*tile] = best[*tile].max(xy.snr_peak());
    }
    Ok(())
}

/// Positions that leave no point of the region further than half a cell's diagonal away.
fn grid(region: &Region, spacing_rad: f64) -> impl Iterator<Item = Lm> + use<> {
    let n = |length: f64| (length / spacing_rad).ceil().max(1.0) as usize;
    let (columns, rows) = (
        n(region.high.l - region.low.l),
        n(region.high.m - region.low.m),
    );
    let middle = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    let region = *region;
    (0..columns * rows)
        .map(move |i| region.from_unit(middle(i % columns, columns), middle(i / columns, rows)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_position_is_far_from_the_grid() {
        let region = Region {
            low: Lm { l: 0.0, m: 0.0 },
            high: Lm { l: 1.0, m: 0.35 },
        };
        let points: Vec<Lm> = grid(&region, 0.1).collect();
        for i in 0..=40 {
            for j in 0..=40 {
                let lm = region.from_unit(f64::from(i) / 40.0, f64::from(j) / 40.0);
                let nearest = points.iter().map(|p| p.distance(lm));
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest <= 0.1 * std::f64::consts::FRAC_1_SQRT_2 + 1e-12);
            }
        }
    }
}
