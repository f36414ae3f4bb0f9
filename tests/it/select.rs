//! What makes a mode a source: `--select`.

use std::path::Path;

use vis2cat_formats::fits::{Table, read_table};

use crate::support::{errors, simulate, vis2cat, vis2cat_ok};

/// Two galaxies, the first of a signal-to-noise ratio of some 9.
const SKY: &str = "\
RA,DEC,Total_flux,Scale_length,E1,E2
53.1035,30.0025,60,1,0.2,0.1
53.0960,29.9970,400,2,0,0
";
const SEARCH: &str = "--fov 1arcmin --tile-size 20arcsec --n-live 50 --overwrite";

fn find(data: &Path, more: &str) -> Table {
    let out = data.with_file_name("out.fits");
    let command = format!("{} {} {SEARCH} {more}", data.display(), out.display());
    vis2cat_ok(command.split_whitespace());
    read_table(&out, Some("CATALOGUE")).unwrap()
}

fn modes(data: &Path) -> Table {
    read_table(&data.with_file_name("out.fits"), Some("MODES")).unwrap()
}

/// Value of a column for the faintest row.
fn faintest(table: &Table, name: &str) -> f64 {
    let flux = table.numbers("Total_flux").unwrap();
    let row = (0..flux.len()).min_by(|&a, &b| flux[a].total_cmp(&flux[b]));
    table.numbers(name).unwrap()[row.unwrap()]
}

/// Part of a power law of index -1.34 from 10 uJy to 1 mJy that lies below.
fn below(flux_ujy: f64) -> f64 {
    let power = |s: f64| s.powf(-0.34);
    (power(10.0) - power(flux_ujy)) / (power(10.0) - power(1000.0))
}

/// Two runs, with the prior below and above the limit, their evidences and prior odds (Malyali et al. 2018,
/// equation 12), and the one run with the whole prior that stands for both.
#[test]
fn one_run_tells_what_two_with_the_prior_cut_in_two_would() {
    let folder = tempfile::tempdir().unwrap();
    let one = SKY.lines().take(2).collect::<Vec<_>>().join("\n");
    let data = simulate(folder.path(), &one);
    let log_z = |table: &Table| [faintest(table, "Log_Z"), faintest(table, "E_Log_Z")];
    let low = log_z(&find(&data, "--flux 10uJy:60uJy --snr-cut 5"));
    let high = log_z(&find(&data, "--flux 60uJy:1mJy --snr-cut 5"));
    let whole = find(
        &data,
        "--flux 10uJy:1mJy --select bayes --flux-cut 60uJy --p-cut 0",
    );
    let odds = (high[0] - low[0]).exp() * (1.0 - below(60.0)) / below(60.0);
    let bright = faintest(&whole, "P_above") / faintest(&whole, "P_source");
    let log_odds = (bright / (1.0 - bright)).ln();
    let error = low[1].hypot(high[1]).max(0.1);
    assert!(
        log_odds.abs() < 3.0,
        "the source is not at the limit: {bright}"
    );
    assert!(
        (odds.ln() - log_odds).abs() < 4.0 * error,
        "{} {log_odds} {error}",
        odds.ln()
    );
    let sum = (low[0].exp() * below(60.0) + high[0].exp() * (1.0 - below(60.0))).ln();
    assert!(
        (sum - faintest(&whole, "Log_Z")).abs() < 4.0 * error,
        "{sum}"
    );
}

#[test]
fn a_flux_limit_selects_by_mean_or_by_probability() {
    let folder = tempfile::tempdir().unwrap();
    let data = simulate(folder.path(), SKY);
    let flux = |table: &Table| table.numbers("Total_flux").unwrap();
    let both = "--flux 10uJy:1mJy --flux-cut";
    for (limit, n) in [("20uJy", 2), ("200uJy", 1)] {
        assert_eq!(flux(&find(&data, &format!("{both} {limit}"))).len(), n);
        let by_probability = find(&data, &format!("{both} {limit} --select bayes"));
        assert_eq!(flux(&by_probability).len(), n);
        let above = by_probability.numbers("P_above").unwrap();
        assert!(above.iter().all(|p| *p > 0.99), "{above:?}");
    }
    // The faint one was a source, but not a bright one.
    let modes = modes(&data);
    let status = modes.strings("Status").unwrap();
    let unlikely = status.iter().position(|s| s == "unlikely").unwrap();
    assert!(modes.numbers("P_source").unwrap()[unlikely] > 0.99);
    assert!((modes.numbers("Total_flux").unwrap()[unlikely] - 60.0).abs() < 40.0);
}

#[test]
fn what_is_more_probably_noise_is_a_mode_below_half() {
    let folder = tempfile::tempdir().unwrap();
    let data = simulate(folder.path(), SKY);
    let search = "--flux 10uJy:1mJy --snr-cut 2.6";
    let all = find(&data, search).rows();
    let likely = find(&data, &format!("{search} --select p-source"));
    assert!(likely.rows() < all, "{all} rows");
    assert!(likely.numbers("P_source").unwrap().iter().all(|p| *p > 0.5));
    let modes = modes(&data);
    let status = modes.strings("Status").unwrap();
    let p_source = modes.numbers("P_source").unwrap();
    let unlikely = (0..status.len()).filter(|&i| status[i] == "unlikely");
    let p_unlikely: Vec<f64> = unlikely.map(|i| p_source[i]).collect();
    assert_eq!(p_unlikely.len() + likely.rows(), all);
    assert!(p_unlikely.iter().all(|p| *p <= 0.5), "{p_unlikely:?}");
}

#[test]
fn a_selection_without_its_cut_is_an_error_that_says_what_to_give() {
    for select in ["flux", "bayes"] {
        let done = vis2cat(["a.uvfits", "b.fits", "--select", select]);
        assert_eq!(done.status.code(), Some(2));
        assert!(errors(&done).contains("--flux-cut"), "{}", errors(&done));
    }
}
