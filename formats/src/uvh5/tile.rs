//! Samples of a few rows on their way into a chunk.

use num_complex::Complex;

use crate::VisChunk;
use crate::chunk::settle;

/// Samples that are put together at a time: 100 kB.
pub(super) const TILE_VALUES: usize = 1 << 13;

/// The samples as the file has them.
#[derive(Debug, Default)]
pub(super) struct Tile {
    pub(super) vis: Vec<Complex<f32>>,
    pub(super) weight: Vec<f32>,
    /// Not zero: flagged.
    pub(super) bad: Vec<i8>,
}

impl Tile {
    pub(super) fn resize(&mut self, n_value: usize) {
        self.vis.resize(n_value, Complex::default());
        self.weight.resize(n_value, 0.0);
        self.bad.resize(n_value, 0);
    }

    /// Appends the samples to a chunk; returns how many were not finite though not flagged.
    ///
    /// Conjugates, since a chunk has the baselines the other way round.
    pub(super) fn append_to(&self, chunk: &mut VisChunk) -> u64 {
        if !self.is_finite() {
            return self.settle_into(chunk);
        }
        // What `settle` comes to for numbers, in loops that the compiler makes many at a time of.
        chunk.vis_jy_rfp.extend(self.vis.iter().map(Complex::conj));
        let samples = || self.weight.iter().zip(&self.bad);
        let good = |weight: f32, bad: i8| bad == 0 && weight > 0.0;
        (chunk.weight_rfp).extend(samples().map(|(&w, &b)| if good(w, b) { w } else { 0.0 }));
        (chunk.flag_rfp).extend(samples().map(|(&w, &b)| !good(w, b)));
        0
    }

    fn is_finite(&self) -> bool {
        let parts = self
            .vis
            .iter()
            .fold(true, |all, v| all & v.re.is_finite() & v.im.is_finite());
        parts & self.weight.iter().fold(true, |all, w| all & w.is_finite())
    }

    fn settle_into(&self, chunk: &mut VisChunk) -> u64 {
        let mut n_odd = 0;
        for ((stored, &size), &bad) in self.vis.iter().zip(&self.weight).zip(&self.bad) {
            let signed = if bad == 0 { size } else { -size.abs() };
            let (vis, weight, flag, odd) = settle(stored.re, -stored.im, signed);
            chunk.vis_jy_rfp.push(vis);
            chunk.weight_rfp.push(weight);
            chunk.flag_rfp.push(flag);
            n_odd += u64::from(odd && bad == 0);
        }
        n_odd
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(last_im: f32) -> Tile {
        Tile {
            vis: vec![
                Complex::new(1.0, 2.0),
                Complex::new(3.0, -4.0),
                Complex::new(5.0, last_im),
            ],
            weight: vec![2.0, -1.0, 3.0],
            bad: vec![0, 0, 1],
        }
    }

    #[test]
    fn both_ways_give_the_same() {
        let mut fast = VisChunk::new(1);
        let mut slow = VisChunk::new(1);
        assert_eq!(tile(0.0).append_to(&mut fast), 0);
        assert_eq!(tile(0.0).settle_into(&mut slow), 0);
        assert_eq!(fast, slow);
        assert_eq!(fast.vis_jy_rfp[0], Complex::new(1.0, -2.0));
        assert_eq!(fast.weight_rfp, [2.0, 0.0, 0.0]);
        assert_eq!(fast.flag_rfp, [false, true, true]);
    }

    #[test]
    fn what_is_not_finite_is_flagged_and_counted_once() {
        let mut chunk = VisChunk::new(1);
        let mut odd = tile(f32::NAN);
        assert_eq!(odd.append_to(&mut chunk), 0, "flagged in the file already");
        odd.weight[0] = f32::INFINITY;
        assert_eq!(odd.append_to(&mut chunk), 1);
        assert_eq!(chunk.flag_rfp, [false, true, true, true, true, true]);
        assert_eq!(chunk.vis_jy_rfp[2], Complex::default());
    }
}
