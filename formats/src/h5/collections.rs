//! Collections of texts, which are looked at before libhdf5 reads them.
//!
//! A text of any length stands in a collection with others. libhdf5 goes from one to the next by their lengths, and
//! for ever stays at one that takes nothing.
//!
//! # Source
//! HDF5 File Format Specification 3.0, III.E (global heap), IV.A.2.i (data layout).

use super::raw_file::{NOWHERE, RawFile, number};

/// The message that says where the data of a dataset stand.
const LAYOUT: u16 = 0x08;

/// Bytes by which a dataset refers to one text: its length, its collection, and its number there.
pub(super) const REFERENCE_BYTES: usize = 16;

/// Where the data of a dataset stand.
#[derive(Debug)]
pub(super) enum Place {
    /// In its header.
    Header(Vec<u8>),
    /// From that byte on.
    At(u64),
    /// In chunks, or not yet anywhere.
    Elsewhere,
    /// In other datasets.
    Virtual,
}

/// Where the data of the dataset stand whose header is at `address`.
pub(super) fn place(raw: &mut RawFile, address: u64) -> Result<Place, String> {
    let Some(layout) = raw.messages(address, LAYOUT)?.pop() else {
        return Ok(Place::Elsewhere);
    };
    let part = |first: usize, count: usize| {
        let bytes = layout.get(first..first + count);
        bytes.ok_or_else(|| "its layout is cut short".to_owned())
    };
    let is_old = part(0, 1)?[0] < 3;
    // Of the older layout, the number of axes comes before the class, and their lengths before the data.
    let class = part(if is_old { 2 } else { 1 }, 1)?[0];
    let (first, width) = if is_old {
        (8 + 4 * usize::from(part(1, 1)?[0]), 4)
    } else {
        (2, 2)
    };
    Ok(match class {
        0 => {
            let count = number(part(first, width)?) as usize;
            Place::Header(part(first + width, count)?.to_vec())
        }
        1 => match number(part(if is_old { 8 } else { 2 }, 8)?) {
            NOWHERE => Place::Elsewhere,
            address => Place::At(address),
        },
        3 => Place::Virtual,
        _ => Place::Elsewhere,
    })
}

/// Makes sure that collections that texts are in can be gone through.
///
/// # Errors
/// What is wrong with one of them.
pub(super) fn check(raw: &mut RawFile, references: &[u8]) -> Result<(), String> {
    let references = references.chunks_exact(REFERENCE_BYTES);
    let mut addresses: Vec<u64> = references
        .filter(|reference| number(&reference[..4]) > 0)
        .map(|reference| number(&reference[4..12]))
        .collect();
    addresses.sort_unstable();
    addresses.dedup();
    addresses.into_iter().try_for_each(|at| {
        walk(raw, at).and_then(|done| done.ok_or("its collection of texts is damaged".into()))
    })
}

/// Goes from text to text; none if there is no way to the end.
fn walk(raw: &mut RawFile, address: u64) -> Result<Option<()>, String> {
    let start: [u8; 16] = raw.array(address)?;
    let end = address.saturating_add(number(&start[8..]));
    if !start.starts_with(b"GCOL\x01") {
        return Ok(None);
    }
    let mut at = address + 16;
    while at.saturating_add(16) <= end {
        let text: [u8; 16] = raw.array(at)?;
        let length = number(&text[8..]);
        // What is left over has number 0, and counts its own head.
        let step = match number(&text[..2]) {
            0 => Some(length),
            _ => length
                .checked_next_multiple_of(8)
                .and_then(|n| n.checked_add(16)),
        };
        match step.and_then(|step| at.checked_add(step)) {
            Some(next) if next >= at + 8 && next <= end => at = next,
            _ => return Ok(None),
        }
    }
    Ok(Some(()))
}
