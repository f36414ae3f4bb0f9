//! Units by which columns of a list may be given.

use std::f64::consts::PI;

use crate::units::{ARCSEC, DEG, MICROJY};

/// What a column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dimension {
    Angle,
    Flux,
    Number,
}

/// What a column measures, and its unit where the file is silent.
#[derive(Debug, Clone, Copy)]
pub(in crate::catalogue) struct Unit {
    dimension: Dimension,
    default: &'static str,
}

/// Angles in radians.
const ANGLES: [(&str, f64); 6] = [
    ("deg", DEG),
    ("degree", DEG),
    ("rad", 1.0),
    ("arcmin", PI / (180.0 * 60.0)),
    ("arcsec", ARCSEC),
    ("mas", ARCSEC * 1e-3),
];
/// Flux densities in janskys; both characters that look like µ.
const FLUXES: [(&str, f64); 6] = [
    ("Jy", 1.0),
    ("mJy", 1e-3),
    ("uJy", MICROJY),
    ("µJy", MICROJY),
    ("μJy", MICROJY),
    ("nJy", 1e-9),
];

impl Unit {
    /// An angle, in `default` where the file is silent.
    pub(in crate::catalogue) const fn angle(default: &'static str) -> Self {
        Self {
            dimension: Dimension::Angle,
            default,
        }
    }

    /// A flux density, in microjanskys where the file is silent.
    pub(in crate::catalogue) const FLUX: Self = Self {
        dimension: Dimension::Flux,
        default: "uJy",
    };

    /// A number, whose unit does not matter.
    pub(in crate::catalogue) const NONE: Self = Self {
        dimension: Dimension::Number,
        default: "",
    };

    /// What turns values in `given` into radians or janskys; or why nothing does.
    pub(in crate::catalogue) fn factor(self, given: Option<&str>) -> Result<f64, String> {
        let given = given.map(str::trim).filter(|u| !u.is_empty());
        let known: &[(&str, f64)] = match self.dimension {
            Dimension::Angle => &ANGLES,
            Dimension::Flux => &FLUXES,
            Dimension::Number => return Ok(1.0),
        };
        let unit = given.unwrap_or(self.default);
        let found = known.iter().find(|(name, _)| *name == unit);
        found.map(|(_, factor)| *factor).ok_or_else(|| {
            let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
            format!("unit {unit:?} is not one of {}", names.join(", "))
        })
    }
}
