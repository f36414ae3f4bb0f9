//! An array of rows, channels and correlations, of which a window of rows is held.
//!
//! Writers cut such arrays into chunks along all three axes, and to read any part of a chunk is to
//! unpack all of it. So a window is a whole number of chunks high wherever that fits into memory, and
//! each chunk is asked for whole, which libhdf5 then need not gather piece by piece. What it brings
//! is kept in that order, and rows are put together when they are asked for.

use std::ops::Range;

use num_complex::Complex;

use super::axes::Axes;
use crate::ReadError;
use crate::h5::{Dataset, Plain};

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
    blocks: Vec<Block<T>>,
}

/// Some channels and correlations of all rows of a window.
#[derive(Debug)]
struct Block<T> {
    chans: Range<usize>,
    corrs: Range<usize>,
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

/// What an array holds, and how it is read.
pub(super) trait Element: Plain {
    fn read(dataset: &Dataset, block: &[(usize, usize)]) -> Result<Vec<Self>, ReadError> {
        dataset.read_block(block)
    }
}

impl Element for i8 {}
impl Element for f32 {}
impl Element for Complex<f32> {
    fn read(dataset: &Dataset, block: &[(usize, usize)]) -> Result<Vec<Self>, ReadError> {
        dataset.read_complex(block)
    }
}

impl<T: Element> Cube<T> {
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
            [rows, _, chans, corrs] | [rows, chans, corrs] => {
                (rows.max(1), chans.max(1), corrs.max(1))
            }
            _ => (1, axes.n_chan, axes.n_corr),
        });
        Ok(Self {
            plan: Plan::new(&axes, chunk, size_of::<T>()),
            dataset,
            axes,
            held: 0..0,
            blocks: Vec::new(),
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

    /// Copies rows that are held into `out`, channel by channel.
    pub(super) fn copy(&self, rows: Range<usize>, out: &mut [T]) {
        let rows = rows.start - self.held.start..rows.end - self.held.start;
        // All blocks of the same channels together, lest memory be gone through once for each.
        for blocks in self.blocks.chunk_by(|a, b| a.chans == b.chans) {
            weave(blocks, &rows, out, (self.axes.n_chan, self.axes.n_corr));
        }
    }

    fn hold(&mut self, rows: &Range<usize>) -> Result<(), ReadError> {
        let (n_chan, n_corr) = (self.axes.n_chan, self.axes.n_corr);
        let (block_chans, block_corrs) = self.plan.block;
        self.blocks.clear();
        for f in (0..n_chan).step_by(block_chans) {
            for p in (0..n_corr).step_by(block_corrs) {
                let chans = f..(f + block_chans).min(n_chan);
                let corrs = p..(p + block_corrs).min(n_corr);
                let values = self.read(rows, &chans, &corrs)?;
                self.blocks.push(Block {
                    chans,
                    corrs,
                    values,
                });
            }
        }
        Ok(())
    }

    fn read(
        &self,
        rows: &Range<usize>,
        chans: &Range<usize>,
        corrs: &Range<usize>,
    ) -> Result<Vec<T>, ReadError> {
        let mut block = vec![
            (rows.start, rows.len()),
            (chans.start, chans.len()),
            (corrs.start, corrs.len()),
        ];
        if self.axes.old {
            block.insert(1, (0, 1));
        }
        T::read(&self.dataset, &block)
    }
}

impl<T: Copy> Block<T> {
    fn rows(&self, rows: &Range<usize>) -> &[T] {
        let per_row = self.chans.len() * self.corrs.len();
        &self.values[rows.start * per_row..rows.end * per_row]
    }
}

/// Puts together some channels of rows from blocks of some correlations each.
///
/// `out` has whole rows, of (channels, correlations). The usual cases are spelled out because copies
/// of a few bytes are mostly calls.
fn weave<T: Copy>(
    blocks: &[Block<T>],
    rows: &Range<usize>,
    out: &mut [T],
    (n_chan, n_corr): (usize, usize),
) {
    let chans = &blocks[0].chans;
    let mut places = Places {
        out,
        stride: n_chan * n_corr,
        span: chans.start * n_corr..chans.end * n_corr,
    };
    match blocks {
        [all] => places.fill(all.rows(rows)),
        [a, b] if n_corr == 2 => places.interleave([a, b].map(|block| block.rows(rows))),
        [a, b] if n_corr == 4 && a.corrs.len() == 2 => {
            let pairs = [a, b].map(|block| block.rows(rows).as_chunks::<2>().0);
            places.pairs().interleave(pairs);
        }
        [a, b, c, d] if n_corr == 4 => {
            places.interleave([a, b, c, d].map(|block| block.rows(rows)));
        }
        any => any.iter().for_each(|block| {
            let values = block.rows(rows).chunks_exact(block.corrs.len());
            for (place, values) in places
                .rows()
                .flat_map(|r| r.chunks_exact_mut(n_corr))
                .zip(values)
            {
                place[block.corrs.clone()].copy_from_slice(values);
            }
        }),
    }
}

/// Where some channels of each row go.
struct Places<'a, T> {
    out: &'a mut [T],
    /// Values of a row.
    stride: usize,
    /// Which of them are meant.
    span: Range<usize>,
}

impl<T: Copy> Places<'_, T> {
    fn rows(&mut self) -> impl Iterator<Item = &mut [T]> {
        let span = self.span.clone();
        let rows = self.out.chunks_exact_mut(self.stride);
        rows.map(move |row| &mut row[span.clone()])
    }

    /// `values` has the rows, one after the other.
    fn fill(&mut self, values: &[T]) {
        let per_row = self.span.len();
        for (place, values) in self.rows().zip(values.chunks_exact(per_row)) {
            place.copy_from_slice(values);
        }
    }

    /// Each of `parts` has every `N`th value of the rows.
    fn interleave<const N: usize>(&mut self, parts: [&[T]; N]) {
        match self.span.len() / N {
            1 => self.interleave_few::<N, 1>(parts),
            2 => self.interleave_few::<N, 2>(parts),
            4 => self.interleave_few::<N, 4>(parts),
            n_chan => {
                for (r, place) in self.rows().enumerate() {
                    let parts = parts.map(|part| &part[r * n_chan..(r + 1) * n_chan]);
                    for (f, place) in place.as_chunks_mut::<N>().0.iter_mut().enumerate() {
                        *place = parts.map(|part| part[f]);
                    }
                }
            }
        }
    }

    /// The same where a row has so few values that a loop over them costs more than they do.
    fn interleave_few<const N: usize, const C: usize>(&mut self, parts: [&[T]; N]) {
        let parts = parts.map(|part| part.as_chunks::<C>().0);
        for (r, place) in self.rows().enumerate() {
            let parts = parts.map(|part| part[r]);
            for (f, place) in place.as_chunks_mut::<N>().0.iter_mut().enumerate().take(C) {
                *place = parts.map(|part| part[f]);
            }
        }
    }
}

impl<T> Places<'_, T> {
    /// The same places, for two values at a time.
    fn pairs(&mut self) -> Places<'_, [T; 2]> {
        Places {
            out: self.out.as_chunks_mut::<2>().0,
            stride: self.stride / 2,
            span: self.span.start / 2..self.span.end / 2,
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

    /// Channels of the rows of which `blocks` has some.
    const N_CHAN: usize = 8;

    /// Blocks of channels 2 to `2 + n` as a file of `n_corr` correlations has them in chunks of
    /// `per_block`, whose values count up over (row, channel, correlation).
    fn blocks(n_chan: usize, n_corr: usize, per_block: usize) -> Vec<Block<usize>> {
        let (n_row, chans) = (3, 2..2 + n_chan);
        let block = |corrs: Range<usize>| {
            let mut values = Vec::new();
            for (row, chan) in (0..n_row).flat_map(|r| chans.clone().map(move |f| (r, f))) {
                values.extend(corrs.clone().map(|p| (row * N_CHAN + chan) * n_corr + p));
            }
            Block {
                chans: chans.clone(),
                corrs,
                values,
            }
        };
        let starts = (0..n_corr).step_by(per_block);
        starts
            .map(|p| block(p..(p + per_block).min(n_corr)))
            .collect()
    }

    #[test]
    fn correlations_are_put_together_however_they_are_cut() {
        for (n_corr, per_block) in [
            (1, 1),
            (2, 1),
            (2, 2),
            (3, 1),
            (3, 2),
            (4, 1),
            (4, 2),
            (4, 3),
            (4, 4),
        ] {
            for n_chan in 1..=5 {
                let blocks = blocks(n_chan, n_corr, per_block);
                let mut out = vec![usize::MAX; 2 * N_CHAN * n_corr];
                weave(&blocks, &(1..3), &mut out, (N_CHAN, n_corr));
                for (i, &value) in out.iter().enumerate() {
                    let held = (2..2 + n_chan).contains(&(i / n_corr % N_CHAN));
                    let wanted = if held {
                        N_CHAN * n_corr + i
                    } else {
                        usize::MAX
                    };
                    assert_eq!(value, wanted, "{n_chan}, {n_corr} in blocks of {per_block}");
                }
            }
        }
    }

    #[test]
    fn a_row_beyond_all_bounds_is_a_window_of_its_own() {
        let plan = Plan::new(&axes(10, 1 << 24), None, 8);
        assert_eq!(plan.window(3, 10), 3..4);
    }
}
