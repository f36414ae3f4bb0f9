//! `vis2cat report`: a catalogue as a page to look at.

use std::path::PathBuf;

use clap::Args;

use super::progress::Bar;
use super::select::ReadArgs;
use super::{CommonArgs, say};
use crate::chains;
use crate::detect::Observer;
use crate::report::{CheckOptions, Contents, Report, check, write_pngs};
use crate::run::RunError;
use crate::timing;
use vis2cat_formats::fits::refuse_existing;

const EXAMPLES: &str = "\
Examples:
  vis2cat report sources.fits -o report.html
      The field, sources, their posteriors and how the run went, in one file.
  vis2cat report sources.fits --truth truth.fits -o report.html
      The same beside what was simulated.
  vis2cat report sources.fits --data day1.ms day2.uvfits -o report.html --png figures
      With the visibilities beside what the posterior predicts, and every figure as a PNG file.

The page is complete in itself: it can be mailed, and opened without a network. Posterior samples are
used if they lie beside the catalogue, as sources.posterior.fits. Visibilities are read as they were in the
run, by the options in the table RUN.";

/// Flags of `vis2cat report`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ReportArgs {
    /// Catalogue of vis2cat, or a FITS, VOTable or CSV table with RA, DEC and Total_flux
    #[arg(value_name = "CATALOGUE")]
    catalogue: PathBuf,
    /// The page to write
    #[arg(long, short, value_name = "OUT.html")]
    output: PathBuf,
    /// True sources, as for `vis2cat evaluate`
    #[arg(long, value_name = "TRUTH")]
    truth: Option<PathBuf>,
    /// Visibilities, to compare with what the posterior predicts
    #[arg(long, value_name = "FILE", num_args = 1..)]
    data: Vec<PathBuf>,
    /// Wall times of the run, as its option --timings wrote them
    #[arg(long, value_name = "FILE")]
    timings: Option<PathBuf>,
    /// Folder for every figure as a PNG file
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
    /// Corner plots of the N sources with the highest signal-to-noise ratio
    #[arg(long, value_name = "N", default_value_t = 200)]
    corners: usize,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    common: CommonArgs,
}

impl ReportArgs {
    pub(crate) fn data(&self) -> &[PathBuf] {
        &self.data
    }

    pub(crate) fn common(&self) -> CommonArgs {
        self.common
    }
}

/// Writes the page, and the figures where they are asked for.
pub(crate) fn execute(args: &ReportArgs) -> Result<(), RunError> {
    let overwrite = args.common.overwrite;
    refuse_existing(&args.output, overwrite)?;
    if let Some(folder) = &args.png {
        chains::refuse_existing(folder, overwrite)?;
    }
    let mut contents = Contents::read(&args.catalogue, args.truth.as_deref())?;
    if let Some(path) = &args.timings {
        contents = contents.with_timings(timing::read(path)?);
    }
    if !args.data.is_empty() {
        let options = CheckOptions {
            inputs: args.data.clone(),
            read: args.read.options(),
        };
        let check = with_bar(args.common.quiet, |progress| {
            check(&contents, &options, progress)
        })?;
        contents = contents.with_check(check);
    }
    let report = Report::new(contents, args.corners);
    if let Some(folder) = &args.png {
        write_pngs(folder, overwrite, &report.figures())?;
    }
    report.write_html(&args.output, overwrite)?;
    if !args.common.quiet {
        say(&summary(args, report.figures().len()));
    }
    Ok(())
}

/// Runs something with a progress bar: it tells the stage, and how much of it is done.
fn with_bar<T>(quiet: bool, run: impl FnOnce(&mut dyn FnMut(&'static str, u64, u64)) -> T) -> T {
    let mut bar = Bar::new(quiet);
    let mut known = ("", 0);
    let done = run(&mut |stage, done, all| {
        if known != (stage, all) {
            known = (stage, all);
            bar.stage(stage, all);
        }
        bar.advance(done, 0);
    });
    bar.finish();
    done
}

fn summary(args: &ReportArgs, n_figure: usize) -> String {
    let page = args.output.display();
    match &args.png {
        Some(folder) => format!("{page}: {n_figure} figures, also in {}", folder.display()),
        None => format!("{page}: {n_figure} figures"),
    }
}
