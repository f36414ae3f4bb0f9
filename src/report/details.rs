//! What the report tells of a catalogue beyond its sources, modes and samples: flags, groups, headers,
//! the table `RUN`. A catalogue of another program has none of these.

use std::path::Path;

use vis2cat_formats::ReadError;
use vis2cat_formats::fits::{Table, Value, find_table, is_fits};

use crate::catalogue::RunEntry;

/// Keywords of the header that are shown, with what they are.
const KEYWORDS: [(&str, &str); 8] = [
    ("TELESCOP", "Telescope"),
    ("OBJECT", "Field"),
    ("DATE-OBS", "Start of the observation (UTC)"),
    ("PHASERA", "Phase centre, RA (ICRS) [deg]"),
    ("PHASEDEC", "Phase centre, DEC (ICRS) [deg]"),
    ("RESTFRQ", "Frequency of the flux densities [Hz]"),
    ("CREATOR", "Written by"),
    ("SEED", "Seed"),
];

/// The rest of a catalogue.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Details {
    /// What the file says of each row; NaN where it does not.
    pub(super) rows: Vec<RowDetails>,
    /// The table `RUN`.
    pub(super) run: Vec<RunEntry>,
    /// Observation and origin: what, and its value.
    pub(super) header: Vec<(&'static str, String)>,
}

/// What is told of a row beyond what [`FoundRow`](crate::catalogue::FoundRow) has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RowDetails {
    pub(super) corr_ra_dec: f64,
    pub(super) group_id: f64,
    pub(super) log_z: f64,
    pub(super) e_log_z: f64,
    pub(super) n_eff: f64,
    pub(super) flags: f64,
}

impl Details {
    /// Reads them from `path`, which has `n_row` sources.
    pub(super) fn read(path: &Path, n_row: usize) -> Result<Self, ReadError> {
        let nothing = Self {
            rows: vec![RowDetails::none(); n_row],
            ..Self::default()
        };
        if !is_fits(path)? {
            return Ok(nothing);
        }
        let Some(catalogue) = find_table(path, Some("CATALOGUE"))? else {
            refuse_samples(path)?;
            return Ok(nothing);
        };
        let run = find_table(path, Some("RUN"))?;
        Ok(Self {
            rows: rows(&catalogue)?,
            run: run
                .map(|table| entries(&table))
                .transpose()?
                .unwrap_or_default(),
            header: header(&catalogue),
        })
    }

    /// The value of a key of `RUN`.
    pub(super) fn entry(&self, key: &str) -> Option<&str> {
        let entry = self.run.iter().find(|entry| entry.key == key);
        entry.map(|entry| entry.value.as_str())
    }

    /// The same as a number.
    pub(super) fn number(&self, key: &str) -> Option<f64> {
        self.entry(key)?.parse().ok()
    }
}

impl RowDetails {
    const fn none() -> Self {
        Self {
            corr_ra_dec: f64::NAN,
            group_id: f64::NAN,
            log_z: f64::NAN,
            e_log_z: f64::NAN,
            n_eff: f64::NAN,
            flags: f64::NAN,
        }
    }
}

/// An error if the file is not a catalogue but the samples of one, which have positions as well.
fn refuse_samples(path: &Path) -> Result<(), ReadError> {
    match find_table(path, Some("POSTERIOR"))? {
        None => Ok(()),
        Some(_) => Err(ReadError::Unsupported {
            path: path.into(),
            place: "POSTERIOR".to_owned(),
            what: "these are the posterior samples of a catalogue; name the catalogue itself, \
                   and the samples beside it are found"
                .to_owned(),
        }),
    }
}

fn rows(table: &Table) -> Result<Vec<RowDetails>, ReadError> {
    let column = |name: &str| match table.column(name) {
        Some(_) => table.numbers(name),
        None => Ok(vec![f64::NAN; table.rows()]),
    };
    let (corr_ra_dec, group_id) = (column("Corr_RA_DEC")?, column("Group_id")?);
    let (log_z, e_log_z) = (column("Log_Z")?, column("E_Log_Z")?);
    let (n_eff, flags) = (column("N_eff")?, column("Flags")?);
    let row = |i: usize| RowDetails {
        corr_ra_dec: corr_ra_dec[i],
        group_id: group_id[i],
        log_z: log_z[i],
        e_log_z: e_log_z[i],
        n_eff: n_eff[i],
        flags: flags[i],
    };
    Ok((0..table.rows()).map(row).collect())
}

fn entries(table: &Table) -> Result<Vec<RunEntry>, ReadError> {
    let (keys, values) = (table.strings("KEY")?, table.strings("VALUE")?);
    let comments = table.strings("COMMENT")?;
    let entry = |i: usize| RunEntry {
        key: keys[i].clone(),
        value: values[i].clone(),
        comment: comments[i].clone(),
    };
    Ok((0..table.rows()).map(entry).collect())
}

fn header(table: &Table) -> Vec<(&'static str, String)> {
    let known = |(key, what): &(&str, &'static str)| Some((*what, text(table.keyword(key)?)?));
    KEYWORDS.iter().filter_map(known).collect()
}

fn text(value: &Value) -> Option<String> {
    match value {
        Value::Text(text) => Some(text.clone()),
        Value::Integer(value) => Some(value.to_string()),
        Value::Real(value) => Some(rounded(*value).to_string()),
        _ => None,
    }
}

/// A number to fifteen digits: what more of them say is rounding.
fn rounded(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}
