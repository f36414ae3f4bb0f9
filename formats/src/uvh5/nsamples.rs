//! What the nsamples are worth as weights.
//!
//! nsamples tell how many of the correlator's samples went into a visibility, so that its variance
//! goes as 1/nsample. Real files have them all zero, or all of no sense at all (-1.2e12), with good
//! data beside. Of such files all weights are taken as 1; in any other a sample of zero or less is
//! flagged, as pyuvdata has it on the way to UVFITS.

use super::axes::Axes;
use super::cube::Cube;
use crate::ReadError;

/// Windows that are looked at before nsamples are given up.
const MAX_WINDOWS: usize = 4;
/// Rows of each that are looked at.
const MAX_WINDOW_ROWS: usize = 1 << 10;

/// Whether nsamples can be weights: some sample that is not flagged has a positive one, in any of a
/// few places of the file, or all that was looked at is flagged.
pub(super) fn are_weights(
    axes: &Axes,
    flags: &mut Cube<i8>,
    nsamples: &mut Cube<f32>,
) -> Result<bool, ReadError> {
    let per_row = axes.n_chan * axes.n_corr;
    let n_window = MAX_WINDOWS.min(axes.n_row);
    let (mut bad, mut sizes) = (vec![0; per_row], vec![0.0; per_row]);
    let mut all_flagged = true;
    for window in 0..n_window {
        let first = (axes.n_row as u128 * window as u128 / n_window as u128) as usize;
        let n = (flags.load(first..axes.n_row)?).min(nsamples.load(first..axes.n_row)?);
        for row in (first..first + n).step_by(n.div_ceil(MAX_WINDOW_ROWS)) {
            flags.copy(row..row + 1, &mut bad);
            nsamples.copy(row..row + 1, &mut sizes);
            for (_, &nsample) in bad.iter().zip(&sizes).filter(|(flag, _)| **flag == 0) {
                if nsample > 0.0 && nsample.is_finite() {
                    return Ok(true);
                }
                all_flagged = false;
            }
        }
    }
    Ok(all_flagged)
}
