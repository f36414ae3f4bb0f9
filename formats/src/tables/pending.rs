//! A file that gets its name only once it is whole.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::WriteError;

/// A file written and synced to disk under a temporary name beside its target.
///
/// [`commit`](Self::commit) renames it; dropping it removes it. Whatever kills the process before
/// the rename, nothing stands under the final name; what is left then is a hidden `.NAME.*.part`. Two files that belong together are both prepared
/// before either is committed.
#[derive(Debug)]
pub struct PendingFile {
    temp: NamedTempFile,
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
    /// The file that `fill` writes, to be named `path`.
    ///
    /// # Errors
    /// A file stands at `path` and `overwrite` is false; the directory cannot be written; the disk
    /// is full; or whatever `fill` returns.
    pub fn prepare(
        path: &Path,
        overwrite: bool,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<Self, WriteError> {
        refuse_existing(path, overwrite)?;
        let temp = write_temp(path, fill).map_err(|source| WriteError::Io {
            path: path.into(),
            source,
        })?;
        Ok(Self {
            temp,
            path: path.into(),
            overwrite,
        })
    }

    /// The final name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its final name, atomically.
    ///
    /// # Errors
    /// A file has come to stand there and may not be replaced, or the system refuses the rename.
    pub fn commit(self) -> Result<(), WriteError> {
        let Self {
            temp,
            path,
            overwrite,
        } = self;
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
            Err(e) => Err(WriteError::Io {
                path,
                source: e.error,
            }),
        }
    }
}

fn write_temp(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<NamedTempFile> {
    let Some(name) = path.file_name() else {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "the path names no file",
        ));
    };
    let mut prefix = std::ffi::OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What any new file gets: the umask takes its bits away.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let temp = builder.tempfile_in(directory(path))?;
    let mut out = BufWriter::with_capacity(1 << 16, temp.as_file());
    fill(&mut out)?;
    out.flush()?;
    drop(out);
    temp.as_file().sync_all()?;
    Ok(temp)
}

fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Makes the new name itself survive a power cut, where the system can; the file is whole anyway.
fn sync_directory(path: &Path) {
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

    #[test]
    fn the_name_appears_at_commit_and_not_before() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.fits");
        let pending = PendingFile::prepare(&path, false, |w| w.write_all(b"whole")).unwrap();
        assert!(!path.exists() && names(dir.path()).len() == 1);
        pending.commit().unwrap();
        assert_eq!(names(dir.path()), ["a.fits"]);
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
    }

    #[test]
    fn a_failed_or_dropped_file_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.fits");
        let failed = PendingFile::prepare(&path, false, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(matches!(failed, Err(WriteError::Io { .. })));
        drop(PendingFile::prepare(&path, false, |_| Ok(())).unwrap());
        assert!(names(dir.path()).is_empty());
    }

    #[test]
    fn an_existing_file_is_kept_unless_overwriting() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.fits");
        let late = PendingFile::prepare(&path, false, |w| w.write_all(b"new")).unwrap();
        std::fs::write(&path, "old").unwrap();
        assert!(matches!(late.commit(), Err(WriteError::Exists { .. })));
        let early = PendingFile::prepare(&path, false, |w| w.write_all(b"new"));
        assert!(matches!(early, Err(WriteError::Exists { .. })));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        let forced = PendingFile::prepare(&path, true, |w| w.write_all(b"new")).unwrap();
        forced.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(names(dir.path()), ["a.fits"]);
    }

    #[test]
    fn a_missing_directory_is_an_io_error_with_the_path() {
        let lost = Path::new("/nonexistent-directory/a.fits");
        let error = PendingFile::prepare(lost, false, |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("nonexistent-directory"));
    }
}
