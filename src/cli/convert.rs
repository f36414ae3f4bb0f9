//! `vis2cat convert`: one visibility format to another.

use std::path::PathBuf;

use clap::Args;
use vis2cat_formats::{ReadOptions, VisChunk, create, open_with};

use super::{CommonArgs, progress::Bar, say};
use crate::detect::Observer;
use crate::run::RunError;

/// Values that a chunk may hold: a few tens of megabytes.
const CHUNK_VALUES: usize = 1 << 20;

const EXAMPLES: &str = "\
Examples:
  vis2cat convert field.uvfits field.ms
  vis2cat convert field.ms field.uvh5 --data-column DATA

Everything is kept that both formats have a place for: visibilities, flags and weights to the precision
of the new format, (u, v, w), times, antennas, phase centres, frequencies.";

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
    /// Column of visibilities of a Measurement Set [default: CORRECTED_DATA where filled, or DATA]
    #[arg(long, value_name = "NAME")]
    data_column: Option<String>,
    /// Replace an output that exists
    #[arg(long)]
    overwrite: bool,
    /// Nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

impl ConvertArgs {
    pub(crate) fn common(&self) -> CommonArgs {
        CommonArgs {
            quiet: self.quiet,
            ..CommonArgs::default()
        }
    }
}

/// Copies row after row.
pub(crate) fn execute(args: &ConvertArgs) -> Result<(), RunError> {
    let options = ReadOptions {
        data_column: args.data_column.clone(),
    };
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
        bar.advance(n_done, 0);
    }
    writer.finish()?;
    bar.finish();
    if !args.quiet {
        say(&format!("{}: {n_done} rows", args.output.display()));
    }
    Ok(())
}
