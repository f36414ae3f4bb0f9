//! `vis2cat convert`: what goes in comes out, whatever the way.

use std::path::Path;

use vis2cat_formats::{Observation, VisChunk, open};

use crate::support::{errors, in_repository, vis2cat, vis2cat_ok};

fn read(path: &Path) -> (Observation, VisChunk) {
    let mut reader = open(path).unwrap();
    let observation = reader.observation().clone();
    let mut chunk = VisChunk::new(observation.n_row as usize + 1);
    let n_row = reader.read_chunk(&mut chunk).unwrap();
    assert_eq!(n_row as u64, observation.n_row);
    (observation, chunk)
}

/// Through every format and back to the first.
#[test]
fn visibilities_survive_a_round_of_all_formats() {
    let folder = tempfile::tempdir().unwrap();
    let first = in_repository("fixtures/ska30.uvfits");
    let (observation, rows) = read(&first);
    let mut from = first;
    let names = if cfg!(feature = "ms") {
        &["a.uvh5", "b.ms", "c.uvh5", "d.uvfits"][..]
    } else {
        &["a.uvh5", "d.uvfits"][..]
    };
    for name in names {
        let to = folder.path().join(name);
        let said = vis2cat_ok(["convert".as_ref(), from.as_os_str(), to.as_os_str()]);
        assert!(said.contains(&format!("{} rows", observation.n_row)));
        let (again, found) = read(&to);
        assert_eq!(found.vis_jy_rfp, rows.vis_jy_rfp, "{name}");
        assert_eq!(found.weight_rfp, rows.weight_rfp, "{name}");
        assert_eq!(found.flag_rfp, rows.flag_rfp, "{name}");
        assert_eq!(
            (&found.ant1_r, &found.ant2_r),
            (&rows.ant1_r, &rows.ant2_r),
            "{name}"
        );
        for (a, b) in found.uvw_m_r.iter().zip(&rows.uvw_m_r) {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{name}");
        }
        for (a, b) in found.time_mjd_r.iter().zip(&rows.time_mjd_r) {
            assert!((a - b).abs() < 1e-9, "{name}");
        }
        let ([field], [wanted]) = (&again.fields[..], &observation.fields[..]) else {
            panic!("{name}: one field");
        };
        assert!((field.ra_rad - wanted.ra_rad).abs() < 1e-12, "{name}");
        assert!((field.dec_rad - wanted.dec_rad).abs() < 1e-12, "{name}");
        let freq_hz = |o: &Observation| o.freq_setups[0].freq_hz_f.clone();
        assert_eq!(freq_hz(&again), freq_hz(&observation), "{name}");
        from = to;
    }
}

#[test]
fn an_output_that_exists_and_an_input_that_does_not_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let (there, missing) = (
        folder.path().join("there.uvh5"),
        folder.path().join("missing.uvfits"),
    );
    std::fs::write(&there, "mine").unwrap();
    let convert =
        |from: &Path, to: &Path| vis2cat(["convert".as_ref(), from.as_os_str(), to.as_os_str()]);
    let done = convert(&in_repository("fixtures/ska30.uvfits"), &there);
    assert_eq!(done.status.code(), Some(4));
    assert!(errors(&done).contains("there.uvh5"));
    assert_eq!(std::fs::read(&there).unwrap(), b"mine");
    let done = convert(&missing, &folder.path().join("out.uvh5"));
    assert_eq!(done.status.code(), Some(3));
    assert!(errors(&done).contains("missing.uvfits"));
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 1, "nothing but what was there");
}

/// Damage on which casacore reads where there is no memory: the program has another one read, and says so.
#[cfg(all(unix, feature = "ms"))]
#[test]
fn a_set_that_ends_its_reader_is_an_error_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let archive = in_repository("fixtures/good/ms_standard_storage.ms.tar.gz");
    let packed = flate2::read::GzDecoder::new(std::fs::File::open(archive).unwrap());
    tar::Archive::new(packed).unpack(folder.path()).unwrap();
    let set = folder.path().join("ms_standard_storage.ms");
    let storage = set.join("table.f12");
    let mut bytes = std::fs::read(&storage).unwrap();
    bytes[530..534].fill(236);
    std::fs::write(&storage, bytes).unwrap();
    let out = folder.path().join("out.uvfits");
    for args in [
        vec!["info".as_ref(), set.as_os_str()],
        vec!["convert".as_ref(), set.as_os_str(), out.as_os_str()],
        vec![set.as_os_str(), out.as_os_str()],
    ] {
        let done = vis2cat(args);
        assert_eq!(done.status.code(), Some(3), "{}", errors(&done));
        assert!(
            errors(&done).contains("ms_standard_storage.ms"),
            "{}",
            errors(&done)
        );
    }
    assert!(!out.exists());
}
