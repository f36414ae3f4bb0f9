//! What is in a visibility file, counted in one pass.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::Serialize;
use vis2cat_formats::{Observation, ReadOptions, VisChunk, stokes_i};

use super::DatasetError;
use super::ingest::{Ingest, Sample, Tally, WeightRule};
use super::noise::{NoiseReport, NoiseTally};
use crate::config::NoiseSource;

/// Counts over a whole file.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Overview {
    /// Rows (baseline times time).
    pub n_row: u64,
    /// Rows of an antenna with itself.
    pub n_row_auto: u64,
    /// Distinct pairs of antennas, autocorrelations included.
    pub n_baseline: usize,
    /// Antennas that occur in a row.
    pub n_antenna_used: usize,
    /// Distinct time stamps.
    pub n_time: usize,
    /// First time stamp [MJD].
    pub first_mjd: f64,
    /// Last time stamp [MJD].
    pub last_mjd: f64,
    /// Most frequent integration time [s].
    pub interval_s: f64,
    /// Longest baseline [m].
    pub max_baseline_m: f64,
    /// Values: rows times channels times correlations.
    pub n_value: u64,
    /// Values that are flagged.
    pub n_flagged: u64,
    /// Noise of a Stokes I sample, where there is Stokes I.
    pub noise: Option<NoiseReport>,
    /// What the rows have in common.
    pub observation: Observation,
}

impl Overview {
    /// Counts; `progress` is told the rows done and in all.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(
        path: &Path,
        options: &ReadOptions,
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Self, DatasetError> {
        let mut reader = vis2cat_formats::open_with(path, options)?;
        let n_row = reader.observation().n_row;
        let mut counts = Counts::default();
        let observation;
        if let Ok(rule) = stokes_i(&reader.observation().corrs) {
            let files = vec![0; reader.observation().freq_setups.len()];
            let mut ingest = Ingest::new(reader, rule, files, vec![WeightRule::Scaled(1.0)]);
            while ingest.next_block(&mut counts)?.is_some() {
                progress(ingest.n_row(), n_row);
            }
            observation = ingest.observation().clone();
        } else {
            let mut chunk = VisChunk::new(4096);
            while reader.read_chunk(&mut chunk)? > 0 {
                counts.chunk(&chunk);
                progress(reader.n_row_read(), n_row);
            }
            observation = reader.observation().clone();
        }
        Ok(Self {
            observation,
            ..counts.finish()
        })
    }
}

/// The counts on their way.
#[derive(Default)]
struct Counts {
    overview: Overview,
    baselines: BTreeSet<(u32, u32)>,
    /// Time stamps to the microsecond.
    times_us: BTreeSet<i64>,
    intervals_us: BTreeMap<i64, u64>,
    noise: NoiseTally,
    n_sample: u64,
}

impl Tally for Counts {
    fn chunk(&mut self, chunk: &VisChunk) {
        let counts = &mut self.overview;
        counts.n_row += chunk.n_row as u64;
        counts.n_value += chunk.flag_rfp.len() as u64;
        counts.n_flagged += chunk.flag_rfp.iter().filter(|flag| **flag).count() as u64;
        for r in 0..chunk.n_row {
            let pair = (chunk.ant1_r[r], chunk.ant2_r[r]);
            counts.n_row_auto += u64::from(pair.0 == pair.1);
            self.baselines
                .insert((pair.0.min(pair.1), pair.0.max(pair.1)));
            self.times_us
                .insert((chunk.time_mjd_r[r] * 86400e6).round() as i64);
            let interval_s = chunk.interval_s_r[r];
            if interval_s.is_finite() {
                *self
                    .intervals_us
                    .entry((interval_s * 1e6).round() as i64)
                    .or_default() += 1;
            }
            let [u, v, w] = chunk.uvw_m_r[r];
            let length_m = (u * u + v * v + w * w).sqrt();
            counts.max_baseline_m = counts.max_baseline_m.max(length_m);
        }
    }

    fn sample(&mut self, sample: &Sample) {
        self.n_sample += 1;
        self.noise.sample(sample);
    }
}

impl Counts {
    fn finish(self) -> Overview {
        let antennas: BTreeSet<u32> = self.baselines.iter().flat_map(|(a, b)| [*a, *b]).collect();
        let mjd = |us: Option<&i64>| us.map_or(f64::NAN, |us| *us as f64 / 86400e6);
        let interval = self.intervals_us.iter().max_by_key(|(_, count)| **count);
        Overview {
            n_baseline: self.baselines.len(),
            n_antenna_used: antennas.len(),
            n_time: self.times_us.len(),
            first_mjd: mjd(self.times_us.first()),
            last_mjd: mjd(self.times_us.last()),
            interval_s: interval.map_or(f64::NAN, |(us, _)| *us as f64 / 1e6),
            noise: (self.n_sample > 0).then(|| self.noise.report(NoiseSource::Auto)),
            ..self.overview
        }
    }
}
