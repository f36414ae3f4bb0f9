//! What each sample of a block is a mean over, and the factor that this gives a source.
#![allow(clippy::inline_always)] // compiled anew for each instruction set

use super::kernel::numbers::{SQRT2_SIN_PI, horner};
use crate::rime::{EARTH_RAD_PER_S, Extent, Instrument, Ray, Smearing};
use std::f64::consts::{PI, SQRT_2};
use std::ops::Range;
use std::sync::Arc;

/// Coefficients of the brightness over the band.
const TERMS: usize = 12;

/// How the samples of a block were observed; empty where no term of the instrument is asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Extents {
    /// The terms.
    pub instrument: Option<Arc<Instrument>>,
    /// Where in the band, -1/2 to 1/2.
    pub place: Vec<f32>,
    /// Channel width over frequency.
    pub width: Vec<f32>,
    /// Integration time [s].
    pub interval_s: Vec<f32>,
}

impl Extents {
    /// None yet, of samples seen through `instrument`.
    pub fn of(instrument: Option<Arc<Instrument>>) -> Self {
        Self {
            instrument,
            ..Self::default()
        }
    }

    /// Bytes that a sample takes.
    pub fn sample_bytes(&self) -> usize {
        self.instrument.as_ref().map_or(0, |_| 3 * size_of::<f32>())
    }

    /// Adds a sample.
    pub fn push(&mut self, extent: Extent) {
        if let Some(instrument) = &self.instrument {
            self.place.push(instrument.place(extent.freq_hz) as f32);
            // Without smearing they may not even be known.
            let (width, interval_s) = match instrument.smearing {
                Some(_) => (extent.width_hz / extent.freq_hz, extent.interval_s),
                None => (0.0, 0.0),
            };
            self.width.push(width as f32);
            self.interval_s.push(interval_s as f32);
        }
    }

    /// Adds the samples of `range` of `other`.
    pub(super) fn extend_from(&mut self, other: &Self, range: Range<usize>) {
        if other.instrument.is_some() {
            self.instrument.clone_from(&other.instrument);
            self.place.extend_from_slice(&other.place[range.clone()]);
            self.width.extend_from_slice(&other.width[range.clone()]);
            self.interval_s.extend_from_slice(&other.interval_s[range]);
        }
    }

    /// Becomes the same as `other`, in the room that it has.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.instrument.clone_from(&other.instrument);
        self.place.clone_from(&other.place);
        self.width.clone_from(&other.width);
        self.interval_s.clone_from(&other.interval_s);
    }

    /// The samples number `which`, in that order.
    pub(super) fn select(&self, which: &[u32]) -> Self {
        if self.instrument.is_none() {
            return Self::default();
        }
        let of = |from: &[f32]| which.iter().map(|&k| from[k as usize]).collect();
        Self {
            instrument: self.instrument.clone(),
            place: of(&self.place),
            width: of(&self.width),
            interval_s: of(&self.interval_s),
        }
    }

    /// The factors of a source; none where there are no terms.
    pub(super) fn gain(&self, ray: Ray) -> Option<Gain> {
        self.instrument.as_ref().map(|i| Gain::new(i, ray))
    }

    /// True where there is smearing.
    pub(super) fn are_smeared(&self) -> bool {
        let instrument = self.instrument.as_ref();
        instrument.is_some_and(|i| i.smearing.is_some())
    }

    /// [`Extent::blur`] of sample `k`.
    pub(super) fn blur(&self, k: usize) -> f64 {
        f64::from(self.width[k]) + EARTH_RAD_PER_S * f64::from(self.interval_s[k])
    }

    /// Frequency in the middle of sample `k` [Hz].
    #[cfg(test)]
    pub(super) fn freq_hz(&self, k: usize) -> f64 {
        let place = f64::from(self.place[k]);
        self.instrument
            .as_ref()
            .map_or(f64::NAN, |i| i.freq_hz(place))
    }

    /// The factor of a source for sample `k` on the baseline `uvw` [wavelength], in f64 as the
    /// formulas stand; 1 where there are no terms.
    pub(super) fn factor(&self, k: usize, ray: Ray, uvw: [f64; 3]) -> f64 {
        self.instrument.as_ref().map_or(1.0, |instrument| {
            let freq_hz = instrument.freq_hz(f64::from(self.place[k]));
            let extent = Extent {
                freq_hz,
                width_hz: f64::from(self.width[k]) * freq_hz,
                interval_s: f64::from(self.interval_s[k]),
            };
            instrument.factor(ray, uvw, extent)
        })
    }
}

/// The factors s_k of a source, in single precision: within 3e-6 of [`Instrument::factor`] where
/// brightness is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gain {
    /// Phase and its rate [turn, turn/s] for each wavelength of baseline; 0 without smearing.
    turns: [f32; 3],
    turns_per_s: [f32; 3],
    /// Brightness as a polynomial of the place in the band.
    brightness: [f32; TERMS],
}

impl Gain {
    fn new(instrument: &Instrument, ray: Ray) -> Self {
        let at = |place: f64| instrument.brightness(ray, instrument.freq_hz(place));
        let (turns, turns_per_s) = match instrument.smearing {
            Some(smearing) => (Smearing::turns(ray.lm), smearing.turns_per_s(ray.lm)),
            None => ([0.0; 3], [0.0; 3]),
        };
        Self {
            turns: turns.map(|x| x as f32),
            turns_per_s: turns_per_s.map(|x| x as f32),
            brightness: crate::polynomial::fit::<TERMS>(at).map(|c| c as f32),
        }
    }

    /// s on the baseline (u, v, w) [wavelength] of a sample of this extent.
    #[inline(always)]
    pub(super) fn at(&self, [u, v, w]: [f32; 3], [place, width, interval_s]: [f32; 3]) -> f32 {
        let ([a, b, c], [d, e, f]) = (self.turns, self.turns_per_s);
        let mut brightness = 0.0;
        for i in (0..TERMS).rev() {
            brightness = brightness * place + self.brightness[i];
        }
        brightness
            * sinc((a * u + b * v + c * w) * width)
            * sinc((d * u + e * v + f * w) * interval_s)
    }
}

/// sin(πx)/(πx) for |x| below 4e6.
#[inline(always)]
fn sinc(x: f32) -> f32 {
    // 1.5 x 2^23: adding it rounds to a whole number, whose parity is then the lowest bit
    const ROUND: f32 = 12_582_912.0;
    let rounded = x + ROUND;
    let rest = x - (rounded - ROUND);
    let sine = rest * horner(&SQRT2_SIN_PI, rest * rest);
    let sine = f32::from_bits(sine.to_bits() ^ (rounded.to_bits() << 31));
    let below = x * (SQRT_2 * PI) as f32;
    if x == 0.0 { 1.0 } else { sine / below }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coords::Lm;
    use crate::likelihood::samples::instrument;
    use crate::rime;

    #[test]
    fn the_fast_sinc_is_good_to_single_precision() {
        for i in -40_000..40_000 {
            let x = i as f32 * 1.37e-4;
            let error = f64::from(sinc(x)) - rime::sinc(f64::from(x));
            assert!(error.abs() < 2e-7, "{x}: {error:e}");
        }
        assert_eq!((sinc(0.0), sinc(1e-30)), (1.0, 1.0));
    }

    /// Over an octave, as far out as beams are worth anything.
    #[test]
    fn fast_factors_follow_the_formulas() {
        for beam in ["meerkat", "airy=13.5m", "gaussian=13.5m"] {
            let instrument = Arc::new(instrument(beam));
            for (rho, tilt) in [(0.0, 1.5), (0.005, -1.5), (0.012, 0.3), (0.02, 0.0)] {
                let lm = Lm {
                    l: 0.6 * rho,
                    m: -0.8 * rho,
                };
                let ray = Ray { lm, tilt };
                let mut extents = Extents::of(Some(instrument.clone()));
                let gain = extents.gain(ray).unwrap();
                for k in 0..200 {
                    let freq_hz = 0.86e9 * 2f64.powf(f64::from(k) / 199.0);
                    let t = f64::from(k);
                    let uvw = [90.0 * t, 30_000.0 - 170.0 * t, 40.0 * t];
                    extents.push(Extent {
                        freq_hz,
                        width_hz: 13e6,
                        interval_s: 8.0,
                    });
                    let k = k as usize;
                    let extent = [extents.place[k], extents.width[k], extents.interval_s[k]];
                    let got = f64::from(gain.at(uvw.map(|x| x as f32), extent));
                    let error = got - extents.factor(k, ray, uvw);
                    assert!(error.abs() < 3e-6, "{beam} {rho} {k}: {got} {error:e}");
                }
            }
        }
    }
}
