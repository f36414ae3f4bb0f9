//! How many sources a field holds, of which each mode may be one.

use super::Mode;

/// Steps of the bisection: as many as the mantissa has bits.
const N_STEP: u32 = 60;
/// Times that the number of sources and the noise that they add are found from each other: a tenth of the
/// noise, more than there ever is, leaves an error of 1e-4.
const N_REPEAT: u32 = 4;

/// Number N of sources to be expected in a field, from the local evidences of all modes above the cut
/// (against no source, with the prior of the whole field) and the part `faint` of all sources that
/// stay below it.
///
/// # Formula
/// There is a source in mode i or none, with the odds N Z_i. Below the cut lies the part `faint` of the
/// evidence of a source, on average over the noise. So the likelihood of N is
/// ```text
/// L(N) = exp(-N (1 - faint)) Π (1 + N Z_i)
/// ```
/// which is highest where the probabilities N Z_i/(1 + N Z_i) add up to N (1 - faint).
///
/// # Source
/// The odds: Hobson & McLachlan 2003, MNRAS 338, 765, equation 24. N by maximum likelihood of a Poisson
/// number of sources.
pub(super) fn expected_sources(log_z: &[f64], faint: f64) -> f64 {
    let seen = 1.0 - faint;
    // The sum of Z/(1 + N Z) falls with N, from the sum of Z at 0 to below `seen` at this N.
    let excess = |n: f64| {
        let terms = log_z.iter().map(|log_z| 1.0 / ((-log_z).exp() + n));
        terms.sum::<f64>() - seen
    };
    if seen <= 0.0 || excess(0.0) <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, log_z.len() as f64 / seen);
    for _ in 0..N_STEP {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// What modes are weighed with to tell sources from noise.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Census {
    /// Sources in the field, detectable or not.
    pub n_expected: f64,
    /// Variance that those below the cut add to the noise, in units of that of the noise.
    pub confusion: f64,
}

impl Census {
    /// The census by the `modes` above the cut, if the part `faint` of all sources stays below it and
    /// each source of all adds `confusion_of_one` to the variance on average.
    pub(super) fn take(modes: &[&Mode], faint: f64, confusion_of_one: f64) -> Self {
        let mut census = Self::default();
        for _ in 0..N_REPEAT {
            let log_z: Vec<f64> = modes.iter().map(|mode| census.log_z(mode)).collect();
            census.n_expected = expected_sources(&log_z, faint);
            census.confusion = census.n_expected * confusion_of_one;
        }
        census
    }

    /// Local evidence of a mode with the noise that there is.
    ///
    /// # Formula
    /// With the noise f times larger ln L is ln L/f², and the evidence the posterior mean of
    /// exp((1/f² - 1) ln L) times what it was: to first order ln Z - (1 - 1/f²) <ln L>.
    fn log_z(&self, mode: &Mode) -> f64 {
        mode.log_z - self.confusion / (1.0 + self.confusion) * mode.mean_log_l
    }

    /// Probability that a mode is a source.
    pub fn p_source(&self, mode: &Mode) -> f64 {
        p_source(self.log_z(mode), self.n_expected)
    }
}

/// Probability that a mode of local evidence `log_z` is a source where `n_expected` are expected.
fn p_source(log_z: f64, n_expected: f64) -> f64 {
    1.0 / (1.0 + (-log_z - n_expected.ln()).exp())
}

#[cfg(test)]
mod tests {
    use super::super::ModeSample;
    use super::*;
    use crate::rime::Source;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn sure_sources_are_counted() {
        assert!((expected_sources(&[50.0; 20], 0.0) - 20.0).abs() < 1e-9);
        assert!((expected_sources(&[50.0; 20], 0.5) - 40.0).abs() < 1e-9);
        assert_eq!(p_source(50.0, 20.0), 1.0);
    }

    #[test]
    fn noise_is_no_source() {
        assert_eq!(expected_sources(&[], 0.0), 0.0);
        assert_eq!(expected_sources(&[-5.0; 20], 0.0), 0.0);
        assert_eq!(expected_sources(&[3.0], 1.0), 0.0);
        assert_eq!(p_source(-5.0, 0.0), 0.0);
    }

    #[test]
    fn the_probabilities_add_up_to_what_can_be_seen() {
        let log_z: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.2 - 8.0).collect();
        for faint in [0.0, 0.3] {
            let n = expected_sources(&log_z, faint);
            let sum: f64 = log_z.iter().map(|z| p_source(*z, n)).sum();
            assert!((sum / (n * (1.0 - faint)) - 1.0).abs() < 1e-9, "{sum} {n}");
        }
    }

    /// One of 1000 places, which shows `snr`.
    fn mode(snr: f64) -> Mode {
        let log_l = 0.5 * snr * snr;
        let sample = ModeSample {
            source: Source::default(),
            log_l,
            weight: 1.0,
        };
        Mode::new(0, vec![sample], log_l - 1000f64.ln(), 0.0)
    }

    #[test]
    fn confusion_makes_faint_sources_less_sure_and_fewer() {
        let modes: Vec<Mode> = (0..60).map(|i| mode(3.0 + 0.05 * f64::from(i))).collect();
        let modes: Vec<&Mode> = modes.iter().collect();
        let clear = Census::take(&modes, 0.3, 0.0);
        let confused = Census::take(&modes, 0.3, 5e-4);
        assert_eq!(clear.confusion, 0.0);
        assert!((confused.confusion / (5e-4 * confused.n_expected) - 1.0).abs() < 1e-3);
        assert!(confused.n_expected < clear.n_expected);
        for mode in modes {
            assert!(confused.p_source(mode) < clear.p_source(mode));
        }
        // At a signal-to-noise ratio of 5 a variance of 3% takes 0.36 of ln Z.
        let census = Census {
            n_expected: 20.0,
            confusion: 0.03,
        };
        assert!((census.log_z(&mode(5.0)) - (mode(5.0).log_z - 12.5 * 0.03 / 1.03)).abs() < 1e-9);
    }

    /// A field of 1000 places, in which a source shows as SNR 4 +- 1 and noise as 0 +- 1, has
    /// Z = exp(4 x - 8)/1000 where x is seen.
    #[test]
    fn a_simulated_number_is_found_again() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut gauss = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let (n_true, mut sum) = (60, 0.0);
        for _ in 0..20 {
            let log_z: Vec<f64> = (0..1000)
                .map(|i| 4.0 * (gauss() + if i < n_true { 4.0 } else { 0.0 }) - 8.0 - 1000f64.ln())
                .collect();
            sum += expected_sources(&log_z, 0.0) / 20.0;
        }
        assert!((sum - f64::from(n_true)).abs() < 4.0, "{sum}");
    }
}
