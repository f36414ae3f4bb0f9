//! What two sources have in common in the data, and the likelihood of several sources together.
//!
//! ```text
//! ln L - ln L0 = Σ_i S_i X_i - 1/2 Σ_i S_i² Y_i - Σ_{i<j} S_i S_j Y_ij
//! Y_ij = Σ w F_i F_j cos 2π(φ_i - φ_j)      so that Y_ii = Y_i
//! ```

use super::kernel::{self, Isa, PairTerm};
use super::{VisBlock, Xy};
use crate::rime::Source;
use crate::rime::shape::{Profile, QuadraticForm};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Most partial sums kept at a time (8 bytes each).
const PARTIAL_SUMS: usize = 1 << 22;

/// Which of `count` sources make a pair: (0, 1), (0, 2), .., (1, 2), ..
pub fn pairs(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| [i, j]))
}

/// ln L - ln L0 of `sources` together: `xy` is X and Y of each in data that hold all of them,
/// `cross` is Y_ij [Jy⁻²] of their [`pairs`].
pub fn joint_log_l(sources: &[Source], xy: &[Xy], cross: &[f64]) -> f64 {
    let flux_jy = |i: usize| sources[i].flux_jy;
    let alone: f64 = (sources.iter().zip(xy))
        .map(|(source, xy)| xy.log_l(source.flux_jy))
        .sum();
    let shared: f64 = pairs(sources.len())
        .zip(cross)
        .map(|([i, j], y)| flux_jy(i) * flux_jy(j) * y)
        .sum();
    alone - shared
}

/// X and Y of source number `which` of `sources` with the others taken out of the data; arguments
/// as for [`joint_log_l`].
pub fn xy_without_others(which: usize, sources: &[Source], xy: &[Xy], cross: &[f64]) -> Xy {
    let of_others = pairs(sources.len()).zip(cross).map(|([i, j], y)| {
        let other = if i == which { j } else { i };
        let is_ours = i == which || j == which;
        f64::from(u8::from(is_ours)) * sources[other].flux_jy * y
    });
    Xy {
        x: xy[which].x - of_others.sum::<f64>(),
        y: xy[which].y,
    }
}

/// Adds Y_ij [Jy⁻²] of each of `terms` over the next `blocks` of a stream to `out`, on the current
/// rayon pool. As with X and Y, sums of blocks are added in the order of blocks.
///
/// # Panics
/// If `out` is not as long as `terms`.
pub fn accumulate_pairs(blocks: &[VisBlock], terms: &[PairTerm], out: &mut [f64]) {
    assert_eq!(terms.len(), out.len(), "one sum a pair");
    if terms.is_empty() {
        return;
    }
    let isa = Isa::detect();
    for group in blocks.chunks((PARTIAL_SUMS / terms.len()).max(1)) {
        let parts: Vec<Vec<f64>> = group
            .par_iter()
            .map(|block| {
                let mut sums = vec![0.0; terms.len()];
                kernel::accumulate_pairs(isa, block, terms, &mut sums);
                sums
            })
            .collect();
        for part in parts {
            out.iter_mut()
                .zip(part)
                .for_each(|(out, part)| *out += part);
        }
    }
}

/// Y_ij of a pair over `block` as the formula writes it, in f64: what the kernels are held against.
pub fn plain_cross(block: &VisBlock, pair: &[Source; 2], profile: Profile) -> f64 {
    let [a, b] = pair.map(|source| source.lm);
    let term = |k: usize| {
        let (u, v, w) = (block.u[k], block.v[k], block.w[k]);
        let phase = u * (a.l - b.l) + v * (a.m - b.m) + w * (a.n_minus_1() - b.n_minus_1());
        let [f, g] = pair.map(|source| {
            let [u_seen, v_seen] = source.lm.uv_seen(u, v, w);
            let form = QuadraticForm::new(source.scale_rad, source.e);
            let gain = block.extents.factor(k, source.ray(), [u, v, w]);
            gain * profile.shape().factor(form.at(u_seen, v_seen))
        });
        block.weight[k] as f64 * f * g * (TAU * phase).cos()
    };
    (0..block.len()).map(term).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::samples::{MEERKAT, PROFILES, noise, seen, sources};
    use crate::likelihood::{plain_xy, subtract};
    use crate::units::ARCSEC;

    /// Pairs up to 30 arcsec apart, and one far apart.
    fn close_pairs(count: usize) -> Vec<[Source; 2]> {
        let all = sources(2 * count, 3);
        let pair = |(i, two): (usize, &[Source])| {
            let mut second = two[1];
            if i > 0 {
                let apart = 30.0 * ARCSEC / 0.04;
                second.lm.l = two[0].lm.l + apart * second.lm.l;
                second.lm.m = two[0].lm.m + apart * second.lm.m;
            }
            [two[0], second]
        };
        all.chunks(2).enumerate().map(pair).collect()
    }

    fn cross(isa: Isa, block: &VisBlock, pairs: &[[Source; 2]], profile: Profile) -> Vec<f64> {
        let terms: Vec<_> = pairs.iter().map(|p| PairTerm::new(p, profile)).collect();
        let mut out = vec![0.0; terms.len()];
        kernel::accumulate_pairs(isa, block, &terms, &mut out);
        out
    }

    /// Largest error of a pair's sum relative to sqrt(Y_i Y_j).
    fn worst(isa: Isa, block: &VisBlock, pairs: &[[Source; 2]], profile: Profile) -> f64 {
        let error = |(got, pair): (f64, &[Source; 2])| {
            let [a, b] = pair.map(|source| plain_xy(block, &source, profile).y);
            (got - plain_cross(block, pair, profile)).abs() / (a * b).sqrt()
        };
        let got = cross(isa, block, pairs, profile);
        got.into_iter().zip(pairs).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn every_kernel_has_the_plain_sum() {
        let pairs = close_pairs(40);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            for profile in PROFILES {
                for len in [1, 15, 16, 17, 513, 5_000] {
                    let worst = worst(isa, &noise(len, 2), &pairs, profile);
                    assert!(worst < 2e-6, "{isa:?} {profile:?} {len}: {worst:e}");
                }
            }
        }
    }

    #[test]
    fn factors_of_the_instrument_are_those_of_both() {
        let pairs = close_pairs(30);
        let block = seen(noise(3_000, 4), MEERKAT);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            let worst = worst(isa, &block, &pairs, Profile::Exponential);
            assert!(worst < 5e-6, "{isa:?}: {worst:e}");
        }
    }

    #[test]
    fn phases_beyond_the_fixed_point_form_are_summed_too() {
        let mut block = noise(600, 12);
        block.w.iter_mut().for_each(|w| *w *= 1e5);
        let mut pair = close_pairs(1)[0];
        pair[1].lm.l += 0.3;
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            assert!(worst(isa, &block, &[pair], Profile::Exponential) < 2e-6);
        }
    }

    #[test]
    fn a_source_with_itself_has_its_y() {
        let block = noise(1_000, 5);
        for source in sources(5, 6) {
            let y = plain_xy(&block, &source, Profile::Exponential).y;
            let cross = plain_cross(&block, &[source; 2], Profile::Exponential);
            assert!((cross / y - 1.0).abs() < 1e-12);
        }
    }

    /// What the joint likelihood says of three sources is what their sum does to |d - V|².
    #[test]
    fn the_joint_likelihood_is_that_of_the_sum_of_the_models() {
        let block = noise(800, 7);
        let profile = Profile::Exponential;
        let mut sources = [sources(1, 8)[0]; 3];
        for (i, source) in sources.iter_mut().enumerate() {
            source.lm.l += i as f64 * ARCSEC;
            source.scale_rad = (1.0 + i as f64) * ARCSEC;
            source.flux_jy = 3e-4 * (1.0 + i as f64);
        }
        let xy = sources.map(|source| plain_xy(&block, &source, profile));
        let cross: Vec<f64> = pairs(3)
            .map(|[i, j]| plain_cross(&block, &[sources[i], sources[j]], profile))
            .collect();
        let chi2 = |block: &VisBlock| -> f64 {
            let square = |k: usize| {
                let (re, im) = (block.weighted_re[k] as f64, block.weighted_im[k] as f64);
                (re * re + im * im) / block.weight[k] as f64
            };
            (0..block.len()).map(square).sum()
        };
        let mut without = block.clone();
        subtract(&mut without, &sources.map(|source| (source, profile)));
        let direct = 0.5 * (chi2(&block) - chi2(&without));
        let joint = joint_log_l(&sources, &xy, &cross);
        assert!((joint - direct).abs() < 1e-3, "{joint} {direct}");
        // One of them in data without the others.
        let mut others = block.clone();
        subtract(&mut others, &[(sources[0], profile), (sources[2], profile)]);
        let alone = plain_xy(&others, &sources[1], profile);
        let got = xy_without_others(1, &sources, &xy, &cross);
        assert!((got.x - alone.x).abs() < 1e-5 * alone.y.sqrt());
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let blocks: Vec<_> = [700, 1, 0, 1_300].map(|len| noise(len, 9)).into();
        let pairs = close_pairs(5);
        let terms: Vec<_> = (pairs.iter())
            .map(|pair| PairTerm::new(pair, Profile::Exponential))
            .collect();
        let with_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let mut out = vec![0.0; terms.len()];
            pool.unwrap()
                .install(|| accumulate_pairs(&blocks, &terms, &mut out));
            out
        };
        assert_eq!(with_threads(1), with_threads(3));
    }
}
