//! Channel frequencies: the FREQ and IF axes and the `AIPS FQ` table.
//!
//! # Formula
//! f(if, chan) = CRVAL + IF FREQ(if) + (chan - CRPIX)·step, chan from 1; step is CH WIDTH(if), or
//! CDELT where there is no table.
//!
//! # Source
//! Memo, sections 3.1.3 and 4.7.

use std::fs::File;

use super::axes::Axes;
use crate::fits::Table;
use crate::fits::header::Header;
use crate::fits::scan::Hdu;
use crate::{FreqSetup, ReadError};

/// Most channels over all set-ups, where there are several.
const MAX_CHANNELS: usize = 4 << 20;

/// The set-ups and the FRQSEL number of each.
#[derive(Debug, Default)]
pub(super) struct Frequencies {
    pub(super) setups: Vec<FreqSetup>,
    pub(super) numbers: Vec<i64>,
}

impl Frequencies {
    /// Index of the set-up that FREQSEL names; 0 and -1 stand for the first (memo: "any").
    pub(super) fn find(&self, number: i64) -> Option<u32> {
        if number <= 0 {
            return Some(0);
        }
        self.numbers
            .iter()
            .position(|&n| n == number)
            .map(|i| i as u32)
    }

    /// Reads header and table.
    pub(super) fn read(
        file: &mut File,
        hdus: &[Hdu],
        axes: &Axes,
        warnings: &mut Vec<String>,
    ) -> Result<Self, ReadError> {
        let header = &hdus[0].header;
        let axis = Spacing::read(header, axes)?;
        if let Some(hdu) = hdus.iter().find(|hdu| hdu.is_named("AIPS FQ")) {
            return from_table(&Table::read(file, hdu)?, &axis, warnings);
        }
        if axis.n_if > 1 {
            let what = format!(
                "there are {} IFs but no AIPS FQ table with their frequencies; the file may be truncated",
                axis.n_if
            );
            return Err(header
                .place
                .malformed(&format!("NAXIS{}", axes.n_if.number), what));
        }
        if axis.step_hz.is_none() && axis.n_chan > 1 {
            let key = format!("CDELT{}", axes.freq.number);
            return Err(header.place.malformed(&key, "keyword is missing"));
        }
        let mut setup = FreqSetup {
            n_if: 1,
            ..FreqSetup::default()
        };
        axis.append_if(&mut setup, 0.0, axis.step_hz.unwrap_or(0.0));
        Ok(Self {
            setups: vec![setup],
            numbers: vec![1],
        })
    }
}

/// The FREQ axis of the header.
struct Spacing {
    n_if: usize,
    n_chan: usize,
    ref_hz: f64,
    ref_chan: f64,
    step_hz: Option<f64>,
}

impl Spacing {
    fn read(header: &Header, axes: &Axes) -> Result<Self, ReadError> {
        let number = axes.freq.number;
        let key = format!("CRVAL{number}");
        let ref_hz = header.need_real(&key)?;
        if ref_hz <= 0.0 {
            return Err(header
                .place
                .malformed(&key, format!("frequency {ref_hz} Hz is not positive")));
        }
        Ok(Self {
            n_if: axes.n_if.len,
            n_chan: axes.freq.len,
            ref_hz,
            ref_chan: header.real(&format!("CRPIX{number}"))?.unwrap_or(1.0),
            step_hz: header.real(&format!("CDELT{number}"))?,
        })
    }

    /// Appends the channels of one IF.
    fn append_if(&self, setup: &mut FreqSetup, offset_hz: f64, step_hz: f64) {
        for chan in 0..self.n_chan {
            let steps = chan as f64 + 1.0 - self.ref_chan;
            setup
                .freq_hz_f
                .push(self.ref_hz + offset_hz + steps * step_hz);
            setup.chan_width_hz_f.push(step_hz);
        }
    }

    /// The step of an IF. The table keeps it in 32 bits: where the header's CDELT is the same
    /// number before rounding, that is taken. A positive width with a lower sideband is negated
    /// (the memo's "CH WIDTH x SIDEBAND"); a negative one has its sign already.
    fn step_hz(&self, width_hz: f64, sideband: f64, warnings: &mut Vec<String>) -> f64 {
        if let Some(cdelt) = self.step_hz
            && cdelt as f32 == width_hz as f32
            && sideband >= 0.0
        {
            return cdelt;
        }
        if width_hz > 0.0 && sideband < 0.0 {
            let note = "AIPS FQ: SIDEBAND -1 with CH WIDTH > 0: frequencies are taken to fall";
            if warnings.last().is_none_or(|last| last != note) {
                warnings.push(note.to_owned());
            }
            return -width_hz;
        }
        width_hz
    }
}

fn from_table(
    table: &Table,
    axis: &Spacing,
    warnings: &mut Vec<String>,
) -> Result<Frequencies, ReadError> {
    let place = table.header.place.clone();
    let numbers = table.need_cells("FRQSEL", 1)?;
    let offsets_hz = table.need_cells("IF FREQ", axis.n_if)?;
    let widths_hz = table.need_cells("CH WIDTH", axis.n_if)?;
    let sidebands = table
        .cells("SIDEBAND")?
        .filter(|column| column.repeat >= axis.n_if);
    if table.n_row == 0 {
        return Err(place.malformed("NAXIS2", "is 0: there is no frequency set-up"));
    }
    // A short file can name many set-ups of many channels each: the product is ours to bound.
    let n_total = table.n_row.saturating_mul(axis.n_if * axis.n_chan);
    if table.n_row > 1 && n_total > MAX_CHANNELS {
        let what =
            format!("{n_total} channels in all set-ups, more than {MAX_CHANNELS} are not read");
        return Err(place.unsupported("NAXIS2", what));
    }
    let mut frequencies = Frequencies::default();
    for row in 0..table.n_row {
        let mut setup = FreqSetup {
            n_if: axis.n_if,
            ..FreqSetup::default()
        };
        for i in 0..axis.n_if {
            let sideband = sidebands.as_ref().map_or(1.0, |column| column.row(row)[i]);
            let step_hz = axis.step_hz(widths_hz.row(row)[i], sideband, warnings);
            axis.append_if(&mut setup, offsets_hz.row(row)[i], step_hz);
        }
        if let Some(bad) = setup
            .freq_hz_f
            .iter()
            .find(|f| !(f.is_finite() && **f > 0.0))
        {
            let what = format!("row {}: a channel would be at {bad} Hz", row + 1);
            return Err(place.malformed("IF FREQ", what));
        }
        frequencies.setups.push(setup);
        frequencies.numbers.push(numbers.row(row)[0] as i64);
    }
    Ok(frequencies)
}
