//! The writer's promises: nothing half-done under the final name, no surprise to what is there.

use std::process::Command;

use fitsio::FitsFile;
use vis2cat_formats::{Corr, UvfitsWriter, VisChunk, VisWriter, WriteError};

use crate::support::{Shape, chunk, names, observation, read, write};

#[test]
fn a_dropped_writer_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let shape = Shape::default();
    let mut writer = UvfitsWriter::create(&path, &observation(&shape), false).unwrap();
    writer.write_chunk(&chunk(&shape)).unwrap();
    let hidden = names(folder.path());
    assert!(
        hidden.len() == 1 && hidden[0].starts_with('.'),
        "{hidden:?}"
    );
    drop(writer);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn what_is_there_is_kept_unless_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let shape = Shape::default();
    std::fs::write(&path, "precious").unwrap();
    let refused = UvfitsWriter::create(&path, &observation(&shape), false);
    assert!(matches!(refused, Err(WriteError::Exists { .. })));

    let mut writer = Box::new(UvfitsWriter::create(&path, &observation(&shape), true).unwrap());
    writer.write_chunk(&chunk(&shape)).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
    writer.finish().unwrap();
    assert_eq!(read(&path, 100).unwrap().1.n_row, shape.n_row);
    assert_eq!(names(folder.path()), ["a.uvfits"]);
}

#[test]
fn a_file_that_came_meanwhile_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let shape = Shape::default();
    let mut writer = Box::new(UvfitsWriter::create(&path, &observation(&shape), false).unwrap());
    writer.write_chunk(&chunk(&shape)).unwrap();
    std::fs::write(&path, "precious").unwrap();
    assert!(matches!(writer.finish(), Err(WriteError::Exists { .. })));
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
}

#[test]
fn rows_may_come_in_many_chunks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let shape = Shape::default();
    let rows = chunk(&shape);
    let mut writer = Box::new(UvfitsWriter::create(&path, &observation(&shape), false).unwrap());
    for _ in 0..3 {
        writer.write_chunk(&rows).unwrap();
        writer.write_chunk(&VisChunk::new(1)).unwrap();
    }
    writer.finish().unwrap();
    let (observation, found) = read(&path, 4).unwrap();
    assert_eq!(observation.n_row, 30);
    assert_eq!(
        found.vis_jy_rfp[found.vis_jy_rfp.len() / 3..][..rows.vis_jy_rfp.len()],
        rows.vis_jy_rfp
    );
}

#[test]
fn what_does_not_fit_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let shape = Shape::default();
    let good = observation(&shape);
    let refused = |change: fn(&mut vis2cat_formats::Observation)| {
        let mut observation = good.clone();
        change(&mut observation);
        let error = UvfitsWriter::create(&path, &observation, false)
            .unwrap_err()
            .to_string();
        error
            .strip_prefix(&format!("{}: ", path.display()))
            .unwrap()
            .to_owned()
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
        refused(|o| o.freq_setups.clear()),
        "the observation has no frequencies"
    );
    assert_eq!(
        refused(|o| o.corrs.clear()),
        "the observation has no correlations"
    );
    assert_eq!(
        refused(|o| o.corrs = vec![Corr::Rr, Corr::Xx, Corr::Lr]),
        "correlations [Rr, Xx, Lr] are no series that a STOKES axis can hold"
    );
    assert_eq!(
        refused(|o| o.freq_setups[0].freq_hz_f[1] += 1e5),
        "channel 2 is at 1400350000 Hz, 1400250000 Hz would be even spacing; UVFITS can hold no other"
    );
    let mut rows = chunk(&shape);
    rows.ant1_r[4] = 99;
    let mut writer = UvfitsWriter::create(&path, &good, false).unwrap();
    let error = writer.write_chunk(&rows).unwrap_err().to_string();
    assert!(error.ends_with("row 5: antenna 99 of 5"), "{error}");
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let mut rows = chunk(&shape);
        rows.time_mjd_r[2] = bad;
        assert!(writer.write_chunk(&rows).is_err());
        let mut rows = chunk(&shape);
        rows.uvw_m_r[2][1] = bad;
        assert!(writer.write_chunk(&rows).is_err());
    }
    let empty = Box::new(writer).finish().unwrap_err().to_string();
    assert!(
        empty.ends_with("no row was written; UVFITS cannot be empty"),
        "{empty}"
    );
}

/// An independent reader, on a name that CFITSIO would not take for a plain path.
#[test]
fn cfitsio_reads_our_tables() {
    let folder = tempfile::tempdir().unwrap();
    let odd = folder.path().join("a[1].uvfits");
    let shape = Shape::default();
    let wanted = observation(&shape);
    write(&odd, &wanted, &chunk(&shape));
    assert_eq!(read(&odd, 100).unwrap().0.antennas, wanted.antennas);

    let plain = folder.path().join("a.uvfits");
    std::fs::rename(&odd, &plain).unwrap();
    let mut fits = FitsFile::open(&plain).unwrap();
    let table = fits.hdu("AIPS AN").unwrap();
    let numbers: Vec<i32> = table.read_col(&mut fits, "NOSTA").unwrap();
    assert_eq!(numbers, [1, 2, 3, 4, 5]);
    let names: Vec<String> = table.read_col(&mut fits, "ANNAME").unwrap();
    assert_eq!(names[3], "m003");
    for key in ["TIMESYS", "TIMSYS"] {
        let scale: String = table.read_key(&mut fits, key).unwrap();
        assert_eq!(scale.trim(), "UTC");
    }
    let primary = fits.primary_hdu().unwrap();
    let n_group: i64 = primary.read_key(&mut fits, "GCOUNT").unwrap();
    assert_eq!(n_group, 10);
}

/// Where the machine has the verifier of the FITS standard's authors.
#[test]
fn fitsverify_finds_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let shape = Shape {
        n_antenna: 300,
        n_if: 2,
        n_field: 3,
        n_setup: 2,
        n_row: 50,
        corrs: vec![Corr::Rr, Corr::Ll, Corr::Rl, Corr::Lr],
        ..Shape::default()
    };
    write(&path, &observation(&shape), &chunk(&shape));
    let Ok(output) = Command::new("fitsverify")
        .args(["-e", "-q"])
        .arg(&path)
        .output()
    else {
        return;
    };
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
}
