//! `vis2cat info`: what is in a visibility file.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vis2cat_formats::{Observation, Window};

use super::{CommonArgs, progress::Bar, say, select::ReadArgs};
use crate::dataset::Overview;
use crate::detect::Observer;
use crate::run::RunError;
use crate::units::DEG;

/// Flags of `vis2cat info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Visibility file or Measurement Set
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    read: ReadArgs,
    /// As JSON
    #[arg(long)]
    json: bool,
    /// No progress bar
    #[arg(long, short)]
    quiet: bool,
}

impl InfoArgs {
    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    pub(crate) fn common(&self) -> CommonArgs {
        CommonArgs {
            quiet: self.quiet,
            ..CommonArgs::default()
        }
    }
}

/// Prints the overview.
pub(crate) fn execute(args: &InfoArgs) -> Result<(), RunError> {
    let mut bar = Bar::new(args.quiet);
    bar.stage("reading", 0);
    let mut n_row_known = 0;
    let options = args.read.options();
    let overview = Overview::read(&args.file, &options, &mut |done, n_row| {
        if n_row_known != n_row {
            n_row_known = n_row;
            bar.stage("reading", n_row);
        }
        bar.advance(done, 0);
    })?;
    bar.finish();
    let report = Report {
        file: args.file.display().to_string(),
        overview,
    };
    say(&if args.json {
        json(&report)
    } else {
        text(&report)
    });
    Ok(())
}

#[derive(Serialize)]
struct Report {
    file: String,
    #[serde(flatten)]
    overview: Overview,
}

fn json(report: &Report) -> String {
    serde_json::to_string_pretty(report).unwrap_or_default()
}

fn text(report: &Report) -> String {
    let Report { file, overview } = report;
    let observation = &overview.observation;
    let mut text = format!("{file}\n");
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<14}{value}");
    };
    line("telescope", observation.telescope.clone());
    line("date", observation.date_obs.clone());
    line(
        "antennas",
        format!(
            "{} ({} used)",
            observation.antennas.len(),
            overview.n_antenna_used
        ),
    );
    for (i, field) in observation.fields.iter().enumerate() {
        let (ra, dec) = (field.ra_rad / DEG, field.dec_rad / DEG);
        let place = if field.drifts {
            "not phased (drift scan)".to_owned()
        } else {
            format!("RA {ra:.6} deg, DEC {dec:.6} deg, {:?}", field.frame)
        };
        line("field", format!("{i} {}  {place}", field.name));
    }
    let rows = overview.n_row;
    line(
        "rows",
        format!("{rows} ({} autocorrelations)", overview.n_row_auto),
    );
    line("baselines", overview.n_baseline.to_string());
    line("times", times(overview));
    for window in observation.windows() {
        line("spw", frequencies(observation, &window));
    }
    let corrs: Vec<_> = observation
        .corrs
        .iter()
        .map(|c| format!("{c:?}").to_uppercase())
        .collect();
    line("correlations", corrs.join(" "));
    if let Some(ms) = &observation.ms {
        let (data, weights) = (&ms.data_column, &ms.weight_column);
        line("columns", format!("{data}, weights of {weights}"));
    }
    line("longest", format!("{:.1} m", overview.max_baseline_m));
    let percent = 100.0 * overview.n_flagged as f64 / overview.n_value.max(1) as f64;
    line(
        "flagged",
        format!("{percent:.2}% of {} values", overview.n_value),
    );
    line(
        "noise",
        overview.noise.map_or(
            "not measured: no Stokes I that is not flagged".into(),
            |n| n.to_string(),
        ),
    );
    for warning in &observation.warnings {
        line("warning", warning.clone());
    }
    text.truncate(text.trim_end().len());
    text
}

fn times(overview: &Overview) -> String {
    let hours = 24.0 * (overview.last_mjd - overview.first_mjd);
    format!(
        "{} over {hours:.3} h from MJD {:.6}, {} s each",
        overview.n_time, overview.first_mjd, overview.interval_s
    )
}

fn frequencies(observation: &Observation, window: &Window) -> String {
    let setup = &observation.freq_setups[window.setup];
    let freq_hz_f = &setup.freq_hz_f[window.chans.clone()];
    let mhz = |hz: Option<&f64>| hz.map_or(f64::NAN, |hz| hz / 1e6);
    format!(
        "{} {} channels, {:.4} to {:.4} MHz, {:.4} MHz wide",
        window.number,
        freq_hz_f.len(),
        mhz(freq_hz_f.first()),
        mhz(freq_hz_f.last()),
        mhz(setup.chan_width_hz_f.get(window.chans.start))
    )
}
