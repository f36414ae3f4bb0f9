//! Files of other software, where the machine has them; they are not part of the repository.

use std::path::Path;

use crate::support::read;

/// File, rows, channels, correlations, antennas, flagged samples: from pyuvdata 3.2.8.
const FILES: [(&str, usize, usize, usize, usize); 7] = [
    ("1061316296", 16256, 1, 4, 128),
    ("1131733552_mini_cotter", 8256, 1, 4, 128),
    ("1133866760", 5565, 11, 4, 128),
    ("mojave", 3150, 2, 4, 10),
    ("ref_1.1_uniform", 3916, 1, 4, 88),
    ("test_redundant_array", 1071, 21, 1, 61),
    ("zen.2456865.60537.xy.uvcRREAAM", 285, 11, 1, 64),
];

#[test]
fn files_of_other_software_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    for (name, n_row, n_chan, n_corr, n_antenna) in FILES {
        let path = folder.join(format!("{name}.uvfits"));
        if !path.is_file() {
            continue;
        }
        let (observation, rows) = read(&path, 1000).unwrap();
        let shape = (
            rows.n_row,
            rows.n_chan,
            rows.n_corr,
            observation.antennas.len(),
        );
        assert_eq!(shape, (n_row, n_chan, n_corr, n_antenna), "{name}");
        // Miriad's file has positions in a frame of its own.
        let told = observation
            .warnings
            .iter()
            .any(|w| w.contains("do not agree with the antenna"));
        assert_eq!(told, name.starts_with("zen"), "{name}");
        assert_eq!(
            observation.warnings.len(),
            usize::from(told),
            "{:?}",
            observation.warnings
        );
        let all_flagged = rows.flag_rfp.iter().all(|&flag| flag);
        // By pyuvdata: every flag of the three MWA files is set.
        let expected = name.starts_with('1');
        assert_eq!(all_flagged, expected, "{name}");
    }
}

/// File, rows, channels, correlations and antennas by pyuvdata 3.2.8.
const UNPHASED: [(&str, [usize; 4]); 3] = [
    ("simulated_bda_file", [17, 4, 2, 52]),
    ("zen.2458098.45361.HH_downselected", [360, 64, 2, 52]),
    ("zen.2458432.34569", [80, 64, 4, 6]),
];

#[test]
fn uvh5_files_of_correlators_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    for (name, wanted) in UNPHASED {
        let path = folder.join(format!("{name}.uvh5"));
        if path.is_file() {
            let (observation, rows) = read(&path, 1000).unwrap();
            let n_antenna = observation.antennas.len();
            let found = [rows.n_row, rows.n_chan, rows.n_corr, n_antenna];
            assert_eq!(found, wanted, "{name}");
            assert!(observation.fields.iter().all(|field| field.drifts));
        }
    }
    let path = folder.join("ata.LoA.C0352.uvh5_60647_62965_9760406_3c286_0001.uvh5");
    if path.is_file() {
        let (observation, rows) = read(&path, 100).unwrap();
        assert_eq!((rows.n_row, rows.n_chan, rows.n_corr), (406, 16, 4));
        assert_eq!(observation.antennas.len(), 42);
        assert_eq!(observation.fields[0].name, "3c286");
        // Its nsamples are -1.2e12 throughout; the baselines run as they should.
        assert_eq!(observation.warnings.len(), 2, "{:?}", observation.warnings);
        assert!(observation.warnings[1].starts_with("no nsample is positive"));
        let n_flagged = rows.flag_rfp.iter().filter(|&&flag| flag).count();
        assert_eq!(n_flagged, 0);
    }
}
