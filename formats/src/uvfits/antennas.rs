//! The `AIPS AN` tables: antennas, one table a subarray.
//!
//! # Source
//! Memo, section 4.1.

use std::fs::File;

use crate::date;
use crate::fits::Table;
use crate::fits::header::{Header, Place};
use crate::fits::scan::Hdu;
use crate::{Antenna, EarthOrientation, ReadError, TimeScale};

/// All antennas of a file, and how its rows name them.
#[derive(Debug, Clone, Default)]
pub(super) struct Antennas {
    pub(super) list: Vec<Antenna>,
    /// (subarray and number, index into `list`), sorted.
    index: Vec<(u64, u32)>,
}

/// What the header of the first antenna table says about the whole file.
#[derive(Debug, Clone, Default)]
pub(super) struct ArrayHeader {
    pub(super) name: String,
    pub(super) position_m: [f64; 3],
    pub(super) time_scale: TimeScale,
    pub(super) earth: EarthOrientation,
    /// RDATE, where it is a day.
    pub(super) reference_day: Option<String>,
}

impl Antennas {
    /// Index of the antenna that a row names; `None` where no table has it.
    pub(super) fn find(&self, subarray: u32, number: u32) -> Option<u32> {
        let key = key(subarray, number);
        // Mostly numbers follow one another.
        let guess = key.wrapping_sub(self.index.first()?.0) as usize;
        if let Some((there, at)) = self.index.get(guess)
            && *there == key
        {
            return Some(*at);
        }
        let at = self
            .index
            .binary_search_by_key(&key, |entry| entry.0)
            .ok()?;
        Some(self.index[at].1)
    }

    /// Reads every antenna table of the file.
    pub(super) fn read(
        file: &mut File,
        hdus: &[Hdu],
        warnings: &mut Vec<String>,
    ) -> Result<(Self, ArrayHeader), ReadError> {
        let whole = Place::file(&hdus[0].header.place.path);
        let mut antennas = Self::default();
        let mut first = None;
        for (i, hdu) in hdus
            .iter()
            .filter(|hdu| hdu.is_named("AIPS AN"))
            .enumerate()
        {
            let header = &hdu.header;
            let subarray = header.integer("EXTVER")?.unwrap_or(i as i64 + 1);
            let subarray = u32::try_from(subarray)
                .map_err(|_| header.place.malformed("EXTVER", "is no subarray number"))?;
            antennas.read_table(file, hdu, subarray, warnings)?;
            if first.is_none() {
                first = Some(array_header(header, warnings)?);
            }
        }
        let Some(first) = first else {
            let what = "there is no antenna table; the file may be truncated";
            return Err(whole.malformed("AIPS AN", what));
        };
        antennas.index.sort_unstable();
        if let Some(pair) = antennas
            .index
            .windows(2)
            .find(|pair| pair[0].0 == pair[1].0)
        {
            let (subarray, number) = (pair[0].0 >> 32, pair[0].0 & 0xffff_ffff);
            let what = format!("antenna {number} of subarray {subarray} stands there twice");
            return Err(whole.malformed("AIPS AN: NOSTA", what));
        }
        Ok((antennas, first))
    }

    fn read_table(
        &mut self,
        file: &mut File,
        hdu: &Hdu,
        subarray: u32,
        warnings: &mut Vec<String>,
    ) -> Result<(), ReadError> {
        let table = Table::read(file, hdu)?;
        let position = Position::read(&table.header, warnings)?;
        let numbers = table.need_cells("NOSTA", 1)?;
        let xyz_m = table.need_cells("STABXYZ", 3)?;
        let names = table.texts("ANNAME")?.unwrap_or_default();
        let diameters_m = table.cells("DIAMETER")?.filter(|column| column.repeat > 0);
        for row in 0..table.n_row {
            let number = numbers.row(row)[0];
            if number.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&number) {
                let what = format!("row {}: {number} is no antenna number", row + 1);
                return Err(table.header.place.malformed("NOSTA", what));
            }
            let antenna = Antenna {
                number: number as u32,
                name: names.get(row).cloned().unwrap_or_default(),
                itrf_m: position.itrf_m(xyz_m.row(row)),
                diameter_m: diameters_m
                    .as_ref()
                    .map(|d| d.row(row)[0])
                    .filter(|&d| d > 0.0),
            };
            if !antenna.itrf_m.iter().all(|x| x.is_finite()) {
                let what = format!("row {}: the position is not finite", row + 1);
                return Err(table.header.place.malformed("STABXYZ", what));
            }
            self.insert(subarray, antenna);
        }
        Ok(())
    }

    /// Adds an antenna; the same one in several subarrays is one antenna.
    fn insert(&mut self, subarray: u32, antenna: Antenna) {
        let known = if subarray > 1 {
            self.list.iter().position(|a| *a == antenna)
        } else {
            None
        };
        let key = key(subarray, antenna.number);
        let index = known.unwrap_or(self.list.len());
        if known.is_none() {
            self.list.push(antenna);
        }
        self.index.push((key, index as u32));
    }
}

fn key(subarray: u32, number: u32) -> u64 {
    (u64::from(subarray) << 32) | u64::from(number)
}

/// How STABXYZ becomes geocentric.
struct Position {
    array_m: [f64; 3],
    sin_lon: f64,
    cos_lon: f64,
    /// -1 for a left-handed table.
    y_sign: f64,
}

impl Position {
    fn read(header: &Header, warnings: &mut Vec<String>) -> Result<Self, ReadError> {
        let array_m = array_position_m(header)?;
        let lon_rad = if array_m == [0.0; 3] {
            0.0
        } else {
            array_m[1].atan2(array_m[0])
        };
        let left = header
            .text("XYZHAND")
            .is_some_and(|hand| hand.eq_ignore_ascii_case("LEFT"));
        let frame = header.text("FRAME").unwrap_or("");
        let known = frame.is_empty() || frame.starts_with("ITRF") || frame.starts_with('?');
        if !known && !frame.eq_ignore_ascii_case("WGS84") {
            warnings.push(format!("antenna FRAME '{frame}' is taken as ITRF"));
        }
        Ok(Self {
            array_m,
            sin_lon: lon_rad.sin(),
            cos_lon: lon_rad.cos(),
            y_sign: if left { -1.0 } else { 1.0 },
        })
    }

    /// Relative positions stand in axes turned to the array's longitude (memo, section 4.1.1);
    /// with the array at the centre of the Earth they are geocentric already.
    fn itrf_m(&self, xyz_m: &[f64]) -> [f64; 3] {
        let (x, y, z) = (xyz_m[0], self.y_sign * xyz_m[1], xyz_m[2]);
        [
            self.array_m[0] + x * self.cos_lon - y * self.sin_lon,
            self.array_m[1] + x * self.sin_lon + y * self.cos_lon,
            self.array_m[2] + z,
        ]
    }
}

fn array_position_m(header: &Header) -> Result<[f64; 3], ReadError> {
    let coordinate = |key| Ok::<f64, ReadError>(header.real(key)?.unwrap_or(0.0));
    Ok([
        coordinate("ARRAYX")?,
        coordinate("ARRAYY")?,
        coordinate("ARRAYZ")?,
    ])
}

fn array_header(header: &Header, warnings: &mut Vec<String>) -> Result<ArrayHeader, ReadError> {
    let polar = match (header.real("POLARX")?, header.real("POLARY")?) {
        (Some(x), Some(y)) => Some([x, y]),
        _ => None,
    };
    Ok(ArrayHeader {
        name: header.text("ARRNAM").unwrap_or("").to_owned(),
        position_m: array_position_m(header)?,
        time_scale: time_scale(header, warnings),
        earth: EarthOrientation {
            ut1_utc_s: header.real("UT1UTC")?,
            polar_motion_arcsec: polar,
            gst0_deg: header.real("GSTIA0")?,
        },
        reference_day: header.text("RDATE").and_then(date::parse_day),
    })
}

/// The memo spells the keyword both ways; files have either.
fn time_scale(header: &Header, warnings: &mut Vec<String>) -> TimeScale {
    let name = header
        .text("TIMESYS")
        .or_else(|| header.text("TIMSYS"))
        .unwrap_or("UTC");
    match name.to_uppercase().as_str() {
        "UTC" => TimeScale::Utc,
        "TAI" | "IAT" => TimeScale::Tai,
        other => {
            warnings.push(format!("time scale '{other}' is taken as UTC"));
            TimeScale::Other
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_turned_by_the_longitude_and_mirrored_when_left_handed() {
        let mut position = Position {
            array_m: [0.0, 6e6, 0.0],
            sin_lon: 1.0,
            cos_lon: 0.0,
            y_sign: 1.0,
        };
        assert_eq!(
            position.itrf_m(&[10.0, 20.0, 30.0]),
            [-20.0, 6_000_010.0, 30.0]
        );
        position.y_sign = -1.0;
        assert_eq!(
            position.itrf_m(&[10.0, 20.0, 30.0]),
            [20.0, 6_000_010.0, 30.0]
        );
    }
}
