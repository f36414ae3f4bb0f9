//! Antenna numbers in one number.
//!
//! # Source
//! Memo, section 3.1.2: 256·a1 + a2 + 0.01·(subarray - 1). Miriad's extension for numbers above
//! 255, also found in MWA files: 2048·a1 + a2 + 65536, without a subarray.

/// Smallest value in Miriad's encoding.
const MIRIAD_OFFSET: u32 = 65536;

/// Subarray, first and second antenna number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Pair {
    pub(super) subarray: u32,
    pub(super) ant1: u32,
    pub(super) ant2: u32,
}

/// Decodes one value of BASELINE; `None` where no pair can be meant.
///
/// Each row by itself: files of 256 MWA tiles mix both encodings.
pub(super) fn decode(baseline: f64) -> Option<Pair> {
    if !(0.0..2_147_483_648.0).contains(&baseline) {
        return None;
    }
    // The margin undoes the rounding of a 32-bit 256·a1 + a2 + 0.01·s just below a whole number.
    let whole = (baseline + 0.002) as u32;
    if let Some(rest) = whole.checked_sub(MIRIAD_OFFSET) {
        // The fraction does not survive in 32 bits here, so it is not looked at.
        return Some(Pair {
            subarray: 1,
            ant1: rest / 2048,
            ant2: rest % 2048,
        });
    }
    // A cast takes off what comes after the point, and makes negative ones zero.
    let subarray = ((baseline - f64::from(whole)) * 100.0 + 0.5) as u32 + 1;
    Some(Pair {
        subarray,
        ant1: whole / 256,
        ant2: whole % 256,
    })
}

/// Encodes a pair of numbers below 256.
pub(super) fn encode(ant1: u32, ant2: u32) -> f32 {
    (256 * ant1 + ant2) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(subarray: u32, ant1: u32, ant2: u32) -> Pair {
        Pair {
            subarray,
            ant1,
            ant2,
        }
    }

    #[test]
    fn both_encodings_are_told_apart_by_value() {
        assert_eq!(decode(258.0), Some(pair(1, 1, 2)));
        assert_eq!(decode(f64::from(258.01_f32)), Some(pair(2, 1, 2)));
        assert_eq!(decode(f64::from(65_279.04_f32)), Some(pair(5, 254, 255)));
        assert_eq!(decode(65_535.0), Some(pair(1, 255, 255)));
        // The last row of a 256-tile file that mixes the encodings.
        assert_eq!(decode(590_080.0), Some(pair(1, 256, 256)));
        assert_eq!(decode(2048.0 + 300.0 + 65_536.0), Some(pair(1, 1, 300)));
    }

    #[test]
    fn nonsense_is_refused() {
        for value in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(decode(value), None);
        }
    }

    #[test]
    fn what_is_encoded_decodes() {
        for (ant1, ant2) in [(1, 2), (255, 255), (200, 1)] {
            assert_eq!(decode(encode(ant1, ant2).into()), Some(pair(1, ant1, ant2)));
        }
    }
}
