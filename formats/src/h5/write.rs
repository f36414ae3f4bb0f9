//! Writing: values, texts, and datasets that grow.
//!
//! Times of creation are not kept and nothing else depends on the clock: the same values give the
//! same bytes. The oldest layout that libhdf5 knows is used, as h5py uses it, for the widest
//! readership.

use hdf5::types::{FixedAscii, TypeDescriptor};
use hdf5::{H5Type, Hyperslab, SliceOrIndex};
use ndarray::{ArrayViewD, IxDyn};

use super::words;

/// Names and texts of up to this many bytes go through memory of a fixed size.
const LINE_BYTES: usize = 256;

/// A file under construction.
#[derive(Debug)]
pub(crate) struct NewFile {
    file: hdf5::File,
}

/// A group under construction. Errors are in words.
#[derive(Debug)]
pub(crate) struct NewGroup {
    group: hdf5::Group,
}

/// A dataset whose first axis grows.
#[derive(Debug)]
pub(crate) struct Growing {
    dataset: hdf5::Dataset,
    /// Elements along the other axes.
    rest: Vec<usize>,
    len: usize,
}

/// How chunks are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Packing {
    /// Not at all.
    None,
    /// Bytes sorted by significance, and deflate at its fastest.
    ShuffleDeflate,
}

impl NewFile {
    /// An empty file at `path`, which is emptied if it is there.
    pub(crate) fn create(path: &std::path::Path) -> Result<Self, String> {
        let file = hdf5::File::create(path).map_err(|e| words(&e))?;
        Ok(Self { file })
    }

    /// A group at the root.
    pub(crate) fn group(&self, name: &str) -> Result<NewGroup, String> {
        let group = self.file.create_group(name).map_err(|e| words(&e))?;
        Ok(NewGroup { group })
    }

    /// Writes what is still in memory. Everything else of the file must have been dropped.
    pub(crate) fn close(self) -> Result<(), String> {
        self.file.flush().map_err(|e| words(&e))?;
        self.file.close().map_err(|e| words(&e))
    }
}

impl NewGroup {
    /// A group in this one.
    pub(crate) fn group(&self, name: &str) -> Result<Self, String> {
        let group = self.group.create_group(name).map_err(|e| words(&e))?;
        Ok(Self { group })
    }

    /// One value.
    pub(crate) fn value<T: H5Type>(&self, name: &str, value: T) -> Result<(), String> {
        self.array(name, &[], &[value])
    }

    /// Values in the order of the file.
    pub(crate) fn array<T: H5Type>(
        &self,
        name: &str,
        shape: &[usize],
        values: &[T],
    ) -> Result<(), String> {
        let view = ArrayViewD::from_shape(IxDyn(shape), values).map_err(|e| e.to_string())?;
        let builder = self.group.new_dataset_builder().with_data(view);
        builder.create(name).map(drop).map_err(|e| words(&e))
    }

    /// One text.
    pub(crate) fn text(&self, name: &str, text: &str) -> Result<(), String> {
        self.strings(name, &[], &[text])
    }

    /// Texts, in a list.
    pub(crate) fn texts(&self, name: &str, texts: &[String]) -> Result<(), String> {
        let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
        self.strings(name, &[texts.len()], &texts)
    }

    /// Texts of fixed length in the file, that of the longest, as the memo wants them.
    fn strings(&self, name: &str, shape: &[usize], texts: &[&str]) -> Result<(), String> {
        let clean: Vec<String> = texts.iter().map(|text| ascii(text)).collect();
        let bytes = clean.iter().map(String::len).max().unwrap_or(0).max(1);
        match bytes {
            0..=LINE_BYTES => self.fixed::<LINE_BYTES>(name, shape, bytes, &clean),
            257..=16_384 => self.fixed::<16_384>(name, shape, bytes, &clean),
            16_385..=1_048_576 => self.fixed::<1_048_576>(name, shape, bytes, &clean),
            _ => Err(format!("{name}: a text of {bytes} bytes is too long")),
        }
    }

    fn fixed<const N: usize>(
        &self,
        name: &str,
        shape: &[usize],
        bytes: usize,
        texts: &[String],
    ) -> Result<(), String> {
        let values: Result<Vec<FixedAscii<N>>, _> =
            texts.iter().map(FixedAscii::from_ascii).collect();
        let values = values.map_err(|error| format!("{name}: {error}"))?;
        let view = ArrayViewD::from_shape(IxDyn(shape), &values).map_err(|e| e.to_string())?;
        let builder = self
            .group
            .new_dataset_builder()
            .with_data_as(view, &TypeDescriptor::FixedAscii(bytes));
        builder.create(name).map(drop).map_err(|e| words(&e))
    }

    /// A dataset of no rows yet, in chunks of the shape `chunk`.
    pub(crate) fn growing<T: H5Type>(
        &self,
        name: &str,
        rest: &[usize],
        chunk: &[usize],
        packing: Packing,
    ) -> Result<Growing, String> {
        let mut extents = vec![hdf5::Extent::resizable(0)];
        extents.extend(rest.iter().map(|&n| hdf5::Extent::fixed(n)));
        let mut builder = self
            .group
            .new_dataset_builder()
            .empty::<T>()
            .shape(hdf5::SimpleExtents::new(extents))
            .chunk(chunk);
        if packing == Packing::ShuffleDeflate {
            builder = builder.shuffle().deflate(1);
        }
        Ok(Growing {
            dataset: builder.create(name).map_err(|e| words(&e))?,
            rest: rest.to_vec(),
            len: 0,
        })
    }
}

impl Growing {
    /// Appends rows.
    pub(crate) fn append<T: H5Type>(&mut self, values: &[T]) -> Result<(), String> {
        let per_row: usize = self.rest.iter().product();
        let n_row = values.len() / per_row.max(1);
        if n_row == 0 {
            return Ok(());
        }
        let mut shape = vec![self.len + n_row];
        shape.extend(&self.rest);
        self.dataset
            .resize(shape.as_slice())
            .map_err(|e| words(&e))?;
        let mut spans = vec![SliceOrIndex::from(self.len..self.len + n_row)];
        spans.extend(self.rest.iter().map(|&n| SliceOrIndex::from(0..n)));
        shape[0] = n_row;
        let view = ArrayViewD::from_shape(IxDyn(&shape), values).map_err(|e| e.to_string())?;
        self.dataset
            .write_slice(view, Hyperslab::from(spans))
            .map_err(|e| words(&e))?;
        self.len += n_row;
        Ok(())
    }
}

/// Readers take the texts for ASCII: what is not becomes a question mark, as does a NUL.
fn ascii(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_ascii() && c != '\0' { c } else { '?' })
        .collect()
}
