//! Every file of `fixtures/good` and `fixtures/bad`, and scratches in the good ones.

use serde_json::Value;

use crate::support::{Fixture, Numbers, fixtures, read, visibility_files};

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect()
}

fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!(
        (found - wanted).abs() <= tolerance,
        "found {found}, wanted {wanted}"
    );
}

/// `scripts/make_good_*.py` have put what pyuvdata finds beside each file.
#[test]
fn good_files_hold_what_pyuvdata_finds_in_them() {
    let good = visibility_files(&fixtures("good"));
    assert!(!good.is_empty());
    for Fixture { path, beside, .. } in &good {
        let text = std::fs::read_to_string(beside.with_extension("json")).unwrap();
        let wanted: Value = serde_json::from_str(&text).unwrap();
        let (observation, rows) = read(path, 7).unwrap_or_else(|error| panic!("{error}"));
        let count = |key: &str| wanted[key].as_u64().unwrap() as usize;
        assert_eq!(rows.n_row, count("n_row"));
        assert_eq!(observation.n_row as usize, count("n_row"));
        assert_eq!(rows.n_chan, count("n_chan"));
        assert_eq!(observation.corrs.len(), count("n_corr"));
        assert_eq!(observation.antennas.len(), count("n_antenna"));
        assert_eq!(
            rows.flag_rfp.iter().filter(|&&flag| flag).count(),
            count("n_flagged")
        );

        let good = |i: &usize| !rows.flag_rfp[*i];
        let (mut re, mut im, mut weight) = (0.0, 0.0, 0.0);
        for i in (0..rows.flag_rfp.len()).filter(good) {
            re += f64::from(rows.vis_jy_rfp[i].re);
            im += f64::from(rows.vis_jy_rfp[i].im);
            weight += f64::from(rows.weight_rfp[i]);
        }
        let sum_vis = numbers(&wanted["sum_vis"]);
        close(re, sum_vis[0], 1e-9);
        close(im, sum_vis[1], 1e-9);
        close(weight, wanted["sum_weight"].as_f64().unwrap(), 1e-9);
        let (sums_m, first_m) = (
            numbers(&wanted["sum_uvw_m"]),
            numbers(&wanted["first_uvw_m"]),
        );
        for d in 0..3 {
            close(rows.uvw_m_r.iter().map(|uvw| uvw[d]).sum(), sums_m[d], 1e-8);
            close(rows.uvw_m_r[1][d], first_m[d], 1e-9);
        }
        let first_vis = numbers(&wanted["first_vis"]);
        let at = rows.values_per_row();
        assert_eq!(rows.vis_jy_rfp[at].re, first_vis[0] as f32);
        assert_eq!(rows.vis_jy_rfp[at].im, first_vis[1] as f32);
        close(
            rows.time_mjd_r[0],
            wanted["first_mjd"].as_f64().unwrap(),
            1e-9,
        );
        let number = |index: u32| f64::from(observation.antennas[index as usize].number);
        let first_ant = numbers(&wanted["first_ant"]);
        assert_eq!(
            [number(rows.ant1_r[1]), number(rows.ant2_r[1])],
            first_ant[..]
        );
        for (found, wanted) in observation.freq_setups[0]
            .freq_hz_f
            .iter()
            .zip(numbers(&wanted["freq_hz"]))
        {
            close(*found, wanted, 0.1);
        }
        for (field, wanted) in observation
            .fields
            .iter()
            .zip(wanted["fields"].as_array().unwrap())
        {
            assert_eq!(field.name, wanted[0].as_str().unwrap());
            close(field.ra_rad, wanted[1].as_f64().unwrap(), 1e-12);
            close(field.dec_rad, wanted[2].as_f64().unwrap(), 1e-12);
        }
    }
}

/// `scripts/make_bad_*.py` have put the message beside each file.
#[test]
fn bad_files_get_their_messages() {
    let bad = visibility_files(&fixtures("bad"));
    assert!(bad.len() > 50);
    for Fixture { path, beside, .. } in &bad {
        let beside = format!("{}.txt", beside.display());
        let wanted = std::fs::read_to_string(beside).unwrap();
        let error = read(path, 2)
            .expect_err(&path.display().to_string())
            .to_string();
        let found = error
            .strip_prefix(&format!("{}: ", path.display()))
            .unwrap();
        assert_eq!(found, wanted.trim_end(), "{}", path.display());
    }
}

/// Bytes changed at random: any result will do, but a result there must be.
///
/// Not of Measurement Sets, whose headers are casacore's to read: see `ms.rs` for what is damaged there.
#[test]
fn scratched_files_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let scratched = folder.path().join("scratched.uvfits");
    let mut random = Numbers(7);
    let good = visibility_files(&fixtures("good"));
    for Fixture { path, .. } in good.iter().filter(|good| good.path.is_file()) {
        let whole = std::fs::read(path).unwrap();
        for _ in 0..400 {
            let mut bytes = whole.clone();
            for _ in 0..=(random.next() * 4.0) as usize {
                let at = (random.next() * bytes.len() as f64) as usize;
                bytes[at] = match (random.next() * 4.0) as u8 {
                    0 => (random.next() * 256.0) as u8,
                    1 => b'0' + (random.next() * 10.0) as u8,
                    2 => b' ',
                    _ => bytes[(random.next() * bytes.len() as f64) as usize],
                };
            }
            std::fs::write(&scratched, &bytes).unwrap();
            let _ = read(&scratched, 100);
        }
    }
}
