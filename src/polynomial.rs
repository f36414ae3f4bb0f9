//! Polynomials through functions.

use std::f64::consts::PI;

/// Monomial coefficients of the polynomial through `f` at the Chebyshev nodes of [-1/2, 1/2].
pub(crate) fn fit<const TERMS: usize>(f: impl Fn(f64) -> f64) -> [f64; TERMS] {
    let nodes: [f64; TERMS] =
        std::array::from_fn(|i| 0.5 * (PI * (i as f64 + 0.5) / TERMS as f64).cos());
    // Newton's divided differences, then expanded.
    let mut differences = nodes.map(&f);
    for order in 1..TERMS {
        for i in (order..TERMS).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (nodes[i] - nodes[i - order]);
        }
    }
    let mut sum = [0.0; TERMS];
    for i in (0..TERMS).rev() {
        // sum = sum (x - node) + difference
        for k in (0..TERMS).rev() {
            let lower = if k > 0 { sum[k - 1] } else { differences[i] };
            sum[k] = lower - nodes[i] * sum[k];
        }
    }
    sum
}
