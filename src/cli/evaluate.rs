//! `vis2cat evaluate`: a catalogue beside the truth.

mod tables;

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::say;
use crate::catalogue::{read_catalogue, read_source_list};
use crate::evaluate::{Evaluation, evaluate};
use crate::run::RunError;

const EXAMPLES: &str = "\
Examples:
  vis2cat evaluate sources.fits truth.fits
  vis2cat evaluate sources.fits truth.csv --json > evaluation.json
      TRUTH with RA[deg],DEC[deg],Total_flux[uJy] and, optionally, Scale_length[arcsec],E1,E2,SNR.

A row is true if a true source lies within 3 sigma of its position, sqrt(E_RA^2 + E_DEC^2) being
1 sigma, or within 1 arcsec; a source is matched once, the closest pair first. Cuts are moved over
the table MODES after the run: what the run never looked at, because it lies far below the cut it
was given, cannot come back. Posterior samples are used if they lie beside the catalogue.

Intervals of completeness and purity in JSON are of 68% (Wilson's score); what is not defined is
null there, and - in the tables.";

/// Flags of `vis2cat evaluate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct EvaluateArgs {
    /// Catalogue of vis2cat, or a FITS, VOTable or CSV table with RA, DEC and Total_flux
    #[arg(value_name = "CATALOGUE")]
    catalogue: PathBuf,
    /// True sources: as `simulate --truth` writes them, or a FITS, VOTable or CSV table with RA, DEC and
    /// Total_flux
    #[arg(value_name = "TRUTH")]
    truth: PathBuf,
    /// As JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    catalogue: String,
    truth: String,
    #[serde(flatten)]
    evaluation: Evaluation,
}

/// Prints the evaluation.
pub(crate) fn execute(args: &EvaluateArgs) -> Result<(), RunError> {
    let found = read_catalogue(&args.catalogue)?;
    let truth = read_source_list(&args.truth)?;
    let report = Report {
        catalogue: args.catalogue.display().to_string(),
        truth: args.truth.display().to_string(),
        evaluation: evaluate(&found, &truth),
    };
    say(&if args.json {
        serde_json::to_string_pretty(&report).unwrap_or_default()
    } else {
        let title = format!("{} against {}", report.catalogue, report.truth);
        format!("{title}\n{}", tables::text(&report.evaluation))
    });
    Ok(())
}
