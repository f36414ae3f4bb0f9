//! Samples in the order of where they fall on the grids.
//!
//! A block holds baselines of all lengths, and a sample touches 64 cells: in file order each one
//! would have to wait for memory. Sorted by tiles of the grid once for all facets, the cells stay in
//! the first-level cache, and sums of a tile are short enough for f32. The stream is cut into chunks of its own, so that neither blocks nor calls
//! matter.

use super::plan::{FacetPlan, Fine};
use crate::likelihood::VisBlock;
use std::ops::Range;

/// Samples in a chunk (9 MB).
pub(super) const CHUNK: usize = 1 << 18;

/// Side of a tile [cells].
pub(super) const TILE: i32 = 24;

/// A run of samples, waiting.
#[derive(Debug, Default)]
pub(super) struct Queue {
    /// Full chunks and a last one that is not.
    chunks: Vec<VisBlock>,
}

impl Queue {
    /// Appends the samples of `block`.
    pub(super) fn push(&mut self, block: &VisBlock) {
        let mut first = 0;
        while first < block.len() {
            if self.chunks.last().is_none_or(|chunk| chunk.len() == CHUNK) {
                self.chunks.push(VisBlock::with_capacity(CHUNK));
            }
            let Some(chunk) = self.chunks.last_mut() else {
                return;
            };
            let range = first..block.len().min(first + CHUNK - chunk.len());
            first = range.end;
            chunk.u.extend_from_slice(&block.u[range.clone()]);
            chunk.v.extend_from_slice(&block.v[range.clone()]);
            chunk.w.extend_from_slice(&block.w[range.clone()]);
            let (re, im) = (&block.weighted_re, &block.weighted_im);
            chunk.weighted_re.extend_from_slice(&re[range.clone()]);
            chunk.weighted_im.extend_from_slice(&im[range.clone()]);
            chunk.weight.extend_from_slice(&block.weight[range.clone()]);
            chunk.extents.extend_from(&block.extents, range);
        }
    }

    /// Takes the full chunks; all of them if `everything`.
    pub(super) fn take(&mut self, everything: bool) -> Vec<VisBlock> {
        let partial = self.chunks.last().is_some_and(|chunk| chunk.len() < CHUNK);
        let rest = if partial && !everything {
            self.chunks.pop()
        } else {
            None
        };
        let full = std::mem::take(&mut self.chunks);
        self.chunks.extend(rest);
        full
    }
}

/// A tile of the fine grid of a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) level: i32,
    /// First row and column, from the first ones of the grid.
    pub(super) row: i32,
    pub(super) col: i32,
}

/// The samples of a chunk, those of a tile together.
#[derive(Debug)]
pub(super) struct Sorted {
    pub(super) block: VisBlock,
    /// Every tile that has samples, and which.
    pub(super) runs: Vec<(Tile, Range<usize>)>,
}

impl Sorted {
    /// Sorts `chunk` by tile; within a tile the samples keep their order.
    pub(super) fn new(plan: &FacetPlan, chunk: &VisBlock) -> Sorted {
        let tiles = Tiles::new(plan);
        let keys: Vec<u32> = (0..chunk.len())
            .map(|k| tiles.index(plan, chunk.u[k], chunk.v[k]))
            .collect();
        let mut starts = vec![0; tiles.count() + 1];
        for &key in &keys {
            starts[key as usize + 1] += 1;
        }
        for i in 0..tiles.count() {
            starts[i + 1] += starts[i];
        }
        let runs = (0..tiles.count())
            .map(|i| (tiles.tile(i), starts[i]..starts[i + 1]))
            .filter(|(_, range)| !range.is_empty())
            .collect();
        let mut order = vec![0u32; chunk.len()];
        for (k, &key) in keys.iter().enumerate() {
            order[starts[key as usize]] = k as u32;
            starts[key as usize] += 1;
        }
        let block = chunk.select(&order);
        Sorted { block, runs }
    }
}

/// The tiles of all levels.
struct Tiles {
    levels: usize,
    fine: Fine,
    rows: i32,
    cols: i32,
}

impl Tiles {
    fn new(plan: &FacetPlan) -> Tiles {
        let fine = plan.fine();
        Tiles {
            levels: plan.levels,
            fine,
            rows: fine.rows as i32 / TILE + 1,
            cols: fine.cols as i32 / TILE + 1,
        }
    }

    fn count(&self) -> usize {
        self.levels * (self.rows * self.cols) as usize
    }

    /// The tile of a sample, without what w does to it.
    fn index(&self, plan: &FacetPlan, u: f64, v: f64) -> u32 {
        let level = plan.level_of(u, v) as i32;
        let scale = 1f64.copysign(v) * 2f64.powi(level) * self.fine.cells_per_wavelength;
        let row = ((v * scale) as i32 - self.fine.first_row as i32) / TILE;
        let col = ((u * scale) as i32 - self.fine.first_col as i32) / TILE;
        let (row, col) = (row.clamp(0, self.rows - 1), col.clamp(0, self.cols - 1));
        ((level * self.rows + row) * self.cols + col) as u32
    }

    fn tile(&self, index: usize) -> Tile {
        let index = index as i32;
        Tile {
            level: index / (self.rows * self.cols),
            row: index / self.cols % self.rows * TILE,
            col: index % self.cols * TILE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::facet::tests::plan;
    use crate::likelihood::samples::noise;

    #[test]
    fn the_queue_cuts_the_stream_anew() {
        let mut queue = Queue::default();
        let block = noise(CHUNK / 2 + 10, 1);
        queue.push(&block);
        assert!(queue.take(false).is_empty());
        queue.push(&block);
        let full = queue.take(false);
        assert_eq!(full.len(), 1);
        assert_eq!(full[0].len(), CHUNK);
        assert_eq!(full[0].u[CHUNK / 2 + 10], block.u[0]);
        let rest = queue.take(true);
        assert_eq!(rest[0].len(), 20);
        assert_eq!(rest[0].w[..], block.w[block.len() - 20..]);
        assert!(queue.take(true).is_empty());
    }

    #[test]
    fn every_sample_is_in_one_run_of_its_tile() {
        let (plan, chunk) = (plan(20.0), noise(3_000, 2));
        let sorted = Sorted::new(&plan, &chunk);
        let ends: Vec<_> = sorted.runs.iter().map(|(_, range)| range.clone()).collect();
        assert_eq!((ends[0].start, ends[ends.len() - 1].end), (0, 3_000));
        assert!(ends.windows(2).all(|w| w[0].end == w[1].start));
        let tiles = Tiles::new(&plan);
        for (tile, range) in &sorted.runs {
            for k in range.clone() {
                let index = tiles.index(&plan, sorted.block.u[k], sorted.block.v[k]);
                assert_eq!(tiles.tile(index as usize), *tile);
            }
        }
        let sum = |block: &VisBlock| block.weight.iter().map(|&w| f64::from(w)).sum::<f64>();
        assert!((sum(&sorted.block) / sum(&chunk) - 1.0).abs() < 1e-12);
    }
}
