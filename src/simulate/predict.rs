//! What the sources add to the channels of a baseline.
//!
//! A plain version in f64, one row at a time.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::rime::{Source, shape::Profile};
use crate::units::SPEED_OF_LIGHT;

/// A source, ready to be evaluated at many (u, v, w) in metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Component {
    flux_jy: f64,
    /// Delay per metre of (u, v, w): (l, m, n - 1)/c [s/m].
    delay_s_per_m: [f64; 3],
    /// The shape's quadratic form in (u, v): 4π²α²(k1² + k2²) f⁻² = a u² + b u v + c v² [s²/m²].
    form: [f64; 3],
    profile: Profile,
}

impl Component {
    /// The component of `source` with `profile`.
    ///
    /// # Formula
    /// ```text
    /// k1 = ((1+e1) u + e2 v)/det     k2 = (e2 u + (1-e1) v)/det     det = 1 - e1² - e2²
    /// ```
    pub(super) fn new(source: &Source, profile: Profile) -> Self {
        let (e1, e2) = (source.e.e1, source.e.e2);
        let det = 1.0 - e1 * e1 - e2 * e2;
        let alpha_rad = if profile == Profile::Point {
            0.0
        } else {
            source.scale_rad
        };
        let scale = (TAU * alpha_rad / (det * SPEED_OF_LIGHT)).powi(2);
        let (p, q) = (1.0 + e1, 1.0 - e1);
        Self {
            flux_jy: source.flux_jy,
            delay_s_per_m: [source.lm.l, source.lm.m, source.lm.n_minus_1()]
                .map(|x| x / SPEED_OF_LIGHT),
            form: [
                scale * (p * p + e2 * e2),
                scale * 2.0 * e2 * (p + q),
                scale * (e2 * e2 + q * q),
            ],
            profile,
        }
    }

    /// Adds the component to `vis_jy_f`, the channels `freq_hz_f` of a baseline, and returns the sum
    /// of F² over them.
    ///
    /// # Formula
    /// `V = S F(u, v) exp(+2πi (u l + v m + w (n - 1)))`, see [`vis2cat_formats`].
    pub(super) fn add_to(
        &self,
        uvw_m: [f64; 3],
        freq_hz_f: &[f64],
        vis_jy_f: &mut [Complex<f64>],
    ) -> f64 {
        let [u_m, v_m, w_m] = uvw_m;
        let [l, m, n_minus_1] = self.delay_s_per_m;
        let [a, b, c] = self.form;
        let delay_s = u_m * l + v_m * m + w_m * n_minus_1;
        let form_s2 = a * u_m * u_m + b * u_m * v_m + c * v_m * v_m;
        let mut sum_f2 = 0.0;
        for (vis_jy, &freq_hz) in vis_jy_f.iter_mut().zip(freq_hz_f) {
            let factor = attenuation(self.profile, form_s2 * freq_hz * freq_hz);
            let cycles = delay_s * freq_hz;
            let (sin, cos) = (TAU * (cycles - cycles.round())).sin_cos();
            let amplitude_jy = self.flux_jy * factor;
            vis_jy.re += amplitude_jy * cos;
            vis_jy.im += amplitude_jy * sin;
            sum_f2 += factor * factor;
        }
        sum_f2
    }
}

/// F as a function of x = 4π²α²(k1² + k2²).
fn attenuation(profile: Profile, x: f64) -> f64 {
    match profile {
        Profile::Exponential => {
            let t = 1.0 + x;
            1.0 / (t * t.sqrt())
        }
        Profile::Gaussian => (-0.5 * x).exp(),
        Profile::Point => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coords::Lm;
    use crate::rime::shape::Ellipticity;
    use crate::units::ARCSEC;
    use std::f64::consts::PI;

    fn source() -> Source {
        Source {
            lm: Lm { l: 2e-3, m: -1e-3 },
            flux_jy: 3e-3,
            scale_rad: 1.5 * ARCSEC,
            e: Ellipticity { e1: 0.3, e2: -0.2 },
        }
    }

    /// The formulas of the method, letter by letter, in wavelengths.
    fn by_definition(s: &Source, profile: Profile, u: f64, v: f64, w: f64) -> Complex<f64> {
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
        let n = (1.0 - s.lm.l.powi(2) - s.lm.m.powi(2)).sqrt();
        let phase = TAU * (u * s.lm.l + v * s.lm.m + w * (n - 1.0));
        Complex::from_polar(s.flux_jy * factor, phase)
    }

    #[test]
    fn prediction_follows_the_measurement_equation() {
        let freq_hz_f = [1.3e9, 1.4e9, 1.5e9];
        for profile in [Profile::Exponential, Profile::Gaussian, Profile::Point] {
            let component = Component::new(&source(), profile);
            for uvw_m in [[0.0; 3], [12.0, -700.0, 40.0], [-9000.0, 4000.0, -30000.0]] {
                let mut vis_jy_f = [Complex::default(); 3];
                let sum_f2 = component.add_to(uvw_m, &freq_hz_f, &mut vis_jy_f);
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
