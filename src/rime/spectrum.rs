//! The spectrum of sources: a power law, the same for all.

/// S(ν) = S (ν/ν0)^β.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrum {
    /// Spectral index β: -0.7 is typical of synchrotron radiation.
    pub index: f64,
    /// Frequency that flux densities are given at [Hz].
    pub ref_freq_hz: f64,
}

impl Spectrum {
    /// Flux density at `freq_hz` over that at the reference frequency.
    pub fn factor(self, freq_hz: f64) -> f64 {
        (freq_hz / self.ref_freq_hz).powf(self.index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steep_spectrum_is_fainter_at_high_frequencies() {
        let spectrum = Spectrum {
            index: -0.7,
            ref_freq_hz: 1.4e9,
        };
        assert_eq!(spectrum.factor(1.4e9), 1.0);
        assert!((spectrum.factor(2.8e9) - 0.615_572_206_672_458).abs() < 1e-14);
    }
}
