//! From visibilities to the catalogue: what is found, how well, and that nothing else decides it.

use std::path::Path;

use nalgebra::DMatrix;
use vis2cat::catalogue::{CatalogueSource, read_sources};
use vis2cat::units::ARCSEC;
use vis2cat_formats::fits::{Table, read_table};
use vis2cat_formats::{UvfitsWriter, VisChunk, VisWriter};

use crate::support::{search, searched, simulate, vis2cat_ok};

/// Three galaxies that a snapshot of twelve minutes sees in each other's sidelobes.
const SNAPSHOT: &str = "\
RA,DEC,Total_flux,Scale_length,E1,E2
53.1105,-29.9905,2000,4,0.2,0.1
53.0930,-30.0040,1200,3,-0.1,0.2
53.1070,-30.0110,800,3,0,-0.2
";

/// Two bright galaxies 41 arcsec apart, where the core of the array still sees a fifth of one in the
/// other.
const PAIR: &str = "\
RA,DEC,Total_flux,Scale_length,E1,E2
53.1150677941,-30.3296622106,93.27,2.497,0.065,-0.126
53.1226108161,-30.3203582949,130.8,1.746,-0.006,-0.439
";

/// A faint galaxy 10 arcsec from a bright one, both of which one long disk fits so well that it leaves
/// 5 standard deviations.
const SWALLOWED: &str = "\
RA,DEC,Total_flux,Scale_length,E1,E2
53.1000,-30.0001,12.7634,0.6378,-0.4231,-0.1211
53.0967,-29.9999,53.0588,1.7202,-0.12,-0.0017
";

/// No estimate may be further from the truth than this many of its own errors.
const LARGEST_PULL: f64 = 5.0;
/// A match: within three sigma, and at least this.
const MATCH_FLOOR_ARCSEC: f64 = 1.0;

fn column(table: &Table, name: &str) -> Vec<f64> {
    table.numbers(name).unwrap()
}

/// Slices know nothing of ellipsoids: what the two samplers say differs by their own noise only.
#[test]
fn the_catalogue_does_not_depend_on_the_sampler() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sampler_slice");
    std::fs::create_dir_all(&folder).unwrap();
    let run = searched();
    let more = ["--sampler", "slice", "--n-live", "60", "--overwrite"];
    let paths = search(&run.data, &folder.join("out.fits"), &more);
    let by_slices = read_table(&paths.catalogue, Some("CATALOGUE")).unwrap();
    let by_ellipsoids = run.table("CATALOGUE");
    assert_eq!(by_slices.rows(), by_ellipsoids.rows());
    for (name, error) in [
        ("RA", "E_RA"),
        ("DEC", "E_DEC"),
        ("Total_flux", "E_Total_flux"),
        ("Scale_length", "E_Scale_length"),
        ("E1", "E_E1"),
        ("E2", "E_E2"),
    ] {
        let unit = if matches!(name, "RA" | "DEC") {
            3600.0
        } else {
            1.0
        };
        let estimates = column(&by_slices, name)
            .into_iter()
            .zip(column(&by_ellipsoids, name));
        let errors = column(&by_slices, error)
            .into_iter()
            .zip(column(&by_ellipsoids, error));
        for (row, ((a, b), (e_a, e_b))) in estimates.zip(errors).enumerate() {
            // 1000 effective samples know the mean to 0.03 sigma, and sigma to 2%.
            assert!(
                ((a - b) * unit).abs() < 0.2 * e_b,
                "{name} of {row}: {a} ± {e_a}, {b} ± {e_b}"
            );
            assert!(
                (e_a / e_b - 1.0).abs() < 0.15,
                "{error} of {row}: {e_a}, {e_b}"
            );
        }
    }
    let log_z = column(&by_slices, "Log_Z")
        .into_iter()
        .zip(column(&by_ellipsoids, "Log_Z"));
    let err = column(&by_slices, "E_Log_Z")
        .into_iter()
        .zip(column(&by_ellipsoids, "E_Log_Z"));
    for ((a, b), (e_a, e_b)) in log_z.zip(err) {
        assert!(
            (a - b).abs() < 4.0 * e_a.hypot(e_b),
            "log Z {a} ± {e_a}, {b} ± {e_b}"
        );
    }
}

/// One source, and a search that takes a second.
pub(crate) const ONE: &str =
    "RA,DEC,Total_flux,Scale_length,E1,E2\n53.1035,30.0025,300,2,0.2,0.1\n";
const ONE_SEARCH: &str =
    "--fov 30arcsec --tile-size 15arcsec --n-live 50 --flux 50uJy:1mJy --overwrite";

/// Distance of a row to a source: east and north on the sky [arcsec].
fn offset_arcsec(table: &Table, row: usize, truth: &CatalogueSource) -> (f64, f64) {
    let ra_rad = column(table, "RA")[row].to_radians();
    let dec_rad = column(table, "DEC")[row].to_radians();
    let east = (ra_rad - truth.position.ra_rad) * dec_rad.cos();
    (east / ARCSEC, (dec_rad - truth.position.dec_rad) / ARCSEC)
}

/// The source that each row is; every one once.
fn matched(table: &Table, truth: &[CatalogueSource]) -> Vec<usize> {
    let (e_ra, e_dec) = (column(table, "E_RA"), column(table, "E_DEC"));
    let mut matches = Vec::new();
    for row in 0..table.rows() {
        let radius = (3.0 * e_ra[row].hypot(e_dec[row])).max(MATCH_FLOOR_ARCSEC);
        let near: Vec<usize> = (0..truth.len())
            .filter(|&i| {
                let (east, north) = offset_arcsec(table, row, &truth[i]);
                east.hypot(north) < radius
            })
            .collect();
        assert_eq!(near.len(), 1, "row {row} is no source, or two");
        matches.push(near[0]);
    }
    let mut once = matches.clone();
    once.sort_unstable();
    assert_eq!(once, (0..truth.len()).collect::<Vec<_>>());
    matches
}

/// Largest |estimate - truth| / error over positions, flux densities and shapes.
fn largest_pull(table: &Table, truth: &[CatalogueSource]) -> f64 {
    let mut largest: f64 = 0.0;
    for (row, i) in matched(table, truth).into_iter().enumerate() {
        let (east, north) = offset_arcsec(table, row, &truth[i]);
        let mut pull = |difference: f64, error: &str| {
            let sigma = column(table, error)[row];
            assert!(sigma > 0.0, "{error} of row {row}: {sigma}");
            largest = largest.max((difference / sigma).abs());
        };
        let estimate = |name: &str| column(table, name)[row];
        pull(east, "E_RA");
        pull(north, "E_DEC");
        pull(
            estimate("Total_flux") - truth[i].flux_jy * 1e6,
            "E_Total_flux",
        );
        pull(
            estimate("Scale_length") - truth[i].scale_rad / ARCSEC,
            "E_Scale_length",
        );
        pull(estimate("E1") - truth[i].e.e1, "E_E1");
        pull(estimate("E2") - truth[i].e.e2, "E_E2");
    }
    largest
}

/// Simulates `sky` into `folder` and searches it, with these options each; the largest pull. What was
/// found is in `out.fits` there.
fn pull_of(folder: &Path, sky: &str, simulation: &str, search: &str) -> f64 {
    let in_folder = |name: &str| folder.join(name).display().to_string();
    let (list, data) = (in_folder("sky.csv"), in_folder("field.uvfits"));
    let (truth, out) = (in_folder("truth.fits"), in_folder("out.fits"));
    std::fs::write(&list, sky).unwrap();
    let simulate = format!("simulate {data} --catalogue {list} --truth {truth} {simulation}");
    vis2cat_ok(simulate.split_whitespace());
    vis2cat_ok(format!("{data} {out} {search}").split_whitespace());
    let truth = read_sources(Path::new(&truth)).unwrap();
    largest_pull(&read_table(Path::new(&out), None).unwrap(), &truth)
}

#[test]
fn all_sources_are_found_with_honest_errors_and_nothing_else() {
    let run = searched();
    let truth = read_sources(&run.truth).unwrap();
    assert_eq!(truth.len(), 3);
    let pull = largest_pull(&run.table("CATALOGUE"), &truth);
    assert!(pull < LARGEST_PULL, "{pull}");
}

#[test]
fn east_is_positive_l_and_larger_right_ascension() {
    let table = searched().table("CATALOGUE");
    for row in 0..table.rows() {
        let value = |name| column(&table, name)[row];
        assert!((value("RA") - 53.1) * value("L") > 0.0);
        assert!((value("DEC") - 30.0) * value("M") > 0.0);
    }
}

#[test]
fn the_samples_of_a_source_are_its_slice_and_make_its_row() {
    let run = searched();
    let rows = run.table("CATALOGUE");
    let samples = read_table(&run.paths.posterior, None).unwrap();
    let weight = column(&samples, "weight");
    let (first, n) = (column(&rows, "Post_row"), column(&rows, "Post_n"));
    let mut next = 0;
    for row in 0..rows.rows() {
        let slice = first[row] as usize..first[row] as usize + n[row] as usize;
        assert_eq!(slice.start, next, "the slices follow each other");
        next = slice.end;
        let id = column(&rows, "Source_id")[row];
        assert!(
            column(&samples, "Source_id")[slice.clone()]
                .iter()
                .all(|&i| i == id)
        );
        let total: f64 = weight[slice.clone()].iter().sum();
        assert!((total - 1.0).abs() < 1e-9, "{total}");
        for (parameter, mean, error) in [
            ("flux", "Total_flux", "E_Total_flux"),
            ("scale", "Scale_length", "E_Scale_length"),
            ("e1", "E1", "E_E1"),
            ("e2", "E2", "E_E2"),
        ] {
            let values = &column(&samples, parameter)[slice.clone()];
            let weights = &weight[slice.clone()];
            let moment = |f: &dyn Fn(f64) -> f64| -> f64 {
                values.iter().zip(weights).map(|(v, w)| w * f(*v)).sum()
            };
            let (mean, error) = (column(&rows, mean)[row], column(&rows, error)[row]);
            assert!((moment(&|v| v) - mean).abs() < 1e-9 * error.max(mean.abs()));
            let variance = moment(&|v| (v - mean).powi(2));
            assert!((variance.sqrt() / error - 1.0).abs() < 0.02, "{parameter}");
        }
        for (parameter, mean) in [("ra", "RA"), ("dec", "DEC")] {
            let values = &column(&samples, parameter)[slice.clone()];
            let sum: f64 = values
                .iter()
                .zip(&weight[slice.clone()])
                .map(|(v, w)| v * w)
                .sum();
            assert!((sum - column(&rows, mean)[row]).abs() * 3600.0 < 1e-4);
        }
    }
    assert_eq!(next, samples.rows());
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let run = searched();
    let folder = tempfile::tempdir().unwrap();
    let alone = search(
        &run.data,
        &folder.path().join("out.fits"),
        &["--threads", "1"],
    );
    let same = |a: &Path, b: &Path| std::fs::read(a).unwrap() == std::fs::read(b).unwrap();
    assert!(same(&run.paths.catalogue, &alone.catalogue));
    assert!(same(&run.paths.posterior, &alone.posterior));
}

/// All that a mode needs is its own tile: one that was screened away held nothing.
#[test]
fn without_screening_the_same_is_found_and_every_other_mode_has_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let data = simulate(folder.path(), ONE);
    let out = folder.path().join("out.fits");
    let truth = read_sources(&folder.path().join("truth.fits")).unwrap();
    let find = |more: &str| {
        let command = format!("{} {} {ONE_SEARCH} {more}", data.display(), out.display());
        vis2cat_ok(command.split_whitespace());
        let pull = largest_pull(&read_table(&out, None).unwrap(), &truth);
        assert!(pull < LARGEST_PULL, "{pull} {more}");
        read_table(&out, Some("MODES")).unwrap()
    };
    let screened = find("--threads 2").rows();
    let modes = find("--no-screening");
    assert!(modes.rows() > screened);
    let status = modes.strings("Status").unwrap();
    let dropped = [
        "f1_duplicate",
        "below_cut",
        "explained_by_brighter",
        "worse_than_no_source",
    ];
    for (status, source) in status.iter().zip(modes.numbers("Source_id").unwrap()) {
        if status == "kept" {
            assert_eq!(source, 1.0);
        } else {
            assert!(dropped.contains(&status.as_str()), "{status}");
        }
    }
    assert_eq!(status.iter().filter(|s| *s == "kept").count(), 1);
}

/// Sixteen tiles of 15 arcsec; each galaxy stands where two or four of them meet.
#[test]
fn sources_on_borders_and_corners_of_tiles_are_found_once() {
    let folder = tempfile::tempdir().unwrap();
    let places = [(0.0, 0.0), (15.0, 7.5), (-7.5, -15.0), (-15.0, 15.0)];
    let row = |(l_arcsec, m_arcsec): (f64, f64)| {
        let ra_deg = 53.1 + l_arcsec / 3600.0 / 30f64.to_radians().cos();
        format!("{ra_deg},{},300,1.5,0.1,-0.2\n", 30.0 + m_arcsec / 3600.0)
    };
    let rows: String = places.into_iter().map(row).collect();
    let sky = format!("RA,DEC,Total_flux,Scale_length,E1,E2\n{rows}");
    let (data, out) = (
        simulate(folder.path(), &sky),
        folder.path().join("out.fits"),
    );
    let truth = read_sources(&folder.path().join("truth.fits")).unwrap();
    for more in ["", "--no-screening"] {
        let command = format!(
            "{} {} --fov 1arcmin --tiles 16 --n-live 60 --flux 50uJy:1mJy --overwrite {more}",
            data.display(),
            out.display()
        );
        vis2cat_ok(command.split_whitespace());
        let pull = largest_pull(&read_table(&out, None).unwrap(), &truth);
        assert!(pull < LARGEST_PULL, "{pull} {more}");
    }
}

#[test]
fn facets_find_the_same_on_any_number_of_threads() {
    let run = searched();
    let folder = tempfile::tempdir().unwrap();
    let find = |name: &str, engine: &str, threads: &str| {
        let options = ["--engine", engine, "--threads", threads];
        search(&run.data, &folder.path().join(name), &options)
    };
    let exact = find("exact.fits", "exact", "2").catalogue;
    let (one, two) = (find("1.fits", "facet", "1"), find("2.fits", "facet", "2"));
    let same = |a: &Path, b: &Path| std::fs::read(a).unwrap() == std::fs::read(b).unwrap();
    assert!(same(&one.catalogue, &two.catalogue));
    assert!(same(&one.posterior, &two.posterior));
    let (exact, facet) = (
        read_table(&exact, None).unwrap(),
        read_table(&one.catalogue, None).unwrap(),
    );
    assert_eq!((exact.rows(), facet.rows()), (3, 3));
    let estimates = [
        ("Total_flux", "E_Total_flux"),
        ("Scale_length", "E_Scale_length"),
        ("E1", "E_E1"),
        ("E2", "E_E2"),
    ];
    for (name, error) in estimates {
        for row in 0..3 {
            let difference = column(&exact, name)[row] - column(&facet, name)[row];
            let sigma = column(&exact, error)[row];
            assert!(difference.abs() < 0.3 * sigma, "{name} of row {row}");
            let ratio = column(&facet, error)[row] / sigma;
            assert!((ratio - 1.0).abs() < 0.25, "{error} of row {row}: {ratio}");
        }
    }
    // Certified, and drawn from something that is not the exact likelihood.
    let off = column(&facet, "Max_dlogL");
    assert!(off.iter().all(|d| *d > 0.0 && *d < 5.0), "{off:?}");
}

/// What a poor first model of the second galaxy leaves behind is found as a source; in the end it
/// must be part of the galaxy again.
#[test]
fn a_galaxy_among_sidelobes_is_not_split_in_two() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = "--array meerkat --hours 0.2 --tint 60s --seed 1";
    let pull = pull_of(
        folder.path(),
        SNAPSHOT,
        simulation,
        "--fov 2arcmin --flux 200uJy:5mJy",
    );
    assert!(pull < LARGEST_PULL, "{pull}");
    let modes = read_table(&folder.path().join("out.fits"), Some("MODES")).unwrap();
    // Whether the first model is so poor depends on the last bits of the sums, and so on the processor.
    let status = modes.strings("Status").unwrap();
    let sources = modes.numbers("Source_id").unwrap();
    for (status, source) in status.iter().zip(sources) {
        assert!(status != "part_of_neighbour" || source == 2.0);
    }
}

/// The first model of each is far off, as the other still stands in the data: both must be sampled
/// again until nothing changes, and be found where they are, outside the region of their first model.
#[test]
fn bright_neighbours_end_up_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = "--array ska1-mid --ra 53.1188deg --dec -30.325deg --tint 1h --sefd 51Jy";
    let pull = pull_of(folder.path(), PAIR, simulation, "--fov 2arcmin");
    assert!(pull < LARGEST_PULL, "{pull}");
}

/// Two equal galaxies that an array sees as one by most of its baselines, and a faint one beside one
/// twenty times as bright.
const EQUAL: &str = "\
RA,DEC,Total_flux,Scale_length,E1,E2
53.1183173,-30.325,30,0.8,0.2,0.1
53.1192827,-30.325,30,0.7,-0.1,0.15
";
const UNEQUAL: &str = "\
RA,DEC,Total_flux,Scale_length,E1,E2
53.1188,-30.325,200,2.3,0.2,0.1
53.12202,-30.325,10,0.8,-0.1,0.15
";

/// Parameters of samples in `POSTERIOR`.
const PARAMETERS: [&str; 6] = ["ra", "dec", "flux", "scale", "e1", "e2"];
/// Pulls of sources that were sampled jointly.
const LARGEST_JOINT_PULL: f64 = 4.0;

/// Simulates and searches a pair of galaxies; both must be found, as one group with honest errors.
/// Returns the covariance of the parameters of both, axes (source, parameter).
fn joint_covariance(folder: &Path, sky: &str, simulation: &str, search: &str) -> DMatrix<f64> {
    let simulation = format!("--ra 53.1188deg --dec -30.325deg {simulation}");
    let pull = pull_of(folder, sky, &simulation, search);
    assert!(pull < LARGEST_JOINT_PULL, "{pull}");
    let rows = read_table(&folder.join("out.fits"), None).unwrap();
    assert_eq!(column(&rows, "Group_id"), [1.0, 1.0]);
    let samples = read_table(&folder.join("out.posterior.fits"), None).unwrap();
    let n = column(&rows, "Post_n")[0] as usize;
    assert_eq!(column(&rows, "Post_n")[1] as usize, n);
    let weight = column(&samples, "weight");
    assert!(weight[..n] == weight[n..], "one weight a joint draw");
    let values: Vec<Vec<f64>> = PARAMETERS.iter().map(|p| column(&samples, p)).collect();
    let value = |k: usize, d: usize| values[d % 6][k + d / 6 * n];
    let mean: Vec<f64> = (0..12)
        .map(|d| (0..n).map(|k| weight[k] * value(k, d)).sum())
        .collect();
    let offset = |k: usize, d: usize| value(k, d) - mean[d];
    let covariance = |i, j| -> f64 {
        (0..n)
            .map(|k| weight[k] * offset(k, i) * offset(k, j))
            .sum()
    };
    DMatrix::from_fn(12, 12, covariance)
}

/// Error of parameter `d` with all of the other source left free, over that for fixed values.
fn growth(covariance: &DMatrix<f64>, d: usize) -> f64 {
    let (own, other) = (d / 6 * 6, 6 - d / 6 * 6);
    let block = |i: usize, j: usize| covariance.view((i, j), (6, 6)).into_owned();
    let fixed = block(other, other).try_inverse().unwrap();
    let conditional = block(own, own) - block(own, other) * fixed * block(other, own);
    (covariance[(d, d)] / conditional[(d % 6, d % 6)]).sqrt()
}

/// What one galaxy loses the other gains: their flux densities are anticorrelated, and all errors
/// grow when neither is held fixed.
#[test]
fn overlapping_galaxies_are_sampled_together() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = "--array vla-a --tint 1h --sefd 30Jy";
    let search = "--fov 30arcsec --flux 5uJy:500uJy --threads 2";
    let covariance = joint_covariance(folder.path(), EQUAL, simulation, search);
    let flux = |i: usize, j: usize| covariance[(6 * i + 2, 6 * j + 2)];
    let correlation = flux(0, 1) / (flux(0, 0) * flux(1, 1)).sqrt();
    assert!(correlation < -0.5, "{correlation}");
    assert!(growth(&covariance, 2) > 1.3 && growth(&covariance, 8) > 1.3);
    assert!((0..12).all(|d| growth(&covariance, d) >= 1.0));
    // The same on one thread.
    let (data, out) = (
        folder.path().join("field.uvfits"),
        folder.path().join("one.fits"),
    );
    let search = search.replace("--threads 2", "--threads 1");
    vis2cat_ok(format!("{} {} {search}", data.display(), out.display()).split_whitespace());
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("out.posterior.fits") == bytes("one.posterior.fits"));
}

/// By facets: the faint galaxy is what the long baselines see of the two.
#[test]
fn a_faint_galaxy_beside_a_bright_one_is_sampled_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = "--array ska1-mid --tint 2h --sefd 150Jy";
    let search = "--fov 1arcmin --flux 3uJy:500uJy --engine facet";
    let covariance = joint_covariance(folder.path(), UNEQUAL, simulation, search);
    let flux = |i: usize, j: usize| covariance[(6 * i + 2, 6 * j + 2)];
    assert!(flux(0, 1) < 0.0, "brightest first");
    assert!(growth(&covariance, 8) > 1.05);
    let rows = read_table(&folder.path().join("out.fits"), None).unwrap();
    // Certified together, and drawn from something that is not the exact likelihood.
    let off = column(&rows, "Max_dlogL");
    assert!(off[0] == off[1] && off[0] > 0.0 && off[0] < 5.0, "{off:?}");
}

#[test]
fn what_a_long_disk_has_swallowed_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = "--array ska1-mid --tint 1h --sefd 400Jy --seed 5";
    let pull = pull_of(folder.path(), SWALLOWED, simulation, "--fov 1arcmin");
    assert!(pull < LARGEST_PULL, "{pull}");
    let modes = read_table(&folder.path().join("out.fits"), Some("MODES")).unwrap();
    let status = modes.strings("Status").unwrap();
    assert_eq!(status.iter().filter(|s| *s == "kept").count(), 2);
    // Its first mode lies below the cut.
    let snr = modes.numbers("SNR_peak").unwrap();
    assert!(snr.iter().any(|snr| *snr < 6.0), "{snr:?}");
}

#[test]
fn weights_that_are_all_one_are_rescaled_and_the_same_is_found() {
    let folder = tempfile::tempdir().unwrap();
    simulate(folder.path(), ONE);
    let data = folder.path().join("ones.uvfits");
    copy_with_weights_of_one(&folder.path().join("field.uvfits"), &data);
    let out = folder.path().join("out.fits");
    let command = format!("{} {} {ONE_SEARCH}", data.display(), out.display());
    vis2cat_ok(command.split_whitespace());
    let truth = read_sources(&folder.path().join("truth.fits")).unwrap();
    let pull = largest_pull(&read_table(&out, None).unwrap(), &truth);
    assert!(pull < LARGEST_PULL, "{pull}");
    let run = read_table(&out, Some("RUN")).unwrap();
    let key = |key: &str| {
        let row = run.strings("KEY").unwrap().iter().position(|k| k == key);
        run.strings("VALUE").unwrap()[row.unwrap()]
            .parse::<f64>()
            .unwrap()
    };
    // Both hands of weight 1 are two in Stokes I.
    assert!((key("noise.weights") - 0.5f64.sqrt()).abs() < 1e-9);
    let scale = (key("noise.weights") / key("noise.data")).powi(2);
    assert!((key("noise.weight_scale") / scale - 1.0).abs() < 1e-9 && scale > 1e5);
}

fn copy_with_weights_of_one(from: &Path, to: &Path) {
    let mut reader = vis2cat_formats::open(from).unwrap();
    let mut writer = UvfitsWriter::create(to, reader.observation(), false).unwrap();
    let mut chunk = VisChunk::new(4096);
    while reader.read_chunk(&mut chunk).unwrap() > 0 {
        chunk.weight_rfp.fill(1.0);
        writer.write_chunk(&chunk).unwrap();
    }
    Box::new(writer).finish().unwrap();
}
