//! Taking sources out of the data.

use super::VisBlock;
use super::kernel::{self, Isa};
use crate::rime::Source;
use crate::rime::shape::Profile;

/// Subtracts the visibilities of `sources` from `block`: w d becomes w (d - Σ V). To put sources
/// back, subtract them with the flux densities negated.
///
/// On one core; blocks are independent of each other.
pub fn subtract(block: &mut VisBlock, sources: &[(Source, Profile)]) {
    kernel::subtract(Isa::detect(), block, sources);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::samples::{MEERKAT, PROFILES, noise, seen, sources};
    use crate::rime::predict;
    use num_complex::Complex;

    /// `count` sources of all profiles.
    fn mixed(count: usize) -> Vec<(Source, Profile)> {
        sources(count, 1)
            .into_iter()
            .zip(PROFILES.into_iter().cycle())
            .collect()
    }

    /// Largest error of what `isa` takes out of `block`, relative to the sum of the fluxes.
    fn worst_error(isa: Isa, block: &VisBlock, sources: &[(Source, Profile)]) -> f64 {
        // without data, so that the rounding of the data does not hide the model
        let mut got = block.clone();
        got.weighted_re.fill(0.0);
        got.weighted_im.fill(0.0);
        kernel::subtract(isa, &mut got, sources);
        let total: f64 = sources.iter().map(|(s, _)| s.flux_jy).sum();
        let error = |k: usize| {
            let (u, v, w) = (block.u[k], block.v[k], block.w[k]);
            let gain = |s: &Source| block.extents.factor(k, s.ray(), [u, v, w]);
            let models = sources
                .iter()
                .map(|(s, p)| predict(s, *p, u, v, w) * gain(s));
            let model: Complex<f64> = models.sum();
            let taken = -Complex::new(got.weighted_re[k] as f64, got.weighted_im[k] as f64);
            (taken / block.weight[k] as f64 - model).norm() / total
        };
        (0..block.len()).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn the_model_is_taken_out_to_1e_6_by_every_kernel() {
        let sources = mixed(20);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            for len in [0, 1, 15, 16, 17, 1000] {
                let worst = worst_error(isa, &noise(len, 2), &sources);
                assert!(worst < 1e-6, "{isa:?} {len}: {worst:e}");
            }
        }
    }

    #[test]
    fn factors_of_the_instrument_are_taken_out_too() {
        let sources = mixed(20);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            let worst = worst_error(isa, &seen(noise(1000, 2), MEERKAT), &sources);
            assert!(worst < 3e-6, "{isa:?}: {worst:e}");
        }
    }

    #[test]
    fn phases_beyond_the_fixed_point_form_are_taken_out_too() {
        let mut block = noise(100, 3);
        block.w.iter_mut().for_each(|w| *w *= 1e6);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            assert!(worst_error(isa, &block, &mixed(6)) < 1e-6, "{isa:?}");
        }
    }

    #[test]
    fn putting_back_undoes_taking_out() {
        let block = noise(300, 4);
        let sources = mixed(5);
        let mut there_and_back = block.clone();
        subtract(&mut there_and_back, &sources);
        assert_ne!(block, there_and_back);
        let negated: Vec<_> = sources
            .iter()
            .map(|&(s, p)| {
                (
                    Source {
                        flux_jy: -s.flux_jy,
                        ..s
                    },
                    p,
                )
            })
            .collect();
        subtract(&mut there_and_back, &negated);
        for (a, b) in block.weighted_re.iter().zip(&there_and_back.weighted_re) {
            assert!((a - b).abs() < 1e-3, "of about 540");
        }
    }

    #[test]
    fn samples_of_zero_weight_stay_zero() {
        let mut block = noise(10, 5);
        block.weight.fill(0.0);
        block.weighted_re.fill(0.0);
        block.weighted_im.fill(0.0);
        subtract(&mut block, &mixed(3));
        assert!(
            block
                .weighted_re
                .iter()
                .chain(&block.weighted_im)
                .all(|&d| d == 0.0)
        );
    }
}
