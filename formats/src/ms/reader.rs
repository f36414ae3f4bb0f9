//! Reading.

use std::path::Path;

use super::antennas::Antennas;
use super::columns::{self, Weights};
use super::describe::describe;
use super::fields::Fields;
use super::rows::{self, Tables, freq_setup};
use super::samples::Samples;
use super::windows::Windows;
use crate::casa::Table;
use crate::direction;
use crate::odd::OddSamples;
use crate::{MsNotes, Observation, ReadError, VisChunk, VisReader};

/// Rows looked at to tell which way the baselines run.
const DIRECTION_ROWS: u64 = 64;
/// How casacore's importers, CASA and pyuvdata have them run.
const DIRECTION: direction::Words = direction::Words {
    coordinates: "UVW",
    wrong_way: "from antenna 1 to antenna 2, against what CASA writes",
};

/// Reads a Measurement Set.
///
/// Holds one row, besides what casacore keeps: the tiles that the row is in. The rows of a chunk
/// have the same number of channels: where that changes the chunk ends. After an error the chunk is
/// empty: [`rewind`](VisReader::rewind) before reading on.
#[derive(Debug)]
pub struct MsReader {
    main: Table,
    observation: Observation,
    tables: Tables,
    samples: Samples,
    next_row: u64,
    odd: OddSamples,
}

impl MsReader {
    /// Opens a Measurement Set: reads its subtables and looks at the first row. `data_column` is
    /// the column of visibilities, if not `CORRECTED_DATA` where it is filled and `DATA` otherwise.
    ///
    /// # Errors
    /// The directory is no Measurement Set, is damaged, or holds what we cannot read.
    pub fn open(path: &Path, data_column: Option<&str>) -> Result<Self, ReadError> {
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
        let tables = Tables {
            antennas: Antennas::read(path)?,
            fields: Fields::read(path)?,
            windows: Windows::read(path, first, &mut warnings)?,
        };
        let samples = Samples {
            data: columns::data(&mut main, data_column)?,
            weights: Weights::choose(&mut main)?,
        };
        let mut observation = describe(path, &mut main, &mut warnings)?;
        observation.antennas.clone_from(&tables.antennas.list);
        observation.fields.clone_from(&tables.fields.list);
        observation.freq_setups.clone_from(&tables.windows.setups);
        observation.corrs.clone_from(&tables.windows.corrs);
        observation.warnings = warnings;
        observation.ms = Some(MsNotes {
            data_column: samples.data.clone(),
            weight_column: samples.weights.column.to_owned(),
        });
        let mut reader = Self {
            main,
            observation,
            tables,
            samples,
            next_row: 0,
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
            let Ok((head, _)) = rows::read(&mut self.main, row, &self.tables) else {
                break;
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

    /// Channels of a row.
    fn n_chan(&mut self, row: u64) -> Result<usize, ReadError> {
        let setup = freq_setup(&mut self.main, row, &self.tables)?;
        Ok(self.tables.windows.setups[setup as usize].freq_hz_f.len())
    }

    /// Appends the next row to a chunk of its shape.
    fn append(&mut self, chunk: &mut VisChunk) -> Result<(), ReadError> {
        let row = self.next_row;
        let (head, is_flagged) = rows::read(&mut self.main, row, &self.tables)?;
        let n_odd = self
            .samples
            .append(&mut self.main, row, is_flagged, chunk)?;
        chunk.push(&head);
        chunk.n_row += 1;
        self.odd.add(n_odd, row);
        self.next_row += 1;
        Ok(())
    }

    fn fill(&mut self, chunk: &mut VisChunk) -> Result<(), ReadError> {
        let n_row = self.main.n_row;
        while chunk.n_row < chunk.max_row.max(1) && self.next_row < n_row {
            let n_chan = self.n_chan(self.next_row)?;
            if chunk.n_row == 0 {
                chunk.clear(n_chan, self.observation.corrs.len());
            } else if n_chan != chunk.n_chan {
                break;
            }
            self.append(chunk)?;
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
        self.odd.rewind();
        Ok(())
    }
}
