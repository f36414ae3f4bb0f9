//! The grids as the kernels read them: sixteen cells side by side.

use super::plan::FacetPlan;
use super::resample::HalfPlane;

/// Cells in a pack: what one vector of f32 holds at most.
pub(super) const LANES: usize = 16;

/// Sixteen neighbours along u of one facet.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Pack {
    /// Σ w d, rotated to the facet's centre [Jy⁻¹].
    pub(super) re: [f32; LANES],
    pub(super) im: [f32; LANES],
    /// The same times the w coordinate in units of the plan's largest.
    pub(super) w_re: [f32; LANES],
    pub(super) w_im: [f32; LANES],
}

/// Sixteen neighbours along u, what they have in common for all facets.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Common {
    /// Σ w [Jy⁻²].
    pub(super) weight: [f32; LANES],
    /// The same times the w coordinate in units of the plan's largest.
    pub(super) weight_w: [f32; LANES],
    /// Window where this level is the last one.
    pub(super) low: [f32; LANES],
    /// Window where the next level takes the middle.
    pub(super) band: [f32; LANES],
}

/// The packs of `grid` and of the same times w.
pub(super) fn packs(plan: &FacetPlan, grid: &HalfPlane, times_w: &HalfPlane) -> Vec<Pack> {
    let columns = plan.columns();
    let skipped = grid.n as i64 / 2 - columns as i64 / 2;
    let at = |grid: &HalfPlane, row: usize, col: usize| {
        let col = col as i64 + skipped;
        if (0..grid.n as i64).contains(&col) && row < grid.rows() {
            grid.cells[row * grid.n + col as usize]
        } else {
            num_complex::Complex::default()
        }
    };
    let pack = |i: usize| {
        let (row, first) = (i / (columns / LANES), i % (columns / LANES) * LANES);
        Pack {
            re: std::array::from_fn(|k| at(grid, row, first + k).re as f32),
            im: std::array::from_fn(|k| at(grid, row, first + k).im as f32),
            w_re: std::array::from_fn(|k| at(times_w, row, first + k).re as f32),
            w_im: std::array::from_fn(|k| at(times_w, row, first + k).im as f32),
        }
    };
    (0..plan.rows() * columns / LANES).map(pack).collect()
}

/// What the facets have in common at `level`, from the grid of weights and of the same times w.
pub(super) fn common(
    plan: &FacetPlan,
    level: usize,
    weights: &HalfPlane,
    times_w: &HalfPlane,
) -> Vec<Common> {
    let (cell, half) = (plan.cell(level), plan.columns() as f64 / 2.0);
    let windows = |row: usize, col: usize| {
        let uv = cell * (col as f64 - half).hypot(row as f64);
        let low = plan.low_pass(level, uv);
        (low as f32, (low - plan.low_pass(level + 1, uv)) as f32)
    };
    let packs_per_row = plan.columns() / LANES;
    packs(plan, weights, times_w)
        .iter()
        .enumerate()
        .map(|(i, pack)| {
            let (row, first) = (i / packs_per_row, i % packs_per_row * LANES);
            let windows: [_; LANES] = std::array::from_fn(|k| windows(row, first + k));
            Common {
                weight: pack.re,
                weight_w: pack.w_re,
                low: windows.map(|w| w.0),
                band: windows.map(|w| w.1),
            }
        })
        .collect()
}
