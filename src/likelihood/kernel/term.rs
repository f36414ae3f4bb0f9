//! What a kernel needs to know of a source.

use crate::rime::Source;
use crate::rime::shape::{Profile, QuadraticForm};
use std::f64::consts::{LOG2_E, PI};

/// A source of unit flux density, ready for the kernels.
///
/// The shape enters as Q = (p u + r v)² + s v², scaled so that the exponential is (1 + Q)^(-3/2)
/// and the Gaussian 2^(-Q).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourceTerm {
    /// Direction cosine towards east.
    pub(super) l: f64,
    /// Direction cosine towards north.
    pub(super) m: f64,
    /// n - 1.
    pub(super) n_minus_1: f64,
    /// Coefficient p [wavelength⁻¹].
    pub(super) p: f32,
    /// Coefficient r [wavelength⁻¹].
    pub(super) r: f32,
    /// Coefficient s [wavelength⁻²].
    pub(super) s: f32,
    /// Which function of Q.
    pub(super) profile: Profile,
}

impl SourceTerm {
    /// The term of `source`; its flux density is left out.
    pub fn new(source: &Source, profile: Profile) -> SourceTerm {
        let scale = match profile {
            Profile::Exponential => 4.0 * PI * PI,
            Profile::Gaussian => 2.0 * PI * PI * LOG2_E,
            Profile::Point => 0.0,
        };
        let (p, r, s) = if scale > 0.0 {
            QuadraticForm::new(source.scale_rad, source.e).as_squares(scale)
        } else {
            (0.0, 0.0, 0.0)
        };
        SourceTerm {
            l: source.lm.l,
            m: source.lm.m,
            n_minus_1: source.lm.n_minus_1(),
            p: p as f32,
            r: r as f32,
            s: s as f32,
            profile,
        }
    }
}
