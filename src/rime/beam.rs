//! The primary beam: what a dish takes off the flux density of a source away from where it points.
//!
//! Attenuation of power, round and the same for both hands, centred on the phase centre. FITS images of
//! beams are not read.

use super::smearing::sinc;
use crate::coords::Lm;
use crate::units::{DEG, Length, SPEED_OF_LIGHT, UnitError};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::f64::consts::{FRAC_PI_4, LN_2, PI};
use std::str::FromStr;

/// A primary beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beam {
    /// MeerKAT in L band: the power of a cosine-tapered field,
    ///
    /// ```text
    /// A = [cos(1.189 π x) / (1 - 4 (1.189 x)²)]²      x = ρ/θ      θ = 57.5' (1.5 GHz/ν)
    /// ```
    ///
    /// with θ the full width at half maximum.
    ///
    /// # Source
    /// Mauch et al. (2020), ApJ 888, 61, equations 3 and 4.
    MeerKat,
    /// A uniformly lit, unblocked dish of this diameter: A = [2 J1(y)/y]², y = π D sin(ρ)/λ.
    Airy(Length),
    /// A Gaussian as wide at half maximum as the [`Beam::Airy`] of this diameter, 1.029 λ/D.
    Gaussian(Length),
}

/// Argument of [2 J1(y)/y]² = 1/2; 2/π of it is 1.0290, the width of an Airy disk in λ/D.
const AIRY_HALF: f64 = 1.616_339_948_310_703;

impl Beam {
    /// A at direction `lm` and `freq_hz` [Hz]: 1 at the phase centre.
    pub fn power(self, lm: Lm, freq_hz: f64) -> f64 {
        let sin_rho = lm.distance(Lm::default());
        match self {
            Self::MeerKat => {
                let width_rad = 57.5 / 60.0 * DEG * 1.5e9 / freq_hz;
                let x = 1.189 * sin_rho.asin() / width_rad;
                // cos πx / (1 - 4x²), which is 0/0 at x = 1/2
                let field = FRAC_PI_4 * sinc(0.5 - x) / (0.5 + x);
                field * field
            }
            Self::Airy(diameter) => {
                let y = PI * diameter.0 * sin_rho * freq_hz / SPEED_OF_LIGHT;
                if y < 1e-4 {
                    return 1.0 - 0.25 * y * y;
                }
                (2.0 * puruspe::Jn(1, y) / y).powi(2)
            }
            Self::Gaussian(diameter) => {
                let half_rad = AIRY_HALF / PI * SPEED_OF_LIGHT / (freq_hz * diameter.0);
                (-LN_2 * (sin_rho.asin() / half_rad).powi(2)).exp()
            }
        }
    }
}

/// A text that names no beam.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BeamError {
    /// None of the words.
    #[error("'{0}' is no beam; use meerkat, airy=13.5m or gaussian=13.5m, or none")]
    Unknown(String),
    /// The diameter is no length.
    #[error(transparent)]
    Diameter(#[from] UnitError),
    /// The diameter is zero or below.
    #[error("a dish of diameter {0} has no beam")]
    NoDish(Length),
}

impl FromStr for Beam {
    type Err = BeamError;
    fn from_str(text: &str) -> Result<Self, BeamError> {
        let diameter = |text: &str| -> Result<Length, BeamError> {
            let diameter: Length = text.parse()?;
            if diameter.0 > 0.0 {
                Ok(diameter)
            } else {
                Err(BeamError::NoDish(diameter))
            }
        };
        match text.split_once('=') {
            None if text == "meerkat" => Ok(Self::MeerKat),
            Some(("airy", text)) => Ok(Self::Airy(diameter(text)?)),
            Some(("gaussian", text)) => Ok(Self::Gaussian(diameter(text)?)),
            _ => Err(BeamError::Unknown(text.into())),
        }
    }
}

impl std::fmt::Display for Beam {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::MeerKat => f.write_str("meerkat"),
            Self::Airy(diameter) => write!(f, "airy={diameter}"),
            Self::Gaussian(diameter) => write!(f, "gaussian={diameter}"),
        }
    }
}

impl Serialize for Beam {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Beam {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        String::deserialize(d)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(deg: f64) -> Lm {
        let [sin, cos] = [0.6, 0.8];
        let rho = (deg * DEG).sin();
        Lm {
            l: rho * sin,
            m: -rho * cos,
        }
    }

    #[test]
    fn meerkat_has_the_published_width_and_its_formula() {
        assert!((Beam::MeerKat.power(at(0.0), 1.5e9) - 1.0).abs() < 1e-12);
        let half = Beam::MeerKat.power(at(0.5 * 57.5 / 60.0), 1.5e9);
        assert!((half - 0.5).abs() < 2e-4, "{half}");
        // Half as high a frequency sees twice as far.
        let low = Beam::MeerKat.power(at(57.5 / 60.0), 0.75e9);
        assert!((low - half).abs() < 1e-9);
        for deg in [0.2, 0.7, 0.9, 1.4] {
            let x = 1.189 * deg * 60.0 / (57.5 * 1.5e9 / 1.28e9);
            let field = (PI * x).cos() / (1.0 - 4.0 * x * x);
            let power = Beam::MeerKat.power(at(deg), 1.28e9);
            assert!((power - field * field).abs() < 1e-12, "{deg}: {power}");
        }
        // x = 1/2, where the formula is 0/0: (π/4)².
        let x = Beam::MeerKat.power(at(57.5 / 60.0 * 0.5 / 1.189), 1.5e9);
        assert!((x - FRAC_PI_4 * FRAC_PI_4).abs() < 1e-9);
    }

    /// The disk summed point by point: its far field is what 2 J1(y)/y stands for.
    #[test]
    fn airy_is_the_far_field_of_a_disk() {
        let beam = Beam::Airy(Length(13.5));
        let n = 600;
        for deg in [0.0, 0.3, 0.7, 1.5] {
            let (mut sum, mut count) = (0.0, 0.0);
            for i in -n..=n {
                for j in -n..=n {
                    let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    if x * x + y * y <= 1.0 {
                        let metres = 0.5 * 13.5 * x;
                        let turns = metres * (deg * DEG).sin() * 1.28e9 / SPEED_OF_LIGHT;
                        sum += (2.0 * PI * turns).cos();
                        count += 1.0;
                    }
                }
            }
            let field: f64 = sum / count;
            let power = beam.power(at(deg), 1.28e9);
            assert!((power - field * field).abs() < 2e-4, "{deg}: {power}");
        }
    }

    #[test]
    fn the_gaussian_is_as_wide_as_the_airy_disk() {
        let half_deg = 0.5 * 1.028_99 * SPEED_OF_LIGHT / 1.28e9 / 25.0 / DEG;
        for beam in [Beam::Airy(Length(25.0)), Beam::Gaussian(Length(25.0))] {
            let power = beam.power(at(half_deg), 1.28e9);
            assert!((power - 0.5).abs() < 1e-4, "{beam}: {power}");
        }
        let twice = Beam::Gaussian(Length(25.0)).power(at(2.0 * half_deg), 1.28e9);
        assert!((twice - 0.0625).abs() < 1e-4);
    }

    #[test]
    fn beams_are_read_as_they_are_written() {
        for text in ["meerkat", "airy=13.5m", "gaussian=25m"] {
            assert_eq!(text.parse::<Beam>().unwrap().to_string(), text);
        }
        for text in ["vla", "airy", "airy=13.5", "gaussian=0m", "meerkat=13.5m"] {
            assert!(text.parse::<Beam>().is_err(), "{text}");
        }
    }
}
