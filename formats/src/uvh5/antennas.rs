//! Where the antennas are.
//!
//! # Source
//! Memo, section 3.1: antenna_positions are geocentric vectors from the telescope's position, whose
//! latitude and longitude are geodetic, on WGS84.

use sofars::coords::{gc2gd, gd2gc};

use crate::h5::Group;
use crate::{Antenna, ReadError};

/// SOFA's number of the reference ellipsoid WGS84.
const WGS84: i32 = 1;

/// The antennas, and how to find one.
#[derive(Debug)]
pub(super) struct Antennas {
    pub(super) list: Vec<Antenna>,
    /// Geocentric ITRF position of the array [m].
    pub(super) array_m: [f64; 3],
    /// Numbers and places in the list, sorted.
    index: Vec<(i64, u32)>,
}

impl Antennas {
    pub(super) fn read(header: &Group) -> Result<Self, ReadError> {
        let array_m = array_position_m(header)?;
        let numbers = header.need("antenna_numbers")?;
        let count = header.need("Nants_telescope")?.count()?;
        numbers.check_shape_is(&[count])?;
        let values = numbers.wholes()?;
        let names = header.need("antenna_names")?;
        names.check_shape_is(&[count])?;
        let names = names.texts()?;
        let positions = header.need("antenna_positions")?;
        positions.check_shape_is(&[count, 3])?;
        let offsets_m = positions.reals()?;
        if let Some(i) = offsets_m.iter().position(|x| !x.is_finite()) {
            return Err(positions.malformed(format!("antenna {}: is not finite", i / 3 + 1)));
        }
        let diameters_m = diameters_m(header, count)?;
        let mut antennas = Self {
            list: Vec::with_capacity(count),
            array_m,
            index: Vec::with_capacity(count),
        };
        for (i, (&number, name)) in values.iter().zip(names).enumerate() {
            let known = u32::try_from(number)
                .map_err(|_| numbers.malformed(format!("{number} is no antenna number")))?;
            antennas.index.push((number, i as u32));
            antennas.list.push(Antenna {
                number: known,
                name,
                itrf_m: [0, 1, 2].map(|d| array_m[d] + offsets_m[3 * i + d]),
                diameter_m: diameters_m.get(i).copied().filter(|&d| d > 0.0),
            });
        }
        antennas.index.sort_unstable();
        let twice = antennas
            .index
            .windows(2)
            .find(|pair| pair[0].0 == pair[1].0);
        match twice {
            Some(pair) => Err(numbers.malformed(format!("has antenna {} twice", pair[0].0))),
            None => Ok(antennas),
        }
    }

    /// The place in the list of the antenna with that number.
    pub(super) fn find(&self, number: i64) -> Option<u32> {
        let at = self.index.binary_search_by_key(&number, |entry| entry.0);
        at.ok().map(|i| self.index[i].1)
    }
}

fn diameters_m(header: &Group, count: usize) -> Result<Vec<f64>, ReadError> {
    let Some(diameters) = header.dataset("antenna_diameters")? else {
        return Ok(Vec::new());
    };
    diameters.check_shape_is(&[count])?;
    diameters.reals()
}

fn array_position_m(header: &Group) -> Result<[f64; 3], ReadError> {
    if let Some(frame) = header.dataset("telescope_frame")? {
        let name = frame.text()?;
        if name != "itrs" {
            let what = format!("is '{name}': only positions on the Earth (itrs) are read");
            return Err(frame.unsupported(what));
        }
    }
    let mut values = [0.0; 3];
    for (value, name) in values.iter_mut().zip(["longitude", "latitude", "altitude"]) {
        *value = header.need(name)?.real()?;
        if !value.is_finite() {
            return Err(header.malformed(name, format!("{value} is not finite")));
        }
    }
    let [lon_deg, lat_deg, height_m] = values;
    if lat_deg.abs() > 90.0 {
        return Err(header.malformed("latitude", format!("{lat_deg} deg")));
    }
    gd2gc(WGS84, lon_deg.to_radians(), lat_deg.to_radians(), height_m)
        .map_err(|_| header.malformed("altitude", format!("no place is {height_m} m high")))
}

/// Longitude [deg], geodetic latitude [deg] and height [m] of a geocentric position; zeros where
/// there is no such place.
pub(super) fn geodetic(position_m: [f64; 3]) -> [f64; 3] {
    gc2gd(WGS84, position_m).map_or([0.0; 3], |(lon_rad, lat_rad, height_m)| {
        [lon_rad.to_degrees(), lat_rad.to_degrees(), height_m]
    })
}

/// Geocentric position [m] of a longitude, latitude [deg] and height [m]: what readers will make of
/// them.
pub(super) fn geocentric_m([lon_deg, lat_deg, height_m]: [f64; 3]) -> [f64; 3] {
    gd2gc(WGS84, lon_deg.to_radians(), lat_deg.to_radians(), height_m).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_comes_back_to_the_micrometre() {
        let position_m = [5_109_325.0, 2_006_919.0, -3_238_944.0];
        let back_m = geocentric_m(geodetic(position_m));
        for (found, wanted) in back_m.iter().zip(position_m) {
            assert!((found - wanted).abs() < 1e-6);
        }
        // MeerKAT, by astropy's EarthLocation.from_geocentric.
        let [lon_deg, lat_deg, height_m] = geodetic(position_m);
        assert!((lon_deg - 21.444_668_171_958_38).abs() < 1e-9);
        assert!((lat_deg + 30.711_062_335_619_737).abs() < 1e-9);
        assert!((height_m - 1_077.252_524_379_048).abs() < 1e-5);
    }
}
