//! What other writers make of the memo.

use num_complex::Complex;
use vis2cat_formats::{Corr, Frame, TimeScale};

use crate::made::{Made, antennas, frequencies, number, text};

const C_M_S: f64 = 299_792_458.0;

fn close(found: f64, wanted: f64) {
    assert!(
        (found - wanted).abs() <= 1e-6 * wanted.abs(),
        "found {found}, wanted {wanted}"
    );
}

#[test]
fn the_plain_file_reads() {
    let (observation, rows) = Made::default().read().unwrap();
    assert_eq!(rows.n_row, 1);
    assert_eq!((rows.ant1_r[0], rows.ant2_r[0]), (0, 1));
    assert_eq!(rows.time_mjd_r, [60_000.25]);
    close(rows.uvw_m_r[0][2], 3e-6 * C_M_S);
    assert_eq!(
        rows.vis_jy_rfp,
        [Complex::new(1.0, 2.0), Complex::new(4.0, 5.0)]
    );
    assert_eq!(rows.weight_rfp, [3.0, 6.0]);
    assert!(rows.interval_s_r[0].is_nan());
    assert_eq!(observation.corrs, [Corr::Xx]);
    assert_eq!(observation.freq_setups[0].freq_hz_f, [1e9, 1.001e9]);
    assert_eq!(observation.antennas[1].itrf_m, [2000.0, 20.0, 2.0]);
    assert_eq!(observation.fields[0].frame, Frame::Fk5(2000.0));
}

#[test]
fn parameters_come_in_any_order_scaled_and_repeated() {
    let made = Made {
        parameters: vec![
            ("DATE", 1.0, 0.0),
            ("WW---SIN", 1e-9, 0.0),
            ("UU---SIN", 1e-9, 0.0),
            ("DATE", 1.0, 0.0),
            ("VV---SIN", 1e-9, 1e-6),
            ("UU---SIN", 1e-12, 0.0),
            ("BASELINE", 1.0, 0.0),
            ("INTTIM", 2.0, 1.0),
        ],
        // A whole Julian date in one float and the day's fraction in another, as CASA writes.
        groups: vec![vec![
            2_460_000.5,
            3.0,
            1.0,
            0.25,
            2.0,
            500.0,
            258.0,
            4.0,
            1.0,
            2.0,
            3.0,
            4.0,
            5.0,
            6.0,
        ]],
        ..Made::default()
    };
    let (_, rows) = made.read().unwrap();
    assert_eq!(rows.time_mjd_r, [60_000.25]);
    assert_eq!(rows.interval_s_r, [9.0]);
    for (found, wanted_s) in rows.uvw_m_r[0].iter().zip([1.5e-9, 1.002e-6, 3e-9]) {
        close(*found, wanted_s * C_M_S);
    }
}

#[test]
fn both_baseline_encodings_may_stand_in_one_file() {
    let made = Made {
        groups: [
            258.0,
            2048.0 + 300.0 + 65_536.0,
            515.0,
            2048.0 * 300.0 + 301.0 + 65_536.0,
        ]
        .iter()
        .map(|&baseline| {
            let mut group = Made::default().groups[0].clone();
            group[3] = baseline;
            group
        })
        .collect(),
        tables: vec![antennas(&[1, 2, 3, 300, 301])],
        ..Made::default()
    };
    let (_, rows) = made.read().unwrap();
    assert_eq!(rows.ant1_r, [0, 0, 1, 3]);
    assert_eq!(rows.ant2_r, [1, 3, 2, 4]);
}

#[test]
fn subarrays_have_their_own_antenna_tables() {
    let mut made = Made::default();
    let mut second = made.groups[0].clone();
    second[3] = 258.01;
    made.groups.push(second);
    let mut table = antennas(&[1, 2]);
    table.cards = vec![
        number("EXTVER", 2.0).replace("2.0", "  2"),
        number("ARRAYX", 7.0),
    ];
    made.tables[0].cards = vec![number("EXTVER", 1.0).replace("1.0", "  1")];
    made.tables.push(table);
    let (observation, rows) = made.read().unwrap();
    assert_eq!(observation.antennas.len(), 5);
    assert_eq!((rows.ant1_r, rows.ant2_r), (vec![0, 3], vec![1, 4]));
    assert_eq!(observation.antennas[3].itrf_m, [1007.0, 10.0, 1.0]);
}

#[test]
fn axes_come_in_any_order() {
    let mut made = Made::default();
    made.axes[1].1 = 2;
    made.axes.swap(1, 2);
    // COMPLEX, FREQ, STOKES: both channels of XX, then both of YY.
    let cell = |n: f64| [n, 0.0, 1.0];
    made.groups[0].truncate(5);
    made.groups[0].extend([1.0, 3.0, 2.0, 4.0].map(cell).concat());
    let (observation, rows) = made.read().unwrap();
    assert_eq!(observation.corrs, [Corr::Xx, Corr::Yy]);
    let real: Vec<f32> = rows.vis_jy_rfp.iter().map(|vis| vis.re).collect();
    assert_eq!(real, [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn a_missing_stokes_axis_means_total_intensity() {
    let mut made = Made::default();
    made.axes.remove(1);
    assert_eq!(made.read().unwrap().0.corrs, [Corr::I]);
}

#[test]
fn without_weights_all_samples_count_alike() {
    let mut made = Made::default();
    made.axes[0].1 = 2;
    made.groups[0].truncate(9);
    let (observation, rows) = made.read().unwrap();
    assert_eq!(
        rows.vis_jy_rfp,
        [Complex::new(1.0, 2.0), Complex::new(3.0, 4.0)]
    );
    assert_eq!(
        (rows.weight_rfp, rows.flag_rfp),
        (vec![1.0; 2], vec![false; 2])
    );
    assert_eq!(
        observation.warnings,
        ["the COMPLEX axis has no weights: all are taken as 1"]
    );
}

#[test]
fn integers_are_scaled_and_may_be_blank() {
    for bitpix in [16, 32] {
        let mut made = Made {
            bitpix,
            ..Made::default()
        };
        made.parameters[0].1 = 1e-9;
        made.parameters[4] = ("DATE", 0.25, 2_460_000.5);
        made.groups[0] = vec![5.0, 0.0, 0.0, 258.0, 1.0, 10.0, -20.0, 4.0, -99.0, 0.0, 4.0];
        made.cards
            .extend([number("BSCALE", 0.5), number("BZERO", 1.0)]);
        made.cards.push("BLANK   =                  -99".into());
        let (_, rows) = made.read().unwrap();
        assert_eq!(rows.vis_jy_rfp[0], Complex::new(6.0, -9.0));
        assert_eq!(rows.weight_rfp, [3.0, 0.0]);
        assert_eq!(rows.flag_rfp, [false, true]);
        assert_eq!(rows.time_mjd_r, [60_000.25]);
        close(rows.uvw_m_r[0][0], 5e-9 * C_M_S);
    }
}

#[test]
fn doubles_are_read() {
    let made = Made {
        bitpix: -64,
        ..Made::default()
    };
    let (_, found) = made.read().unwrap();
    let (_, wanted) = Made::default().read().unwrap();
    assert_eq!(found.vis_jy_rfp, wanted.vis_jy_rfp);
    assert_eq!(found.weight_rfp, wanted.weight_rfp);
    assert_eq!(
        found.uvw_m_r[0],
        [1e-6, 2e-6, 3e-6].map(|seconds| seconds * C_M_S)
    );
}

#[test]
fn wavelengths_are_told_by_name_unless_scaled_to_seconds() {
    for (scale, raw) in [(1.0, 1500.0), (1e-9, 1500.0)] {
        let mut made = Made::default();
        for (parameter, name) in made
            .parameters
            .iter_mut()
            .zip(["UU-L-SIN", "VV-L-SIN", "WW-L-SIN"])
        {
            *parameter = (name, scale, 0.0);
        }
        made.groups[0][0] = raw;
        close(made.read().unwrap().1.uvw_m_r[0][0], 1500.0 * C_M_S / 1e9);
    }
}

#[test]
fn pole_oriented_coordinates_are_turned_to_the_source() {
    let mut made = Made::default();
    for (parameter, name) in made
        .parameters
        .iter_mut()
        .zip(["UU---NCP", "VV---NCP", "WW---NCP"])
    {
        parameter.0 = name;
    }
    let uvw_m = made.read().unwrap().1.uvw_m_r[0];
    // Declination -30 deg.
    let (sin, cos) = (-0.5, 0.75f64.sqrt());
    close(uvw_m[0], 1e-6 * C_M_S);
    close(uvw_m[1], (2e-6 * sin + 3e-6 * cos) * C_M_S);
    close(uvw_m[2], (3e-6 * sin - 2e-6 * cos) * C_M_S);
}

#[test]
fn weights_that_are_no_numbers_flag_and_are_told() {
    let mut made = Made::default();
    made.groups[0][7] = f64::NAN;
    made.groups[0][10] = f64::INFINITY;
    let (observation, rows) = made.read().unwrap();
    assert_eq!(
        (rows.weight_rfp, rows.flag_rfp),
        (vec![0.0; 2], vec![true; 2])
    );
    assert!(
        observation.warnings[0].starts_with("2 samples"),
        "{:?}",
        observation.warnings
    );
}

#[test]
fn frequencies_follow_table_reference_channel_and_sideband() {
    let mut made = Made::default();
    made.axes[2].4 = 2.0;
    made.tables.push(frequencies(&[
        (1, 5e6, 2e6, 1),
        (7, 0.0, -1e6, -1),
        (8, 0.0, 1e6, -1),
    ]));
    made.parameters.push(("FREQSEL", 1.0, 0.0));
    made.groups[0].insert(5, 7.0);
    let (observation, rows) = made.read().unwrap();
    let freq = |i: usize| observation.freq_setups[i].freq_hz_f.clone();
    assert_eq!(freq(0), [1.003e9, 1.005e9]);
    assert_eq!(freq(1), [1.001e9, 1.0e9]);
    assert_eq!(freq(2), [1.001e9, 1.0e9]);
    assert_eq!(rows.freq_setup_r, [1]);
    assert_eq!(observation.warnings.len(), 1);
}

#[test]
fn left_handed_positions_are_mirrored_and_names_cleaned() {
    let mut made = Made::default();
    made.tables[0].cards = vec![
        text("XYZHAND", "LEFT"),
        text("TIMSYS", "IAT"),
        text("FRAME", "?????"),
    ];
    made.tables[0].rows[0][..4].copy_from_slice(b"\x07A!\xe9");
    let (observation, _) = made.read().unwrap();
    assert_eq!(observation.antennas[1].itrf_m, [2000.0, -20.0, 2.0]);
    assert_eq!(observation.antennas[0].name, "A!");
    assert_eq!(observation.time_scale, TimeScale::Tai);
    assert_eq!(observation.warnings, [""; 0]);
}

#[test]
fn frames_go_by_name_then_by_epoch() {
    let frame = |cards: &[String]| {
        let made = Made {
            cards: cards.to_vec(),
            ..Made::default()
        };
        made.read().unwrap().0.fields[0].frame
    };
    assert_eq!(frame(&[]), Frame::Icrs);
    assert_eq!(frame(&[number("EPOCH", 1950.0)]), Frame::Fk4(1950.0));
    assert_eq!(frame(&[number("EQUINOX", 2000.0)]), Frame::Fk5(2000.0));
    assert_eq!(
        frame(&[text("RADESYS", "ICRS"), number("EPOCH", 2000.0)]),
        Frame::Icrs
    );
    assert_eq!(
        frame(&[text("PHSFRAME", "icrs"), number("EPOCH", 2000.0)]),
        Frame::Icrs
    );
    assert_eq!(frame(&[text("RADESYS", "FK4")]), Frame::Fk4(1950.0));
}

#[test]
fn a_source_number_without_a_table_is_the_header_s_source() {
    let mut made = Made::default();
    made.parameters.push(("SOURCE", 1.0, 0.0));
    made.groups[0].insert(5, 3.0);
    let (observation, rows) = made.read().unwrap();
    assert_eq!(rows.field_r, [0]);
    assert_eq!(observation.warnings.len(), 1);
}

#[test]
fn what_follows_the_last_table_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uvfits");
    let mut bytes = Made::default().bytes();
    bytes.extend([b'Z'; 100]);
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(crate::support::read(&path, 3).unwrap().1.n_row, 1);
}
