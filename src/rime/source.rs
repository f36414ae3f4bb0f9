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
    /// Spectral index less that of the [`Spectrum`](super::Spectrum) that all sources are seen with: 0
    /// unless indices are free. In catalogues, which have no such spectrum, the index itself.
    pub tilt: f64,
}

impl Source {
    /// What the instrument makes its factors of.
    pub fn ray(&self) -> Ray {
        Ray {
            lm: self.lm,
            tilt: self.tilt,
        }
    }
}

/// Where light comes from, and its spectrum: what the factors of the instrument depend on.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ray {
    /// Position about the phase centre.
    pub lm: Lm,
    /// As in [`Source`].
    pub tilt: f64,
}
