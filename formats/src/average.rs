//! Averages over times and channels: a reader of fewer, longer, wider samples than another has.
//!
//! # Formula
//! Of the unflagged samples i of a baseline, correlation, run of times and run of channels:
//!
//! ```text
//! V = Σ w_i V_i / Σ w_i      w = Σ w_i
//! ```
//!
//! so that weights stay inverse variances. What has no unflagged sample is flagged. (u, v, w) is the
//! mean over the rows with the weights that their samples have in sum, so that to first order a source
//! keeps its phase where part of the data are flagged; a row's time is the middle of the rows that it
//! is made of, flagged or not, and its integration time the sum of theirs. A channel's frequency is the
//! mean of its channels', flagged or not, since all rows share it.
//!
//! # Which rows belong together
//! Time is divided into steps from the start of the first row on. Rows of a baseline, field and
//! frequency set-up whose middle lies in the same step are one. Only the sums of one step are held:
//! those of every baseline where rows come time after time, of one baseline where they come baseline
//! after baseline. Rows of a step that come back after those of another make a row of their own:
//! nothing is lost, but less averaged.

use std::collections::HashMap;
use std::path::Path;

use num_complex::Complex;

use crate::chunk::RowHead;
use crate::{FreqSetup, Observation, ReadError, VisChunk, VisReader};

const DAY_S: f64 = 86_400.0;

/// How much is averaged; by default nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Averaging {
    /// Length of the steps of time [s].
    pub time_s: Option<f64>,
    /// Channels that become one.
    pub channels: Option<usize>,
}

impl Averaging {
    /// Whether nothing is averaged.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// Reads what another reader reads, averaged. `n_row` of its observation is that before averaging.
pub struct Averaged {
    inner: Box<dyn VisReader>,
    observation: Observation,
    time_s: Option<f64>,
    n_chan: usize,
    chunk: VisChunk,
    /// Next row of the chunk.
    row: usize,
    /// Where the steps of time begin [MJD].
    start_mjd: Option<f64>,
    /// The step that the sums are of.
    step: i64,
    /// Rows taken so far.
    n_row: i64,
    sums: Vec<Sum>,
    /// Place of a baseline, field and set-up in the sums.
    places: HashMap<(u32, u32, u32, u32), usize>,
    /// The next sum to be handed out, while that is done.
    handed_out: Option<usize>,
}

impl Averaged {
    /// Averages; `path` is for errors.
    ///
    /// # Errors
    /// The channels of a spectral window cannot be shared out evenly, or the step of time is no
    /// positive number.
    pub fn new(
        path: &Path,
        inner: Box<dyn VisReader>,
        averaging: &Averaging,
    ) -> Result<Self, ReadError> {
        let mut observation = inner.observation().clone();
        let n_chan = averaging.channels.unwrap_or(1);
        let is_step = averaging.time_s.is_none_or(|s| s.is_finite() && s > 0.0);
        let checked = if is_step {
            average_channels(&mut observation, n_chan)
        } else {
            Err("the step of time must be positive".to_owned())
        };
        checked.map_err(|what| ReadError::Unsupported {
            path: path.to_owned(),
            place: "averaging".to_owned(),
            what,
        })?;
        Ok(Self {
            inner,
            observation,
            time_s: averaging.time_s,
            n_chan,
            chunk: VisChunk::new(1),
            row: 0,
            start_mjd: None,
            step: 0,
            n_row: 0,
            sums: Vec::new(),
            places: HashMap::new(),
            handed_out: None,
        })
    }

    fn clear(&self, out: &mut VisChunk) {
        let n_chan = self.observation.freq_setups[0].freq_hz_f.len();
        out.clear(n_chan, self.observation.corrs.len());
    }

    fn refill(&mut self, max_row: usize) -> Result<bool, ReadError> {
        self.row = 0;
        (self.chunk).take_at_most(max_row, self.inner.observation());
        let n = self.inner.read_chunk(&mut self.chunk)?;
        let warnings = &self.inner.observation().warnings;
        self.observation.warnings.clone_from(warnings);
        Ok(n > 0)
    }

    /// The step of time that the next row is of; without steps every row is one.
    fn step(&mut self) -> i64 {
        let Some(step_s) = self.time_s else {
            return self.n_row;
        };
        let time_mjd = self.chunk.time_mjd_r[self.row];
        let half_s = 0.5 * known_s(self.chunk.interval_s_r[self.row]);
        let start_mjd = *self.start_mjd.get_or_insert(time_mjd - half_s / DAY_S);
        ((time_mjd - start_mjd) * DAY_S / step_s).floor() as i64
    }

    /// Adds the next row to its sum.
    fn add_row(&mut self) {
        let (chunk, row) = (&self.chunk, self.row);
        let head = chunk.head(row);
        let key = (head.ants[0], head.ants[1], head.field, head.freq_setup);
        let place = *self.places.entry(key).or_insert(self.sums.len());
        if place == self.sums.len() {
            let n_value = chunk.n_chan / self.n_chan * chunk.n_corr;
            self.sums.push(Sum::new(head, n_value));
        }
        self.sums[place].add(chunk, row, self.n_chan);
        self.row += 1;
        self.n_row += 1;
    }

    /// Hands out sums from `next` on, as many as there is room for and that have as many channels;
    /// false where there is no room.
    fn hand_out(&mut self, mut next: usize, out: &mut VisChunk) -> bool {
        let n_corr = self.observation.corrs.len();
        while out.n_row < out.max_row.max(1) && next < self.sums.len() {
            let n_chan = self.sums[next].weight_fp.len() / n_corr;
            if out.n_row == 0 {
                out.clear(n_chan, n_corr);
            } else if n_chan != out.n_chan {
                break;
            }
            self.sums[next].append_to(out);
            next += 1;
        }
        let are_all = next == self.sums.len();
        self.handed_out = (!are_all).then_some(next);
        if are_all {
            self.sums.clear();
            self.places.clear();
        }
        are_all
    }

    fn fill(&mut self, out: &mut VisChunk) -> Result<(), ReadError> {
        let max_row = out.max_row.max(1);
        while out.n_row < max_row {
            if let Some(next) = self.handed_out {
                if !self.hand_out(next, out) {
                    break;
                }
            } else if self.row == self.chunk.n_row {
                let is_end = !self.refill(max_row)?;
                if is_end && self.sums.is_empty() {
                    break;
                }
                self.handed_out = is_end.then_some(0);
            } else {
                let step = self.step();
                if step != self.step && !self.sums.is_empty() {
                    self.handed_out = Some(0);
                } else {
                    self.step = step;
                    self.add_row();
                }
            }
        }
        Ok(())
    }
}

impl VisReader for Averaged {
    fn observation(&self) -> &Observation {
        &self.observation
    }

    fn read_chunk(&mut self, chunk: &mut VisChunk) -> Result<usize, ReadError> {
        self.clear(chunk);
        if let Err(error) = self.fill(chunk) {
            self.clear(chunk);
            return Err(error);
        }
        Ok(chunk.n_row)
    }

    fn rewind(&mut self) -> Result<(), ReadError> {
        self.chunk.clear(0, 0);
        (self.row, self.n_row) = (0, 0);
        self.start_mjd = None;
        self.handed_out = None;
        self.sums.clear();
        self.places.clear();
        self.inner.rewind()
    }

    fn n_row_read(&self) -> u64 {
        self.inner.n_row_read()
    }
}

fn known_s(interval_s: f64) -> f64 {
    if interval_s.is_finite() {
        interval_s
    } else {
        0.0
    }
}

/// The channels that will be handed out.
fn average_channels(observation: &mut Observation, n: usize) -> Result<(), String> {
    for window in observation.windows() {
        let len = window.chans.len();
        if n == 0 || !len.is_multiple_of(n) {
            return Err(format!(
                "the {len} channels of spectral window {} cannot be averaged by {n}: take a number \
                 that divides them, or select some of them first",
                window.number
            ));
        }
    }
    for setup in &mut observation.freq_setups {
        let FreqSetup {
            freq_hz_f,
            chan_width_hz_f,
            ..
        } = setup;
        let mean = |run: &[f64]| run.iter().sum::<f64>() / n as f64;
        *freq_hz_f = freq_hz_f.chunks_exact(n).map(mean).collect();
        let widths = chan_width_hz_f.chunks_exact(n);
        *chan_width_hz_f = widths.map(|run| run.iter().sum()).collect();
    }
    if let Some(notes) = &mut observation.uvh5 {
        notes.spw_f = notes.spw_f.iter().copied().step_by(n).collect();
    }
    Ok(())
}

/// What rows that become one are in sum.
struct Sum {
    head: RowHead,
    /// Of the rows' weights times (u, v, w), and plain where all is flagged.
    weighted_uvw_m: [f64; 3],
    plain_uvw_m: [f64; 3],
    weight: f64,
    n_row: u32,
    start_mjd: f64,
    end_mjd: f64,
    interval_s: f64,
    weighted_vis_fp: Vec<Complex<f32>>,
    weight_fp: Vec<f32>,
}

impl Sum {
    /// Nothing, for rows like `head`.
    fn new(head: RowHead, n_value: usize) -> Self {
        Self {
            head,
            weighted_uvw_m: [0.0; 3],
            plain_uvw_m: [0.0; 3],
            weight: 0.0,
            n_row: 0,
            start_mjd: f64::INFINITY,
            end_mjd: f64::NEG_INFINITY,
            interval_s: 0.0,
            weighted_vis_fp: vec![Complex::default(); n_value],
            weight_fp: vec![0.0; n_value],
        }
    }

    fn add(&mut self, chunk: &VisChunk, row: usize, n: usize) {
        let head = chunk.head(row);
        let n_corr = chunk.n_corr;
        let first = row * chunk.values_per_row();
        let mut row_weight = 0.0;
        for f in 0..chunk.n_chan {
            for p in 0..n_corr {
                let (from, to) = (first + f * n_corr + p, f / n * n_corr + p);
                if chunk.flag_rfp[from] {
                    continue;
                }
                let weight = chunk.weight_rfp[from];
                self.weighted_vis_fp[to] += chunk.vis_jy_rfp[from] * weight;
                self.weight_fp[to] += weight;
                row_weight += f64::from(weight);
            }
        }
        for (d, x_m) in head.uvw_m.into_iter().enumerate() {
            self.weighted_uvw_m[d] += row_weight * x_m;
            self.plain_uvw_m[d] += x_m;
        }
        self.weight += row_weight;
        self.n_row += 1;
        let half_day = 0.5 * known_s(head.interval_s) / DAY_S;
        self.start_mjd = self.start_mjd.min(head.time_mjd - half_day);
        self.end_mjd = self.end_mjd.max(head.time_mjd + half_day);
        self.interval_s += head.interval_s;
    }

    fn append_to(&self, out: &mut VisChunk) {
        let mut head = self.head;
        if self.n_row > 1 {
            head.uvw_m = if self.weight > 0.0 {
                self.weighted_uvw_m.map(|x| x / self.weight)
            } else {
                self.plain_uvw_m.map(|x| x / f64::from(self.n_row))
            };
            head.time_mjd = 0.5 * (self.start_mjd + self.end_mjd);
            head.interval_s = self.interval_s;
        }
        out.push(&head);
        out.n_row += 1;
        for (vis, &weight) in self.weighted_vis_fp.iter().zip(&self.weight_fp) {
            let mean = vis / weight;
            let good = weight > 0.0 && mean.is_finite();
            out.vis_jy_rfp
                .push(if good { mean } else { Complex::default() });
            out.weight_rfp.push(if good { weight } else { 0.0 });
            out.flag_rfp.push(!good);
        }
    }
}
