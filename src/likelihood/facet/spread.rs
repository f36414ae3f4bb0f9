//! The kernel that spreads a sample over the cells about it: exponential of semicircle.
//!
//! ```text
//! φ(t) = exp(β (sqrt(1 - (2t/W)²) - 1))      |t| <= W/2, t in cells
//! ```
//!
//! # Source
//! Barnett, Magland & af Klinteberg (2019), SIAM J. Sci. Comput. 41, C479, eq. 1.8; β by their
//! eq. 4.5 with the safety factor of FINUFFT.

use crate::polynomial::fit;
use std::f64::consts::PI;

/// Cells across the kernel, W.
pub(super) const WIDTH: usize = 8;

/// Coefficients of the polynomial of each of the W pieces.
const TERMS: usize = 12;

/// Nodes of the quadrature for the transform.
const NODES: usize = 512;

/// The kernel, ready for both sides: polynomials for the samples, transform for the image.
#[derive(Debug, Clone)]
pub(super) struct Spread {
    beta: f64,
    /// Coefficient `k` of the cells: those of u in lanes 0 to 7, those of v in 8 to 15.
    pub(super) polynomials: [[f32; 2 * WIDTH]; TERMS],
}

impl Spread {
    /// The kernel for images that are read out to `reach`, a fraction of the grid's period
    /// (half the inverse oversampling).
    pub(super) fn new(reach: f64) -> Spread {
        let beta = 0.97 * PI * WIDTH as f64 * (1.0 - reach);
        let mut polynomials = [[0.0; 2 * WIDTH]; TERMS];
        for cell in 0..WIDTH {
            // The sample stands at x in [-1/2, 1/2] from the middle of the cells.
            let distance = cell as f64 - 0.5 * (WIDTH as f64 - 1.0);
            let fitted = fit::<TERMS>(|x| value(beta, distance - x));
            for (row, c) in polynomials.iter_mut().zip(fitted) {
                row[cell] = c as f32;
                row[cell + WIDTH] = c as f32;
            }
        }
        Spread { beta, polynomials }
    }

    /// ∫ φ(t) cos(2π x t) dt at the place `x` of the image, a fraction of the grid's period.
    pub(super) fn transform(&self, x: f64) -> f64 {
        // Mid-point rule in the angle t = sin(a) W/2, which takes away the kernel's steep ends.
        let step = PI / NODES as f64;
        let half = 0.5 * WIDTH as f64;
        let term = |i: usize| {
            let (sin, cos) = ((i as f64 + 0.5) * step - 0.5 * PI).sin_cos();
            (self.beta * (cos - 1.0)).exp() * (2.0 * PI * x * half * sin).cos() * cos
        };
        half * step * (0..NODES).map(term).sum::<f64>()
    }
}

/// φ at `t` cells from the sample.
fn value(beta: f64, t: f64) -> f64 {
    let z = 2.0 * t / WIDTH as f64;
    let inside = 1.0 - z * z;
    if inside > 0.0 {
        (beta * (inside.sqrt() - 1.0)).exp()
    } else {
        (-beta).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polynomial(spread: &Spread, cell: usize, x: f64) -> f64 {
        let terms = spread.polynomials.iter().rev();
        terms.fold(0.0, |sum, row| sum * x + row[cell] as f64)
    }

    #[test]
    fn polynomials_follow_the_kernel() {
        let spread = Spread::new(0.336);
        for cell in 0..WIDTH {
            for i in 0..=100 {
                let x = i as f64 / 100.0 - 0.5;
                let expected = value(spread.beta, cell as f64 - 3.5 - x);
                let error = polynomial(&spread, cell, x) - expected;
                assert!(error.abs() < 3e-7, "{cell} {x}: {error:e}");
                assert_eq!(
                    spread.polynomials[3][cell],
                    spread.polynomials[3][cell + WIDTH]
                );
            }
        }
    }

    /// What the kernel is for: a wave on the cells, weighted, is the wave at the sample.
    #[test]
    fn cells_make_up_the_wave_at_the_sample() {
        let spread = Spread::new(0.336);
        for x in [0.0, 0.1, -0.25, 0.336] {
            let expected = spread.transform(x);
            for i in 0..10 {
                let at = i as f64 / 10.0 - 0.5;
                let (mut re, mut im) = (0.0, 0.0);
                for cell in 0..WIDTH {
                    let turns = x * (cell as f64 - 3.5 - at);
                    let k = polynomial(&spread, cell, at);
                    re += k * (2.0 * PI * turns).cos();
                    im += k * (2.0 * PI * turns).sin();
                }
                let error = (re / expected - 1.0).hypot(im / expected);
                assert!(error < 2e-5, "{x} {at}: {error:e}");
            }
        }
    }
}
