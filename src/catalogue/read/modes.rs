//! `MODES` read back.

use vis2cat_formats::ReadError;

use super::super::list::{ListTable, Unit};
use super::{positions, whole};
use crate::coords::RaDec;
use crate::detect::Status;

/// One mode of a catalogue, kept or not; what the table does not say is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundMode {
    /// Position, ICRS.
    pub position: RaDec,
    /// Standard deviation of the position, the larger of both axes [rad].
    pub position_sigma_rad: f64,
    /// Total flux density [Jy].
    pub flux_jy: f64,
    /// Matched-filter signal-to-noise ratio at the best sample.
    pub snr_peak: f64,
    /// Local log evidence against no source.
    pub log_z: f64,
    /// Probability that this is a source.
    pub p_source: f64,
    /// Kept, or why not.
    pub status: Status,
    /// The source that it is, or that explains it.
    pub source_id: Option<i64>,
}

pub(super) fn read(table: &ListTable) -> Result<Vec<FoundMode>, ReadError> {
    let positions = positions(table)?;
    let sigma_rad = table.column_or("E_Pos", Unit::angle("arcsec"), f64::NAN)?;
    let flux_jy = table.need_flux()?;
    let snr_peak = table.need("SNR_peak", Unit::NONE)?;
    let log_z = table.column_or("Log_Z", Unit::NONE, f64::NAN)?;
    let p_source = table.column_or("P_source", Unit::NONE, f64::NAN)?;
    let source_id = table.column_or("Source_id", Unit::NONE, f64::NAN)?;
    let status = statuses(table)?;
    let mode = |(i, position): (usize, RaDec)| FoundMode {
        position,
        position_sigma_rad: sigma_rad[i],
        flux_jy: flux_jy[i],
        snr_peak: snr_peak[i],
        log_z: log_z[i],
        p_source: p_source[i],
        status: status[i],
        source_id: whole(source_id[i]),
    };
    Ok(positions.into_iter().enumerate().map(mode).collect())
}

fn statuses(table: &ListTable) -> Result<Vec<Status>, ReadError> {
    let words = table.strings("Status")?;
    let words = words.ok_or_else(|| table.malformed("column Status", "there is none"))?;
    let status = |(row, word): (usize, &String)| {
        Status::parse(word).ok_or_else(|| {
            let known: Vec<&str> = Status::ALL.iter().map(|s| s.as_str()).collect();
            let place = format!("row {}, column Status", row + 1);
            let what = format!("{word:?} is not one of {}", known.join(", "));
            table.malformed(&place, &what)
        })
    };
    words.iter().enumerate().map(status).collect()
}
