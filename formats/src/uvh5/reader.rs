//! Reading.

use std::path::Path;

use num_complex::Complex;

use super::antennas::Antennas;
use super::axes::Axes;
use super::cube::Cube;
use super::describe;
use super::frequencies::Frequencies;
use super::nsamples;
use super::phase_centres::PhaseCentres;
use super::rows::{Rows, Tables};
use super::tile::{TILE_VALUES, Tile};
use crate::direction;
use crate::h5::{Group, Kind};
use crate::odd::OddSamples;
use crate::{Observation, ReadError, VisChunk, VisReader};

/// Rows looked at to tell which way the baselines run.
const DIRECTION_ROWS: usize = 64;
/// How UVH5 has them run.
const DIRECTION: direction::Words = direction::Words {
    coordinates: "uvw_array",
    wrong_way: "from antenna 2 to antenna 1, against the UVH5 convention",
};

/// Reads a UVH5 file.
///
/// Holds a window of rows of each array: about a megabyte each, more where the file's chunks are
/// high, and never more than 32 MB unless one row is larger. After an error the chunk is empty:
/// [`rewind`](VisReader::rewind) before reading on.
#[derive(Debug)]
pub struct Uvh5Reader {
    observation: Observation,
    antennas: Antennas,
    centres: PhaseCentres,
    rows: Rows,
    vis: Cube<Complex<f32>>,
    flags: Cube<i8>,
    nsamples: Cube<f32>,
    has_weights: bool,
    next_row: usize,
    tile: Tile,
    odd: OddSamples,
}

impl Uvh5Reader {
    /// Opens a file: reads its header and checks all sizes.
    ///
    /// # Errors
    /// The file is no UVH5 file, is damaged or truncated, or holds what we cannot read.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let root = Group::open(path)?;
        let group = |name| {
            let what = "is missing: this HDF5 file is no UVH5 file";
            root.group(name)?
                .ok_or_else(|| root.unsupported(name, what))
        };
        let (header, data) = (group("Header")?, group("Data")?);
        let visdata = data.need("visdata")?;
        let axes = Axes::read(&header, &visdata)?;
        let mut warnings = Vec::new();
        let antennas = Antennas::read(&header)?;
        let frequencies = Frequencies::read(&header, &axes)?;
        let centres = PhaseCentres::read(&header, &mut warnings)?;
        let mut observation = describe::describe(&header, &mut warnings)?;
        observation.array_position_m = antennas.array_m;
        observation.antennas.clone_from(&antennas.list);
        observation.fields.clone_from(&centres.fields);
        observation.freq_setups = vec![frequencies.setup];
        observation.corrs = axes.corrs(&header)?;
        observation.n_row = axes.n_row as u64;
        let notes = describe::notes(&header, frequencies.spw_f, &mut warnings)?;
        observation.uvh5 = Some(notes);

        let mut flags = open_flags(&data, axes, &mut warnings)?;
        let mut nsamples = open_nsamples(&data, axes, &mut warnings)?;
        let has_weights = nsamples::are_weights(&axes, &mut flags, &mut nsamples)?;
        if !has_weights {
            warnings.push("no nsample is positive: all weights are taken as 1".into());
        }
        let rows = Rows::open(&header, axes.n_row, centres.has_ids)?;
        let vis = Cube::open(visdata, axes, &mut warnings)?;
        observation.warnings = warnings;
        let mut reader = Self {
            observation,
            antennas,
            centres,
            rows,
            vis,
            flags,
            nsamples,
            has_weights,
            next_row: 0,
            tile: Tile::default(),
            odd: OddSamples::default(),
        };
        reader.judge_direction(axes.n_row);
        Ok(reader)
    }

    /// Sets some rows' coordinates against the antenna positions, and warns where they disagree.
    fn judge_direction(&mut self, n_row: usize) {
        let tables = Tables {
            antennas: &self.antennas,
            centres: &self.centres,
        };
        let mut evidence = Vec::new();
        for row in (0..n_row).step_by(n_row.div_ceil(DIRECTION_ROWS)) {
            // A row that is wrong is an error when its turn comes.
            let Ok(head) = self.rows.single(row, tables) else {
                continue;
            };
            let field = &self.centres.fields[head.field as usize];
            if field.drifts {
                continue;
            }
            evidence.extend(direction::compare(
                head.uvw_m,
                head.ants.map(|ant| self.antennas.list[ant as usize].itrf_m),
                head.time_mjd,
                (field.ra_rad, field.dec_rad),
            ));
        }
        let verdict = direction::verdict(&evidence, &DIRECTION);
        self.observation.warnings.extend(verdict);
    }

    /// Appends the next rows, at most `n_wanted`: as many as all windows hold.
    fn append(&mut self, n_wanted: usize, chunk: &mut VisChunk) -> Result<(), ReadError> {
        let row = self.next_row;
        let wanted = row..row + n_wanted;
        let mut n = self.vis.load(wanted.clone())?;
        n = n.min(self.flags.load(wanted.clone())?);
        n = n.min(self.nsamples.load(wanted)?);
        let tables = Tables {
            antennas: &self.antennas,
            centres: &self.centres,
        };
        let n = self.rows.append(row, n, tables, chunk)?;
        let n_odd = self.append_samples(row, n, chunk);
        self.odd.add(n_odd, row as u64);
        chunk.n_row += n;
        self.next_row += n;
        Ok(())
    }

    /// Appends the samples of rows that are held; returns how many were not finite though not
    /// flagged.
    fn append_samples(&mut self, row: usize, n: usize, chunk: &mut VisChunk) -> u64 {
        let per_row = chunk.values_per_row();
        chunk.vis_jy_rfp.reserve(n * per_row);
        chunk.weight_rfp.reserve(n * per_row);
        chunk.flag_rfp.reserve(n * per_row);
        // As many rows at a time as stay in the processor's cache from one step to the next.
        let few = (TILE_VALUES / per_row).max(1);
        let mut n_odd = 0;
        for first in (row..row + n).step_by(few) {
            let rows = first..(first + few).min(row + n);
            let tile = &mut self.tile;
            tile.resize(rows.len() * per_row);
            self.vis.copy(rows.clone(), &mut tile.vis);
            self.nsamples.copy(rows.clone(), &mut tile.weight);
            self.flags.copy(rows, &mut tile.bad);
            if !self.has_weights {
                tile.weight.fill(1.0);
            }
            n_odd += tile.append_to(chunk);
        }
        n_odd
    }
}

impl VisReader for Uvh5Reader {
    fn observation(&self) -> &Observation {
        &self.observation
    }

    fn read_chunk(&mut self, chunk: &mut VisChunk) -> Result<usize, ReadError> {
        let n_chan = self.observation.freq_setups[0].freq_hz_f.len();
        let n_corr = self.observation.corrs.len();
        chunk.clear(n_chan, n_corr);
        let n_row = self.observation.n_row as usize;
        let wanted = (n_row - self.next_row).min(chunk.max_row.max(1));
        while chunk.n_row < wanted {
            if let Err(error) = self.append(wanted - chunk.n_row, chunk) {
                chunk.clear(n_chan, n_corr);
                return Err(error);
            }
        }
        if self.next_row == n_row {
            let warnings = &mut self.observation.warnings;
            self.odd.tell("the first in or after row", warnings);
        }
        Ok(wanted)
    }

    fn rewind(&mut self) -> Result<(), ReadError> {
        self.next_row = 0;
        self.odd.rewind();
        Ok(())
    }

    fn n_row_read(&self) -> u64 {
        self.next_row as u64
    }
}

fn open_flags(data: &Group, axes: Axes, warnings: &mut Vec<String>) -> Result<Cube<i8>, ReadError> {
    let dataset = data.need("flags")?;
    match dataset.kind {
        Kind::Boolean | Kind::Whole => Cube::open(dataset, axes, warnings),
        _ => Err(dataset.wrong_kind("booleans")),
    }
}

fn open_nsamples(
    data: &Group,
    axes: Axes,
    warnings: &mut Vec<String>,
) -> Result<Cube<f32>, ReadError> {
    let dataset = data.need("nsamples")?;
    dataset.check_real()?;
    Cube::open(dataset, axes, warnings)
}
