//! The whole run, readable aloud: data in, sources found, catalogue out.

mod outcome;

use std::path::{Path, PathBuf};

use vis2cat_formats::{ReadError, ReadOptions, WriteError};

use crate::catalogue::CataloguePaths;
use crate::config::{Config, ConfigError, SamplerKind, Tiling};
use crate::dataset::{Dataset, DatasetError, EngineOptions, NoiseUsed, OpenOptions};
use crate::detect::{
    Cuts, DetectError, Observer, SamplerSettings, Settings, detect, field_of_view, side_for_basin,
    tiles,
};
use crate::prior::{MODE_DIMS, N_DIM};
use crate::sampler::{MultiNest, MultiNestConfig, Sampler, SamplerError};
use crate::simulate::SimulateError;
use crate::units::ARCSEC;

pub use outcome::Outcome;

/// Modes within this many widths of the beam may be sidelobes of each other.
const NEAR_BEAMS: f64 = 12.0;
/// Modes closer than this are one source, however well they are measured (method section 4).
const MERGE_FLOOR_RAD: f64 = 0.4 * ARCSEC;
/// Live points about a single source, whose posterior is one piece.
const N_LIVE_SOURCE: usize = 300;

/// Evaluations a live point after which a sampler has stalled: several times what a well-shaped
/// posterior takes.
const MAX_EVAL_PER_LIVE_POINT: u64 = 1500;

/// A run failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The configuration makes no sense.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The data cannot be read or used.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// Another input cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// An output cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Detection did not end well.
    #[error("detection failed")]
    Detect(#[from] DetectError),
    /// The simulation could not be done.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
}

impl RunError {
    /// The exit code of the program: see `vis2cat --help`.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Detect(DetectError::Sampler { .. }) => 1,
            Self::Config(_)
            | Self::Simulate(
                SimulateError::Parameter { .. } | SimulateError::NoEarthOrientation { .. },
            ) => 2,
            Self::Write(_) | Self::Simulate(SimulateError::Write(_)) => 4,
            Self::Dataset(_)
            | Self::Detect(DetectError::Dataset(_))
            | Self::Read(_)
            | Self::Simulate(_) => 3,
        }
    }
}

/// Finds the sources in `input` and writes `output` and its posterior samples.
///
/// # Errors
/// Whatever stopped the run; no output stands under its final name then.
pub fn run(
    input: &Path,
    output: &Path,
    config: &Config,
    overwrite: bool,
    observer: &mut dyn Observer,
) -> Result<Outcome, RunError> {
    config.check()?;
    let paths = CataloguePaths::new(output);
    paths.refuse_existing(overwrite)?;
    let digest = digest(input)?;
    let mut dataset = open(input, config, observer)?;
    report_noise(&dataset);
    let field = field_of_view(config.fov.0);
    let beam_rad = dataset.info().beam_rad;
    let n_tile = n_tile(config, beam_rad);
    let settings = Settings {
        field,
        tiles: tiles(&field, n_tile, beam_rad),
        beam_rad,
        is_global: config.is_global(),
        screening: config.screening && !config.is_global(),
        prior: config.prior.source_prior(),
        cuts: Cuts {
            snr: config.snr_cut,
            flux_jy: config.flux_cut.map(|flux| flux.0),
            merge_radius_rad: config.merge_radius.map(|radius| radius.0),
            merge_floor_rad: MERGE_FLOOR_RAD,
            near_rad: NEAR_BEAMS * beam_rad,
        },
        factory: &|settings| sampler(config, settings),
        n_live: config.n_live_tile(),
        n_live_source: N_LIVE_SOURCE,
        refine: config.refine,
        seed: config.seed,
    };
    tracing::info!(
        "{} samples, beam {:.2} arcsec, {} tiles of {} live points",
        dataset.info().n_sample,
        beam_rad / ARCSEC,
        settings.tiles.len(),
        settings.n_live
    );
    let detection = detect(&mut dataset, &settings, observer)?;
    let outcome = Outcome::new(config, &digest, &dataset, &settings, &detection);
    outcome.write(&paths, overwrite)?;
    Ok(outcome)
}

fn open(
    input: &Path,
    config: &Config,
    observer: &mut dyn Observer,
) -> Result<Dataset, DatasetError> {
    let prior = config.prior.source_prior();
    let options = OpenOptions {
        read: ReadOptions {
            data_column: config.data_column.clone(),
        },
        field: config.field.clone(),
        noise: config.noise,
        instrument: config.instrument(),
        memory_bytes: config.memory.0,
        profile: config.prior.profile,
        typical_scale_rad: prior.scale.from_unit(0.5, prior.flux.low_jy),
        engine: EngineOptions {
            engine: config.engine,
            farthest: config.fov.0 * std::f64::consts::FRAC_1_SQRT_2,
            longest_axis_rad: prior.scale.high_rad / (1.0 - config.prior.e_max),
        },
    };
    let mut n_row_known = 0;
    let mut progress = |done, n_row| {
        if n_row_known != n_row {
            n_row_known = n_row;
            observer.stage("reading", n_row);
        }
        observer.advance(done, 0);
    };
    Dataset::open(input, &options, &mut progress)
}

/// Both noise levels, loudly where they disagree.
fn report_noise(dataset: &Dataset) {
    let noise = &dataset.info().noise;
    let used = match noise.used {
        NoiseUsed::Weights => "the weights as they are",
        NoiseUsed::Data => "the weights, scaled to the noise in the data",
        NoiseUsed::Sefd => "the system equivalent flux density",
    };
    if noise.disagrees() {
        tracing::warn!("noise of a Stokes I sample: {noise}; used: {used} (see --noise)");
    } else {
        tracing::info!("noise of a Stokes I sample: {noise}; used: {used}");
    }
}

fn n_tile(config: &Config, beam_rad: f64) -> usize {
    let by_side = |side_rad: f64| (config.fov.0 / side_rad).ceil().powi(2) as usize;
    match config.tiles {
        Tiling::Count(n) => n,
        Tiling::Size(side) => by_side(side.0),
        Tiling::Auto => by_side(side_for_basin(config.n_live_tile(), beam_rad)),
    }
}

fn sampler(config: &Config, settings: SamplerSettings) -> Result<Box<dyn Sampler>, SamplerError> {
    match config.sampler {
        SamplerKind::Multinest => Ok(Box::new(MultiNest::new(MultiNestConfig {
            // Modes are only to be seen here; each source is sampled again by itself.
            n_live_mode: 4,
            mode_dims: if settings.search {
                MODE_DIMS.to_vec()
            } else {
                Vec::new()
            },
            efficiency: config.efficiency,
            tolerance: config.tolerance,
            max_eval: most_evaluations(config, settings),
            seed: settings.seed,
            ..MultiNestConfig::new(N_DIM, settings.n_live)
        })?)),
    }
}

/// Where a sampler is stopped. What the one search of a global run misses is never looked for
/// again, so it has all the time it takes.
fn most_evaluations(config: &Config, settings: SamplerSettings) -> Option<u64> {
    let is_only_search = settings.search && config.is_global();
    (!is_only_search).then_some(MAX_EVAL_PER_LIVE_POINT * settings.n_live as u64)
}

/// BLAKE3 of the input's bytes; of a directory, of its files with their names.
fn digest(input: &Path) -> Result<String, ReadError> {
    let mut hasher = blake3::Hasher::new();
    add_to_digest(input, &mut hasher).map_err(|source| ReadError::Io {
        path: PathBuf::from(input),
        source,
    })?;
    Ok(hasher.finalize().to_hex().to_string())
}

fn add_to_digest(path: &Path, hasher: &mut blake3::Hasher) -> std::io::Result<()> {
    if !path.is_dir() {
        hasher.update_reader(std::fs::File::open(path)?)?;
        return Ok(());
    }
    let entries = std::fs::read_dir(path)?;
    let mut paths = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<std::io::Result<Vec<_>>>()?;
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap_or_default();
        // Casacore's locks are written by whoever reads.
        if name != "table.lock" {
            hasher.update(name.as_encoded_bytes());
            add_to_digest(&path, hasher)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::SamplerError;

    #[test]
    fn detection_that_fails_is_1_unless_the_input_is_to_blame() {
        let stuck = DetectError::Sampler {
            l_arcsec: 0.0,
            m_arcsec: 0.0,
            source: SamplerError::Stalled {
                n_eval: 1,
                log_l: 0.0,
                advice: String::new(),
            },
        };
        assert_eq!(RunError::Detect(stuck).exit_code(), 1);
        let gone = DetectError::Dataset(DatasetError::Unusable {
            path: "a.uvfits".into(),
            what: "gone".into(),
        });
        assert_eq!(RunError::Detect(gone).exit_code(), 3);
    }
}
