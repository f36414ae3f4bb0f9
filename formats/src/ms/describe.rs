//! What the tables say of the observation as a whole.
//!
//! # Source
//! Note, sections on OBSERVATION and HISTORY.

use std::path::Path;

use super::DAY_S;
use crate::casa::Table;
use crate::{Observation, ReadError, TimeScale, date};

/// Most lines of history that are kept.
const MAX_HISTORY: u64 = 10_000;

/// Names, days, time scale, history; nothing of the rows.
pub(super) fn describe(
    root: &Path,
    main: &mut Table,
    warnings: &mut Vec<String>,
) -> Result<Observation, ReadError> {
    let mut table = Table::open_sub(root, "OBSERVATION")?;
    let first_mjd = main.scalar::<f64>("TIME", 0)? / DAY_S;
    let array_position_m = if table.has("TELESCOPE_LOCATION") {
        let position_m = table.shaped::<f64>("TELESCOPE_LOCATION", 0, &[3])?;
        [position_m[0], position_m[1], position_m[2]]
    } else {
        [0.0; 3]
    };
    Ok(Observation {
        telescope: table.text("TELESCOPE_NAME", 0)?.trim().to_owned(),
        observer: table.text("OBSERVER", 0)?.trim().to_owned(),
        date_obs: if first_mjd.is_finite() {
            date::day_of_mjd(first_mjd)
        } else {
            String::new()
        },
        array_position_m,
        time_scale: time_scale(main, warnings)?,
        history: history(root)?,
        n_row: main.n_row,
        ..Observation::default()
    })
}

fn time_scale(main: &mut Table, warnings: &mut Vec<String>) -> Result<TimeScale, ReadError> {
    if let Some(unit) = main.unit("TIME")?.filter(|unit| unit != "s") {
        let what = format!("is in '{unit}', must be in 's'");
        return Err(main.column_error("TIME", what));
    }
    let name = main.reference("TIME")?.frame;
    Ok(match name.as_deref() {
        None | Some("UTC") => TimeScale::Utc,
        Some("TAI" | "IAT") => TimeScale::Tai,
        Some(other) => {
            warnings.push(format!("time scale '{other}' is taken as UTC"));
            TimeScale::Other
        }
    })
}

/// The messages of `HISTORY`, which can be done without.
fn history(root: &Path) -> Result<Vec<String>, ReadError> {
    if !root.join("HISTORY").join("table.dat").is_file() {
        return Ok(Vec::new());
    }
    let mut table = Table::open_sub(root, "HISTORY")?;
    (0..table.n_row.min(MAX_HISTORY))
        .map(|row| table.text("MESSAGE", row))
        .collect()
}
