//! Part of a file: a reader that leaves out what is not wanted of another.

mod choose;

use std::path::Path;

use crate::{Corr, Observation, ReadError, StokesIRule, VisChunk, VisReader, stokes_i};
use choose::{Cut, Rows};

/// What is wanted; by default everything.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Selection {
    /// Name or number (from 0) of the field.
    pub field: Option<String>,
    /// Numbers of the spectral windows, as [`Observation::windows`] has them; none = all.
    pub spws: Vec<i64>,
    /// First and last channel of each window, from 0.
    pub channels: Option<[usize; 2]>,
    /// First and last time [MJD], in the scale of the file; the middle of a row counts.
    pub times_mjd: Option<[f64; 2]>,
    /// Pairs of antennas, or antennas with all others, by name or number; none = all.
    pub baselines: Vec<(String, Option<String>)>,
    /// No autocorrelations.
    pub cross_only: bool,
    /// Stokes I instead of the correlations: see [`stokes_i`].
    pub stokes_i: bool,
}

impl Selection {
    /// Whether everything is wanted.
    pub fn is_all(&self) -> bool {
        *self == Self::default()
    }
}

/// Reads the selected part of what another reader reads.
///
/// Fields and frequency set-ups without a wanted row or channel are left out of the observation;
/// its `n_row` is that of the file, since only reading tells how many rows are wanted. Antennas stay,
/// with or without data.
pub struct Selected {
    inner: Box<dyn VisReader>,
    observation: Observation,
    rows: Rows,
    /// What stays of each set-up of the file.
    cuts: Vec<Option<Cut>>,
    stokes_i: Option<StokesIRule>,
    chunk: VisChunk,
    /// Next row of the chunk.
    row: usize,
}

impl Selected {
    /// Selects; `path` is for errors.
    ///
    /// # Errors
    /// What is wanted is not there; the error says what is.
    pub fn new(
        path: &Path,
        inner: Box<dyn VisReader>,
        selection: &Selection,
    ) -> Result<Self, ReadError> {
        let error = |what: String| ReadError::Unsupported {
            path: path.to_owned(),
            place: "selection".to_owned(),
            what,
        };
        let mut observation = inner.observation().clone();
        let rows = Rows::choose(&mut observation, selection).map_err(error)?;
        let cuts = choose::cuts(&mut observation, selection).map_err(error)?;
        let mut rule = None;
        if selection.stokes_i {
            rule = Some(stokes_i(&observation.corrs).map_err(|e| error(e.to_string()))?);
            observation.corrs = vec![Corr::I];
        }
        Ok(Self {
            inner,
            observation,
            rows,
            cuts,
            stokes_i: rule,
            chunk: VisChunk::new(1),
            row: 0,
        })
    }

    fn clear(&self, out: &mut VisChunk) {
        let n_chan = self.observation.freq_setups[0].freq_hz_f.len();
        out.clear(n_chan, self.observation.corrs.len());
    }

    /// Reads on where all rows of the chunk are done; false at the end.
    fn refill(&mut self, max_row: usize) -> Result<bool, ReadError> {
        self.row = 0;
        (self.chunk).take_at_most(max_row, self.inner.observation());
        let n = self.inner.read_chunk(&mut self.chunk)?;
        // Some warnings come only with the last rows.
        let warnings = &self.inner.observation().warnings;
        self.observation.warnings.clone_from(warnings);
        Ok(n > 0)
    }

    /// As many wanted rows as there is room for and that have the same number of channels.
    fn fill(&mut self, out: &mut VisChunk) -> Result<(), ReadError> {
        while out.n_row < out.max_row.max(1) {
            if self.row == self.chunk.n_row {
                if !self.refill(out.max_row.max(1))? {
                    break;
                }
                continue;
            }
            let setup = self.chunk.freq_setup_r[self.row] as usize;
            if let (Some(cut), true) = (&self.cuts[setup], self.rows.has(&self.chunk, self.row)) {
                if out.n_row == 0 {
                    out.clear(cut.chans.len(), self.observation.corrs.len());
                } else if cut.chans.len() != out.n_chan {
                    break;
                }
                self.append(cut, out);
            }
            self.row += 1;
        }
        Ok(())
    }

    /// Appends the row to a chunk of its shape.
    fn append(&self, cut: &Cut, out: &mut VisChunk) {
        let (chunk, row) = (&self.chunk, self.row);
        let mut head = chunk.head(row);
        head.freq_setup = cut.setup;
        head.field = self.rows.field(head.field);
        out.push(&head);
        out.n_row += 1;
        for &chan in &cut.chans {
            let first = (row * chunk.n_chan + chan) * chunk.n_corr;
            let at = first..first + chunk.n_corr;
            let vis_jy_p = &chunk.vis_jy_rfp[at.clone()];
            let (weight_p, flag_p) = (&chunk.weight_rfp[at.clone()], &chunk.flag_rfp[at]);
            if let Some(rule) = self.stokes_i {
                let found = rule.apply(vis_jy_p, weight_p, flag_p);
                let (vis_jy, weight) = found.unwrap_or_default();
                out.vis_jy_rfp.push(vis_jy);
                out.weight_rfp.push(weight);
                out.flag_rfp.push(found.is_none());
            } else {
                out.vis_jy_rfp.extend(vis_jy_p);
                out.weight_rfp.extend(weight_p);
                out.flag_rfp.extend(flag_p);
            }
        }
    }
}

impl VisReader for Selected {
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
        self.row = 0;
        self.inner.rewind()
    }

    fn n_row_read(&self) -> u64 {
        self.inner.n_row_read()
    }
}
