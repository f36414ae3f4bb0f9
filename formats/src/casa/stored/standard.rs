//! Headers and indices of standard storage managers.
//!
//! Rows are in buckets of the same length; an index, in buckets of its own, tells the last row of each.

use std::fs::File;
use std::path::Path;

use super::arrays::Arrays;
use super::buckets::{Buckets, HEADER_BYTES};
use super::columns::{Column, Held, Managed};
use super::stream::{Stream, length, read};
use super::texts;
use super::types::{TEXT, bits};

/// What a bucket of an index begins with: where the next is, twice.
const LINK_BYTES: u64 = 8;
/// Newest layout that is known.
const VERSION: u32 = 3;

/// What a cell says of something that is elsewhere: of a text, of an array.
const TEXT_BITS: u64 = 96;
const ARRAY_BITS: u64 = 64;

/// What the header says.
#[derive(Debug)]
struct Header {
    buckets: Buckets,
    /// Buckets of the indices, and the first of these.
    n_link: u64,
    first: u64,
    /// Where in its bucket the indices begin, if they are in one with something else.
    offset: u64,
    index_bytes: u64,
    n_index: u32,
}

/// A file of which the header and the indices have been looked at.
#[derive(Debug)]
pub(super) struct Manager {
    file: File,
    /// Whether the most significant byte comes first, in the indices and in cells.
    big: bool,
    header: Header,
    indices: Vec<Index>,
}

/// Which rows are in which bucket.
#[derive(Debug)]
struct Index {
    /// Most rows of a bucket.
    per_bucket: u64,
    /// The last row of each bucket, and which it is.
    buckets: Vec<(u64, u64)>,
}

/// Where a column is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// From which byte of a bucket on.
    offset: u64,
    index: usize,
}

/// Looks through the file of a manager.
pub(super) fn check(path: &Path, file: File, big: bool, managed: &Managed) -> Result<(), String> {
    let manager = Manager::open(file, big)?;
    let arrays = Arrays::open(path, big)?;
    let places = places(managed.own, managed.columns.len())?;
    for (column, (offset, index)) in managed.columns.iter().zip(places) {
        let told = |what| format!("column {}: {what}", column.name);
        let place = manager.place(column, offset, index).map_err(told)?;
        if is_text(column) {
            texts::check(&manager, place).map_err(told)?;
        } else if let Some(arrays) = arrays.as_ref().filter(|_| is_elsewhere(column)) {
            let check = |cells: &mut Stream| arrays.check(cells.u64()?);
            (manager.check_cells(place, ARRAY_BITS / 8, check)).map_err(told)?;
        }
    }
    Ok(())
}

/// Where each column begins in a bucket, and which index it has.
fn places(mut own: Stream, n: usize) -> Result<Vec<(u64, u64)>, String> {
    own.outermost()?;
    own.text()?;
    let (offsets, indices) = (own.list(false)?, own.list(false)?);
    if offsets.len() < n || indices.len() < n {
        let said = offsets.len().min(indices.len());
        return Err(format!(
            "has {n} columns, table.dat says of {said} where they are"
        ));
    }
    Ok(offsets.into_iter().zip(indices).take(n).collect())
}

/// Whether cells are texts of any length.
fn is_text(column: &Column) -> bool {
    column.data_type == TEXT && column.held == Held::Value && column.max_length == 0
}

/// Whether cells are places of arrays in another file.
fn is_elsewhere(column: &Column) -> bool {
    column.data_type != TEXT && column.held == Held::Elsewhere
}

/// What a row takes; nothing is known of other types than those that there are.
fn cell_bits(column: &Column) -> u64 {
    let of_one = bits(column.data_type).unwrap_or(0);
    match (column.data_type, column.held) {
        (TEXT, Held::Value) if column.max_length > 0 => 8 * u64::from(column.max_length),
        (TEXT, _) => TEXT_BITS,
        (_, Held::Value) => of_one,
        (_, Held::Values(n)) => n.saturating_mul(of_one),
        (_, Held::Elsewhere) => ARRAY_BITS,
    }
}

impl Manager {
    /// Looks at the header and through the indices.
    fn open(file: File, big: bool) -> Result<Self, String> {
        let header = header(&file, big)?;
        let bytes = index(&file, &header)?;
        // Each is a stream of its own.
        let mut stream = Stream::new(&bytes, big);
        let mut indices = Vec::new();
        for i in 0..header.n_index {
            let index = rows(&mut stream, &header);
            indices.push(index.map_err(|what| format!("index {i}: {what}"))?);
        }
        Ok(Self {
            file,
            big,
            header,
            indices,
        })
    }

    /// Where a column is, if it can be there.
    fn place(&self, column: &Column, offset: u64, index: u64) -> Result<Place, String> {
        let n_index = self.indices.len();
        let index = usize::try_from(index).unwrap_or(usize::MAX);
        let per_bucket = match self.indices.get(index) {
            Some(index) => index.per_bucket,
            None => return Err(format!("is in index {index}, of {n_index}")),
        };
        let n_byte = self.header.buckets.n_byte;
        let cells = per_bucket.saturating_mul(cell_bits(column)).div_ceil(8);
        if offset.saturating_add(cells) > n_byte {
            return Err(format!(
                "has {cells} bytes from byte {offset} on, of {n_byte} in a bucket"
            ));
        }
        Ok(Place { offset, index })
    }

    /// Looks at the cells of a column, of so many bytes each.
    pub(super) fn check_cells(
        &self,
        place: Place,
        n_byte: u64,
        check: impl Fn(&mut Stream) -> Result<(), String>,
    ) -> Result<(), String> {
        let mut row = 0;
        for &(last, bucket) in &self.indices[place.index].buckets {
            let end = last.saturating_add(1);
            let bytes = self.read(bucket, place.offset, (end - row) * n_byte)?;
            let mut cells = Stream::new(&bytes, self.big);
            while row < end {
                check(&mut cells).map_err(|what| format!("row {row}: {what}"))?;
                row += 1;
            }
        }
        Ok(())
    }

    /// Some bytes of a bucket; fewer at the end of the file.
    pub(super) fn read(&self, bucket: u64, at: u64, n_byte: u64) -> Result<Vec<u8>, String> {
        let n_bucket = self.header.buckets.n;
        if bucket >= n_bucket {
            return Err(format!("is in bucket {bucket}, of {n_bucket}"));
        }
        let start = self.header.buckets.start(bucket) + at;
        read(&self.file, start, n_byte)
    }

    /// Buckets that there are.
    pub(super) fn n_bucket(&self) -> u64 {
        self.header.buckets.n_there
    }

    pub(super) fn bucket_bytes(&self) -> u64 {
        self.header.buckets.n_byte
    }
}

fn header(file: &File, big: bool) -> Result<Header, String> {
    let n_byte = length(file)?;
    let bytes = read(file, 0, HEADER_BYTES)?;
    let mut stream = Stream::new(&bytes, big);
    let version = stream.outermost()?.known(0..=VERSION)?;
    if version >= 3 {
        stream.byte()?;
    }
    let buckets = Buckets::read(&mut stream, n_byte)?;
    for _ in 0..2 {
        stream.u32()?;
    }
    let (n_link, first) = (stream.u32()?, stream.u32()?);
    let offset = if version >= 2 { stream.u32()? } else { 0 };
    stream.u32()?;
    let (index_bytes, n_index) = (stream.u32()?, stream.u32()?);
    Ok(Header {
        buckets,
        n_link: n_link.into(),
        first: first.into(),
        offset: offset.into(),
        index_bytes: index_bytes.into(),
        n_index,
    })
}

/// The bytes of all indices, bucket by bucket.
fn index(file: &File, header: &Header) -> Result<Vec<u8>, String> {
    let (n_byte, n_link) = (header.index_bytes, header.n_link);
    if header.offset > 0 {
        let at = header.buckets.start(header.first) + header.offset;
        let bytes = read(file, at, n_byte)?;
        return match bytes.len() as u64 {
            there if there < n_byte => {
                Err(format!("announces {n_byte} bytes of indices, has {there}"))
            }
            _ => Ok(bytes),
        };
    }
    let per_link = header.buckets.n_byte - LINK_BYTES;
    if n_link.saturating_sub(1) * per_link > n_byte || n_link * per_link < n_byte {
        return Err(format!("has indices of {n_byte} bytes in {n_link} buckets"));
    }
    let mut bytes = Vec::new();
    let mut bucket = header.first;
    for _ in 0..n_link {
        let n_byte = per_link.min(n_byte - bytes.len() as u64);
        let link = read(file, header.buckets.start(bucket), LINK_BYTES + n_byte)?;
        let mut stream = Stream::new(&link, true);
        stream.u32()?;
        bucket = stream.u32()?.into();
        stream.pass(n_byte)?;
        bytes.extend(&link[LINK_BYTES as usize..]);
    }
    Ok(bytes)
}

/// Which rows are in which bucket.
fn rows(stream: &mut Stream, header: &Header) -> Result<Index, String> {
    let version = stream.outermost()?.version;
    let n_used = stream.u32()? as usize;
    let per_bucket = u64::from(stream.u32()?);
    stream.u32()?;
    stream.skip()?;
    if per_bucket > 8 * header.buckets.n_byte {
        return Err(format!(
            "has {per_bucket} rows in a bucket, which have not room there"
        ));
    }
    let (last_rows, buckets) = (stream.list(version > 1)?, stream.list(false)?);
    if last_rows.len() < n_used || buckets.len() < n_used {
        return Err(format!("has not the {n_used} buckets that it announces"));
    }
    let mut next = 0;
    for &last in &last_rows[..n_used] {
        if last < next || last - next >= per_bucket {
            return Err(format!(
                "has rows {next} to {last} in one bucket, which can have {per_bucket}"
            ));
        }
        next = last.saturating_add(1);
    }
    match buckets[..n_used].iter().find(|&&at| at >= header.buckets.n) {
        Some(at) => Err(format!("has rows in bucket {at}, of {}", header.buckets.n)),
        None => Ok(Index {
            per_bucket,
            buckets: last_rows.into_iter().zip(buckets).take(n_used).collect(),
        }),
    }
}
