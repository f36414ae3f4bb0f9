//! How an observation is laid out in a set: decided before the first row.

use std::ops::Range;

use super::corrs;
use crate::{Corr, Frame, FreqSetup, Observation};

/// Bytes of visibilities that are gathered before they are written, and of a tile.
const BLOCK_BYTES: usize = 1 << 20;
/// Most rows of a block.
const MAX_BLOCK_ROWS: usize = 1 << 13;

/// The layout.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    /// Rows that are gathered before they are written.
    pub(super) block_rows: usize,
    /// Channels of each spectral window, the same of every set-up.
    pub(super) windows: Vec<Range<usize>>,
    /// Correlations by their place in a chunk, in the order of their numbers.
    pub(super) corr_order: Vec<usize>,
    /// casacore's name of the frame of the phase centres.
    pub(super) frame: &'static str,
    /// Names of antennas, none of them empty.
    pub(super) antenna_names: Vec<String>,
    /// Geocentric position of the array, or the mean of its antennas' where that is all there is [m].
    pub(super) array_m: [f64; 3],
}

impl Layout {
    /// Decides; what cannot be written is told in words.
    pub(super) fn new(observation: &Observation) -> Result<Self, String> {
        if observation.antennas.is_empty() {
            return Err("0 antennas cannot be written".into());
        }
        if observation.corrs.is_empty() {
            return Err("the observation has no correlations".into());
        }
        observation.check_phased("a Measurement Set")?;
        let windows = windows(observation)?;
        let n_chan = windows.last().map_or(0, |window| window.end);
        let row_bytes = n_chan * observation.corrs.len() * 8;
        Ok(Self {
            block_rows: (BLOCK_BYTES / row_bytes.max(1)).clamp(1, MAX_BLOCK_ROWS),
            windows,
            corr_order: corr_order(&observation.corrs),
            frame: frame(observation)?,
            antenna_names: antenna_names(observation),
            array_m: observation.array_or_mean_m(),
        })
    }

    /// The shape (rows, channels, correlations) of a tile, in a set whose blocks have `n_row` rows.
    pub(super) fn tile(&self, n_row: usize) -> [u64; 3] {
        let n_corr = self.corr_order.len();
        let n_chan = self.windows.iter().map(Range::len).max().unwrap_or(1);
        let most = (BLOCK_BYTES / (8 * n_corr)).max(1);
        [n_row, n_chan.min(most), n_corr].map(|len| len as u64)
    }

    /// The number of the data description of a window of a set-up.
    pub(super) fn description(&self, setup: usize, window: usize) -> usize {
        setup * self.windows.len() + window
    }
}

/// The spectral windows: the runs of channels of a number that UVH5 has, or else the IFs.
fn windows(observation: &Observation) -> Result<Vec<Range<usize>>, String> {
    let Some(first) = observation.freq_setups.first() else {
        return Err("the observation has no frequencies".into());
    };
    let n_chan = first.freq_hz_f.len();
    let like_first = |setup: &FreqSetup| {
        setup.freq_hz_f.len() == n_chan
            && setup.chan_width_hz_f.len() == n_chan
            && setup.n_if == first.n_if
    };
    if n_chan == 0 || !observation.freq_setups.iter().all(like_first) {
        return Err("the frequency set-ups have no channels, or not all as many".into());
    }
    if let Some(notes) = (observation.uvh5.as_ref()).filter(|notes| notes.spw_f.len() == n_chan) {
        let mut start = 0;
        let runs = notes.spw_f.chunk_by(|a, b| a == b).map(|run| {
            let end = start + run.len();
            std::mem::replace(&mut start, end)..end
        });
        return Ok(runs.collect());
    }
    if first.n_if == 0 || !n_chan.is_multiple_of(first.n_if) {
        let n_if = first.n_if;
        return Err(format!(
            "{n_chan} channels cannot be shared among {n_if} IFs"
        ));
    }
    let per_if = n_chan / first.n_if;
    Ok((0..first.n_if)
        .map(|i| i * per_if..(i + 1) * per_if)
        .collect())
}

fn corr_order(list: &[Corr]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..list.len()).collect();
    order.sort_by_key(|&p| corrs::number(list[p]));
    order
}

/// The frame that all phase centres are in: (u, v, w) are in it too.
fn frame(observation: &Observation) -> Result<&'static str, String> {
    let Some(first) = observation.fields.first() else {
        return Err("the observation has no phase centre".into());
    };
    if let Some(other) = observation.fields.iter().find(|f| f.frame != first.frame) {
        return Err(format!(
            "phase centres in {:?} and {:?} cannot be written to one Measurement Set",
            first.frame, other.frame
        ));
    }
    match first.frame {
        Frame::Icrs => Ok("ICRS"),
        Frame::Fk5(2000.0) => Ok("J2000"),
        Frame::Fk4(1950.0) => Ok("B1950"),
        other => Err(format!(
            "casacore has no frame {other:?}: the phase centre cannot be written to a Measurement Set"
        )),
    }
}

/// Their names, or their numbers: an antenna without a name is none to readers.
fn antenna_names(observation: &Observation) -> Vec<String> {
    let name = |antenna: &crate::Antenna| match antenna.name.trim() {
        "" => antenna.number.to_string(),
        name => name.to_owned(),
    };
    observation.antennas.iter().map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observation() -> Observation {
        Observation {
            antennas: vec![crate::Antenna::default()],
            fields: vec![crate::Field::default()],
            freq_setups: vec![FreqSetup {
                freq_hz_f: vec![1e9; 6],
                chan_width_hz_f: vec![1e6; 6],
                n_if: 3,
            }],
            corrs: vec![Corr::Xx, Corr::Yy, Corr::Xy],
            ..Observation::default()
        }
    }

    #[test]
    fn ifs_and_runs_of_channels_are_windows() {
        let mut observation = observation();
        let layout = Layout::new(&observation).unwrap();
        assert_eq!(layout.windows, [0..2, 2..4, 4..6]);
        assert_eq!(layout.corr_order, [0, 2, 1]);
        assert_eq!(layout.description(2, 1), 7);
        observation.uvh5 = Some(crate::Uvh5Notes {
            spw_f: vec![7, 3, 3, 4, 4, 4],
            ..crate::Uvh5Notes::default()
        });
        let layout = Layout::new(&observation).unwrap();
        assert_eq!(layout.windows, [0..1, 1..3, 3..6]);
    }

    #[test]
    fn frames_that_casacore_lacks_are_told() {
        let mut observation = observation();
        observation.fields[0].frame = Frame::Fk5(2016.5);
        let error = Layout::new(&observation).unwrap_err();
        assert!(
            error.starts_with("casacore has no frame Fk5(2016.5)"),
            "{error}"
        );
    }
}
