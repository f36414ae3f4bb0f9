//! Headers and indices of standard storage managers.
//!
//! Rows are in buckets of the same length; an index, in buckets of its own, tells the last row of each.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use super::columns::Columns;
use super::stream::Stream;

/// Where buckets begin.
const HEADER_BYTES: u64 = 512;
/// What a bucket of an index begins with: where the next is, twice.
const LINK_BYTES: u64 = 8;
/// Newest layout that is known.
const VERSION: u32 = 3;

/// What the header says.
#[derive(Debug)]
pub(super) struct Header {
    bucket_bytes: u64,
    n_bucket: u64,
    /// Buckets of the indices, and the first of these.
    n_link: u64,
    first: u64,
    /// Where in its bucket the indices begin, if they are in one with something else.
    offset: u64,
    index_bytes: u64,
    n_index: u32,
}

/// Looks at the header and through the indices.
pub(super) fn check(file: &mut File, big: bool) -> Result<Header, String> {
    let header = header(&read(file, 0, HEADER_BYTES)?, big)?;
    let index = index(file, &header)?;
    // Each is a stream of its own.
    let mut stream = Stream::new(&index, big);
    for i in 0..header.n_index {
        rows(&mut stream, &header).map_err(|what| format!("index {i}: {what}"))?;
    }
    Ok(header)
}

/// Whether columns can be where they are said to be.
pub(super) fn check_columns(header: &Header, columns: &Columns) -> Result<(), String> {
    let n_index = u64::from(header.n_index);
    if let Some(index) = columns.indices.iter().find(|&&index| index >= n_index) {
        return Err(format!("a column is in index {index}, of {n_index}"));
    }
    let n_byte = header.bucket_bytes;
    match columns.offsets.iter().find(|&&offset| offset >= n_byte) {
        Some(offset) => Err(format!(
            "a column begins at byte {offset} of {n_byte} in a bucket"
        )),
        None => Ok(()),
    }
}

/// Bytes from a place on; fewer at the end of the file.
fn read(file: &mut File, at: u64, n_byte: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let found = file.seek(SeekFrom::Start(at));
    let found = found.and_then(|_| file.take(n_byte).read_to_end(&mut bytes));
    found.map(|_| bytes).map_err(|error| error.to_string())
}

fn header(bytes: &[u8], big: bool) -> Result<Header, String> {
    let mut stream = Stream::new(bytes, big);
    let version = stream.outermost()?.version;
    if version > VERSION {
        return Err(format!(
            "is of layout {version}, {VERSION} is the newest known"
        ));
    }
    if version >= 3 {
        stream.byte()?;
    }
    let (bucket_bytes, n_bucket) = (stream.u32()?, stream.u32()?);
    for _ in 0..3 {
        stream.u32()?;
    }
    let (n_link, first) = (stream.u32()?, stream.u32()?);
    let offset = if version >= 2 { stream.u32()? } else { 0 };
    stream.u32()?;
    let (index_bytes, n_index) = (stream.u32()?, stream.u32()?);
    let header = Header {
        bucket_bytes: bucket_bytes.into(),
        n_bucket: n_bucket.into(),
        n_link: n_link.into(),
        first: first.into(),
        offset: offset.into(),
        index_bytes: index_bytes.into(),
        n_index,
    };
    if header.bucket_bytes <= LINK_BYTES {
        return Err(format!("its buckets have {bucket_bytes} bytes"));
    }
    Ok(header)
}

/// The bytes of all indices, bucket by bucket.
fn index(file: &mut File, header: &Header) -> Result<Vec<u8>, String> {
    let start = |bucket: u64| HEADER_BYTES + bucket * header.bucket_bytes;
    if header.offset > 0 {
        let at = start(header.first) + header.offset;
        return read(file, at, header.index_bytes);
    }
    let per_link = header.bucket_bytes - LINK_BYTES;
    let (n_byte, n_link) = (header.index_bytes, header.n_link);
    if n_link.saturating_sub(1) * per_link > n_byte || n_link * per_link < n_byte {
        return Err(format!("has indices of {n_byte} bytes in {n_link} buckets"));
    }
    let mut bytes = Vec::new();
    let mut bucket = header.first;
    for _ in 0..n_link {
        let n_byte = per_link.min(n_byte - bytes.len() as u64);
        let link = read(file, start(bucket), LINK_BYTES + n_byte)?;
        let mut stream = Stream::new(&link, true);
        stream.u32()?;
        bucket = stream.u32()?.into();
        bytes.extend(&link[LINK_BYTES as usize..]);
    }
    Ok(bytes)
}

/// Which rows are in which bucket.
fn rows(stream: &mut Stream, header: &Header) -> Result<(), String> {
    let version = stream.outermost()?.version;
    let n_used = stream.u32()? as usize;
    let per_bucket = u64::from(stream.u32()?);
    stream.u32()?;
    stream.skip()?;
    if per_bucket > 8 * header.bucket_bytes {
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
    match buckets[..n_used].iter().find(|&&at| at >= header.n_bucket) {
        Some(at) => Err(format!("has rows in bucket {at}, of {}", header.n_bucket)),
        None => Ok(()),
    }
}
