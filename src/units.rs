//! Unit constants: inside the program everything is Hz, m, s, rad and Jy.

use std::f64::consts::PI;

/// One arcsecond [rad].
pub const ARCSEC: f64 = PI / (180.0 * 3600.0);
/// One degree [rad].
pub const DEG: f64 = PI / 180.0;
/// One microjansky [Jy].
pub const MICROJY: f64 = 1e-6;
/// Speed of light [m/s], exact by definition.
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;
