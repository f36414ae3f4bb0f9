//! The spectral windows of an observation, whatever its format calls them.

use std::ops::Range;

use crate::Observation;

/// A run of channels with a number of its own: an IF of UVFITS, a window of UVH5, the spectral window
/// of a data description of a Measurement Set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Window {
    /// Its number: of the table `SPECTRAL_WINDOW`, or of `spw_array`; counted from 0 where a format
    /// has none, IF after IF and set-up after set-up.
    pub number: i64,
    /// Index into [`Observation::freq_setups`].
    pub setup: usize,
    /// Its channels of those of the set-up.
    pub chans: Range<usize>,
}

impl Observation {
    /// The spectral windows, in the order of set-ups and channels.
    pub fn windows(&self) -> Vec<Window> {
        let mut windows = Vec::new();
        for (setup, n_chan) in self
            .freq_setups
            .iter()
            .map(|s| s.freq_hz_f.len())
            .enumerate()
        {
            let ms = self.ms.as_ref().and_then(|ms| ms.spw_s.get(setup));
            let uvh5 = self
                .uvh5
                .as_ref()
                .filter(|notes| notes.spw_f.len() == n_chan);
            let first = windows.len() as i64;
            let mut start = 0;
            let mut push = |number: i64, len: usize| {
                let chans = start..start + len;
                start += len;
                windows.push(Window {
                    number,
                    setup,
                    chans,
                });
            };
            if let Some(&number) = ms {
                push(number.into(), n_chan);
            } else if let Some(notes) = uvh5 {
                let runs = notes.spw_f.chunk_by(|a, b| a == b);
                runs.for_each(|run| push(run[0], run.len()));
            } else {
                let n_if = self.freq_setups[setup].n_if.max(1);
                (0..n_if).for_each(|i| push(first + i as i64, n_chan / n_if));
            }
        }
        windows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FreqSetup, Uvh5Notes};

    #[test]
    fn ifs_are_counted_over_all_set_ups_and_runs_have_their_own_numbers() {
        let setup = FreqSetup {
            freq_hz_f: vec![1e9; 6],
            chan_width_hz_f: vec![1e6; 6],
            n_if: 2,
        };
        let mut observation = Observation {
            freq_setups: vec![setup.clone(), setup],
            ..Observation::default()
        };
        let found: Vec<_> = observation
            .windows()
            .into_iter()
            .map(|w| (w.number, w.setup, w.chans))
            .collect();
        assert_eq!(
            found,
            [(0, 0, 0..3), (1, 0, 3..6), (2, 1, 0..3), (3, 1, 3..6)]
        );
        observation.freq_setups.truncate(1);
        observation.uvh5 = Some(Uvh5Notes {
            spw_f: vec![4, 4, 2, 2, 2, 2],
            ..Uvh5Notes::default()
        });
        let found: Vec<_> = observation
            .windows()
            .into_iter()
            .map(|w| (w.number, w.chans))
            .collect();
        assert_eq!(found, [(4, 0..2), (2, 2..6)]);
    }
}
