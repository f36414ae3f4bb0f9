//! What chunks went through, undone.
//!
//! libhdf5 takes a chunk to be as long as it should be once it is unpacked, and reads beyond it if it is
//! not. So chunks are unpacked here, by the libraries of the filters, to what must be their length.
//!
//! # Source
//! HDF5 File Format Specification 3.0, "Data Object Header Messages: Filter Pipeline"; Fletcher's checksum as
//! in HDF5 1.14, `H5checksum.c`.

use flate2::{Decompress, FlushDecompress, Status};
use hdf5::filters::Filter;

use super::lzf;

/// Bytes that a Fletcher checksum adds to a chunk.
const CHECKSUM_BYTES: usize = 4;

/// Filters, in the order in which they were applied.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Pipeline(Vec<Stage>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Bytes of the same place in elements of that many bytes stand together.
    Shuffle(usize),
    Deflate,
    Lzf,
    Checksum,
}

impl Pipeline {
    /// None if one of the filters is not known here.
    pub(super) fn new(filters: &[Filter], element_bytes: usize) -> Option<Self> {
        let stage = |filter: &Filter| match filter {
            Filter::Shuffle => Some(Stage::Shuffle(element_bytes)),
            Filter::Deflate(_) => Some(Stage::Deflate),
            Filter::LZF => Some(Stage::Lzf),
            Filter::Fletcher32 => Some(Stage::Checksum),
            _ => None,
        };
        filters.iter().map(stage).collect::<Option<_>>().map(Self)
    }

    /// The chunk that is packed as `bytes`, of which stages with a bit in `left_out` were not applied.
    ///
    /// # Errors
    /// It does not unpack, or not to `chunk_bytes` bytes.
    pub(super) fn undo(
        &self,
        mut bytes: Vec<u8>,
        left_out: u32,
        chunk_bytes: usize,
    ) -> Result<Vec<u8>, String> {
        // What a stage may make at most: a chunk, and the checksums of the stages before it.
        let longest = chunk_bytes + CHECKSUM_BYTES * self.0.len();
        for (i, stage) in self.0.iter().enumerate().rev() {
            // Beyond 32 stages there is no bit.
            if left_out.checked_shr(i as u32).unwrap_or(0) & 1 == 0 {
                bytes = stage.undo(bytes, longest)?;
            }
        }
        if bytes.len() == chunk_bytes {
            Ok(bytes)
        } else {
            let n = bytes.len();
            Err(format!(
                "unpacks to {n} bytes where a chunk has {chunk_bytes}"
            ))
        }
    }
}

impl Stage {
    fn undo(self, bytes: Vec<u8>, longest: usize) -> Result<Vec<u8>, String> {
        match self {
            Self::Shuffle(element_bytes) => Ok(unshuffle(bytes, element_bytes)),
            Self::Deflate => inflate(&bytes, longest),
            Self::Lzf => undo_lzf(&bytes, longest),
            Self::Checksum => without_checksum(bytes),
        }
    }
}

fn inflate(bytes: &[u8], longest: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::with_capacity(longest);
    let inflated = Decompress::new(true).decompress_vec(bytes, &mut out, FlushDecompress::Finish);
    match inflated {
        Ok(Status::StreamEnd) => Ok(out),
        Ok(_) if out.len() == longest => Err("inflates to more than a chunk".into()),
        Ok(_) => Err("is cut off".into()),
        Err(error) => Err(format!("does not inflate ({error})")),
    }
}

fn undo_lzf(bytes: &[u8], longest: usize) -> Result<Vec<u8>, String> {
    lzf::decompress(bytes, longest).ok_or_else(|| "is no LZF, or of more than a chunk".into())
}

/// Bytes back into elements; those beyond the last whole element stand at the end as they are.
fn unshuffle(bytes: Vec<u8>, element_bytes: usize) -> Vec<u8> {
    match element_bytes {
        0 | 1 => bytes,
        2 => unshuffle_by::<2>(&bytes),
        4 => unshuffle_by::<4>(&bytes),
        8 => unshuffle_by::<8>(&bytes),
        16 => unshuffle_by::<16>(&bytes),
        n => {
            let n_element = bytes.len() / n;
            let mut out = bytes.clone();
            for (i, element) in out.chunks_exact_mut(n).enumerate() {
                for (k, byte) in element.iter_mut().enumerate() {
                    *byte = bytes[k * n_element + i];
                }
            }
            out
        }
    }
}

/// The same where the compiler knows the size.
fn unshuffle_by<const N: usize>(bytes: &[u8]) -> Vec<u8> {
    let n_element = bytes.len() / N;
    let mut out = Vec::with_capacity(bytes.len());
    let planes: [&[u8]; N] = std::array::from_fn(|k| &bytes[k * n_element..(k + 1) * n_element]);
    for i in 0..n_element {
        out.extend_from_slice(&planes.map(|plane| plane[i]));
    }
    out.extend_from_slice(&bytes[N * n_element..]);
    out
}

fn without_checksum(mut bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    let Some(at) = bytes.len().checked_sub(CHECKSUM_BYTES) else {
        return Err("is shorter than its checksum".into());
    };
    let stored = bytes.split_off(at);
    let sum = fletcher32(&bytes);
    // HDF5 before 1.6.3 wrote the bytes of both halves the other way round.
    let old = sum.swap_bytes().rotate_left(16);
    let is_right = [sum, old].iter().any(|sum| sum.to_le_bytes() == stored[..]);
    is_right
        .then_some(bytes)
        .ok_or_else(|| "has not the checksum that it should have".into())
}

/// Fletcher's checksum of words of two bytes, the first of which counts more.
fn fletcher32(bytes: &[u8]) -> u32 {
    let fold = |sum: u32| (sum & 0xffff) + (sum >> 16);
    let (mut sum1, mut sum2) = (0u32, 0u32);
    // As many words as the sums have room for.
    for words in bytes.chunks(2 * 360) {
        for word in words.chunks(2) {
            let low = word.get(1).copied().unwrap_or(0);
            sum1 += u32::from(u16::from_be_bytes([word[0], low]));
            sum2 += sum1;
        }
        (sum1, sum2) = (fold(sum1), fold(sum2));
    }
    (fold(sum2) << 16) | fold(sum1)
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::super::Group;
    use super::*;
    use crate::h5::Dataset;
    use hdf5::plist::dataset_create::ChunkOpts;

    const SHAPE: [usize; 2] = [40, 7];

    fn values() -> Vec<f32> {
        let n = SHAPE.iter().product::<usize>();
        (0..n).map(|i| (i / 9) as f32 * 0.5).collect()
    }

    /// A file of libhdf5 with chunks that overhang, packed with `filters`.
    fn written(folder: &std::path::Path, filters: &[Filter]) -> std::path::PathBuf {
        written_with(folder, filters, ChunkOpts::empty())
    }

    fn written_with(
        folder: &std::path::Path,
        filters: &[Filter],
        opts: ChunkOpts,
    ) -> std::path::PathBuf {
        let path = folder.join("a.h5");
        let file = hdf5::File::create(&path).unwrap();
        let data = ndarray::Array2::from_shape_vec((SHAPE[0], SHAPE[1]), values()).unwrap();
        let builder = file.new_dataset_builder().with_data(&data);
        builder
            .chunk((16, 3))
            .chunk_opts(opts)
            .set_filters(filters)
            .create("a")
            .unwrap();
        path
    }

    fn look(path: &std::path::Path) -> Dataset {
        Group::open(path).unwrap().need("a").unwrap()
    }

    fn all() -> Vec<Vec<Filter>> {
        vec![
            vec![Filter::deflate(4)],
            vec![Filter::shuffle(), Filter::deflate(1)],
            vec![Filter::lzf()],
            vec![Filter::shuffle(), Filter::lzf(), Filter::fletcher32()],
            vec![Filter::fletcher32(), Filter::shuffle(), Filter::deflate(9)],
            vec![Filter::fletcher32()],
        ]
    }

    #[test]
    fn what_libhdf5_packed_is_unpacked() {
        for filters in all() {
            let folder = tempfile::tempdir().unwrap();
            let dataset = look(&written(folder.path(), &filters));
            let values = values();
            assert_eq!(
                dataset.read_block::<f32>(&[(0, 40), (0, 7)]).unwrap(),
                values
            );
            let part: Vec<f32> = (10..35)
                .flat_map(|row| values[row * 7 + 2..row * 7 + 7].to_vec())
                .collect();
            assert_eq!(
                dataset.read_block::<f32>(&[(10, 25), (2, 5)]).unwrap(),
                part,
                "{filters:?}"
            );
            // As another type, by libhdf5.
            let wide: Vec<f64> = part.iter().map(|&x| f64::from(x)).collect();
            assert_eq!(
                dataset.read_block::<f64>(&[(10, 25), (2, 5)]).unwrap(),
                wide
            );
        }
    }

    #[test]
    fn chunks_at_the_edge_that_were_left_as_they_are_are_taken_so() {
        for filters in all() {
            let folder = tempfile::tempdir().unwrap();
            let path = written_with(
                folder.path(),
                &filters,
                ChunkOpts::DONT_FILTER_PARTIAL_CHUNKS,
            );
            let dataset = look(&path);
            let block = [(0, 40), (0, 7)];
            assert_eq!(dataset.read_block::<f32>(&block).unwrap(), values());
            let wide: Vec<f64> = values().iter().map(|&x| f64::from(x)).collect();
            assert_eq!(dataset.read_block::<f64>(&block).unwrap(), wide);
        }
    }

    /// Every byte of the packed chunks is changed in turn: what is read then is an error or has the length
    /// that it must have, never what lies beyond.
    #[test]
    fn damaged_chunks_are_errors_or_full() {
        for filters in all() {
            let folder = tempfile::tempdir().unwrap();
            let path = written(folder.path(), &filters);
            let whole = std::fs::read(&path).unwrap();
            let first = look(&path).first_chunk_at().unwrap();
            let mut n_error = 0;
            for at in first..(first + 40).min(whole.len()) {
                let mut bytes = whole.clone();
                bytes[at] ^= 0x55;
                let damaged = folder.path().join(format!("{at}.h5"));
                std::fs::write(&damaged, bytes).unwrap();
                let dataset = look(&damaged);
                for read in [
                    dataset
                        .read_block::<f32>(&[(0, 40), (0, 7)])
                        .map(|v| v.len()),
                    dataset
                        .read_block::<f64>(&[(0, 40), (0, 7)])
                        .map(|v| v.len()),
                ] {
                    match read {
                        Ok(n) => assert_eq!(n, 280),
                        Err(error) => {
                            n_error += 1;
                            assert!(error.to_string().contains(": a: "), "{error}");
                        }
                    }
                }
            }
            assert!(n_error > 0, "{filters:?}");
        }
    }

    #[test]
    fn a_chunk_that_has_a_place_but_no_bytes_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.h5");
        let data = ndarray::Array2::from_shape_vec((SHAPE[0], SHAPE[1]), values()).unwrap();
        let file = hdf5::File::create(&path).unwrap();
        let made = file
            .new_dataset_builder()
            .with_data(&data)
            .chunk((16, 3))
            .set_filters(&[Filter::lzf()])
            .create("a");
        drop((made, file));
        let (packed, _) = look(&path).packed_chunk(&[0, 0]).unwrap().unwrap();
        // The index of chunks begins with a head of 24 bytes; then come the bytes of the first chunk.
        let mut bytes = std::fs::read(&path).unwrap();
        let index = bytes.windows(5).position(|part| part == b"TREE\x01");
        let of_first = &mut bytes[index.unwrap() + 24..][..4];
        assert_eq!(of_first, (packed.len() as u32).to_le_bytes());
        of_first.fill(0);
        std::fs::write(&path, bytes).unwrap();
        let read = look(&path).read_block::<f32>(&[(0, 40), (0, 7)]);
        let error = read.unwrap_err().to_string();
        assert!(
            error.contains("the chunk at [0, 0] has no bytes"),
            "{error}"
        );
    }

    #[test]
    fn a_chunk_that_is_too_short_or_too_long_says_so() {
        let packed = |n: usize| {
            let mut encoder =
                flate2::read::ZlibEncoder::new(&[7u8; 100][..n], flate2::Compression::fast());
            let mut bytes = Vec::new();
            encoder.read_to_end(&mut bytes).unwrap();
            bytes
        };
        let pipeline = Pipeline::new(&[Filter::shuffle(), Filter::deflate(1)], 4).unwrap();
        assert_eq!(pipeline.undo(packed(80), 0, 80).unwrap(), [7; 80]);
        let short = pipeline.undo(packed(76), 0, 80).unwrap_err();
        assert_eq!(short, "unpacks to 76 bytes where a chunk has 80");
        assert!(
            pipeline
                .undo(packed(100), 0, 80)
                .unwrap_err()
                .contains("more than a chunk")
        );
        // The mask says that nothing was done to this one.
        assert_eq!(pipeline.undo(vec![1; 80], 0b11, 80).unwrap(), [1; 80]);
        assert!(pipeline.undo(vec![1; 8], 0b11, 80).is_err());
    }

    #[test]
    fn odd_elements_and_what_is_over_are_unshuffled() {
        assert_eq!(
            unshuffle(vec![1, 4, 2, 5, 3, 6, 9], 3),
            [1, 2, 3, 4, 5, 6, 9]
        );
        assert_eq!(unshuffle(vec![1, 3, 2, 4, 9], 2), [1, 2, 3, 4, 9]);
    }
}
