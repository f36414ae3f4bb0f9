//! A file without libhdf5: what must be looked at before libhdf5 does.
//!
//! # Source
//! HDF5 File Format Specification 3.0, II (superblock), IV.A.1 (object headers).

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// What a file begins with; it may stand after a block of the user's.
const SIGNATURE: &[u8; 8] = b"\x89HDF\r\n\x1a\n";
const LAST_START: u64 = 1 << 24;

/// The message that says where further ones stand.
const CONTINUATION: u16 = 0x10;

/// Messages of an object, and blocks that they stand in, beyond which its header goes in circles.
const MOST_MESSAGES: usize = 1 << 16;
const MOST_BLOCKS: usize = 1 << 10;

/// The address of what is not there.
pub(super) const NOWHERE: u64 = u64::MAX;

/// A number of up to eight bytes.
pub(super) fn number(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .rev()
        .fold(0, |sum, &b| sum << 8 | u64::from(b))
}

/// A file without libhdf5.
#[derive(Debug)]
pub(super) struct RawFile {
    file: File,
    /// Where its addresses count from.
    base: u64,
}

impl RawFile {
    /// Opens a file whose addresses are as wide as all programs make them.
    pub(super) fn open(path: &Path) -> Result<Self, String> {
        let file = File::open(path).map_err(|error| error.to_string())?;
        let mut raw = Self { file, base: 0 };
        while raw.array::<8>(0).as_ref() != Ok(SIGNATURE) {
            raw.base = (2 * raw.base).max(512);
            if raw.base > LAST_START {
                return Err("it does not begin as a file of HDF5".into());
            }
        }
        let start: [u8; 16] = raw.array(0)?;
        let sizes = if start[8] < 2 {
            &start[13..15]
        } else {
            &start[9..11]
        };
        if sizes != [8, 8] {
            return Err(format!(
                "addresses and lengths take {sizes:?} bytes, not 8 each"
            ));
        }
        Ok(raw)
    }

    /// What the messages of a type in the object header at `address` hold.
    pub(super) fn messages(&mut self, address: u64, wanted: u16) -> Result<Vec<Vec<u8>>, String> {
        let start: [u8; 16] = self.array(address)?;
        let (is_new, first) = if start.starts_with(b"OHDR\x02") {
            (true, self.first_block(address, start[5])?)
        } else if start[0] == 1 {
            (false, (address + 16, number(&start[8..12])))
        } else {
            return Err("its header is damaged".into());
        };
        // Of the newer layout, messages may have an age.
        let header = match (is_new, start[5] & 4 != 0) {
            (false, _) => 8,
            (true, false) => 4,
            (true, true) => 6,
        };
        let mut blocks = vec![first];
        let mut found = Vec::new();
        let (mut n_message, mut n_block) = (0, 0);
        while let Some((mut at, length)) = blocks.pop() {
            n_block += 1;
            let end = at.checked_add(length).ok_or("its header is damaged")?;
            while at.saturating_add(header) <= end {
                n_message += 1;
                if n_message > MOST_MESSAGES || n_block > MOST_BLOCKS {
                    return Err("its header goes in circles".into());
                }
                let start: [u8; 8] = self.array(at)?;
                let (kind, size) = if is_new {
                    (u16::from(start[0]), number(&start[1..3]))
                } else {
                    (number(&start[..2]) as u16, number(&start[2..4]))
                };
                if kind == wanted {
                    found.push(self.bytes(at + header, size as usize)?);
                } else if kind == CONTINUATION {
                    let place: [u8; 16] = self.array(at + header)?;
                    let (at, length) = (number(&place[..8]), number(&place[8..]));
                    // Of the newer layout, a signature before the messages and a checksum after them.
                    let (before, around) = if is_new { (4, 8) } else { (0, 0) };
                    blocks.push((at.saturating_add(before), length.saturating_sub(around)));
                }
                at = at.saturating_add(header + size);
            }
        }
        Ok(found)
    }

    /// Where the messages of a header of the newer layout begin, and how many bytes they take.
    fn first_block(&mut self, address: u64, flags: u8) -> Result<(u64, u64), String> {
        let times = if flags & 0x20 == 0 { 0 } else { 16 };
        let attributes = if flags & 0x10 == 0 { 0 } else { 4 };
        let at = address + 6 + times + attributes;
        let width = 1 << (flags & 3);
        let length = number(&self.bytes(at, width)?);
        Ok((at + width as u64, length))
    }

    /// The bytes at an address.
    pub(super) fn array<const N: usize>(&mut self, address: u64) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.fill(address, &mut bytes)?;
        Ok(bytes)
    }

    /// That many bytes, which must be no more than there is memory for.
    pub(super) fn bytes(&mut self, address: u64, count: usize) -> Result<Vec<u8>, String> {
        let mut bytes = vec![0; count];
        self.fill(address, &mut bytes)?;
        Ok(bytes)
    }

    fn fill(&mut self, address: u64, bytes: &mut [u8]) -> Result<(), String> {
        let at = self.base.checked_add(address).ok_or("it points nowhere")?;
        let done = self.file.seek(SeekFrom::Start(at));
        done.and_then(|_| self.file.read_exact(bytes))
            .map_err(|error| format!("there is nothing at byte {at} ({error})"))
    }
}
