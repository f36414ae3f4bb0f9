//! Reading.

use std::path::Path;

use super::antennas::Antennas;
use super::columns::{self, Weights};
use super::describe::describe;
use super::fields::Fields;
use super::rows::{Heads, Tables};
use super::samples::Samples;
use super::windows::Windows;
use crate::casa::Table;
use crate::direction;
use crate::odd::OddSamples;
use crate::{MsNotes, Observation, ReadError, VisChunk, VisReader};

/// Rows looked at to tell which way the baselines run.
const DIRECTION_ROWS: u64 = 64;
/// Most values of a column that are read at a time, unless a row has more.
const MAX_VALUES: usize = 1 << 19;
/// How casacore's importers, CASA and pyuvdata have them run.
const DIRECTION: direction::Words = direction::Words {
    coordinates: "UVW",
    wrong_way: "from antenna 1 to antenna 2, against what CASA writes",
};

/// Reads a Measurement Set.
///
/// Holds what a few thousand rows say besides their samples, and what casacore keeps: the tiles that the
/// rows are in. The rows of a chunk
/// have the same number of channels: where that changes the chunk ends. After an error the chunk is
/// empty: [`rewind`](VisReader::rewind) before reading on.
#[derive(Debug)]
pub struct MsReader {
    main: Table,
    observation: Observation,
    tables: Tables,
    samples: Samples,
    next_row: u64,
    heads: Heads,
    odd: OddSamples,
}

impl MsReader {
    /// Opens a Measurement Set: reads its subtables and looks at the first row. `data_column` is
    /// the column of visibilities, if not `CORRECTED_DATA` where it is filled and `DATA` otherwise.
    ///
    /// # Errors
    /// The directory is no Measurement Set, is damaged, or holds what we cannot read.
    pub fn open(path: &Path, data_column: Option<&str>) -> Result<Self, ReadError> {
        Self::open_with(path, data_column, &[])
    }

    /// As [`open`](Self::open), and reads only rows of the spectral windows `spws`, unless there are none.
    ///
    /// # Errors
    /// As [`open`](Self::open), or there is no such spectral window.
    pub fn open_with(
        path: &Path,
        data_column: Option<&str>,
        spws: &[i64],
    ) -> Result<Self, ReadError> {
        let mut main = Table::open(path)?;
        if !["UVW", "ANTENNA1", "DATA_DESC_ID"]
            .iter()
            .all(|column| main.has(column))
        {
            return Err(
                main.malformed("has no UVW, ANTENNA1 and DATA_DESC_ID: it is no Measurement Set")
            );
        }
        if main.n_row == 0 {
            return Err(main.malformed("has no rows: the set holds no visibilities"));
        }
        let mut warnings = Vec::new();
        let first = main.scalar("DATA_DESC_ID", 0)?;
        let home = main.home()?;
        let tables = Tables {
            antennas: Antennas::read(&home)?,
            fields: Fields::read(&home)?,
            windows: Windows::read(&home, first, spws, &mut warnings)?,
        };
        let samples = Samples {
            data: columns::data(&mut main, data_column)?,
            weights: Weights::choose(&mut main)?,
        };
        let mut observation = describe(&home, &mut main, &mut warnings)?;
        observation.antennas.clone_from(&tables.antennas.list);
        observation.fields.clone_from(&tables.fields.list);
        observation.freq_setups.clone_from(&tables.windows.setups);
        observation.corrs.clone_from(&tables.windows.corrs);
        observation.warnings = warnings;
        observation.ms = Some(MsNotes {
            data_column: samples.data.clone(),
            weight_column: samples.weights.column.to_owned(),
            spw_s: tables.windows.spw_s.clone(),
        });
        let mut reader = Self {
            main,
            observation,
            tables,
            samples,
            next_row: 0,
            heads: Heads::default(),
            odd: OddSamples::default(),
        };
        reader.judge_direction();
        Ok(reader)
    }

    /// Sets some rows' coordinates against the antenna positions, and warns where they disagree.
    fn judge_direction(&mut self) {
        let n_row = self.main.n_row;
        let mut evidence = Vec::new();
        for row in (0..n_row).step_by(n_row.div_ceil(DIRECTION_ROWS) as usize) {
            // A row that is wrong is an error when its turn comes; there is no use in meeting it twice.
            let Ok(heads) = Heads::read(&mut self.main, row, 1) else {
                break;
            };
            let Ok((head, _)) = heads.get(&self.main, row, &self.tables) else {
                continue;
            };
            let field = &self.observation.fields[head.field as usize];
            let antennas = &self.observation.antennas;
            evidence.extend(direction::compare(
                head.uvw_m,
                head.ants.map(|ant| antennas[ant as usize].itrf_m),
                head.time_mjd,
                (field.ra_rad, field.dec_rad),
            ));
        }
        let verdict = direction::verdict(&evidence, &DIRECTION);
        self.observation.warnings.extend(verdict);
    }

    /// Goes on to the next row that is wanted, if there is one; its head is held then.
    fn skip(&mut self) -> Result<bool, ReadError> {
        while self.next_row < self.main.n_row {
            if !self.heads.has(self.next_row) {
                self.heads = Heads::read(&mut self.main, self.next_row, u64::MAX)?;
            }
            let description = self.heads.description(self.next_row);
            if self.tables.windows.is_wanted(description) {
                return Ok(true);
            }
            self.next_row += 1;
        }
        Ok(false)
    }

    /// Appends the heads of the next rows, all of `n_chan` channels and at most `n_most`, as many as are
    /// held and wanted; returns whether each is bad as a whole.
    fn append_heads(
        &mut self,
        n_chan: usize,
        n_most: usize,
        chunk: &mut VisChunk,
    ) -> Result<Vec<bool>, ReadError> {
        let mut all_bad = Vec::new();
        while all_bad.len() < n_most && self.heads.has(self.next_row) {
            let description = self.heads.description(self.next_row);
            if !self.tables.windows.is_wanted(description) {
                break;
            }
            let (head, is_bad) = self.heads.get(&self.main, self.next_row, &self.tables)?;
            if self.n_chan(head.freq_setup) != n_chan {
                break;
            }
            chunk.push(&head);
            all_bad.push(is_bad);
            self.next_row += 1;
        }
        Ok(all_bad)
    }

    fn n_chan(&self, setup: u32) -> usize {
        self.tables.windows.setups[setup as usize].freq_hz_f.len()
    }

    fn fill(&mut self, chunk: &mut VisChunk) -> Result<(), ReadError> {
        let n_corr = self.observation.corrs.len();
        while chunk.n_row < chunk.max_row.max(1) && self.skip()? {
            let first = self.next_row;
            let (head, _) = self.heads.get(&self.main, first, &self.tables)?;
            let n_chan = self.n_chan(head.freq_setup);
            if chunk.n_row == 0 {
                chunk.clear(n_chan, n_corr);
            } else if n_chan != chunk.n_chan {
                break;
            }
            let room = chunk.max_row.max(1) - chunk.n_row;
            let most = (MAX_VALUES / (n_chan * n_corr)).clamp(1, room);
            let all_bad = self.append_heads(n_chan, most, chunk)?;
            let odd = self
                .samples
                .append(&mut self.main, first, &all_bad, chunk)?;
            chunk.n_row += all_bad.len();
            for (row, n_odd) in (first..).zip(odd) {
                self.odd.add(n_odd, row);
            }
        }
        // What is not wanted at the end is done with.
        if chunk.n_row < chunk.max_row.max(1) {
            self.skip()?;
        }
        Ok(())
    }
}

impl VisReader for MsReader {
    fn observation(&self) -> &Observation {
        &self.observation
    }

    fn read_chunk(&mut self, chunk: &mut VisChunk) -> Result<usize, ReadError> {
        let n_chan = self.observation.freq_setups[0].freq_hz_f.len();
        let n_corr = self.observation.corrs.len();
        chunk.clear(n_chan, n_corr);
        if let Err(error) = self.fill(chunk) {
            chunk.clear(n_chan, n_corr);
            return Err(error);
        }
        if self.next_row == self.main.n_row {
            let warnings = &mut self.observation.warnings;
            self.odd.tell("the first in row", warnings);
        }
        Ok(chunk.n_row)
    }

    fn rewind(&mut self) -> Result<(), ReadError> {
        self.next_row = 0;
        self.heads = Heads::default();
        self.odd.rewind();
        Ok(())
    }

    fn n_row_read(&self) -> u64 {
        self.next_row
    }
}
