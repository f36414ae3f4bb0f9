//! Buckets of incremental storage managers.
//!
//! A value is kept once for all rows from its own to the next that has another. In a bucket are first the values, and
//! then, for each column, the rows where one begins, and where each is.

use std::fs::File;
use std::path::Path;

use super::arrays::Arrays;
use super::buckets::{Buckets, HEADER_BYTES};
use super::columns::{Column, Held, Managed};
use super::stream::{Stream, length, read};
use super::types::{TEXT, bits};

/// Newest layout that is known.
const VERSION: u32 = 5;
/// An index has some 12 bytes for each bucket, of which most have 32 kilobytes.
const MAX_INDEX_BYTES: u64 = 1 << 28;
/// casacore has 28 bits for a place in a bucket; the rest tells that row numbers are of 64 bits.
const PLACE_BITS: u32 = 28;
/// Bytes of the place of the index, with which a bucket begins.
const START_BYTES: usize = 4;

/// Looks through the file of a manager.
pub(super) fn check(path: &Path, file: &File, big: bool, managed: &Managed) -> Result<(), String> {
    let mut own = managed.own;
    own.outermost()?;
    own.text()?;
    let arrays = Arrays::open(path, big)?;
    let n_byte = length(file)?;
    let all = header(&read(file, 0, HEADER_BYTES)?, big, n_byte)?;
    let index = read(file, all.start(all.n), MAX_INDEX_BYTES)?;
    for bucket in used(&index, big, all.n)? {
        let bytes = read(file, all.start(bucket), all.n_byte)?;
        check_bucket(&bytes, big, &managed.columns, arrays.as_ref())
            .map_err(|what| format!("bucket {bucket}: {what}"))?;
    }
    Ok(())
}

fn header(bytes: &[u8], big: bool, file_bytes: u64) -> Result<Buckets, String> {
    let mut stream = Stream::new(bytes, big);
    let version = stream.outermost()?.known(0..=VERSION)?;
    if version >= 5 {
        stream.byte()?;
    }
    Buckets::read(&mut stream, file_bytes)
}

/// The buckets in which there are rows.
fn used(index: &[u8], big: bool, n_bucket: u64) -> Result<Vec<u64>, String> {
    let mut stream = Stream::new(index, big);
    let is_wide = stream.outermost()?.version > 1;
    let n_used = stream.u32()? as usize;
    let (first_rows, mut buckets) = (stream.list(is_wide)?, stream.list(false)?);
    // After the first rows of all buckets comes the number of rows.
    if first_rows.len() <= n_used || buckets.len() < n_used {
        return Err(format!(
            "index: has not the {n_used} buckets that it announces"
        ));
    }
    if first_rows[0] != 0 || !first_rows[..=n_used].is_sorted() {
        return Err("index: its rows are not in order".into());
    }
    buckets.truncate(n_used);
    match buckets.iter().find(|&&at| at >= n_bucket) {
        Some(at) => Err(format!("index: has bucket {at}, of {n_bucket}")),
        None => Ok(buckets),
    }
}

fn check_bucket(
    bytes: &[u8],
    big: bool,
    columns: &[Column],
    arrays: Option<&Arrays>,
) -> Result<(), String> {
    let place = Stream::new(bytes, big).u32()?;
    let is_wide = place >> PLACE_BITS != 0;
    let place = place as usize & ((1 << PLACE_BITS) - 1);
    let (values, mut index) = match (bytes.get(START_BYTES..place), bytes.get(place..)) {
        (Some(values), Some(index)) => (values, Stream::new(index, big)),
        _ => return Err(format!("its index is at byte {place}, of {}", bytes.len())),
    };
    for column in columns {
        check_column(
            &mut index,
            is_wide,
            Stream::new(values, big),
            column,
            arrays,
        )
        .map_err(|what| format!("column {}: {what}", column.name))?;
    }
    Ok(())
}

fn check_column(
    index: &mut Stream,
    is_wide: bool,
    values: Stream,
    column: &Column,
    arrays: Option<&Arrays>,
) -> Result<(), String> {
    let n = index.u32()? as usize;
    let (rows, places) = (index.numbers(n, is_wide)?, index.numbers(n, false)?);
    // Every row is searched for the last that is not after it.
    if rows.first() != Some(&0) || !rows.is_sorted() {
        return Err("its rows are not in order".into());
    }
    places.into_iter().try_for_each(|place| {
        let mut values = values;
        let there = values.pass(place).and_then(|()| {
            let mut array = values;
            value(&mut values, column).map(|()| array.u64().unwrap_or(0))
        });
        let array = there.map_err(|_| format!("a value at byte {place} goes beyond the others"))?;
        match arrays {
            Some(arrays) if column.held == Held::Elsewhere => arrays.check(array),
            _ => Ok(()),
        }
    })
}

/// Passes over a value.
fn value(values: &mut Stream, column: &Column) -> Result<(), String> {
    let n = match column.held {
        Held::Elsewhere => return values.u64().map(drop),
        Held::Value => 1,
        Held::Values(n) => n,
    };
    if column.data_type != TEXT {
        let of_one = bits(column.data_type).unwrap_or(0);
        return values.pass(n.saturating_mul(of_one).div_ceil(8));
    }
    // The length of all, itself as well; each of several has its own.
    let length = values.u32()?;
    if n == 1 {
        let text = length.checked_sub(4).ok_or("is shorter than its length")?;
        return values.pass(text.into());
    }
    (0..n).try_for_each(|_| values.text().map(drop))
}
