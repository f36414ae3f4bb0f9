//! The exact likelihood of a batch of sources over many blocks, on all cores.

use super::kernel::{Isa, SourceTerm, accumulate};
use super::{VisBlock, Xy};
use crate::rime::Source;
use crate::rime::shape::Profile;
use rayon::prelude::*;

/// Fewest sources in a task: below this, setting up the tiles costs more than it spreads.
const SOURCES_PER_TASK: usize = 32;

/// Tasks a thread, so that the last ones to finish do not leave the others waiting long.
const TASKS_PER_THREAD: usize = 4;

/// Most partial sums kept at a time (16 bytes each).
const PARTIAL_SUMS: usize = 1 << 22;

/// X and Y of each of `sources` at unit flux density over all `blocks`.
///
/// Bit-identical for any number of threads and however sources are spread over batches.
pub fn xy_batch(blocks: &[VisBlock], sources: &[Source], profile: Profile) -> Vec<Xy> {
    let terms: Vec<_> = sources
        .iter()
        .map(|s| SourceTerm::new(s, profile))
        .collect();
    let mut out = vec![Xy::default(); terms.len()];
    accumulate_blocks(blocks, &terms, &mut out);
    out
}

/// Adds X and Y of each of `terms` over the next `blocks` of a stream to `out`, on the current
/// rayon pool.
///
/// Each block's sums are formed on their own and added in the order of blocks: how the stream is
/// cut into calls, threads and batches of sources leaves every bit as it is. How it is cut into
/// *blocks* does not, within rounding.
///
/// # Panics
/// If `out` is not as long as `terms`.
pub fn accumulate_blocks(blocks: &[VisBlock], terms: &[SourceTerm], out: &mut [Xy]) {
    assert_eq!(terms.len(), out.len(), "one sum a source");
    if terms.is_empty() {
        return;
    }
    let blocks_at_a_time = (PARTIAL_SUMS / terms.len()).max(1);
    for group in blocks.chunks(blocks_at_a_time) {
        accumulate_group(group, terms, out);
    }
}

/// All (block, run of sources) pairs in parallel, then their sums in order.
fn accumulate_group(blocks: &[VisBlock], terms: &[SourceTerm], out: &mut [Xy]) {
    let isa = Isa::detect();
    let run = run_of_sources(blocks.len(), terms.len());
    let tasks: Vec<_> = blocks
        .iter()
        .flat_map(|block| terms.chunks(run).map(move |terms| (block, terms)))
        .collect();
    let parts: Vec<Vec<Xy>> = tasks
        .into_par_iter()
        .map(|(block, terms)| {
            let mut sums = vec![Xy::default(); terms.len()];
            accumulate(isa, block, terms, &mut sums);
            sums
        })
        .collect();
    for parts in parts.chunks(terms.len().div_ceil(run)) {
        for (out, part) in out.iter_mut().zip(parts.iter().flatten()) {
            out.x += part.x;
            out.y += part.y;
        }
    }
}

/// Sources a task: all of them when there are blocks enough to keep every thread busy.
fn run_of_sources(blocks: usize, sources: usize) -> usize {
    let tasks = TASKS_PER_THREAD * rayon::current_num_threads();
    let runs = tasks.div_ceil(blocks.max(1));
    sources.div_ceil(runs).max(SOURCES_PER_TASK)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::plain_xy;
    use crate::likelihood::samples::{noise, sources};

    fn blocks() -> Vec<VisBlock> {
        [700, 1, 0, 1_300, 512]
            .iter()
            .map(|&len| noise(len, len as u64))
            .collect()
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let (blocks, sources) = (blocks(), sources(150, 1));
        let with_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| xy_batch(&blocks, &sources, Profile::Exponential))
        };
        let one = with_threads(1);
        assert_eq!(one, with_threads(2));
        assert_eq!(one, with_threads(4));
    }

    #[test]
    fn any_cut_of_the_stream_and_the_batch_gives_the_same_bits() {
        let (blocks, sources) = (blocks(), sources(70, 2));
        let whole = xy_batch(&blocks, &sources, Profile::Exponential);
        for size in [1, 33] {
            let mut apart = Vec::new();
            for sources in sources.chunks(size) {
                let terms: Vec<_> = sources
                    .iter()
                    .map(|s| SourceTerm::new(s, Profile::Exponential))
                    .collect();
                let mut out = vec![Xy::default(); terms.len()];
                for blocks in blocks.chunks(2) {
                    accumulate_blocks(blocks, &terms, &mut out);
                }
                apart.append(&mut out);
            }
            assert_eq!(whole, apart, "batches of {size}");
        }
    }

    #[test]
    fn blocks_add_up_to_the_plain_sum() {
        let (blocks, sources) = (blocks(), sources(5, 3));
        let sums = xy_batch(&blocks, &sources, Profile::Gaussian);
        for (sum, source) in sums.iter().zip(&sources) {
            let y: f64 = blocks
                .iter()
                .map(|b| plain_xy(b, source, Profile::Gaussian).y)
                .sum();
            assert!((sum.y / y - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn nothing_in_nothing_out() {
        assert!(xy_batch(&blocks(), &[], Profile::Point).is_empty());
        assert_eq!(
            xy_batch(&[], &sources(2, 4), Profile::Point),
            [Xy::default(); 2]
        );
    }
}
