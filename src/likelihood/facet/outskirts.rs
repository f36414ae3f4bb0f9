//! How far out in uv a source must be summed: beyond, its visibilities are too faint to matter.
//!
//! Long baselines resolve most galaxies, and most cells of a facet are those of long baselines.

use super::cells::{Common, LANES};
use super::plan::{FacetPlan, GUARD};
use super::term::FacetTerm;
use crate::rime::shape::Profile;

/// Part ε of Y that may be left out. The noise of what is left out changes ln L by SNR sqrt(ε) (rms),
/// at most a fourteenth of 1e-4 SNR²/2 + 0.01.
const LEFT_OUT: f64 = 1e-8;
/// Bins per octave of baseline length.
const PER_OCTAVE: f64 = 4.0;
/// Bins: 10 octaves below the longest baseline.
const N_BIN: usize = 40;
/// Nothing is left out where F is larger: what interpolates the samples further in reaches as far.
const LARGEST_FACTOR: f64 = 3e-3;
/// Limits of Q are powers of this.
const STEP: f64 = 1.3;

/// Weight [Jy⁻²] by baseline length, in logarithmic bins from the longest baseline down.
#[derive(Debug)]
pub(super) struct Outskirts {
    weight: [f64; N_BIN],
    /// Square of the longest baseline in each bin [wavelength²], and of how far out the cells reach that
    /// interpolate there.
    uv2: [f64; N_BIN],
    reach2: [f64; N_BIN],
}

impl Outskirts {
    pub(super) fn new(plan: &FacetPlan, levels: &[Vec<Common>]) -> Outskirts {
        let mut weight = [0.0; N_BIN];
        let half = plan.columns() as f64 / 2.0;
        let packs_per_row = plan.columns() / LANES;
        for (level, packs) in levels.iter().enumerate() {
            let is_last = level + 1 == levels.len();
            for (i, pack) in packs.iter().enumerate() {
                let (row, first) = (i / packs_per_row, i % packs_per_row * LANES);
                let window = if is_last { &pack.low } else { &pack.band };
                for (k, (w, window)) in pack.weight.iter().zip(window).enumerate() {
                    let uv = plan.cell(level) * ((first + k) as f64 - half).hypot(row as f64);
                    let octaves = (plan.uv_max / uv.max(f64::MIN_POSITIVE)).log2();
                    let bin = (octaves * PER_OCTAVE).clamp(0.0, (N_BIN - 1) as f64) as usize;
                    weight[bin] += f64::from(w * window);
                }
            }
        }
        let longest = |bin: usize| plan.uv_max * (-(bin as f64) / PER_OCTAVE).exp2();
        let reach = |uv: f64| uv + GUARD as f64 * plan.cell(plan.level_of(uv, 0.0));
        Outskirts {
            // Between the samples the grids go below zero.
            weight: weight.map(|w| w.max(0.0)),
            uv2: std::array::from_fn(|bin| longest(bin).powi(2)),
            reach2: std::array::from_fn(|bin| reach(longest(bin)).powi(2)),
        }
    }

    /// The smallest Q beyond which what is left of Y is negligible.
    pub(super) fn q_max(&self, term: &FacetTerm) -> f64 {
        let factor_squared = |q: f64| match term.profile {
            Profile::Exponential => (1.0 + q).powi(-3),
            Profile::Gaussian => (-2.0 * q).exp2(),
            Profile::Point => 1.0,
        };
        let [short, long] = term.axes_squared();
        let bins = || self.weight.iter().zip(&self.uv2).zip(&self.reach2);
        // Of F² in a bin: less than on the long axis at its outer, more than on the short one at its
        // inner edge.
        let y: f64 = bins()
            .map(|((w, uv2), _)| w * factor_squared(long * uv2))
            .sum();
        let inner = (-2.0 / PER_OCTAVE).exp2();
        let left_out = |q: f64| -> f64 {
            bins()
                .take_while(|(_, reach2)| long * **reach2 > q)
                .map(|((w, uv2), _)| w * factor_squared(q.max(short * uv2 * inner)))
                .sum()
        };
        let mut q = term.q_max;
        let is_faint = |q: f64| factor_squared(q) < LARGEST_FACTOR * LARGEST_FACTOR;
        while is_faint(q / STEP) && left_out(q / STEP) < LEFT_OUT * y {
            q /= STEP;
        }
        q
    }
}
