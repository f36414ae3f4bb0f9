//! What is shown.

use std::path::Path;

use vis2cat_formats::ReadError;

use super::details::{Details, RowDetails};
use super::visibilities::Check;
use crate::catalogue::{
    FoundCatalogue, FoundRow, SearchedField, SourceList, read_catalogue, read_source_list,
};
use crate::coords::{Lm, RaDec};
use crate::evaluate::{Evaluation, MatchedRow, evaluate};
use crate::timing::StageTime;

/// Everything that a report is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Contents {
    /// Name of the catalogue's file.
    pub(super) name: String,
    pub(super) catalogue: FoundCatalogue,
    pub(super) details: Details,
    pub(super) truth: Option<Truth>,
    pub(super) check: Option<Check>,
    /// Wall times of the run; none if nobody noted them.
    pub(super) timings: Vec<StageTime>,
}

/// True sources, and how the catalogue compares with them.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    pub(super) name: String,
    pub(super) list: SourceList,
    pub(super) evaluation: Evaluation,
}

impl Contents {
    /// Reads a catalogue, with samples where they lie beside it, and true sources where there are any.
    ///
    /// # Errors
    /// A file cannot be read or is something else; the error names table, column and row.
    pub fn read(catalogue: &Path, truth: Option<&Path>) -> Result<Self, ReadError> {
        let found = read_catalogue(catalogue)?;
        let details = Details::read(catalogue, found.rows.len())?;
        let truth = truth.map(|path| {
            let list = read_source_list(path)?;
            let evaluation = evaluate(&found, &list);
            let name = file_name(path);
            Ok(Truth {
                name,
                list,
                evaluation,
            })
        });
        Ok(Self {
            name: file_name(catalogue),
            catalogue: found,
            details,
            truth: truth.transpose()?,
            check: None,
            timings: Vec::new(),
        })
    }

    /// The same with what the visibilities say.
    #[must_use]
    pub fn with_check(self, check: Check) -> Self {
        Self {
            check: Some(check),
            ..self
        }
    }

    /// The same with how long the stages of the run took.
    #[must_use]
    pub fn with_timings(self, timings: Vec<StageTime>) -> Self {
        Self { timings, ..self }
    }

    /// What positions are offsets from: the centre of the searched field, or of the sources.
    pub(super) fn centre(&self) -> RaDec {
        let rows = &self.catalogue.rows;
        let Some(SearchedField { centre, .. }) = self.catalogue.field else {
            let sum = rows.iter().fold([0.0; 3], |sum, row| {
                let at = row.position.unit_vector();
                [sum[0] + at[0], sum[1] + at[1], sum[2] + at[2]]
            });
            return RaDec {
                ra_rad: sum[1].atan2(sum[0]).rem_euclid(std::f64::consts::TAU),
                dec_rad: sum[2].atan2(sum[0].hypot(sum[1])),
            };
        };
        centre
    }

    /// Where a source is from there.
    pub(super) fn offset(&self, position: RaDec) -> Lm {
        position.to_lm(self.centre())
    }

    /// What the file says of a row beyond its measurements.
    pub(super) fn row_details(&self, row: usize) -> RowDetails {
        self.details.rows[row]
    }

    /// The number of a row: `Source_id`, or its place in the table from 1.
    pub(super) fn number_of(&self, row: usize) -> i64 {
        self.catalogue.rows[row].source_id.unwrap_or(row as i64 + 1)
    }

    /// Name of a row's place in the page and of its figure: unique, whatever the file says.
    pub(super) fn anchor(&self, row: usize) -> String {
        let own = self.number_of(row);
        let is_taken = (0..row).any(|other| self.number_of(other) == own);
        if is_taken {
            format!("source_{own}_row_{}", row + 1)
        } else {
            format!("source_{own}")
        }
    }

    /// What a row is called.
    pub(super) fn title(&self, row: usize) -> String {
        let name = &self.catalogue.rows[row].name;
        if name.is_empty() {
            format!("Source {}", self.number_of(row))
        } else {
            name.clone()
        }
    }

    /// The true source that a row is.
    pub(super) fn match_of(&self, row: usize) -> Option<&MatchedRow> {
        let matched = &self.truth.as_ref()?.evaluation.matched;
        matched.iter().find(|m| m.row == row + 1)
    }

    /// The rows, the highest signal-to-noise ratio first.
    pub(super) fn by_snr(&self) -> Vec<usize> {
        let rows = &self.catalogue.rows;
        let strength = |row: &FoundRow| {
            let snr = if row.snr.is_nan() {
                row.snr_peak
            } else {
                row.snr
            };
            if snr.is_nan() { f64::NEG_INFINITY } else { snr }
        };
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by(|&i, &j| strength(&rows[j]).total_cmp(&strength(&rows[i])));
        order
    }
}

/// The last part of a path.
pub(super) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}
