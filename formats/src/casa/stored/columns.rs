//! What `table.dat` says of the columns, and of the storage managers that keep them.

use super::keywords;
use super::stream::Stream;
use super::types::{TEXT, bits};

/// Newest layouts that are known, of `table.dat` and of its list of managers.
const TABLE_VERSION: u32 = 3;
const LIST_VERSION: i32 = 3;

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

/// All managers; none where the layout is not known.
pub(super) fn read(table_dat: &[u8]) -> Result<Vec<Managed<'_>>, String> {
    Ok(known(&mut Stream::new(table_dat, true))?.unwrap_or_default())
}

fn known<'a>(stream: &mut Stream<'a>) -> Result<Option<Vec<Managed<'a>>>, String> {
    let version = stream.outermost()?.version;
    if !(2..=TABLE_VERSION).contains(&version) {
        return Ok(None);
    }
    stream.grown(version > 2)?;
    stream.u32()?;
    stream.text()?;
    let Some(described) = description(stream)? else {
        return Ok(None);
    };
    let Some(managers) = managers(stream)? else {
        return Ok(None);
    };
    let mut columns = Vec::new();
    for described in described {
        let Some(column) = column(stream, described)? else {
            return Ok(None);
        };
        columns.push(column);
    }
    let managed = managers.into_iter().map(|(class, file)| {
        let mine = columns.iter().filter(|(of, _)| *of == file);
        Ok(Managed {
            class,
            file,
            columns: mine.map(|(_, column)| column.clone()).collect(),
            own: stream.part()?,
        })
    });
    managed.collect::<Result<_, _>>().map(Some)
}

/// The columns as they are described, in their order.
fn description(stream: &mut Stream) -> Result<Option<Vec<Described>>, String> {
    let table = stream.object()?;
    // The first layout has no private keywords.
    if table.version < 2 {
        return Ok(None);
    }
    for _ in 0..3 {
        stream.text()?;
    }
    keywords::pass(stream)?;
    // Private ones.
    keywords::pass(stream)?;
    let mut columns = Vec::new();
    for _ in 0..stream.u32()? {
        let Some(column) = described(stream)? else {
            return Ok(None);
        };
        columns.push(column);
    }
    stream.leave(&table);
    Ok(Some(columns))
}

fn described(stream: &mut Stream) -> Result<Option<Described>, String> {
    stream.u32()?;
    let class = stream.text()?;
    let kind = match class.split('<').next() {
        Some("ScalarColumnDesc") => Kind::Scalar,
        Some("ArrayColumnDesc") => Kind::Array,
        Some("ScalarRecordColumnDesc") => Kind::Record,
        _ => return Ok(None),
    };
    stream.u32()?;
    let name = stream.text()?;
    // A comment, the kind of manager and its group.
    for _ in 0..3 {
        stream.text()?;
    }
    let (data_type, options) = (stream.u32()?, stream.u32()?);
    stream.u32()?;
    if kind == Kind::Array {
        stream.shape()?;
    }
    let max_length = stream.u32()?;
    keywords::pass(stream)?;
    stream.u32()?;
    match kind {
        // The value of cells that nobody has written.
        Kind::Scalar if data_type == TEXT => drop(stream.text()?),
        Kind::Scalar => match bits(data_type) {
            Some(bits) => stream.pass(bits.div_ceil(8))?,
            None => return Ok(None),
        },
        Kind::Array => drop(stream.byte()?),
        Kind::Record => {}
    }
    Ok(Some(Described {
        name,
        kind,
        data_type,
        options,
        max_length,
    }))
}

/// Kinds of the managers and the numbers of their files, in their order.
fn managers(stream: &mut Stream) -> Result<Option<Vec<(String, u32)>>, String> {
    // Negative, but in old files.
    let version = (stream.u32()? as i32).saturating_neg();
    if !(1..=LIST_VERSION).contains(&version) {
        return Ok(None);
    }
    stream.grown(version > 2)?;
    if version > 2 {
        stream.u64()?;
    }
    stream.u32()?;
    let mut managers = Vec::new();
    for _ in 0..stream.u32()? {
        managers.push((stream.text()?, stream.u32()?));
    }
    Ok(Some(managers))
}

/// The number of a column's manager, and how that keeps it.
fn column(stream: &mut Stream, described: Described) -> Result<Option<(u32, Column)>, String> {
    // The first layout has keywords here.
    if stream.u32()? < 2 {
        return Ok(None);
    }
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
    Ok(Some((manager, column)))
}

fn elements(shape: &[i64]) -> Option<u64> {
    let mut lens = shape.iter().map(|&len| u64::try_from(len).ok());
    lens.try_fold(1, |product: u64, len| product.checked_mul(len?))
}
