//! What we write, we read: bit for bit, but for uvw that go through 48 bits of seconds.

use proptest::prelude::*;
use vis2cat_formats::{Corr, Observation, VisChunk};

use crate::support::{Shape, chunk, fixtures, is_about_direction, observation, read, write};

fn assert_same_rows(found: &VisChunk, wanted: &VisChunk) {
    let mut found = found.clone();
    found.max_row = wanted.max_row;
    for (found, wanted) in found
        .uvw_m_r
        .iter()
        .flatten()
        .zip(wanted.uvw_m_r.iter().flatten())
    {
        assert!(
            (found - wanted).abs() <= 1e-14 * wanted.abs(),
            "{found} {wanted}"
        );
    }
    found.uvw_m_r.clone_from(&wanted.uvw_m_r);
    assert_eq!(&found, wanted);
}

fn assert_same_observation(found: &Observation, wanted: &Observation) {
    let mut found = found.clone();
    found
        .warnings
        .retain(|warning| !is_about_direction(warning));
    for (found, wanted) in found.fields.iter_mut().zip(&wanted.fields) {
        // Radians become degrees and radians again.
        assert!((found.ra_rad - wanted.ra_rad).abs() < 1e-15);
        assert!((found.dec_rad - wanted.dec_rad).abs() < 1e-15);
        (found.ra_rad, found.dec_rad) = (wanted.ra_rad, wanted.dec_rad);
    }
    assert_eq!(&found, wanted);
}

fn check(shape: &Shape) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let (observation, chunk) = (observation(shape), chunk(shape));
    write(&path, &observation, &chunk);
    let (found, rows) = read(&path, 7).unwrap();
    assert_same_observation(&found, &observation);
    assert_same_rows(&rows, &chunk);
}

#[test]
fn one_channel_and_one_hand() {
    check(&Shape {
        n_chan_per_if: 1,
        corrs: vec![Corr::Rr],
        ..Shape::default()
    });
}

#[test]
fn several_ifs_fields_and_set_ups() {
    check(&Shape {
        n_if: 3,
        n_field: 2,
        n_setup: 2,
        corrs: vec![Corr::Rr, Corr::Ll, Corr::Rl, Corr::Lr],
        ..Shape::default()
    });
}

#[test]
fn more_antennas_than_a_baseline_number_can_name() {
    check(&Shape {
        n_antenna: 3000,
        n_row: 500,
        ..Shape::default()
    });
}

#[test]
fn the_255th_antenna_still_has_a_baseline_number() {
    for n_antenna in [255, 256] {
        let shape = Shape {
            n_antenna,
            n_row: 300,
            ..Shape::default()
        };
        check(&shape);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.uvfits");
        write(&path, &observation(&shape), &chunk(&shape));
        let bytes = std::fs::read(&path).unwrap();
        let named = bytes.windows(8).any(|window| window == b"BASELINE");
        assert_eq!(named, n_antenna == 255);
    }
}

#[test]
fn correlations_out_of_order_come_back_in_order() {
    use Corr::{Xx, Xy, Yx, Yy};
    let shape = Shape {
        corrs: vec![Xx, Xy, Yx, Yy],
        ..Shape::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let written = chunk(&shape);
    write(&path, &observation(&shape), &written);
    let (found, rows) = read(&path, 100).unwrap();
    assert_eq!(found.corrs, [Xx, Yy, Xy, Yx]);
    for (found, wanted) in rows.vis_jy_rfp.chunks(4).zip(written.vis_jy_rfp.chunks(4)) {
        assert_eq!(found, [wanted[0], wanted[3], wanted[1], wanted[2]]);
    }
}

#[test]
fn a_flagged_sample_keeps_its_value_and_loses_its_weight() {
    let shape = Shape::default();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let mut written = chunk(&shape);
    written.weight_rfp[0] = 5.0;
    written.flag_rfp[0] = true;
    written.vis_jy_rfp[1].re = f32::NAN;
    written.weight_rfp[1] = 5.0;
    written.flag_rfp[1] = false;
    write(&path, &observation(&shape), &written);
    let (found, rows) = read(&path, 100).unwrap();
    assert_eq!(rows.vis_jy_rfp[0], written.vis_jy_rfp[0]);
    assert_eq!((rows.weight_rfp[0], rows.flag_rfp[0]), (0.0, true));
    assert_eq!((rows.weight_rfp[1], rows.flag_rfp[1]), (0.0, true));
    assert!(rows.vis_jy_rfp[1].is_finite());
    let told = "1 samples have a visibility or weight that is not finite and were flagged, the \
                first in group 1";
    let warnings: Vec<_> = found
        .warnings
        .iter()
        .filter(|w| !is_about_direction(w))
        .collect();
    assert_eq!(warnings, [told]);
}

#[test]
fn the_same_rows_give_the_same_bytes() {
    let shape = Shape::default();
    let folder = tempfile::tempdir().unwrap();
    let paths = [
        folder.path().join("a.uvfits"),
        folder.path().join("b.uvfits"),
    ];
    for path in &paths {
        write(path, &observation(&shape), &chunk(&shape));
    }
    assert_eq!(
        std::fs::read(&paths[0]).unwrap(),
        std::fs::read(&paths[1]).unwrap()
    );
}

#[test]
fn baselines_turned_round_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let (observation, mut rows) = read(&fixtures("good/pyuvdata_small.uvfits"), 100).unwrap();
    assert_eq!(observation.warnings, [""; 0]);
    for uvw_m in &mut rows.uvw_m_r {
        *uvw_m = uvw_m.map(|x| -x);
    }
    let path = folder.path().join("a.uvfits");
    write(&path, &observation, &rows);
    let (observation, found) = read(&path, 100).unwrap();
    assert!(observation.warnings[0].starts_with("UU, VV, WW run from antenna 1 to antenna 2"));
    // Told, not repaired.
    assert!((found.uvw_m_r[1][0] - rows.uvw_m_r[1][0]).abs() < 1e-9);
}

fn shapes() -> impl Strategy<Value = Shape> {
    use Corr::{I, Ll, Lr, Q, Rl, Rr, U, V, Xx, Yy};
    let corrs = prop_oneof![
        Just(vec![I]),
        Just(vec![I, Q, U, V]),
        Just(vec![Ll]),
        Just(vec![Rr, Ll]),
        Just(vec![Yy, Xx]),
        Just(vec![Rr, Ll, Rl, Lr]),
    ];
    let counts = (
        1usize..400,
        1usize..4,
        1usize..6,
        1usize..4,
        1usize..4,
        1usize..40,
    );
    (counts, corrs, any::<u64>()).prop_map(|(n, corrs, seed)| Shape {
        n_antenna: n.0,
        n_if: n.1,
        n_chan_per_if: n.2,
        n_field: n.3,
        n_setup: n.4,
        n_row: n.5,
        corrs,
        seed,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_observation_comes_back(shape in shapes()) {
        check(&shape);
    }

    #[test]
    fn reading_in_pieces_of_any_size_is_the_same(max_row in 1usize..30) {
        let shape = Shape { n_row: 25, ..Shape::default() };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.uvfits");
        write(&path, &observation(&shape), &chunk(&shape));
        prop_assert_eq!(read(&path, max_row).unwrap(), read(&path, usize::MAX).unwrap());
    }
}
