//! A block of Stokes I samples, one array a quantity.

use super::extents::Extents;
use super::kernel::{self, Isa};
use crate::rime::Ray;

/// Samples in the form that the kernels eat: only unflagged ones, Stokes I, coordinates in
/// wavelengths, data multiplied by their weight.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VisBlock {
    /// Baseline coordinate u [wavelength].
    pub u: Vec<f64>,
    /// Baseline coordinate v [wavelength].
    pub v: Vec<f64>,
    /// Baseline coordinate w [wavelength].
    pub w: Vec<f64>,
    /// Real part of weight times visibility [Jy⁻¹].
    pub weighted_re: Vec<f32>,
    /// Imaginary part of weight times visibility [Jy⁻¹].
    pub weighted_im: Vec<f32>,
    /// Weight 1/σ² [Jy⁻²], σ that of the real and of the imaginary part.
    pub weight: Vec<f32>,
    /// What the samples are means over, where that is asked for.
    pub extents: Extents,
}

impl VisBlock {
    /// No samples, with room for `len`.
    pub fn with_capacity(len: usize) -> Self {
        Self {
            u: Vec::with_capacity(len),
            v: Vec::with_capacity(len),
            w: Vec::with_capacity(len),
            weighted_re: Vec::with_capacity(len),
            weighted_im: Vec::with_capacity(len),
            weight: Vec::with_capacity(len),
            extents: Extents::default(),
        }
    }

    /// Becomes the same as `other`, in the room that it has.
    pub fn copy_from(&mut self, other: &Self) {
        self.u.clone_from(&other.u);
        self.v.clone_from(&other.v);
        self.w.clone_from(&other.w);
        self.weighted_re.clone_from(&other.weighted_re);
        self.weighted_im.clone_from(&other.weighted_im);
        self.weight.clone_from(&other.weight);
        self.extents.copy_from(&other.extents);
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.weight.len()
    }

    /// The samples number `which`, in that order.
    #[must_use]
    pub fn select(&self, which: &[u32]) -> Self {
        let doubles = |from: &[f64]| which.iter().map(|&k| from[k as usize]).collect();
        let singles = |from: &[f32]| which.iter().map(|&k| from[k as usize]).collect();
        Self {
            u: doubles(&self.u),
            v: doubles(&self.v),
            w: doubles(&self.w),
            weighted_re: singles(&self.weighted_re),
            weighted_im: singles(&self.weighted_im),
            weight: singles(&self.weight),
            extents: self.extents.select(which),
        }
    }

    /// The largest change of what a smearing loss is the sinc of with direction cosines [turn]; 0 without
    /// smearing.
    pub(super) fn blur(&self) -> f64 {
        let length = |k: usize| (self.u[k].powi(2) + self.v[k].powi(2) + self.w[k].powi(2)).sqrt();
        let extent = |k: usize| self.extents.blur(k);
        let n = if self.extents.are_smeared() {
            self.len()
        } else {
            0
        };
        (0..n).fold(0.0, |most, k| f64::max(most, length(k) * extent(k)))
    }

    /// The factors of the instrument for a source; none without.
    pub(super) fn gains(&self, isa: Isa, ray: Ray) -> Option<Vec<f32>> {
        let gain = self.extents.gain(ray)?;
        let mut gains = vec![0.0; self.len()];
        kernel::look(isa, self, &gain, &mut gains);
        Some(gains)
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.weight.is_empty()
    }
}
