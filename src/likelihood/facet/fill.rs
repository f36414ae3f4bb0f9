//! Spreading samples over the grids of a facet, on one core.
#![allow(clippy::inline_always)] // plain loops must be compiled anew for each instruction set
#![allow(unsafe_code)] // entering code compiled for an instruction set

use super::cells::LANES;
use super::lanes::Lanes;
use super::lanes::portable::Plain;
#[cfg(target_arch = "x86_64")]
use super::lanes::{avx2::Avx2, avx512::Avx512};
use super::plan::{FacetPlan, Fine, level_of_ratio};
use super::sorted::{Sorted, TILE, Tile};
use super::spread::{Spread, WIDTH};
use super::term::Centre;
use super::turns::cos_sin;
use crate::likelihood::{Isa, VisBlock};

/// Numbers in a cell: w d and the same times the w coordinate, complex.
pub(super) const CHANNELS: usize = 4;

/// 1.5 x 2^52: adding it rounds to a whole number, which the low bits then hold.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Samples that are prepared at a time.
const BATCH: usize = 64;

/// What is spread: samples rotated to a centre, or weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    centre: Centre,
    n_minus_1: f64,
    fine: Fine,
    uv_max: f64,
    levels: usize,
    per_w: f64,
}

impl Target {
    pub(super) fn new(plan: &FacetPlan, centre: &Centre) -> Target {
        Target {
            centre: *centre,
            n_minus_1: centre.lm.n_minus_1(),
            fine: plan.fine(),
            uv_max: plan.uv_max,
            levels: plan.levels,
            per_w: 1.0 / plan.needs.reach.w.max(f64::MIN_POSITIVE),
        }
    }
}

/// Adds `samples` with `data` (real and imaginary parts) in place of their own to `grid`, the fine
/// grids of all levels, each sample to the deepest level that reaches it.
///
/// # Panics
/// If a sample lies beyond the plan's reach or if the processor lacks `isa`.
pub(super) fn fill(
    isa: Isa,
    spread: &Spread,
    target: &Target,
    samples: &Sorted,
    data: [&[f32]; 2],
    grid: &mut [f32],
) {
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    match isa {
        Isa::Portable => fill_with::<Plain>(spread, target, samples, data, grid),
        // SAFETY: the instructions are there, it was just asserted.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { fill_avx2(spread, target, samples, data, grid) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { fill_avx512(spread, target, samples, data, grid) },
        #[cfg(not(target_arch = "x86_64"))]
        _ => fill_with::<Plain>(spread, target, samples, data, grid),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn fill_avx2(s: &Spread, t: &Target, samples: &Sorted, data: [&[f32]; 2], grid: &mut [f32]) {
    fill_with::<Avx2>(s, t, samples, data, grid);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn fill_avx512(s: &Spread, t: &Target, samples: &Sorted, data: [&[f32]; 2], grid: &mut [f32]) {
    fill_with::<Avx512>(s, t, samples, data, grid);
}

#[inline(always)]
fn fill_with<L: Lanes>(
    spread: &Spread,
    target: &Target,
    samples: &Sorted,
    data: [&[f32]; 2],
    grid: &mut [f32],
) {
    let mut batch = Batch::new();
    let mut patch = Patch::new();
    for (tile, range) in &samples.runs {
        let is_patch = range.len() >= PATCH_SAMPLES;
        if is_patch {
            patch.start(*tile);
        }
        for first in range.clone().step_by(BATCH) {
            let count = BATCH.min(range.end - first);
            batch.load(&samples.block, data, first, count);
            batch.prepare(target);
            for i in 0..count {
                let value = [batch.re[i], batch.im[i], batch.w_re[i], batch.w_im[i]];
                let at = [batch.at_u[i], batch.at_v[i]];
                let place = [batch.level[i], batch.row[i], batch.col[i]];
                match patch.index(place) {
                    Some(first) if is_patch => {
                        spread_sample::<L>(spread, at, value, &mut patch.cells[first..], PATCH);
                    }
                    _ => {
                        let first = target.index(place);
                        let cols = target.fine.cols;
                        spread_sample::<L>(spread, at, value, &mut grid[first..], cols);
                    }
                }
            }
        }
        if is_patch {
            patch.add_to(target, grid);
        }
    }
}

impl Target {
    /// Index in the grids of the first channel of the cell `row`, `col` of `level`.
    #[inline(always)]
    fn index(&self, [level, row, col]: [i32; 3]) -> usize {
        let row = level as usize * self.fine.rows + row as usize;
        (row * self.fine.cols + col as usize) * CHANNELS
    }
}

/// Room about a tile for the kernel and for what w does to u and v [cells].
const MARGIN: i32 = 8;

/// Side of a patch [cells]: 26 KB.
const PATCH: usize = (TILE + 2 * MARGIN) as usize;

/// Fewest samples that are worth a patch.
const PATCH_SAMPLES: usize = 24;

/// A tile and the cells about it, summed up on their own.
struct Patch {
    tile: Tile,
    cells: Vec<f32>,
}

impl Patch {
    fn new() -> Patch {
        Patch {
            tile: Tile {
                level: -1,
                row: 0,
                col: 0,
            },
            cells: vec![0.0; PATCH * PATCH * CHANNELS],
        }
    }

    fn start(&mut self, tile: Tile) {
        self.tile = tile;
        self.cells.fill(0.0);
    }

    /// Index of the first channel of a cell, if the eight by eight cells from there on are in.
    #[inline(always)]
    fn index(&self, [level, row, col]: [i32; 3]) -> Option<usize> {
        const LAST: u32 = (PATCH - WIDTH) as u32;
        let row = (row - self.tile.row + MARGIN) as u32;
        let col = (col - self.tile.col + MARGIN) as u32;
        (level == self.tile.level && row <= LAST && col <= LAST)
            .then_some((row as usize * PATCH + col as usize) * CHANNELS)
    }

    /// Adds the cells to the grids; those outside of them are empty.
    #[inline(always)]
    fn add_to(&self, target: &Target, grid: &mut [f32]) {
        let (rows, cols) = (target.fine.rows as i32, target.fine.cols as i32);
        let first_col = (self.tile.col - MARGIN).max(0);
        let end_col = (self.tile.col + TILE + MARGIN).min(cols);
        let count = (end_col - first_col) as usize * CHANNELS;
        let skipped = (first_col - (self.tile.col - MARGIN)) as usize * CHANNELS;
        for (i, cells) in self.cells.chunks_exact(PATCH * CHANNELS).enumerate() {
            let row = self.tile.row - MARGIN + i as i32;
            if !(0..rows).contains(&row) {
                continue;
            }
            let first = target.index([self.tile.level, row, first_col]);
            let sums = &mut grid[first..first + count];
            let cells = &cells[skipped..skipped + count];
            for k in 0..count {
                sums[k] += cells[k];
            }
        }
    }
}

/// Adds `value` to the 8 x 8 cells from the first one of `grid` on, rows `cols` cells apart.
/// The sample stands at `at`, in [-1/2, 1/2], from the middle of the cells.
#[inline(always)]
fn spread_sample<L: Lanes>(
    spread: &Spread,
    at: [f32; 2],
    value: [f32; CHANNELS],
    grid: &mut [f32],
    cols: usize,
) {
    let stride = cols * CHANNELS;
    let kernel = kernel::<L>(spread, at);
    let mut values = [0.0; LANES];
    for (i, v) in values.iter_mut().enumerate() {
        *v = value[i % CHANNELS];
    }
    let values = L::load(&values, 0);
    // Four cells of four channels are sixteen numbers; eight cells are two such groups.
    let mut along_u = [[values; 2]; 2];
    for (half, group) in along_u.iter_mut().enumerate() {
        for (part, vector) in group[..L::PARTS].iter_mut().enumerate() {
            *vector = L::repeat(&kernel, half * L::PARTS + part).mul(values);
        }
    }
    for row in 0..WIDTH {
        let factor = L::splat(kernel[WIDTH + row]);
        let (cells, _) = grid[row * stride..][..WIDTH * CHANNELS].as_chunks_mut::<LANES>();
        for (cells, along_u) in cells.iter_mut().zip(&along_u) {
            for (part, &vector) in along_u[..L::PARTS].iter().enumerate() {
                let sum = factor.mul_add(vector, L::load(cells, part));
                sum.store(cells, part);
            }
        }
    }
}

/// The kernel at the eight cells along u and the eight along v.
#[inline(always)]
fn kernel<L: Lanes>(spread: &Spread, at: [f32; 2]) -> [f32; LANES] {
    let mut x = [at[0]; LANES];
    x[WIDTH..].fill(at[1]);
    let mut kernel = [0.0; LANES];
    for part in 0..L::PARTS {
        let x = L::load(&x, part);
        let mut sum = L::splat(0.0);
        for k in (0..spread.polynomials.len()).rev() {
            sum = sum.mul_add(x, L::load(&spread.polynomials[k], part));
        }
        sum.store(&mut kernel, part);
    }
    kernel
}

/// Samples on their way to the grid.
struct Batch {
    u: [f64; BATCH],
    v: [f64; BATCH],
    w: [f64; BATCH],
    re: [f32; BATCH],
    im: [f32; BATCH],
    w_re: [f32; BATCH],
    w_im: [f32; BATCH],
    /// Place from the middle of the eight cells [cells].
    at_u: [f32; BATCH],
    at_v: [f32; BATCH],
    /// First cell, from the first ones of the grid.
    level: [i32; BATCH],
    row: [i32; BATCH],
    col: [i32; BATCH],
}

impl Batch {
    fn new() -> Batch {
        Batch {
            u: [0.0; BATCH],
            v: [0.0; BATCH],
            w: [0.0; BATCH],
            re: [0.0; BATCH],
            im: [0.0; BATCH],
            w_re: [0.0; BATCH],
            w_im: [0.0; BATCH],
            at_u: [0.0; BATCH],
            at_v: [0.0; BATCH],
            level: [0; BATCH],
            row: [0; BATCH],
            col: [0; BATCH],
        }
    }

    /// Sets the `count` samples from `first` on; what is left over keeps valid coordinates.
    #[inline(always)]
    fn load(&mut self, block: &VisBlock, [re, im]: [&[f32]; 2], first: usize, count: usize) {
        let range = first..first + count;
        self.u[..count].copy_from_slice(&block.u[range.clone()]);
        self.v[..count].copy_from_slice(&block.v[range.clone()]);
        self.w[..count].copy_from_slice(&block.w[range.clone()]);
        self.re[..count].copy_from_slice(&re[range.clone()]);
        self.im[..count].copy_from_slice(&im[range]);
    }

    /// Rotates the samples to the centre, folds them over to v >= 0, finds level and cells.
    #[inline(always)]
    fn prepare(&mut self, target: &Target) {
        let Centre {
            lm,
            slope_u,
            slope_v,
        } = target.centre;
        for i in 0..BATCH {
            let (u, v, w) = (self.u[i], self.v[i], self.w[i]);
            let turns = u * lm.l + v * lm.m + w * target.n_minus_1;
            let [cos, sin] = cos_sin(turns);
            let (u, v) = (u - w * slope_u, v - w * slope_v);
            let sign = 1f64.copysign(v);
            let (re, im) = (self.re[i], self.im[i]);
            let turned_re = re * cos + im * sin;
            let turned_im = sign as f32 * (im * cos - re * sin);
            let w = (sign * w * target.per_w) as f32;
            (self.re[i], self.im[i]) = (turned_re, turned_im);
            (self.w_re[i], self.w_im[i]) = (w * turned_re, w * turned_im);
            (self.u[i], self.v[i]) = (sign * u, sign * v);
        }
        for i in 0..BATCH {
            self.place(target, i);
        }
    }

    #[inline(always)]
    fn place(&mut self, target: &Target, i: usize) {
        let fine = target.fine;
        let (u, v) = (self.u[i], self.v[i]);
        let ratio = target.uv_max * target.uv_max / (u * u + v * v);
        let level = level_of_ratio(ratio, target.levels as i32);
        let scale = f64::from_bits(((level + 1023) as u64) << 52) * fine.cells_per_wavelength;
        let middle = 0.5 * (WIDTH as f64 - 1.0);
        let (u, v) = (u * scale - middle, v * scale - middle);
        let (col, row) = (u + ROUND, v + ROUND);
        self.at_u[i] = (u - (col - ROUND)) as f32;
        self.at_v[i] = (v - (row - ROUND)) as f32;
        let (col, row) = (col.to_bits() as i32, row.to_bits() as i32);
        self.level[i] = level;
        self.row[i] = row - fine.first_row as i32;
        self.col[i] = col - fine.first_col as i32;
    }
}
