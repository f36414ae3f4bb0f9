//! One source of the sky model.

use super::shape::Ellipticity;
use crate::coords::Lm;

/// A source: position, total flux density and shape.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Source {
    /// Position about the phase centre.
    pub lm: Lm,
    /// Total flux density [Jy].
    pub flux_jy: f64,
    /// Scale-length α [rad]: the harmonic mean of those of the two axes.
    pub scale_rad: f64,
    /// Ellipticity.
    pub e: Ellipticity,
}
