//! How an observation is laid out in a file: decided before the first row.
//!
//! # Source
//! Memo, section 3.1.

use crate::date::{self, MJD_ZERO_JD};
use crate::fits::{CARD_BYTES, Cards};
use crate::{Corr, Frame, FreqSetup, Observation};

/// Largest number that BASELINE = 256·a1 + a2 can name.
const MAX_BASELINE_NUMBER: u32 = 255;
/// Largest whole number that every 32-bit float up to it can tell apart.
const MAX_F32_WHOLE: u32 = 1 << 24;
/// Relative to a channel: how far frequencies may be from even spacing.
const SPACING_TOLERANCE: f64 = 1e-4;

/// The layout.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// Number of each antenna in the file.
    pub(super) antenna_numbers: Vec<u32>,
    /// Whether all numbers are small enough for BASELINE.
    pub(super) has_baseline: bool,
    /// Whether rows say which field they are of.
    pub(super) has_source: bool,
    /// Whether rows say which frequency set-up they are of.
    pub(super) has_freq_sel: bool,
    /// Channels of a row, all IFs together.
    pub(super) n_chan: usize,
    /// IFs.
    pub(super) n_if: usize,
    /// First channel of the first IF of the first set-up [Hz].
    pub(super) ref_hz: f64,
    /// Frequency of the first channel and step of each IF [Hz], set-up by set-up.
    pub(super) ifs: Vec<Vec<IfBand>>,
    /// Which correlation of a chunk is written when.
    pub(super) corr_order: Vec<usize>,
    /// First code and step along STOKES.
    stokes: (i8, i8),
    /// The one frame of all fields.
    frame: Frame,
}

/// An IF of evenly spaced channels.
#[derive(Debug, Clone, Copy)]
pub(super) struct IfBand {
    pub(super) first_hz: f64,
    pub(super) step_hz: f64,
}

impl Plan {
    /// Decides; what cannot be written is told in words.
    pub(super) fn new(observation: &Observation) -> Result<Self, String> {
        let antenna_numbers = antenna_numbers(observation)?;
        let first = observation
            .freq_setups
            .first()
            .ok_or("the observation has no frequencies")?;
        let n_chan = first.freq_hz_f.len();
        let mut ifs = Vec::new();
        for setup in &observation.freq_setups {
            if (setup.n_if, setup.freq_hz_f.len()) != (first.n_if, n_chan) {
                return Err("the frequency set-ups differ in IFs or channels".into());
            }
            ifs.push(if_bands(setup)?);
        }
        let (corr_order, stokes) = corr_order(&observation.corrs)?;
        let field = observation
            .fields
            .first()
            .ok_or("the observation has no phase centre")?;
        observation.check_phased("UVFITS")?;
        if observation
            .fields
            .iter()
            .any(|other| other.frame != field.frame)
        {
            return Err(
                "the phase centres are in different frames; a UVFITS header names one".into(),
            );
        }
        Ok(Self {
            has_baseline: antenna_numbers.iter().all(|&n| n <= MAX_BASELINE_NUMBER),
            antenna_numbers,
            has_source: observation.fields.len() > 1,
            has_freq_sel: observation.freq_setups.len() > 1,
            n_chan,
            n_if: first.n_if,
            ref_hz: ifs[0][0].first_hz,
            ifs,
            corr_order,
            stokes,
            frame: field.frame,
        })
    }

    /// Names and zero points of the random parameters.
    fn parameters(&self, day_mjd: f64, has_interval: bool) -> Vec<(&'static str, f64)> {
        let mut list = vec![("UU", 0.0), ("VV", 0.0), ("WW", 0.0)];
        list.extend([("DATE", day_mjd + MJD_ZERO_JD), ("DATE", 0.0)]);
        if self.has_baseline {
            list.push(("BASELINE", 0.0));
        }
        list.extend([("ANTENNA1", 0.0), ("ANTENNA2", 0.0), ("SUBARRAY", 0.0)]);
        if self.has_source {
            list.push(("SOURCE", 0.0));
        }
        if self.has_freq_sel {
            list.push(("FREQSEL", 0.0));
        }
        if has_interval {
            list.push(("INTTIM", 0.0));
        }
        list.extend([("UU", 0.0), ("VV", 0.0), ("WW", 0.0)]);
        list
    }

    /// The primary header; returns where the value of GCOUNT starts.
    pub(super) fn primary_cards(
        &self,
        cards: &mut Cards,
        observation: &Observation,
        day_mjd: f64,
        has_interval: bool,
    ) -> usize {
        let parameters = self.parameters(day_mjd, has_interval);
        let axes = self.axes(observation);
        cards.push("SIMPLE", true, "FITS");
        cards.push("BITPIX", -32, "32-bit floating point");
        cards.push("NAXIS", axes.len() + 1, "");
        cards.push("NAXIS1", 0, "random groups, no image");
        for (number, axis) in (2..).zip(&axes) {
            cards.push(&format!("NAXIS{number}"), axis.len, "");
        }
        cards.push("EXTEND", true, "tables follow");
        cards.push("GROUPS", true, "random groups");
        cards.push("PCOUNT", parameters.len(), "parameters of a group");
        let gcount_at = cards.keywords.len() * CARD_BYTES + 10;
        cards.push("GCOUNT", 0, "groups");
        for (number, axis) in (2..).zip(&axes) {
            cards.push(&format!("CTYPE{number}"), axis.name, axis.comment);
            cards.push(&format!("CRVAL{number}"), axis.value, "");
            cards.push(&format!("CDELT{number}"), axis.step, "");
            cards.push(&format!("CRPIX{number}"), 1.0, "");
            cards.push(&format!("CROTA{number}"), 0.0, "");
        }
        for (number, (name, zero)) in (1..).zip(parameters) {
            cards.push(&format!("PTYPE{number}"), name, "");
            cards.push(&format!("PSCAL{number}"), 1.0, "");
            cards.push(&format!("PZERO{number}"), zero, "");
        }
        self.describe(cards, observation, day_mjd);
        gcount_at
    }

    /// The regular axes, fastest first.
    fn axes(&self, observation: &Observation) -> [AxisCards; 6] {
        let axis = |name, len, value, step, comment| AxisCards {
            name,
            len,
            value,
            step,
            comment,
        };
        let (first, step) = self.stokes;
        // The header of a multi-source file has no position (memo, section 3.1.3).
        let centre = match observation.fields.as_slice() {
            [field] => (field.ra_rad.to_degrees(), field.dec_rad.to_degrees()),
            _ => (0.0, 0.0),
        };
        let n_chan = self.n_chan / self.n_if;
        let step_hz = self.ifs[0][0].step_hz;
        [
            axis("COMPLEX", 3, 1.0, 1.0, "real, imaginary, weight"),
            axis(
                "STOKES",
                self.corr_order.len(),
                first.into(),
                step.into(),
                "",
            ),
            axis("FREQ", n_chan, self.ref_hz, step_hz, "Hz"),
            axis("IF", self.n_if, 1.0, 1.0, ""),
            axis("RA", 1, centre.0, 1.0, "deg"),
            axis("DEC", 1, centre.1, 1.0, "deg"),
        ]
    }

    /// The keywords that tell about the observation.
    fn describe(&self, cards: &mut Cards, observation: &Observation, day_mjd: f64) {
        let name = match observation.fields.as_slice() {
            [field] => field.name.as_str(),
            _ => "MULTI",
        };
        cards.push("OBJECT", name, "");
        cards.push("TELESCOP", observation.telescope.as_str(), "");
        cards.push("INSTRUME", observation.instrument.as_str(), "");
        cards.push("OBSERVER", observation.observer.as_str(), "");
        cards.push("DATE-OBS", reference_day(observation, day_mjd), "");
        cards.push("BSCALE", 1.0, "");
        cards.push("BZERO", 0.0, "");
        cards.push("BUNIT", "JY", "");
        let (name, equinox) = match self.frame {
            Frame::Icrs => ("ICRS", 2000.0),
            Frame::Fk5(equinox) => ("FK5", equinox),
            Frame::Fk4(equinox) => ("FK4", equinox),
        };
        cards.push("RADESYS", name, "");
        // pyuvdata knows frames in lower case only, and looks here first.
        cards.push("PHSFRAME", name.to_lowercase(), "as RADESYS, for pyuvdata");
        cards.push("EPOCH", equinox, "");
        if let [field] = observation.fields.as_slice() {
            cards.push("OBSRA", field.ra_rad.to_degrees(), "deg");
            cards.push("OBSDEC", field.dec_rad.to_degrees(), "deg");
        }
        // Readers of Miriad's family take the weights' scale from here and zero them without it.
        cards.history.push("AIPS WTSCAL = 1.0".to_owned());
        for line in observation
            .history
            .iter()
            .filter(|line| !line.contains("WTSCAL"))
        {
            cards.history.push(line.clone());
        }
    }
}

struct AxisCards {
    name: &'static str,
    len: usize,
    value: f64,
    step: f64,
    comment: &'static str,
}

/// The day that sidereal time and times in tables are counted from.
pub(super) fn reference_day(observation: &Observation, day_mjd: f64) -> String {
    date::parse_day(&observation.date_obs).unwrap_or_else(|| date::day_of_mjd(day_mjd))
}

/// The observation's own numbers where they can stand in a file, 1, 2, 3 ... otherwise.
fn antenna_numbers(observation: &Observation) -> Result<Vec<u32>, String> {
    let own: Vec<u32> = observation
        .antennas
        .iter()
        .map(|antenna| antenna.number)
        .collect();
    if own.is_empty() || own.len() > MAX_F32_WHOLE as usize {
        return Err(format!("{} antennas cannot be written", own.len()));
    }
    let mut sorted = own.clone();
    sorted.sort_unstable();
    let unique = sorted.windows(2).all(|pair| pair[0] != pair[1]);
    let in_range = sorted[0] > 0 && sorted[sorted.len() - 1] < MAX_F32_WHOLE;
    Ok(if unique && in_range {
        own
    } else {
        (1..=own.len() as u32).collect()
    })
}

/// Start and step of each IF of a set-up, which UVFITS wants evenly spaced.
fn if_bands(setup: &FreqSetup) -> Result<Vec<IfBand>, String> {
    let n_chan = setup.freq_hz_f.len();
    if setup.n_if == 0 || n_chan == 0 || !n_chan.is_multiple_of(setup.n_if) {
        return Err(format!(
            "{n_chan} channels cannot be shared among {} IFs",
            setup.n_if
        ));
    }
    if setup.chan_width_hz_f.len() != n_chan {
        return Err("a frequency set-up has other than one width a channel".into());
    }
    let per_if = n_chan / setup.n_if;
    let bands = setup
        .freq_hz_f
        .chunks(per_if)
        .zip(setup.chan_width_hz_f.chunks(per_if));
    bands
        .map(|(freq_hz, width_hz)| if_band(freq_hz, width_hz[0]))
        .collect()
}

fn if_band(freq_hz: &[f64], width_hz: f64) -> Result<IfBand, String> {
    let (first_hz, last_hz) = (freq_hz[0], freq_hz[freq_hz.len() - 1]);
    let mean_hz = (last_hz - first_hz) / (freq_hz.len() as f64 - 1.0).max(1.0);
    // The width is the spacing where it can be: it has not gone through a subtraction.
    let close =
        (mean_hz - width_hz).abs() <= SPACING_TOLERANCE * width_hz.abs() / freq_hz.len() as f64;
    let step_hz = if freq_hz.len() == 1 || close {
        width_hz
    } else {
        mean_hz
    };
    for (i, &freq) in freq_hz.iter().enumerate() {
        let even_hz = first_hz + i as f64 * step_hz;
        if !freq.is_finite() || (freq - even_hz).abs() > SPACING_TOLERANCE * step_hz.abs() {
            return Err(format!(
                "channel {} is at {freq} Hz, {even_hz} Hz would be even spacing; UVFITS can hold \
                 no other",
                i + 1
            ));
        }
    }
    Ok(IfBand { first_hz, step_hz })
}

/// The order in which codes step evenly, with the first code and the step.
fn corr_order(corrs: &[Corr]) -> Result<(Vec<usize>, (i8, i8)), String> {
    let code = |i: &usize| corrs[*i].stokes_code();
    let own: Vec<usize> = (0..corrs.len()).collect();
    let mut sorted = own.clone();
    sorted.sort_by_key(|i| code(i).abs());
    for order in [own, sorted] {
        let codes: Vec<i8> = order.iter().map(code).collect();
        match codes.as_slice() {
            [] => return Err("the observation has no correlations".into()),
            [only] => return Ok((order, (*only, if *only < 0 { -1 } else { 1 }))),
            [first, second, ..] => {
                let step = second - first;
                let even = step != 0 && codes.windows(2).all(|pair| pair[1] - pair[0] == step);
                if even {
                    return Ok((order, (*first, step)));
                }
            }
        }
    }
    Err(format!(
        "correlations {corrs:?} are no series that a STOKES axis can hold"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlations_are_ordered_into_a_series() {
        use Corr::{I, Ll, Lr, Rl, Rr, Xx, Xy, Yx, Yy};
        assert_eq!(corr_order(&[I]), Ok((vec![0], (1, 1))));
        assert_eq!(corr_order(&[Yy]), Ok((vec![0], (-6, -1))));
        assert_eq!(corr_order(&[Rr, Ll]), Ok((vec![0, 1], (-1, -1))));
        assert_eq!(corr_order(&[Ll, Rr]), Ok((vec![0, 1], (-2, 1))));
        // The order of a Measurement Set.
        assert_eq!(
            corr_order(&[Xx, Xy, Yx, Yy]),
            Ok((vec![0, 3, 1, 2], (-5, -1)))
        );
        assert!(corr_order(&[Rr, Ll, Lr]).is_err());
        assert!(corr_order(&[Rr, Rr]).is_err());
        assert!(corr_order(&[]).is_err());
        assert_eq!(corr_order(&[Rr, Rl]), Ok((vec![0, 1], (-1, -2))));
    }

    #[test]
    fn uneven_channels_are_refused() {
        let even = if_band(&[1.0e9, 1.001e9, 1.002e9], 1e6).unwrap();
        assert_eq!((even.first_hz, even.step_hz), (1e9, 1e6));
        let falling = if_band(&[1.002e9, 1.001e9], -1e6).unwrap();
        assert_eq!(falling.step_hz, -1e6);
        // Channels narrower than their spacing: the spacing counts.
        assert_eq!(if_band(&[1.0e9, 1.002e9], 1e6).unwrap().step_hz, 2e6);
        assert!(if_band(&[1.0e9, 1.001e9, 1.003e9], 1e6).is_err());
    }
}
