//! A mode of the one-source posterior, and what became of it.

use crate::coords::Lm;
use crate::likelihood::Xy;
use crate::rime::Source;
use crate::rime::shape::Ellipticity;

/// A weighted posterior sample of a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeSample {
    /// The source.
    pub source: Source,
    /// ln L relative to no source.
    pub log_l: f64,
    /// Posterior weight; those of a mode sum to one.
    pub weight: f64,
}

/// Why a mode is a source, or why not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// It is a source.
    Kept,
    /// Another mode of the same source has the higher local evidence, or was found later, with
    /// more of the others removed.
    F1Duplicate,
    /// Below the signal-to-noise or flux cut.
    BelowCut,
    /// It falls below the cut once brighter sources are subtracted: a sidelobe.
    ExplainedByBrighter,
    /// Once a close neighbour is sampled without it, nothing above the cut is left of it.
    PartOfNeighbour,
    /// It is above the cut, but not likely enough to be a source, or one as bright as wanted.
    Unlikely,
    /// Even its best model is no better than no source.
    WorseThanNoSource,
}

impl Status {
    /// Every status.
    pub const ALL: [Self; 7] = [
        Self::Kept,
        Self::F1Duplicate,
        Self::BelowCut,
        Self::ExplainedByBrighter,
        Self::PartOfNeighbour,
        Self::Unlikely,
        Self::WorseThanNoSource,
    ];

    /// The status that is called `word` in the catalogue.
    pub fn parse(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.as_str() == word)
    }

    /// The word in the catalogue.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::F1Duplicate => "f1_duplicate",
            Self::BelowCut => "below_cut",
            Self::ExplainedByBrighter => "explained_by_brighter",
            Self::PartOfNeighbour => "part_of_neighbour",
            Self::Unlikely => "unlikely",
            Self::WorseThanNoSource => "worse_than_no_source",
        }
    }
}

/// A mode that a sampler returned.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Tile that it was found in.
    pub tile: usize,
    /// Posterior mean.
    pub mean: Source,
    /// The sample of highest likelihood.
    pub best: Source,
    /// ln L of that sample.
    pub best_log_l: f64,
    /// Posterior mean of ln L where it was sampled alone, as `log_z` is of.
    pub mean_log_l: f64,
    /// Standard deviation of the position, the larger of l and m [rad].
    pub position_sigma_rad: f64,
    /// Standard deviation of the flux density [Jy].
    pub flux_sigma_jy: f64,
    /// Local evidence against no source, with the position prior of the whole field.
    pub log_z: f64,
    /// Its error.
    pub log_z_err: f64,
    /// X and Y of the best sample.
    pub best_xy: Xy,
    /// Number of samples and their effective number.
    pub n_sample: usize,
    /// Effective number of samples.
    pub n_eff: f64,
    /// Posterior samples; empty where the mode cannot become a source.
    pub samples: Vec<ModeSample>,
    /// Its sampling was stopped before it had the whole evidence.
    pub is_unfinished: bool,
    /// What became of it.
    pub status: Status,
    /// The mode that is kept in its place, or that explains it: an index into the same list.
    pub explained_by: Option<usize>,
}

impl Mode {
    /// The mode that these samples make, which must not be empty.
    pub(super) fn new(tile: usize, samples: Vec<ModeSample>, log_z: f64, log_z_err: f64) -> Self {
        let mean_of = |f: fn(&Source) -> f64| -> f64 {
            samples.iter().map(|s| s.weight * f(&s.source)).sum()
        };
        let sigma_of = |f: fn(&Source) -> f64, mean: f64| -> f64 {
            samples
                .iter()
                .map(|s| s.weight * (f(&s.source) - mean).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let mean = Source {
            lm: Lm {
                l: mean_of(|s| s.lm.l),
                m: mean_of(|s| s.lm.m),
            },
            flux_jy: mean_of(|s| s.flux_jy),
            scale_rad: mean_of(|s| s.scale_rad),
            e: Ellipticity {
                e1: mean_of(|s| s.e.e1),
                e2: mean_of(|s| s.e.e2),
            },
            tilt: mean_of(|s| s.tilt),
        };
        let best = samples.iter().max_by(|a, b| a.log_l.total_cmp(&b.log_l));
        let (best, best_log_l) = best.map_or((mean, f64::NEG_INFINITY), |s| (s.source, s.log_l));
        let position_sigma_rad =
            sigma_of(|s| s.lm.l, mean.lm.l).max(sigma_of(|s| s.lm.m, mean.lm.m));
        Self {
            tile,
            mean,
            best,
            best_log_l,
            mean_log_l: samples.iter().map(|s| s.weight * s.log_l).sum(),
            position_sigma_rad,
            flux_sigma_jy: sigma_of(|s| s.flux_jy, mean.flux_jy),
            log_z,
            log_z_err,
            best_xy: Xy::default(),
            n_sample: samples.len(),
            n_eff: 1.0 / samples.iter().map(|s| s.weight * s.weight).sum::<f64>(),
            samples,
            is_unfinished: false,
            status: Status::Kept,
            explained_by: None,
        }
    }

    /// Matched-filter signal-to-noise ratio of the best sample.
    pub fn snr_peak(&self) -> f64 {
        self.best_xy.snr_peak()
    }

    /// The mode without its samples, where they will not be needed.
    pub(super) fn without_samples(mut self) -> Self {
        self.samples = Vec::new();
        self
    }
}
