//! The Earth's orientation: UT1-UTC and the pole, day by day.

use super::{SimulateError, format_utc};
use crate::units::ARCSEC;

/// The built-in table; its head says where the numbers come from.
const TABLE: &str = include_str!("earth_orientation.csv");
/// Day of the table's first row (2017-01-01).
const FIRST_MJD: f64 = 57754.0;

/// Orientation of the Earth at one time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Orientation {
    /// UT1-UTC [s].
    pub ut1_utc_s: f64,
    /// Celestial intermediate pole in the terrestrial frame (x, y) [rad].
    pub pole_rad: [f64; 2],
}

/// Daily values of the Earth's orientation, IERS Bulletin B.
#[derive(Debug, Clone, PartialEq)]
pub struct EarthTable {
    days: Vec<Orientation>,
}

impl EarthTable {
    /// The built-in table, 2017-01-01 to 2026-01-02.
    ///
    /// # Errors
    /// Never, unless the program was built with a damaged table.
    pub fn builtin() -> Result<Self, SimulateError> {
        let lines = TABLE.lines().filter(|line| !line.starts_with('#')).skip(1);
        let days = lines.map(parse_day).collect::<Option<Vec<_>>>();
        days.map(|days| Self { days }).ok_or_else(|| {
            SimulateError::parameter("the built-in Earth orientation table is damaged")
        })
    }

    /// First and last day of the table, modified Julian date.
    pub fn range_mjd(&self) -> (f64, f64) {
        let last = self.days.len().saturating_sub(1);
        (FIRST_MJD, FIRST_MJD + last as f64)
    }

    /// The orientation at `mjd` [day, UTC], linear between the days' values (as astropy has it).
    ///
    /// # Errors
    /// The table does not reach that time.
    pub fn at(&self, mjd: f64) -> Result<Orientation, SimulateError> {
        self.interpolate(mjd).ok_or_else(|| {
            let (first, last) = self.range_mjd();
            SimulateError::NoEarthOrientation {
                utc: format_utc(mjd),
                first: format_utc(first),
                last: format_utc(last),
            }
        })
    }

    /// The orientation at `mjd` with UT1-UTC as the user gives it; the pole is that of the table,
    /// and (0, 0), less than 0.6 arcsec wrong, where the table does not reach.
    pub fn with_ut1_utc(&self, mjd: f64, ut1_utc_s: f64) -> Orientation {
        Orientation {
            ut1_utc_s,
            ..self.interpolate(mjd).unwrap_or_default()
        }
    }

    fn interpolate(&self, mjd: f64) -> Option<Orientation> {
        let since = mjd - FIRST_MJD;
        if !(since >= 0.0 && mjd <= self.range_mjd().1) {
            return None;
        }
        let row = (since as usize).min(self.days.len().checked_sub(2)?);
        let part = since - row as f64;
        let (a, b) = (self.days[row], self.days[row + 1]);
        let mix = |a: f64, b: f64| a + part * (b - a);
        Some(Orientation {
            ut1_utc_s: mix(a.ut1_utc_s, b.ut1_utc_s),
            pole_rad: [
                mix(a.pole_rad[0], b.pole_rad[0]),
                mix(a.pole_rad[1], b.pole_rad[1]),
            ],
        })
    }
}

fn parse_day(line: &str) -> Option<Orientation> {
    let mut numbers = line.split(',').map(|text| text.parse::<f64>().ok());
    let mut number = || numbers.next().flatten();
    Some(Orientation {
        ut1_utc_s: number()? * 1e-7,
        pole_rad: [number()? * 1e-6 * ARCSEC, number()? * 1e-6 * ARCSEC],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_bulletin_b() {
        // IERS Bulletin B, 2018-01-01 (MJD 58119) and the day after
        let table = EarthTable::builtin().unwrap();
        let noon = table.at(58119.5).unwrap();
        assert!((noon.ut1_utc_s - 0.5 * (0.216_356_7 + 0.215_588_7)).abs() < 1e-10);
        assert!((noon.pole_rad[0] / ARCSEC - 0.5 * (0.059258 + 0.057424)).abs() < 1e-10);
        assert!((noon.pole_rad[1] / ARCSEC - 0.5 * (0.247585 + 0.248531)).abs() < 1e-10);
    }

    #[test]
    fn the_table_ends_where_it_says() {
        let table = EarthTable::builtin().unwrap();
        let (first, last) = table.range_mjd();
        assert_eq!(format_utc(first), "2017-01-01T00:00:00");
        assert_eq!(format_utc(last), "2026-01-02T00:00:00");
        assert!(table.at(first).is_ok() && table.at(last).is_ok());
        let message = table.at(last + 0.1).unwrap_err().to_string();
        assert!(message.contains("--ut1-utc"), "{message}");
        assert!(table.at(f64::NAN).is_err());
        assert_eq!(table.with_ut1_utc(last + 900.0, 0.1).ut1_utc_s, 0.1);
    }
}
