//! What the rows are made of: tables `DATA_DESCRIPTION`, `SPECTRAL_WINDOW` and `POLARIZATION`.
//!
//! # Source
//! Note, sections on these tables.

use std::path::Path;

use super::{MAX_SUBTABLE_ROWS, corrs};
use crate::casa::Table;
use crate::{Corr, FreqSetup, ReadError};

/// Most channels over all windows.
const MAX_CHANNELS: usize = 4 << 20;

/// The data descriptions: each is a spectral window and a set of correlations.
#[derive(Debug)]
pub(super) struct Windows {
    /// The windows of the wanted descriptions with the correlations of the first of them.
    pub(super) setups: Vec<FreqSetup>,
    pub(super) corrs: Vec<Corr>,
    /// The row in `SPECTRAL_WINDOW` of each set-up.
    pub(super) spw_s: Vec<u32>,
    /// The set-up of each description, or why it has none; nothing where it is not wanted.
    places: Vec<Option<Result<u32, String>>>,
}

impl Windows {
    /// `first` is the description of the first row of the main table; of the others only those of the
    /// spectral windows `spws` are wanted, or all where there are none.
    pub(super) fn read(
        root: &Path,
        first: i32,
        spws: &[i64],
        warnings: &mut Vec<String>,
    ) -> Result<Self, ReadError> {
        let mut descriptions = Table::open_sub(root, "DATA_DESCRIPTION")?;
        let mut polarizations = Table::open_sub(root, "POLARIZATION")?;
        let mut spectral = Table::open_sub(root, "SPECTRAL_WINDOW")?;
        if descriptions.n_row > MAX_SUBTABLE_ROWS {
            return Err(descriptions.malformed(format!("has {} rows", descriptions.n_row)));
        }
        let mut ids = Vec::new();
        for row in 0..descriptions.n_row {
            ids.push(descriptions.scalar::<i32>("SPECTRAL_WINDOW_ID", row)?);
        }
        let first = first_wanted(&descriptions, &ids, first, spws)?;
        let id = descriptions.scalar("POLARIZATION_ID", first)?;
        let corrs = corrs_of(&mut polarizations, id)??;
        let mut windows = Self {
            setups: Vec::new(),
            corrs,
            spw_s: Vec::new(),
            places: Vec::new(),
        };
        let mut n_chan = 0;
        for (row, &spw) in (0..).zip(&ids) {
            if !spws.is_empty() && !spws.contains(&spw.into()) {
                windows.places.push(None);
                continue;
            }
            let id = descriptions.scalar("POLARIZATION_ID", row)?;
            let found = match corrs_of(&mut polarizations, id)? {
                Ok(corrs) if corrs == windows.corrs => {
                    let setup = channels(&mut spectral, spw, warnings)?;
                    n_chan += setup.freq_hz_f.len();
                    windows.setups.push(setup);
                    windows.spw_s.push(spw.unsigned_abs());
                    Ok(windows.setups.len() as u32 - 1)
                }
                Ok(corrs) => Err(format!(
                    "data description {row} (spectral window {spw}) has correlations {corrs:?}, that \
                     of the first row has {:?}; spectral windows of different correlations cannot be \
                     read at once: choose some that agree, with --spw",
                    windows.corrs
                )),
                Err(error) => Err(error.to_string()),
            };
            windows.places.push(Some(found));
            if n_chan > MAX_CHANNELS {
                let what = format!("more than {MAX_CHANNELS} channels in all windows are not read");
                return Err(spectral.malformed(what));
            }
        }
        Ok(windows)
    }

    /// Whether rows of a description are wanted.
    pub(super) fn is_wanted(&self, number: i32) -> bool {
        let row = usize::try_from(number).ok();
        !matches!(row.and_then(|row| self.places.get(row)), Some(None))
    }

    /// The place in the set-ups of a description; errors in words.
    pub(super) fn find(&self, number: i32) -> Result<u32, String> {
        let row = usize::try_from(number).ok();
        match row.and_then(|row| self.places.get(row)) {
            Some(Some(place)) => place.clone(),
            Some(None) => Err(format!("data description {number} is not wanted")),
            None => Err(format!("data description {number} is not in its table")),
        }
    }
}

/// The description that says what correlations are read: that of the first row, or else the first of
/// the spectral windows wanted.
fn first_wanted(
    descriptions: &Table,
    ids: &[i32],
    first: i32,
    spws: &[i64],
) -> Result<u64, ReadError> {
    if spws.is_empty() {
        return Ok(u64::try_from(first).unwrap_or(u64::MAX));
    }
    if let Some(missing) = spws
        .iter()
        .find(|spw| !ids.iter().any(|id| i64::from(*id) == **spw))
    {
        let what = format!("there is no spectral window {missing}; there are: {ids:?}");
        return Err(descriptions.unsupported("SPECTRAL_WINDOW_ID", 0, what));
    }
    let at = ids.iter().position(|id| spws.contains(&i64::from(*id)));
    Ok(at.map_or(u64::MAX, |at| at as u64))
}

/// The correlations of a row of `POLARIZATION`. What is unknown there is an error of its own, since
/// nothing is wrong as long as no data are of it.
fn corrs_of(table: &mut Table, id: i32) -> Result<Result<Vec<Corr>, ReadError>, ReadError> {
    let row = u64::try_from(id).unwrap_or(u64::MAX);
    let (shape, numbers) = table.array::<i32>("CORR_TYPE", row)?;
    if shape.len() != 1 || numbers.is_empty() {
        let what = format!("has shape {shape:?}, must be one axis of correlations");
        return Err(table.cell_error("CORR_TYPE", row, what));
    }
    let mut list = Vec::with_capacity(numbers.len());
    for number in numbers {
        match corrs::from_number(number) {
            Some(corr) if !list.contains(&corr) => list.push(corr),
            Some(corr) => {
                let what = format!("has {corr:?} twice");
                return Err(table.cell_error("CORR_TYPE", row, what));
            }
            None => {
                let what = format!("{number} is no known correlation");
                return Ok(Err(table.unsupported("CORR_TYPE", row, what)));
            }
        }
    }
    Ok(Ok(list))
}

/// The channels of a row of `SPECTRAL_WINDOW`.
fn channels(
    table: &mut Table,
    id: i32,
    warnings: &mut Vec<String>,
) -> Result<FreqSetup, ReadError> {
    let row = u64::try_from(id).unwrap_or(u64::MAX);
    let (shape, freq_hz_f) = table.array::<f64>("CHAN_FREQ", row)?;
    if shape.len() != 1 || freq_hz_f.is_empty() {
        let what = format!("has shape {shape:?}, must be one axis of channels");
        return Err(table.cell_error("CHAN_FREQ", row, what));
    }
    if let Some(bad) = freq_hz_f.iter().find(|f| !(f.is_finite() && **f > 0.0)) {
        let what = format!("a channel would be at {bad} Hz");
        return Err(table.cell_error("CHAN_FREQ", row, what));
    }
    let mut chan_width_hz_f = table.shaped::<f64>("CHAN_WIDTH", row, &[freq_hz_f.len()])?;
    if let [first, .., last] = freq_hz_f.as_slice() {
        // Some writers have all widths positive.
        for width_hz in &mut chan_width_hz_f {
            *width_hz = width_hz.abs().copysign(last - first);
        }
    }
    warnings.extend(frame_warning(table, row)?);
    Ok(FreqSetup {
        freq_hz_f,
        chan_width_hz_f,
        n_if: 1,
    })
}

/// Frequencies that are not those at the telescope are told of.
fn frame_warning(table: &mut Table, row: u64) -> Result<Option<String>, ReadError> {
    /// casacore's manual, class MFrequency, Types.
    const TOPO: i32 = 5;
    const NAMES: [&str; 9] = [
        "REST", "LSRK", "LSRD", "BARY", "GEO", "TOPO", "GALACTO", "LGROUP", "CMB",
    ];
    let reference = table.reference("CHAN_FREQ")?;
    let name = match (&reference.column, &reference.frame) {
        (Some(column), _) => {
            let code = table.scalar::<i32>(column, row)?;
            if code == TOPO {
                return Ok(None);
            }
            let known = usize::try_from(code).ok().and_then(|code| NAMES.get(code));
            known.map_or_else(|| format!("frame {code}"), |name| (*name).to_owned())
        }
        (None, Some(frame)) if frame != "TOPO" => frame.clone(),
        _ => return Ok(None),
    };
    Ok(Some(format!(
        "the frequencies of spectral window {row} are {name}, not those at the telescope (TOPO); they \
         are used as stored, which can be wrong by one part in ten thousand"
    )))
}
