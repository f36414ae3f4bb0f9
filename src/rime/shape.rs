//! Source shapes: the factor F(u, v) of a source of unit flux density.

/// Ellipticity (e1, e2), |e| = (a - b)/(a + b); the major axis lies at atan2(e2, e1)/2 from l
/// (east) towards m (north).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ellipticity {
    /// Stretch along l (positive) or m (negative).
    pub e1: f64,
    /// Stretch along the diagonals.
    pub e2: f64,
}

/// Family of radial profiles.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Exponential (Sersic n = 1) disk: F = (1 + 4π²α²k²)^(-3/2), α the scale-length.
    #[default]
    Exponential,
    /// Gaussian: F = exp(-2π²α²k²), α the standard deviation.
    Gaussian,
    /// Point: F = 1.
    Point,
}
