//! What `table.dat` says of the columns, and of the storage managers that keep them.

use std::ops::RangeInclusive;

use super::keywords;
use super::others;
use super::stream::{Stream, check_version};
use super::types::{MAX_AXES, TEXT, bits};

/// Layouts that are known; those before are of the years before Measurement Sets of version 2.
const TABLE_VERSIONS: RangeInclusive<u32> = 2..=3;
const DESCRIPTION_VERSIONS: RangeInclusive<u32> = 2..=2;
const LIST_VERSIONS: RangeInclusive<u32> = 2..=3;
const COLUMN_VERSIONS: RangeInclusive<u32> = 2..=2;

/// Options of a column: its arrays are beside the other columns, not in a file of their own.
const DIRECT: u32 = 1;

/// A manager and what it keeps.
#[derive(Debug)]
pub(super) struct Managed<'a> {
    /// Its class.
    pub(super) class: String,
    /// The number in the name of its file.
    pub(super) file: u32,
    /// Its columns, in their order.
    pub(super) columns: Vec<Column>,
    /// What it says itself.
    pub(super) own: Stream<'a>,
}

#[derive(Debug, Clone)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) data_type: u32,
    pub(super) held: Held,
    /// Of texts, if they are not longer than some number of bytes.
    pub(super) max_length: u32,
}

/// What is in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Held {
    Value,
    /// An array of so many.
    Values(u64),
    /// Where an array is.
    Elsewhere,
}

/// What the description of a table says of a column.
struct Described {
    name: String,
    kind: Kind,
    data_type: u32,
    options: u32,
    max_length: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Scalar,
    Array,
    Record,
}

/// What a table is made of.
#[derive(Debug)]
pub(super) enum Made<'a> {
    /// Columns that storage managers keep.
    Columns(Vec<Managed<'a>>),
    /// Other tables, by their names.
    Others(Vec<String>),
}

/// Looks through `table.dat`.
pub(super) fn read(table_dat: &[u8]) -> Result<Made<'_>, String> {
    let stream = &mut Stream::new(table_dat, true);
    let version = stream.outermost()?.known(TABLE_VERSIONS)?;
    let n_row = stream.grown(version > 2)?;
    stream.u32()?;
    match stream.text()?.as_str() {
        "PlainTable" => managed(stream).map(Made::Columns),
        "RefTable" => others::selection(stream, n_row).map(|name| Made::Others(vec![name])),
        "ConcatTable" => others::concatenation(stream).map(Made::Others),
        // casacore knows no other, and says so.
        _ => Ok(Made::Others(Vec::new())),
    }
}

fn managed<'a>(stream: &mut Stream<'a>) -> Result<Vec<Managed<'a>>, String> {
    let described = description(stream)?;
    let managers = managers(stream)?;
    let columns: Result<Vec<_>, _> = described
        .into_iter()
        .map(|one| column(stream, one))
        .collect();
    let columns = columns?;
    let managed = managers.into_iter().map(|(class, file)| {
        let mine = columns.iter().filter(|(of, _)| *of == file);
        Ok(Managed {
            class,
            file,
            columns: mine.map(|(_, column)| column.clone()).collect(),
            own: stream.part()?,
        })
    });
    managed.collect()
}

/// The columns as they are described, in their order.
fn description(stream: &mut Stream) -> Result<Vec<Described>, String> {
    let table = stream.object()?;
    table.known(DESCRIPTION_VERSIONS)?;
    for _ in 0..3 {
        stream.text()?;
    }
    keywords::pass(stream)?;
    // Private ones.
    keywords::pass(stream)?;
    let columns: Result<_, _> = (0..stream.u32()?).map(|_| described(stream)).collect();
    stream.leave(&table);
    columns
}

fn described(stream: &mut Stream) -> Result<Described, String> {
    stream.u32()?;
    let class = stream.text()?;
    let kind = match class.split('<').next() {
        Some("ScalarColumnDesc") => Kind::Scalar,
        Some("ArrayColumnDesc") => Kind::Array,
        Some("ScalarRecordColumnDesc") => Kind::Record,
        _ => return Err(format!("a column is of class {class}, which is not known")),
    };
    stream.u32()?;
    let name = stream.text()?;
    // A comment, the kind of manager and its group.
    for _ in 0..3 {
        stream.text()?;
    }
    let (data_type, options, n_axis) = (stream.u32()?, stream.u32()?, stream.u32()? as i32);
    // Negative where it is not known.
    if n_axis > MAX_AXES as i32 {
        return Err(format!("column {name} has {n_axis} axes"));
    }
    if kind == Kind::Array {
        stream.shape()?;
    }
    let max_length = stream.u32()?;
    keywords::pass(stream)?;
    stream.u32()?;
    match kind {
        // The value of cells that nobody has written.
        Kind::Scalar if data_type == TEXT => drop(stream.text()?),
        Kind::Scalar => {
            let bits = bits(data_type).ok_or_else(|| {
                format!("column {name} is of type {data_type}, which is not known")
            })?;
            stream.pass(bits.div_ceil(8))?;
        }
        Kind::Array => drop(stream.byte()?),
        Kind::Record => {}
    }
    Ok(Described {
        name,
        kind,
        data_type,
        options,
        max_length,
    })
}

/// Kinds of the managers and the numbers of their files, in their order.
fn managers(stream: &mut Stream) -> Result<Vec<(String, u32)>, String> {
    // Negative, so that it is no number of rows, with which the first layout began.
    let version = (stream.u32()? as i32).wrapping_neg() as u32;
    check_version("the list of storage managers", version, LIST_VERSIONS)?;
    stream.grown(version > 2)?;
    if version > 2 {
        stream.u64()?;
    }
    stream.u32()?;
    let n = stream.u32()?;
    (0..n)
        .map(|_| Ok((stream.text()?, stream.u32()?)))
        .collect()
}

/// The number of a column's manager, and how that keeps it.
fn column(stream: &mut Stream, described: Described) -> Result<(u32, Column), String> {
    check_version("a column", stream.u32()?, COLUMN_VERSIONS)?;
    stream.text()?;
    stream.u32()?;
    let manager = stream.u32()?;
    let is_array = described.kind == Kind::Array;
    let shape = if is_array && stream.byte()? != 0 {
        stream.shape()?
    } else {
        Vec::new()
    };
    let held = match described.kind {
        Kind::Scalar => Held::Value,
        Kind::Array if described.options & DIRECT != 0 => match elements(&shape) {
            Some(n) => Held::Values(n),
            None => return Err(format!("column {} has shape {shape:?}", described.name)),
        },
        Kind::Array | Kind::Record => Held::Elsewhere,
    };
    let column = Column {
        name: described.name,
        data_type: described.data_type,
        held,
        max_length: described.max_length,
    };
    Ok((manager, column))
}

fn elements(shape: &[i64]) -> Option<u64> {
    let mut lens = shape.iter().map(|&len| u64::try_from(len).ok());
    lens.try_fold(1, |product: u64, len| product.checked_mul(len?))
}
