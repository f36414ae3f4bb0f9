//! `vis2cat simulate`: an observation with known sources.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vis2cat_formats::fits::refuse_existing;
use vis2cat_formats::{Corr, create};

use super::{CommonArgs, progress::Bar, say};
use crate::catalogue::{CatalogueSource, read_sources, write_truth};
use crate::config::PriorConfig;
use crate::coords::RaDec;
use crate::detect::{Observer, field_of_view};
use crate::rime::{InstrumentTerms, Source, SpectralIndex};
use crate::run::RunError;
use crate::simulate::{Array, SimulateConfig, SimulationSummary, parse_utc, simulate};
use crate::units::{Angle, Duration, Flux, Frequency, Range};

const EXAMPLES: &str = "\
Examples:
  vis2cat simulate field.uvfits --array ska1-mid --sources 20 --truth truth.fits
  vis2cat simulate field.uvfits --array meerkat --catalogue truth.fits --tint 8s --hours 1
  vis2cat simulate field.uvfits --array my_array.csv --sources 5 --fov 10arcmin --no-noise
  vis2cat simulate wide.ms --array meerkat --sources 20 --fov 1.4deg --channels 64 \
      --bandwidth 856MHz --freq 1284MHz --tint 8s --hours 1 --smearing --beam meerkat

Without --smearing samples are points in time and frequency.";

/// Flags of `vis2cat simulate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
#[command(group(ArgGroup::new("sky").required(true).args(["sources", "catalogue"])))]
pub(crate) struct SimulateArgs {
    /// File to write: a Measurement Set if it ends in .ms, UVH5 if in .uvh5, UVFITS otherwise
    #[arg(value_name = "OUT.uvfits")]
    output: PathBuf,
    /// Built-in array (meerkat, ska1-mid, vla-a, ...) or a CSV file with name,x_m,y_m,z_m
    #[arg(long, value_name = "NAME|FILE.csv")]
    array: String,
    /// Draw this many sources from the prior
    #[arg(long, value_name = "N")]
    sources: Option<usize>,
    /// Take the sources from a FITS, VOTable or CSV table with RA, DEC, Total_flux (as --truth writes it)
    #[arg(long, value_name = "FILE")]
    catalogue: Option<PathBuf>,
    /// Range of flux densities to draw from
    #[arg(long, value_name = "LOW:HIGH", default_value = "10uJy:200uJy")]
    flux: Range<Flux>,
    /// Side of the square to draw positions from
    #[arg(long, value_name = "ANGLE", default_value = "1deg")]
    fov: Angle,
    /// Right ascension of the phase centre (ICRS), as 53.1deg or 3h32m24s
    #[arg(long, value_name = "ANGLE", default_value = "53.1deg")]
    ra: Angle,
    /// Declination of the phase centre (ICRS), as -30deg or -30d15m0s
    #[arg(
        long,
        value_name = "ANGLE",
        default_value = "-30deg",
        allow_hyphen_values = true
    )]
    dec: Angle,
    /// Length of the observation [h]
    #[arg(long, value_name = "HOURS", default_value_t = 8.0)]
    hours: f64,
    /// Start (UTC), as 2020-01-01T12:00:00 [default: centred on transit on 2020-01-01]
    #[arg(long, value_name = "TIME")]
    start: Option<String>,
    /// UT1-UTC, for times outside the built-in table
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    ut1_utc: Option<Duration>,
    /// Integration time of a sample
    #[arg(long, value_name = "TIME", default_value = "60s")]
    tint: Duration,
    /// Centre of the band
    #[arg(long, value_name = "FREQ", default_value = "1.4GHz")]
    freq: Frequency,
    /// Width of the band
    #[arg(long, value_name = "FREQ", default_value = "240MHz")]
    bandwidth: Frequency,
    /// Channels
    #[arg(long, value_name = "N", default_value_t = 1)]
    channels: usize,
    /// What each sample holds
    #[arg(long, value_enum, default_value_t = Hands::XxYy)]
    hands: Hands,
    /// System equivalent flux density of every dish [default: the array's own; none is
    /// published for atca-*, and files may lack it]
    #[arg(long, value_name = "FLUX", conflicts_with = "no_noise")]
    sefd: Option<Flux>,
    /// No noise; the weights stay those of the noise
    #[arg(long)]
    no_noise: bool,
    #[command(flatten)]
    instrument: super::instrument::InstrumentArgs,
    /// Seed of the population and of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Table of the true sources to write
    #[arg(long, value_name = "FILE.fits")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) common: CommonArgs,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Hands {
    XxYy,
    RrLl,
    Xx,
    Rr,
    I,
}

impl Hands {
    fn corrs(self) -> Vec<Corr> {
        match self {
            Self::XxYy => vec![Corr::Xx, Corr::Yy],
            Self::RrLl => vec![Corr::Rr, Corr::Ll],
            Self::Xx => vec![Corr::Xx],
            Self::Rr => vec![Corr::Rr],
            Self::I => vec![Corr::I],
        }
    }
}

impl SimulateArgs {
    fn centre(&self) -> RaDec {
        RaDec {
            ra_rad: self.ra.0,
            dec_rad: self.dec.0,
        }
    }

    fn config(&self, instrument: InstrumentTerms) -> Result<SimulateConfig, RunError> {
        Ok(SimulateConfig {
            array: Array::find(&self.array)?,
            centre: self.centre(),
            start_mjd: self.start.as_deref().map(parse_utc).transpose()?,
            duration_s: self.hours * 3600.0,
            interval_s: self.tint.0,
            freq_hz: self.freq.0,
            bandwidth_hz: self.bandwidth.0,
            n_chan: self.channels,
            corrs: self.hands.corrs(),
            sefd_jy: self.sefd.map(|sefd| sefd.0),
            noise: !self.no_noise,
            instrument,
            seed: self.seed,
            ut1_utc_s: self.ut1_utc.map(|t| t.0),
            ..SimulateConfig::default()
        })
    }

    /// The sources, and how they are seen.
    fn sky(&self) -> Result<(Vec<Source>, InstrumentTerms), RunError> {
        let terms = self.instrument.terms();
        match &self.catalogue {
            Some(path) => Ok(self.listed(&read_sources(path)?, terms)),
            None => Ok((self.drawn(), terms)),
        }
    }

    /// Those of a table; its spectral indices are used if it has any.
    fn listed(
        &self,
        list: &[CatalogueSource],
        terms: InstrumentTerms,
    ) -> (Vec<Source>, InstrumentTerms) {
        let has_index = list.iter().any(|s| s.spectral_index.is_finite());
        let flat = has_index.then_some(SpectralIndex::FLAT);
        let spectral_index = terms.spectral_index.or(flat);
        let middle = spectral_index.map_or(0.0, SpectralIndex::middle);
        let centre = self.centre();
        let source = |s: &CatalogueSource| Source {
            lm: s.position.to_lm(centre),
            flux_jy: s.flux_jy,
            scale_rad: s.scale_rad,
            e: s.e,
            tilt: if s.spectral_index.is_finite() {
                s.spectral_index - middle
            } else {
                0.0
            },
        };
        let terms = InstrumentTerms {
            spectral_index,
            ..terms
        };
        (list.iter().map(source).collect(), terms)
    }

    /// Those drawn from the prior.
    fn drawn(&self) -> Vec<Source> {
        let prior = PriorConfig {
            flux: self.flux,
            ..PriorConfig::default()
        }
        .source_prior(self.instrument.spectral_index);
        let field = field_of_view(self.fov.0);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        // A stream of its own: the noise has the others.
        rng.set_stream(u64::MAX);
        let draw = |_| {
            let u: Vec<f64> = (0..prior.n_dim()).map(|_| rng.random()).collect();
            prior.source(&field, &u)
        };
        (0..self.sources.unwrap_or(0)).map(draw).collect()
    }
}

/// Simulates and says what came out.
pub(crate) fn execute(args: &SimulateArgs) -> Result<(), RunError> {
    let (sources, instrument) = args.sky()?;
    let config = args.config(instrument)?;
    if let Some(path) = &args.truth {
        refuse_existing(path, args.common.overwrite)?;
    }
    let observation = crate::simulate::observation(&config)?;
    let mut writer = create(&args.output, &observation, args.common.overwrite)?;
    let mut bar = Bar::new(args.common.quiet);
    bar.stage("simulating", observation.n_row);
    let summary = simulate(&config, &sources, writer.as_mut(), &mut |done, _| {
        bar.advance(done, 0);
    })?;
    bar.finish();
    if let Some(path) = &args.truth {
        let truth = truth(&config, &sources, &summary.snr_s);
        write_truth(path, args.common.overwrite, Some(args.freq.0), &truth)?;
    }
    writer.finish()?;
    if !args.common.quiet {
        say(&describe(args, &summary, sources.len()));
    }
    Ok(())
}

fn truth(config: &SimulateConfig, sources: &[Source], snr_s: &[f64]) -> Vec<CatalogueSource> {
    let index = config.instrument.spectral_index;
    let index = index.map_or(f64::NAN, SpectralIndex::middle);
    let row = |(source, snr): (&Source, &f64)| CatalogueSource {
        position: RaDec::from_lm(source.lm, config.centre),
        flux_jy: source.flux_jy,
        scale_rad: source.scale_rad,
        e: source.e,
        spectral_index: index + source.tilt,
        snr: *snr,
    };
    sources.iter().zip(snr_s).map(row).collect()
}

fn describe(args: &SimulateArgs, summary: &SimulationSummary, n_source: usize) -> String {
    let (faint, bright) = summary
        .snr_s
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(low, high), snr| {
            (low.min(*snr), high.max(*snr))
        });
    let mut text = format!(
        "{}: {} rows, {} times, {} visibilities, longest baseline {:.0} wavelengths\n\
         noise {:.4} to {:.4} mJy a visibility",
        args.output.display(),
        summary.n_row,
        summary.n_time,
        summary.n_vis,
        summary.uv_max_lambda,
        summary.sigma_jy[0] * 1e3,
        summary.sigma_jy[1] * 1e3,
    );
    if n_source > 0 {
        let _ = write!(
            text,
            "; {n_source} sources with SNR {faint:.1} to {bright:.1}"
        );
    }
    for warning in &summary.warnings {
        let _ = write!(text, "\nwarning: {warning}");
    }
    text
}
