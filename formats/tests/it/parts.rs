//! Readers over readers: parts, averages, several files as one.

use num_complex::Complex;
use std::path::{Path, PathBuf};
use vis2cat_formats::{
    Averaging, Corr, ReadError, ReadOptions, Selection, VisChunk, open_all, open_with, stokes_i,
};

use crate::support::{Shape, chunk, observation, read, read_rows, write};

/// Two IFs of four channels, two fields, rows of four antennas.
fn shape() -> Shape {
    Shape {
        n_antenna: 4,
        n_if: 2,
        n_chan_per_if: 4,
        n_field: 2,
        n_row: 200,
        ..Shape::default()
    }
}

fn written(folder: &Path) -> (PathBuf, VisChunk) {
    let path = folder.join("all.uvfits");
    write(&path, &observation(&shape()), &chunk(&shape()));
    let (_, rows) = read(&path, 1000).unwrap();
    (path, rows)
}

fn select(path: &Path, select: Selection, max_row: usize) -> Result<VisChunk, ReadError> {
    let options = ReadOptions {
        select,
        ..ReadOptions::default()
    };
    let mut reader = open_with(path, &options)?;
    let rows = read_rows(reader.as_mut(), max_row)?;
    assert_eq!(reader.n_row_read(), 200);
    // As often as wanted, and in any helpings.
    reader.rewind()?;
    assert_eq!(read_rows(reader.as_mut(), 7)?, rows);
    Ok(rows)
}

#[test]
fn what_is_selected_is_there_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (path, all) = written(folder.path());
    let (first, last) = (all.time_mjd_r[50], all.time_mjd_r[150]);
    let wanted = Selection {
        field: Some("F1".into()),
        spws: vec![1],
        channels: Some([1, 2]),
        times_mjd: Some([first, last]),
        baselines: vec![("m000".into(), Some("m001".into())), ("4".into(), None)],
        cross_only: true,
        stokes_i: false,
    };
    let found = select(&path, wanted, 1000).unwrap();
    let has = |r: &usize| {
        let (a, b) = (all.ant1_r[*r], all.ant2_r[*r]);
        let pair = (a.min(b), a.max(b));
        all.field_r[*r] == 1 && a != b && (pair == (0, 1) || pair.1 == 3)
    };
    let rows: Vec<usize> = (50..=150).filter(has).collect();
    assert!(rows.len() > 10 && found.n_row == rows.len());
    assert_eq!((found.n_chan, found.n_corr), (2, 2));
    for (to, from) in rows.into_iter().enumerate() {
        assert_eq!(found.uvw_m_r[to], all.uvw_m_r[from]);
        assert_eq!(found.time_mjd_r[to], all.time_mjd_r[from]);
        assert_eq!(found.field_r[to], 0);
        let (to, from) = (to * 4..to * 4 + 4, (from * 8 + 5) * 2..(from * 8 + 7) * 2);
        assert_eq!(found.vis_jy_rfp[to.clone()], all.vis_jy_rfp[from.clone()]);
        assert_eq!(found.weight_rfp[to.clone()], all.weight_rfp[from.clone()]);
        assert_eq!(found.flag_rfp[to], all.flag_rfp[from]);
    }
}

#[test]
fn what_is_not_there_is_told_with_what_is() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = written(folder.path());
    let all = Selection::default;
    let field = Some("F7".into());
    let cases = [
        (
            Selection { field, ..all() },
            "there is no field 'F7'; there are: 0 F0, 1 F1",
        ),
        (
            Selection {
                spws: vec![2],
                ..all()
            },
            "there is no spectral window 2; there are: 0, 1",
        ),
        (
            Selection {
                channels: Some([2, 4]),
                ..all()
            },
            "channels 2 to 4 are not in spectral window 0, which has 4, from 0",
        ),
        (
            Selection {
                baselines: vec![("x".into(), None)],
                ..all()
            },
            "there is no antenna 'x'; there are 4: m000, m001, m002, m003",
        ),
    ];
    for (wanted, why) in cases {
        let error = select(&path, wanted, 10).unwrap_err().to_string();
        assert!(
            error.ends_with(&format!("all.uvfits: selection: {why}")),
            "{error}"
        );
    }
}

#[test]
fn stokes_i_is_made_as_detection_makes_it() {
    let folder = tempfile::tempdir().unwrap();
    let (path, all) = written(folder.path());
    let wanted = Selection {
        stokes_i: true,
        ..Selection::default()
    };
    let found = select(&path, wanted, 10).unwrap();
    let rule = stokes_i(&[Corr::Xx, Corr::Yy]).unwrap();
    for (i, at) in (0..all.vis_jy_rfp.len()).step_by(2).enumerate() {
        let pair = at..at + 2;
        let (vis, weight, flag) = (&all.vis_jy_rfp, &all.weight_rfp, &all.flag_rfp);
        let wanted = rule.apply(&vis[pair.clone()], &weight[pair.clone()], &flag[pair]);
        let there = !found.flag_rfp[i];
        assert_eq!(
            there.then(|| (found.vis_jy_rfp[i], found.weight_rfp[i])),
            wanted
        );
    }
}

/// Rows of one baseline after the other, or of one time after the other.
fn regular(by_time: bool) -> VisChunk {
    let shape = Shape {
        n_row: 12,
        n_chan_per_if: 2,
        ..Shape::default()
    };
    let mut rows = chunk(&shape);
    for r in 0..12 {
        let (time, baseline) = if by_time {
            (r / 2, r % 2)
        } else {
            (r % 6, r / 6)
        };
        rows.time_mjd_r[r] = 60_000.0 + (time as f64 + 0.5) * 2.0 / 86_400.0;
        rows.interval_s_r[r] = 2.0;
        (rows.ant1_r[r], rows.ant2_r[r]) = (0, baseline as u32 + 1);
        let seed = (6 * baseline + time) as f32;
        rows.uvw_m_r[r] = [f64::from(seed), 1.0, -1.0];
        for i in 0..4 {
            let at = 4 * r + i;
            rows.vis_jy_rfp[at] = Complex::new(seed, i as f32);
            rows.flag_rfp[at] = (time, i) == (1, 0) || (baseline, time, i % 2) == (1, 4, 1);
            rows.weight_rfp[at] = if rows.flag_rfp[at] {
                0.0
            } else {
                1.0 + time as f32
            };
        }
    }
    rows
}

#[test]
fn averages_do_not_depend_on_the_order_of_rows() {
    let folder = tempfile::tempdir().unwrap();
    let shape = Shape {
        n_row: 12,
        n_chan_per_if: 2,
        ..Shape::default()
    };
    let average = |by_time: bool| {
        let path = folder.path().join(format!("{by_time}.uvh5"));
        write(&path, &observation(&shape), &regular(by_time));
        let options = ReadOptions {
            average: Averaging {
                time_s: Some(6.0),
                channels: Some(2),
            },
            ..ReadOptions::default()
        };
        let mut reader = open_with(&path, &options).unwrap();
        assert_eq!(
            reader.observation().freq_setups[0].freq_hz_f,
            [1.4e9 + 1.25e5]
        );
        assert_eq!(reader.observation().freq_setups[0].chan_width_hz_f, [5e5]);
        let rows = read_rows(reader.as_mut(), 3).unwrap();
        reader.rewind().unwrap();
        assert_eq!(read_rows(reader.as_mut(), 1).unwrap(), rows);
        rows
    };
    let (by_time, by_baseline) = (average(true), average(false));
    assert_eq!((by_time.n_row, by_baseline.n_row), (4, 4));
    let same = |a: usize, b: usize| {
        assert_eq!(
            by_time.vis_jy_rfp[2 * a..2 * a + 2],
            by_baseline.vis_jy_rfp[2 * b..2 * b + 2]
        );
        assert_eq!(by_time.uvw_m_r[a], by_baseline.uvw_m_r[b]);
        assert!((by_time.time_mjd_r[a] - by_baseline.time_mjd_r[b]).abs() < 1e-11);
    };
    for (a, b) in [(0, 0), (1, 2), (2, 1), (3, 3)] {
        same(a, b);
    }
    // The first baseline's first step: times 0, 1, 2 of weights 1, 2, 3, and in the first channel's
    // first correlation the second time is flagged.
    let weight = [1.0 + 3.0 + 6.0, 6.0 + 6.0];
    assert_eq!(by_time.weight_rfp[..2], weight);
    let re = [
        (2.0 + 6.0 + 2.0 + 6.0 - 2.0) / weight[0],
        (2.0 + 2.0 + 6.0 + 6.0) / weight[1],
    ];
    assert!((by_time.vis_jy_rfp[0].re - re[0]).abs() < 1e-6);
    assert!((by_time.vis_jy_rfp[1].re - re[1]).abs() < 1e-6);
    assert!((by_time.uvw_m_r[0][0] - (3.0 * 2.0 + 4.0 * 3.0 * 2.0) / 22.0).abs() < 1e-12);
    assert_eq!(by_time.interval_s_r, [6.0; 4]);
    assert!((by_time.time_mjd_r[0] - 60_000.0 - 3.0 / 86_400.0).abs() < 1e-10);
}

#[test]
fn channels_that_cannot_be_shared_out_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = written(folder.path());
    let options = ReadOptions {
        average: Averaging {
            time_s: None,
            channels: Some(3),
        },
        ..ReadOptions::default()
    };
    let error = open_with(&path, &options).err().unwrap().to_string();
    assert!(
        error.contains("the 4 channels of spectral window 0 cannot be averaged by 3"),
        "{error}"
    );
}

/// A file of hands, one of other hands, one of Stokes I and one of a single hand, of other antennas.
#[test]
fn files_of_other_correlations_are_read_as_hands() {
    let folder = tempfile::tempdir().unwrap();
    let files = [
        vec![Corr::Xx, Corr::Yy, Corr::Xy, Corr::Yx],
        vec![Corr::Rr, Corr::Ll],
        vec![Corr::I],
        vec![Corr::Yy],
    ];
    let mut paths = Vec::new();
    let mut wanted = Vec::new();
    for (i, corrs) in files.into_iter().enumerate() {
        let shape = Shape {
            corrs: corrs.clone(),
            n_antenna: 3 + i,
            seed: i as u64,
            ..Shape::default()
        };
        let path = folder.path().join(format!("{i}.uvfits"));
        write(&path, &observation(&shape), &chunk(&shape));
        let (_, rows) = read(&path, 100).unwrap();
        let rule = stokes_i(&corrs).unwrap();
        for at in (0..rows.vis_jy_rfp.len()).step_by(corrs.len()) {
            let at = at..at + corrs.len();
            let (vis, weight) = (&rows.vis_jy_rfp[at.clone()], &rows.weight_rfp[at.clone()]);
            wanted.push(rule.apply(vis, weight, &rows.flag_rfp[at]));
        }
        paths.push(path);
    }
    let (mut reader, file_of_setup) = open_all(&paths, &ReadOptions::default()).unwrap();
    assert_eq!(file_of_setup, [0, 1, 2, 3]);
    let observation = reader.observation().clone();
    assert_eq!(observation.corrs, [Corr::Xx, Corr::Yy]);
    assert_eq!((observation.n_row, observation.freq_setups.len()), (40, 4));
    // The third antenna's place depends on nothing but its number.
    assert_eq!(observation.antennas.len(), 6);
    let rows = read_rows(reader.as_mut(), 4).unwrap();
    assert_eq!(rows.freq_setup_r[25], 2);
    let rule = stokes_i(&observation.corrs).unwrap();
    for (i, wanted) in wanted.into_iter().enumerate() {
        let at = 2 * i..2 * i + 2;
        let (vis, weight) = (&rows.vis_jy_rfp[at.clone()], &rows.weight_rfp[at.clone()]);
        assert_eq!(rule.apply(vis, weight, &rows.flag_rfp[at]), wanted);
    }
    reader.rewind().unwrap();
    assert_eq!(read_rows(reader.as_mut(), 100).unwrap(), rows);
}

/// Not phased: read, described, and written as UVH5 only.
#[test]
fn a_drift_scan_is_kept_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut wanted = observation(&Shape::default());
    wanted.fields[0].drifts = true;
    let path = folder.path().join("a.uvh5");
    write(&path, &wanted, &chunk(&Shape::default()));
    let (found, rows) = read(&path, 3).unwrap();
    assert!(found.fields[0].drifts && rows.n_row == 10);
    for name in ["a.uvfits", "a.ms"] {
        let error = vis2cat_formats::create(&folder.path().join(name), &wanted, false);
        let error = error.err().unwrap().to_string();
        assert!(error.contains("not phased (drift scan)"), "{error}");
    }
}
