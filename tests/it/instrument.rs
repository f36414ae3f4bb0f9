//! Smearing, primary beam and spectral index, from simulation to catalogue.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use vis2cat::catalogue::CataloguePaths;
use vis2cat_formats::fits::read_table;
use vis2cat_formats::{UvfitsWriter, VisChunk, VisWriter, open};

use crate::support::{errors, vis2cat, vis2cat_ok};

/// 0.64 degrees from the phase centre.
const FAR: &str = "\
RA[deg],DEC[deg],Total_flux[mJy],Scale_length[arcsec],E1,E2
53.6,-30.48,5.0,3.0,0.1,0.2
";

fn simulated(sky: &str, to: PathBuf, more: &str) -> PathBuf {
    let list = to.with_extension("csv");
    std::fs::write(&list, sky).unwrap();
    let command = format!(
        "simulate {} --array meerkat --catalogue {} {more} --quiet",
        to.display(),
        list.display()
    );
    vis2cat_ok(command.split_whitespace());
    to
}

/// Every value of a file, and their (channel) frequencies.
fn read(path: &Path) -> (VisChunk, Vec<f64>) {
    let mut reader = open(path).unwrap();
    let mut chunk = VisChunk::new(reader.observation().n_row as usize + 1);
    let n_row = reader.read_chunk(&mut chunk).unwrap();
    assert_eq!(n_row as u64, reader.observation().n_row);
    (chunk, reader.observation().freq_setups[0].freq_hz_f.clone())
}

/// Visibilities of short times and narrow channels, averaged by `convert`, are smeared.
#[test]
fn averages_of_fine_visibilities_are_what_smearing_says() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let band = "--freq 1.28GHz --bandwidth 26MHz --hands i --no-noise --hours 0.0022222222";
    let fine = simulated(
        FAR,
        at("fine.uvh5"),
        &format!("{band} --tint 0.5s --channels 64"),
    );
    let command = format!(
        "convert {} {} --average-time 8s --average-channels 32",
        fine.display(),
        at("averaged.uvh5").display()
    );
    vis2cat_ok(command.split_whitespace());
    let coarse = format!("{band} --tint 8s --channels 2");
    let with = simulated(FAR, at("with.uvh5"), &format!("{coarse} --smearing"));
    let without = simulated(FAR, at("without.uvh5"), &coarse);
    let [averaged, with, without] =
        [&at("averaged.uvh5"), &with, &without].map(|path| read(path).0);
    assert_eq!(averaged.ant1_r, with.ant1_r);
    let largest = |other: &VisChunk| {
        let values = averaged.vis_jy_rfp.iter().zip(&other.vis_jy_rfp);
        values.fold(0.0, |largest: f32, (a, b)| largest.max((a - b).norm()))
    };
    // Of 5 mJy.
    assert!(largest(&with) < 1e-5, "{}", largest(&with));
    assert!(largest(&without) > 1e-3, "{}", largest(&without));
}

/// The beam by the Bessel function's own integral, the spectrum by its power.
#[test]
fn a_beam_and_a_spectrum_multiply_visibilities() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let band = "--freq 1.284GHz --bandwidth 856MHz --channels 4 --hands i --no-noise \
                --hours 0.0022222222 --tint 8s";
    let plain = simulated(FAR, at("plain.uvh5"), band);
    let more = format!("{band} --beam airy=13.5m --spectral-index");
    let seen = simulated(FAR, at("seen.uvh5"), &more);
    let ((plain, freqs_hz), (seen, _)) = (read(&plain), read(&seen));
    let (ra, dec) = (0.5f64.to_radians(), -30.48f64.to_radians());
    let dec0 = -30f64.to_radians();
    let cos_rho = dec.sin() * dec0.sin() + dec.cos() * dec0.cos() * ra.cos();
    let sin_rho = (1.0 - cos_rho * cos_rho).sqrt();
    let j1 = |x: f64| {
        let n = 2000;
        let angle = |i: i32| (f64::from(i) + 0.5) * PI / f64::from(n);
        let sum: f64 = (0..n).map(|i| (angle(i) - x * angle(i).sin()).cos()).sum();
        sum / f64::from(n)
    };
    let expected = |freq_hz: f64| {
        let y = PI * 13.5 * sin_rho * freq_hz / 299_792_458.0;
        (2.0 * j1(y) / y).powi(2) * (freq_hz / 1.284e9).powf(-0.7)
    };
    for (k, (plain, seen)) in plain.vis_jy_rfp.iter().zip(&seen.vis_jy_rfp).enumerate() {
        let wanted = plain * expected(freqs_hz[k % freqs_hz.len()]) as f32;
        assert!((seen - wanted).norm() < 1e-8, "{k}: {seen} {wanted}");
    }
}

/// Galaxies out to 0.6 degrees, each of several signal-to-noise ratios of ten.
const FIELD: &str = "\
RA[deg],DEC[deg],Total_flux[mJy],Scale_length[arcsec],E1,E2
53.12,-30.03,8,4.0,0.1,0.0
52.85,-30.31,30,6.0,0.1,-0.2
53.52,-30.36,45,6.0,0.0,0.1
";
const TERMS: &str = "--smearing --beam meerkat --spectral-index -0.7";

/// Pulls of flux density and of the position of sources of [`FIELD`] found with some terms.
fn pulls(folder: &Path, data: &Path, name: &str, terms: &str) -> Vec<[f64; 3]> {
    let out = folder.join(name);
    let command = format!(
        "{} {} --fov 1deg --flux 1mJy:60mJy --quiet {terms}",
        data.display(),
        out.display()
    );
    vis2cat_ok(command.split_whitespace());
    let table = read_table(&CataloguePaths::new(&out).catalogue, Some("CATALOGUE")).unwrap();
    let column = |name: &str| table.numbers(name).unwrap().clone();
    let (ra, dec, flux) = (column("RA"), column("DEC"), column("Total_flux"));
    let (e_ra, e_dec, e_flux) = (column("E_RA"), column("E_DEC"), column("E_Total_flux"));
    let sky: Vec<Vec<f64>> = FIELD
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert_eq!(ra.len(), sky.len(), "{terms}: not what there is");
    let pull = |i: usize| {
        let near = |s: &&Vec<f64>| (s[0] - ra[i]).abs() < 0.005 && (s[1] - dec[i]).abs() < 0.005;
        let truth = sky.iter().find(near).unwrap();
        // Errors of RA are of the great circle.
        let on_circle = 3600.0 * dec[i].to_radians().cos();
        [
            (flux[i] - 1e3 * truth[2]) / e_flux[i],
            (ra[i] - truth[0]) * on_circle / e_ra[i],
            (dec[i] - truth[1]) * 3600.0 / e_dec[i],
        ]
    };
    (0..ra.len()).map(pull).collect()
}

/// One catalogue with the terms of the instrument and one without, of one time and 32 channels.
#[test]
fn a_smeared_field_is_unbiased_with_the_terms_and_biased_without() {
    let folder = tempfile::tempdir().unwrap();
    let band = "--freq 1.284GHz --bandwidth 856MHz --channels 32 --hours 0.0022222222 --tint 8s";
    let data = simulated(
        FIELD,
        folder.path().join("field.uvfits"),
        &format!("{band} {TERMS}"),
    );
    let with = pulls(folder.path(), &data, "with.fits", TERMS);
    let mean_square = with.as_flattened().iter().map(|p| p * p).sum::<f64>() / 9.0;
    assert!(
        with.as_flattened().iter().all(|p| p.abs() < 4.0),
        "{with:?}"
    );
    assert!((0.1..3.0).contains(&mean_square), "{with:?}");
    let table = read_table(&folder.path().join("with.fits"), Some("CATALOGUE")).unwrap();
    let [gain, seen, flux] =
        ["PB_gain", "App_flux", "Total_flux"].map(|name| table.numbers(name).unwrap().clone());
    for i in 0..gain.len() {
        assert!((0.2..1.0).contains(&gain[i]), "{gain:?}");
        assert!((seen[i] / (flux[i] * gain[i]) - 1.0).abs() < 1e-6);
    }
    let without = pulls(folder.path(), &data, "without.fits", "");
    let biased = without.iter().filter(|pull| pull[0] < -10.0).count();
    assert!(biased >= 2, "{without:?}");
}

/// Sources of several spectral indices, the last of them too faint to tell.
const SPECTRA: &str = "\
RA[deg],DEC[deg],Total_flux[mJy],Scale_length[arcsec],E1,E2,Spectral_index
53.12,-30.03,20,4.0,0.1,0.0,-1.4
53.05,-29.96,15,3.0,0.1,-0.2,0.3
53.19,-29.95,3,4.0,0.0,0.1,-0.7
";

/// By facets; that these are right is tested where they are made.
#[test]
fn spectral_indices_are_found_where_they_are_free() {
    let folder = tempfile::tempdir().unwrap();
    let band = "--freq 1.284GHz --bandwidth 856MHz --channels 16 --hours 0.0022222222 --tint 8s";
    let data = simulated(SPECTRA, folder.path().join("field.uvfits"), band);
    let out = folder.path().join("out.fits");
    let command = format!(
        "{} {} --fov 12arcmin --flux 1mJy:60mJy --spectral-index=-1.5:0.5 --engine facet --quiet",
        data.display(),
        out.display()
    );
    vis2cat_ok(command.split_whitespace());
    let truth = folder.path().join("field.csv");
    let command = format!("evaluate --json {} {}", out.display(), truth.display());
    let done = vis2cat_ok(command.split_whitespace());
    let found: serde_json::Value = serde_json::from_str(&done).unwrap();
    assert_eq!(found["matched"].as_array().unwrap().len(), 3);
    assert_eq!(found["false_rows"].as_array().unwrap().len(), 0);
    let parameters = found["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), 7);
    for parameter in parameters {
        let largest = parameter["pull_largest"].as_f64().unwrap();
        assert!(largest.abs() < 4.0, "{parameter}");
    }
    let table = read_table(&out, Some("CATALOGUE")).unwrap();
    let errors = table.numbers("E_Spectral_index").unwrap();
    // The brightest first: known well, and hardly better than by the prior.
    assert!(errors[0] < 0.1 && errors[2] > 0.2, "{errors:?}");
}

#[test]
fn terms_that_cannot_be_are_refused() {
    for (flags, what) in [
        ("--beam vla", "'vla' is no beam"),
        ("--beam airy=0m", "has no beam"),
        ("--spectral-index 11", "use a number from -10 to 10"),
    ] {
        let command = format!("in.uvfits out.fits {flags}");
        let done = vis2cat(command.split_whitespace());
        assert_eq!(done.status.code(), Some(2), "{flags}");
        assert!(errors(&done).contains(what), "{}", errors(&done));
    }
}

/// A file that does not say how long its samples were averaged: smearing cannot be known, a beam can.
#[test]
fn only_smearing_needs_integration_times() {
    let folder = tempfile::tempdir().unwrap();
    let sky = "RA,DEC,Total_flux[mJy],Scale_length,E1,E2\n53.12,-30.03,8,4.0,0.1,0.0\n";
    let made = folder.path().join("made.uvfits");
    let data = simulated(sky, made, "--tint 1800s --channels 2 --beam meerkat");
    let mut reader = open(&data).unwrap();
    let timeless = folder.path().join("timeless.uvfits");
    let mut writer = UvfitsWriter::create(&timeless, reader.observation(), false).unwrap();
    let mut chunk = VisChunk::new(4096);
    while reader.read_chunk(&mut chunk).unwrap() > 0 {
        chunk.interval_s_r.fill(f64::NAN);
        writer.write_chunk(&chunk).unwrap();
    }
    Box::new(writer).finish().unwrap();
    let out = folder.path().join("out.fits");
    let search = |flags: &str| {
        let (data, out) = (timeless.display(), out.display());
        let command = format!("{data} {out} --fov 5arcmin --flux 1mJy:60mJy --quiet {flags}");
        vis2cat(command.split_whitespace())
    };
    let done = search("--smearing");
    assert_eq!(done.status.code(), Some(3));
    assert!(errors(&done).contains("no integration times, which --smearing needs"));
    assert!(!out.exists());
    let done = search("--beam meerkat");
    assert!(done.status.success(), "{}", errors(&done));
    let found = read_table(&out, Some("CATALOGUE")).unwrap();
    let gain = found.numbers("PB_gain").unwrap();
    assert!(
        gain.len() == 1 && (0.98..1.0).contains(&gain[0]),
        "{gain:?}"
    );
}
