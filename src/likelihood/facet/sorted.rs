//! Samples in the order of where they fall on the grids.
//!
//! A block holds baselines of all lengths, and a sample touches 64 cells: in file order each one
//! would have to wait for memory. Sorted by tiles of the grid once for all facets, the cells stay in
//! the first-level cache. The stream is cut into chunks of its own, so that neither blocks nor calls
//! matter.

use super::plan::{FacetPlan, Fine};
use crate::likelihood::VisBlock;

/// Samples in a chunk (9 MB).
pub(super) const CHUNK: usize = 1 << 18;

/// Side of a tile [cells].
const TILE: i64 = 16;

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
                self.chunks.push(VisBlock::default());
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
            chunk.weight.extend_from_slice(&block.weight[range]);
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

/// The samples of `chunk`, those of a tile together, otherwise in their order.
pub(super) fn sorted(plan: &FacetPlan, chunk: &VisBlock) -> VisBlock {
    let fine = plan.fine();
    let tiles = plan.levels * tiles_per_level(fine);
    let keys: Vec<u32> = (0..chunk.len())
        .map(|k| tile(plan, fine, chunk.u[k], chunk.v[k]) as u32)
        .collect();
    let mut starts = vec![0u32; tiles + 1];
    for &key in &keys {
        starts[key as usize + 1] += 1;
    }
    for i in 0..tiles {
        starts[i + 1] += starts[i];
    }
    let mut order = vec![0u32; chunk.len()];
    for (k, &key) in keys.iter().enumerate() {
        order[starts[key as usize] as usize] = k as u32;
        starts[key as usize] += 1;
    }
    let doubles = |from: &[f64]| order.iter().map(|&k| from[k as usize]).collect();
    let singles = |from: &[f32]| order.iter().map(|&k| from[k as usize]).collect();
    VisBlock {
        u: doubles(&chunk.u),
        v: doubles(&chunk.v),
        w: doubles(&chunk.w),
        weighted_re: singles(&chunk.weighted_re),
        weighted_im: singles(&chunk.weighted_im),
        weight: singles(&chunk.weight),
    }
}

fn tiles_per_level(fine: Fine) -> usize {
    (fine.rows as i64 / TILE + 1) as usize * (fine.cols as i64 / TILE + 1) as usize
}

/// The tile of a sample, without what w does to it.
fn tile(plan: &FacetPlan, fine: Fine, u: f64, v: f64) -> usize {
    let sign = 1f64.copysign(v);
    let level = plan.level_of(u, v);
    let scale = sign * 2f64.powi(level as i32) * fine.cells_per_wavelength;
    let (col, row) = ((u * scale) as i64 - fine.first_col, (v * scale) as i64);
    let along_u = fine.cols as i64 / TILE + 1;
    let tile = row / TILE * along_u + (col / TILE).clamp(0, along_u - 1);
    level * tiles_per_level(fine) + (tile as usize).min(tiles_per_level(fine) - 1)
}
