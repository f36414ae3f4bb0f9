//! What each row says besides its visibilities.
//!
//! # Source
//! Memo, section 3.1: uvw_array, time_array, integration_time, ant_1_array, ant_2_array.

use std::ops::Range;

use super::antennas::Antennas;
use super::phase_centres::PhaseCentres;
use crate::chunk::RowHead;
use crate::date::MJD_ZERO_JD;
use crate::h5::{Dataset, Group, Plain};
use crate::{ReadError, VisChunk};

/// Rows held at a time.
const WINDOW_ROWS: usize = 1 << 13;
/// Most rows held at a time, where chunks are long.
const MAX_WINDOW_ROWS: usize = 1 << 18;

/// The arrays of one value or triple a row.
#[derive(Debug)]
pub(super) struct Rows {
    uvw: Column<f64>,
    time: Column<f64>,
    /// Absent in no file known, but a value that can be done without.
    interval: Option<Column<f64>>,
    /// The one integration time of old files [s].
    interval_s: f64,
    ant1: Column<i64>,
    ant2: Column<i64>,
    phase_centre: Option<Column<i64>>,
}

/// What rows refer to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tables<'a> {
    pub(super) antennas: &'a Antennas,
    pub(super) centres: &'a PhaseCentres,
}

impl Rows {
    pub(super) fn open(header: &Group, n_row: usize, has_ids: bool) -> Result<Self, ReadError> {
        let real = |name, rest: &[usize]| Column::<f64>::real(header.need(name)?, n_row, rest);
        let whole = |name| Column::<i64>::whole(header.need(name)?, n_row);
        let interval = header.dataset("integration_time")?;
        let (interval, interval_s) = match interval {
            None => (None, f64::NAN),
            Some(one) if one.shape.is_empty() => (None, known_interval(one.real()?)),
            Some(column) => (Some(Column::real(column, n_row, &[])?), f64::NAN),
        };
        Ok(Self {
            uvw: real("uvw_array", &[3])?,
            time: real("time_array", &[])?,
            interval,
            interval_s,
            ant1: whole("ant_1_array")?,
            ant2: whole("ant_2_array")?,
            phase_centre: has_ids
                .then(|| whole("phase_center_id_array"))
                .transpose()?,
        })
    }

    /// Appends what the rows from `row` on say, at most `n_wanted`; returns how many.
    pub(super) fn append(
        &mut self,
        row: usize,
        n_wanted: usize,
        tables: Tables,
        chunk: &mut VisChunk,
    ) -> Result<usize, ReadError> {
        let wanted = row..row + n_wanted;
        let mut n = self.uvw.load(wanted.clone())?;
        n = n.min(self.time.load(wanted.clone())?);
        n = n.min(self.ant1.load(wanted.clone())?);
        n = n.min(self.ant2.load(wanted.clone())?);
        if let Some(column) = &mut self.interval {
            n = n.min(column.load(wanted.clone())?);
        }
        if let Some(column) = &mut self.phase_centre {
            n = n.min(column.load(wanted.clone())?);
        }
        for row in row..row + n {
            let head = self.head(row, tables)?;
            chunk.push(&head);
        }
        Ok(n)
    }

    /// One row, wherever it is.
    pub(super) fn single(&mut self, row: usize, tables: Tables) -> Result<RowHead, ReadError> {
        self.uvw.load_one(row)?;
        self.time.load_one(row)?;
        self.ant1.load_one(row)?;
        self.ant2.load_one(row)?;
        if let Some(column) = &mut self.interval {
            column.load_one(row)?;
        }
        if let Some(column) = &mut self.phase_centre {
            column.load_one(row)?;
        }
        self.head(row, tables)
    }

    /// A row that has been loaded.
    ///
    /// UVH5 has baselines from antenna 1 to antenna 2, a chunk the other way: (u, v, w) change sign
    /// here and the visibilities are conjugated, which leaves the phase convention as it is.
    fn head(&self, row: usize, tables: Tables) -> Result<RowHead, ReadError> {
        let uvw_m = [0, 1, 2].map(|d| -self.uvw.at(row)[d]);
        let time_mjd = self.time.at(row)[0] - MJD_ZERO_JD;
        if let Some(bad) = uvw_m.iter().find(|x| !x.is_finite()) {
            return Err(self.uvw.row_error(row, &format!("{bad} is not finite")));
        }
        if !time_mjd.is_finite() {
            return Err(self
                .time
                .row_error(row, &format!("{time_mjd} is not finite")));
        }
        let interval = self.interval.as_ref();
        let ant = |column: &Column<i64>| {
            let number = column.at(row)[0];
            tables.antennas.find(number).ok_or_else(|| {
                column.row_error(row, &format!("antenna {number} is not in antenna_numbers"))
            })
        };
        let field = match &self.phase_centre {
            None => 0,
            Some(column) => (tables.centres.find(column.at(row)[0]))
                .map_err(|what| column.row_error(row, &what))?,
        };
        Ok(RowHead {
            uvw_m,
            time_mjd,
            interval_s: interval.map_or(self.interval_s, |c| known_interval(c.at(row)[0])),
            ants: [ant(&self.ant1)?, ant(&self.ant2)?],
            field,
            freq_setup: 0,
        })
    }
}

fn known_interval(interval_s: f64) -> f64 {
    if interval_s.is_finite() && interval_s > 0.0 {
        interval_s
    } else {
        f64::NAN
    }
}

/// An array of which some rows are held.
#[derive(Debug)]
struct Column<T> {
    dataset: Dataset,
    n_row: usize,
    per_row: usize,
    /// Rows of a window, a multiple of the file's chunks where these are short enough.
    window_rows: usize,
    held: Range<usize>,
    values: Vec<T>,
}

impl Column<f64> {
    fn real(dataset: Dataset, n_row: usize, rest: &[usize]) -> Result<Self, ReadError> {
        dataset.check_real()?;
        Self::new(dataset, n_row, rest)
    }
}

impl Column<i64> {
    fn whole(dataset: Dataset, n_row: usize) -> Result<Self, ReadError> {
        dataset.check_whole()?;
        Self::new(dataset, n_row, &[])
    }
}

impl<T: Plain> Column<T> {
    fn new(dataset: Dataset, n_row: usize, rest: &[usize]) -> Result<Self, ReadError> {
        let mut shape = vec![n_row];
        shape.extend(rest);
        dataset.check_shape_is(&shape)?;
        let (written, wanted) = dataset.stored_part()?;
        if written < wanted {
            let what = format!("{written} of {wanted} chunks were written: the file is unfinished");
            return Err(dataset.malformed(what));
        }
        let chunk_rows = dataset.chunk.as_ref().map_or(1, |chunk| chunk[0].max(1));
        Ok(Self {
            n_row,
            per_row: rest.iter().product(),
            window_rows: WINDOW_ROWS
                .next_multiple_of(chunk_rows)
                .min(MAX_WINDOW_ROWS),
            dataset,
            held: 0..0,
            values: Vec::new(),
        })
    }

    /// Sees to it that the first of the wanted rows is held; returns how many of them are.
    fn load(&mut self, wanted: Range<usize>) -> Result<usize, ReadError> {
        if !self.held.contains(&wanted.start) {
            let first = wanted.start - wanted.start % self.window_rows;
            self.hold(first..(first + self.window_rows).min(self.n_row))?;
        }
        Ok(self.held.end.min(wanted.end) - wanted.start)
    }

    fn load_one(&mut self, row: usize) -> Result<(), ReadError> {
        if self.held.contains(&row) {
            return Ok(());
        }
        self.hold(row..row + 1)
    }

    fn hold(&mut self, rows: Range<usize>) -> Result<(), ReadError> {
        self.held = 0..0;
        let mut block = vec![(rows.start, rows.len())];
        if self.per_row > 1 {
            block.push((0, self.per_row));
        }
        self.values = self.dataset.read_block(&block)?;
        self.held = rows;
        Ok(())
    }

    /// The values of a row that is held.
    fn at(&self, row: usize) -> &[T] {
        let at = (row - self.held.start) * self.per_row;
        &self.values[at..at + self.per_row]
    }

    fn row_error(&self, row: usize, what: &str) -> ReadError {
        (self.dataset).malformed(format!("row {} of {}: {what}", row + 1, self.n_row))
    }
}
