//! What the sources below the cut add to the noise.
//!
//! The model of the data has none of them, so that about every place they add to what is seen: less
//! than the noise by far, but evidences of faint modes are exponentials of what is seen.

use std::f64::consts::{PI, TAU};

use super::{Dataset, DatasetError};
use crate::coords::Lm;
use crate::prior::{Region, SourcePrior};
use crate::rime::Source;

/// Pairs of sources that are looked at.
const N_PAIR: usize = 256;
/// The other source of a pair has so many times the number of the one, so that all shapes meet.
const OTHER_STEP: usize = 97;
/// Turn from one pair to the next: the golden angle, so that all directions are covered at all
/// distances.
const GOLDEN_TURN: f64 = 0.381_966_011_250_105;

impl Dataset {
    /// Variance that one source of `prior` adds on average, if it stays below the signal-to-noise ratio
    /// `cut`, to X/sqrt(Y) of another one anywhere in `field`, but not nearer than `nearest_rad`; that of
    /// the noise is 1.
    ///
    /// # Formula
    /// Source i adds S_i Y_ij/sqrt(Y_j) to X_j/sqrt(Y_j), so that with ρ_i² = S_i² Y_i
    /// ```text
    /// variance = <ρ_i² [i below the cut] ∫ Y_ij²/(Y_i Y_j) dΩ> / field
    /// ```
    /// The integral, from `nearest_rad` to a disk as large as the field, is a sum over pairs at distances
    /// that are even in their logarithm.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn confusion_of_one(
        &mut self,
        prior: &SourcePrior,
        cut: f64,
        field: &Region,
        nearest_rad: f64,
    ) -> Result<f64, DatasetError> {
        let farthest_rad = (field.area() / PI).sqrt().max(nearest_rad);
        let step = (farthest_rad / nearest_rad).ln() / N_PAIR as f64;
        let distance_rad = |k: usize| nearest_rad * ((k as f64 + 0.5) * step).exp();
        let centre = field.from_unit(0.5, 0.5);
        let place = |k: usize| {
            let (sin, cos) = (TAU * GOLDEN_TURN * k as f64).sin_cos();
            Lm {
                l: centre.l + distance_rad(k) * cos,
                m: centre.m + distance_rad(k) * sin,
            }
        };
        let below = self.below(cut, prior, N_PAIR);
        let other = |k: usize| &below[(k * OTHER_STEP + 1) % N_PAIR];
        let at = |lm, source| Source { lm, ..source };
        let pair = |k: usize| [at(place(k), below[k].source), at(centre, other(k).source)];
        let y_ij = self.cross(&(0..N_PAIR).map(pair).collect::<Vec<_>>())?;
        let term = |k: usize| {
            let common = y_ij[k] * y_ij[k] / (below[k].y * other(k).y);
            let area = TAU * distance_rad(k).powi(2) * step;
            below[k].probability * below[k].snr2() * common * area
        };
        Ok((0..N_PAIR).map(term).sum::<f64>() / field.area())
    }
}
