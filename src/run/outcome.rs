//! What a run found, as rows of the catalogue.

use std::collections::BTreeMap;

use vis2cat_formats::WriteError;

use super::entries;
use crate::catalogue::{
    self, CatalogueHeader, CataloguePaths, Estimate, Flags, ModeRow, PosteriorRow, PriorRange,
    RunEntry, SourceRow, WeightedSample,
};
use crate::config::{Config, Select};
use crate::coords::{IcrsCentre, RaDec};
use crate::dataset::Dataset;
use crate::detect::{Census, Detected, Detection, Mode, Settings, Status};
use crate::rime::{Source, SpectralIndex};
use crate::simulate::format_utc;
use crate::units::{ARCSEC, MICROJY};

/// What a run found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Provenance.
    pub header: CatalogueHeader,
    /// Sources, brightest first.
    pub sources: Vec<SourceRow>,
    /// Every mode, kept or not.
    pub modes: Vec<ModeRow>,
    /// Samples of the sources, one source after the other.
    pub posterior: Vec<PosteriorRow>,
    /// Options, counts and versions.
    pub run: Vec<RunEntry>,
    /// What to tell the user.
    pub summary: String,
}

impl Outcome {
    pub(super) fn new(
        config: &Config,
        digests: &[String],
        dataset: &Dataset,
        settings: &Settings,
        detection: &Detection,
    ) -> Self {
        let field = dataset.phase_centre();
        let native = RaDec {
            ra_rad: field.ra_rad,
            dec_rad: field.dec_rad,
        };
        let frame = IcrsCentre::new(native, field.frame);
        let mut outcome = Self {
            header: header(config, dataset, frame),
            sources: Vec::new(),
            modes: Vec::new(),
            posterior: Vec::new(),
            run: entries::of_run(config, digests, dataset, settings, detection),
            summary: String::new(),
        };
        // The number of a group is that of its brightest member.
        let mut groups = BTreeMap::new();
        for detected in &detection.sources {
            let source_id = outcome.sources.len() as i64 + 1;
            let group_id = *groups.entry(detected.group).or_insert(source_id);
            let gain = dataset.beam_at(detected.posterior.mean.lm);
            outcome.push(
                config,
                settings,
                frame,
                detected,
                group_id,
                &detection.census,
            );
            if let (Some(gain), Some(row)) = (gain, outcome.sources.last_mut()) {
                row.pb_gain = gain;
            }
        }
        outcome.modes = modes(&outcome.sources, detection, frame);
        outcome.summary = outcome.summarise(dataset, detection);
        outcome
    }

    /// Writes the catalogue and the posterior samples.
    pub(super) fn write(&self, paths: &CataloguePaths, overwrite: bool) -> Result<(), WriteError> {
        let Self {
            header,
            sources,
            modes,
            run,
            posterior,
            ..
        } = self;
        catalogue::write(paths, overwrite, header, sources, modes, run, posterior)
    }

    fn push(
        &mut self,
        config: &Config,
        settings: &Settings,
        frame: IcrsCentre,
        detected: &Detected,
        group_id: i64,
        census: &Census,
    ) {
        let mode = &detected.posterior;
        // Catalogues have no spectrum that indices could be told against.
        let middle = config.spectral_index.map_or(0.0, SpectralIndex::middle);
        let turned = |source: &Source| Source {
            tilt: middle + source.tilt,
            ..frame.turn(source)
        };
        let samples: Vec<WeightedSample> = mode
            .samples
            .iter()
            .map(|s| WeightedSample {
                log_w: s.weight.ln(),
                log_l: s.log_l,
                source: turned(&s.source),
            })
            .collect();
        let profile = config.prior.profile;
        let Some(summary) = catalogue::summarise(&samples, frame.centre, profile) else {
            return;
        };
        let source_id = self.sources.len() as i64 + 1;
        let mode_id = detected.mode as i64;
        let rows = catalogue::posterior_rows(&samples, source_id, mode_id, frame.centre, profile);
        self.sources.push(SourceRow {
            name: catalogue::source_name(&config.acronym, summary.position),
            source_id,
            group_id,
            mode_id,
            flags: flags(settings, detected, summary.flags()),
            posterior: summary,
            snr: detected.snr,
            snr_peak: mode.snr_peak(),
            log_z: Estimate {
                mean: mode.log_z,
                err: mode.log_z_err,
            },
            p_source: census.p_source(mode),
            p_above: settings
                .likely
                .filter(|likely| likely.above_jy.is_some())
                .map_or(f64::NAN, |likely| likely.probability(census, mode)),
            pb_gain: f64::NAN,
            max_dlog_l: detected.max_dlog_l,
            post_row: self.posterior.len() as i64,
            post_n: rows.len() as i64,
        });
        self.posterior.extend(rows);
    }

    fn summarise(&self, dataset: &Dataset, detection: &Detection) -> String {
        let info = dataset.info();
        let n = self.sources.len();
        format!(
            "{}\n{n} source{} among {} modes; {} visibilities, {} likelihood evaluations",
            catalogue::summary_table(&self.sources).trim_end(),
            if n == 1 { "" } else { "s" },
            detection.modes.len(),
            info.n_sample,
            detection.n_eval,
        )
    }
}

fn flags(settings: &Settings, detected: &Detected, mut flags: Flags) -> Flags {
    let mode = &detected.posterior;
    if settings.field.distance_to_edge(mode.mean.lm) < 3.0 * mode.position_sigma_rad {
        flags = flags.with(Flags::AT_BORDER);
    }
    if mode.is_unfinished {
        flags = flags.with(Flags::UNFINISHED);
    }
    if detected.is_conditional {
        flags = flags.with(Flags::CONDITIONAL);
    }
    let flux = &settings.prior.flux;
    let (below, above) = (
        mode.mean.flux_jy - flux.low_jy,
        flux.high_jy - mode.mean.flux_jy,
    );
    if below.min(above) < mode.flux_sigma_jy {
        flags = flags.with(Flags::FLUX_AT_LIMIT);
    }
    let mean_log: f64 = mode
        .samples
        .iter()
        .map(|s| s.weight * s.source.scale_rad.ln())
        .sum();
    let variance: f64 = mode
        .samples
        .iter()
        .map(|s| s.weight * (s.source.scale_rad.ln() - mean_log).powi(2))
        .sum();
    if variance.sqrt() > 0.9 * settings.prior.scale.sigma_log {
        flags = flags.with(Flags::SHAPE_FROM_PRIOR);
    }
    flags
}

fn modes(sources: &[SourceRow], detection: &Detection, frame: IcrsCentre) -> Vec<ModeRow> {
    let row = |(i, mode): (usize, &Mode)| {
        let mean = frame.turn(&mode.mean);
        let mode_id = i as i64;
        let source_id = source_of(i, sources, detection);
        let p_source = match mode.status {
            Status::Kept => sources
                .iter()
                .find(|s| s.mode_id == mode_id)
                .map(|s| s.p_source),
            Status::BelowCut | Status::Unlikely => Some(detection.census.p_source(mode)),
            _ => None,
        };
        ModeRow {
            mode_id,
            tile_id: mode.tile as i64,
            position: RaDec::from_lm(mean.lm, frame.centre),
            position_sigma_rad: mode.position_sigma_rad,
            lm: mean.lm,
            flux_jy: Estimate {
                mean: mean.flux_jy,
                err: mode.flux_sigma_jy,
            },
            snr: mode.best_xy.snr(mean.flux_jy),
            snr_peak: mode.snr_peak(),
            log_z: Estimate {
                mean: mode.log_z,
                err: mode.log_z_err,
            },
            p_source: p_source.unwrap_or(f64::NAN),
            n_samples: mode.n_sample as i64,
            n_eff: mode.n_eff,
            status: mode.status,
            source_id,
        }
    };
    detection.modes.iter().enumerate().map(row).collect()
}

/// The source that a mode is, or that explains it.
fn source_of(mut mode: usize, sources: &[SourceRow], detection: &Detection) -> Option<i64> {
    // What explains a mode may be explained itself, by a stronger one each time.
    while let Some(other) = detection.modes[mode].explained_by {
        mode = other;
    }
    let source = sources.iter().find(|s| s.mode_id == mode as i64);
    source.map(|s| s.source_id)
}

fn header(config: &Config, dataset: &Dataset, frame: IcrsCentre) -> CatalogueHeader {
    let info = dataset.info();
    let prior = &config.prior;
    let half_fov = 0.5 * config.fov.0 / ARCSEC;
    let range = |parameter: &str, unit: &str, low: f64, high: f64, form: String| PriorRange {
        parameter: parameter.into(),
        unit: unit.into(),
        low,
        high,
        form,
    };
    let index = config.spectral_index.filter(|index| index.is_free());
    let index = index.map(|index| {
        let [low, high] = index.ends();
        range("Spectral_index", "", low, high, "uniform".into())
    });
    let mut priors = vec![
        range("L", "arcsec", -half_fov, half_fov, "uniform".into()),
        range("M", "arcsec", -half_fov, half_fov, "uniform".into()),
        range(
            "Total_flux",
            "uJy",
            prior.flux.low.0 / MICROJY,
            prior.flux.high.0 / MICROJY,
            format!("power law, index {}", prior.flux_index),
        ),
        range(
            "Scale_length",
            "arcsec",
            prior.scale.low.0 / ARCSEC,
            prior.scale.high.0 / ARCSEC,
            format!("log-normal, sigma {}", prior.scale_sigma_log),
        ),
        range("abs(E)", "", 0.0, prior.e_max, "VLA-COSMOS".into()),
    ];
    priors.extend(index);
    CatalogueHeader {
        telescope: Some(dataset.observation().telescope.clone()).filter(|name| !name.is_empty()),
        object: Some(dataset.phase_centre().name.clone()).filter(|name| !name.is_empty()),
        date_obs: Some(format_utc(info.first_mjd)),
        mjd_obs: Some(info.first_mjd),
        ref_freq_hz: Some(dataset.ref_freq_hz()),
        phase_centre: frame.centre,
        profile: prior.profile,
        has_beam: config.beam.is_some(),
        has_p_above: config.selection() == Select::Bayes,
        has_spectral_index: config.spectral_index.is_some_and(SpectralIndex::is_free),
        seed: config.seed,
        priors,
        config: config.to_toml().lines().map(str::to_owned).collect(),
    }
}
