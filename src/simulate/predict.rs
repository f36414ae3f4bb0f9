//! What the sources add to the channels of a baseline.
//!
//! A plain version in f64, one row at a time.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::coords::Lm;
use crate::rime::shape::{Profile, QuadraticForm, Shape};
use crate::rime::{Extent, Instrument, Source};
use crate::units::SPEED_OF_LIGHT;

/// A source, ready to be evaluated at many (u, v, w) in metres.
#[derive(Debug, Clone)]
pub(super) struct Component {
    source: Source,
    form: QuadraticForm,
    shape: &'static dyn Shape,
    /// What the primary beam and the spectrum make of it in each channel.
    brightness_f: Vec<f64>,
}

/// The channels, and how a sample of them is observed.
#[derive(Debug, Clone)]
pub(super) struct Look {
    pub(super) freq_hz_f: Vec<f64>,
    pub(super) width_hz: f64,
    pub(super) interval_s: f64,
    pub(super) instrument: Option<Instrument>,
}

impl Look {
    /// The smearing of a source at `lm` on the baseline `uvw_s` [s] at `freq_hz`.
    fn smearing(&self, lm: Lm, uvw_s: [f64; 3], freq_hz: f64) -> f64 {
        self.instrument.as_ref().map_or(1.0, |instrument| {
            let extent = Extent {
                freq_hz,
                width_hz: self.width_hz,
                interval_s: self.interval_s,
            };
            instrument.smearing(lm, uvw_s.map(|s| s * freq_hz), extent)
        })
    }
}

impl Component {
    /// The component of `source` with `profile`.
    pub(super) fn new(source: &Source, profile: Profile, look: &Look) -> Self {
        let brightness = |&freq_hz: &f64| match &look.instrument {
            Some(instrument) => instrument.brightness(source.ray(), freq_hz),
            None => 1.0,
        };
        let form = QuadraticForm::new(source.scale_rad, source.e);
        Self {
            source: *source,
            form,
            shape: profile.shape(),
            brightness_f: look.freq_hz_f.iter().map(brightness).collect(),
        }
    }

    /// Adds the component to `vis_jy_f`, the channels of a baseline, and returns the sum
    /// of F² over them, the factors of the instrument included.
    ///
    /// # Formula
    /// That of [`crate::rime::predict`]. Phase and the
    /// square root of q grow with the frequency, so both are worked out once a baseline.
    pub(super) fn add_to(
        &self,
        uvw_m: [f64; 3],
        look: &Look,
        vis_jy_f: &mut [Complex<f64>],
    ) -> f64 {
        let [u_s, v_s, w_s] = uvw_m.map(|metres| metres / SPEED_OF_LIGHT);
        let lm = self.source.lm;
        let delay_s = u_s * lm.l + v_s * lm.m + w_s * lm.n_minus_1();
        let [u_seen_s, v_seen_s] = lm.uv_seen(u_s, v_s, w_s);
        let q_s2 = self.form.at(u_seen_s, v_seen_s);
        let mut sum_f2 = 0.0;
        let channels = look.freq_hz_f.iter().zip(&self.brightness_f);
        for (vis_jy, (&freq_hz, brightness)) in vis_jy_f.iter_mut().zip(channels) {
            let gain = brightness * look.smearing(lm, [u_s, v_s, w_s], freq_hz);
            let factor = gain * self.shape.factor(q_s2 * freq_hz * freq_hz);
            let cycles = delay_s * freq_hz;
            let (sin, cos) = (TAU * (cycles - cycles.round())).sin_cos();
            let amplitude_jy = self.source.flux_jy * factor;
            vis_jy.re += amplitude_jy * cos;
            vis_jy.im += amplitude_jy * sin;
            sum_f2 += factor * factor;
        }
        sum_f2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rime::shape::Ellipticity;
    use crate::units::ARCSEC;
    use std::f64::consts::PI;

    fn source() -> Source {
        Source {
            lm: Lm { l: 2e-3, m: -1e-3 },
            flux_jy: 3e-3,
            scale_rad: 1.5 * ARCSEC,
            e: Ellipticity { e1: 0.3, e2: -0.2 },
            tilt: 0.0,
        }
    }

    /// The formulas of the method, letter by letter, in wavelengths.
    fn by_definition(s: &Source, profile: Profile, u: f64, v: f64, w: f64) -> Complex<f64> {
        let n = (1.0 - s.lm.l.powi(2) - s.lm.m.powi(2)).sqrt();
        let phase = TAU * (u * s.lm.l + v * s.lm.m + w * (n - 1.0));
        let (u, v) = (u - w * s.lm.l / n, v - w * s.lm.m / n);
        let (e1, e2) = (s.e.e1, s.e.e2);
        let det = 1.0 - e1 * e1 - e2 * e2;
        let k1 = ((1.0 + e1) * u + e2 * v) / det;
        let k2 = (e2 * u + (1.0 - e1) * v) / det;
        let k2_sum = k1 * k1 + k2 * k2;
        let factor = match profile {
            Profile::Exponential => (1.0 + 4.0 * PI * PI * s.scale_rad.powi(2) * k2_sum).powf(-1.5),
            Profile::Gaussian => (-2.0 * PI * PI * s.scale_rad.powi(2) * k2_sum).exp(),
            Profile::Point => 1.0,
        };
        Complex::from_polar(s.flux_jy * factor, phase)
    }

    #[test]
    fn prediction_follows_the_measurement_equation() {
        let freq_hz_f = [1.3e9, 1.4e9, 1.5e9];
        for profile in [Profile::Exponential, Profile::Gaussian, Profile::Point] {
            let look = Look {
                freq_hz_f: freq_hz_f.to_vec(),
                width_hz: 0.0,
                interval_s: 0.0,
                instrument: None,
            };
            let component = Component::new(&source(), profile, &look);
            for uvw_m in [[0.0; 3], [12.0, -700.0, 40.0], [-9000.0, 4000.0, -30000.0]] {
                let mut vis_jy_f = [Complex::default(); 3];
                let sum_f2 = component.add_to(uvw_m, &look, &mut vis_jy_f);
                let mut expected_f2 = 0.0;
                for (vis_jy, freq_hz) in vis_jy_f.iter().zip(freq_hz_f) {
                    let [u, v, w] = uvw_m.map(|x| x * freq_hz / SPEED_OF_LIGHT);
                    let expected = by_definition(&source(), profile, u, v, w);
                    assert!((vis_jy - expected).norm() < 1e-12, "{profile:?} {uvw_m:?}");
                    expected_f2 += (expected.norm() / 3e-3).powi(2);
                }
                assert!((sum_f2 - expected_f2).abs() < 1e-12);
            }
        }
    }
}
