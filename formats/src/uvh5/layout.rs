//! How an observation is laid out in a file: decided before the first row.

use crate::{FreqSetup, Observation, Uvh5Notes};

use super::antennas::{geocentric_m, geodetic};

/// Bytes of a chunk of visibilities: what h5py and libhdf5 keep in their caches.
const CHUNK_BYTES: usize = 1 << 20;
/// Most rows of a chunk.
pub(super) const MAX_CHUNK_ROWS: usize = 1 << 13;

/// The layout.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    /// Rows and channels of a chunk; it has all correlations.
    pub(super) chunk_rows: usize,
    pub(super) chunk_chans: usize,
    /// Number of each antenna in the file.
    pub(super) antenna_numbers: Vec<i64>,
    /// Longitude, latitude [deg] and height [m] of the array.
    pub(super) geodetic: [f64; 3],
    /// The same place, geocentric [m], as readers will compute it.
    pub(super) array_m: [f64; 3],
    /// Number of the spectral window of each channel.
    pub(super) spw_f: Vec<i64>,
}

impl Layout {
    /// Decides; what cannot be written is told in words.
    pub(super) fn new(observation: &Observation) -> Result<Self, String> {
        if observation.antennas.is_empty() {
            return Err("0 antennas cannot be written".into());
        }
        if observation.fields.is_empty() {
            return Err("the observation has no phase centre".into());
        }
        if observation.corrs.is_empty() {
            return Err("the observation has no correlations".into());
        }
        let setup = match observation.freq_setups.as_slice() {
            [] => return Err("the observation has no frequencies".into()),
            [setup] => setup,
            several => {
                return Err(format!(
                    "there are {} frequency set-ups; UVH5 can hold one, of any channels",
                    several.len()
                ));
            }
        };
        let n_chan = setup.freq_hz_f.len();
        if n_chan == 0 || setup.chan_width_hz_f.len() != n_chan {
            return Err(
                "the frequency set-up has no channels, or other than one width each".into(),
            );
        }
        let (chunk_rows, chunk_chans) = chunk(n_chan, observation.corrs.len());
        let geodetic = geodetic(observation.array_or_mean_m());
        Ok(Self {
            chunk_rows,
            chunk_chans,
            antenna_numbers: antenna_numbers(observation),
            geodetic,
            array_m: geocentric_m(geodetic),
            spw_f: windows(setup, observation.uvh5.as_ref())?,
        })
    }
}

/// Whole rows, as many as a chunk may have; part of a row where one has more.
fn chunk(n_chan: usize, n_corr: usize) -> (usize, usize) {
    let chan_bytes = n_corr * size_of::<num_complex::Complex<f32>>();
    let rows = CHUNK_BYTES / (n_chan * chan_bytes);
    if rows == 0 {
        return (1, (CHUNK_BYTES / chan_bytes).clamp(1, n_chan));
    }
    (rows.min(MAX_CHUNK_ROWS), n_chan)
}

/// The observation's own numbers unless two antennas share one; 0, 1, 2 ... then.
fn antenna_numbers(observation: &Observation) -> Vec<i64> {
    let own: Vec<i64> = observation
        .antennas
        .iter()
        .map(|a| a.number.into())
        .collect();
    let mut sorted = own.clone();
    sorted.sort_unstable();
    if sorted.windows(2).all(|pair| pair[0] != pair[1]) {
        own
    } else {
        (0..own.len() as i64).collect()
    }
}

/// The windows that a UVH5 file had, or one for each IF.
fn windows(setup: &FreqSetup, notes: Option<&Uvh5Notes>) -> Result<Vec<i64>, String> {
    let n_chan = setup.freq_hz_f.len();
    if let Some(notes) = notes.filter(|notes| notes.spw_f.len() == n_chan) {
        return Ok(notes.spw_f.clone());
    }
    if setup.n_if == 0 || !n_chan.is_multiple_of(setup.n_if) {
        return Err(format!(
            "{n_chan} channels cannot be shared among {} IFs",
            setup.n_if
        ));
    }
    let per_if = n_chan / setup.n_if;
    Ok((0..n_chan).map(|f| (f / per_if + 1) as i64).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_whole_rows_of_a_megabyte() {
        assert_eq!(chunk(64, 4), (512, 64));
        assert_eq!(chunk(1, 1), (MAX_CHUNK_ROWS, 1));
        assert_eq!(chunk(1 << 16, 4), (1, 1 << 15));
    }
}
