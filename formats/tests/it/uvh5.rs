//! UVH5 against UVFITS, there and back, and scratched.

use proptest::prelude::*;
use vis2cat_formats::{
    Corr, Frame, Observation, UvfitsWriter, Uvh5Writer, VisChunk, VisWriter, WriteError,
};

use crate::support::{
    Numbers, Shape, chunk, files, fixtures, is_about_direction, names, observation, read, write,
    writer,
};

/// A shape that UVH5 can hold: one frequency set-up.
fn one_setup(shape: Shape) -> Shape {
    Shape {
        n_setup: 1,
        ..shape
    }
}

/// To the last bit of a Julian date, 40 μs.
const TIME_TOLERANCE_DAYS: f64 = 5e-10;

fn assert_same_rows(found: &VisChunk, wanted: &VisChunk, uvw_tolerance_m: f64, tolerance_s: f64) {
    let mut found = found.clone();
    found.max_row = wanted.max_row;
    let close = |a: &[f64], b: &[f64], tolerance: f64| {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= tolerance, "{a} {b}");
        }
    };
    let (a, b) = (found.uvw_m_r.as_flattened(), wanted.uvw_m_r.as_flattened());
    close(a, b, uvw_tolerance_m);
    close(&found.time_mjd_r, &wanted.time_mjd_r, TIME_TOLERANCE_DAYS);
    close(&found.interval_s_r, &wanted.interval_s_r, tolerance_s);
    found.uvw_m_r.clone_from(&wanted.uvw_m_r);
    found.time_mjd_r.clone_from(&wanted.time_mjd_r);
    found.interval_s_r.clone_from(&wanted.interval_s_r);
    assert_eq!(&found, wanted);
}

/// pyuvdata wrote the same observation in both formats: the fixtures that share a name.
#[test]
fn both_formats_of_an_observation_give_the_same_rows() {
    let mut n_pair = 0;
    for path in files(&fixtures("good"), "uvh5") {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let other = name.replace("uvh5_", "pyuvdata_");
        let other = fixtures("good").join(format!("{other}.uvfits"));
        if !other.is_file() {
            continue;
        }
        n_pair += 1;
        let (uvh5, rows) = read(&path, 5).unwrap();
        let (uvfits, wanted) = read(&other, 5).unwrap();
        // UVFITS has intervals of 32 bits and coordinates of twice 24.
        assert_same_rows(&rows, &wanted, 1e-9, 1e-6);
        assert_eq!(uvh5.corrs, uvfits.corrs);
        assert_eq!(uvh5.warnings, uvfits.warnings);
        for (found, wanted) in uvh5.antennas.iter().zip(&uvfits.antennas) {
            assert_eq!((found.number, &found.name), (wanted.number, &wanted.name));
            for d in 0..3 {
                assert!((found.itrf_m[d] - wanted.itrf_m[d]).abs() < 1e-6);
            }
        }
    }
    assert_eq!(n_pair, 4);
}

#[test]
fn uvfits_becomes_uvh5_and_stays_the_same() {
    let folder = tempfile::tempdir().unwrap();
    for path in files(&fixtures("good"), "uvfits") {
        let (observation, rows) = read(&path, 100).unwrap();
        let copy = folder.path().join("copy.uvh5");
        write(&copy, &observation, &rows);
        let (found, again) = read(&copy, 4).unwrap();
        assert_same_rows(&again, &rows, 0.0, 0.0);
        assert_eq!(found.fields, observation.fields);
        assert_eq!(found.corrs, observation.corrs);
        assert_eq!(found.warnings, [""; 0]);
        std::fs::remove_file(&copy).unwrap();
    }
}

#[test]
fn uvh5_becomes_uvh5_and_stays_the_same() {
    let folder = tempfile::tempdir().unwrap();
    for path in files(&fixtures("good"), "uvh5") {
        let (observation, rows) = read(&path, 100).unwrap();
        let copy = folder.path().join("copy.uvh5");
        write(&copy, &observation, &rows);
        let (found, again) = read(&copy, 4).unwrap();
        assert_same_rows(&again, &rows, 0.0, 0.0);
        assert_eq!(found.fields, observation.fields, "{}", path.display());
        assert_eq!(found.freq_setups, observation.freq_setups);
        assert_eq!(found.uvh5, observation.uvh5);
        assert_eq!(found.history, observation.history);
        std::fs::remove_file(&copy).unwrap();
    }
}

fn check(shape: &Shape) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvh5");
    let (wanted, rows) = (observation(shape), chunk(shape));
    write(&path, &wanted, &rows);
    let (mut found, again) = read(&path, 7).unwrap();
    assert_same_rows(&again, &rows, 0.0, 0.0);
    found
        .warnings
        .retain(|warning| !is_about_direction(warning));
    assert_same_observation(&found, &wanted);
}

/// What UVH5 has no place for: the observer, polar motion, where absolute positions are absolute.
fn assert_same_observation(found: &Observation, wanted: &Observation) {
    for (found, wanted) in found.antennas.iter().zip(&wanted.antennas) {
        assert!((0..3).all(|d| (found.itrf_m[d] - wanted.itrf_m[d]).abs() < 2e-9));
    }
    assert_eq!(found.antennas.len(), wanted.antennas.len());
    let mut found = found.clone();
    found.antennas.clone_from(&wanted.antennas);
    found.array_position_m = wanted.array_position_m;
    found.observer.clone_from(&wanted.observer);
    found.earth.polar_motion_arcsec = wanted.earth.polar_motion_arcsec;
    found.uvh5 = None;
    assert_eq!(&found, wanted);
}

#[test]
fn several_windows_and_fields() {
    check(&Shape {
        n_if: 3,
        n_field: 4,
        n_row: 40,
        corrs: vec![Corr::Rr, Corr::Ll, Corr::Rl, Corr::Lr],
        ..Shape::default()
    });
}

/// A chunk of the file is a megabyte: here there are several, and one that is not full.
#[test]
fn more_rows_than_a_chunk_holds() {
    check(&Shape {
        n_chan_per_if: 500,
        n_row: 300,
        corrs: vec![Corr::Xx, Corr::Yy],
        ..Shape::default()
    });
}

#[test]
fn more_channels_than_a_chunk_holds() {
    check(&Shape {
        n_chan_per_if: 100_000,
        n_row: 3,
        corrs: vec![Corr::Xx, Corr::Yy],
        ..Shape::default()
    });
}

#[test]
fn the_bytes_do_not_depend_on_when_and_how_rows_came() {
    let shape = Shape {
        n_chan_per_if: 500,
        n_row: 300,
        ..Shape::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let (observation, rows) = (observation(&shape), chunk(&shape));
    let whole = folder.path().join("whole.uvh5");
    write(&whole, &observation, &rows);
    let pieces = folder.path().join("pieces.uvh5");
    let mut to = writer(&pieces, &observation);
    let mut from = vis2cat_formats::open(&whole).unwrap();
    let mut piece = VisChunk::new(7);
    while from.read_chunk(&mut piece).unwrap() > 0 {
        // A Julian date is coarser than ours; the rest comes back to the bit.
        let first = (rows.time_mjd_r.iter())
            .position(|mjd| (mjd - piece.time_mjd_r[0]).abs() < TIME_TOLERANCE_DAYS);
        let first = first.unwrap();
        let times = rows.time_mjd_r[first..first + piece.n_row].to_vec();
        piece.time_mjd_r = times;
        to.write_chunk(&piece).unwrap();
    }
    // Some time apart: nothing in the file is of the clock.
    std::thread::sleep(std::time::Duration::from_millis(1100));
    to.finish().unwrap();
    assert!(std::fs::read(&whole).unwrap() == std::fs::read(&pieces).unwrap());
}

#[test]
fn flags_and_weights_are_not_lost_on_the_way() {
    let shape = Shape::default();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvh5");
    let mut rows = chunk(&shape);
    rows.vis_jy_rfp[1].re = f32::NAN;
    (rows.weight_rfp[1], rows.flag_rfp[1]) = (5.0, false);
    (rows.weight_rfp[2], rows.flag_rfp[2]) = (5.0, true);
    write(&path, &observation(&shape), &rows);
    let (found, again) = read(&path, 100).unwrap();
    assert_eq!((again.weight_rfp[1], again.flag_rfp[1]), (0.0, true));
    assert_eq!((again.weight_rfp[2], again.flag_rfp[2]), (0.0, true));
    assert_eq!(again.vis_jy_rfp[2], rows.vis_jy_rfp[2]);
    let told = "1 samples have a visibility or weight that is not finite and were flagged, the \
                first in or after row 1";
    assert!(
        found.warnings.contains(&told.to_owned()),
        "{:?}",
        found.warnings
    );
}

#[test]
fn nsamples_that_make_no_sense_are_told_and_not_used() {
    let shape = Shape::default();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvh5");
    let mut rows = chunk(&shape);
    rows.weight_rfp.fill(-1.2e12);
    write(&path, &observation(&shape), &rows);
    let (found, again) = read(&path, 100).unwrap();
    assert!(found.warnings[0].starts_with("no nsample is positive"));
    for (weight, flag) in again.weight_rfp.iter().zip(&rows.flag_rfp) {
        assert_eq!(*weight, if *flag { 0.0 } else { 1.0 });
    }
    assert_eq!(again.flag_rfp, rows.flag_rfp);

    // One that does makes them weights again, wherever it is.
    *rows.weight_rfp.last_mut().unwrap() = 3.0;
    *rows.flag_rfp.last_mut().unwrap() = false;
    std::fs::remove_file(&path).unwrap();
    write(&path, &observation(&shape), &rows);
    let (_, again) = read(&path, 100).unwrap();
    assert_eq!(again.flag_rfp.iter().filter(|&&flag| !flag).count(), 1);
}

#[test]
fn baselines_turned_round_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let (observation, mut rows) = read(&fixtures("good/uvh5_small.uvh5"), 100).unwrap();
    assert_eq!(observation.warnings, [""; 0]);
    for uvw_m in &mut rows.uvw_m_r {
        *uvw_m = uvw_m.map(|x| -x);
    }
    let path = folder.path().join("a.uvh5");
    write(&path, &observation, &rows);
    let (observation, found) = read(&path, 100).unwrap();
    assert!(observation.warnings[0].starts_with("uvw_array run from antenna 2 to antenna 1"));
    assert_eq!(found.uvw_m_r, rows.uvw_m_r, "told, not repaired");
}

#[test]
fn windows_that_are_no_ifs_keep_their_numbers() {
    let (found, _) = read(&fixtures("good/uvh5_unequal_windows.uvh5"), 100).unwrap();
    let setup = &found.freq_setups[0];
    assert_eq!(found.uvh5.unwrap().spw_f, [7, 3, 3, 4, 4, 4]);
    assert_eq!(setup.n_if, 1);
    assert_eq!(setup.chan_width_hz_f, [1e6, 5e5, 5e5, -1e6, -1e6, -1e6]);
}

#[test]
fn old_and_new_phase_centres_are_read() {
    let (old, _) = read(&fixtures("good/uvh5_old_phase.uvh5"), 100).unwrap();
    assert_eq!(
        (old.fields[0].name.as_str(), old.fields[0].frame),
        ("SRC0", Frame::Icrs)
    );
    let (new, rows) = read(&fixtures("good/uvh5_gzip.uvh5"), 100).unwrap();
    assert_eq!(new.fields.len(), 3);
    assert!((0..3).all(|field| rows.field_r.contains(&field)));
}

#[test]
fn a_file_has_its_name_when_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvh5");
    let shape = Shape::default();
    let mut writer = Uvh5Writer::create(&path, &observation(&shape), false).unwrap();
    writer.write_chunk(&chunk(&shape)).unwrap();
    let hidden = names(folder.path());
    assert!(
        hidden.len() == 1 && hidden[0].starts_with('.'),
        "{hidden:?}"
    );
    drop(writer);
    assert!(names(folder.path()).is_empty());

    write(&path, &observation(&shape), &chunk(&shape));
    assert_eq!(names(folder.path()), ["a.uvh5"]);
    let refused = Uvh5Writer::create(&path, &observation(&shape), false);
    assert!(matches!(refused, Err(WriteError::Exists { .. })));
}

#[test]
fn what_does_not_fit_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvh5");
    let refused = |change: fn(&mut Observation)| {
        let mut observation = observation(&Shape::default());
        change(&mut observation);
        let error = Uvh5Writer::create(&path, &observation, false)
            .unwrap_err()
            .to_string();
        let prefix = format!("{}: ", path.display());
        error.strip_prefix(&prefix).unwrap().to_owned()
    };
    assert_eq!(
        refused(|o| o.antennas.clear()),
        "0 antennas cannot be written"
    );
    assert_eq!(
        refused(|o| o.fields.clear()),
        "the observation has no phase centre"
    );
    assert_eq!(
        refused(|o| o.corrs.clear()),
        "the observation has no correlations"
    );
    assert_eq!(
        refused(|o| o.freq_setups.push(o.freq_setups[0].clone())),
        "there are 2 frequency set-ups; UVH5 can hold one, of any channels"
    );
    let observation = observation(&Shape::default());
    let mut writer = Uvh5Writer::create(&path, &observation, false).unwrap();
    let mut rows = chunk(&Shape::default());
    rows.ant1_r[4] = 99;
    let error = writer.write_chunk(&rows).unwrap_err().to_string();
    assert!(error.ends_with("row 5: antenna 99 of 5"), "{error}");
    let empty = Box::new(writer).finish().unwrap_err().to_string();
    assert!(
        empty.ends_with("no row was written; UVH5 cannot be empty"),
        "{empty}"
    );
    assert!(names(folder.path()).is_empty());
}

/// Bytes changed in the structures that tell where and how large everything is.
#[test]
fn scratched_structures_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let scratched = folder.path().join("scratched.uvh5");
    let mut random = Numbers(11);
    for path in files(&fixtures("bad"), "uvh5").iter().take(3) {
        let whole = std::fs::read(path).unwrap();
        for _ in 0..300 {
            let mut bytes = whole.clone();
            let at = (random.next() * bytes.len() as f64) as usize;
            let value = [0x00, 0xff, 0x7f, 0x80][(random.next() * 4.0) as usize];
            let n_byte = 1 + (random.next() * 8.0) as usize;
            let end = (at + n_byte).min(bytes.len());
            bytes[at..end].fill(value);
            std::fs::write(&scratched, &bytes).unwrap();
            let _ = read(&scratched, 100);
        }
    }
}

fn shapes() -> impl Strategy<Value = Shape> {
    use Corr::{I, Ll, Lr, Q, Rl, Rr, U, V, Xx, Yx, Yy};
    let corrs = prop_oneof![
        Just(vec![I]),
        Just(vec![I, Q, U, V]),
        Just(vec![Yy, Xx]),
        Just(vec![Yx, Xx, Yy]),
        Just(vec![Rr, Rl, Lr, Ll]),
    ];
    // The width of a channel alone has no sign in UVH5.
    let counts = (1usize..400, 1usize..4, 2usize..6, 1usize..4, 1usize..40);
    (counts, corrs, any::<u64>()).prop_map(|(n, corrs, seed)| {
        one_setup(Shape {
            n_antenna: n.0,
            n_if: n.1,
            n_chan_per_if: n.2,
            n_field: n.3,
            n_row: n.4,
            corrs,
            seed,
            ..Shape::default()
        })
    })
}

/// A file that another program writes is waited for, and then refused with words that say so.
#[test]
fn a_file_that_is_locked_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvh5");
    let good = files(&fixtures("good"), "uvh5").remove(0);
    std::fs::copy(good, &path).unwrap();
    let lock = std::fs::File::open(&path).unwrap();
    lock.lock().unwrap();
    let error = read(&path, 9).unwrap_err().to_string();
    assert!(error.contains("HDF5_USE_FILE_LOCKING"), "{error}");
    let holder = std::thread::spawn(move || {
        std::thread::sleep(std::time::Duration::from_millis(200));
        drop(lock);
    });
    read(&path, 9).unwrap();
    holder.join().unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_observation_comes_back(shape in shapes()) {
        check(&shape);
    }

    #[test]
    fn reading_in_pieces_of_any_size_is_the_same(max_row in 1usize..30) {
        for path in files(&fixtures("good"), "uvh5") {
            prop_assert_eq!(read(&path, max_row).unwrap(), read(&path, usize::MAX).unwrap());
        }
    }

    /// UVFITS from UVH5 and back: to the precision of UVFITS.
    #[test]
    fn uvfits_can_stand_between(shape in shapes()) {
        // A STOKES axis has an order of its own.
        let shape = Shape { corrs: vec![Corr::Xx, Corr::Yy], n_field: 1, ..shape };
        let folder = tempfile::tempdir().unwrap();
        let rows = chunk(&shape);
        let uvfits = folder.path().join("a.uvfits");
        let mut writer = Box::new(UvfitsWriter::create(&uvfits, &observation(&shape), false).unwrap());
        writer.write_chunk(&rows).unwrap();
        writer.finish().unwrap();
        let (between, rows_between) = read(&uvfits, 9).unwrap();
        let uvh5 = folder.path().join("a.uvh5");
        write(&uvh5, &between, &rows_between);
        assert_same_rows(&read(&uvh5, 9).unwrap().1, &rows, 1e-9, 0.0);
    }
}
