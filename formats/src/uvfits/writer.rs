//! Writing.

use std::path::Path;

use super::plan::Plan;
use super::{C_M_S, baseline, tables};
use crate::fits::{BLOCK_BYTES, Cards, PendingFile, refuse_existing};
use crate::{Observation, VisChunk, VisWriter, WriteError};

/// Writes a UVFITS file.
///
/// Rows go to a hidden file beside the target, which takes the target's name in
/// [`finish`](VisWriter::finish); dropped before, the writer leaves nothing. The number of rows need
/// not be known: GCOUNT is filled in at the end.
///
/// A flag becomes the sign of the weight. A flagged sample keeps its visibility. Where the plan of
/// correlations in [`Observation::corrs`] is no arithmetic series of codes, as the STOKES axis wants
/// it, they are written in the order of their codes.
#[derive(Debug)]
pub struct UvfitsWriter {
    file: PendingFile,
    observation: Observation,
    plan: Plan,
    /// Known from the first row on.
    started: Option<Started>,
    n_row: u64,
    row: Vec<u8>,
}

/// What the first row decides.
#[derive(Debug, Clone, Copy)]
struct Started {
    /// Where the value of GCOUNT stands in the file.
    gcount_offset: u64,
    /// The day that dates are counted from.
    day_mjd: f64,
    /// Whether rows have an integration time.
    has_interval: bool,
}

impl UvfitsWriter {
    /// Starts a file for `observation`.
    ///
    /// # Errors
    /// The target exists and `overwrite` is false, its folder cannot be written, or the
    /// observation cannot be put into a UVFITS file.
    pub fn create(
        path: &Path,
        observation: &Observation,
        overwrite: bool,
    ) -> Result<Self, WriteError> {
        refuse_existing(path, overwrite)?;
        let plan = Plan::new(observation).map_err(|what| WriteError::Parameter {
            path: path.to_owned(),
            what,
        })?;
        Ok(Self {
            file: PendingFile::create(path, overwrite)?,
            observation: observation.clone(),
            plan,
            started: None,
            n_row: 0,
            row: Vec::new(),
        })
    }

    /// Writes the header, now that the first row is known.
    fn start(&mut self, chunk: &VisChunk) -> Result<Started, WriteError> {
        let day_mjd = chunk.time_mjd_r[0].floor();
        let has_interval = chunk.interval_s_r.iter().any(|s| s.is_finite());
        let mut cards = Cards::default();
        let gcount_at =
            self.plan
                .primary_cards(&mut cards, &self.observation, day_mjd, has_interval);
        self.file.append(&cards.header())?;
        let started = Started {
            gcount_offset: gcount_at as u64,
            day_mjd,
            has_interval,
        };
        self.started = Some(started);
        Ok(started)
    }

    /// One row as a group of big-endian floats, in `self.row`.
    fn encode(&mut self, chunk: &VisChunk, row: usize, started: Started) {
        let plan = &self.plan;
        let bytes = &mut self.row;
        bytes.clear();
        let mut push = |value: f32| bytes.extend_from_slice(&value.to_be_bytes());
        let (uvw_high, uvw_low) = split3(chunk.uvw_m_r[row].map(|metres| metres / C_M_S));
        let (date_high, date_low) = split(chunk.time_mjd_r[row] - started.day_mjd);
        let ant1 = plan.antenna_numbers[chunk.ant1_r[row] as usize];
        let ant2 = plan.antenna_numbers[chunk.ant2_r[row] as usize];
        uvw_high.into_iter().for_each(&mut push);
        push(date_high);
        push(date_low);
        if plan.has_baseline {
            push(baseline::encode(ant1, ant2));
        }
        push(ant1 as f32);
        push(ant2 as f32);
        push(1.0);
        if plan.has_source {
            push((chunk.field_r[row] + 1) as f32);
        }
        if plan.has_freq_sel {
            push((chunk.freq_setup_r[row] + 1) as f32);
        }
        if started.has_interval {
            let interval_s = chunk.interval_s_r[row];
            push(if interval_s.is_finite() {
                interval_s as f32
            } else {
                0.0
            });
        }
        uvw_low.into_iter().for_each(&mut push);

        let per_row = chunk.values_per_row();
        let span = row * per_row..(row + 1) * per_row;
        let vis = chunk.vis_jy_rfp[span.clone()].chunks_exact(chunk.n_corr);
        let weights = chunk.weight_rfp[span.clone()].chunks_exact(chunk.n_corr);
        let flags = chunk.flag_rfp[span].chunks_exact(chunk.n_corr);
        for ((vis, weights), flags) in vis.zip(weights).zip(flags) {
            for &p in &plan.corr_order {
                push(vis[p].re);
                push(vis[p].im);
                push(signed_weight(weights[p], flags[p]));
            }
        }
    }

    fn parameter_error(&self, what: String) -> WriteError {
        WriteError::Parameter {
            path: self.file.path().to_owned(),
            what,
        }
    }

    /// Pads the data, fills in GCOUNT and appends the tables.
    fn complete(&mut self) -> Result<(), WriteError> {
        let Some(started) = self.started else {
            return Err(self.parameter_error("no row was written; UVFITS cannot be empty".into()));
        };
        let data_bytes = self.n_row * self.row.len() as u64;
        let padding = data_bytes.next_multiple_of(BLOCK_BYTES as u64) - data_bytes;
        self.file.append(&vec![0; padding as usize])?;
        let tables = tables::all(&self.observation, &self.plan, started.day_mjd)
            .map_err(|what| self.parameter_error(what))?;
        self.file.append(&tables)?;
        let gcount = format!("{:>20}", self.n_row);
        self.file.replace(started.gcount_offset, gcount.as_bytes())
    }
}

impl VisWriter for UvfitsWriter {
    fn write_chunk(&mut self, chunk: &VisChunk) -> Result<(), WriteError> {
        if chunk.n_row == 0 {
            return Ok(());
        }
        chunk
            .check(&self.observation, self.n_row)
            .map_err(|what| self.parameter_error(what))?;
        let started = match self.started {
            Some(started) => started,
            None => self.start(chunk)?,
        };
        for row in 0..chunk.n_row {
            self.encode(chunk, row, started);
            self.file.append(&self.row)?;
            self.n_row += 1;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        self.complete()?;
        self.file.commit()
    }
}

/// A number as a 32-bit value and the remainder that this leaves.
fn split(value: f64) -> (f32, f32) {
    let high = value as f32;
    (high, (value - f64::from(high)) as f32)
}

fn split3(values: [f64; 3]) -> ([f32; 3], [f32; 3]) {
    let parts = values.map(split);
    (parts.map(|part| part.0), parts.map(|part| part.1))
}

/// The weight with the flag in its sign; what is no number becomes 0, which is flagged.
fn signed_weight(weight: f32, flag: bool) -> f32 {
    match (weight.is_finite(), flag) {
        (false, _) => 0.0,
        (true, true) => -weight.abs(),
        (true, false) => weight,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_parts_hold_a_day_to_the_microsecond() {
        for value in [0.123_456_789_012_345, 1e-7, 3.999_999_9] {
            let (high, low) = split(value);
            assert!((f64::from(high) + f64::from(low) - value).abs() <= value * 2e-15);
        }
    }

    #[test]
    fn flags_are_signs() {
        assert_eq!(signed_weight(2.0, false), 2.0);
        assert_eq!(signed_weight(2.0, true), -2.0);
        assert_eq!(signed_weight(f32::NAN, false), 0.0);
    }
}
