//! `vis2cat convert`: one visibility format to another.

use std::path::{Path, PathBuf};

use clap::Args;
use vis2cat_formats::{Averaging, ReadError, ReadOptions, VisChunk, create, open_with};

use super::{CommonArgs, progress::Bar, say, select::ReadArgs};
use crate::detect::Observer;
use crate::run::RunError;
use crate::simulate::parse_utc;
use crate::units::Duration;

/// Values that a chunk may hold: a few tens of megabytes.
const CHUNK_VALUES: usize = 1 << 20;

const EXAMPLES: &str = "\
Examples:
  vis2cat convert field.uvfits field.ms
  vis2cat convert field.ms field.uvh5 --data-column DATA
  vis2cat convert field.ms part.ms --field 3C286 --spw 0 --channels 8:55
  vis2cat convert field.ms part.uvfits --times 2026-01-01T08:00..2026-01-01T08:30
  vis2cat convert field.ms part.uvfits --baselines 'ea01&ea02,ea05' --cross-only
  vis2cat convert field.ms small.uvh5 --average-time 8s --average-channels 4 --stokes I

Without options everything is kept that both formats have a place for: visibilities, flags and weights to the precision
of the new format, (u, v, w), times, antennas, phase centres, frequencies.

Averages are weighted with the weights of the unflagged samples, whose sum is the new weight; (u, v, w)
are averaged with the same weights, the time is the middle of what was averaged. Steps of time begin with
the first row; rows are averaged with the rows of their baseline in the same step.";

/// Flags of `vis2cat convert`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ConvertArgs {
    /// Visibilities: a UVFITS or UVH5 file or a Measurement Set
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// What to write: a Measurement Set if it ends in .ms, UVH5 if in .uvh5, UVFITS otherwise
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    read: ReadArgs,
    /// First and last time, as UTC or MJD, in the time scale of the file; either may be left out
    #[arg(long, value_name = "FIRST..LAST", value_parser = times)]
    times: Option<[f64; 2]>,
    /// First and last channel of every spectral window, from 0
    #[arg(long, value_name = "FIRST:LAST", value_parser = channels)]
    channels: Option<[usize; 2]>,
    /// Pairs of antennas, or antennas with all others, by name or number, as in 'ea01&ea02,ea05'
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = baseline)]
    baselines: Vec<(String, Option<String>)>,
    /// Leave out autocorrelations
    #[arg(long)]
    cross_only: bool,
    /// Total intensity instead of the correlations
    #[arg(long, value_enum, value_name = "I")]
    stokes: Option<Stokes>,
    /// Average rows over this length of time
    #[arg(long, value_name = "TIME")]
    average_time: Option<Duration>,
    /// Average this many channels into one
    #[arg(long, value_name = "N")]
    average_channels: Option<usize>,
    /// Replace an output that exists
    #[arg(long)]
    overwrite: bool,
    /// Nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

impl ConvertArgs {
    pub(crate) fn input(&self) -> &Path {
        &self.input
    }

    fn options(&self) -> ReadOptions {
        let mut options = self.read.options();
        options.select.times_mjd = self.times;
        options.select.channels = self.channels;
        options.select.baselines.clone_from(&self.baselines);
        options.select.cross_only = self.cross_only;
        options.select.stokes_i = self.stokes.is_some();
        options.average = Averaging {
            time_s: self.average_time.map(|time| time.0),
            channels: self.average_channels,
        };
        options
    }

    pub(crate) fn common(&self) -> CommonArgs {
        CommonArgs {
            quiet: self.quiet,
            ..CommonArgs::default()
        }
    }
}

/// What can be asked for instead of correlations.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Stokes {
    /// Total intensity.
    #[value(name = "I")]
    I,
}

fn times(text: &str) -> Result<[f64; 2], String> {
    let what = "write FIRST..LAST, as in 2026-01-01T08:00..2026-01-01T08:30 or 60000.25..60000.5";
    let (first, last) = text.split_once("..").ok_or(what)?;
    let time = |text: &str, otherwise: f64| match text.trim() {
        "" => Ok(otherwise),
        text => match text.parse::<f64>() {
            Ok(mjd) if mjd.is_finite() => Ok(mjd),
            _ => parse_utc(text).map_err(|e| format!("{e}; {what}")),
        },
    };
    Ok([time(first, f64::NEG_INFINITY)?, time(last, f64::INFINITY)?])
}

fn channels(text: &str) -> Result<[usize; 2], String> {
    let ends = text.split_once(':').and_then(|(first, last)| {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        Some([number(first)?, number(last)?])
    });
    match ends {
        Some([first, last]) if first <= last => Ok([first, last]),
        _ => Err("write FIRST:LAST, from 0, as in 8:55".into()),
    }
}

fn baseline(text: &str) -> Result<(String, Option<String>), String> {
    let (first, second) = match text.split_once('&') {
        Some((first, second)) => (first, Some(second)),
        None => (text, None),
    };
    if first.trim().is_empty() || second.is_some_and(|name| name.trim().is_empty()) {
        return Err(
            "write pairs of antennas as in ea01&ea02, one antenna for all its baselines".into(),
        );
    }
    Ok((
        first.trim().to_owned(),
        second.map(|name| name.trim().to_owned()),
    ))
}

/// Copies row after row.
pub(crate) fn execute(args: &ConvertArgs) -> Result<(), RunError> {
    let options = args.options();
    let mut reader = open_with(&args.input, &options)?;
    let observation = reader.observation();
    for warning in &observation.warnings {
        tracing::warn!("{}: {warning}", args.input.display());
    }
    let n_row = observation.n_row;
    let n_chan = observation.freq_setups.iter().map(|s| s.freq_hz_f.len());
    let values = n_chan.max().unwrap_or(1) * observation.corrs.len();
    let mut chunk = VisChunk::new((CHUNK_VALUES / values.max(1)).max(1));
    let mut writer = create(&args.output, observation, args.overwrite)?;
    let mut bar = Bar::new(args.quiet);
    bar.stage("converting", n_row);
    let mut n_done = 0;
    loop {
        let n = reader.read_chunk(&mut chunk)?;
        if n == 0 {
            break;
        }
        writer.write_chunk(&chunk)?;
        n_done += n as u64;
        bar.advance(reader.n_row_read(), 0);
    }
    if n_done == 0 {
        return Err(nothing_left(args));
    }
    writer.finish()?;
    bar.finish();
    if !args.quiet {
        say(&format!("{}: {n_done} rows", args.output.display()));
    }
    Ok(())
}

fn nothing_left(args: &ConvertArgs) -> RunError {
    RunError::Read(ReadError::Unsupported {
        path: args.input.clone(),
        place: "selection".into(),
        what: "no row is selected; vis2cat info tells what there is".into(),
    })
}
