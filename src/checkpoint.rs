//! What a run was told, kept on disk, so that a run that was killed goes on where it was.
//!
//! Nothing of a run is decided by chance or by the clock: all that it does follows from its options and
//! from the answers that the data give. So a checkpoint holds the answers, in order. A run that is
//! resumed asks its questions once more, is given the answers of the checkpoint as long as there are
//! any, which takes no pass over the data, and works out those that follow. It ends with the same bytes.
//!
//! # Format
//! Integers and floats are little-endian; a check is the first 8 bytes of a BLAKE3.
//!
//! ```text
//! head    "V2CCKPT\n"  version: u32  n: u32  n bytes of JSON (Identity)  check of all before
//! record  question: 8 bytes  n: u64  n values: f64  check of (the check before, all of the record)
//! ```
//!
//! A question is a digest of what was asked. The last record may be cut short: the program was killed
//! while it was written. It is dropped.

mod head;
mod record;

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufReader, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use vis2cat_formats::WriteError;

pub use head::Identity;
use record::{CHECK_BYTES, Check, Whole};

/// Time after which what was written is forced to the disk: a power cut loses no more.
const SYNC_EVERY: Duration = Duration::from_secs(10);

/// A digest of what was asked.
pub type QuestionId = [u8; 8];

/// A checkpoint cannot be used or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The operating system does not let us read it.
    #[error("cannot read the checkpoint {path}")]
    Read {
        /// File.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The operating system does not let us write it.
    #[error(
        "cannot write the checkpoint {path}; what it holds so far is good: make room, and go on with --resume"
    )]
    Write {
        /// File.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It could not be begun.
    #[error(transparent)]
    Create(#[from] WriteError),
    /// There is one already, and we were not told what to do with it.
    #[error(
        "{path} is there, of a run that did not end; go on with it by --resume, or replace it with --overwrite"
    )]
    Exists {
        /// File.
        path: PathBuf,
    },
    /// Somebody else has it.
    #[error("{path} is in use: that run has not ended yet")]
    InUse {
        /// File.
        path: PathBuf,
    },
    /// It is not what we expect.
    #[error("{path}: {what}")]
    Malformed {
        /// File.
        path: PathBuf,
        /// What is wrong, and what to do.
        what: String,
    },
    /// It is of another run.
    #[error(
        "{path} belongs to another run: {what}. Remove it, or replace it with --checkpoint --overwrite, to begin anew"
    )]
    Foreign {
        /// File.
        path: PathBuf,
        /// What differs.
        what: String,
    },
    /// The run took another way than the one that wrote it.
    #[error(
        "{path}: this run asks another question than its answer {n_answer} is for, so another build or machine has written it; remove it to begin anew"
    )]
    Strayed {
        /// File.
        path: PathBuf,
        /// Number of the answer, from 1.
        n_answer: u64,
    },
}

impl CheckpointError {
    /// True if it is an output that cannot be written, false if an input that cannot be used.
    pub fn is_output(&self) -> bool {
        matches!(
            self,
            Self::Write { .. } | Self::Create(_) | Self::Exists { .. }
        )
    }
}

/// The answers that a run has been given, first those on disk, then new ones.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    file: BufReader<File>,
    /// Answers on disk that were not recalled yet.
    n_left: u64,
    n_recalled: u64,
    check: Check,
    synced: Instant,
}

impl Checkpoint {
    /// Begins one; a file of this name is replaced only if `overwrite`.
    ///
    /// # Errors
    /// There is one, or it cannot be written.
    pub fn create(
        path: &Path,
        identity: &Identity,
        overwrite: bool,
    ) -> Result<Self, CheckpointError> {
        if !overwrite && path.symlink_metadata().is_ok() {
            return Err(CheckpointError::Exists { path: path.into() });
        }
        head::write(path, identity, overwrite)?;
        Self::open(path, identity)
    }

    /// Opens the one that is there, or begins one if there is none.
    ///
    /// # Errors
    /// It is of another run, is in use, or cannot be read or written.
    pub fn resume(path: &Path, identity: &Identity) -> Result<Self, CheckpointError> {
        if path.symlink_metadata().is_ok() {
            return Self::open(path, identity);
        }
        tracing::warn!(
            "there is no {}: the run begins at its beginning",
            path.display()
        );
        Self::create(path, identity, false)
    }

    fn open(path: &Path, identity: &Identity) -> Result<Self, CheckpointError> {
        let unreadable = |source| CheckpointError::Read {
            path: path.into(),
            source,
        };
        let file = OpenOptions::new().read(true).append(true).open(path);
        let file = file.map_err(unreadable)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(CheckpointError::InUse { path: path.into() });
            }
            // A file system that has no locks: then nobody can be asked.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        let len = file.metadata().map_err(unreadable)?.len();
        let mut file = BufReader::new(file);
        let check = head::read(path, &mut file, len, identity)?;
        let whole = Whole::count(&mut file, len, check).map_err(unreadable)?;
        whole.tell(path, len);
        let mut this = Self {
            path: path.into(),
            file,
            n_left: whole.n_record,
            n_recalled: 0,
            check,
            synced: Instant::now(),
        };
        this.cut(whole.end)
            .map_err(|source| this.unwritable(source))?;
        Ok(this)
    }

    /// Drops what is after `end`, and goes back to the first record.
    fn cut(&mut self, end: u64) -> io::Result<()> {
        let first = self.file.stream_position()?;
        let file = self.file.get_ref();
        if file.metadata()?.len() > end {
            file.set_len(end)?;
        }
        self.file.seek(SeekFrom::Start(first)).map(drop)
    }

    /// The answer that was given to this question, as the next one, if it is on disk.
    ///
    /// # Errors
    /// Another question was asked then, or the file can no longer be read.
    pub fn recall(&mut self, question: QuestionId) -> Result<Option<Vec<f64>>, CheckpointError> {
        if self.n_left == 0 {
            return Ok(None);
        }
        let record = record::read(&mut self.file, &mut self.check);
        let (asked, answer) = record.map_err(|source| CheckpointError::Read {
            path: self.path.clone(),
            source,
        })?;
        if asked != question {
            return Err(CheckpointError::Strayed {
                path: self.path.clone(),
                n_answer: self.n_recalled + 1,
            });
        }
        self.n_recalled += 1;
        self.n_left -= 1;
        if self.n_left == 0 {
            tracing::info!(
                "all {} answers are recalled: the run goes on",
                self.n_recalled
            );
        }
        Ok(Some(answer))
    }

    /// Adds the answer to a question that was not on disk.
    ///
    /// # Errors
    /// The disk is full, or the system refuses otherwise; what was there before stays good.
    ///
    /// # Panics
    /// If there are answers that were not recalled yet.
    pub fn record(&mut self, question: QuestionId, answer: &[f64]) -> Result<(), CheckpointError> {
        assert_eq!(
            self.n_left, 0,
            "answers are recalled before new ones are added"
        );
        let bytes = record::bytes(question, answer, &mut self.check);
        self.append(&bytes)
            .map_err(|source| self.unwritable(source))
    }

    /// One call of the system for each record, so that a kill can only cut the last.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        let file = self.file.get_mut();
        file.write_all(bytes)?;
        if self.synced.elapsed() > SYNC_EVERY {
            file.sync_data()?;
            self.synced = Instant::now();
        }
        Ok(())
    }

    /// Removes the file: the run has ended.
    ///
    /// # Errors
    /// The system refuses.
    pub fn remove(self) -> Result<(), CheckpointError> {
        let removed = std::fs::remove_file(&self.path);
        removed.map_err(|source| self.unwritable(source))
    }

    fn unwritable(&self, source: io::Error) -> CheckpointError {
        CheckpointError::Write {
            path: self.path.clone(),
            source,
        }
    }
}

/// Reads exactly `N` bytes.
fn array<const N: usize>(file: &mut impl io::Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn check_of(hasher: &blake3::Hasher) -> Check {
    let mut check = [0; CHECK_BYTES];
    hasher.finalize_xof().fill(&mut check);
    check
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity() -> Identity {
        Identity {
            version: "1".into(),
            processor: "one".into(),
            input: "abc".into(),
            config: "seed = 1\nfov = 2".into(),
        }
    }

    fn answer(i: u8) -> Vec<f64> {
        (0..i).map(|k| f64::from(k).exp() - f64::from(i)).collect()
    }

    /// What an uninterrupted run leaves of its questions 0 to 3.
    fn whole(path: &Path) -> Vec<u8> {
        let mut checkpoint = Checkpoint::create(path, &identity(), true).unwrap();
        for i in 0..4 {
            assert_eq!(checkpoint.recall([i; 8]).unwrap(), None);
            checkpoint.record([i; 8], &answer(i)).unwrap();
        }
        std::fs::read(path).unwrap()
    }

    #[test]
    fn cut_anywhere_or_wrong_anywhere_it_goes_on_to_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.checkpoint");
        let bytes = whole(&path);
        let head = 24 + serde_json::to_vec(&identity()).unwrap().len();
        let goes_on = |left: &[u8]| {
            std::fs::write(&path, left).unwrap();
            let mut checkpoint = Checkpoint::resume(&path, &identity()).unwrap();
            for i in 0..4 {
                match checkpoint.recall([i; 8]).unwrap() {
                    Some(known) => assert_eq!(known, answer(i)),
                    None => checkpoint.record([i; 8], &answer(i)).unwrap(),
                }
            }
            assert_eq!(std::fs::read(&path).unwrap(), bytes);
        };
        for place in head..bytes.len() {
            goes_on(&bytes[..place]);
            for wrong in [1, 0x80] {
                let mut damaged = bytes.clone();
                damaged[place] ^= wrong;
                goes_on(&damaged);
            }
        }
        for place in 0..head {
            std::fs::write(&path, &bytes[..place]).unwrap();
            assert!(Checkpoint::resume(&path, &identity()).is_err(), "{place}");
            let mut damaged = bytes.clone();
            damaged[place] ^= 1;
            std::fs::write(&path, &damaged).unwrap();
            assert!(Checkpoint::resume(&path, &identity()).is_err(), "{place}");
            assert_eq!(std::fs::read(&path).unwrap(), damaged);
        }
    }

    /// A change of the identity, and what the error says of it.
    type Change = (fn(&mut Identity), &'static str);

    #[test]
    fn another_question_or_another_run_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.checkpoint");
        whole(&path);
        let mut checkpoint = Checkpoint::resume(&path, &identity()).unwrap();
        checkpoint.recall([0; 8]).unwrap();
        let strayed = checkpoint.recall([7; 8]);
        assert!(matches!(
            strayed,
            Err(CheckpointError::Strayed { n_answer: 2, .. })
        ));
        drop(checkpoint);
        let others: [Change; 4] = [
            (|i| i.version = "2".into(), "vis2cat 1, this is 2"),
            (|i| i.processor = "two".into(), "written on one"),
            (|i| i.input = "xyz".into(), "input"),
            (|i| i.config = "seed = 1".into(), "'fov = 2' there, '' here"),
        ];
        for (change, wanted) in others {
            let mut other = identity();
            change(&mut other);
            let error = Checkpoint::resume(&path, &other).unwrap_err();
            assert!(error.to_string().contains(wanted), "{error}");
            assert!(!error.is_output());
        }
        let checkpoint = Checkpoint::resume(&path, &identity()).unwrap();
        checkpoint.remove().unwrap();
        assert!(!path.exists());
    }
}
