//! Indices of names, which are looked at before libhdf5 walks them.
//!
//! A group of the newer layout that has many members keeps their links in a fractal heap, with B-trees of version 2
//! over it. libhdf5 believes what these say of their own shape: it divides by the length of a record that may be
//! none, and reads beyond blocks that are smaller than they should be. It writes all of them in one shape, which no
//! program can ask it to change; so any other is damage.
//!
//! # Source
//! HDF5 File Format Specification 3.0, III.A.2 (B-trees), III.G (fractal heap), IV.A.2.c (link info).

use std::path::Path;

use super::raw_file::{NOWHERE, RawFile, number};

/// The message about the links of a group.
const LINK_INFO: u16 = 0x02;

/// Makes sure that the indices of a group's names are as libhdf5 writes them.
///
/// # Errors
/// What is wrong with them, or with what leads to them.
pub(super) fn check(path: &Path, address: u64) -> Result<(), String> {
    let mut raw = RawFile::open(path)?;
    for info in raw.messages(address, LINK_INFO)? {
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
