//! Spreading samples over the grids of a facet, on one core.
#![allow(clippy::inline_always)] // plain loops must be compiled anew for each instruction set
#![allow(unsafe_code)] // entering code compiled for an instruction set

use super::plan::{FacetPlan, Fine, level_of_ratio};
use super::spread::{Spread, WIDTH};
use super::term::Centre;
use super::turns::cos_sin;
use crate::likelihood::{Isa, VisBlock};

/// Numbers in a cell: w d and the same times the w coordinate, complex.
pub(super) const CHANNELS: usize = 4;

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

/// Adds the samples of `block` with the data `re`, `im` in place of its own to `grid`, the fine
/// grids of all levels, each sample to the deepest level that reaches it.
///
/// # Panics
/// If a sample lies beyond the plan's reach or if the processor lacks `isa`.
pub(super) fn fill(
    isa: Isa,
    spread: &Spread,
    target: &Target,
    block: &VisBlock,
    [re, im]: [&[f32]; 2],
    grid: &mut [f32],
) {
    assert!(
        isa.is_available(),
        "{isa:?} is not available on this processor"
    );
    match isa {
        Isa::Portable => fill_with::<false>(spread, target, block, [re, im], grid),
        // SAFETY: the instructions are there, it was just asserted.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { fill_avx2(spread, target, block, [re, im], grid) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { fill_avx512(spread, target, block, [re, im], grid) },
        #[cfg(not(target_arch = "x86_64"))]
        _ => fill_with::<false>(spread, target, block, [re, im], grid),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn fill_avx2(s: &Spread, t: &Target, block: &VisBlock, data: [&[f32]; 2], grid: &mut [f32]) {
    fill_with::<true>(s, t, block, data, grid);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn fill_avx512(s: &Spread, t: &Target, block: &VisBlock, data: [&[f32]; 2], grid: &mut [f32]) {
    fill_with::<true>(s, t, block, data, grid);
}

#[inline(always)]
fn fill_with<const FMA: bool>(
    spread: &Spread,
    target: &Target,
    block: &VisBlock,
    [re, im]: [&[f32]; 2],
    grid: &mut [f32],
) {
    let mut batch = Batch::new();
    let stride = target.fine.cols * CHANNELS;
    for first in (0..block.len()).step_by(BATCH) {
        let count = BATCH.min(block.len() - first);
        batch.load(block, [re, im], first, count);
        batch.prepare(target);
        for i in 0..count {
            let at = [batch.at_u[i], batch.at_v[i]];
            let value = [batch.re[i], batch.im[i], batch.w_re[i], batch.w_im[i]];
            let start = batch.start[i] as usize * CHANNELS;
            spread_sample::<FMA>(spread, at, value, &mut grid[start..], stride);
        }
    }
}

/// Adds `value` to the 8 x 8 cells from the first one of `grid` on, rows `stride` numbers apart.
/// The sample stands at `at`, in [-1/2, 1/2], from the middle of the cells.
#[inline(always)]
fn spread_sample<const FMA: bool>(
    spread: &Spread,
    at: [f32; 2],
    value: [f32; CHANNELS],
    grid: &mut [f32],
    stride: usize,
) {
    let mut x = [at[0]; 2 * WIDTH];
    x[WIDTH..].fill(at[1]);
    let mut kernel = [0.0; 2 * WIDTH];
    for row in spread.polynomials.iter().rev() {
        for i in 0..2 * WIDTH {
            kernel[i] = mul_add::<FMA>(kernel[i], x[i], row[i]);
        }
    }
    let mut along_u = [0.0; WIDTH * CHANNELS];
    for i in 0..WIDTH * CHANNELS {
        along_u[i] = kernel[i / CHANNELS] * value[i % CHANNELS];
    }
    for (row, &factor) in kernel[WIDTH..].iter().enumerate() {
        let cells = &mut grid[row * stride..][..WIDTH * CHANNELS];
        for i in 0..WIDTH * CHANNELS {
            cells[i] = mul_add::<FMA>(factor, along_u[i], cells[i]);
        }
    }
}

/// a b + c, in one step where the processor has one.
#[inline(always)]
fn mul_add<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
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
    /// First cell.
    start: [i32; BATCH],
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
            start: [0; BATCH],
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
        let (col, row) = (u.round_ties_even(), v.round_ties_even());
        (self.at_u[i], self.at_v[i]) = ((u - col) as f32, (v - row) as f32);
        let row = level * fine.rows as i32 + row as i32 - fine.first_row as i32;
        self.start[i] = row * fine.cols as i32 + col as i32 - fine.first_col as i32;
    }
}
