//! Measurement Sets.

use vis2cat_formats::{
    Corr, MsWriter, Observation, ReadOptions, VisChunk, VisWriter, WriteError, open_with,
};

use crate::support::{
    Fixture, Shape, chunk, files_below, fixtures, is_about_direction, names, observation, read,
    read_rows, unpack, write,
};

/// A set of `fixtures/good`.
fn good(name: &str) -> Fixture {
    unpack(&fixtures(&format!("good/ms_{name}.ms.tar.gz")))
}

/// What there is in a set's place in seconds comes back in days: to the last bit or so.
fn assert_same_rows(found: &VisChunk, wanted: &VisChunk) {
    let mut found = found.clone();
    found.max_row = wanted.max_row;
    for (found, wanted) in found.time_mjd_r.iter_mut().zip(&wanted.time_mjd_r) {
        assert!((*found - wanted).abs() <= 1e-11, "{found} {wanted}");
        *found = *wanted;
    }
    assert_eq!(&found, wanted);
}

fn round_trip(shape: &Shape) -> (Observation, VisChunk) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ms");
    write(&path, &observation(shape), &chunk(shape));
    read(&path, 7).unwrap()
}

#[test]
fn the_same_observation_is_the_same_in_all_formats() {
    for name in ["small", "large_numbers"] {
        let (ms, ms_rows) = read(&good(name).path, 100).unwrap();
        for other in [
            format!("pyuvdata_{name}.uvfits"),
            format!("uvh5_{name}.uvh5"),
        ] {
            let (observation, mut rows) = read(&fixtures("good").join(&other), 100).unwrap();
            // Seconds in 48 bits in UVFITS; Julian dates in 64 in UVH5 (40 μs).
            let pairs = ms_rows
                .uvw_m_r
                .iter()
                .flatten()
                .zip(rows.uvw_m_r.iter().flatten());
            pairs.for_each(|(a, b)| assert!((a - b).abs() <= 1e-9, "{other}: {a} {b}"));
            let pairs = ms_rows.time_mjd_r.iter().zip(&rows.time_mjd_r);
            pairs.for_each(|(a, b)| assert!((a - b).abs() <= 1e-9, "{other}: {a} {b}"));
            rows.uvw_m_r.clone_from(&ms_rows.uvw_m_r);
            rows.time_mjd_r.clone_from(&ms_rows.time_mjd_r);
            let order: Vec<usize> = (ms.corrs.iter())
                .map(|corr| observation.corrs.iter().position(|c| c == corr).unwrap())
                .collect();
            assert_eq!(ms_rows, reordered(&rows, &order), "{other}");
            assert_eq!(ms.freq_setups, observation.freq_setups);
            assert_eq!(ms.antennas.len(), observation.antennas.len());
            for (a, b) in ms.antennas.iter().zip(&observation.antennas) {
                assert_eq!((a.number, &a.name), (b.number, &b.name));
                assert!((0..3).all(|d| (a.itrf_m[d] - b.itrf_m[d]).abs() < 1e-6));
            }
        }
    }
}

/// The rows with their correlations in another order.
fn reordered(rows: &VisChunk, order: &[usize]) -> VisChunk {
    fn take<T: Copy>(values: &[T], order: &[usize]) -> Vec<T> {
        let channels = values.chunks(order.len());
        channels
            .flat_map(|channel| order.iter().map(|&p| channel[p]))
            .collect()
    }
    VisChunk {
        vis_jy_rfp: take(&rows.vis_jy_rfp, order),
        weight_rfp: take(&rows.weight_rfp, order),
        flag_rfp: take(&rows.flag_rfp, order),
        ..rows.clone()
    }
}

#[test]
fn what_we_write_we_read() {
    let shapes = [
        Shape::default(),
        Shape {
            n_field: 3,
            n_setup: 2,
            n_chan_per_if: 1,
            n_row: 300,
            corrs: vec![Corr::Rr],
            ..Shape::default()
        },
        Shape {
            n_antenna: 400,
            n_chan_per_if: 17,
            n_row: 5000,
            corrs: vec![Corr::I, Corr::Q, Corr::U, Corr::V],
            ..Shape::default()
        },
    ];
    for shape in shapes {
        let (found, rows) = round_trip(&shape);
        assert_same_rows(&rows, &chunk(&shape));
        let mut wanted = observation(&shape);
        // What there is no place for; antennas are known by their rows.
        wanted.instrument.clear();
        wanted.earth = found.earth;
        wanted.ms.clone_from(&found.ms);
        wanted.array_position_m = found.array_position_m;
        for (row, antenna) in wanted.antennas.iter_mut().enumerate() {
            antenna.number = row as u32;
        }
        let mut found = found;
        found
            .warnings
            .retain(|warning| !is_about_direction(warning));
        assert_eq!(found, wanted);
    }
}

#[test]
fn correlations_are_written_in_the_order_of_their_numbers() {
    use Corr::{Ll, Lr, Rl, Rr};
    let shape = Shape {
        corrs: vec![Rr, Ll, Rl, Lr],
        ..Shape::default()
    };
    let (found, rows) = round_trip(&shape);
    assert_eq!(found.corrs, [Rr, Rl, Lr, Ll]);
    assert_same_rows(&rows, &reordered(&chunk(&shape), &[0, 2, 3, 1]));
}

#[test]
fn ifs_become_spectral_windows() {
    let shape = Shape {
        n_if: 2,
        n_setup: 2,
        ..Shape::default()
    };
    let (found, rows) = round_trip(&shape);
    let (wanted, written) = (observation(&shape), chunk(&shape));
    assert_eq!(found.freq_setups.len(), 4);
    assert_eq!(
        found.freq_setups[1].freq_hz_f,
        wanted.freq_setups[0].freq_hz_f[3..]
    );
    assert_eq!((found.n_row, rows.n_chan), (20, 3));
    for (row, setup) in written.freq_setup_r.iter().enumerate() {
        assert_eq!(rows.freq_setup_r[row], 2 * setup);
        assert_eq!(rows.freq_setup_r[10 + row], 2 * setup + 1);
        assert_eq!(rows.ant1_r[10 + row], written.ant1_r[row]);
        let half = 3 * shape.corrs.len();
        let from = written.vis_jy_rfp[2 * half * row..].chunks(half);
        let found = [row, 10 + row].map(|row| &rows.vis_jy_rfp[half * row..half * (row + 1)]);
        from.zip(found)
            .for_each(|(wanted, found)| assert_eq!(found, wanted));
    }
}

/// Windows of 1, 2 and 3 channels: a chunk has rows of one length.
#[test]
fn windows_may_be_of_any_lengths() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ms");
    let (from, written) = read(&fixtures("good/uvh5_unequal_windows.uvh5"), 100).unwrap();
    write(&path, &from, &written);
    let mut reader = open_with(&path, &ReadOptions::default()).unwrap();
    let lengths: Vec<usize> = reader
        .observation()
        .freq_setups
        .iter()
        .map(|s| s.freq_hz_f.len())
        .collect();
    assert_eq!(lengths, [1, 2, 3]);
    assert_eq!(
        reader.observation().freq_setups[2].chan_width_hz_f,
        [-1e6; 3]
    );
    let (mut chunk, mut n_value) = (VisChunk::new(1000), 0);
    for wanted in lengths {
        assert_eq!(reader.read_chunk(&mut chunk).unwrap(), written.n_row);
        assert_eq!(chunk.n_chan, wanted);
        n_value += chunk.vis_jy_rfp.len();
    }
    assert_eq!(reader.read_chunk(&mut chunk).unwrap(), 0);
    assert_eq!(n_value, written.vis_jy_rfp.len());
}

#[test]
fn the_column_of_visibilities_can_be_chosen() {
    let set = good("corrected");
    let first = |column: Option<&str>| {
        let options = ReadOptions {
            data_column: column.map(str::to_owned),
            ..ReadOptions::default()
        };
        let mut reader = open_with(&set.path, &options)?;
        let rows = read_rows(reader.as_mut(), 100)?;
        let read = reader
            .observation()
            .ms
            .as_ref()
            .unwrap()
            .data_column
            .clone();
        Ok::<_, vis2cat_formats::ReadError>((read, rows.vis_jy_rfp[5]))
    };
    let (read, plain) = first(Some("DATA")).unwrap();
    assert_eq!(read, "DATA");
    assert_eq!(first(None).unwrap(), ("CORRECTED_DATA".into(), plain * 2.0));
    assert_eq!(first(Some("MODEL_DATA")).unwrap().1, plain * 3.0);
    let error = first(Some("NOTHING")).unwrap_err().to_string();
    assert!(
        error.ends_with("table MAIN, column NOTHING: is missing"),
        "{error}"
    );
    let options = ReadOptions {
        data_column: Some("DATA".into()),
        ..ReadOptions::default()
    };
    assert!(open_with(&fixtures("good/uvh5_small.uvh5"), &options).is_err());
}

#[test]
fn weights_are_taken_from_the_first_column_that_is_filled() {
    for (name, wanted) in [
        ("small", "WEIGHT_SPECTRUM"),
        ("empty_columns", "WEIGHT"),
        ("sigma", "SIGMA_SPECTRUM"),
    ] {
        let (observation, _) = read(&good(name).path, 100).unwrap();
        let notes = observation.ms.unwrap();
        assert_eq!(
            (notes.data_column.as_str(), notes.weight_column.as_str()),
            ("DATA", wanted)
        );
    }
}

#[test]
fn baselines_turned_round_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let (observation, mut rows) = read(&good("small").path, 100).unwrap();
    assert_eq!(observation.warnings, [""; 0]);
    for uvw_m in &mut rows.uvw_m_r {
        *uvw_m = uvw_m.map(|x| -x);
    }
    let path = folder.path().join("a.ms");
    write(&path, &observation, &rows);
    let (observation, found) = read(&path, 100).unwrap();
    assert!(observation.warnings[0].starts_with("UVW run from antenna 1 to antenna 2"));
    assert_eq!(found.uvw_m_r, rows.uvw_m_r);
}

/// `table.dat` of a table that is the set beside it twice, as casacore 3.5 wrote it.
const TWICE: &[&[u8]] = &[
    b"\xbe\xbe\xbe\xbe\0\0\0\x7a\0\0\0\x05Table\0\0\0\x02\0\0\0\x3c\0\0\0\0",
    b"\0\0\0\x0bConcatTable\0\0\0\x52\0\0\0\x0bConcatTable\0\0\0\0\0\0\0\x02",
    b"\0\0\0\x0d./ms_small.ms\0\0\0\x0d./ms_small.ms",
    b"\0\0\0\x15\0\0\0\x05Block\0\0\0\x01\0\0\0\0",
];

#[test]
fn sets_may_be_put_together_without_their_rows() {
    let set = good("small");
    let twice = set.path.with_file_name("twice.ms");
    std::fs::create_dir(&twice).unwrap();
    std::fs::write(twice.join("table.dat"), TWICE.concat()).unwrap();
    let (_, once) = read(&set.path, 100).unwrap();
    let (observation, found) = read(&twice, 100).unwrap();
    assert_eq!(observation.antennas.len(), 4);
    assert_eq!(found.n_row, 2 * once.n_row);
    assert_eq!(found.vis_jy_rfp, [&once.vis_jy_rfp[..]; 2].concat());

    // casacore would not see that.
    let manager = std::fs::read(set.path.join("table.f9")).unwrap();
    std::fs::write(set.path.join("table.f9"), &manager[..20]).unwrap();
    let error = read(&twice, 100).unwrap_err().to_string();
    assert!(error.contains("ms_small.ms: table.f9: "), "{error}");
}

#[test]
fn the_sizes_of_chunks_make_no_difference() {
    let shape = Shape {
        n_row: 100,
        ..Shape::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let (observation, rows) = (observation(&shape), chunk(&shape));
    let whole = folder.path().join("a.ms");
    write(&whole, &observation, &rows);
    let pieces = folder.path().join("b.ms");
    let mut writer = Box::new(MsWriter::create(&pieces, &observation, false).unwrap());
    let mut reader = open_with(&whole, &ReadOptions::default()).unwrap();
    let mut piece = VisChunk::new(7);
    while reader.read_chunk(&mut piece).unwrap() > 0 {
        writer.write_chunk(&piece).unwrap();
    }
    writer.finish().unwrap();
    let (whole_files, files) = (files_below(&whole), files_below(&pieces));
    assert!(whole_files.keys().eq(files.keys()));
    for (name, bytes) in whole_files {
        // casacore leaves gaps in some, and what is in them to chance; locks say who holds them.
        let is_left_to_chance = name.contains(".f0i") || name.ends_with("table.lock");
        assert!(is_left_to_chance || files[&name] == bytes, "{name}");
    }
    assert_eq!(read(&whole, 3).unwrap(), read(&pieces, 1000).unwrap());
}

#[test]
fn a_set_is_whole_or_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ms");
    let shape = Shape::default();
    let observation = observation(&shape);
    let create = |overwrite| MsWriter::create(&path, &observation, overwrite);
    let mut writer = create(false).unwrap();
    writer.write_chunk(&chunk(&shape)).unwrap();
    assert!(!path.exists());
    drop(writer);
    assert!(names(folder.path()).is_empty());
    let error = Box::new(create(false).unwrap()).finish().unwrap_err();
    assert!(
        error
            .to_string()
            .ends_with("a Measurement Set cannot be empty")
    );
    write(&path, &observation, &chunk(&shape));
    assert!(matches!(create(false), Err(WriteError::Exists { .. })));
    let mut writer = Box::new(create(true).unwrap());
    writer.write_chunk(&chunk(&shape)).unwrap();
    writer.finish().unwrap();
    assert_eq!(names(folder.path()), ["a.ms"]);
    assert_eq!(read(&path, 100).unwrap().1.n_row, shape.n_row);
}

/// casacore itself crashes on two threads with the same table.
#[test]
fn a_set_may_be_read_by_many_threads() {
    let set = good("small");
    let wanted = read(&set.path, 100).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for max_row in 1..20 {
                    assert_eq!(read(&set.path, max_row).unwrap(), wanted);
                }
            });
        }
    });
}

#[test]
fn a_missing_table_is_named() {
    for name in [
        "ANTENNA",
        "DATA_DESCRIPTION",
        "FIELD",
        "OBSERVATION",
        "POLARIZATION",
        "SPECTRAL_WINDOW",
    ] {
        let set = good("small");
        std::fs::remove_dir_all(set.path.join(name)).unwrap();
        let error = read(&set.path, 100).unwrap_err().to_string();
        assert!(
            error.contains(&format!("table {name}: is missing")),
            "{error}"
        );
    }
    let set = good("small");
    std::fs::remove_file(set.path.join("table.dat")).unwrap();
    let error = read(&set.path, 100).unwrap_err().to_string();
    assert!(
        error.ends_with("is no Measurement Set (there is no table.dat in it)"),
        "{error}"
    );
    let error = read(&good("small").path.join("FIELD"), 100)
        .unwrap_err()
        .to_string();
    assert!(error.ends_with("it is no Measurement Set"), "{error}");
}
