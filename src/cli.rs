//! The command line: flags exactly as typed, and what they do to the configuration.

mod convert;
mod evaluate;
mod guard;
mod info;
mod instrument;
mod progress;
mod report;
mod select;
mod simulate;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use vis2cat_formats::fits::refuse_existing;

use crate::config::{Config, ConfigError, Engine, NoiseSource, SamplerKind, Select, Tiling};
use crate::run::{self, Keep, Outputs, RunError};
use crate::timing::{self, Stopwatch};
use crate::units::{Angle, Flux, Memory, Range};

const EXAMPLES: &str = "\
Examples:
  vis2cat field.uvfits sources.fits
      Sources in 1 deg x 1 deg about the phase centre, into sources.fits and
      sources.posterior.fits.
  vis2cat field.uvfits sources.fits --fov 10arcmin --flux 50uJy:5mJy --snr-cut 7
      A smaller field, brighter sources, a stricter cut.
  vis2cat field.uvfits sources.fits --flux 1uJy:10uJy --select p-source
      Faint sources: what is more probably a source than noise.
  vis2cat field.uvfits sources.fits --tiles 1 --n-live 8000
      The single global run of Malyali et al. (2018).
  vis2cat field.uvfits sources.fits --resume
      A long run that may be killed: the same command goes on where it was.
  vis2cat field.uvfits sources.fits --chains chains
      Chains for getdist and anesthetic beside the catalogue, chains/source_1.txt and so on.
  vis2cat day1.ms day2.uvfits sources.fits
      Several observations of one field, in one likelihood.
  vis2cat wide.ms sources.fits --fov 1.4deg --smearing --beam meerkat --spectral-index -0.7
      A wide field of MeerKAT: flux densities are those outside the beam.
  vis2cat info field.uvfits
      What is in the file, and how noisy it is.
  vis2cat convert field.ms field.uvfits
      The same visibilities in another format.
  vis2cat simulate field.uvfits --array ska1-mid --sources 20 --truth truth.fits
      A field to try it on.
  vis2cat evaluate sources.fits truth.fits
      How much of it was found, and how well.
  vis2cat report sources.fits -o report.html
      The field, the posteriors and how the run went as one page.

Exit codes:
  0  done, also when no source was found
  1  the run failed
  2  the command line or the configuration is wrong
  3  an input cannot be read or used
  4  an output cannot be written";

/// Radio-interferometer visibilities in, a source catalogue with full posteriors out.
#[derive(Debug, Parser)]
#[command(version, about, after_help = EXAMPLES, max_term_width = 100)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    detect: DetectArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Prints what is in a visibility file
    Info(info::InfoArgs),
    /// Writes visibilities in another format
    Convert(convert::ConvertArgs),
    /// Simulates an observation
    Simulate(Box<simulate::SimulateArgs>),
    /// Compares a catalogue with the truth
    Evaluate(evaluate::EvaluateArgs),
    /// Writes a page that shows a catalogue: field, posteriors, diagnostics
    Report(report::ReportArgs),
}

/// Flags that every command knows.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct CommonArgs {
    /// Threads [default: all cores]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Replace outputs that exist
    #[arg(long)]
    pub overwrite: bool,
    /// Nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// More detail (-v, -vv)
    #[arg(long, short, action = clap::ArgAction::Count, conflicts_with = "quiet")]
    pub verbose: u8,
}

#[derive(Debug, Args)]
struct DetectArgs {
    /// Visibilities of one field (UVFITS or UVH5 files, Measurement Sets), and last the catalogue to
    /// write; the posterior samples go to OUT.posterior.fits
    #[arg(value_names = ["IN", "OUT.fits"], num_args = 2.., required = true)]
    paths: Vec<PathBuf>,
    /// Options from a TOML file; flags win over it
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    flags: Flags,
    /// Folder for the posterior of each source in the files of GetDist, anesthetic and MultiNest
    #[arg(long, value_name = "DIR")]
    chains: Option<PathBuf>,
    /// File for the wall time of each stage (CSV), which `vis2cat report --timings` shows
    #[arg(long, value_name = "FILE")]
    timings: Option<PathBuf>,
    /// Keep a checkpoint beside the catalogue, OUT.checkpoint, until the run has ended
    #[arg(long)]
    checkpoint: bool,
    /// Go on with the checkpoint of a run that was killed, to the same catalogue; keep one anyway
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    common: CommonArgs,
}

/// Flags that change the configuration; one that is not given changes nothing.
#[derive(Debug, Default, Args)]
struct Flags {
    /// Side of the square field of view about the phase centre [default: 1deg]
    #[arg(long, value_name = "ANGLE")]
    fov: Option<Angle>,
    /// Name or number of the field, where the file holds several
    #[arg(long, value_name = "FIELD")]
    field: Option<String>,
    /// Numbers of the spectral windows to use, as in 0,2 [default: all]
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',')]
    spw: Option<Vec<i64>>,
    /// Column of visibilities of a Measurement Set [default: CORRECTED_DATA where filled, or DATA]
    #[arg(long, value_name = "NAME")]
    data_column: Option<String>,
    /// Prior range of flux density [default: 10uJy:200uJy]
    #[arg(long, value_name = "LOW:HIGH")]
    flux: Option<Range<Flux>>,
    /// What makes a mode a source: signal-to-noise ratio, mean flux density, the probability to be a
    /// source above the flux cut (bayes), or to be a source [default: flux with a flux cut, or snr]
    #[arg(long, value_enum)]
    select: Option<Select>,
    /// Lowest matched-filter signal-to-noise ratio of a source [default: 6; 5 where probabilities select]
    #[arg(long, value_name = "SNR")]
    snr_cut: Option<f64>,
    /// Lowest flux density of a source, for --select flux and bayes
    #[arg(long, value_name = "FLUX")]
    flux_cut: Option<Flux>,
    /// Probability that a source exceeds, for --select bayes and p-source [default: 0.5]
    #[arg(long, value_name = "P")]
    p_cut: Option<f64>,
    /// Modes closer than this are one source [default: their own uncertainty, at least 0.4arcsec]
    #[arg(long, value_name = "ANGLE")]
    merge_radius: Option<Angle>,
    /// Likelihood engine [default: auto]
    #[arg(long, value_enum)]
    engine: Option<Engine>,
    /// Sampler [default: multinest]
    #[arg(long, value_enum)]
    sampler: Option<SamplerKind>,
    /// Live points of each tile [default: 120; 8000 with --tiles 1]
    #[arg(long, value_name = "N")]
    n_live: Option<usize>,
    /// Sampling efficiency [default: 0.8]
    #[arg(long, value_name = "FRACTION")]
    efficiency: Option<f64>,
    /// At least this many tiles; 1 is one global run [default: by the resolution of the data]
    #[arg(long, value_name = "N", conflicts_with = "tile_size")]
    tiles: Option<usize>,
    /// Largest side of a tile
    #[arg(long, value_name = "ANGLE")]
    tile_size: Option<Angle>,
    /// Search every tile, also those that cannot hold a source
    #[arg(long)]
    no_screening: bool,
    /// Noise level: auto, weights, data or sefd=400Jy [default: auto]
    #[arg(long, value_name = "SOURCE")]
    noise: Option<NoiseSource>,
    #[command(flatten)]
    instrument: instrument::InstrumentArgs,
    /// Keep the modes as first found: do not sample each source with the others removed
    #[arg(long)]
    no_refine: bool,
    /// Seed of every random stream [default: 1]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Memory for visibilities; more are streamed from the file in each pass [default: 256MB]
    #[arg(long, value_name = "SIZE")]
    memory: Option<Memory>,
    /// Acronym in front of source names [default: V2C]
    #[arg(long, value_name = "TEXT")]
    acronym: Option<String>,
}

/// Puts a given value in place of the old one.
fn set<T>(target: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *target = value;
    }
}

impl Flags {
    fn apply(self, config: &mut Config) {
        set(&mut config.fov, self.fov);
        set(&mut config.field, self.field.map(Some));
        set(&mut config.spw, self.spw);
        set(&mut config.data_column, self.data_column.map(Some));
        set(&mut config.prior.flux, self.flux);
        set(&mut config.select, self.select.map(Some));
        set(&mut config.snr_cut, self.snr_cut.map(Some));
        set(&mut config.p_cut, self.p_cut);
        set(&mut config.flux_cut, self.flux_cut.map(Some));
        set(&mut config.merge_radius, self.merge_radius.map(Some));
        set(&mut config.engine, self.engine);
        set(&mut config.sampler, self.sampler);
        set(&mut config.n_live, self.n_live.map(Some));
        set(&mut config.efficiency, self.efficiency);
        set(&mut config.tiles, self.tiles.map(Tiling::Count));
        set(&mut config.tiles, self.tile_size.map(Tiling::Size));
        set(&mut config.noise, self.noise);
        config.smearing |= self.instrument.smearing;
        set(
            &mut config.beam,
            self.instrument.beam.map(|choice| choice.0),
        );
        set(
            &mut config.spectral_index,
            self.instrument.spectral_index.map(Some),
        );
        set(&mut config.seed, self.seed);
        set(&mut config.memory, self.memory);
        set(&mut config.acronym, self.acronym);
        config.refine &= !self.no_refine;
        config.screening &= !self.no_screening;
    }
}

impl Cli {
    /// Flags that every command knows.
    pub fn common(&self) -> CommonArgs {
        match &self.command {
            Some(Command::Info(args)) => args.common(),
            Some(Command::Convert(args)) => args.common(),
            Some(Command::Simulate(args)) => args.common,
            Some(Command::Evaluate(_)) => CommonArgs::default(),
            Some(Command::Report(args)) => args.common(),
            None => self.detect.common,
        }
    }

    /// The files that the command reads visibilities from.
    fn inputs(&self) -> Vec<&Path> {
        match &self.command {
            Some(Command::Info(args)) => vec![args.file()],
            Some(Command::Convert(args)) => vec![args.input()],
            Some(Command::Report(args)) => args.data().iter().map(PathBuf::as_path).collect(),
            Some(Command::Simulate(_) | Command::Evaluate(_)) => Vec::new(),
            None => {
                let inputs = self.detect.paths.split_last().map(|(_, inputs)| inputs);
                inputs
                    .unwrap_or_default()
                    .iter()
                    .map(PathBuf::as_path)
                    .collect()
            }
        }
    }

    /// The exit code of a process of its own that did all of it, where an input may end its reader; none where
    /// [`execute`](Self::execute) is to do it.
    ///
    /// # Errors
    /// That process was ended by a damaged input.
    pub fn execute_guarded(&self) -> Result<Option<ExitCode>, RunError> {
        guard::run_guarded(&self.inputs())
    }

    /// Runs the command; what it has to say goes to standard output.
    ///
    /// # Errors
    /// Whatever stopped it.
    pub fn execute(self) -> Result<(), RunError> {
        match self.command {
            Some(Command::Info(args)) => info::execute(&args),
            Some(Command::Convert(args)) => convert::execute(&args),
            Some(Command::Simulate(args)) => simulate::execute(&args),
            Some(Command::Evaluate(args)) => evaluate::execute(&args),
            Some(Command::Report(args)) => report::execute(&args),
            None => detect(self.detect),
        }
    }
}

fn detect(args: DetectArgs) -> Result<(), RunError> {
    let Some((output, inputs)) = args
        .paths
        .split_last()
        .filter(|(_, inputs)| !inputs.is_empty())
    else {
        return Err(RunError::Config(ConfigError::Value {
            key: "IN OUT.fits",
            value: String::new(),
            what: "both are needed",
        }));
    };
    let mut config = match &args.config {
        Some(path) => Config::from_file(path)?,
        None => Config::default(),
    };
    args.flags.apply(&mut config);
    config.check()?;
    let keep = match (args.checkpoint, args.resume) {
        (_, true) => Keep::Resume,
        (true, false) => Keep::Checkpoint,
        (false, false) => Keep::Nothing,
    };
    let mut progress = progress::Bar::new(args.common.quiet);
    let outputs = Outputs {
        catalogue: output,
        chains: args.chains.as_deref(),
        overwrite: args.common.overwrite,
        keep,
    };
    if let Some(path) = &args.timings {
        refuse_existing(path, args.common.overwrite)?;
    }
    let mut stopwatch = Stopwatch::new(&mut progress);
    let outcome = run::run(inputs, outputs, &config, &mut stopwatch)?;
    let stages = stopwatch.stages();
    progress.finish();
    if let Some(path) = &args.timings {
        timing::write(path, args.common.overwrite, &stages)?;
    }
    if !args.common.quiet {
        say(&outcome.summary);
    }
    Ok(())
}

/// The one place where results are printed. A reader that has gone away wants no more of them.
fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}
