//! Writing.

use std::ops::Range;
use std::path::Path;

use super::layout::Layout;
use super::tables::{self, Parts, seconds};
use crate::casa::{NewTable, Value};
use crate::pending::refuse_existing;
use crate::pending_dir::PendingDir;
use crate::{Observation, TimeScale, VisChunk, VisWriter, WriteError};

/// What stands in `table.info`: how casacore's own programs know a Measurement Set.
const INFO: &str = "Type = Measurement Set\nSubType = \n\nwritten by vis2cat\n";

/// Writes a Measurement Set.
///
/// Rows go to a hidden directory beside the target, which takes the target's name in
/// [`finish`](VisWriter::finish); dropped before, the writer leaves nothing. The number of rows need
/// not be known. Rows are gathered to whole tiles, so that the tables do not depend on the sizes in
/// which they came. Where there are several spectral windows, each block of rows is written window
/// after window.
#[derive(Debug)]
pub struct MsWriter {
    // Closed before its directory goes.
    main: Option<NewTable>,
    pending: PendingDir,
    observation: Observation,
    layout: Layout,
    /// Rows that are not written yet.
    gathered: VisChunk,
    n_row: u64,
    span_s: [f64; 2],
}

impl MsWriter {
    /// Starts a set for `observation`.
    ///
    /// # Errors
    /// The target exists and `overwrite` is false, its folder cannot be written, or the
    /// observation cannot be put into a Measurement Set.
    pub fn create(
        path: &Path,
        observation: &Observation,
        overwrite: bool,
    ) -> Result<Self, WriteError> {
        refuse_existing(path, overwrite)?;
        let layout = Layout::new(observation).map_err(|what| WriteError::Parameter {
            path: path.to_owned(),
            what,
        })?;
        let mut gathered = VisChunk::new(layout.block_rows);
        let n_chan = layout.windows.iter().map(Range::len).sum();
        gathered.clear(n_chan, observation.corrs.len());
        Ok(Self {
            main: None,
            pending: PendingDir::create(path, overwrite)?,
            observation: observation.clone(),
            layout,
            gathered,
            n_row: 0,
            span_s: [f64::INFINITY, f64::NEG_INFINITY],
        })
    }

    fn scale(&self) -> &'static str {
        match self.observation.time_scale {
            TimeScale::Tai => "TAI",
            TimeScale::Utc | TimeScale::Other => "UTC",
        }
    }

    /// Writes the rows gathered. The first time the main table is made: its tiles are as high as a
    /// block or, in a set of fewer rows, as the set.
    fn flush(&mut self) -> Result<(), String> {
        let scale = self.scale();
        let rows = &self.gathered;
        let main = match &mut self.main {
            Some(main) => main,
            empty => {
                let tile = self.layout.tile(rows.n_row);
                let root = self.pending.temp_path();
                empty.insert(tables::main(&root, &self.layout, scale, tile)?)
            }
        };
        for window in 0..self.layout.windows.len() {
            let first = main.add_rows(rows.n_row)?;
            write_heads(main, first, rows)?;
            let setups = rows.freq_setup_r.iter();
            let descriptions: Vec<i32> = setups
                .map(|&setup| self.layout.description(setup as usize, window) as i32)
                .collect();
            main.put_range("DATA_DESC_ID", first, &descriptions)?;
            write_samples(main, first, rows, &self.layout, window)?;
        }
        for &mjd in &rows.time_mjd_r {
            let time_s = seconds(mjd);
            self.span_s = [self.span_s[0].min(time_s), self.span_s[1].max(time_s)];
        }
        let (n_chan, n_corr) = (rows.n_chan, rows.n_corr);
        self.gathered.clear(n_chan, n_corr);
        Ok(())
    }

    /// Writes what is left, and the subtables, and closes all.
    fn complete(&mut self) -> Result<(), String> {
        if self.gathered.n_row > 0 {
            self.flush()?;
        }
        let root = self.pending.temp_path();
        let parts = Parts {
            root: &root,
            observation: &self.observation,
            layout: &self.layout,
            scale: self.scale(),
            span_s: self.span_s,
        };
        if let Some(mut main) = self.main.take() {
            parts.write(&mut main)?;
        }
        std::fs::write(root.join("table.info"), INFO).map_err(|e| e.to_string())
    }

    fn casacore_error(&self, what: String) -> WriteError {
        WriteError::Io {
            path: self.pending.path().to_owned(),
            source: std::io::Error::other(what),
        }
    }
}

impl VisWriter for MsWriter {
    fn write_chunk(&mut self, chunk: &VisChunk) -> Result<(), WriteError> {
        let before = self.n_row;
        (chunk.check(&self.observation, before)).map_err(|what| WriteError::Parameter {
            path: self.pending.path().to_owned(),
            what,
        })?;
        let mut from = 0;
        while from < chunk.n_row {
            let room = self.layout.block_rows - self.gathered.n_row;
            let to = (from + room).min(chunk.n_row);
            self.gathered.append(chunk, from, to);
            from = to;
            if self.gathered.n_row == self.layout.block_rows {
                self.flush().map_err(|what| self.casacore_error(what))?;
            }
        }
        self.n_row += chunk.n_row as u64;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        if self.n_row == 0 {
            return Err(WriteError::Parameter {
                path: self.pending.path().to_owned(),
                what: "no row was written; a Measurement Set cannot be empty".into(),
            });
        }
        self.complete().map_err(|what| self.casacore_error(what))?;
        self.pending.commit()
    }
}

/// What rows say besides their samples.
fn write_heads(main: &mut NewTable, first: u64, rows: &VisChunk) -> Result<(), String> {
    let wholes = |values: &[u32]| -> Vec<i32> { values.iter().map(|&i| i as i32).collect() };
    let time_s: Vec<f64> = rows.time_mjd_r.iter().map(|&mjd| seconds(mjd)).collect();
    // Tables have no way to say that a time is not known but zero.
    let known = |s: &f64| if s.is_finite() { *s } else { 0.0 };
    let interval_s: Vec<f64> = rows.interval_s_r.iter().map(known).collect();
    let uvw_m = rows.uvw_m_r.iter().flatten().copied().collect();
    main.put_vectors("UVW", first, uvw_m, 3)?;
    main.put_range("ANTENNA1", first, &wholes(&rows.ant1_r))?;
    main.put_range("ANTENNA2", first, &wholes(&rows.ant2_r))?;
    main.put_range("FIELD_ID", first, &wholes(&rows.field_r))?;
    main.put_range("TIME", first, &time_s)?;
    main.put_range("TIME_CENTROID", first, &time_s)?;
    main.put_range("EXPOSURE", first, &interval_s)?;
    main.put_range("INTERVAL", first, &interval_s)?;
    main.put_range("SCAN_NUMBER", first, &vec![1; rows.n_row])?;
    // There is nothing in PROCESSOR and STATE.
    main.put_range("PROCESSOR_ID", first, &vec![-1; rows.n_row])?;
    main.put_range("STATE_ID", first, &vec![-1; rows.n_row])
}

/// The samples of a spectral window.
fn write_samples(
    main: &mut NewTable,
    first: u64,
    rows: &VisChunk,
    layout: &Layout,
    window: usize,
) -> Result<(), String> {
    let chans = layout.windows[window].clone();
    let order = &layout.corr_order;
    let shape = (chans.len(), order.len());
    let cut = Cut {
        n_chan: rows.n_chan,
        chans,
        order,
    };
    let vis = cut.take(&rows.vis_jy_rfp);
    let weights = cut.take(&rows.weight_rfp);
    let flags = cut.take(&rows.flag_rfp);
    let per_row = shape.0 * shape.1;
    let all_bad: Vec<bool> = (flags.chunks_exact(per_row))
        .map(|flags| flags.iter().all(|&bad| bad))
        .collect();
    let mut means = Vec::with_capacity(rows.n_row * shape.1);
    for (weights, flags) in weights
        .chunks_exact(per_row)
        .zip(flags.chunks_exact(per_row))
    {
        means.extend((0..shape.1).map(|p| mean_weight(weights, flags, p, shape.1)));
    }
    let sigma = |weight: &f32| {
        if *weight > 0.0 {
            weight.sqrt().recip()
        } else {
            0.0
        }
    };
    main.put_vectors("SIGMA", first, means.iter().map(sigma).collect(), shape.1)?;
    main.put_vectors("WEIGHT", first, means, shape.1)?;
    main.put_range("FLAG_ROW", first, &all_bad)?;
    main.put_matrices("DATA", first, vis, shape)?;
    main.put_matrices("WEIGHT_SPECTRUM", first, weights, shape)?;
    main.put_matrices("FLAG", first, flags, shape)
}

/// Mean weight of the good channels of a correlation, as CASA has it for a channel; 0 where all are bad.
fn mean_weight(weights: &[f32], flags: &[bool], corr: usize, n_corr: usize) -> f32 {
    let channels = weights.iter().zip(flags).skip(corr).step_by(n_corr);
    let good = channels.filter(|(_, bad)| !**bad);
    let (sum, count) = good.fold((0.0, 0u32), |(sum, n), (w, _)| (sum + f64::from(*w), n + 1));
    (sum / f64::from(count.max(1))) as f32
}

/// Some channels of all rows, with the correlations in another order.
struct Cut<'a> {
    n_chan: usize,
    chans: Range<usize>,
    order: &'a [usize],
}

impl Cut<'_> {
    fn take<T: Value>(&self, values: &[T]) -> Vec<T> {
        let n_corr = self.order.len();
        let mut taken = Vec::with_capacity(values.len() / self.n_chan * self.chans.len());
        for row in values.chunks_exact(self.n_chan * n_corr) {
            let part = &row[self.chans.start * n_corr..self.chans.end * n_corr];
            for channel in part.chunks_exact(n_corr) {
                taken.extend(self.order.iter().map(|&p| channel[p]));
            }
        }
        taken
    }
}
