//! From one regular grid of the uv-plane to another, through the image plane.
//!
//! ```text
//! image(x) = Σ g(c) exp(-2πi c x)      g'(c') = 1/n' Σ window(x) image(x) exp(+2πi c' x)
//! ```
//!
//! Along one axis at a time. The image is cut to the period of the new grid by a smooth window;
//! where the window falls, on either side of half the new period, the image folds over onto
//! itself, out of what a facet reads.

use num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// The part of the period, on either side of the centre, that the new grid holds truly.
pub(super) const CLEAR: f64 = 0.42;

/// Steepness of the window's edges: erfc of this is what they leave undone, 1e-5.
const EDGE: f64 = 3.0;

/// Share of the image at `x`, a fraction of the new period, that is kept: 1 up to [`CLEAR`],
/// 0 from 1 - [`CLEAR`] on.
pub(super) fn window(x: f64) -> f64 {
    let edge = (x.abs() - 0.5) / (0.5 - CLEAR);
    0.5 * puruspe::erfc(EDGE * edge.clamp(-1.5, 1.5))
}

/// Resampling of an axis of `n_in` cells to one of `n_out`. Cells are counted from the middle:
/// cell c stands at index c + n/2.
pub(super) struct Resampler {
    n_in: usize,
    n_out: usize,
    to_image: Arc<dyn Fft<f64>>,
    to_grid: Arc<dyn Fft<f64>>,
    /// Window over the transform's length, in the order of the transform.
    window: Vec<f64>,
}

impl std::fmt::Debug for Resampler {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Resampler({} -> {})", self.n_in, self.n_out)
    }
}

/// Room to work in, one for each thread.
#[derive(Default)]
pub(super) struct Scratch {
    image: Vec<Complex<f64>>,
    fft: Vec<Complex<f64>>,
}

impl Resampler {
    /// `window` is a function of x as a fraction of the new period.
    pub(super) fn new(n_in: usize, n_out: usize, window: impl Fn(f64) -> f64) -> Resampler {
        assert!(
            n_out <= n_in && n_in <= 2 * n_out,
            "{n_in} to {n_out} cells"
        );
        let mut planner = FftPlanner::new();
        let half = n_in as i64 / 2;
        let window = (0..n_in as i64)
            .map(|i| if i < half { i } else { i - n_in as i64 })
            .map(|i| window(i as f64 / n_out as f64) / n_out as f64)
            .collect();
        Resampler {
            n_in,
            n_out,
            to_image: planner.plan_fft_forward(n_in),
            to_grid: planner.plan_fft_inverse(n_out),
            window,
        }
    }

    pub(super) fn n_out(&self) -> usize {
        self.n_out
    }

    /// Resamples the cells `first`, `first` + 1, ... of `cells`, all others being zero, into `out`.
    pub(super) fn run(
        &self,
        cells: impl Iterator<Item = Complex<f64>>,
        first: i64,
        out: &mut [Complex<f64>],
        scratch: &mut Scratch,
    ) {
        let Scratch { image, fft } = scratch;
        image.clear();
        image.resize(self.n_in, Complex::default());
        let (before, after) = image.split_at_mut(first.rem_euclid(self.n_in as i64) as usize);
        for (place, cell) in after.iter_mut().chain(before).zip(cells) {
            *place = cell;
        }
        let room = self
            .to_image
            .get_inplace_scratch_len()
            .max(self.to_grid.get_inplace_scratch_len());
        fft.resize(room, Complex::default());
        self.to_image.process_with_scratch(image, fft);
        self.fold(image);
        self.to_grid
            .process_with_scratch(&mut image[..self.n_out], fft);
        let half = self.n_out / 2;
        out[half..].copy_from_slice(&image[..half]);
        out[..half].copy_from_slice(&image[half..self.n_out]);
    }

    /// Cuts the image to the new period: its first `n_out` values, in the order of the transform,
    /// places before the middle at the end.
    fn fold(&self, image: &mut [Complex<f64>]) {
        for (value, window) in image.iter_mut().zip(&self.window) {
            *value *= window;
        }
        if self.n_in == self.n_out {
            return;
        }
        let half = self.n_in / 2;
        let (kept, before) = image.split_at_mut(self.n_out.max(half));
        // What lies before the middle starts at `half`; part of it may stand in `kept`.
        let inside: Vec<_> = kept[half..].to_vec();
        kept[half..].fill(Complex::default());
        let first = self.n_out - (self.n_in - half);
        let sums = kept[first..].iter_mut();
        for (sum, value) in sums.zip(inside.iter().chain(before.iter())) {
            *sum += value;
        }
    }
}

/// What is summed against a grid, at (-u, -v).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mirror {
    /// The conjugate of that at (u, v), as a visibility is.
    Even,
    /// The same negated, as a visibility over w is: w changes its sign.
    Odd,
}

impl Mirror {
    fn of(self, cell: Complex<f64>) -> Complex<f64> {
        match self {
            Self::Even => cell.conj(),
            Self::Odd => -cell.conj(),
        }
    }
}

/// A grid over half of the uv-plane, v >= 0, `rows` by `n`; u = 0 stands in column n/2.
///
/// The other half is its mirror image and already added; only the real part of what is summed
/// against it counts.
#[derive(Debug, Clone)]
pub(super) struct HalfPlane {
    pub(super) mirror: Mirror,
    pub(super) n: usize,
    pub(super) cells: Vec<Complex<f64>>,
}

impl HalfPlane {
    pub(super) fn rows(&self) -> usize {
        self.cells.len() / self.n
    }

    /// Resamples both axes of `rows` rows of `n` cells from `cell`: row `first_row` is the first
    /// one, column c of it is the cell c + `first_col`. Rows below v = 0 are folded over.
    pub(super) fn resampled(
        resampler: &Resampler,
        mirror: Mirror,
        [rows, cols]: [usize; 2],
        [first_row, first_col]: [i64; 2],
        cell: impl Fn(usize, usize) -> Complex<f64>,
    ) -> HalfPlane {
        let n = resampler.n_out();
        let mut scratch = Scratch::default();
        let mut along_u = vec![Complex::default(); rows * n];
        for (row, out) in along_u.chunks_exact_mut(n).enumerate() {
            resampler.run(
                (0..cols).map(|c| cell(row, c)),
                first_col,
                out,
                &mut scratch,
            );
        }
        let half = n / 2;
        let mut cells = vec![Complex::default(); half * n];
        let mut column = vec![Complex::default(); n];
        for col in 0..n {
            let along = (0..rows).map(|row| along_u[row * n + col]);
            resampler.run(along, first_row, &mut column, &mut scratch);
            for row in 0..half {
                cells[row * n + col] += column[half + row];
            }
            // The cell at -n/2 has no mirror image; the grid is empty there.
            let mirrored = (n - col) % n;
            for row in 1..half {
                cells[row * n + mirrored] += mirror.of(column[half - row]);
            }
        }
        HalfPlane { mirror, n, cells }
    }

    /// This grid on cells twice as wide: for the part of the sky in the middle.
    pub(super) fn coarsened(&self, resampler: &Resampler) -> HalfPlane {
        let first = -(self.n as i64 / 2);
        let size = [self.rows(), self.n];
        Self::resampled(resampler, self.mirror, size, [0, first], |row, col| {
            self.cells[row * self.n + col]
        })
    }

    /// Adds `other`, of the same size.
    pub(super) fn add(&mut self, other: &HalfPlane) {
        for (sum, cell) in self.cells.iter_mut().zip(&other.cells) {
            *sum += cell;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Cells of an image of two points, one of them where the image folds over: the same points
    /// on cells of the new size, as far as they lie where the grid is true.
    #[test]
    fn a_point_is_a_wave_on_the_new_cells() {
        for n_in in [40, 50, 80] {
            let n_out = 40;
            let resampler = Resampler::new(n_in, n_out, window);
            let wave = |x: f64, n: usize| {
                let phase = move |c: i64| TAU * x * c as f64 / n as f64;
                let half = n as i64 / 2;
                (-half..half).map(move |c| Complex::from_polar(1.0, phase(c)))
            };
            for x in [0.0, 7.0, -13.0] {
                let mut out = vec![Complex::default(); n_out];
                let first = -(n_in as i64 / 2);
                resampler.run(wave(x, n_in), first, &mut out, &mut Scratch::default());
                let scale = n_in as f64 / n_out as f64;
                for (got, expected) in out.iter().zip(wave(x, n_out)) {
                    assert!((got / scale - expected).norm() < 2e-5, "{n_in} {x}");
                }
            }
        }
    }

    #[test]
    fn the_window_is_one_where_the_grid_is_true_and_its_halves_add_up() {
        assert!((window(CLEAR) - 1.0).abs() < 2e-5 && window(1.0 - CLEAR) < 2e-5);
        for i in 0..100 {
            let x = f64::from(i) / 100.0;
            assert!((window(x) + window(x - 1.0) - 1.0).abs() < 1e-12);
        }
    }
}
