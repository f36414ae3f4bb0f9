//! The built-in arrays: tables of published positions, in a layout of our own.
//!
//! Where the numbers come from stands at the head of each table; `scripts/make_arrays.py` makes them.

use std::path::Path;

use super::table::{self, Row};
use super::{Array, Dish};
use crate::simulate::SimulateError;

const SKA1_MID: &str = include_str!("../arrays/ska1_mid.csv");
const VLA: &str = include_str!("../arrays/vla.csv");
const ATCA: &str = include_str!("../arrays/atca.csv");

/// Stages of SKA1-MID in the order of building; each holds the dishes of those before it.
const SKA1_MID_STAGES: [&str; 4] = ["AA1", "AA2", "AAstar", "AA4"];

/// Names of the built-in arrays.
///
/// | name | array | dishes | longest baseline |
/// |---|---|---|---|
/// | `meerkat` | MeerKAT | 64 | 7.7 km |
/// | `ska1-mid` | SKA1-MID AA4: the SKA and MeerKAT dishes | 197 | 159.6 km |
/// | `ska1-mid-aa1`, `-aa2`, `-aastar` | its earlier stages | 8, 64, 144 | 1.4, 108, 108 km |
/// | `vla-a` to `vla-d` | Karl G. Jansky Very Large Array | 27 | 36.6 to 1.0 km |
/// | `atca-6a`, `atca-1.5a` | Australia Telescope Compact Array | 6 | 5.9, 4.5 km |
pub const BUILTIN_NAMES: [&str; 11] = [
    "meerkat",
    "ska1-mid",
    "ska1-mid-aa1",
    "ska1-mid-aa2",
    "ska1-mid-aastar",
    "vla-a",
    "vla-b",
    "vla-c",
    "vla-d",
    "atca-6a",
    "atca-1.5a",
];

/// The built-in array called `name`; `None` where there is none.
pub(super) fn builtin(name: &str) -> Option<Result<Array, SimulateError>> {
    let name = name.to_ascii_lowercase();
    if !BUILTIN_NAMES.contains(&name.as_str()) {
        return None;
    }
    let (telescope, dishes) = match name.as_str() {
        "meerkat" => ("MeerKAT", ska1_mid(is_meerkat)),
        "ska1-mid" => ("SKA1-MID", ska1_mid(|_| true)),
        "ska1-mid-aa1" => ("SKA1-MID", ska1_mid(|row| by_stage(row, 0))),
        "ska1-mid-aa2" => ("SKA1-MID", ska1_mid(|row| by_stage(row, 1))),
        "ska1-mid-aastar" => ("SKA1-MID", ska1_mid(|row| by_stage(row, 2))),
        other => configuration(other),
    };
    Some(dishes.map(|dishes| Array {
        name: telescope.to_owned(),
        dishes,
    }))
}

fn ska1_mid(keep: impl Fn(&Row) -> bool) -> Result<Vec<Dish>, SimulateError> {
    table::read(SKA1_MID.as_bytes(), Path::new("ska1_mid.csv"), keep)
}

fn is_meerkat(row: &Row) -> bool {
    row.text("name").is_some_and(|name| name.starts_with('M'))
}

fn by_stage(row: &Row, last_stage: usize) -> bool {
    row.text("stage")
        .is_some_and(|stage| SKA1_MID_STAGES[..=last_stage].contains(&stage))
}

/// The pads that the configuration after the dash of `name` uses.
fn configuration(name: &str) -> (&'static str, Result<Vec<Dish>, SimulateError>) {
    let (telescope, config) = name.split_once('-').unwrap_or((name, ""));
    let (telescope, file, text) = match telescope {
        "vla" => ("VLA", "vla.csv", VLA),
        _ => ("ATCA", "atca.csv", ATCA),
    };
    let used = |row: &Row| {
        row.text("configs")
            .is_some_and(|configs| configs.split(' ').any(|known| known == config))
    };
    (
        telescope,
        table::read(text.as_bytes(), Path::new(file), used),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn longest_km(array: &Array) -> f64 {
        let length_m = |(i, j): &(u32, u32)| {
            let (p, q) = (&array.dishes[*i as usize], &array.dishes[*j as usize]);
            (0..3)
                .map(|k| (p.itrf_m[k] - q.itrf_m[k]).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        array.baselines().iter().map(length_m).fold(0.0, f64::max) * 1e-3
    }

    #[test]
    fn every_built_in_array_has_its_dishes_and_longest_baseline() {
        let expected = [
            (64, 7.7),
            (197, 159.6),
            (8, 1.4),
            (64, 108.0),
            (144, 108.0),
            (27, 36.6),
            (27, 11.1),
            (27, 3.4),
            (27, 1.0),
            (6, 5.9),
            (6, 4.5),
        ];
        for (name, (n_dish, length_km)) in BUILTIN_NAMES.iter().zip(expected) {
            let array = Array::find(name).unwrap();
            assert_eq!(array.dishes.len(), n_dish, "{name}");
            assert!((longest_km(&array) - length_km).abs() < 0.06, "{name}");
        }
    }

    #[test]
    fn the_first_meerkat_dish_stands_where_its_observatory_says() {
        // SARAO: M000 is 8.264 m west, 207.290 m south, 8.597 m above 21d26m38.0s E 30d42m39.8s S
        let meerkat = Array::find("MeerKAT").unwrap();
        let (lon_rad, lat_rad) = (
            21.443_888_889_f64.to_radians(),
            -30.711_055_556_f64.to_radians(),
        );
        let (sin_lon, cos_lon) = lon_rad.sin_cos();
        let (sin_lat, cos_lat) = lat_rad.sin_cos();
        let reference = sofars::coords::gd2gc(1, lon_rad, lat_rad, 1086.6).unwrap();
        let d: Vec<f64> = (0..3)
            .map(|k| meerkat.dishes[0].itrf_m[k] - reference[k])
            .collect();
        let east_m = -sin_lon * d[0] + cos_lon * d[1];
        let north_m = -sin_lat * (cos_lon * d[0] + sin_lon * d[1]) + cos_lat * d[2];
        assert!((east_m + 8.264).abs() < 0.05, "{east_m}");
        assert!((north_m + 207.290).abs() < 0.05, "{north_m}");
    }

    #[test]
    fn a_mixed_array_knows_the_noise_of_each_dish() {
        let ska = Array::find("ska1-mid").unwrap();
        assert_eq!(ska.dishes[0].sefd_jy, Some(551.0));
        assert_eq!(ska.dishes[196].sefd_jy, Some(400.0));
        assert_eq!(Array::find("atca-6a").unwrap().dishes[0].sefd_jy, None);
    }

    #[test]
    fn an_unknown_array_lists_the_known_ones() {
        let message = Array::find("vla-e").unwrap_err().to_string();
        assert!(message.contains("vla-d") && message.contains("CSV"));
    }
}
