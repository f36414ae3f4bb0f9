//! ln L of source models given the visibilities, relative to no source (method: X and Y).
//!
//! ```text
//! ln L - ln L0 = S X - S² Y / 2
//! X = Σ w F Re[d exp(-2πi φ)]      Y = Σ w F²
//! ```
//!
//! Where terms of the instrument are asked for ([`Extents`]), F is F times their factor s.

mod block;
mod cross;
mod exact;
mod extents;
pub mod facet;
pub mod kernel;
mod plain;
#[cfg(test)]
mod samples;
mod subtract;

pub use block::VisBlock;
pub use cross::{accumulate_pairs, joint_log_l, pairs, plain_cross, xy_without_others};
pub use exact::{accumulate_blocks, xy_batch};
pub use extents::Extents;
pub use kernel::{Isa, PairTerm, SourceTerm};
pub use plain::plain_xy;
pub use subtract::subtract;

/// The two sums that a model's likelihood is made of, for unit flux density.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Xy {
    /// X = Σ w F Re[d exp(-2πi φ)] [Jy⁻¹].
    pub x: f64,
    /// Y = Σ w F² [Jy⁻²].
    pub y: f64,
}

impl Xy {
    /// ln L - ln L0 at flux density `flux_jy`.
    pub fn log_l(self, flux_jy: f64) -> f64 {
        flux_jy * (self.x - 0.5 * flux_jy * self.y)
    }

    /// Signal-to-noise ratio S sqrt(Y) of a model of flux density `flux_jy`.
    pub fn snr(self, flux_jy: f64) -> f64 {
        flux_jy * self.y.sqrt()
    }

    /// Matched-filter signal-to-noise ratio X / sqrt(Y) at the best flux density.
    pub fn snr_peak(self) -> f64 {
        if self.y > 0.0 {
            self.x / self.y.sqrt()
        } else {
            0.0
        }
    }
}
