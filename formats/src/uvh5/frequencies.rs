//! Channels and the spectral windows that they are of.
//!
//! # Source
//! Memo, section 3.1 (freq_array, channel_width, spw_array) and 3.2 (flex_spw_id_array).

use super::axes::Axes;
use crate::h5::{Dataset, Group};
use crate::{FreqSetup, ReadError};

/// What the file says of its channels.
#[derive(Debug)]
pub(super) struct Frequencies {
    pub(super) setup: FreqSetup,
    /// Number of the spectral window of each channel.
    pub(super) spw_f: Vec<i64>,
}

impl Frequencies {
    pub(super) fn read(header: &Group, axes: &Axes) -> Result<Self, ReadError> {
        refuse_window_per_hand(header)?;
        let n_chan = axes.n_chan;
        let freq = header.need("freq_array")?;
        let freq_hz_f = per_channel(&freq, n_chan)?;
        if let Some(f) = freq_hz_f
            .iter()
            .position(|hz| !hz.is_finite() || *hz <= 0.0)
        {
            let what = format!("channel {}: {} Hz is no frequency", f + 1, freq_hz_f[f]);
            return Err(freq.malformed(what));
        }
        let spw_f = windows(header, n_chan)?;
        let mut chan_width_hz_f = widths_hz(header, n_chan)?;
        give_signs(&mut chan_width_hz_f, &freq_hz_f, &spw_f);
        let n_if = equal_windows(&spw_f);
        Ok(Self {
            setup: FreqSetup {
                freq_hz_f,
                chan_width_hz_f,
                n_if,
            },
            spw_f,
        })
    }
}

/// One value a channel, with the axis of windows in front that old files have.
fn per_channel(dataset: &Dataset, n_chan: usize) -> Result<Vec<f64>, ReadError> {
    if dataset.shape != [1, n_chan] {
        dataset.check_shape_is(&[n_chan])?;
    }
    dataset.reals()
}

/// The widths as written, all positive; one for all channels in old files.
fn widths_hz(header: &Group, n_chan: usize) -> Result<Vec<f64>, ReadError> {
    let width = header.need("channel_width")?;
    let values = if width.shape.is_empty() || width.shape == [1] {
        vec![width.real()?; n_chan]
    } else {
        per_channel(&width, n_chan)?
    };
    match values.iter().find(|hz| !hz.is_finite()) {
        Some(bad) => Err(width.malformed(format!("{bad} Hz is no width"))),
        None => Ok(values.into_iter().map(f64::abs).collect()),
    }
}

fn windows(header: &Group, n_chan: usize) -> Result<Vec<i64>, ReadError> {
    let numbers = header.need("spw_array")?.wholes()?;
    let Some(ids) = header.dataset("flex_spw_id_array")? else {
        return match numbers.as_slice() {
            [only] => Ok(vec![*only; n_chan]),
            _ => Err(header.malformed(
                "flex_spw_id_array",
                format!(
                    "is missing, but there are {} spectral windows",
                    numbers.len()
                ),
            )),
        };
    };
    ids.check_shape_is(&[n_chan])?;
    let spw_f = ids.wholes()?;
    match spw_f.iter().find(|id| !numbers.contains(id)) {
        Some(id) => Err(ids.malformed(format!("spectral window {id} is not in spw_array"))),
        None => Ok(spw_f),
    }
}

/// Windows that hold one correlation each have no place in a row of channels times correlations.
fn refuse_window_per_hand(header: &Group) -> Result<(), ReadError> {
    if header.dataset("flex_spw_polarization_array")?.is_some() {
        let what = "every spectral window has a polarization of its own, which is not read; convert \
                    with pyuvdata's remove_flex_pol";
        return Err(header.unsupported("flex_spw_polarization_array", what));
    }
    Ok(())
}

/// Widths are negative where the frequency falls within the window.
fn give_signs(width_hz_f: &mut [f64], freq_hz_f: &[f64], spw_f: &[i64]) {
    for (f, width_hz) in width_hz_f.iter_mut().enumerate() {
        let beside = [f.checked_sub(1).map(|e| (e, f)), Some((f, f + 1))];
        let mut steps = beside.into_iter().flatten();
        let step_hz = steps.find_map(|(a, b)| {
            let same = b < spw_f.len() && spw_f[a] == spw_f[b];
            same.then(|| freq_hz_f[b] - freq_hz_f[a])
        });
        if step_hz.is_some_and(|hz| hz < 0.0) {
            *width_hz = -*width_hz;
        }
    }
}

/// The number of windows if they are blocks of equal length, one after the other; 1 otherwise.
fn equal_windows(spw_f: &[i64]) -> usize {
    let starts = spw_f.windows(2).filter(|pair| pair[0] != pair[1]).count() + 1;
    let per_block = spw_f.len() / starts;
    let equal = spw_f.len().is_multiple_of(starts)
        && spw_f
            .chunks(per_block)
            .all(|block| block.iter().all(|id| *id == block[0]));
    let mut ids: Vec<i64> = spw_f.iter().step_by(per_block).copied().collect();
    ids.sort_unstable();
    ids.dedup();
    if equal && ids.len() == starts {
        starts
    } else {
        1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_of_equal_length_are_ifs() {
        assert_eq!(equal_windows(&[1, 1, 2, 2, 3, 3]), 3);
        assert_eq!(equal_windows(&[7, 7, 7]), 1);
        assert_eq!(equal_windows(&[1, 1, 2]), 1);
        assert_eq!(equal_windows(&[1, 2, 1, 2]), 1);
        assert_eq!(equal_windows(&[4]), 1);
    }

    #[test]
    fn a_falling_window_has_negative_widths() {
        let mut widths_hz = [1.0; 5];
        give_signs(
            &mut widths_hz,
            &[10.0, 9.0, 20.0, 21.0, 5.0],
            &[1, 1, 2, 2, 3],
        );
        assert_eq!(widths_hz, [-1.0, -1.0, 1.0, 1.0, 1.0]);
    }
}
