//! Numbers with units, as users type them. Inside the program everything is Hz, m, s, rad and Jy.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// One arcsecond [rad].
pub const ARCSEC: f64 = PI / (180.0 * 3600.0);
/// One degree [rad].
pub const DEG: f64 = PI / 180.0;
/// One microjansky [Jy].
pub const MICROJY: f64 = 1e-6;
/// Speed of light [m/s], exact by definition.
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;

/// A text that should be a number with a unit, and is not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{text}' is not {kind}; write a number and a unit, as in {example} (units: {units})")]
pub struct UnitError {
    text: String,
    kind: &'static str,
    example: &'static str,
    units: String,
}

/// The units of a kind of quantity, the one it is displayed in first.
struct Kind {
    name: &'static str,
    example: &'static str,
    units: &'static [(&'static str, f64)],
}

impl Kind {
    fn error(&self, text: &str) -> UnitError {
        let units = self
            .units
            .iter()
            .map(|(name, _)| *name)
            .collect::<Vec<_>>()
            .join(", ");
        UnitError {
            text: text.to_owned(),
            kind: self.name,
            example: self.example,
            units,
        }
    }

    fn parse(&self, text: &str) -> Result<f64, UnitError> {
        let text = text.trim();
        let by_length = |(name, _): &&(&str, f64)| std::cmp::Reverse(name.len());
        let mut units: Vec<_> = self.units.iter().collect();
        units.sort_by_key(by_length);
        let (number, factor) = units
            .iter()
            .find_map(|(name, factor)| text.strip_suffix(name).map(|number| (number, *factor)))
            .ok_or_else(|| self.error(text))?;
        let value: f64 = number.trim().parse().map_err(|_| self.error(text))?;
        if value.is_finite() {
            Ok(value * factor)
        } else {
            Err(self.error(text))
        }
    }

    fn display(&self, value: f64, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, factor) = self.units[0];
        // Twelve digits hide the last bit that the conversion of units costs.
        let shown: f64 = format!("{:.12e}", value / factor)
            .parse()
            .unwrap_or(value / factor);
        write!(f, "{shown}{unit}")
    }
}

/// Gives a newtype over f64 its units: parsing, display, serde as text.
macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $kind:ident, $text:expr, $example:expr, $units:expr) => {
        const $kind: Kind = Kind { name: $text, example: $example, units: $units };

        $(#[$doc])*
        #[derive(Debug, Clone, Copy, Default, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl FromStr for $name {
            type Err = UnitError;
            fn from_str(text: &str) -> Result<Self, UnitError> {
                $kind.parse(text).map(Self)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                $kind.display(self.0, f)
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
                s.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                String::deserialize(d)?.parse().map_err(serde::de::Error::custom)
            }
        }
    };
}

quantity!(
    /// An angle [rad].
    Angle, ANGLE, "an angle", "0.5arcsec",
    &[("arcsec", ARCSEC), ("deg", DEG), ("arcmin", 60.0 * ARCSEC), ("mas", 1e-3 * ARCSEC),
      ("rad", 1.0), ("\"", ARCSEC), ("'", 60.0 * ARCSEC)]
);
quantity!(
    /// A flux density [Jy].
    Flux, FLUX, "a flux density", "10uJy",
    &[("uJy", MICROJY), ("mJy", 1e-3), ("Jy", 1.0), ("nJy", 1e-9), ("µJy", MICROJY), ("μJy", MICROJY)]
);
quantity!(
    /// A frequency [Hz].
    Frequency, FREQUENCY, "a frequency", "1.4GHz",
    &[("MHz", 1e6), ("GHz", 1e9), ("kHz", 1e3), ("Hz", 1.0)]
);
quantity!(
    /// A length of time [s].
    Duration, DURATION, "a length of time", "60s",
    &[("s", 1.0), ("ms", 1e-3), ("min", 60.0), ("h", 3600.0), ("d", 86400.0)]
);
quantity!(
    /// A length [m].
    Length, LENGTH, "a length", "13.5m",
    &[("m", 1.0), ("km", 1e3), ("cm", 1e-2)]
);
quantity!(
    /// An amount of memory [byte].
    Memory, MEMORY, "an amount of memory", "512MB",
    &[("MB", 1e6), ("kB", 1e3), ("GB", 1e9), ("TB", 1e12), ("KiB", 1024.0), ("MiB", 1_048_576.0),
      ("GiB", 1_073_741_824.0)]
);

/// A range `LOW:HIGH` of a quantity, both ends with their unit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Range<T> {
    /// Lower end.
    pub low: T,
    /// Upper end.
    pub high: T,
}

/// A text that should be a range, and is not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RangeError {
    /// No colon.
    #[error("'{0}' is not a range; write LOW:HIGH, as in 10uJy:200uJy")]
    NoColon(String),
    /// The upper end is not above the lower one.
    #[error("'{0}' is empty: the upper end must lie above the lower one")]
    Empty(String),
    /// An end is no quantity.
    #[error(transparent)]
    End(#[from] UnitError),
}

impl<T: FromStr<Err = UnitError> + PartialOrd> FromStr for Range<T> {
    type Err = RangeError;
    fn from_str(text: &str) -> Result<Self, RangeError> {
        let (low, high) = text
            .split_once(':')
            .ok_or_else(|| RangeError::NoColon(text.into()))?;
        let range = Self {
            low: low.parse()?,
            high: high.parse()?,
        };
        if range.low < range.high {
            Ok(range)
        } else {
            Err(RangeError::Empty(text.into()))
        }
    }
}

impl<T: fmt::Display> fmt::Display for Range<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.low, self.high)
    }
}

impl<T: fmt::Display> Serialize for Range<T> {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_str(self)
    }
}

impl<'de, T: FromStr<Err = UnitError> + PartialOrd> Deserialize<'de> for Range<T> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        String::deserialize(d)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_parse_with_their_units() {
        assert_eq!("10uJy".parse::<Flux>().unwrap().0, 10.0 * MICROJY);
        assert_eq!("0.5 arcsec".parse::<Angle>().unwrap().0, 0.5 * ARCSEC);
        assert_eq!("-30deg".parse::<Angle>().unwrap().0, -30.0 * DEG);
        assert_eq!("2min".parse::<Duration>().unwrap().0, 120.0);
        assert_eq!("1ms".parse::<Duration>().unwrap().0, 1e-3);
        assert_eq!("512MB".parse::<Memory>().unwrap().0, 512e6);
    }

    #[test]
    fn a_number_without_unit_names_the_units() {
        let text = "10".parse::<Flux>().unwrap_err().to_string();
        assert!(text.contains("uJy") && text.contains("'10'"), "{text}");
        assert!("nandeg".parse::<Angle>().is_err());
        assert!("10 parsec".parse::<Angle>().is_err());
    }

    #[test]
    fn ranges_need_two_ordered_ends() {
        let flux: Range<Flux> = "10uJy:0.2mJy".parse().unwrap();
        assert_eq!(flux.to_string(), "10uJy:200uJy");
        assert!("200uJy:10uJy".parse::<Range<Flux>>().is_err());
        assert!("200uJy".parse::<Range<Flux>>().is_err());
    }

    #[test]
    fn display_parses_back_to_the_same_value() {
        for text in ["0.1arcsec", "3600arcsec", "1e-7arcsec"] {
            let angle: Angle = text.parse().unwrap();
            let back: Angle = angle.to_string().parse().unwrap();
            assert!((back.0 - angle.0).abs() <= 1e-12 * angle.0.abs());
        }
    }
}
