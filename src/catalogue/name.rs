//! The name of a source after its position.

use crate::coords::RaDec;
use crate::units::{ARCSEC, DEG};

/// Acronym in front of the names, unless the configuration gives another.
pub const ACRONYM: &str = "V2C";

/// The part of the last digit by which a coordinate may fall short of a round value and still be
/// taken for it: a microarcsecond or less, the rounding of degrees to radians and back.
const ROUNDING: f64 = 1e-6;

/// `V2C J123456.78-012345.6`: acronym, then right ascension [h m s] and declination [deg ' "], both
/// **truncated** to the digits shown, never rounded, so that the name survives better positions.
///
/// # Source
/// IAU Commission 5, "Specifications concerning designations for astronomical radiation sources
/// outside the solar system", sections 3.2.3 and 3.2.5.
pub fn source_name(acronym: &str, position: RaDec) -> String {
    let centiseconds = truncated(position.ra_rad.rem_euclid(std::f64::consts::TAU) / DEG * 24000.0);
    let centiseconds = centiseconds % (24 * 360_000);
    let tenths = truncated(position.dec_rad.abs() / ARCSEC * 10.0);
    let sign = if position.dec_rad.is_sign_negative() {
        '-'
    } else {
        '+'
    };
    let (seconds, ra_fraction) = (centiseconds / 100, centiseconds % 100);
    let (arcsec, dec_fraction) = (tenths / 10, tenths % 10);
    let [hour, minute, second] = base60(seconds);
    let [degree, arcmin, arcsec] = base60(arcsec);
    format!(
        "{acronym} J{hour:02}{minute:02}{second:02}.{ra_fraction:02}\
         {sign}{degree:02}{arcmin:02}{arcsec:02}.{dec_fraction}"
    )
}

fn truncated(units: f64) -> u64 {
    (units + ROUNDING).floor() as u64
}

fn base60(seconds: u64) -> [u64; 3] {
    [seconds / 3600, seconds / 60 % 60, seconds % 60]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(ra_deg: f64, dec_deg: f64) -> String {
        let position = RaDec {
            ra_rad: ra_deg * DEG,
            dec_rad: dec_deg * DEG,
        };
        source_name(ACRONYM, position)
    }

    #[test]
    fn coordinates_are_truncated_and_not_rounded() {
        // 23h59m59.999s must become neither 23h59m60.00s nor 00h.
        let ra = (24.0 - 0.001 / 3600.0) * 15.0;
        assert_eq!(name(ra, -29.9999999), "V2C J235959.99-295959.9");
        assert_eq!(name(188.73658, 1.5), "V2C J123456.77+013000.0");
    }

    #[test]
    fn a_degree_of_minus_zero_keeps_its_sign() {
        assert_eq!(name(0.0, -0.5 / 60.0), "V2C J000000.00-000030.0");
        assert_eq!(name(0.0, 0.5 / 60.0), "V2C J000000.00+000030.0");
    }

    #[test]
    fn round_coordinates_stay_round() {
        for hour in 0..24 {
            let text = name(f64::from(hour) * 15.0, f64::from(hour));
            assert_eq!(text, format!("V2C J{hour:02}0000.00+{hour:02}0000.0"));
        }
        assert_eq!(name(360.0, 90.0), "V2C J000000.00+900000.0");
        assert_eq!(name(-15.0, -90.0), "V2C J230000.00-900000.0");
    }

    #[test]
    fn the_acronym_is_the_callers() {
        let name = source_name("SKAD", RaDec::default());
        assert_eq!(name, "SKAD J000000.00+000000.0");
    }
}
