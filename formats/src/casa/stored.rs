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

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
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
        Made::Columns(managed) => check_files(folder, managed),
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

fn check_files(folder: &Path, managed: Vec<Managed>) -> Result<(), String> {
    // A folder that cannot be listed is casacore's to complain of.
    let Ok(entries) = folder.read_dir() else {
        return Ok(());
    };
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| is_manager(name))
        .collect();
    names.sort();
    let named = managed.into_iter();
    let mut managed: BTreeMap<String, Managed> = named
        .map(|managed| (format!("table.f{}", managed.file), managed))
        .collect();
    for name in names {
        check_file(&folder.join(&name), managed.remove(&name))
            .map_err(|what| format!("{name}: {what}"))?;
    }
    Ok(())
}

/// `table.f` and a number.
fn is_manager(name: &str) -> bool {
    let number = name.strip_prefix("table.f");
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
}

/// What the last process to write has left in the lock file, for others to see whether something has changed.
fn check_lock(path: &Path) -> Result<(), String> {
    let Ok(mut file) = File::open(path) else {
        return Ok(());
    };
    let left = stream::read(&mut file, LOCK_LENGTH_AT, MAX_HEADER_BYTES)?;
    // One that is shorter announces nothing.
    if left.len() < 4 {
        return Ok(());
    }
    let mut left = Stream::new(&left, true).part()?;
    if left.is_empty() {
        return Ok(());
    }
    let version = left.outermost()?.version;
    left.grown(version > 1)?;
    let n_column = left.u32()? as i32;
    left.u32()?;
    // A table without columns is another program's.
    if n_column >= 0 {
        left.u32()?;
        left.list(false)?;
    }
    Ok(())
}

/// Looks through a file of a manager, whose columns are known if the layout of `table.dat` is.
fn check_file(path: &Path, managed: Option<Managed>) -> Result<(), String> {
    let words = |error: std::io::Error| error.to_string();
    let mut file = File::open(path).map_err(words)?;
    let n_byte = file.metadata().map_err(words)?.len();
    let mut bytes = Vec::new();
    (file.by_ref().take(START_BYTES))
        .read_to_end(&mut bytes)
        .map_err(words)?;
    // The order of bytes is the table's in some files, and the same for all tables in others.
    let named = |big| Some((Stream::new(&bytes, big).outermost().ok()?.name, big));
    let Some((name, big)) = [true, false].into_iter().find_map(named) else {
        if bytes.starts_with(&stream::MAGIC.to_be_bytes()) {
            return Err("does not say which manager it is of: it is truncated or damaged".into());
        }
        return Ok(());
    };
    let managed = managed.filter(|managed| managed.class == name);
    match (name.as_str(), managed) {
        ("StandardStMan", managed) => standard::check(file, big, managed),
        ("IncrementalStMan", Some(managed)) => incremental::check(file, big, &managed),
        (name, _) if name.starts_with("Tiled") && big && n_byte <= MAX_HEADER_BYTES => {
            file.read_to_end(&mut bytes).map_err(words)?;
            tiled::check(&bytes, path)
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_managers_are_known_by_their_names() {
        assert!(is_manager("table.f0") && is_manager("table.f12"));
        let others = ["table.f", "table.f0i", "table.f3_TSM1", "table.dat"];
        assert!(!others.into_iter().any(is_manager));
    }

    #[test]
    fn a_file_of_a_manager_whose_name_is_not_there_is_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.f0");
        std::fs::write(
            &path,
            b"\xbe\xbe\xbe\xbe\0\0\x01\x08\x79\0\0\x10TiledColumnStMan",
        )
        .unwrap();
        assert!(
            check_file(&path, None)
                .unwrap_err()
                .contains("which manager")
        );
        std::fs::write(&path, b"of a manager that is not casacore's own").unwrap();
        assert!(check_file(&path, None).is_ok());
    }
}
