//! Blocks of a dataset from its chunks, which are unpacked here.

use bytemuck::Pod;
use hdf5::H5Type;

use super::dataset::Dataset;
use super::unpack::Pipeline;
use crate::ReadError;

/// Types of elements of which any bytes make a value.
pub(crate) trait Plain: H5Type + Pod {}
impl<T: H5Type + Pod> Plain for T {}

/// A chunk that a block needs.
struct Place {
    /// Its first element along each axis.
    first: Vec<usize>,
    /// What the block needs of it: first element, in the dataset, and count along each axis.
    part: Vec<(usize, usize)>,
}

/// The elements of a block from chunks of their type, each of which is unpacked by `pipeline`; those that
/// were never written are left to libhdf5, which knows what stands for them.
pub(super) fn read<T: Plain>(
    dataset: &Dataset,
    block: &[(usize, usize)],
    chunk: &[usize],
    pipeline: &Pipeline,
) -> Result<Vec<T>, ReadError> {
    let n_element: usize = block.iter().map(|(_, count)| count).product();
    let mut values = vec![T::zeroed(); n_element];
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
    for Place { first, part } in places(block, chunk) {
        if let Some(whole) = unpacked(dataset, &first, pipeline, chunk)? {
            copy(&whole, &first, chunk, &part, bytes, block, size_of::<T>());
        } else {
            let values: Vec<T> = dataset.read_by_library(&part)?;
            let (first, counts): (Vec<usize>, Vec<usize>) = part.iter().copied().unzip();
            let values = bytemuck::cast_slice(&values);
            copy(values, &first, &counts, &part, bytes, block, size_of::<T>());
        }
    }
    Ok(values)
}

/// Makes sure that the chunks of a block unpack to what they should, before libhdf5 reads them.
pub(super) fn check(
    dataset: &Dataset,
    block: &[(usize, usize)],
    chunk: &[usize],
    pipeline: &Pipeline,
) -> Result<(), ReadError> {
    each(dataset, block, chunk, pipeline, |_| Ok(()))
}

/// Looks at the chunks of a block that were written, as they were before they were packed.
pub(super) fn each(
    dataset: &Dataset,
    block: &[(usize, usize)],
    chunk: &[usize],
    pipeline: &Pipeline,
    mut look: impl FnMut(&[u8]) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    for place in places(block, chunk) {
        if let Some(bytes) = unpacked(dataset, &place.first, pipeline, chunk)? {
            look(&bytes)?;
        }
    }
    Ok(())
}

/// The chunk that begins at `first` as it was before it was packed; none if it was never written.
fn unpacked(
    dataset: &Dataset,
    first: &[usize],
    pipeline: &Pipeline,
    chunk: &[usize],
) -> Result<Option<Vec<u8>>, ReadError> {
    let Some((packed, left_out)) = dataset.packed_chunk(first)? else {
        return Ok(None);
    };
    let chunk_bytes = chunk.iter().product::<usize>() * dataset.element_bytes();
    let unpacked = pipeline.undo(packed, left_out, chunk_bytes);
    unpacked.map(Some).map_err(|what| {
        dataset.malformed(format!(
            "the chunk at {first:?} {what}: the file is damaged, copy it again"
        ))
    })
}

/// The chunks that a block needs, in the order of the file.
fn places(block: &[(usize, usize)], chunk: &[usize]) -> Vec<Place> {
    let mut places = vec![Place {
        first: Vec::new(),
        part: Vec::new(),
    }];
    for (&(first, count), &n) in block.iter().zip(chunk) {
        // libhdf5 refuses chunks of nothing; a division must not depend on that.
        let (n, end) = (n.max(1), first + count);
        let along = (first / n..end.div_ceil(n)).map(|i| {
            let from = (i * n).max(first);
            (i * n, (from, ((i + 1) * n).min(end) - from))
        });
        let along: Vec<_> = along.collect();
        let longer = |place: &Place| {
            let (start, before) = (place.first.clone(), place.part.clone());
            let add = move |&(chunk_first, part): &(usize, (usize, usize))| Place {
                first: [&start[..], &[chunk_first]].concat(),
                part: [&before[..], &[part]].concat(),
            };
            along.iter().map(add).collect::<Vec<_>>()
        };
        places = places.iter().flat_map(longer).collect();
    }
    places
}

/// Copies `part` of `from`, an array that begins at `first` and has `counts` elements along each axis, to
/// where it belongs in `block`.
fn copy(
    from: &[u8],
    first: &[usize],
    counts: &[usize],
    part: &[(usize, usize)],
    to: &mut [u8],
    block: &[(usize, usize)],
    element_bytes: usize,
) {
    let Some((&(start, count), rest)) = part.split_first() else {
        to[..element_bytes].copy_from_slice(&from[..element_bytes]);
        return;
    };
    let from_step = element_bytes * counts[1..].iter().product::<usize>();
    let to_step = element_bytes * block[1..].iter().map(|(_, count)| count).product::<usize>();
    let whole = rest.iter().zip(&counts[1..]).all(|(p, n)| p.1 == *n)
        && rest.iter().zip(&block[1..]).all(|(p, b)| p.1 == b.1);
    let (from_at, to_at) = (
        (start - first[0]) * from_step,
        (start - block[0].0) * to_step,
    );
    if whole {
        let n = count * to_step;
        to[to_at..to_at + n].copy_from_slice(&from[from_at..from_at + n]);
        return;
    }
    for i in 0..count {
        copy(
            &from[from_at + i * from_step..],
            &first[1..],
            &counts[1..],
            rest,
            &mut to[to_at + i * to_step..],
            &block[1..],
            element_bytes,
        );
    }
}
