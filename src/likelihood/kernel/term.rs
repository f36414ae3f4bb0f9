//! What a kernel needs to know of a source.

use crate::coords::Lm;
use crate::rime::shape::{Profile, QuadraticForm};
use crate::rime::{Ray, Source};
use std::f64::consts::{LOG2_E, PI};

/// A source of unit flux density, ready for the kernels.
///
/// The shape enters as Q = (p u' + r v')² + s v'² of the baseline (u', v') that the source sees, scaled
/// so that the exponential is (1 + Q)^(-3/2) and the Gaussian 2^(-Q). With w written out it is
/// Q = (along_u u + along_v v + along_w w)² + (across_v v + across_w w)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourceTerm {
    /// Direction cosine towards east.
    pub(super) l: f64,
    /// Direction cosine towards north.
    pub(super) m: f64,
    /// n - 1.
    pub(super) n_minus_1: f64,
    /// Coefficients of u, v and w in the first square [wavelength⁻¹].
    pub(super) along: [f32; 3],
    /// Coefficients of v and w in the second square [wavelength⁻¹].
    pub(super) across: [f32; 2],
    /// Which function of Q.
    pub(super) profile: Profile,
    /// As in [`Source`].
    pub(super) tilt: f64,
}

impl SourceTerm {
    /// What the instrument makes its factors of.
    pub(super) fn ray(&self) -> Ray {
        Ray {
            lm: Lm {
                l: self.l,
                m: self.m,
            },
            tilt: self.tilt,
        }
    }

    /// Q at (u, v, w).
    #[inline(always)]
    pub(super) fn q(&self, u: f32, v: f32, w: f32) -> f32 {
        let ([p, r, t], [s, z]) = (self.along, self.across);
        let (along, across) = (p * u + r * v + t * w, s * v + z * w);
        along * along + across * across
    }

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
        let ([slope_u, slope_v], s) = (source.lm.slopes(), s.sqrt());
        SourceTerm {
            l: source.lm.l,
            m: source.lm.m,
            n_minus_1: source.lm.n_minus_1(),
            along: [p, r, -(p * slope_u + r * slope_v)].map(|x| x as f32),
            across: [s, -s * slope_v].map(|x| x as f32),
            profile,
            tilt: source.tilt,
        }
    }
}
