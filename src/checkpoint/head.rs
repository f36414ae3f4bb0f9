//! Whose answers these are.

use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};
use vis2cat_formats::{PendingFile, WriteError};

use super::record::{CHECK_BYTES, Check};
use super::{CheckpointError, array, check_of};

const MAGIC: &[u8; 8] = b"V2CCKPT\n";
const VERSION: u32 = 1;

/// All that decides what a run asks and what it is told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of the program.
    pub version: String,
    /// Processor and instruction set.
    pub processor: String,
    /// Digest of the input.
    pub input: String,
    /// Every option that decides the result, `key = value` a line.
    pub config: String,
}

impl Identity {
    /// What differs between the run `self` and that of a checkpoint, if anything does.
    fn difference(&self, of_file: &Self) -> Option<String> {
        if of_file.version != self.version {
            return Some(format!(
                "it is by vis2cat {}, this is {}",
                of_file.version, self.version
            ));
        }
        if of_file.input != self.input {
            return Some("the input has changed, or is another one".into());
        }
        if of_file.config != self.config {
            let then = of_file.config.lines().chain(std::iter::repeat(""));
            let lines = self.config.lines().chain(std::iter::repeat("")).zip(then);
            let most = self.config.lines().count() + of_file.config.lines().count();
            let differs = lines.take(most).find(|(now, then)| now != then);
            let (now, then) = differs.unwrap_or_default();
            return Some(format!("its options differ: '{then}' there, '{now}' here"));
        }
        (of_file.processor != self.processor).then(|| {
            format!(
                "it was written on {}, this is {}: sums differ in their last bits",
                of_file.processor, self.processor
            )
        })
    }
}

/// Writes a checkpoint without answers, whole or not at all.
pub(super) fn write(path: &Path, identity: &Identity, overwrite: bool) -> Result<(), WriteError> {
    let parameter = |what: String| WriteError::Parameter {
        path: path.into(),
        what,
    };
    let text = serde_json::to_vec(identity).map_err(|e| parameter(e.to_string()))?;
    let n = u32::try_from(text.len()).map_err(|e| parameter(e.to_string()))?;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(n.to_le_bytes());
    bytes.extend(text);
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes);
    bytes.extend(check_of(&hasher));
    let mut pending = PendingFile::create(path, overwrite)?;
    pending.append(&bytes)?;
    pending.commit()
}

/// Reads the head of a file of `len` bytes and compares it with `identity`; returns its check, from
/// which those of the records go on.
pub(super) fn read(
    path: &Path,
    file: &mut impl Read,
    len: u64,
    identity: &Identity,
) -> Result<Check, CheckpointError> {
    let malformed = |what: &str| CheckpointError::Malformed {
        path: path.into(),
        what: what.into(),
    };
    let damaged = || malformed("the head of this checkpoint is damaged; remove it to begin anew");
    let unreadable = |source: std::io::Error| CheckpointError::Read {
        path: path.into(),
        source,
    };
    let no_checkpoint = || malformed("this is no checkpoint of vis2cat, and is left as it is");
    let short = MAGIC.len() + 2 * size_of::<u32>() + CHECK_BYTES;
    if len < short as u64 {
        return Err(no_checkpoint());
    }
    let magic: [u8; 8] = array(file).map_err(unreadable)?;
    if magic != *MAGIC {
        return Err(no_checkpoint());
    }
    let version: [u8; 4] = array(file).map_err(unreadable)?;
    if u32::from_le_bytes(version) != VERSION {
        return Err(malformed(
            "this checkpoint has another format, of another version of vis2cat; remove it to begin anew",
        ));
    }
    let n: [u8; 4] = array(file).map_err(unreadable)?;
    if u64::from(u32::from_le_bytes(n)) > len - short as u64 {
        return Err(damaged());
    }
    let mut text = vec![0; u32::from_le_bytes(n) as usize];
    file.read_exact(&mut text).map_err(unreadable)?;
    let mut hasher = blake3::Hasher::new();
    for part in [&magic[..], &version, &n, &text] {
        hasher.update(part);
    }
    let check = check_of(&hasher);
    if array(file).map_err(unreadable)? != check {
        return Err(damaged());
    }
    let of_file: Identity = serde_json::from_slice(&text).map_err(|_| damaged())?;
    match identity.difference(&of_file) {
        None => Ok(check),
        Some(what) => Err(CheckpointError::Foreign {
            path: path.into(),
            what,
        }),
    }
}
