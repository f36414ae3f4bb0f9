//! What multiplies the model of a sample besides the source's shape: a real factor s_k(l, m).
//!
//! ```text
//! s = A(l, m, ν) (ν/ν0)^β sinc(φ Δν/ν) sinc(dφ/dt τ)
//! ```
//!
//! Primary beam, spectral index, bandwidth and time smearing; each is 1 unless it is asked for. Here it
//! is in f64 as the formulas stand; `likelihood` has a fast form of it.

use super::{Beam, EARTH_RAD_PER_S, Ray, Smearing, SpectralIndex, Spectrum, sinc};
use crate::coords::Lm;

/// Which terms there are.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InstrumentTerms {
    /// Time and bandwidth smearing.
    pub smearing: bool,
    /// Primary beam.
    pub beam: Option<Beam>,
    /// Spectral index of the sources.
    pub spectral_index: Option<SpectralIndex>,
}

impl InstrumentTerms {
    /// True without any.
    pub fn are_none(&self) -> bool {
        *self == Self::default()
    }
}

/// What one sample is a mean over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Frequency in the middle [Hz].
    pub freq_hz: f64,
    /// Channel width [Hz].
    pub width_hz: f64,
    /// Integration time [s].
    pub interval_s: f64,
}

impl Extent {
    /// The most that the arguments of both sincs can change together, for each wavelength of baseline and
    /// each unit of direction cosine [turn].
    pub fn blur(&self) -> f64 {
        self.width_hz / self.freq_hz + EARTH_RAD_PER_S * self.interval_s
    }
}

/// The terms, ready for the samples of one observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instrument {
    pub(crate) smearing: Option<Smearing>,
    beam: Option<Beam>,
    spectrum: Option<Spectrum>,
    /// Lowest and highest frequency of a sample [Hz].
    band_hz: [f64; 2],
}

impl Instrument {
    /// None without terms. `band_hz` are the middles of the lowest and the highest channel [Hz], of which
    /// the mean is where the flux densities are given at; `pole` is as in [`Smearing`].
    pub fn new(terms: &InstrumentTerms, band_hz: [f64; 2], pole: [f64; 3]) -> Option<Self> {
        let ref_freq_hz = 0.5 * (band_hz[0] + band_hz[1]);
        let spectrum = |index: SpectralIndex| Spectrum {
            index: index.middle(),
            ref_freq_hz,
        };
        (!terms.are_none()).then(|| Self {
            smearing: terms.smearing.then_some(Smearing { pole }),
            beam: terms.beam,
            spectrum: terms.spectral_index.map(spectrum),
            band_hz,
        })
    }

    /// The middle of the band, where flux densities are given at [Hz].
    pub fn ref_freq_hz(&self) -> f64 {
        0.5 * (self.band_hz[0] + self.band_hz[1])
    }

    /// Where in the band a frequency is: -1/2 at the lowest channel, 1/2 at the highest.
    pub fn place(&self, freq_hz: f64) -> f64 {
        // The width of a single channel does not matter.
        let width_hz = (self.band_hz[1] - self.band_hz[0]).max(1e-6 * self.band_hz[1]);
        (freq_hz - self.ref_freq_hz()) / width_hz
    }

    /// The frequency at a place in the band [Hz].
    pub fn freq_hz(&self, place: f64) -> f64 {
        self.ref_freq_hz() + place * (self.band_hz[1] - self.band_hz[0])
    }

    /// The largest |ln(ν/ν0)| of the band.
    pub fn half_band_ln(&self) -> f64 {
        let ref_freq_hz = self.ref_freq_hz();
        let ends = self
            .band_hz
            .map(|freq_hz| (freq_hz / ref_freq_hz).ln().abs());
        ends[0].max(ends[1])
    }

    /// The primary beam at the middle of the band; none without a beam.
    pub fn beam_at(&self, lm: Lm) -> Option<f64> {
        self.beam.map(|beam| beam.power(lm, self.ref_freq_hz()))
    }

    /// The part of s that does not depend on the baseline.
    pub fn brightness(&self, ray: Ray, freq_hz: f64) -> f64 {
        let beam = self.beam.map_or(1.0, |beam| beam.power(ray.lm, freq_hz));
        beam * self.spectrum.map_or(1.0, |s| s.factor(freq_hz, ray.tilt))
    }

    /// The part of s that smearing leaves on the baseline `uvw` [wavelength].
    pub fn smearing(&self, lm: Lm, uvw: [f64; 3], extent: Extent) -> f64 {
        let Some(smearing) = self.smearing else {
            return 1.0;
        };
        let along = |s: [f64; 3]| uvw[0] * s[0] + uvw[1] * s[1] + uvw[2] * s[2];
        sinc(along(Smearing::turns(lm)) * extent.width_hz / extent.freq_hz)
            * sinc(along(smearing.turns_per_s(lm)) * extent.interval_s)
    }

    /// s of a source on the baseline `uvw` [wavelength].
    pub fn factor(&self, ray: Ray, uvw: [f64; 3], extent: Extent) -> f64 {
        self.brightness(ray, extent.freq_hz) * self.smearing(ray.lm, uvw, extent)
    }
}
