//! A dataset: what it says of itself, and whether the file bears it out.

use std::path::{Path, PathBuf};

use bytemuck::{Pod, Zeroable};
use hdf5::plist::dataset_create::ChunkOpts;
use hdf5::types::TypeDescriptor;
use hdf5::{H5Type, Hyperslab, SliceOrIndex};
use num_complex::Complex;

use super::chunks::{self, Plain};
use super::collections::{self, Place, REFERENCE_BYTES};
use super::raw_file::RawFile;
use super::unpack::Pipeline;
use super::{COPY_AGAIN, filter, raw, unreadable};
use crate::ReadError;

/// How many bytes a filter can make of one: deflate's bound is 1032, LZF's 88 (zlib manual, "Maximum
/// expansion factor").
const MAX_EXPANSION: u128 = 1100;

/// Chunks that a filter makes whole must fit into memory; writers make chunks of about a megabyte.
const MAX_FILTERED_CHUNK_BYTES: u64 = 1 << 28;

/// Most bytes in memory of what is read in one piece: a few kilobytes packed can become as many
/// megabytes, and a channel or an antenna takes 64 at most.
const MAX_HEADER_BYTES: u128 = 1 << 28;

/// A complex number as correlators write it.
#[derive(Clone, Copy, H5Type, Pod, Zeroable)]
#[repr(C)]
struct WholeComplex {
    r: i32,
    i: i32,
}

/// What the elements are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Whole numbers.
    Whole,
    /// Real numbers.
    Real,
    /// h5py's booleans: an enumeration of FALSE and TRUE.
    Boolean,
    /// A compound of numbers `r` and `i`.
    Complex,
    /// A string of that many bytes.
    FixedText(usize),
    /// Strings of any length, elsewhere in the file.
    VariableText,
    /// Anything else.
    Other,
}

/// Why a dataset is not read whose data stand outside of it.
pub(super) const ELSEWHERE: &str = "the data stand in another file, which is not followed; copy them into this file, \
                                    with h5repack";

/// A dataset with a value.
#[derive(Debug)]
pub(crate) struct Dataset {
    path: PathBuf,
    name: String,
    inner: hdf5::Dataset,
    place: Place,
    /// Elements along each axis, slowest first; empty for a scalar.
    pub(crate) shape: Vec<usize>,
    /// What the elements are.
    pub(crate) kind: Kind,
    /// Elements of a chunk along each axis, where the dataset is cut into chunks.
    pub(crate) chunk: Option<Vec<usize>>,
    /// Whether chunks are compressed or otherwise changed.
    pub(crate) filtered: bool,
    /// What undoes that here; none where only libhdf5 can.
    pipeline: Option<Pipeline>,
    /// Chunks beyond the edge of the shape did not go through the filters.
    edges_unfiltered: bool,
    element_bytes: usize,
    /// Bytes in the file, which two datasets of a hostile file may share but not exceed.
    stored_bytes: u64,
}

impl Dataset {
    /// Looks at a dataset; `None` where it has no value.
    pub(super) fn look(
        path: &Path,
        name: String,
        dataset: hdf5::Dataset,
        place: Place,
    ) -> Result<Option<Self>, ReadError> {
        let damaged = |error: hdf5::Error| ReadError::Malformed {
            path: path.to_owned(),
            place: name.clone(),
            what: unreadable(&error),
        };
        let space = dataset.space().map_err(damaged)?;
        if space.is_null() {
            return Ok(None);
        }
        let shape = space.shape();
        let dtype = dataset.dtype().map_err(damaged)?;
        let kind = dtype.to_descriptor().map_or(Kind::Other, |d| kind(&d));
        let element_bytes = match kind {
            // In memory it would be a pointer.
            Kind::VariableText => REFERENCE_BYTES,
            _ => dtype.size(),
        };
        let plist = dataset.dcpl().map_err(damaged)?;
        let chunk = plist.get_chunk().map_err(damaged)?;
        let filters = filter::pipeline(&plist);
        let file_bytes = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
        let found = Self {
            stored_bytes: dataset.storage_size().min(file_bytes),
            pipeline: (filters.as_ref().ok())
                .filter(|list| !list.is_empty())
                .and_then(|list| Pipeline::new(list, element_bytes)),
            filtered: filters.as_ref().map_or(true, |list| !list.is_empty()),
            edges_unfiltered: plist
                .chunk_opts()
                .is_some_and(|opts| opts.contains(ChunkOpts::DONT_FILTER_PARTIAL_CHUNKS)),
            path: path.to_owned(),
            name,
            inner: dataset,
            place,
            shape,
            kind,
            chunk,
            element_bytes,
        };
        found.check_place(&plist)?;
        filters
            .and_then(|list| filter::check(&list))
            .map_err(|what| found.unsupported(what))?;
        found.check_shape()?;
        Ok(Some(found))
    }

    /// The data must stand in this file.
    fn check_place(&self, plist: &hdf5::plist::DatasetCreate) -> Result<(), ReadError> {
        if plist.get_external().map_or(true, |list| !list.is_empty()) {
            return Err(self.unsupported(ELSEWHERE));
        }
        Ok(())
    }

    fn check_shape(&self) -> Result<(), ReadError> {
        if self.element_bytes == 0 || self.bytes() > u128::from(u64::MAX >> 1) {
            let what = format!(
                "its shape {:?} is of more bytes than any file has",
                self.shape
            );
            return Err(self.malformed(what));
        }
        if self.filtered && self.chunk_bytes() > MAX_FILTERED_CHUNK_BYTES {
            let what = format!(
                "its chunks are of {} bytes each and have to be unpacked whole; write smaller ones, \
                 with h5repack",
                self.chunk_bytes()
            );
            return Err(self.unsupported(what));
        }
        Ok(())
    }

    fn bytes(&self) -> u128 {
        product(&self.shape).saturating_mul(self.element_bytes as u128)
    }

    fn chunk_bytes(&self) -> u64 {
        let elements = self.chunk.as_deref().map_or(1, product);
        u64::try_from(elements.saturating_mul(self.element_bytes as u128)).unwrap_or(u64::MAX)
    }

    /// Makes sure that the file can hold what the shape announces.
    ///
    /// Must come before an allocation of the dataset's size. Of chunked data that were written in
    /// part only this says no: use [`stored_part`](Self::stored_part) for those.
    pub(crate) fn prove_stored(&self) -> Result<(), ReadError> {
        let stored = u128::from(self.stored_bytes);
        let possible = if self.filtered {
            stored.saturating_mul(MAX_EXPANSION)
        } else {
            stored
        };
        if self.bytes() > possible {
            let what = format!(
                "its shape {:?} announces {} bytes, the file has {stored} for it: it is truncated, \
                 unfinished or the header is wrong",
                self.shape,
                self.bytes()
            );
            return Err(self.malformed(what));
        }
        Ok(())
    }

    /// Chunks written and chunks in all; equal for data that are not cut into chunks.
    pub(crate) fn stored_part(&self) -> Result<(u128, u128), ReadError> {
        let Some(chunk) = &self.chunk else {
            self.prove_stored()?;
            return Ok((1, 1));
        };
        let counts = self.shape.iter().zip(chunk);
        let wanted = counts
            .map(|(&n, &c)| n.div_ceil(c.max(1)) as u128)
            .product();
        let written = self.inner.num_chunks().unwrap_or(0) as u128;
        Ok((written, wanted))
    }

    /// Makes sure that what is read in one piece is there, and that there is room for it.
    fn check_size(&self, bytes: u128) -> Result<(), ReadError> {
        self.prove_stored()?;
        if bytes > MAX_HEADER_BYTES {
            let what = format!("its shape {:?} is more than a header can have", self.shape);
            return Err(self.unsupported(what));
        }
        Ok(())
    }

    /// All of it, as a block.
    fn all(&self) -> Vec<(usize, usize)> {
        self.shape.iter().map(|&n| (0, n)).collect()
    }

    /// All elements, in the order of the file.
    pub(super) fn read_all<T: H5Type>(&self) -> Result<Vec<T>, ReadError> {
        self.check_size(product(&self.shape).saturating_mul(size_of::<T>() as u128))?;
        self.check_chunks(&self.all())?;
        let read = self.inner.read_raw();
        read.map_err(|error| self.damaged("", &error))
    }

    /// The elements of a block: first element and count along each axis, none of them beyond the
    /// shape. What that allocates is the caller's choice.
    pub(crate) fn read_block<T: Plain>(
        &self,
        block: &[(usize, usize)],
    ) -> Result<Vec<T>, ReadError> {
        match (&self.chunk, &self.pipeline) {
            (Some(chunk), Some(pipeline)) if self.holds::<T>() => {
                chunks::read(self, block, chunk, pipeline)
            }
            _ => self.read_converted(block),
        }
    }

    /// Complex numbers of whichever parts. Whole ones, as correlators write them, are converted here, which
    /// libhdf5 does one member at a time.
    pub(crate) fn read_complex(
        &self,
        block: &[(usize, usize)],
    ) -> Result<Vec<Complex<f32>>, ReadError> {
        if !self.holds::<WholeComplex>() {
            return self.read_block(block);
        }
        let whole = self.read_block::<WholeComplex>(block)?;
        let real = |pair: &WholeComplex| Complex::new(pair.r as f32, pair.i as f32);
        Ok(whole.iter().map(real).collect())
    }

    /// The same for any type, into which libhdf5 converts.
    pub(super) fn read_converted<T: H5Type>(
        &self,
        block: &[(usize, usize)],
    ) -> Result<Vec<T>, ReadError> {
        self.check_chunks(block)?;
        self.read_by_library(block)
    }

    /// Makes sure that the chunks of a block are whole, if they are packed.
    /// Makes sure that all texts can be found, before libhdf5 looks for them.
    pub(super) fn check_texts(&self) -> Result<(), ReadError> {
        self.check_size(self.bytes())?;
        let damaged = |what| self.malformed(format!("{what}; {COPY_AGAIN}"));
        let mut raw = RawFile::open(&self.path).map_err(damaged)?;
        match (&self.place, &self.chunk) {
            (Place::Header(bytes), _) => collections::check(&mut raw, bytes).map_err(damaged),
            (Place::At(first), _) => (raw.bytes(*first, self.bytes() as usize))
                .and_then(|bytes| collections::check(&mut raw, &bytes))
                .map_err(damaged),
            (_, Some(chunk)) => {
                let bare = Pipeline::default();
                let pipeline = match &self.pipeline {
                    None if self.filtered => return Err(self.unsupported("packed texts")),
                    pipeline => pipeline.as_ref().unwrap_or(&bare),
                };
                let check = |bytes: &[u8]| collections::check(&mut raw, bytes).map_err(damaged);
                chunks::each(self, &self.all(), chunk, pipeline, check)
            }
            _ => Ok(()),
        }
    }

    fn check_chunks(&self, block: &[(usize, usize)]) -> Result<(), ReadError> {
        match (&self.chunk, &self.pipeline) {
            (Some(chunk), Some(pipeline)) => chunks::check(self, block, chunk, pipeline),
            _ => Ok(()),
        }
    }

    /// Whether the elements are of type `T` to the byte.
    fn holds<T: H5Type>(&self) -> bool {
        let is_byte = self.kind == Kind::Boolean && self.element_bytes == 1 && size_of::<T>() == 1;
        let is_same = |dtype: hdf5::Datatype| {
            hdf5::Datatype::from_type::<T>().is_ok_and(|wanted| wanted == dtype)
        };
        is_byte || self.inner.dtype().is_ok_and(is_same)
    }

    /// Bytes of an element in the file.
    pub(super) fn element_bytes(&self) -> usize {
        self.element_bytes
    }

    /// The bytes of the chunk that begins at `first`, and a bit for each filter that it did not go through;
    /// none if it was never written.
    pub(super) fn packed_chunk(
        &self,
        first: &[usize],
    ) -> Result<Option<(Vec<u8>, u32)>, ReadError> {
        let at = || format!("the chunk at {first:?} ");
        let damaged = |error: hdf5::Error| self.damaged(&at(), &error);
        let Some(bytes) = raw::chunk_bytes(&self.inner, first).map_err(damaged)? else {
            // One that has a place but no bytes can be asked for, and would be unpacked from what follows it.
            return match raw::read_chunk(&self.inner, first, 0) {
                Ok(_) => Err(self.malformed(format!("{}has no bytes; {COPY_AGAIN}", at()))),
                Err(_) => Ok(None),
            };
        };
        if bytes > self.stored_bytes {
            let what = format!(
                "{}has {bytes} bytes, more than there are: the file is damaged or truncated: copy it again",
                at()
            );
            return Err(self.malformed(what));
        }
        let (packed, left_out) = raw::read_chunk(&self.inner, first, bytes).map_err(damaged)?;
        // libhdf5 knows of these without the mask.
        let is_bare = self.edges_unfiltered && self.overhangs(first);
        Ok(Some((packed, if is_bare { u32::MAX } else { left_out })))
    }

    /// Whether the chunk that begins at `first` reaches beyond the shape.
    fn overhangs(&self, first: &[usize]) -> bool {
        let chunk = self.chunk.iter().flatten();
        let mut ends = first.iter().zip(chunk).zip(&self.shape);
        ends.any(|((first, n), end)| first + n > *end)
    }

    /// Reads a block of chunks that are known to be whole, or not packed.
    pub(super) fn read_by_library<T: H5Type>(
        &self,
        block: &[(usize, usize)],
    ) -> Result<Vec<T>, ReadError> {
        let spans: Vec<SliceOrIndex> = block
            .iter()
            .map(|&(first, count)| SliceOrIndex::from(first..first + count))
            .collect();
        let read = self
            .inner
            .read_slice::<T, _, ndarray::IxDyn>(Hyperslab::from(spans));
        let array = read.map_err(|error| {
            let (first, count) = block.first().copied().unwrap_or((0, 0));
            self.damaged(&format!("rows {} to {} ", first + 1, first + count), &error)
        })?;
        Ok(array.into_raw_vec_and_offset().0)
    }

    /// Where it stands, from the root.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The file is at fault here.
    pub(crate) fn malformed(&self, what: impl Into<String>) -> ReadError {
        ReadError::Malformed {
            path: self.path.clone(),
            place: self.name.clone(),
            what: what.into(),
        }
    }

    /// We cannot read what stands here.
    pub(crate) fn unsupported(&self, what: impl Into<String>) -> ReadError {
        ReadError::Unsupported {
            path: self.path.clone(),
            place: self.name.clone(),
            what: what.into(),
        }
    }

    /// The elements are not what they should be.
    pub(crate) fn wrong_kind(&self, wanted: &str) -> ReadError {
        let found = match self.kind {
            Kind::Whole => "whole numbers".to_owned(),
            Kind::Real => "real numbers".to_owned(),
            Kind::Boolean => "booleans".to_owned(),
            Kind::Complex => "complex numbers".to_owned(),
            Kind::FixedText(_) | Kind::VariableText => "text".to_owned(),
            Kind::Other => match self.inner.dtype().and_then(|t| t.to_descriptor()) {
                Ok(descriptor) => format!("type {descriptor}"),
                Err(_) => "a type that is not known".to_owned(),
            },
        };
        self.malformed(format!("must hold {wanted}, holds {found}"))
    }

    fn damaged(&self, rows: &str, error: &hdf5::Error) -> ReadError {
        self.malformed(format!("{rows}{}", unreadable(error)))
    }
}

#[cfg(test)]
impl Dataset {
    /// Address of the first chunk in the file.
    pub(super) fn first_chunk_at(&self) -> Option<usize> {
        self.inner.chunk_info(0).map(|info| info.addr as usize)
    }
}

fn product(counts: &[usize]) -> u128 {
    let terms = counts.iter().map(|&n| n as u128);
    terms.fold(1, u128::saturating_mul)
}

fn kind(descriptor: &TypeDescriptor) -> Kind {
    match descriptor {
        TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_) => Kind::Whole,
        TypeDescriptor::Float(_) => Kind::Real,
        TypeDescriptor::Boolean => Kind::Boolean,
        TypeDescriptor::FixedAscii(n) | TypeDescriptor::FixedUnicode(n) => Kind::FixedText(*n),
        TypeDescriptor::VarLenAscii | TypeDescriptor::VarLenUnicode => Kind::VariableText,
        TypeDescriptor::Compound(compound) => {
            let numeric = |d: &TypeDescriptor| matches!(kind(d), Kind::Whole | Kind::Real);
            let part = |name| compound.fields.iter().find(|field| field.name == name);
            match (compound.fields.len(), part("r"), part("i")) {
                (2, Some(r), Some(i)) if numeric(&r.ty) && numeric(&i.ty) => Kind::Complex,
                _ => Kind::Other,
            }
        }
        _ => Kind::Other,
    }
}
