//! The two sums as the formula writes them, in f64: slow, and what every kernel is held against.

use super::{VisBlock, Xy};
use crate::rime::shape::{Profile, QuadraticForm};
use crate::rime::{Source, phase_turns};
use std::f64::consts::TAU;

/// X and Y of `source` at unit flux density over `block`: one plain loop in f64.
///
/// # Formula
/// ```text
/// X = Σ w F Re[d exp(-2πi φ)] = Σ F (Re(w d) cos 2πφ + Im(w d) sin 2πφ)      Y = Σ w F²
/// ```
pub fn plain_xy(block: &VisBlock, source: &Source, profile: Profile) -> Xy {
    let form = QuadraticForm::new(source.scale_rad, source.e);
    let mut sum = Xy::default();
    for k in 0..block.len() {
        let (u, v, w) = (block.u[k], block.v[k], block.w[k]);
        let (sin, cos) = (TAU * phase_turns(source, u, v, w)).sin_cos();
        let [u_seen, v_seen] = source.lm.uv_seen(u, v, w);
        let gain = block.extents.factor(k, source.ray(), [u, v, w]);
        let factor = gain * profile.shape().factor(form.at(u_seen, v_seen));
        let (re, im) = (block.weighted_re[k] as f64, block.weighted_im[k] as f64);
        sum.x += factor * (re * cos + im * sin);
        sum.y += block.weight[k] as f64 * factor * factor;
    }
    sum
}
