//! Correlations by their numbers.
//!
//! # Source
//! casacore's manual, class Stokes, StokesTypes.

use crate::Corr;

/// Numbers and correlations; the hands of a row are in the order of the numbers.
const CORRS: [(i32, Corr); 12] = [
    (1, Corr::I),
    (2, Corr::Q),
    (3, Corr::U),
    (4, Corr::V),
    (5, Corr::Rr),
    (6, Corr::Rl),
    (7, Corr::Lr),
    (8, Corr::Ll),
    (9, Corr::Xx),
    (10, Corr::Xy),
    (11, Corr::Yx),
    (12, Corr::Yy),
];

/// The correlation of a number.
pub(super) fn from_number(number: i32) -> Option<Corr> {
    let entry = CORRS.iter().find(|entry| entry.0 == number);
    entry.map(|entry| entry.1)
}

/// The number of a correlation.
pub(super) fn number(corr: Corr) -> i32 {
    let entry = CORRS.iter().find(|entry| entry.1 == corr);
    entry.map_or(0, |entry| entry.0)
}

/// Which receptor of the first and of the second antenna a correlation is of.
pub(super) fn receptors(corr: Corr) -> [i32; 2] {
    match corr {
        Corr::Rl | Corr::Xy | Corr::Q => [0, 1],
        Corr::Lr | Corr::Yx | Corr::U => [1, 0],
        Corr::Ll | Corr::Yy | Corr::V => [1, 1],
        Corr::I | Corr::Rr | Corr::Xx => [0, 0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_there_and_back() {
        for wanted in 1..=12 {
            assert_eq!(from_number(wanted).map(number), Some(wanted));
        }
        assert_eq!(from_number(0), None);
        assert_eq!(from_number(13), None);
    }
}
