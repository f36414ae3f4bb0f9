//! The visibilities as the run of the catalogue saw them.

use vis2cat_formats::ReadOptions;

use super::super::Contents;
use super::super::details::Details;
use super::CheckOptions;
use crate::config::{Config, ConfigError};
use crate::coords::{IcrsCentre, RaDec};
use crate::dataset::{Dataset, DatasetError};
use crate::run::open_options;
use crate::units::DEG;

/// Options of a run that say how visibilities are read and modelled, and whether TOML has their values
/// in quotes.
const KEYS: [(&str, bool); 8] = [
    ("field", true),
    ("spw", false),
    ("data-column", true),
    ("noise", true),
    ("smearing", false),
    ("beam", true),
    ("spectral-index", true),
    ("prior.profile", true),
];
/// Visibilities this far from the field are of another one [rad].
const FAR_RAD: f64 = 1.0 * DEG;

/// These options as `RUN` has them; what it does not say is as in a run without options.
pub(super) fn configuration(details: &Details) -> Result<Config, ConfigError> {
    let line = |(key, is_quoted): &(&str, bool)| {
        let value = details.entry(&format!("config.{key}"))?;
        Some(if *is_quoted {
            // As TOML has a text: the rules of JSON hold there.
            format!(
                "{key} = {}\n",
                serde_json::to_string(value).unwrap_or_default()
            )
        } else {
            format!("{key} = {value}\n")
        })
    };
    let text: String = KEYS.iter().filter_map(line).collect();
    toml::from_str(&text).map_err(|e| ConfigError::Toml {
        path: "RUN".into(),
        what: e.to_string(),
    })
}

/// Reads the files once.
pub(super) fn open(
    contents: &Contents,
    options: &CheckOptions,
    config: &Config,
    progress: &mut dyn FnMut(&'static str, u64, u64),
) -> Result<Dataset, DatasetError> {
    let options_given = &options.read;
    let mut read = ReadOptions {
        data_column: options_given
            .data_column
            .clone()
            .or(config.data_column.clone()),
        ..options_given.clone()
    };
    if read.select.field.is_none() {
        read.select.field.clone_from(&config.field);
    }
    if read.select.spws.is_empty() {
        read.select.spws.clone_from(&config.spw);
    }
    let open = open_options(config, read);
    let mut told = |done, all| progress("reading", done, all);
    let dataset = Dataset::open(&options.inputs, &open, &mut told)?;
    refuse_other_field(contents, options, &dataset)?;
    Ok(dataset)
}

/// An error where the data are of another part of the sky.
fn refuse_other_field(
    contents: &Contents,
    options: &CheckOptions,
    dataset: &Dataset,
) -> Result<(), DatasetError> {
    let field = dataset.phase_centre();
    let native = RaDec {
        ra_rad: field.ra_rad,
        dec_rad: field.dec_rad,
    };
    let centre = IcrsCentre::new(native, field.frame).centre;
    let away_rad = centre.separation_rad(contents.centre());
    if away_rad <= FAR_RAD || contents.catalogue.rows.is_empty() {
        return Ok(());
    }
    Err(DatasetError::Unusable {
        path: options.inputs.first().cloned().unwrap_or_default(),
        what: format!(
            "its phase centre is {:.2} deg from the field of the catalogue: it is another field",
            away_rad / DEG
        ),
    })
}
