//! Where `table.dat` says that the columns of standard storage managers are.

use super::stream::Stream;

/// Newest layouts that are known, of `table.dat` and of its list of managers.
const TABLE_VERSION: u32 = 3;
const LIST_VERSION: i32 = 3;

/// The columns of a manager.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Columns {
    /// The number in the name of the manager's file.
    pub(super) file: u32,
    /// Where each column begins in a bucket.
    pub(super) offsets: Vec<u64>,
    /// In which index of the file the rows of each are found.
    pub(super) indices: Vec<u64>,
}

/// Of all standard storage managers; none where the layout is not known.
pub(super) fn read(table_dat: &[u8]) -> Result<Vec<Columns>, String> {
    let mut stream = Stream::new(table_dat, true);
    let Some(files) = files(&mut stream)? else {
        return Ok(Vec::new());
    };
    // What a manager has to say comes after all columns, in a stream of its own.
    let told = stream
        .starts()
        .filter_map(|mut own| (own.outermost().ok()?.name == "SSM").then_some(own));
    let told: Vec<Stream> = told.collect();
    if told.len() != files.len() {
        return Ok(Vec::new());
    }
    let columns = files.into_iter().zip(told).map(|(file, mut own)| {
        own.text()?;
        let (offsets, indices) = (own.list(false)?, own.list(false)?);
        Ok(Columns {
            file,
            offsets,
            indices,
        })
    });
    columns.collect()
}

/// The numbers of the files, in the order of the managers.
fn files(stream: &mut Stream) -> Result<Option<Vec<u32>>, String> {
    let version = stream.outermost()?.version;
    if !(2..=TABLE_VERSION).contains(&version) {
        return Ok(None);
    }
    stream.grown(version > 2)?;
    stream.u32()?;
    stream.text()?;
    // The description of the columns.
    stream.skip()?;
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
    let mut files = Vec::new();
    for _ in 0..stream.u32()? {
        let (name, file) = (stream.text()?, stream.u32()?);
        if name == "StandardStMan" {
            files.push(file);
        }
    }
    Ok(Some(files))
}
