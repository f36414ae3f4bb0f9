//! Rows of a file to blocks of Stokes I samples.

use std::sync::Arc;

use num_complex::Complex;
use vis2cat_formats::{Observation, StokesIRule, VisChunk, VisReader};

use super::{BLOCK_LEN, DatasetError};
use crate::likelihood::{Extents, VisBlock};
use crate::rime::{Extent, Instrument};
use crate::units::SPEED_OF_LIGHT;

/// Rows that are read at a time.
const CHUNK_ROWS: usize = 4096;
/// Values that a chunk may hold: wide data are read in fewer rows.
const CHUNK_VALUES: usize = 1 << 20;

/// System efficiency in the radiometer equation (Wrobel & Walker 1999).
pub(super) const SYSTEM_EFFICIENCY: f64 = 0.9;

/// Which weights the samples get.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WeightRule {
    /// The file's, multiplied by this.
    Scaled(f64),
    /// From the system equivalent flux density [Jy], channel width and integration time.
    Sefd(f64),
}

impl WeightRule {
    /// Adds a sample with its final weight.
    fn push(self, block: &mut VisBlock, uvw: [f64; 3], vis_jy: Complex<f32>, weight: f32) {
        let weight = match self {
            Self::Scaled(scale) => (f64::from(weight) * scale) as f32,
            Self::Sefd(_) => weight,
        };
        block.u.push(uvw[0]);
        block.v.push(uvw[1]);
        block.w.push(uvw[2]);
        block.weighted_re.push(weight * vis_jy.re);
        block.weighted_im.push(weight * vis_jy.im);
        block.weight.push(weight);
    }
}

/// What one Stokes I sample is made of, for whoever wants to look on.
pub(super) struct Sample {
    /// The file that it is of, from 0.
    pub(super) file: usize,
    /// Index of the row's two antennas.
    pub(super) baseline: (u32, u32),
    /// Channel.
    pub(super) chan: usize,
    /// Time stamp [MJD].
    pub(super) time_mjd: f64,
    /// Frequency [Hz], channel width [Hz], integration time [s], which is not a number where not known.
    pub(super) extent: Extent,
    /// Baseline coordinates [wavelength].
    pub(super) uvw: [f64; 3],
    /// Stokes I [Jy].
    pub(super) vis_jy: Complex<f32>,
    /// Weight before any scaling.
    pub(super) weight: f32,
    /// Half the difference of the two hands [Jy], where both are there.
    pub(super) half_difference_jy: Option<Complex<f32>>,
}

/// Looks on while a file is read.
pub(super) trait Tally {
    /// Rows have come from the file.
    fn chunk(&mut self, _chunk: &VisChunk) {}
    /// A used row of a file begins.
    fn row(&mut self, _file: usize) {}
    /// A sample is used.
    fn sample(&mut self, _sample: &Sample) {}
    /// A sample of a file is lost to flags.
    fn flagged(&mut self, _file: usize) {}
}

/// Nobody looks on.
pub(super) struct NoTally;
impl Tally for NoTally {}

/// Reads samples, block after block.
pub(super) struct Ingest {
    reader: Box<dyn VisReader>,
    rule: StokesIRule,
    /// The file that each frequency set-up is of.
    file_of_setup: Vec<u32>,
    /// What is done with the weights of each file.
    weights: Vec<WeightRule>,
    /// Terms of the instrument.
    instrument: Option<Arc<Instrument>>,
    chunk: VisChunk,
    /// Weight of each correlation, where the file's is not to be used.
    sefd_weight_p: Vec<f32>,
    /// Most samples in a block.
    pub(super) block_len: usize,
    /// Next row of the chunk.
    row: usize,
    at_end: bool,
}

impl Ingest {
    pub(super) fn new(
        reader: Box<dyn VisReader>,
        rule: StokesIRule,
        file_of_setup: Vec<u32>,
        weights: Vec<WeightRule>,
    ) -> Self {
        let observation = reader.observation();
        let n_chan = observation
            .freq_setups
            .iter()
            .map(|s| s.freq_hz_f.len())
            .max()
            .unwrap_or(1);
        let values = (n_chan * observation.corrs.len()).max(1);
        let max_row = (CHUNK_VALUES / values).clamp(1, CHUNK_ROWS);
        let chunk = VisChunk::new(max_row);
        let sefd_weight_p = vec![0.0; observation.corrs.len()];
        Self {
            sefd_weight_p,
            block_len: BLOCK_LEN + n_chan,
            reader,
            rule,
            file_of_setup,
            weights,
            instrument: None,
            chunk,
            row: 0,
            at_end: false,
        }
    }

    pub(super) fn observation(&self) -> &Observation {
        self.reader.observation()
    }

    /// Rows of the files that are done, wanted or not.
    pub(super) fn n_row(&self) -> u64 {
        self.reader.n_row_read()
    }

    pub(super) fn set_weights(&mut self, weights: Vec<WeightRule>) {
        self.weights = weights;
    }

    pub(super) fn set_instrument(&mut self, instrument: Option<Arc<Instrument>>) {
        self.instrument = instrument;
    }

    pub(super) fn rewind(&mut self) -> Result<(), DatasetError> {
        self.reader.rewind()?;
        self.chunk.clear(0, 0);
        (self.row, self.at_end) = (0, false);
        Ok(())
    }

    /// The next blocks, none at the end. A row is never split, so a block holds at least
    /// [`BLOCK_LEN`] samples (the last one fewer) and at most one row more.
    pub(super) fn next_block(
        &mut self,
        tally: &mut impl Tally,
    ) -> Result<Option<VisBlock>, DatasetError> {
        let mut block = VisBlock::with_capacity(self.block_len);
        block.extents = Extents::of(self.instrument.clone());
        while block.len() < BLOCK_LEN && !self.at_end {
            if self.row == self.chunk.n_row {
                self.row = 0;
                let n = self.reader.read_chunk(&mut self.chunk)?;
                self.at_end = n == 0;
                tally.chunk(&self.chunk);
            } else {
                self.take_row(&mut block, tally);
                self.row += 1;
            }
        }
        Ok(if block.is_empty() { None } else { Some(block) })
    }

    fn take_row(&mut self, block: &mut VisBlock, tally: &mut impl Tally) {
        let (chunk, r) = (&self.chunk, self.row);
        let baseline = (chunk.ant1_r[r], chunk.ant2_r[r]);
        if baseline.0 == baseline.1 {
            return;
        }
        let file = self.file_of_setup[chunk.freq_setup_r[r] as usize] as usize;
        let weights = self.weights[file];
        tally.row(file);
        let observation = self.reader.observation();
        let setup = &observation.freq_setups[chunk.freq_setup_r[r] as usize];
        let (uvw_m, interval_s) = (chunk.uvw_m_r[r], chunk.interval_s_r[r]);
        for chan in 0..chunk.n_chan {
            let first = (r * chunk.n_chan + chan) * chunk.n_corr;
            let range = first..first + chunk.n_corr;
            let weight_p = match weights {
                WeightRule::Scaled(_) => &chunk.weight_rfp[range.clone()],
                WeightRule::Sefd(sefd_jy) => {
                    let bandwidth_hz = setup.chan_width_hz_f[chan];
                    let weight = sefd_weight(self.rule, sefd_jy, bandwidth_hz, interval_s);
                    self.sefd_weight_p.fill(weight);
                    &self.sefd_weight_p
                }
            };
            let (vis_jy_p, flag_p) = (&chunk.vis_jy_rfp[range.clone()], &chunk.flag_rfp[range]);
            let Some((vis_jy, weight)) = self.rule.apply(vis_jy_p, weight_p, flag_p) else {
                tally.flagged(file);
                continue;
            };
            let half_difference = self.rule.half_difference(vis_jy_p, weight_p, flag_p);
            let freq_hz = setup.freq_hz_f[chan];
            let uvw = uvw_m.map(|metres| metres * freq_hz / SPEED_OF_LIGHT);
            let extent = Extent {
                freq_hz,
                width_hz: setup.chan_width_hz_f[chan].abs(),
                interval_s,
            };
            tally.sample(&Sample {
                file,
                baseline,
                chan,
                time_mjd: chunk.time_mjd_r[r],
                extent,
                uvw,
                vis_jy,
                weight,
                half_difference_jy: half_difference.map(|(difference_jy, _)| difference_jy),
            });
            weights.push(block, uvw, vis_jy, weight);
            block.extents.push(extent);
        }
    }
}

/// Weight of a correlation [Jy⁻²] by the radiometer equation (Wrobel & Walker 1999); Stokes I in
/// the file is made of two hands.
fn sefd_weight(rule: StokesIRule, sefd_jy: f64, bandwidth_hz: f64, interval_s: f64) -> f32 {
    let n_hand = if matches!(rule, StokesIRule::Direct(_)) {
        2.0
    } else {
        1.0
    };
    let n_independent = 2.0 * bandwidth_hz.abs() * interval_s;
    (n_hand * n_independent * (SYSTEM_EFFICIENCY / sefd_jy).powi(2)) as f32
}
