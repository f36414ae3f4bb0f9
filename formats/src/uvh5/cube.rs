//! An array of rows, channels and correlations, of which a window of rows is held.
//!
//! Writers cut such arrays into chunks along all three axes, and to read any part of a chunk is to
//! unpack all of it. So a window is a whole number of chunks high wherever that fits into memory, and
//! each chunk is asked for whole, which libhdf5 then need not gather piece by piece.

use std::ops::Range;

use super::axes::Axes;
use crate::ReadError;
use crate::h5::Dataset;

/// Bytes that a window may have, unless one row has more.
const MAX_WINDOW_BYTES: usize = 1 << 25;
/// Bytes that a window should have, where the chunks are low.
const WINDOW_BYTES: usize = 1 << 20;

/// The array.
#[derive(Debug)]
pub(super) struct Cube<T> {
    pub(super) dataset: Dataset,
    axes: Axes,
    plan: Plan,
    held: Range<usize>,
    values: Vec<T>,
}

/// How an array is cut into windows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Plan {
    /// Rows after which windows start afresh: a number of chunks.
    unit_rows: usize,
    /// Rows of a window, at most a unit.
    window_rows: usize,
    /// Channels and correlations of a block that is read at once.
    block: (usize, usize),
}

impl Plan {
    /// `chunk` is the file's (rows, channels, correlations).
    fn new(axes: &Axes, chunk: Option<(usize, usize, usize)>, element_bytes: usize) -> Self {
        let row_bytes = axes.n_chan * axes.n_corr * element_bytes;
        let rows_in = |bytes: usize| (bytes / row_bytes.max(1)).max(1);
        let (chunk_rows, n_chan, n_corr) = chunk.unwrap_or((1, axes.n_chan, axes.n_corr));
        let unit_rows = if chunk_rows > rows_in(MAX_WINDOW_BYTES) {
            chunk_rows
        } else {
            // Not beyond the rows that there are, lest small files take more than they need.
            rows_in(WINDOW_BYTES)
                .min(axes.n_row)
                .next_multiple_of(chunk_rows)
        };
        // Windows that do not hold a unit share it evenly.
        let n_part = unit_rows.div_ceil(rows_in(MAX_WINDOW_BYTES));
        Self {
            unit_rows,
            window_rows: unit_rows.div_ceil(n_part),
            block: (n_chan.min(axes.n_chan), n_corr.min(axes.n_corr)),
        }
    }

    /// The window that holds a row.
    fn window(&self, row: usize, n_row: usize) -> Range<usize> {
        let unit = row - row % self.unit_rows;
        let first = unit + (row - unit) / self.window_rows * self.window_rows;
        let end = (first + self.window_rows).min(unit + self.unit_rows);
        first..end.min(n_row)
    }
}

impl<T: hdf5::H5Type + Copy + Default> Cube<T> {
    /// Holds nothing yet. Warns of chunks that were never written.
    pub(super) fn open(
        dataset: Dataset,
        axes: Axes,
        warnings: &mut Vec<String>,
    ) -> Result<Self, ReadError> {
        dataset.check_shape_is(&axes.shape())?;
        let (written, wanted) = dataset.stored_part()?;
        if written == 0 {
            return Err(dataset.malformed("was never written: the file is unfinished"));
        }
        if written < wanted {
            warnings.push(format!(
                "{} of {wanted} chunks of {} were never written and are read as zeros",
                wanted - written,
                dataset.name()
            ));
        }
        let chunk = dataset.chunk.as_deref().map(|chunk| match *chunk {
            [rows, _, chans, corrs] => (rows.max(1), chans.max(1), corrs.max(1)),
            [rows, chans, corrs] => (rows.max(1), chans.max(1), corrs.max(1)),
            _ => (1, axes.n_chan, axes.n_corr),
        });
        Ok(Self {
            plan: Plan::new(&axes, chunk, size_of::<T>()),
            dataset,
            axes,
            held: 0..0,
            values: Vec::new(),
        })
    }

    /// Sees to it that the first of the wanted rows is held; returns how many of them are.
    pub(super) fn load(&mut self, wanted: Range<usize>) -> Result<usize, ReadError> {
        if !self.held.contains(&wanted.start) {
            self.held = 0..0;
            let window = self.plan.window(wanted.start, self.axes.n_row);
            self.hold(&window)?;
            self.held = window;
        }
        Ok(self.held.end.min(wanted.end) - wanted.start)
    }

    /// The values of rows that are held.
    pub(super) fn at(&self, rows: Range<usize>) -> &[T] {
        let per_row = self.axes.n_chan * self.axes.n_corr;
        let first = self.held.start;
        &self.values[(rows.start - first) * per_row..(rows.end - first) * per_row]
    }

    fn hold(&mut self, rows: &Range<usize>) -> Result<(), ReadError> {
        let (n_chan, n_corr) = (self.axes.n_chan, self.axes.n_corr);
        let (block_chans, block_corrs) = self.plan.block;
        if (block_chans, block_corrs) == (n_chan, n_corr) {
            self.values = self.block(rows, 0..n_chan, 0..n_corr)?;
            return Ok(());
        }
        self.values.clear();
        self.values
            .resize(rows.len() * n_chan * n_corr, T::default());
        for f in (0..n_chan).step_by(block_chans) {
            for p in (0..n_corr).step_by(block_corrs) {
                let chans = f..(f + block_chans).min(n_chan);
                let corrs = p..(p + block_corrs).min(n_corr);
                let block = self.block(rows, chans.clone(), corrs.clone())?;
                self.scatter(&block, chans, corrs);
            }
        }
        Ok(())
    }

    fn block(
        &self,
        rows: &Range<usize>,
        chans: Range<usize>,
        corrs: Range<usize>,
    ) -> Result<Vec<T>, ReadError> {
        let mut block = vec![
            (rows.start, rows.len()),
            (chans.start, chans.len()),
            (corrs.start, corrs.len()),
        ];
        if self.axes.old {
            block.insert(1, (0, 1));
        }
        self.dataset.read_block(&block)
    }

    /// Puts a block where it belongs in the window.
    fn scatter(&mut self, block: &[T], chans: Range<usize>, corrs: Range<usize>) {
        let (n_chan, n_corr) = (self.axes.n_chan, self.axes.n_corr);
        let block_rows = block.chunks_exact(chans.len() * corrs.len());
        for (row, block) in self
            .values
            .chunks_exact_mut(n_chan * n_corr)
            .zip(block_rows)
        {
            let places = row.chunks_exact_mut(n_corr).skip(chans.start);
            for (place, values) in places.zip(block.chunks_exact(corrs.len())) {
                place[corrs.clone()].copy_from_slice(values);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(n_row: usize, n_chan: usize) -> Axes {
        Axes {
            n_row,
            n_chan,
            n_corr: 4,
            old: false,
        }
    }

    #[test]
    fn windows_are_whole_chunks_where_these_fit() {
        let plan = Plan::new(&axes(406, 16), Some((102, 8, 2)), 8);
        assert_eq!((plan.unit_rows, plan.window_rows), (408, 408));
        assert_eq!(plan.window(0, 406), 0..406);
        let plan = Plan::new(&axes(100_000, 1024), Some((50, 64, 4)), 8);
        assert_eq!((plan.unit_rows, plan.window_rows), (50, 50));
        assert_eq!(plan.window(99, 100_000), 50..100);
    }

    #[test]
    fn high_chunks_are_shared_among_windows_of_bounded_size() {
        let plan = Plan::new(&axes(100_000, 1024), Some((15_625, 16, 1)), 8);
        assert!(plan.window_rows * 1024 * 4 * 8 <= MAX_WINDOW_BYTES);
        assert_eq!(plan.unit_rows, 15_625);
        let mut row = 0;
        while row < 100_000 {
            let window = plan.window(row, 100_000);
            assert_eq!(window.start, row);
            assert_eq!(plan.window(window.end - 1, 100_000), window);
            row = window.end;
        }
    }

    #[test]
    fn a_row_beyond_all_bounds_is_a_window_of_its_own() {
        let plan = Plan::new(&axes(10, 1 << 24), None, 8);
        assert_eq!(plan.window(3, 10), 3..4);
    }
}
