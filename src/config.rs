//! What the flags and the configuration file mean: typed, checked, with defaults.

use serde::{Deserialize, Serialize};

use crate::prior::{EllipticityPrior, FluxPrior, ScalePrior, ScaleRelation, SourcePrior};
use crate::rime::shape::Profile;
use crate::rime::{Beam, InstrumentTerms, SpectralIndex};
use crate::units::{ARCSEC, Angle, Flux, Memory, Range, UnitError};

/// Live points of a tile, and of the paper's single global run.
const N_LIVE_TILE: usize = 120;
const N_LIVE_GLOBAL: usize = 8000;

/// Cuts in signal-to-noise ratio: of sources, and of what probabilities then select from.
const SNR_CUT: f64 = 6.0;
const SNR_CUT_BY_PROBABILITY: f64 = 5.0;

/// A configuration that makes no sense.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The configuration file cannot be read.
    #[error("cannot read the configuration {path}")]
    Io {
        /// File.
        path: std::path::PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The configuration file is not what we expect.
    #[error("{path}: {what}")]
    Toml {
        /// File.
        path: std::path::PathBuf,
        /// Line, key and what is wrong.
        what: String,
    },
    /// A value is out of range.
    #[error("{key} = {value}: {what}")]
    Value {
        /// Option.
        key: &'static str,
        /// Its value.
        value: String,
        /// What it must be.
        what: &'static str,
    },
}

/// Everything that decides the result of a run, but for the input and the build.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Config {
    /// Side of the square field of view about the phase centre.
    pub fov: Angle,
    /// Name or number (from 0) of the field, where the file holds several.
    pub field: Option<String>,
    /// Numbers of the spectral windows that are used, as `vis2cat info` lists them; none = all.
    pub spw: Vec<i64>,
    /// Column of visibilities of a Measurement Set; none = `CORRECTED_DATA` where it is filled,
    /// `DATA` otherwise.
    pub data_column: Option<String>,
    /// What makes a mode a source; none = the flux cut where there is one, the signal-to-noise cut otherwise.
    pub select: Option<Select>,
    /// Lowest matched-filter signal-to-noise ratio of what may be a source; none = 6, or 5 where probabilities
    /// select.
    pub snr_cut: Option<f64>,
    /// Lowest flux density of a source.
    pub flux_cut: Option<Flux>,
    /// A source must be more probable than this, where probabilities select.
    pub p_cut: f64,
    /// Radius within which modes are one source; none = the modes' own uncertainty.
    pub merge_radius: Option<Angle>,
    /// How the likelihood is computed.
    pub engine: Engine,
    /// Which sampler explores a tile.
    pub sampler: SamplerKind,
    /// Live points of each tile; none = 120, or 8000 with `tiles = 1`.
    pub n_live: Option<usize>,
    /// Sampling efficiency of `multinest`: ellipsoids of few live points are enlarged in volume by 1 over this.
    pub efficiency: f64,
    /// Evidence (in ln Z) that may be left in the live points at the end.
    pub tolerance: f64,
    /// How the field is divided.
    pub tiles: Tiling,
    /// Leave out tiles that cannot hold a source.
    pub screening: bool,
    /// Where the noise level comes from.
    pub noise: NoiseSource,
    /// Model time and bandwidth smearing.
    pub smearing: bool,
    /// Primary beam; none = flux densities are apparent ones.
    pub beam: Option<Beam>,
    /// Spectral index of all sources, or the range of it where it is free; none = the same flux density
    /// in all channels.
    pub spectral_index: Option<SpectralIndex>,
    /// Re-sample each source with all others removed, until nothing new is found.
    pub refine: bool,
    /// Seed of every random stream.
    pub seed: u64,
    /// Memory for visibilities; more than that is streamed from the file in every pass.
    pub memory: Memory,
    /// Acronym in front of source names.
    pub acronym: String,
    /// Prior of one source.
    pub prior: PriorConfig,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            fov: Angle(crate::units::DEG),
            field: None,
            spw: Vec::new(),
            data_column: None,
            select: None,
            snr_cut: None,
            flux_cut: None,
            p_cut: 0.5,
            merge_radius: None,
            engine: Engine::Auto,
            sampler: SamplerKind::Multinest,
            n_live: None,
            efficiency: 0.8,
            tolerance: 0.5,
            tiles: Tiling::Auto,
            screening: true,
            noise: NoiseSource::Auto,
            smearing: false,
            beam: None,
            spectral_index: None,
            refine: true,
            seed: 1,
            memory: Memory(256e6),
            acronym: "V2C".into(),
            prior: PriorConfig::default(),
        }
    }
}

/// What makes a mode a source (Malyali et al. 2018, section 3.3, but for the last).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Select {
    /// Its matched-filter signal-to-noise ratio is above the cut.
    Snr,
    /// Its mean flux density is above the cut.
    Flux,
    /// It is probably a source brighter than the flux cut: model selection with priors above and below it.
    Bayes,
    /// It is probably a source.
    PSource,
}

/// Likelihood engine.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Engine {
    /// Facets where they pay, every visibility otherwise.
    #[default]
    Auto,
    /// Every visibility for every point.
    Exact,
    /// Facets: the visibilities as a small patch of sky sees them, on a few grids.
    Facet,
}

/// Sampler.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerKind {
    /// Multimodal nested sampling in ellipsoids (Feroz, Hobson & Bridges 2009).
    #[default]
    Multinest,
    /// Nested slice sampling: ten times the evaluations, no assumption about shapes.
    Slice,
}

/// How the field is divided.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tiling {
    /// By the resolution of the data and the number of live points.
    #[default]
    Auto,
    /// At least this many tiles, in a square; 1 is the paper's global run.
    Count(usize),
    /// Tiles of at most this side.
    Size(Angle),
}

/// Where the noise level comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum NoiseSource {
    /// Measured in the data; the file's own scale where it agrees within 20%.
    #[default]
    Auto,
    /// The file's weights are 1/σ² in Jy⁻².
    Weights,
    /// The file's weights are relative, the scale is measured in the data.
    Data,
    /// From the system equivalent flux density [Jy] of a dish, bandwidth and integration time.
    Sefd(Flux),
}

impl std::str::FromStr for NoiseSource {
    type Err = NoiseSourceError;
    fn from_str(text: &str) -> Result<Self, NoiseSourceError> {
        match text {
            "auto" => Ok(Self::Auto),
            "weights" => Ok(Self::Weights),
            "data" => Ok(Self::Data),
            _ => match text.strip_prefix("sefd=") {
                Some(sefd) => Ok(Self::Sefd(sefd.parse()?)),
                None => Err(NoiseSourceError::Unknown(text.into())),
            },
        }
    }
}

/// A text that names no noise source.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoiseSourceError {
    /// Neither of the words.
    #[error("'{0}' is no noise source; use auto, weights, data or sefd=400Jy")]
    Unknown(String),
    /// The SEFD is no flux density.
    #[error(transparent)]
    Sefd(#[from] UnitError),
}

impl std::fmt::Display for NoiseSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Weights => f.write_str("weights"),
            Self::Data => f.write_str("data"),
            Self::Sefd(sefd) => write!(f, "sefd={}Jy", sefd.0),
        }
    }
}

impl Serialize for NoiseSource {
    fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for NoiseSource {
    fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        String::deserialize(d)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}

/// Constants of the prior (method section 2).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct PriorConfig {
    /// Range of flux densities.
    pub flux: Range<Flux>,
    /// Exponent of the power law in flux density.
    pub flux_index: f64,
    /// Source shape.
    pub profile: Profile,
    /// Does the median scale-length follow the flux density?
    pub scale_relation: ScaleRelation,
    /// Mean of ln(α/arcsec) at 1 µJy of the flux-dependent relation.
    pub scale_intercept: f64,
    /// Slope of that mean with ln(S/µJy).
    pub scale_slope: f64,
    /// Mean of ln(α/arcsec) of the paper's flux-independent prior.
    pub scale_mean_log: f64,
    /// Standard deviation of ln α.
    pub scale_sigma_log: f64,
    /// Range of scale-lengths.
    pub scale: Range<Angle>,
    /// Largest |e|.
    pub e_max: f64,
    /// Circularity scale e0.
    pub e_0: f64,
    /// Fall-off scale a.
    pub e_a: f64,
}

impl Default for PriorConfig {
    fn default() -> Self {
        Self {
            flux: Range {
                low: Flux(10e-6),
                high: Flux(200e-6),
            },
            flux_index: -1.34,
            profile: Profile::Exponential,
            scale_relation: ScaleRelation::FluxDependent,
            scale_intercept: -0.93,
            scale_slope: 0.33,
            scale_mean_log: 0.266,
            scale_sigma_log: 0.3136,
            scale: Range {
                low: Angle(0.1 * ARCSEC),
                high: Angle(10.0 * ARCSEC),
            },
            e_max: 0.804,
            e_0: 0.0732,
            e_a: 0.2298,
        }
    }
}

impl PriorConfig {
    /// The prior that these constants describe.
    ///
    /// `spectral_index` is what is known of spectral indices.
    pub fn source_prior(&self, spectral_index: Option<SpectralIndex>) -> SourcePrior {
        let (intercept, slope) = match self.scale_relation {
            ScaleRelation::FluxDependent => (self.scale_intercept, self.scale_slope),
            ScaleRelation::Paper => (self.scale_mean_log, 0.0),
        };
        SourcePrior {
            flux: FluxPrior {
                low_jy: self.flux.low.0,
                high_jy: self.flux.high.0,
                index: self.flux_index,
            },
            scale: ScalePrior {
                low_rad: self.scale.low.0,
                high_rad: self.scale.high.0,
                sigma_log: self.scale_sigma_log,
                intercept,
                slope,
            },
            ellipticity: EllipticityPrior::new(self.e_max, self.e_0, self.e_a),
            tilt: spectral_index
                .filter(|index| index.is_free())
                .map(SpectralIndex::half_width),
        }
    }

    fn check(&self) -> Result<(), ConfigError> {
        require(
            "prior.flux",
            self.flux,
            self.flux.low.0 > 0.0,
            "must be above zero",
        )?;
        require(
            "prior.scale",
            self.scale,
            self.scale.low.0 > 0.0,
            "must be above zero",
        )?;
        require(
            "prior.flux-index",
            self.flux_index,
            self.flux_index.is_finite(),
            "must be finite",
        )?;
        let sigma = self.scale_sigma_log;
        require(
            "prior.scale-sigma-log",
            sigma,
            sigma > 0.0 && sigma < 10.0,
            "must lie in (0, 10)",
        )?;
        require(
            "prior.e-max",
            self.e_max,
            self.e_max > 0.0 && self.e_max < 1.0,
            "must lie in (0, 1)",
        )?;
        require("prior.e-0", self.e_0, self.e_0 > 0.0, "must be above zero")?;
        require("prior.e-a", self.e_a, self.e_a > 0.0, "must be above zero")
    }
}

fn require(
    key: &'static str,
    value: impl std::fmt::Display,
    holds: bool,
    what: &'static str,
) -> Result<(), ConfigError> {
    if holds {
        Ok(())
    } else {
        Err(ConfigError::Value {
            key,
            value: value.to_string(),
            what,
        })
    }
}

impl Config {
    /// Reads a TOML file.
    ///
    /// # Errors
    /// The file cannot be read, or a key or value in it is not known.
    pub fn from_file(path: &std::path::Path) -> Result<Self, ConfigError> {
        let text = std::fs::read_to_string(path).map_err(|source| ConfigError::Io {
            path: path.into(),
            source,
        })?;
        toml::from_str(&text).map_err(|e| ConfigError::Toml {
            path: path.into(),
            what: e.to_string(),
        })
    }

    /// Checks that every value makes sense.
    ///
    /// # Errors
    /// The first that does not.
    pub fn check(&self) -> Result<(), ConfigError> {
        let fov = self.fov.0;
        require(
            "fov",
            self.fov,
            fov > 0.0 && fov <= 1.0,
            "must lie between 0 and 57 deg",
        )?;
        let snr_cut = self.lowest_snr();
        require("snr-cut", snr_cut, snr_cut > 0.0, "must be above zero")?;
        self.check_selection()?;
        let efficiency = self.efficiency;
        require(
            "efficiency",
            efficiency,
            efficiency > 0.0 && efficiency <= 1.0,
            "must lie in (0, 1]",
        )?;
        require(
            "tolerance",
            self.tolerance,
            self.tolerance > 0.0,
            "must be above zero",
        )?;
        require(
            "memory",
            self.memory,
            self.memory.0 >= 16e6,
            "must be at least 16MB",
        )?;
        let n_live = self.n_live.unwrap_or(N_LIVE_TILE);
        require(
            "n-live",
            n_live,
            (20..=10_000_000).contains(&n_live),
            "must be 20 or more",
        )?;
        match self.tiles {
            Tiling::Count(n) => {
                require(
                    "tiles",
                    n,
                    (1..=1_000_000).contains(&n),
                    "must lie between 1 and 1 000 000",
                )?;
            }
            Tiling::Size(side) => {
                require(
                    "tile-size",
                    side,
                    side.0 > fov / 1000.0,
                    "must be above 1/1000 of the field",
                )?;
            }
            Tiling::Auto => {}
        }
        self.prior.check()
    }

    fn check_selection(&self) -> Result<(), ConfigError> {
        let p_cut = self.p_cut;
        require(
            "p-cut",
            p_cut,
            (0.0..1.0).contains(&p_cut),
            "must lie in [0, 1)",
        )?;
        let select = self.selection();
        let name = match select {
            Select::Snr | Select::PSource => return Ok(()),
            Select::Flux => "flux",
            Select::Bayes => "bayes",
        };
        let Some(flux_cut) = self.flux_cut else {
            return Err(ConfigError::Value {
                key: "select",
                value: name.into(),
                what: "needs a flux cut: give --flux-cut, as in --flux-cut 20uJy",
            });
        };
        let Range { low, high } = self.prior.flux;
        require(
            "flux-cut",
            flux_cut,
            select != Select::Bayes || (low.0..high.0).contains(&flux_cut.0),
            "must lie in the range of flux densities (--flux), part of which is below it with --select bayes",
        )
    }

    /// What makes a mode a source.
    pub fn selection(&self) -> Select {
        self.select.unwrap_or(match self.flux_cut {
            Some(_) => Select::Flux,
            None => Select::Snr,
        })
    }

    /// Lowest matched-filter signal-to-noise ratio of what may be a source.
    pub fn lowest_snr(&self) -> f64 {
        self.snr_cut.unwrap_or(match self.selection() {
            Select::Snr | Select::Flux => SNR_CUT,
            Select::Bayes | Select::PSource => SNR_CUT_BY_PROBABILITY,
        })
    }

    /// The prior of one source.
    pub fn source_prior(&self) -> SourcePrior {
        self.prior.source_prior(self.spectral_index)
    }

    /// The terms of the instrument.
    pub fn instrument(&self) -> InstrumentTerms {
        InstrumentTerms {
            smearing: self.smearing,
            beam: self.beam,
            spectral_index: self.spectral_index,
        }
    }

    /// Is the field to be searched in one run, as in the paper? Only where the user says so: a
    /// field that is no larger than a tile is a tile.
    pub fn is_global(&self) -> bool {
        self.tiles == Tiling::Count(1)
    }

    /// Live points of each tile.
    pub fn n_live_tile(&self) -> usize {
        self.n_live.unwrap_or(if self.is_global() {
            N_LIVE_GLOBAL
        } else {
            N_LIVE_TILE
        })
    }

    /// Every option that decides the result, as TOML. Memory is left out: it does not.
    pub fn to_toml(&self) -> String {
        let mut text = toml::to_string(self).unwrap_or_default();
        text = text
            .lines()
            .filter(|line| !line.starts_with("memory"))
            .collect::<Vec<_>>()
            .join("\n");
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_configuration_is_valid_and_survives_toml() {
        let config = Config::default();
        config.check().unwrap();
        let back: Config = toml::from_str(&config.to_toml()).unwrap();
        assert_eq!(back.to_toml(), config.to_toml());
    }

    #[test]
    fn an_unknown_key_is_an_error_that_names_it() {
        let error = toml::from_str::<Config>("snr-cutt = 5")
            .unwrap_err()
            .to_string();
        assert!(error.contains("snr-cutt"), "{error}");
    }

    fn complaint(config: &Config) -> String {
        config.check().unwrap_err().to_string()
    }

    #[test]
    fn values_out_of_range_are_named() {
        let config = Config {
            efficiency: 1.5,
            ..Config::default()
        };
        assert!(complaint(&config).contains("efficiency = 1.5"));
    }

    #[test]
    fn a_selection_by_flux_density_needs_a_cut_that_can_select() {
        let mut config = Config {
            select: Some(Select::Bayes),
            ..Config::default()
        };
        assert!(complaint(&config).contains("--flux-cut"));
        config.flux_cut = Some(Flux(5e-6));
        assert!(complaint(&config).contains("--flux"));
        config.flux_cut = Some(Flux(20e-6));
        config.check().unwrap();
        assert_eq!(config.lowest_snr(), 5.0);
        config.select = None;
        assert_eq!(
            (config.selection(), config.lowest_snr()),
            (Select::Flux, 6.0)
        );
    }

    #[test]
    fn noise_sources_parse() {
        assert_eq!("sefd=400Jy".parse(), Ok(NoiseSource::Sefd(Flux(400.0))));
        assert!("sefd=400".parse::<NoiseSource>().is_err());
        assert!("guess".parse::<NoiseSource>().is_err());
    }
}
