//! Codes of the types of values, and how many axes they may have.

pub(super) const TEXT: u32 = 11;
pub(super) const TABLE: u32 = 12;
pub(super) const RECORD: u32 = 25;

/// The code of arrays is that of their elements and this, but for those of long numbers.
const ARRAYS: u32 = 13;
const LONG: u32 = 29;
const ARRAY_OF_LONG: u32 = 30;

/// Most axes of an array; casacore makes room for whatever number is there.
pub(super) const MAX_AXES: u32 = 32;

/// What a value takes, if all of a type take the same; truths are bits where there are many.
pub(super) fn bits(code: u32) -> Option<u64> {
    match code {
        0 => Some(1),
        1 | 2 => Some(8),
        3 | 4 => Some(16),
        5..=7 => Some(32),
        8 | 9 | LONG => Some(64),
        10 => Some(128),
        _ => None,
    }
}

/// The type of an array's elements.
pub(super) fn element(code: u32) -> Option<u32> {
    match code {
        ARRAYS..RECORD => Some(code - ARRAYS),
        ARRAY_OF_LONG => Some(LONG),
        _ => None,
    }
}
