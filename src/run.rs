//! The whole run, readable aloud: data in, sources found, catalogue out.

mod entries;
mod outcome;

use std::path::{Path, PathBuf};

use vis2cat_formats::{ReadError, ReadOptions, Selection, WriteError};

use crate::catalogue::CataloguePaths;
use crate::chains;
use crate::checkpoint::{Checkpoint, CheckpointError, Identity};
use crate::config::{Config, ConfigError, SamplerKind, Select, Tiling};
use crate::dataset::{Dataset, DatasetError, EngineOptions, NoiseUsed, OpenOptions};
use crate::detect::{
    Cuts, DetectError, Likely, Observer, SamplerSettings, Settings, Task, detect, field_of_view,
    side_for_basin, tiles,
};
use crate::likelihood::Isa;
use crate::prior::MODE_DIMS;
use crate::sampler::{MultiNest, MultiNestConfig, Sampler, SamplerError, Slice, SliceConfig};
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
const MAX_EVAL_SEARCH: u64 = 1500;
/// The same where slices take over: somewhat more than these take.
const MAX_EVAL_POSTERIOR: u64 = 400;
const MAX_EVAL_SLICE: u64 = 15_000;

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
    /// The checkpoint cannot be used or written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
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
            Self::Checkpoint(error)
            | Self::Dataset(DatasetError::Checkpoint(error))
            | Self::Detect(DetectError::Dataset(DatasetError::Checkpoint(error))) => {
                if error.is_output() { 4 } else { 3 }
            }
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

/// What is kept of a run that does not end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Keep {
    /// Nothing.
    #[default]
    Nothing,
    /// A checkpoint beside the catalogue.
    Checkpoint,
    /// The same, and the run goes on with the one that is there.
    Resume,
}

/// What a run writes.
#[derive(Debug, Clone, Copy)]
pub struct Outputs<'a> {
    /// The catalogue; the posterior samples go beside it.
    pub catalogue: &'a Path,
    /// Folder of chains for other programs.
    pub chains: Option<&'a Path>,
    /// Replace what is there.
    pub overwrite: bool,
    /// In case that the run does not end.
    pub keep: Keep,
}

/// Finds the sources in `inputs`, which are of one field, and writes a catalogue and its posterior samples.
///
/// # Errors
/// Whatever stopped the run; no output stands under its final name then.
pub fn run(
    inputs: &[PathBuf],
    outputs: Outputs,
    config: &Config,
    observer: &mut dyn Observer,
) -> Result<Outcome, RunError> {
    config.check()?;
    let overwrite = outputs.overwrite;
    let paths = CataloguePaths::new(outputs.catalogue);
    paths.refuse_existing(overwrite)?;
    if let Some(folder) = outputs.chains {
        chains::refuse_existing(folder, overwrite)?;
    }
    let digests = inputs.iter().map(|input| digest(input));
    let digests = digests.collect::<Result<Vec<_>, _>>()?;
    let checkpoint = checkpoint(outputs, config, &digests)?;
    let mut dataset = open(inputs, config, observer)?;
    if let Some(checkpoint) = checkpoint {
        dataset.set_checkpoint(checkpoint);
    }
    report_noise(inputs, &dataset);
    let field = field_of_view(config.fov.0);
    let beam_rad = dataset.info().beam_rad;
    let n_tile = n_tile(config, beam_rad);
    let flux_cut_jy = config.flux_cut.map(|flux| flux.0);
    let settings = Settings {
        field,
        tiles: tiles(&field, n_tile, beam_rad),
        beam_rad,
        is_global: config.is_global(),
        screening: config.screening && !config.is_global(),
        prior: config.source_prior(),
        cuts: Cuts {
            snr: config.lowest_snr(),
            flux_jy: flux_cut_jy.filter(|_| config.selection() == Select::Flux),
            merge_radius_rad: config.merge_radius.map(|radius| radius.0),
            merge_floor_rad: MERGE_FLOOR_RAD,
            near_rad: NEAR_BEAMS * beam_rad,
        },
        likely: likely(config),
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
    let outcome = Outcome::new(config, &digests, &dataset, &settings, &detection);
    if let Some(folder) = outputs.chains {
        let (sources, posterior) = (&outcome.sources, &outcome.posterior);
        chains::write(folder, overwrite, config, sources, posterior)?;
    }
    outcome.write(&paths, overwrite)?;
    if let Some(checkpoint) = dataset.take_checkpoint() {
        checkpoint.remove()?;
    }
    Ok(outcome)
}

/// Opens or begins `out.checkpoint` beside `out.fits`, if there is to be one.
fn checkpoint(
    outputs: Outputs,
    config: &Config,
    digests: &[String],
) -> Result<Option<Checkpoint>, CheckpointError> {
    let path = outputs.catalogue.with_extension("checkpoint");
    let identity = Identity {
        version: env!("CARGO_PKG_VERSION").into(),
        processor: format!("{}, {:?}", std::env::consts::ARCH, Isa::detect()),
        input: digests.join(" "),
        config: config.to_toml(),
    };
    match outputs.keep {
        Keep::Nothing => Ok(None),
        Keep::Checkpoint => Checkpoint::create(&path, &identity, outputs.overwrite).map(Some),
        Keep::Resume => Checkpoint::resume(&path, &identity).map(Some),
    }
}

fn open(
    inputs: &[PathBuf],
    config: &Config,
    observer: &mut dyn Observer,
) -> Result<Dataset, DatasetError> {
    let read = ReadOptions {
        data_column: config.data_column.clone(),
        select: Selection {
            field: config.field.clone(),
            spws: config.spw.clone(),
            ..Selection::default()
        },
        ..ReadOptions::default()
    };
    let options = open_options(config, read);
    let mut n_row_known = 0;
    let mut progress = |done, n_row| {
        if n_row_known != n_row {
            n_row_known = n_row;
            observer.stage("reading", n_row);
        }
        observer.advance(done, 0);
    };
    Dataset::open(inputs, &options, &mut progress)
}

/// How a run with `config` opens its data.
pub(crate) fn open_options(config: &Config, read: ReadOptions) -> OpenOptions {
    let prior = config.source_prior();
    OpenOptions {
        read,
        noise: config.noise,
        instrument: config.instrument(),
        memory_bytes: config.memory.0,
        profile: config.prior.profile,
        typical_scale_rad: prior.scale.from_unit(0.5, prior.flux.low_jy),
        engine: EngineOptions {
            engine: config.engine,
            farthest: config.fov.0 * std::f64::consts::FRAC_1_SQRT_2,
            longest_axis_rad: prior.scale.high_rad / (1.0 - config.prior.e_max),
            most_tilt: prior.tilt.unwrap_or(0.0),
        },
    }
}

/// Both noise levels of each file, loudly where they disagree.
fn report_noise(inputs: &[PathBuf], dataset: &Dataset) {
    for (input, noise) in inputs.iter().zip(&dataset.info().noise) {
        let used = match noise.used {
            NoiseUsed::Weights => "the weights as they are",
            NoiseUsed::Data => "the weights, scaled to the noise in the data",
            NoiseUsed::Sefd => "the system equivalent flux density",
        };
        let input = input.display();
        if noise.disagrees() {
            tracing::warn!(
                "{input}: noise of a Stokes I sample: {noise}; used: {used} (see --noise)"
            );
        } else {
            tracing::info!("{input}: noise of a Stokes I sample: {noise}; used: {used}");
        }
    }
}

/// What is asked of sources above the cut, where probabilities select.
fn likely(config: &Config) -> Option<Likely> {
    let above_jy = match config.selection() {
        Select::Snr | Select::Flux => return None,
        Select::Bayes => config.flux_cut.map(|flux| flux.0),
        Select::PSource => None,
    };
    let p_cut = config.p_cut;
    Some(Likely { p_cut, above_jy })
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
    // Modes are only to be seen, if each source is sampled again by itself.
    const N_LIVE_SEEN: usize = 4;
    let SamplerSettings {
        n_dim,
        n_live,
        seed,
        ..
    } = settings;
    let mode_dims = match settings.task {
        Task::Search => MODE_DIMS.to_vec(),
        Task::Posterior | Task::AnyPosterior => Vec::new(),
    };
    let tolerance = config.tolerance;
    let kind = match settings.task {
        Task::AnyPosterior => SamplerKind::Slice,
        _ => config.sampler,
    };
    let max_eval = most_evaluations(config, kind, settings);
    let n_live_mode = |full: usize| if config.refine { N_LIVE_SEEN } else { full };
    Ok(match kind {
        SamplerKind::Multinest => {
            let defaults = MultiNestConfig::new(n_dim, n_live);
            Box::new(MultiNest::new(MultiNestConfig {
                n_live_mode: n_live_mode(defaults.n_live_mode),
                mode_dims,
                efficiency: config.efficiency,
                tolerance,
                max_eval,
                seed,
                ..defaults
            })?)
        }
        SamplerKind::Slice => {
            let defaults = SliceConfig::new(n_dim, n_live);
            Box::new(Slice::new(SliceConfig {
                n_live_mode: n_live_mode(defaults.n_live_mode),
                mode_dims,
                tolerance,
                max_eval,
                seed,
                ..defaults
            })?)
        }
    })
}

/// Where a sampler is stopped. What the one search of a global run misses is never looked for
/// again, so it has all the time it takes.
fn most_evaluations(config: &Config, kind: SamplerKind, settings: SamplerSettings) -> Option<u64> {
    let is_search = settings.task == Task::Search;
    let per_live_point = match kind {
        SamplerKind::Slice => MAX_EVAL_SLICE,
        SamplerKind::Multinest if is_search => MAX_EVAL_SEARCH,
        SamplerKind::Multinest => MAX_EVAL_POSTERIOR,
    };
    let is_only_search = is_search && config.is_global();
    (!is_only_search).then_some(per_live_point * settings.n_live as u64)
}

/// BLAKE3 of the input's bytes; of a directory, of its files with their names.
pub(crate) fn digest(input: &Path) -> Result<String, ReadError> {
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
