//! The table `RUN`: what decided the result, and how it went.

use crate::catalogue::RunEntry;
use crate::config::Config;
use crate::dataset::{Dataset, NoiseReport};
use crate::detect::{Detection, Settings};
use crate::sampler::Health;
use crate::units::{ARCSEC, MICROJY};

/// Versions, counts, diagnostics and options.
pub(super) fn of_run(
    config: &Config,
    digests: &[String],
    dataset: &Dataset,
    settings: &Settings,
    detection: &Detection,
) -> Vec<RunEntry> {
    let info = dataset.info();
    let mut entries = vec![
        RunEntry::new("version", env!("CARGO_PKG_VERSION"), "vis2cat"),
        RunEntry::new("data.n_row", info.n_row, "rows in the input"),
        RunEntry::new("data.n_sample", info.n_sample, "Stokes I samples used"),
        RunEntry::new("data.n_flagged", info.n_flagged, "Stokes I samples flagged"),
        RunEntry::new(
            "data.mean_freq",
            info.mean_freq_hz,
            "[Hz] weighted mean frequency",
        ),
        RunEntry::new("data.max_uv", info.max_uv, "[wavelength] longest baseline"),
        RunEntry::new(
            "data.beam",
            info.beam_rad / ARCSEC,
            "[arcsec] width of the response, sigma",
        ),
        RunEntry::new("search.n_tile", settings.tiles.len(), "tiles"),
        RunEntry::new("search.n_live", settings.n_live, "live points a tile"),
        RunEntry::new(
            "search.n_tile_unfinished",
            detection.n_tile_unfinished,
            "searches stopped early",
        ),
        RunEntry::new("search.n_eval", detection.n_eval, "likelihood evaluations"),
        RunEntry::new("search.n_mode", detection.modes.len(), "modes found"),
        RunEntry::new(
            "search.n_tile_searched",
            detection.n_tile_searched,
            "over all rounds",
        ),
        RunEntry::new("search.n_source", detection.sources.len(), "sources"),
        RunEntry::new(
            "search.n_expected",
            detection.census.n_expected,
            "sources in the field by the evidences of those found, detectable or not",
        ),
        RunEntry::new(
            "search.confusion",
            detection.census.confusion.sqrt(),
            "rms that sources below the cut add, in units of the noise",
        ),
    ];
    for (i, (digest, noise)) in digests.iter().zip(&info.noise).enumerate() {
        entries.extend(input_entries(i, digests.len(), digest, noise));
    }
    entries.extend(detection.log_z.iter().enumerate().map(|(round, log_z)| {
        let key = format!("search.log_z.{}", round + 1);
        RunEntry::new(
            &key,
            log_z,
            "one source in the tiles of a round against none",
        )
    }));
    entries.extend(health_entries("search", &detection.search_health));
    entries.extend(health_entries("posterior", &detection.source_health));
    entries.push(cut_entry(settings));
    if let Some(screening) = detection.screening {
        entries.extend([
            RunEntry::new(
                "search.skipped",
                screening.skipped,
                "part of the field that was not searched",
            ),
            RunEntry::new(
                "search.seen",
                screening.seen,
                "part of its SNR that a source shows to screening",
            ),
            RunEntry::new(
                "search.n_negative",
                screening.n_negative,
                "negative peaks as high as the cut",
            ),
        ]);
    }
    let toml = config.to_toml();
    let mut section = String::new();
    for line in toml.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            section = format!("{name}.");
        } else if let Some((key, value)) = line.split_once(" = ") {
            let value = value.trim_matches('"');
            entries.push(RunEntry::new(
                &format!("config.{section}{key}"),
                value,
                "option",
            ));
        }
    }
    entries
}

/// Which cut it was.
fn cut_entry(settings: &Settings) -> RunEntry {
    let cuts = &settings.cuts;
    match cuts.flux_jy {
        None => RunEntry::new("search.snr_cut", cuts.snr, "lowest signal-to-noise ratio"),
        Some(flux_jy) => RunEntry::new(
            "search.flux_cut",
            flux_jy / MICROJY,
            "[uJy] lowest flux density",
        ),
    }
}

/// What is told of the samplers of a stage, if there were any.
fn health_entries(stage: &str, health: &Health) -> Vec<RunEntry> {
    if health.n_run == 0 {
        return Vec::new();
    }
    let entry = |name: &str, value: f64, what: &str| {
        RunEntry::new(&format!("sampler.{stage}.{name}"), value, what)
    };
    vec![
        entry("n_run", health.n_run as f64, "runs of the sampler"),
        entry(
            "efficiency",
            health.efficiency(),
            "dead points an evaluation",
        ),
        entry(
            "insertion_mean",
            health.insertion_mean(),
            "mean insertion rank, 0.5 if all is well",
        ),
        entry(
            "insertion_p",
            health.insertion_p(),
            "least p value of the insertion tests, times their number",
        ),
        entry(
            "log_z_err",
            health.log_z_err(),
            "error of log Z, rms over runs",
        ),
        entry(
            "log_z_err_bootstrap",
            health.log_z_err_bootstrap(),
            "the same over bootstraps of the live points' threads",
        ),
        entry(
            "fewest_live",
            health.fewest_live as f64,
            "live points that a mode began with, at least",
        ),
    ]
}

/// What is told of each input, which has a number where there are several.
fn input_entries(i: usize, n_input: usize, digest: &str, noise: &NoiseReport) -> [RunEntry; 4] {
    let key = |group: &str, name: &str| match n_input {
        1 => format!("{group}.{name}"),
        _ => format!("{group}.{}.{name}", i + 1),
    };
    [
        RunEntry::new(
            &key("input", "blake3"),
            digest,
            "BLAKE3 of the input's bytes",
        ),
        RunEntry::new(
            &key("noise", "weights"),
            noise.weights_sigma_jy,
            "[Jy] sigma by the weights",
        ),
        RunEntry::new(
            &key("noise", "data"),
            noise.data_sigma_jy.unwrap_or(f64::NAN),
            "[Jy] sigma by differences in the data",
        ),
        RunEntry::new(
            &key("noise", "weight_scale"),
            noise.weight_scale,
            "factor on the file's weights",
        ),
    ]
}
