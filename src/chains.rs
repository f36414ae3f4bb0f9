//! The posterior of each source in files that other programs read as they are.
//!
//! | file | read by | a line |
//! |---|---|---|
//! | `source_N.txt` | GetDist, anesthetic | weight, -ln L, parameters |
//! | `source_N.paramnames`, `.ranges` | the same | name and label; name, lowest, highest |
//! | `source_N-.txt` | what reads MultiNest's files | weight, -2 ln L, parameters |
//! | `source_N-post_separate.dat` | the same | as above; two blank lines before a mode |
//! | `source_N-post_equal_weights.dat` | the same | parameters, ln L |
//! | `source_N-stats.dat` | the same | evidence, means, errors, best parameters |
//!
//! N is `Source_id`, ln L is against no source, and weights sum to one. A source is one mode. There are
//! no files of dead points with their birth contours: samples are weighted anew by all visibilities in
//! the end, and those of sources that overlap come from another sampler.
//!
//! # Source
//! The README of MultiNest 3.12; "GetDist: chain file format", getdist.readthedocs.io.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use vis2cat_formats::{PendingFile, WriteError};

use crate::catalogue::{Estimate, PosteriorRow, SourceRow, WeightedSample, equal_weight};
use crate::config::Config;
use crate::rime::{Source, SpectralIndex};
use crate::units::{ARCSEC, MICROJY};

/// Name, label in LaTeX, value of a parameter.
type Parameter = (&'static str, &'static str, fn(&Source) -> f64);

const PARAMETERS: [Parameter; 7] = [
    ("l_arcsec", r"l\,[\mathrm{arcsec}]", |s| s.lm.l / ARCSEC),
    ("m_arcsec", r"m\,[\mathrm{arcsec}]", |s| s.lm.m / ARCSEC),
    ("flux_ujy", r"S\,[\mu\mathrm{Jy}]", |s| s.flux_jy / MICROJY),
    ("scale_arcsec", r"\alpha\,[\mathrm{arcsec}]", |s| {
        s.scale_rad / ARCSEC
    }),
    ("e1", "e_1", |s| s.e.e1),
    ("e2", "e_2", |s| s.e.e2),
    ("spectral_index", r"\beta", |s| s.tilt),
];

/// Those of the run.
fn parameters(config: &Config) -> &'static [Parameter] {
    &PARAMETERS[..config.source_prior().n_dim()]
}

/// Nothing if chains may be written into `folder`: to be asked before a long run.
///
/// # Errors
/// It is there, is not empty and `overwrite` is false; or its parent is no folder.
pub fn refuse_existing(folder: &Path, overwrite: bool) -> Result<(), WriteError> {
    let unwritable = |source| WriteError::Io {
        path: folder.into(),
        source,
    };
    if folder.symlink_metadata().is_ok() {
        let is_empty = fs::read_dir(folder).map_err(unwritable)?.next().is_none();
        return if is_empty || overwrite {
            Ok(())
        } else {
            Err(WriteError::Exists {
                path: folder.into(),
            })
        };
    }
    match folder.parent().filter(|parent| *parent != Path::new("")) {
        Some(parent) => fs::read_dir(parent).map(drop).map_err(unwritable),
        None => Ok(()),
    }
}

/// Writes the files of all `sources` into `folder`, which is made; those of an earlier run are
/// removed if `overwrite`. None has its name before all are whole.
///
/// # Errors
/// As [`refuse_existing`], or the disk is full.
pub fn write(
    folder: &Path,
    overwrite: bool,
    config: &Config,
    sources: &[SourceRow],
    posterior: &[PosteriorRow],
) -> Result<(), WriteError> {
    refuse_existing(folder, overwrite)?;
    let unwritable = |source| WriteError::Io {
        path: folder.into(),
        source,
    };
    fs::create_dir_all(folder).map_err(unwritable)?;
    let mut pending = Vec::new();
    for source in sources {
        let first = source.post_row as usize;
        let samples = &posterior[first..first + source.post_n as usize];
        for (end, text) in files(config, source, samples) {
            let path = folder.join(format!("source_{}{end}", source.source_id));
            let mut file = PendingFile::create(&path, overwrite)?;
            file.append(text.as_bytes())?;
            file.sync()?;
            pending.push(file);
        }
    }
    remove_old(folder).map_err(unwritable)?;
    pending.into_iter().try_for_each(PendingFile::commit)
}

/// Removes the chains of an earlier run, which may have found more sources.
fn remove_old(folder: &Path) -> io::Result<()> {
    let old = fs::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    let old = old.into_iter().map(|entry| entry.path());
    old.filter(is_ours).try_for_each(fs::remove_file)
}

#[allow(clippy::ptr_arg)] // for `filter`
fn is_ours(path: &PathBuf) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    let rest = name.and_then(|name| name.strip_prefix("source_"));
    rest.is_some_and(|rest| {
        let end = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        end.len() < rest.len() && ENDS.contains(&end)
    })
}

/// How the names of the files end.
const ENDS: [&str; 7] = [
    ".txt",
    ".paramnames",
    ".ranges",
    "-.txt",
    "-post_separate.dat",
    "-post_equal_weights.dat",
    "-stats.dat",
];

/// The texts of the files of one source, each with the end of its name.
fn files(
    config: &Config,
    source: &SourceRow,
    samples: &[PosteriorRow],
) -> impl Iterator<Item = (&'static str, String)> {
    let parameters = parameters(config);
    let chain = |factor: f64| -> String {
        let line =
            |s: &PosteriorRow| line(parameters, &[s.weight, -factor * s.log_l], &s.source, &[]);
        samples.iter().map(line).collect()
    };
    let multinest = chain(2.0);
    let texts = [
        chain(1.0),
        names(parameters),
        ranges(config),
        multinest.clone(),
        format!("\n\n{multinest}"),
        equal_weights(parameters, samples),
        stats(parameters, &source.log_z, samples),
    ];
    ENDS.into_iter().zip(texts)
}

fn line(parameters: &[Parameter], before: &[f64], source: &Source, after: &[f64]) -> String {
    let values: Vec<f64> = parameters
        .iter()
        .map(|(_, _, value)| value(source))
        .collect();
    let numbers = before.iter().chain(&values).chain(after);
    let numbers = numbers.map(|number| format!("{number:24.16e}"));
    numbers.collect::<Vec<_>>().join(" ") + "\n"
}

fn names(parameters: &[Parameter]) -> String {
    let line = |(name, label, _): &Parameter| format!("{name} {label}\n");
    parameters.iter().map(line).collect()
}

/// The ranges of the prior.
fn ranges(config: &Config) -> String {
    let (prior, half) = (&config.prior, 0.5 * config.fov.0 / ARCSEC);
    let flux = [prior.flux.low.0, prior.flux.high.0].map(|flux| flux / MICROJY);
    let scale = [prior.scale.low.0, prior.scale.high.0].map(|scale| scale / ARCSEC);
    let e = [-prior.e_max, prior.e_max];
    let field = [-half, half];
    let index = config.spectral_index.map_or([0.0; 2], SpectralIndex::ends);
    let all = parameters(config)
        .iter()
        .zip([field, field, flux, scale, e, e, index]);
    let lines = all.map(|((name, _, _), [low, high])| format!("{name} {low:.16e} {high:.16e}\n"));
    lines.collect::<Vec<_>>().concat()
}

/// As many draws as there are effective samples.
fn equal_weights(parameters: &[Parameter], samples: &[PosteriorRow]) -> String {
    let n_eff = 1.0 / samples.iter().map(|s| s.weight * s.weight).sum::<f64>();
    let weighted: Vec<WeightedSample> = samples
        .iter()
        .map(|s| WeightedSample {
            log_w: s.weight.ln(),
            log_l: s.log_l,
            source: s.source,
        })
        .collect();
    let drawn = equal_weight(&weighted, n_eff as usize, 0.5);
    drawn
        .iter()
        .map(|s| line(parameters, &[], &s.source, &[s.log_l]))
        .collect()
}

/// MultiNest's summary, with one mode. Its "MAP" is the sample of highest weight.
fn stats(parameters: &[Parameter], log_z: &Estimate, samples: &[PosteriorRow]) -> String {
    let evidence = format!("{:24.16e}  +/-  {:24.16e}", log_z.mean, log_z.err);
    let mut text = format!(
        "Nested Sampling Global Log-Evidence           :  {evidence}\n\n\
         Total Modes Found:  1\n\n\n\
         Mode   1\n\
         Strictly Local Log-Evidence  {evidence}\n\
         Local Log-Evidence  {evidence}\n\n\
         Dim No.       Mean        Sigma\n"
    );
    for (i, (_, _, value)) in parameters.iter().enumerate() {
        let mean: f64 = samples.iter().map(|s| s.weight * value(&s.source)).sum();
        let square = |s: &PosteriorRow| s.weight * (value(&s.source) - mean).powi(2);
        let sigma = samples.iter().map(square).sum::<f64>().sqrt();
        let _ = writeln!(text, "{:4} {mean:24.16e} {sigma:24.16e}", i + 1);
    }
    let by =
        |key: fn(&PosteriorRow) -> f64| samples.iter().max_by(|a, b| key(a).total_cmp(&key(b)));
    for (title, best) in [
        ("Maximum Likelihood", by(|s| s.log_l)),
        ("MAP", by(|s| s.weight)),
    ] {
        let _ = write!(text, "\n{title} Parameters\nDim No.        Parameter\n");
        let values = best
            .iter()
            .flat_map(|s| parameters.iter().map(|(_, _, value)| value(&s.source)));
        for (i, value) in values.enumerate() {
            let _ = writeln!(text, "{:4} {value:24.16e}", i + 1);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_our_own_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let others = [
            "source_.txt",
            "source_1.fits",
            "source_1-notes.txt",
            "a.txt",
        ];
        for name in others
            .iter()
            .chain(&["source_12.txt", "source_3-stats.dat"])
        {
            fs::write(path(name), "").unwrap();
        }
        remove_old(folder.path()).unwrap();
        assert!(others.iter().all(|name| path(name).exists()));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), others.len());
        assert!(refuse_existing(folder.path(), false).is_err());
        assert!(refuse_existing(folder.path(), true).is_ok());
        assert!(refuse_existing(&path("new"), false).is_ok());
        assert!(refuse_existing(&path("no/new"), false).is_err());
    }
}
