//! (u, v, w) against pyuvdata's: golden values here, whole arrays in `scripts/check_simulate_uvw.py`.

use std::io::Write;
use std::path::PathBuf;

use super::*;

/// The (u, v, w) [m] of each dish, relative to the array's centre, at `mjd`.
fn dish_uvw_m(array: &Array, centre: RaDec, mjd: f64) -> Vec<[f64; 3]> {
    let middle_m = array.centre_m();
    let site = Site::from_itrf(middle_m).unwrap();
    let earth = EarthTable::builtin().unwrap().at(mjd).unwrap();
    let frame = UvwFrame::new(&Pointing::at(centre, site, mjd, earth).unwrap());
    let offset_m = |p: [f64; 3]| std::array::from_fn(|k| p[k] - middle_m[k]);
    array
        .dishes
        .iter()
        .map(|dish| frame.apply(offset_m(dish.itrf_m)))
        .collect()
}

/// Writes what `scripts/check_simulate_uvw.py` compares: dishes and their (u, v, w) for some arrays,
/// declinations and dates. Times are multiples of 2^-31 day, which a Julian date in f64 holds exactly.
#[test]
#[ignore = "writes the input of scripts/check_simulate_uvw.py"]
fn write_uvw_for_pyuvdata() {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("simulate_uvw.csv");
    let mut file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    writeln!(
        file,
        "array,ra_deg,dec_deg,mjd,name,x_m,y_m,z_m,u_m,v_m,w_m"
    )
    .unwrap();
    for name in ["ska1-mid", "meerkat", "vla-a", "atca-6a"] {
        let array = Array::find(name).unwrap();
        for (ra_deg, dec_deg) in [
            (53.1, -30.0),
            (0.0, 0.0),
            (187.7, 12.4),
            (300.0, -88.0),
            (201.3, -89.8),
            (10.0, 70.0),
        ] {
            for day in [57754.25, 58849.123456, 59580.9, 60310.5, 61041.77] {
                let mjd = (day * 2f64.powi(31)).round() / 2f64.powi(31);
                let centre = RaDec {
                    ra_rad: ra_deg * DEG,
                    dec_rad: dec_deg * DEG,
                };
                let uvw_m = dish_uvw_m(&array, centre, mjd);
                for (dish, [u, v, w]) in array.dishes.iter().zip(uvw_m) {
                    let [x, y, z] = dish.itrf_m;
                    writeln!(
                        file,
                        "{name},{ra_deg},{dec_deg},{mjd:?},{},{x},{y},{z},{u:?},{v:?},{w:?}",
                        dish.name
                    )
                    .unwrap();
                }
            }
        }
    }
}
