//! `vis2cat evaluate` on catalogues whose numbers are known by hand, and beside astropy.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use vis2cat::catalogue::{
    CatalogueHeader, CataloguePaths, CatalogueSource, Estimate, Flags, ModeRow, PriorRange,
    SourceRow, WeightedSample, posterior_rows, source_name, summarise, write, write_truth,
};
use vis2cat::coords::{Lm, RaDec};
use vis2cat::detect::Status;
use vis2cat::rime::Source;
use vis2cat::rime::shape::{Ellipticity, Profile};
use vis2cat::units::{ARCSEC, DEG, MICROJY};

use crate::support::{errors, in_repository, python_with, searched, vis2cat, vis2cat_ok};

fn evaluate(catalogue: &Path, truth: &Path) -> Value {
    let args = [
        "evaluate".as_ref(),
        "--json".as_ref(),
        catalogue.as_os_str(),
    ];
    let text = vis2cat_ok(args.into_iter().chain([truth.as_os_str()]));
    serde_json::from_str(&text).unwrap()
}

/// Runs the command, which must fail for its input and say all of `wanted`.
fn refused(catalogue: &Path, truth: &Path, wanted: &[&str]) {
    let done = vis2cat([
        "evaluate".as_ref(),
        catalogue.as_os_str(),
        truth.as_os_str(),
    ]);
    let text = errors(&done);
    assert_eq!(done.status.code(), Some(3), "{text}");
    assert!(done.stdout.is_empty());
    assert!(wanted.iter().all(|w| text.contains(w)), "{text}");
}

fn close(value: &Value, wanted: f64) {
    let value = value.as_f64().unwrap_or(f64::NAN);
    assert!((value - wanted).abs() < 1e-4, "{value}, wanted {wanted}");
}

fn parts(fraction: &Value) -> (u64, u64) {
    let part = |key: &str| fraction[key].as_u64().unwrap();
    (part("n"), part("of"))
}

/// The entry of a list that is called `name`.
fn named<'a>(list: &'a Value, key: &str, name: &str) -> &'a Value {
    let list = list.as_array().unwrap();
    list.iter().find(|entry| entry[key] == name).unwrap()
}

fn csv(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

const TRUTH_CSV: &str = "\
RA,DEC,flux[mJy],Scale_length,E1,E2,SNR
10,60,0.1,1,0.1,0,20
10.01,60,0.05,2,0,0,10
10.02,60,0.01,2,0,0,4
";

/// The same as astropy and TOPCAT write it, but for what they say about themselves.
const TRUTH_VOTABLE: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<VOTABLE version="1.4" xmlns="http://www.ivoa.net/xml/VOTable/v1.3">
 <RESOURCE type="results">
  <TABLE name="truth">
   <DESCRIPTION>made up</DESCRIPTION>
   <FIELD ID="RA" datatype="double" name="RA" ucd="pos.eq.ra;meta.main" unit="deg"/>
   <FIELD ID="DEC" datatype="double" name="DEC" unit="deg"/>
   <FIELD ID="flux" datatype="float" name="flux" unit="mJy"><DESCRIPTION>total</DESCRIPTION></FIELD>
   <FIELD datatype="double" name="Scale_length" unit="arcsec"/>
   <FIELD datatype="double" name="E1"/>
   <FIELD datatype="double" name="E2"/>
   <FIELD datatype="int" name="SNR"/>
   <DATA>
    <TABLEDATA>
     <TR><TD>10</TD><TD>60</TD><TD>0.1</TD><TD>1</TD><TD>0.1</TD><TD>0</TD><TD>20</TD></TR>
     <TR>
      <TD>10.01</TD> <TD>60</TD> <TD>0.05</TD> <TD>2</TD> <TD>0</TD> <TD>0</TD> <TD>10</TD>
     </TR>
     <TR><TD>10.02</TD><TD>60</TD><TD>0.01</TD><TD>2</TD><TD>0</TD><TD>0</TD><TD>4</TD></TR>
    </TABLEDATA>
   </DATA>
  </TABLE>
 </RESOURCE>
</VOTABLE>
"#;

#[test]
fn a_votable_is_as_good_as_csv() {
    let folder = tempfile::tempdir().unwrap();
    let truth = csv(folder.path(), "truth.csv", TRUTH_CSV);
    let found = csv(folder.path(), "found.csv", &csv_catalogue());
    let votable = csv(folder.path(), "truth.vot", TRUTH_VOTABLE);
    let told = |truth: &Path| {
        let mut told = evaluate(&found, truth);
        told["truth"] = serde_json::Value::Null;
        told
    };
    assert!(told(&votable) == told(&truth), "{}", told(&votable));
}

/// At declination 60 deg an arcsecond on the sky is two in right ascension: the first row is 0.3
/// arcsec east of its true source, the second 0.6 arcsec south, the third is false.
fn csv_catalogue() -> String {
    let east = 10.0 + 0.6 / 3600.0;
    let south = 60.0 - 0.6 / 3600.0;
    format!(
        "RA,DEC,E_RA,E_DEC,Total_flux,E_Total_flux,Scale_length,E_Scale_length,SNR\n\
         {east:.12},60,0.2,0.4,110,5,1.5,0.25,22\n\
         10.01,{south:.12},0.2,0.4,45,5,1.5,0.25,9\n\
         10.03,60,0.2,0.4,30,5,1.5,0.25,6\n"
    )
}

#[test]
fn biases_pulls_and_bins_of_a_csv_table_are_those_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let truth = csv(folder.path(), "truth.csv", TRUTH_CSV);
    let found = csv(folder.path(), "found.csv", &csv_catalogue());
    let e = evaluate(&found, &truth);
    assert_eq!(parts(&e["completeness"]), (2, 3));
    assert_eq!(parts(&e["completeness_snr_5"]), (2, 2));
    assert_eq!(parts(&e["purity"]), (2, 3));
    close(&e["matched"][0]["separation_arcsec"], 0.3);
    close(&e["matched"][1]["separation_arcsec"], 0.6);
    // One off by x, the other by y: mean (x + y) / 2, its error |x - y| / 2, rms of two pulls.
    for (name, unit, offsets, error) in [
        ("RA", "arcsec", [0.3, 0.0], 0.2),
        ("DEC", "arcsec", [0.0, -0.6], 0.4),
        ("Total_flux", "uJy", [10.0, -5.0], 5.0),
        ("Scale_length", "arcsec", [0.5, -0.5], 0.25),
    ] {
        let p = named(&e["parameters"], "name", name);
        let [x, y]: [f64; 2] = offsets;
        let pulls = [x / error, y / error];
        assert_eq!(p["unit"], unit);
        close(&p["bias"]["value"], 0.5 * (x + y));
        close(&p["bias"]["err"], 0.5 * (x - y).abs());
        close(&p["pull_mean"], 0.5 * (pulls[0] + pulls[1]));
        close(
            &p["pull_rms"],
            (0.5 * (pulls[0].powi(2) + pulls[1].powi(2))).sqrt(),
        );
        let largest = if x.abs() >= y.abs() {
            pulls[0]
        } else {
            pulls[1]
        };
        close(
            &p["pull_largest"].as_f64().unwrap().abs().into(),
            largest.abs(),
        );
        let n_beyond = pulls.iter().filter(|p| p.abs() > 5.0).count();
        assert_eq!(p["n_beyond_5_sigma"], n_beyond);
        for (coverage, half_width) in [(&p["coverage"][0], 0.99446), (&p["coverage"][1], 1.95996)] {
            let inside = pulls.iter().filter(|p| p.abs() <= half_width).count() as u64;
            assert_eq!(coverage["from"], "gaussian");
            assert_eq!(parts(&coverage["covered"]), (inside, 2), "{name}");
        }
    }
    // The catalogue has no ellipticities to compare.
    assert_eq!(e["parameters"].as_array().unwrap().len(), 4);
    assert_eq!(e["missed"][0]["truth_row"], 3);
    assert_eq!(e["false_rows"][0]["row"], 3);
    assert!(e["area_deg2"].is_null() && e["false_per_deg2"].is_null());

    let bins = &named(&e["bins"], "name", "SNR")["bins"];
    let bin = |low: f64| {
        let bins = bins.as_array().unwrap();
        bins.iter().find(|bin| bin["low"] == low).unwrap()
    };
    assert_eq!(parts(&bin(4.0)["completeness"]), (0, 1));
    assert_eq!(parts(&bin(6.0)["purity"]), (0, 1));
    assert_eq!(parts(&bin(10.0)["completeness"]), (1, 1));
    assert_eq!(parts(&bin(8.0)["purity"]), (1, 1));
    close(&bin(20.0)["flux_ratio"]["value"], 1.1);

    // Rows stand in for modes: 22 and 9 are true, 6 is not.
    let curve = &e["curves"][0];
    assert_eq!(curve["table"], "CATALOGUE");
    close(&curve["area"], 1.0);
    close(&curve["best"]["cut"], 9.0);
    close(&curve["lowest_without_false"]["cut"], 9.0);
    assert_eq!(parts(&curve["points"][2]["completeness"]), (2, 3));
    assert_eq!(e["reliability"].as_array().unwrap().len(), 0);
}

#[test]
fn the_tables_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let truth = csv(folder.path(), "truth.csv", TRUTH_CSV);
    let found = csv(folder.path(), "found.csv", &csv_catalogue());
    let text = vis2cat_ok(["evaluate".as_ref(), found.as_os_str(), truth.as_os_str()]);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for wanted in [
        "completeness 0.667 (2/3) of SNR >= 5 1.000 (2/2) purity 0.667 (2/3)",
        "RA arcsec 0.1500 ± 0.1500 0.75 1.06 1.50 0 0.500 (1/2) Gaussian",
        "cuts on the 3 rows of CATALOGUE",
        "SNR 2 1 1.0000 9.00 1.000 9.00 0.667 (2/3) 1.000 (2/2)",
        "6.5 0.667 (2/3) 1.000 (2/2) 1.000 (2/2) 1.000 0.000",
        "3 10.020000 60.000000 10.0 4.0",
        "3 10.030000 60.000000 30.0 6.0",
    ] {
        assert!(text.contains(wanted), "{wanted}\n{text}");
    }
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
}

#[test]
fn an_empty_catalogue_and_an_empty_truth_are_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let none = csv(folder.path(), "none.csv", "RA,DEC,Total_flux\n");
    let truth = csv(folder.path(), "truth.csv", TRUTH_CSV);
    let e = evaluate(&none, &truth);
    assert_eq!(parts(&e["completeness"]), (0, 3));
    assert!(e["purity"]["value"].is_null());
    let e = evaluate(&truth, &none);
    assert_eq!(parts(&e["purity"]), (0, 3));
    assert!(e["completeness"]["value"].is_null());
    assert_eq!(e["curves"][0]["lowest_without_false"], Value::Null);
}

#[test]
fn what_cannot_be_compared_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let truth = csv(folder.path(), "truth.csv", TRUTH_CSV);
    let found = csv(folder.path(), "found.csv", &csv_catalogue());
    let no_dec = csv(folder.path(), "no_dec.csv", "RA,Total_flux\n1,2\n");
    let nowhere = csv(folder.path(), "nowhere.csv", "RA,DEC,Total_flux\n1,,2\n");
    let unit = csv(
        folder.path(),
        "unit.csv",
        "RA,DEC,Total_flux,E_RA[K]\n1,1,2,3\n",
    );
    refused(
        &folder.path().join("no.fits"),
        &truth,
        &["cannot read", "no.fits"],
    );
    refused(
        &found,
        &folder.path().join("no.fits"),
        &["cannot read", "no.fits"],
    );
    refused(&no_dec, &truth, &["no_dec.csv", "column DEC"]);
    let votable = |name, text: &str| csv(folder.path(), name, text);
    let binary = "<VOTABLE><TABLE><FIELD name='RA'/><DATA><BINARY2/></DATA></TABLE></VOTABLE>";
    let binary = votable("b.vot", binary);
    refused(&found, &binary, &["b.vot", "VOTable", "stilts"]);
    let empty = votable("e.vot", "<?xml version='1.0'?>\n<VOTABLE/>\n");
    refused(&found, &empty, &["e.vot", "no TABLE"]);
    let cut = votable("c.vot", "<VOTABLE><TABLE><FIELD name='RA'");
    refused(&found, &cut, &["c.vot", "VOTable"]);
    refused(&found, &no_dec, &["no_dec.csv", "column DEC"]);
    refused(&nowhere, &truth, &["nowhere.csv", "row 1"]);
    refused(&unit, &truth, &["unit.csv", "E_RA", "arcsec"]);
    let image = in_repository("fixtures/bad/image.uvfits");
    refused(&image, &truth, &["image.uvfits", "column RA"]);
}

fn centre() -> RaDec {
    RaDec {
        ra_rad: 53.1 * DEG,
        dec_rad: -30.0 * DEG,
    }
}

fn at(l_arcsec: f64, m_arcsec: f64) -> Lm {
    Lm {
        l: l_arcsec * ARCSEC,
        m: m_arcsec * ARCSEC,
    }
}

fn true_source(lm: Lm, flux_ujy: f64, snr: f64) -> CatalogueSource {
    CatalogueSource {
        position: RaDec::from_lm(lm, centre()),
        flux_jy: flux_ujy * MICROJY,
        scale_rad: ARCSEC,
        e: Ellipticity { e1: 0.1, e2: -0.1 },
        spectral_index: f64::NAN,
        snr,
    }
}

/// Width of the uniform posteriors: of position, scale-length [arcsec], flux density [uJy],
/// ellipticity.
const WIDTHS: [f64; 4] = [1.0, 0.4, 20.0, 0.2];

/// A posterior that is uniform in every parameter about `lm`, 100 uJy, 1 arcsec and (0.1, -0.1), each
/// shifted so that these lie at the given fraction of it: first that of flux density, then of size.
fn uniform(lm: Lm, flux_rank: f64, scale_rank: f64) -> Vec<WeightedSample> {
    let n = 400;
    let sample = |i: usize| {
        // A different order in every parameter, so that none depends on another.
        let t = |step: usize| ((i * step) % n) as f64 / n as f64 + 0.5 / n as f64;
        let centred = |step: usize| t(step) - 0.5;
        let [position, scale, flux, e] = WIDTHS;
        let source = Source {
            lm: Lm {
                l: lm.l + position * ARCSEC * centred(1),
                m: lm.m + position * ARCSEC * centred(3),
            },
            flux_jy: (100.0 + flux * (t(7) - flux_rank)) * MICROJY,
            scale_rad: (1.0 + scale * (t(9) - scale_rank)) * ARCSEC,
            e: Ellipticity {
                e1: 0.1 + e * centred(11),
                e2: -0.1 + e * centred(13),
            },
            tilt: 0.0,
        };
        WeightedSample {
            log_w: 0.0,
            log_l: 50.0,
            source,
        }
    };
    (0..n).map(sample).collect()
}

fn mode(lm: Lm, snr_peak: f64, log_z: f64, status: Status, source_id: Option<i64>) -> ModeRow {
    ModeRow {
        mode_id: 0,
        tile_id: 0,
        position: RaDec::from_lm(lm, centre()),
        position_sigma_rad: 0.5 * ARCSEC,
        lm,
        flux_jy: Estimate {
            mean: snr_peak * 5.0 * MICROJY,
            err: 5.0 * MICROJY,
        },
        snr: snr_peak,
        snr_peak,
        log_z: Estimate {
            mean: log_z,
            err: 0.1,
        },
        p_source: p_source(log_z),
        n_samples: 100,
        n_eff: 50.0,
        status,
        source_id,
    }
}

/// Where three sources are expected.
fn p_source(log_z: f64) -> f64 {
    1.0 / (1.0 + (-log_z).exp() / 3.0)
}

/// Two arcminutes about the centre, as a run writes it: two true sources, a false one, and modes
/// of all kinds.
fn write_catalogue(path: &Path) {
    let sets = [
        (at(10.0, 0.0), uniform(at(10.0, 0.0), 0.5, 0.99)),
        (at(-20.0, 0.0), uniform(at(-20.0, 0.0), 0.9, 0.5)),
        (at(0.0, 40.0), uniform(at(0.0, 40.0), 0.5, 0.5)),
    ];
    let (mut sources, mut posterior) = (Vec::new(), Vec::new());
    for (id, (_, set)) in (1_i64..).zip(&sets) {
        let summary = summarise(set, centre(), Profile::Exponential).unwrap();
        sources.push(SourceRow {
            name: source_name("V2C", summary.position),
            source_id: id,
            group_id: id,
            mode_id: id,
            posterior: summary,
            snr: 15.0,
            snr_peak: 15.0,
            log_z: Estimate::MISSING,
            p_source: 0.99,
            p_above: f64::NAN,
            max_dlog_l: f64::NAN,
            flags: Flags::default(),
            post_row: posterior.len() as i64,
            pb_gain: f64::NAN,
            post_n: set.len() as i64,
        });
        posterior.extend(posterior_rows(set, id, id, centre(), Profile::Exponential));
    }
    let modes = [
        // As the search saw it, 8 arcsec off: what counts is where the row is.
        mode(at(18.0, 0.0), 20.0, 200.0, Status::Kept, Some(1)),
        mode(at(-20.0, 0.0), 12.0, 70.0, Status::Kept, Some(2)),
        mode(at(0.0, 40.0), 7.0, 20.0, Status::Kept, Some(3)),
        // True, and below the cut; 1.5 arcsec off, with an error of 0.5 in both directions.
        mode(at(30.0, -30.0), 5.0, 3.0, Status::BelowCut, None),
        // Noise, seen twice.
        mode(at(-40.0, -30.0), 4.5, -1.0, Status::BelowCut, None),
        mode(at(-41.5, -30.0), 4.4, -1.0, Status::BelowCut, None),
        // A sidelobe of the first, of which little is left without it.
        mode(
            at(15.0, 20.0),
            3.0,
            30.0,
            Status::ExplainedByBrighter,
            Some(1),
        ),
        // What no cut makes a source.
        mode(at(-20.2, 0.0), 11.0, 60.0, Status::F1Duplicate, Some(2)),
        mode(at(14.0, 0.0), 9.0, 30.0, Status::PartOfNeighbour, Some(1)),
        mode(at(50.0, 50.0), 2.0, -5.0, Status::WorseThanNoSource, None),
    ];
    let limit = |parameter: &str| PriorRange {
        parameter: parameter.into(),
        unit: "arcsec".into(),
        low: -60.0,
        high: 60.0,
        form: "uniform".into(),
    };
    let header = CatalogueHeader {
        telescope: None,
        object: None,
        date_obs: None,
        mjd_obs: None,
        ref_freq_hz: None,
        phase_centre: centre(),
        profile: Profile::Exponential,
        seed: 1,
        has_beam: false,
        has_p_above: false,
        has_spectral_index: false,
        priors: vec![limit("L"), limit("M")],
        config: Vec::new(),
    };
    let paths = CataloguePaths::new(path);
    write(&paths, true, &header, &sources, &modes, &[], &posterior).unwrap();
}

/// What [`write_catalogue`] looked for: two that it has, one below the cut, one without any mode,
/// and one outside the field.
fn write_its_truth(path: &Path) {
    let truth = [
        true_source(at(10.0, 0.0), 100.0, 20.0),
        true_source(at(-20.0, 0.0), 100.0, 12.0),
        true_source(at(31.5, -30.0), 25.0, 4.9),
        true_source(at(45.0, 10.0), 30.0, 6.0),
        true_source(at(61.0, 0.0), 500.0, 100.0),
    ];
    write_truth(path, true, None, &truth).unwrap();
}

#[test]
fn modes_samples_and_field_of_a_fits_catalogue_count() {
    let folder = tempfile::tempdir().unwrap();
    let (out, truth) = (
        folder.path().join("out.fits"),
        folder.path().join("truth.fits"),
    );
    write_catalogue(&out);
    write_its_truth(&truth);
    let e = evaluate(&out, &truth);
    assert_eq!(parts(&e["completeness"]), (2, 4));
    assert_eq!(parts(&e["completeness_snr_5"]), (2, 3));
    assert_eq!(parts(&e["purity"]), (2, 3));
    assert_eq!(e["n_truth_outside"], 1);
    close(&e["false_per_deg2"], 900.0);

    // SNR_peak: true 20, 12, 5; false 7, 4.5, 3. Of 9 pairs, 8 are in order.
    assert_eq!(e["n_mode_left_out"], 4);
    let curve = named(&e["curves"], "score", "SNR_peak");
    assert_eq!(
        (&curve["n_true"], &curve["n_false"]),
        (&3.into(), &3.into())
    );
    close(&curve["area"], 8.0 / 9.0);
    // TPR - FPR: 2/3 at 12, and again 1 - 1/3 at 5: the higher cut.
    close(&curve["best"]["cut"], 12.0);
    let clean = &curve["lowest_without_false"];
    close(&clean["cut"], 12.0);
    assert_eq!(parts(&clean["completeness"]), (2, 4));
    assert_eq!(parts(&clean["completeness_snr_5"]), (2, 3));
    let last = curve["points"].as_array().unwrap().last().unwrap();
    assert_eq!(
        (parts(&last["completeness"]), parts(&last["purity"])),
        ((3, 4), (3, 6))
    );
    // Log_Z: of what is explained by a brighter one it is out of date.
    let curve = named(&e["curves"], "score", "Log_Z");
    assert_eq!(
        (&curve["n_true"], &curve["n_false"]),
        (&3.into(), &2.into())
    );
    close(&curve["area"], 5.0 / 6.0);

    // P: 0.99 of three rows, two true, and what two modes say.
    let bins = e["reliability"].as_array().unwrap();
    assert_eq!(parts(&bins[9]["is_true"]), (3, 4));
    close(&bins[9]["mean_p"], 0.25 * (3.0 * 0.99 + p_source(3.0)));
    let p_noise = p_source(-1.0);
    assert!((0.5..0.6).contains(&p_noise));
    close(&bins[5]["mean_p"], p_noise);
    assert_eq!(parts(&bins[5]["is_true"]), (0, 1));
}

/// A truth at 0.99 of a uniform posterior is outside its interval of 95%, but only 1.7 standard
/// deviations from its mean.
#[test]
fn intervals_are_those_of_columns_then_samples_then_gaussians() {
    let folder = tempfile::tempdir().unwrap();
    let (out, truth) = (
        folder.path().join("out.fits"),
        folder.path().join("truth.fits"),
    );
    write_catalogue(&out);
    write_its_truth(&truth);
    let coverage = |e: &Value, name: &str| {
        let coverage = &named(&e["parameters"], "name", name)["coverage"];
        [0, 1].map(|i| {
            let from = coverage[i]["from"].as_str().unwrap().to_owned();
            (from, coverage[i]["covered"]["n"].as_u64().unwrap())
        })
    };
    let wanted = |a: (&str, u64), b: (&str, u64)| [a, b].map(|(from, n)| (from.to_owned(), n));
    let e = evaluate(&out, &truth);
    assert_eq!(
        coverage(&e, "Total_flux"),
        wanted(("columns", 1), ("samples", 2))
    );
    assert_eq!(
        coverage(&e, "Scale_length"),
        wanted(("samples", 1), ("samples", 1))
    );
    for name in ["RA", "DEC", "E1", "E2"] {
        assert_eq!(
            coverage(&e, name),
            wanted(("samples", 2), ("samples", 2)),
            "{name}"
        );
    }
    let flux = named(&e["parameters"], "name", "Total_flux");
    // 0.9 of a uniform posterior is 0.4 sqrt(12) standard deviations above its mean.
    close(&flux["pull_largest"], -0.4 * 12.0_f64.sqrt());
    close(&flux["bias"]["value"], -4.0);
    std::fs::remove_file(folder.path().join("out.posterior.fits")).unwrap();
    let e = evaluate(&out, &truth);
    assert_eq!(
        coverage(&e, "Total_flux"),
        wanted(("columns", 1), ("gaussian", 2))
    );
    assert_eq!(
        coverage(&e, "Scale_length"),
        wanted(("gaussian", 1), ("gaussian", 2))
    );
}

#[test]
fn samples_of_another_catalogue_and_unknown_words_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (out, truth) = (
        folder.path().join("out.fits"),
        folder.path().join("truth.fits"),
    );
    write_catalogue(&out);
    write_its_truth(&truth);
    let samples = folder.path().join("out.posterior.fits");
    std::fs::copy(&searched().paths.posterior, &samples).unwrap();
    refused(
        &out,
        &truth,
        &[
            "out.posterior.fits",
            "POSTERIOR",
            "row 2",
            "another catalogue",
        ],
    );
    std::fs::copy(&truth, &samples).unwrap();
    refused(
        &out,
        &truth,
        &["out.posterior.fits", "no binary table", "move the file"],
    );
    std::fs::remove_file(&samples).unwrap();
    let mut bytes = std::fs::read(&out).unwrap();
    let word = b"worse_than_no_source";
    let place = bytes.windows(word.len()).position(|w| w == word).unwrap();
    bytes[place] = b'W';
    std::fs::write(&out, bytes).unwrap();
    refused(
        &out,
        &truth,
        &["MODES", "row 10", "Status", "Worse_than", "below_cut"],
    );
}

#[test]
fn a_search_finds_what_was_simulated() {
    let run = searched();
    let e = evaluate(&run.paths.catalogue, &run.truth);
    assert_eq!(parts(&e["completeness"]), (3, 3));
    assert_eq!(parts(&e["purity"]), (3, 3));
    let parameters = e["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), 6);
    for p in parameters {
        assert!(p["pull_largest"].as_f64().unwrap().abs() < 5.0, "{p}");
        assert_eq!(p["coverage"][1]["from"], "samples");
    }
    // The same numbers again, whatever the time.
    assert_eq!(e, evaluate(&run.paths.catalogue, &run.truth));
}

/// Pairs by `match_to_catalog_sky`, pulls and coverage by numpy: see `scripts/check_evaluate.py`.
#[test]
fn astropy_finds_the_same_pairs_pulls_and_coverage() {
    let Some(python) = python_with("astropy") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let (out, truth) = (
        folder.path().join("out.fits"),
        folder.path().join("truth.fits"),
    );
    write_catalogue(&out);
    write_its_truth(&truth);
    let run = searched();
    for (catalogue, truth) in [(&out, &truth), (&run.paths.catalogue, &run.truth)] {
        let done = Command::new(&python)
            .arg(in_repository("scripts/check_evaluate.py"))
            .args([Path::new(env!("CARGO_BIN_EXE_vis2cat")), catalogue, truth])
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&done.stdout);
        assert!(done.status.success(), "{text}\n{}", errors(&done));
    }
}
