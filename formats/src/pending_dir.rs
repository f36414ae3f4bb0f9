//! A directory that gets its name only once it is whole.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::WriteError;
use crate::pending::{directory, hidden_name, io_error, refuse_existing, sync_directory};

/// A directory written inside of a hidden one beside its target.
///
/// As [`PendingFile`](crate::fits::PendingFile): [`commit`](Self::commit) renames it, dropping it
/// removes it, and what a killed process leaves is a hidden `.NAME.*.part`.
#[derive(Debug)]
pub(crate) struct PendingDir {
    hidden: TempDir,
    path: PathBuf,
    overwrite: bool,
}

impl PendingDir {
    /// A place for a directory that is to be named `path`.
    ///
    /// # Errors
    /// Something stands at `path` and `overwrite` is false, or its folder cannot be written.
    pub(crate) fn create(path: &Path, overwrite: bool) -> Result<Self, WriteError> {
        refuse_existing(path, overwrite)?;
        let hidden = hidden_name(path).and_then(|prefix| {
            let mut builder = tempfile::Builder::new();
            builder
                .prefix(&prefix)
                .suffix(".part")
                .tempdir_in(directory(path))
        });
        Ok(Self {
            hidden: hidden.map_err(|e| io_error(path, e))?,
            path: path.into(),
            overwrite,
        })
    }

    /// The final name.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Where the directory is to be made. What is written there must be complete and closed before
    /// [`commit`](Self::commit).
    pub(crate) fn temp_path(&self) -> PathBuf {
        self.hidden.path().join("new")
    }

    /// Gives the directory its final name. What stood there is moved aside first, and removed last.
    ///
    /// # Errors
    /// Something has come to stand there and may not be replaced, or the system refuses.
    pub(crate) fn commit(self) -> Result<(), WriteError> {
        refuse_existing(&self.path, self.overwrite)?;
        let io = |e| io_error(&self.path, e);
        sync_all(&self.temp_path()).map_err(io)?;
        let old = self.hidden.path().join("old");
        let had_old = self.path.symlink_metadata().is_ok();
        if had_old {
            fs::rename(&self.path, &old).map_err(io)?;
        }
        if let Err(error) = fs::rename(self.temp_path(), &self.path) {
            if had_old {
                fs::rename(&old, &self.path).map_err(io)?;
            }
            return Err(io(error));
        }
        sync_directory(&self.path);
        Ok(())
    }
}

/// Makes sure that all files below a directory are on the disk.
fn sync_all(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            sync_all(&entry.path())?;
        } else {
            File::open(entry.path())?.sync_all()?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
        names.collect()
    }

    fn prepare(path: &Path, overwrite: bool, text: &str) -> Result<PendingDir, WriteError> {
        let pending = PendingDir::create(path, overwrite)?;
        fs::create_dir(pending.temp_path()).unwrap();
        fs::write(pending.temp_path().join("a"), text).unwrap();
        Ok(pending)
    }

    #[test]
    fn the_name_appears_at_commit_and_not_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ms");
        let pending = prepare(&path, false, "whole").unwrap();
        assert!(!path.exists() && names(folder.path()).len() == 1);
        pending.commit().unwrap();
        assert_eq!(names(folder.path()), ["a.ms"]);
        assert_eq!(fs::read(path.join("a")).unwrap(), b"whole");
    }

    #[test]
    fn what_is_there_is_kept_unless_overwriting() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ms");
        let late = prepare(&path, false, "new").unwrap();
        prepare(&path, false, "old").unwrap().commit().unwrap();
        assert!(matches!(late.commit(), Err(WriteError::Exists { .. })));
        assert_eq!(fs::read(path.join("a")).unwrap(), b"old");
        prepare(&path, true, "new").unwrap().commit().unwrap();
        assert_eq!(fs::read(path.join("a")).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.ms"]);
    }

    #[test]
    fn a_dropped_directory_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        drop(prepare(&folder.path().join("a.ms"), false, "half").unwrap());
        assert!(names(folder.path()).is_empty());
    }
}
