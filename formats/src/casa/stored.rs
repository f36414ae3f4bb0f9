//! What the files beside `table.dat` say of themselves, where casacore would believe it.
//!
//! A storage manager's file begins with a header that tells sizes, and where in which other file to
//! look. casacore divides by the ones and follows the others without a look. So the headers of the
//! managers that Measurement Sets are mostly made of are read here first; of anything that is not known
//! here, nothing is said.
//!
//! # Source
//! casacore 3.5: AipsIO, TiledStMan, TiledShapeStMan, TSMCube, SSMBase, SSMIndex, PlainTable, ColumnSet, LockFile.

mod columns;
mod standard;
mod stream;
mod tiled;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use stream::Stream;

/// Bytes in which the name of a manager must stand.
const START_BYTES: u64 = 64;
/// Headers that are longer than this are left to casacore.
const MAX_HEADER_BYTES: u64 = 1 << 28;

/// Where a lock file says how long what follows is: after the processes that wait for the lock.
const LOCK_LENGTH_AT: u64 = 260;

/// Looks into the files of a table's storage managers, and its lock; what is wrong is told in words.
pub(super) fn check(folder: &Path) -> Result<(), String> {
    check_lock(&folder.join("table.lock")).map_err(|what| format!("table.lock: {what}"))?;
    // A folder that cannot be listed is casacore's to complain of.
    let Ok(entries) = folder.read_dir() else {
        return Ok(());
    };
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| is_manager(name))
        .collect();
    names.sort();
    let mut standard = BTreeMap::new();
    for name in names {
        let header = check_file(&folder.join(&name)).map_err(|what| format!("{name}: {what}"))?;
        standard.extend(header.map(|header| (name, header)));
    }
    let table_dat = std::fs::read(folder.join("table.dat")).map_err(|error| error.to_string())?;
    let told = columns::read(&table_dat).map_err(|what| format!("table.dat: {what}"))?;
    for columns in told {
        let name = format!("table.f{}", columns.file);
        if let Some(header) = standard.get(&name) {
            standard::check_columns(header, &columns).map_err(|what| format!("{name}: {what}"))?;
        }
    }
    Ok(())
}

/// `table.f` and a number.
fn is_manager(name: &str) -> bool {
    let number = name.strip_prefix("table.f");
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
}

/// casacore makes room for all that a lock file announces, and keeps it if there is less.
fn check_lock(path: &Path) -> Result<(), String> {
    let mut bytes = [0; 4];
    let Ok(mut file) = File::open(path) else {
        return Ok(());
    };
    let n_byte = file.metadata().map_or(0, |metadata| metadata.len());
    // One that is shorter announces nothing.
    let start = file.seek(SeekFrom::Start(LOCK_LENGTH_AT));
    if start.and_then(|_| file.read_exact(&mut bytes)).is_err() {
        return Ok(());
    }
    let (announced, there) = (
        u32::from_be_bytes(bytes),
        n_byte.saturating_sub(LOCK_LENGTH_AT + 4),
    );
    if u64::from(announced) > there {
        return Err(format!("announces {announced} bytes, has {there}"));
    }
    Ok(())
}

/// What a standard storage manager says at its start, if it is one.
fn check_file(path: &Path) -> Result<Option<standard::Header>, String> {
    let words = |error: std::io::Error| error.to_string();
    let mut file = File::open(path).map_err(words)?;
    let n_byte = file.metadata().map_err(words)?.len();
    let mut bytes = Vec::new();
    (file.by_ref().take(START_BYTES))
        .read_to_end(&mut bytes)
        .map_err(words)?;
    // The order of bytes is the table's in some files, and the same for all tables in others.
    let named = |big| Some((Stream::new(&bytes, big).outermost().ok()?.name, big));
    match [true, false].into_iter().find_map(named) {
        Some((name, big)) if name == "StandardStMan" => standard::check(&mut file, big).map(Some),
        Some((name, true)) if name.starts_with("Tiled") && n_byte <= MAX_HEADER_BYTES => {
            file.read_to_end(&mut bytes).map_err(words)?;
            tiled::check(&bytes).map(|()| None)
        }
        None if bytes.starts_with(&stream::MAGIC.to_be_bytes()) => {
            Err("does not say which manager it is of: it is truncated or damaged".into())
        }
        _ => Ok(None),
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
        assert!(check_file(&path).unwrap_err().contains("which manager"));
        std::fs::write(&path, b"of a manager that is not casacore's own").unwrap();
        assert!(check_file(&path).unwrap().is_none());
    }
}
