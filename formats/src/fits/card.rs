//! One 80-byte header card: reading and writing.
//!
//! # Source
//! FITS Standard 4.0, sections 4.1 and 4.2.

use super::CARD_BYTES;

/// The value of a card.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    /// A quoted string, without trailing blanks.
    Text(String),
    /// An integer that fits 64 bits.
    Integer(i64),
    /// Any other finite number.
    Real(f64),
    /// `T` or `F`.
    Logical(bool),
    /// Nothing, or nothing that the standard knows.
    Unreadable(String),
}

/// The keyword of a card: columns 1 to 8 without trailing blanks.
pub(crate) fn keyword(card: &[u8; CARD_BYTES]) -> String {
    printable(&card[..8])
}

/// The free text of a commentary card (HISTORY, COMMENT): columns 9 to 80.
pub(crate) fn commentary(card: &[u8; CARD_BYTES]) -> String {
    printable(&card[8..])
}

/// The value of a card; `None` where columns 9 and 10 are not the value indicator `= `.
pub(crate) fn value(card: &[u8; CARD_BYTES]) -> Option<Value> {
    if card[8] != b'=' {
        return None;
    }
    let field = printable(&card[9..]);
    let field = field.trim_start();
    if let Some(rest) = field.strip_prefix('\'') {
        return Some(text(rest));
    }
    let token = field.split('/').next().unwrap_or("").trim();
    Some(match token {
        "T" => Value::Logical(true),
        "F" => Value::Logical(false),
        _ => number(token),
    })
}

/// A string up to its closing quote; a doubled quote stands for one.
fn text(rest: &str) -> Value {
    let mut out = String::new();
    let mut chars = rest.chars().peekable();
    while let Some(c) = chars.next() {
        if c == '\'' {
            if chars.peek() != Some(&'\'') {
                return Value::Text(out.trim_end().to_owned());
            }
            chars.next();
        }
        out.push(c);
    }
    Value::Unreadable(format!("'{rest}"))
}

/// An integer or a finite real number, exponent letter E or D.
fn number(token: &str) -> Value {
    if let Ok(integer) = token.parse::<i64>() {
        return Value::Integer(integer);
    }
    let plain = token
        .bytes()
        .all(|b| b.is_ascii_digit() || b"+-.EDed".contains(&b));
    match token.replace(['D', 'd'], "E").parse::<f64>() {
        Ok(real) if plain && real.is_finite() => Value::Real(real),
        _ => Value::Unreadable(token.to_owned()),
    }
}

/// Bytes as text without trailing blanks; what is not printable ASCII becomes `?`.
pub(crate) fn printable(bytes: &[u8]) -> String {
    let visible = |&b: &u8| {
        if (b' '..=b'~').contains(&b) {
            b as char
        } else {
            '?'
        }
    };
    let text: String = bytes.iter().map(visible).collect();
    text.trim_end().to_owned()
}

/// Header text under construction, card by card.
#[derive(Debug, Default)]
pub(crate) struct Cards {
    /// The cards so far, 80 bytes each.
    pub(crate) bytes: Vec<u8>,
}

impl Cards {
    /// Appends a logical.
    pub(crate) fn logical(&mut self, key: &str, value: bool, comment: &str) {
        self.fixed(key, if value { "T" } else { "F" }, comment);
    }

    /// Appends an integer.
    pub(crate) fn integer(&mut self, key: &str, value: i64, comment: &str) {
        self.fixed(key, &value.to_string(), comment);
    }

    /// Appends a real number in the shortest form that reads back to the same bits.
    pub(crate) fn real(&mut self, key: &str, value: f64, comment: &str) {
        self.fixed(key, &real_text(value), comment);
    }

    /// Appends a string, cut where it would not fit its card.
    pub(crate) fn text(&mut self, key: &str, value: &str, comment: &str) {
        let mut quoted = String::from("'");
        for c in printable(value.as_bytes()).chars() {
            let width = if c == '\'' { 2 } else { 1 };
            if quoted.len() + width > 68 {
                break;
            }
            quoted.push(c);
            if c == '\'' {
                quoted.push(c);
            }
        }
        // Fixed format wants at least eight characters between the quotes (section 4.2.1).
        let quoted = format!("{quoted:<9}'");
        self.push(&with_comment(&format!("{key:<8}= {quoted:<20}"), comment));
    }

    /// Appends commentary, as many cards as the text needs.
    pub(crate) fn history(&mut self, text: &str) {
        let text = printable(text.as_bytes());
        let bytes = text.as_bytes();
        for piece in bytes.chunks(CARD_BYTES - 8) {
            self.push(&format!("HISTORY {}", String::from_utf8_lossy(piece)));
        }
    }

    /// Appends END and pads to whole blocks.
    pub(crate) fn end(mut self) -> Vec<u8> {
        self.push("END");
        let padded = self.bytes.len().next_multiple_of(super::BLOCK_BYTES);
        self.bytes.resize(padded, b' ');
        self.bytes
    }

    fn fixed(&mut self, key: &str, value: &str, comment: &str) {
        self.push(&with_comment(&format!("{key:<8}= {value:>20}"), comment));
    }

    fn push(&mut self, card: &str) {
        let mut bytes = card.as_bytes().to_vec();
        bytes.resize(CARD_BYTES, b' ');
        self.bytes.extend_from_slice(&bytes);
    }
}

/// A card with its comment, where there is one.
fn with_comment(card: &str, comment: &str) -> String {
    if comment.is_empty() {
        return card.to_owned();
    }
    format!("{card} / {comment}")
}

/// A real number as FITS writes it: upper-case exponent and always a decimal point.
fn real_text(value: f64) -> String {
    let text = format!("{value:?}").to_uppercase();
    match text.split_once('E') {
        Some((mantissa, exponent)) if !mantissa.contains('.') => format!("{mantissa}.0E{exponent}"),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn card(text: &str) -> [u8; CARD_BYTES] {
        let mut bytes = [b' '; CARD_BYTES];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        bytes
    }

    #[test]
    fn values_of_every_kind_are_read() {
        let read = |text: &str| value(&card(text)).unwrap();
        assert_eq!(
            read("BITPIX  =                  -32 / bits"),
            Value::Integer(-32)
        );
        assert_eq!(
            read("PZERO5  =    2.45390150000D+06 /"),
            Value::Real(2453901.5)
        );
        assert_eq!(read("GROUPS  =                    T"), Value::Logical(true));
        assert_eq!(read("CTYPE2  = 'COMPLEX '"), Value::Text("COMPLEX".into()));
        assert_eq!(
            read("OBJECT  = 'O''Neil / x' / y"),
            Value::Text("O'Neil / x".into())
        );
        assert_eq!(
            read("PSCAL1  =                  nan"),
            Value::Unreadable("nan".into())
        );
        assert_eq!(
            read("PSCAL1  =               1E9999"),
            Value::Unreadable("1E9999".into())
        );
        assert_eq!(read("OBJECT  = 'open"), Value::Unreadable("'open".into()));
        assert_eq!(
            value(&card("HISTORY = no")),
            Some(Value::Unreadable("no".into()))
        );
        assert_eq!(value(&card("COMMENT none")), None);
    }

    #[test]
    fn written_cards_read_back_bit_for_bit() {
        for number in [
            0.0,
            -1.5,
            1e-10,
            1.4e9,
            2457368.5,
            f64::MIN_POSITIVE,
            1.0 / 3.0,
        ] {
            let mut cards = Cards::default();
            cards.real("KEY", number, "note");
            let written: [u8; CARD_BYTES] = cards.bytes.try_into().unwrap();
            assert_eq!(value(&written), Some(Value::Real(number)));
        }
    }

    #[test]
    fn long_text_is_cut_to_its_card() {
        let mut cards = Cards::default();
        cards.text("OBJECT", &"'".repeat(100), "comment");
        assert_eq!(cards.bytes.len(), CARD_BYTES);
        let written: [u8; CARD_BYTES] = cards.bytes.try_into().unwrap();
        assert_eq!(value(&written), Some(Value::Text("'".repeat(33))));
    }
}
