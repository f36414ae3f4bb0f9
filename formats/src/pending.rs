//! A file that gets its name only once it is whole.

use std::ffi::OsString;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::WriteError;

/// Bytes gathered before each write.
const BUFFER_BYTES: usize = 1 << 20;

/// A file written under a temporary name beside its target.
///
/// [`commit`](Self::commit) renames it; dropping it removes it. Whatever kills the process before
/// the rename, nothing stands under the final name; what is left then is a hidden `.NAME.*.part`. Two
/// files that belong together are both [synced](Self::sync) before either is committed.
#[derive(Debug)]
pub struct PendingFile {
    file: BufWriter<NamedTempFile>,
    path: PathBuf,
    overwrite: bool,
}

/// Nothing if `path` may be written: no file is there, or it may be replaced.
///
/// # Errors
/// [`WriteError::Exists`] if a file is there and `overwrite` is false.
pub fn refuse_existing(path: &Path, overwrite: bool) -> Result<(), WriteError> {
    if !overwrite && path.symlink_metadata().is_ok() {
        return Err(WriteError::Exists { path: path.into() });
    }
    Ok(())
}

impl PendingFile {
    /// An empty file, to be named `path`.
    ///
    /// # Errors
    /// A file stands at `path` and `overwrite` is false, or the directory cannot be written.
    pub fn create(path: &Path, overwrite: bool) -> Result<Self, WriteError> {
        refuse_existing(path, overwrite)?;
        let file = temp_file(path).map_err(|e| io_error(path, e))?;
        Ok(Self {
            file: BufWriter::with_capacity(BUFFER_BYTES, file),
            path: path.into(),
            overwrite,
        })
    }

    /// The final name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where the file stands until it has its name: for libraries that write by name.
    ///
    /// What they write must be complete and closed before [`commit`](Self::commit), and nothing
    /// may be [appended](Self::append).
    pub(crate) fn temp_path(&self) -> &Path {
        self.file.get_ref().path()
    }

    /// Appends.
    ///
    /// # Errors
    /// The disk is full, or the system refuses otherwise.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), WriteError> {
        let written = self.file.write_all(bytes);
        written.map_err(|e| io_error(&self.path, e))
    }

    /// Replaces the bytes at `offset`.
    ///
    /// # Errors
    /// As [`append`](Self::append).
    pub fn replace(&mut self, offset: u64, bytes: &[u8]) -> Result<(), WriteError> {
        let written = (self.file.seek(SeekFrom::Start(offset)))
            .and_then(|_| self.file.write_all(bytes))
            .and_then(|()| self.file.seek(SeekFrom::End(0)));
        written.map(drop).map_err(|e| io_error(&self.path, e))
    }

    /// Makes sure that all is on the disk.
    ///
    /// # Errors
    /// As [`append`](Self::append).
    pub fn sync(&mut self) -> Result<(), WriteError> {
        let synced = (self.file.flush()).and_then(|()| self.file.get_ref().as_file().sync_all());
        synced.map_err(|e| io_error(&self.path, e))
    }

    /// Gives the file its final name, atomically.
    ///
    /// # Errors
    /// A file has come to stand there and may not be replaced, or the system refuses.
    pub fn commit(mut self) -> Result<(), WriteError> {
        self.sync()?;
        let Self {
            file,
            path,
            overwrite,
        } = self;
        let temp = (file.into_inner()).map_err(|e| io_error(&path, e.into_error()))?;
        let named = if overwrite {
            temp.persist(&path)
        } else {
            temp.persist_noclobber(&path)
        };
        match named {
            Ok(_) => {
                sync_directory(&path);
                Ok(())
            }
            Err(e) if e.error.kind() == io::ErrorKind::AlreadyExists => {
                Err(WriteError::Exists { path })
            }
            Err(e) => Err(io_error(&path, e.error)),
        }
    }
}

pub(crate) fn io_error(path: &Path, source: io::Error) -> WriteError {
    let path = path.into();
    WriteError::Io { path, source }
}

/// How the name of what is not whole yet begins.
pub(crate) fn hidden_name(path: &Path) -> io::Result<OsString> {
    let Some(name) = path.file_name() else {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "the path names no file",
        ));
    };
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    Ok(prefix)
}

fn temp_file(path: &Path) -> io::Result<NamedTempFile> {
    let prefix = hidden_name(path)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What any new file gets: the umask takes its bits away.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(directory(path))
}

pub(crate) fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Makes the new name itself survive a power cut, where the system can; the file is whole anyway.
pub(crate) fn sync_directory(path: &Path) {
    if let Ok(directory) = std::fs::File::open(directory(path)) {
        let _ = directory.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(dir: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(dir)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// A file with `text` in it, not yet named.
    fn prepare(path: &Path, overwrite: bool, text: &str) -> Result<PendingFile, WriteError> {
        let mut pending = PendingFile::create(path, overwrite)?;
        pending.append(text.as_bytes())?;
        Ok(pending)
    }

    #[test]
    fn the_name_appears_at_commit_and_not_before() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.fits");
        let pending = prepare(&path, false, "whole").unwrap();
        assert!(!path.exists() && names(dir.path()).len() == 1);
        pending.commit().unwrap();
        assert_eq!(names(dir.path()), ["a.fits"]);
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
    }

    #[test]
    fn bytes_are_replaced_in_their_place() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.fits");
        let mut pending = prepare(&path, false, "one two").unwrap();
        pending.replace(0, b"ONE").unwrap();
        pending.append(b" three").unwrap();
        pending.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"ONE two three");
    }

    #[test]
    fn a_dropped_file_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.fits");
        let mut pending = prepare(&path, false, "half").unwrap();
        pending.sync().unwrap();
        drop(pending);
        assert!(names(dir.path()).is_empty());
    }

    #[test]
    fn an_existing_file_is_kept_unless_overwriting() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.fits");
        let late = prepare(&path, false, "new").unwrap();
        std::fs::write(&path, "old").unwrap();
        assert!(matches!(late.commit(), Err(WriteError::Exists { .. })));
        let early = prepare(&path, false, "new");
        assert!(matches!(early, Err(WriteError::Exists { .. })));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        let forced = prepare(&path, true, "new").unwrap();
        forced.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(names(dir.path()), ["a.fits"]);
    }

    #[test]
    fn a_missing_directory_is_an_io_error_with_the_path() {
        let lost = Path::new("/nonexistent-directory/a.fits");
        let error = PendingFile::create(lost, false).unwrap_err();
        assert!(error.to_string().contains("nonexistent-directory"));
    }
}
