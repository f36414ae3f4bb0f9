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
