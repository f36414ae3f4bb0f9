//! Formats of binary-table columns.
//!
//! # Source
//! FITS Standard 4.0, section 7.3.1 and table 18.

/// A parsed `TFORMn`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tform {
    /// Elements in a cell (characters for `A`).
    pub(crate) repeat: u64,
    /// Type letter.
    pub(crate) letter: u8,
}

impl Tform {
    /// Parses `rT`, `rTa`; `None` where the standard knows no such format.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let digits = text.bytes().take_while(u8::is_ascii_digit).count();
        let repeat = if digits == 0 {
            1
        } else {
            text[..digits].parse().ok()?
        };
        let letter = *text.as_bytes().get(digits)?;
        let rest = &text[digits + 1..];
        let plain = rest.is_empty() || b"APQ".contains(&letter);
        (plain && b"LXBIJKAEDCMPQ".contains(&letter)).then_some(Self { repeat, letter })
    }

    /// Bytes in a cell; `None` on overflow.
    pub(crate) fn bytes(self) -> Option<u64> {
        let unit = match self.letter {
            b'X' => return Some(self.repeat.div_ceil(8)),
            b'L' | b'B' | b'A' => 1,
            b'I' => 2,
            b'J' | b'E' => 4,
            b'M' | b'Q' => 16,
            _ => 8,
        };
        self.repeat.checked_mul(unit)
    }

    /// The format as a plain `rT`, types that are not read here as bytes.
    pub(crate) fn plain(self) -> String {
        if b"ABIJKED".contains(&self.letter) {
            return format!("{}{}", self.repeat, self.letter as char);
        }
        format!("{}B", self.bytes().unwrap_or(0))
    }

    /// Whether a cell holds integers.
    pub(crate) fn is_integer(self) -> bool {
        b"BIJK".contains(&self.letter)
    }

    /// Whether a cell holds numbers, or truth values, that an `f64` can stand for.
    pub(crate) fn is_number(self) -> bool {
        self.is_integer() || b"EDL".contains(&self.letter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_have_their_sizes() {
        let bytes = |text: &str| Tform::parse(text).and_then(Tform::bytes);
        assert_eq!(bytes("8A"), Some(8));
        assert_eq!(bytes("3D      "), Some(24));
        assert_eq!(bytes("D"), Some(8));
        assert_eq!(bytes("0D"), Some(0));
        assert_eq!(bytes("9X"), Some(2));
        assert_eq!(bytes("1PE(20)"), Some(8));
        assert_eq!(bytes("18446744073709551615D"), None);
        assert_eq!(bytes("99999999999999999999D"), None);
        assert_eq!(bytes("-1D"), None);
        assert_eq!(bytes("1Z"), None);
        assert_eq!(bytes("1J7"), None);
        assert_eq!(bytes(""), None);
    }

    #[test]
    fn plain_formats_are_as_wide_as_their_originals() {
        for text in [
            "8A", "8A0", "3D", "D", "9X", "1PE(20)", "2QD", "3C", "4L", "0J",
        ] {
            let tform = Tform::parse(text).unwrap();
            let plain = Tform::parse(&tform.plain()).unwrap();
            assert_eq!(plain.bytes(), tform.bytes(), "{text}");
        }
    }
}
