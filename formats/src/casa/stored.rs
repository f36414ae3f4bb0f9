//! What the files of a table say of themselves, where casacore would believe it.
//!
//! `table.dat` describes the columns, and says where in the files of storage managers they are; these begin with a
//! header that tells sizes. casacore makes room for whatever is announced, divides by the ones and follows the others
//! without a look. So `table.dat` is read here first, and the files of the managers that Measurement Sets are mostly
//! made of; of anything that is not known here, nothing is said.
//!
//! # Source
//! casacore 3.5: AipsIO, TableDesc, TableRecord, PlainTable, RefTable, ConcatTable, ColumnSet, TiledStMan,
//! TiledShapeStMan, TSMCube, SSMBase, SSMIndex, SSMStringHandler, ISMBase, ISMBucket, LockFile, TableSyncData.

mod arrays;
mod buckets;
mod columns;
mod incremental;
mod keywords;
mod others;
mod standard;
mod stream;
mod texts;
mod tiled;
mod types;

use std::fs::File;
use std::path::Path;

use columns::{Made, Managed};
use stream::Stream;

/// Bytes in which the name of a manager must stand.
const START_BYTES: u64 = 64;
/// Headers that are longer than this are left to casacore.
const MAX_HEADER_BYTES: u64 = 1 << 28;

/// Tables of tables: a selection of a selection of some that are put together is three deep.
const MAX_DEPTH: usize = 16;

/// Where a lock file says how long what follows is: after the processes that wait for the lock.
const LOCK_LENGTH_AT: u64 = 260;

/// Looks into `table.dat`, the files of storage managers, and the lock; what is wrong is told in words.
pub(super) fn check(folder: &Path) -> Result<(), String> {
    check_made(folder, 0)
}

/// The table and those that it is made of.
fn check_made(folder: &Path, depth: usize) -> Result<(), String> {
    check_lock(&folder.join("table.lock")).map_err(|what| format!("table.lock: {what}"))?;
    let table_dat = std::fs::read(folder.join("table.dat")).map_err(|error| error.to_string())?;
    match columns::read(&table_dat).map_err(|what| format!("table.dat: {what}"))? {
        Made::Columns(managed) => managed.into_iter().try_for_each(|managed| {
            let name = format!("table.f{}", managed.file);
            check_file(&folder.join(&name), &managed).map_err(|what| format!("{name}: {what}"))
        }),
        Made::Others(_) if depth >= MAX_DEPTH => Err(format!(
            "is made of tables of tables, more than {MAX_DEPTH} deep"
        )),
        Made::Others(names) => names.iter().try_for_each(|name| {
            let other = others::place(folder, name);
            // One that is not there is casacore's to complain of.
            if !other.join("table.dat").is_file() {
                return Ok(());
            }
            check_made(&other, depth + 1).map_err(|what| format!("{}: {what}", other.display()))
        }),
    }
}

/// What the last process to write has left in the lock file, for others to see whether something has changed.
fn check_lock(path: &Path) -> Result<(), String> {
    let Ok(file) = File::open(path) else {
        return Ok(());
    };
    let left = stream::read(&file, LOCK_LENGTH_AT, MAX_HEADER_BYTES)?;
    // One that is shorter announces nothing.
    if left.len() < 4 {
        return Ok(());
    }
    let mut left = Stream::new(&left, true).part()?;
    if left.is_empty() {
        return Ok(());
    }
    let version = left.outermost()?.version;
    // casacore takes all layouts but the first for the newest.
    left.grown(version != 1)?;
    let n_column = left.u32()? as i32;
    left.u32()?;
    // A table without columns is another program's.
    if n_column >= 0 {
        left.u32()?;
        left.list(false)?;
    }
    Ok(())
}

/// Looks through the file of a manager, if there is one and its layout is known.
fn check_file(path: &Path, managed: &Managed) -> Result<(), String> {
    let class = managed.class.as_str();
    let is_tiled = class.starts_with("Tiled");
    let is_known = is_tiled || ["StandardStMan", "IncrementalStMan"].contains(&class);
    let Some(file) = File::open(path).ok().filter(|_| is_known) else {
        return Ok(());
    };
    let start = stream::read(&file, 0, START_BYTES)?;
    // The order of bytes is the table's in some files, and the same for all tables in others.
    let orders: &[bool] = if is_tiled { &[true] } else { &[true, false] };
    let begins = |big| {
        Stream::new(&start, big)
            .outermost()
            .is_ok_and(|object| object.name == class)
    };
    let Some(big) = orders.iter().copied().find(|&big| begins(big)) else {
        return Err(format!(
            "does not begin as that of a {class} does: it is truncated or damaged"
        ));
    };
    match class {
        "StandardStMan" => standard::check(path, file, big, managed),
        "IncrementalStMan" => incremental::check(path, &file, big, managed),
        _ => {
            let header = stream::read(&file, 0, MAX_HEADER_BYTES)?;
            // Longer ones are casacore's.
            if header.len() as u64 == MAX_HEADER_BYTES {
                return Ok(());
            }
            tiled::check(&header, path)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_must_begin_with_the_name_of_its_manager() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.f0");
        let check = |class: &str| {
            let managed = Managed {
                class: class.into(),
                file: 0,
                columns: Vec::new(),
                own: Stream::new(&[], true),
            };
            check_file(&path, &managed)
        };
        assert!(check("TiledColumnStMan").is_ok());
        std::fs::write(
            &path,
            b"\xbe\xbe\xbe\xbe\0\0\x01\x08\x79\0\0\x10TiledColumnStMan",
        )
        .unwrap();
        let error = check("TiledColumnStMan").unwrap_err();
        assert!(
            error.contains("as that of a TiledColumnStMan does"),
            "{error}"
        );
        assert!(check("ManagerOfAnotherProgram").is_ok());
    }
}
