//! Do the stored baselines run the way the format says?
//!
//! A file whose u, v, w were turned round without its data being conjugated shows every source at
//! the opposite side of the phase centre, and nothing in it looks wrong. So the stored baselines of
//! some rows are set against those that follow from the antenna positions. Nothing is ever
//! repaired: a warning tells.
//!
//! # Formula
//! With the Greenwich hour angle h and declination d of the phase centre, and b = r(ant1) - r(ant2)
//! in geocentric coordinates (Thompson, Moran & Swenson, *Interferometry and Synthesis in Radio
//! Astronomy*, 3rd ed., eq. 4.1, for east as the direction of u):
//!
//! ```text
//! u =  sin h bx + cos h by
//! v = -sin d cos h bx + sin d sin h by + cos d bz
//! w =  cos d cos h bx - cos d sin h by + sin d bz
//! ```
//!
//! # Precision
//! Mean sidereal time with UT1 = UTC, no precession or nutation: a third of a degree for J2000
//! positions today, which is nothing to a question of sign.

use crate::date::{DEG_PER_DAY, gmst0_deg};

/// Cosine of the angle between stored and computed from which they are taken to agree.
const AGREE_COS: f64 = 0.9;
/// How far the lengths may differ.
const LENGTHS: std::ops::Range<f64> = 0.9..1.1;
/// Rows needed for a verdict.
const MIN_ROWS: usize = 8;
/// Baselines shorter than this say nothing [m].
const MIN_LENGTH_M: f64 = 1.0;

/// What one row says.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evidence {
    /// Cosine of the angle between stored and computed.
    cos: f64,
    /// Stored over computed length.
    ratio: f64,
}

/// Compares one row; `None` where its baseline is too short.
pub(crate) fn compare(
    uvw_m: [f64; 3],
    positions_m: [[f64; 3]; 2],
    time_mjd: f64,
    centre_rad: (f64, f64),
) -> Option<Evidence> {
    let baseline_m = [0, 1, 2].map(|d| positions_m[0][d] - positions_m[1][d]);
    let computed_m = project(baseline_m, time_mjd, centre_rad);
    let length = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (stored, computed) = (length(uvw_m), length(computed_m));
    let dot: f64 = uvw_m.iter().zip(computed_m).map(|(a, b)| a * b).sum();
    (stored > 0.0 && computed > MIN_LENGTH_M).then(|| Evidence {
        cos: dot / (stored * computed),
        ratio: stored / computed,
    })
}

/// A geocentric vector seen from the phase centre.
fn project(b_m: [f64; 3], time_mjd: f64, (ra_rad, dec_rad): (f64, f64)) -> [f64; 3] {
    let gmst_deg = gmst0_deg(time_mjd) + time_mjd.fract() * DEG_PER_DAY;
    let (sin_h, cos_h) = (gmst_deg.to_radians() - ra_rad).sin_cos();
    let (sin_d, cos_d) = dec_rad.sin_cos();
    let [x, y, z] = b_m;
    [
        sin_h * x + cos_h * y,
        -sin_d * cos_h * x + sin_d * sin_h * y + cos_d * z,
        cos_d * cos_h * x - cos_d * sin_h * y + sin_d * z,
    ]
}

/// What a format calls its coordinates, for warnings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Words {
    /// The coordinates by their name in the file.
    pub(crate) coordinates: &'static str,
    /// How the baselines run where they run the wrong way, and against what.
    pub(crate) wrong_way: &'static str,
}

/// A warning in words where the rows do not agree with the format.
pub(crate) fn verdict(evidence: &[Evidence], words: &Words) -> Option<String> {
    let Words {
        coordinates,
        wrong_way,
    } = words;
    if evidence.len() < MIN_ROWS {
        return None;
    }
    let cos = median(evidence.iter().map(|e| e.cos));
    let ratio = median(evidence.iter().map(|e| e.ratio));
    if !LENGTHS.contains(&ratio) || cos.abs() < AGREE_COS {
        return Some(format!(
            "{coordinates} do not agree with the antenna positions (length ratio {ratio:.3}, cosine \
             {cos:.3}); they are used as stored"
        ));
    }
    (cos < 0.0).then(|| {
        format!(
            "{coordinates} run {wrong_way}; they are used as stored, and unless the data were \
             conjugated with them sources appear at the opposite side of the phase centre"
        )
    })
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: Words = Words {
        coordinates: "UU, VV, WW",
        wrong_way: "from antenna 1 to antenna 2",
    };
    const MJD: f64 = 60_000.3;
    const CENTRE_RAD: (f64, f64) = (1.0, -0.5);

    /// Evidence of rows whose stored baselines are the computed ones times `factor`.
    fn rows(factor: f64) -> Vec<Evidence> {
        let row = |i: u32| {
            let b_m = [100.0 * f64::from(i), -50.0, 70.0 - f64::from(i)];
            let uvw_m = project(b_m, MJD, CENTRE_RAD).map(|x| factor * x);
            compare(uvw_m, [b_m, [0.0; 3]], MJD, CENTRE_RAD).unwrap()
        };
        (1..20).map(row).collect()
    }

    #[test]
    fn the_direction_and_the_unit_are_judged() {
        assert_eq!(verdict(&rows(1.0), &WORDS), None);
        assert!(
            verdict(&rows(-1.0), &WORDS)
                .unwrap()
                .contains("run from antenna 1")
        );
        assert!(
            verdict(&rows(0.21), &WORDS)
                .unwrap()
                .contains("length ratio 0.210")
        );
        assert_eq!(verdict(&rows(-1.0)[..4], &WORDS), None);
    }

    #[test]
    fn a_baseline_is_projected_as_the_book_says() {
        // The source on the equator at Greenwich's meridian: x is w, y is u, z is v.
        let ra_rad = gmst0_deg(60_000.0).to_radians();
        let uvw_m = project([1.0, 2.0, 3.0], 60_000.0, (ra_rad, 0.0));
        for (found, wanted) in uvw_m.iter().zip([2.0, 3.0, 1.0]) {
            assert!((found - wanted).abs() < 1e-9);
        }
    }

    #[test]
    fn short_baselines_say_nothing() {
        assert!(compare([0.0; 3], [[9.0; 3]; 2], MJD, CENTRE_RAD).is_none());
    }
}
