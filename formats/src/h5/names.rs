//! Indices of names, which are looked at before libhdf5 walks them.
//!
//! A group of the newer layout that has many members keeps their links in a fractal heap, with B-trees of version 2
//! over it. libhdf5 believes what these say of their own shape: it divides by the length of a record that may be
//! none, and reads beyond blocks that are smaller than they should be. It writes all of them in one shape, which no
//! program can ask it to change; so any other is damage.
//!
//! # Source
//! HDF5 File Format Specification 3.0, III.A.2 (B-trees), III.G (fractal heap), IV.A.1 (object headers),
//! IV.A.2.c (link info).

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// What a file begins with; it may stand after a block of the user's.
const SIGNATURE: &[u8; 8] = b"\x89HDF\r\n\x1a\n";
const LAST_START: u64 = 1 << 24;

/// Types of messages.
const LINK_INFO: u16 = 0x02;
const CONTINUATION: u16 = 0x10;

/// Messages of a group, and blocks that they stand in, beyond which its header goes in circles.
const MOST_MESSAGES: usize = 1 << 16;
const MOST_BLOCKS: usize = 1 << 10;

/// The address of what is not there.
const NOWHERE: u64 = u64::MAX;

/// Makes sure that the indices of a group's names are as libhdf5 writes them.
///
/// # Errors
/// What is wrong with them, or with what leads to them.
pub(super) fn check(path: &Path, address: u64) -> Result<(), String> {
    let mut raw = Raw::open(path)?;
    for info in link_infos(&mut raw, address)? {
        let [heap, by_name, by_age] = addresses(&info)?;
        if heap != NOWHERE {
            check_heap(&raw.array(heap)?)?;
            check_tree(&raw.array(by_name)?, 5, 11)?;
        }
        if by_age != NOWHERE {
            check_tree(&raw.array(by_age)?, 6, 15)?;
        }
    }
    Ok(())
}

/// Addresses of the heap of links, of its index by name, and of that by age.
fn addresses(info: &[u8]) -> Result<[u64; 3], String> {
    let flags = *info.get(1).ok_or("its link info is cut short")?;
    // The highest age comes first if there are ages, and their index last if there is one.
    let first = if flags & 1 == 0 { 2 } else { 10 };
    let address = |k: usize| -> Result<u64, String> {
        let bytes = info.get(first + 8 * k..first + 8 * (k + 1));
        Ok(number(bytes.ok_or("its link info is cut short")?))
    };
    let by_age = if flags & 2 == 0 { NOWHERE } else { address(2)? };
    Ok([address(0)?, address(1)?, by_age])
}

/// The header of a fractal heap.
fn check_heap(header: &[u8; 142]) -> Result<(), String> {
    // Width of a row, size of the first blocks and of the largest, bits of an address within it, first rows.
    let table = (&header[110..112], &header[112..120], &header[120..128]);
    let table = (number(table.0), number(table.1), number(table.2));
    let rest = (number(&header[128..130]), number(&header[130..132]));
    let n_row = number(&header[140..142]);
    let is_good = header.starts_with(b"FRHP\x00")
        // Length of an identifier, of filters, flags, and the largest object that is not put elsewhere.
        && header[5..10] == [7, 0, 0, 0, 2]
        && number(&header[10..14]) == 4096
        && table == (4, 512, 1 << 16)
        && rest == (32, 1)
        && n_row <= 22;
    is_good
        .then_some(())
        .ok_or("its heap of links is damaged".into())
}

/// The header of a B-tree of version 2 of a type, with records of a length.
fn check_tree(header: &[u8; 16], kind: u8, record: u64) -> Result<(), String> {
    let is_good = header.starts_with(b"BTHD\x00")
        && header[5] == kind
        && number(&header[6..10]) == 512
        && number(&header[10..12]) == record
        && number(&header[12..14]) <= 16
        && header[14..] == [100, 40];
    is_good
        .then_some(())
        .ok_or("its index of names is damaged".into())
}

/// What the messages about links in an object header hold.
fn link_infos(raw: &mut Raw, address: u64) -> Result<Vec<Vec<u8>>, String> {
    let start: [u8; 16] = raw.array(address)?;
    let (is_new, first) = if start.starts_with(b"OHDR\x02") {
        (true, first_block(raw, address, start[5])?)
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
    let mut infos = Vec::new();
    let (mut n_message, mut n_block) = (0, 0);
    while let Some((mut at, length)) = blocks.pop() {
        n_block += 1;
        let end = at.checked_add(length).ok_or("its header is damaged")?;
        while at.saturating_add(header) <= end {
            n_message += 1;
            if n_message > MOST_MESSAGES || n_block > MOST_BLOCKS {
                return Err("its header goes in circles".into());
            }
            let start: [u8; 8] = raw.array(at)?;
            let (kind, size) = if is_new {
                (u16::from(start[0]), number(&start[1..3]))
            } else {
                (number(&start[..2]) as u16, number(&start[2..4]))
            };
            if kind == LINK_INFO {
                infos.push(raw.bytes(at + header, size as usize)?);
            } else if kind == CONTINUATION {
                let place: [u8; 16] = raw.array(at + header)?;
                let (at, length) = (number(&place[..8]), number(&place[8..]));
                // Of the newer layout, a signature before the messages and a checksum after them.
                let (before, around) = if is_new { (4, 8) } else { (0, 0) };
                blocks.push((at.saturating_add(before), length.saturating_sub(around)));
            }
            at = at.saturating_add(header + size);
        }
    }
    Ok(infos)
}

/// Where the messages of a header of the newer layout begin, and how many bytes they take.
fn first_block(raw: &mut Raw, address: u64, flags: u8) -> Result<(u64, u64), String> {
    let times = if flags & 0x20 == 0 { 0 } else { 16 };
    let attributes = if flags & 0x10 == 0 { 0 } else { 4 };
    let at = address + 6 + times + attributes;
    let width = 1 << (flags & 3);
    let length = number(&raw.bytes(at, width)?);
    Ok((at + width as u64, length))
}

/// A number of up to eight bytes.
fn number(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .rev()
        .fold(0, |sum, &b| sum << 8 | u64::from(b))
}

/// A file without libhdf5.
struct Raw {
    file: File,
    /// Where its addresses count from.
    base: u64,
}

impl Raw {
    fn open(path: &Path) -> Result<Self, String> {
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

    fn array<const N: usize>(&mut self, address: u64) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.fill(address, &mut bytes)?;
        Ok(bytes)
    }

    /// Up to 65 536 bytes.
    fn bytes(&mut self, address: u64, count: usize) -> Result<Vec<u8>, String> {
        let mut bytes = vec![0; count.min(1 << 16)];
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
