//! The FITS checksum: the ones-complement sum of all 32-bit words of an HDU (FITS 4.0 appendix J).

use std::io::Write;

/// `CHECKSUM` while the HDU's own sum is taken.
pub(super) const BLANK: &str = "0000000000000000";

/// The ones-complement sum of the big-endian 32-bit words written to it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Checksum {
    sum: u32,
    /// Bytes so far, modulo 4.
    phase: u32,
}

impl Checksum {
    /// The sum with any last partial word filled up with zeros.
    pub(super) fn value(self) -> u32 {
        self.sum
    }

    fn add_word(&mut self, word: u32) {
        let (sum, carry) = self.sum.overflowing_add(word);
        self.sum = sum + u32::from(carry);
    }
}

impl Write for Checksum {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let to_boundary = ((4 - self.phase) % 4) as usize;
        let (head, rest) = bytes.split_at(to_boundary.min(bytes.len()));
        let words = rest.chunks_exact(4);
        let tail = words.remainder();
        for &byte in head {
            self.add_word(u32::from(byte) << (8 * (3 - self.phase)));
            self.phase = (self.phase + 1) % 4;
        }
        for word in words {
            self.add_word(u32::from_be_bytes([word[0], word[1], word[2], word[3]]));
        }
        for &byte in tail {
            self.add_word(u32::from(byte) << (8 * (3 - self.phase)));
            self.phase = (self.phase + 1) % 4;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// The 16 characters of `CHECKSUM` that bring an HDU whose sum is `sum` (with [`BLANK`] in their
/// place) to minus zero.
///
/// Each byte of the complement is spread over four characters; pairs are shifted against each other
/// until all are letters or digits.
pub(super) fn encode(sum: u32) -> String {
    let mut text = [0u8; 16];
    for (i, byte) in (!sum).to_be_bytes().into_iter().enumerate() {
        let mut quad = [byte / 4 + b'0'; 4];
        quad[0] += byte % 4;
        while !quad.iter().all(u8::is_ascii_alphanumeric) {
            for pair in quad.chunks_exact_mut(2) {
                if !pair.iter().all(u8::is_ascii_alphanumeric) {
                    pair[0] += 1;
                    pair[1] -= 1;
                }
            }
        }
        for (j, c) in quad.into_iter().enumerate() {
            // The value starts at column 12 of its card, one byte before a word.
            text[(4 * j + i + 1) % 16] = c;
        }
    }
    text.iter().map(|&c| char::from(c)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_the_standard_is_met() {
        // FITS 4.0 appendix J.3: sum 868229149 encodes as "hcHjjc9ghcEghc9g".
        assert_eq!(encode(868_229_149), "hcHjjc9ghcEghc9g");
    }

    #[test]
    fn the_sum_does_not_depend_on_how_the_bytes_arrive() {
        let bytes: Vec<u8> = (0..1001u32).map(|i| (i * 37 % 251) as u8).collect();
        let mut whole = Checksum::default();
        whole.write_all(&bytes).unwrap();
        for step in [1, 2, 3, 5, 7] {
            let mut parts = Checksum::default();
            for part in bytes.chunks(step) {
                parts.write_all(part).unwrap();
            }
            assert_eq!(parts.value(), whole.value());
        }
    }

    #[test]
    fn every_code_is_letters_and_digits_and_sums_to_the_complement() {
        for i in 0..20_000u32 {
            let sum = i.wrapping_mul(2_654_435_761);
            let code = encode(sum);
            assert!(code.bytes().all(|c| c.is_ascii_alphanumeric()), "{code}");
            let place = |text: &str, sum: u32| {
                let mut total = Checksum { sum, phase: 3 };
                total.write_all(text.as_bytes()).unwrap();
                total.value()
            };
            // Replacing sixteen zeros by the code adds the complement.
            let zeros = place(BLANK, 0);
            let with_code = place(&code, 0);
            let mut total = Checksum {
                sum: with_code,
                phase: 0,
            };
            total.add_word(!zeros);
            total.add_word(sum);
            assert_eq!(total.value(), u32::MAX, "sum {sum}");
        }
    }
}
