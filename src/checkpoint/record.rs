//! Answers, one after the other, each with a check that goes on from the one before.

use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::{QuestionId, array, check_of};

/// Bytes of a check.
pub(super) const CHECK_BYTES: usize = 8;
/// The first bytes of a digest.
pub(super) type Check = [u8; CHECK_BYTES];

/// Bytes of a record before its values.
const BEFORE_VALUES: usize = size_of::<QuestionId>() + size_of::<u64>();
/// Bytes that are looked at in one piece.
const PIECE: usize = 1 << 13;

/// The records that are whole.
pub(super) struct Whole {
    pub(super) n_record: u64,
    /// Where the last of them ends [byte].
    pub(super) end: u64,
    /// What follows is more than a record that was cut short.
    is_damaged: bool,
}

impl Whole {
    /// Counts the records of a file of `len` bytes from where it stands, and goes back there.
    pub(super) fn count<F: Read + Seek>(
        file: &mut BufReader<F>,
        len: u64,
        mut check: Check,
    ) -> io::Result<Self> {
        let first = file.stream_position()?;
        let mut whole = Self {
            n_record: 0,
            end: first,
            is_damaged: false,
        };
        while let Some((head, n)) = whole_record(file, len - whole.end)? {
            let mut hasher = blake3::Hasher::new();
            hasher.update(&check).update(&head);
            update(&mut hasher, file, n)?;
            check = check_of(&hasher);
            if array(file)? != check {
                whole.is_damaged = true;
                break;
            }
            whole.n_record += 1;
            whole.end += (BEFORE_VALUES + CHECK_BYTES) as u64 + n;
        }
        file.seek(SeekFrom::Start(first))?;
        Ok(whole)
    }

    /// Says what a resumed run goes on with.
    pub(super) fn tell(&self, path: &Path, len: u64) {
        let (path, dropped) = (path.display(), len - self.end);
        if self.is_damaged {
            tracing::warn!(
                "{path} is damaged at byte {}: the {} answers before are used, those in the {dropped} \
                 bytes from there on are worked out again",
                self.end,
                self.n_record
            );
        } else if self.n_record > 0 || dropped > 0 {
            tracing::info!(
                "going on with {path}: {} answers, {dropped} bytes of one that was cut short",
                self.n_record
            );
        }
    }
}

/// The beginning of the next record and the bytes of its values, if it is whole among the `left` ones to
/// come.
fn whole_record(file: &mut impl Read, left: u64) -> io::Result<Option<([u8; BEFORE_VALUES], u64)>> {
    let Some(most) = left.checked_sub((BEFORE_VALUES + CHECK_BYTES) as u64) else {
        return Ok(None);
    };
    let head: [u8; BEFORE_VALUES] = array(file)?;
    let n = u64::from_le_bytes(array(&mut &head[size_of::<QuestionId>()..])?);
    let bytes = n.checked_mul(size_of::<f64>() as u64);
    Ok(bytes
        .filter(|bytes| *bytes <= most)
        .map(|bytes| (head, bytes)))
}

/// Adds the next `n` bytes to `hasher`.
fn update(hasher: &mut blake3::Hasher, file: &mut impl Read, mut n: u64) -> io::Result<()> {
    let mut room = [0; PIECE];
    while n > 0 {
        let piece = &mut room[..n.min(PIECE as u64) as usize];
        file.read_exact(piece)?;
        hasher.update(piece);
        n -= piece.len() as u64;
    }
    Ok(())
}

/// The next record of those that were found [whole](Whole): what was asked, and the answer.
pub(super) fn read(file: &mut impl Read, check: &mut Check) -> io::Result<(QuestionId, Vec<f64>)> {
    let question: QuestionId = array(file)?;
    let n = u64::from_le_bytes(array(file)?);
    let mut answer = Vec::new();
    for _ in 0..n {
        answer.push(f64::from_le_bytes(array(file)?));
    }
    let last = *check;
    *check = array(file)?;
    let changed = || io::Error::new(io::ErrorKind::InvalidData, "it has changed meanwhile");
    let mut same = last;
    bytes(question, &answer, &mut same);
    (same == *check)
        .then_some((question, answer))
        .ok_or_else(changed)
}

/// A record; `check` is that of the one before, and becomes its own.
pub(super) fn bytes(question: QuestionId, answer: &[f64], check: &mut Check) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(BEFORE_VALUES + size_of_val(answer) + CHECK_BYTES);
    bytes.extend(question);
    bytes.extend((answer.len() as u64).to_le_bytes());
    bytes.extend(answer.iter().flat_map(|value| value.to_le_bytes()));
    let mut hasher = blake3::Hasher::new();
    hasher.update(check);
    hasher.update(&bytes);
    *check = check_of(&hasher);
    bytes.extend(*check);
    bytes
}
