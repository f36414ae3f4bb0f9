//! Header cards: 80 ASCII characters each (FITS 4.0 section 4).

use super::CARD;

/// Longest string that one card holds between its quotes.
const MAX_STR: usize = 68;
/// Longest text of a `COMMENT` or `HISTORY` card.
const MAX_TEXT: usize = 72;

/// Value of a keyword.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Characters; longer than one card continues on `CONTINUE` cards.
    Str(String),
    /// A whole number.
    Int(i128),
    /// A finite number.
    Float(f64),
    /// True or false.
    Bool(bool),
}

impl From<&str> for Value {
    fn from(value: &str) -> Self {
        Self::Str(value.to_owned())
    }
}
impl From<String> for Value {
    fn from(value: String) -> Self {
        Self::Str(value)
    }
}
impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Float(value)
    }
}
impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}
impl From<u64> for Value {
    fn from(value: u64) -> Self {
        Self::Int(value.into())
    }
}
impl From<i64> for Value {
    fn from(value: i64) -> Self {
        Self::Int(value.into())
    }
}
impl From<usize> for Value {
    fn from(value: usize) -> Self {
        Self::Int(value as i128)
    }
}

/// A keyword with value and comment.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyword {
    /// Up to 8 of `A-Z 0-9 - _`.
    pub key: String,
    /// The value.
    pub value: Value,
    /// What it means, with `[unit]` in front where it has one; cut at the end of the card.
    pub comment: String,
}

impl Keyword {
    /// A keyword.
    pub fn new(key: &str, value: impl Into<Value>, comment: &str) -> Self {
        Self {
            key: key.to_owned(),
            value: value.into(),
            comment: comment.to_owned(),
        }
    }

    /// Why this keyword cannot stand in a header, if it cannot.
    pub(super) fn fault(&self) -> Option<String> {
        let key = &self.key;
        let legal = |c: u8| c.is_ascii_uppercase() || c.is_ascii_digit() || b"-_".contains(&c);
        if key.is_empty() || key.len() > 8 || !key.bytes().all(legal) {
            return Some(format!("{key:?} is not a FITS keyword (8 of A-Z 0-9 - _)"));
        }
        match self.value {
            Value::Float(x) if !x.is_finite() => Some(format!("keyword {key} is {x}: not finite")),
            _ => None,
        }
    }

    /// The keyword as one card, or several for a long string.
    pub(super) fn cards(&self) -> Vec<[u8; CARD]> {
        let key = &self.key;
        let comment = to_ascii(&self.comment);
        let fixed = match &self.value {
            Value::Str(s) => return string_cards(key, &to_ascii(s), &comment),
            Value::Int(i) => i.to_string(),
            Value::Float(x) => float(*x),
            Value::Bool(b) => (if *b { "T" } else { "F" }).to_owned(),
        };
        vec![card(&with_comment(
            format!("{key:<8}= {fixed:>20}"),
            &comment,
        ))]
    }
}

/// `COMMENT` or `HISTORY` cards with `text`, broken at spaces where that is possible.
pub(super) fn text_cards(key: &str, text: &str) -> Vec<[u8; CARD]> {
    let text = to_ascii(text);
    let mut rest = text.as_str();
    let mut cards = Vec::new();
    loop {
        let cut = match rest.len() {
            n if n <= MAX_TEXT => n,
            _ => (rest[..=MAX_TEXT].rfind(' '))
                .filter(|&at| at > MAX_TEXT / 2)
                .unwrap_or(MAX_TEXT),
        };
        cards.push(card(&format!("{key:<8}{}", &rest[..cut])));
        rest = rest[cut..].strip_prefix(' ').unwrap_or(&rest[cut..]);
        if rest.is_empty() {
            return cards;
        }
    }
}

/// The card that ends a header.
pub(super) fn end_card() -> [u8; CARD] {
    card("END")
}

/// `text` with every character outside printable ASCII replaced: µ by u, others by a question mark.
pub(super) fn to_ascii(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            ' '..='~' => c,
            '\t' | '\n' | '\r' => ' ',
            'µ' | 'μ' => 'u',
            '±' => '~',
            _ => '?',
        })
        .collect()
}

/// A finite number with decimal point, in the fewest digits that give it back.
fn float(x: f64) -> String {
    let text = format!("{x:?}").to_uppercase();
    match text.split_once('E') {
        Some((mantissa, exponent)) if !mantissa.contains('.') => format!("{mantissa}.0E{exponent}"),
        _ => text,
    }
}

/// A string value, by the `CONTINUE` convention (FITS 4.0 section 4.2.1.2) if it is long.
fn string_cards(key: &str, text: &str, comment: &str) -> Vec<[u8; CARD]> {
    let mut pieces = pieces(text);
    let last = pieces.pop().unwrap_or_default();
    let mut cards = Vec::new();
    let head = |first: bool| {
        if first {
            format!("{key:<8}= ")
        } else {
            "CONTINUE  ".to_owned()
        }
    };
    for piece in pieces {
        cards.push(card(&format!("{}'{piece}&'", head(cards.is_empty()))));
    }
    let value = format!("{}{:<20}", head(cards.is_empty()), format!("'{last:<8}'"));
    cards.push(card(&with_comment(value, comment)));
    cards
}

/// `text` with quotes doubled, in pieces that fit a card; a doubled quote is never torn apart.
fn pieces(text: &str) -> Vec<String> {
    let escaped_len = text.len() + text.matches('\'').count();
    // One character less where a piece must end in the continuation mark.
    let limit = if escaped_len <= MAX_STR {
        MAX_STR
    } else {
        MAX_STR - 1
    };
    let mut pieces = vec![String::new()];
    for c in text.chars() {
        let width = if c == '\'' { 2 } else { 1 };
        if pieces.last().is_some_and(|p| p.len() + width > limit) {
            pieces.push(String::new());
        }
        if let Some(piece) = pieces.last_mut() {
            piece.push_str(if c == '\'' { "''" } else { "" });
            if c != '\'' {
                piece.push(c);
            }
        }
    }
    pieces
}

/// `value / comment`; no comment where no room is left for one.
fn with_comment(value: String, comment: &str) -> String {
    if comment.is_empty() || value.len() + 4 > CARD {
        return value;
    }
    format!("{value} / {comment}")
}

/// `text` cut or padded with spaces to a card.
fn card(text: &str) -> [u8; CARD] {
    let mut card = [b' '; CARD];
    for (to, from) in card.iter_mut().zip(text.bytes()) {
        *to = from;
    }
    card
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(cards: &[[u8; CARD]]) -> Vec<String> {
        cards
            .iter()
            .map(|c| String::from_utf8(c.to_vec()).unwrap().trim_end().to_owned())
            .collect()
    }

    #[test]
    fn values_stand_in_the_fixed_format() {
        let line = |value: Value| lines(&Keyword::new("KEY", value, "why").cards()).remove(0);
        assert_eq!(line(Value::Int(-5)), "KEY     =                   -5 / why");
        assert_eq!(line(true.into()), "KEY     =                    T / why");
        assert_eq!(line(1e-7.into()), "KEY     =               1.0E-7 / why");
        assert_eq!(line("it's".into()), "KEY     = 'it''s   '           / why");
        assert_eq!(
            line(u64::MAX.into()),
            "KEY     = 18446744073709551615 / why"
        );
        assert_eq!(line(1.28e9.into()), "KEY     =         1280000000.0 / why");
    }

    #[test]
    fn a_long_string_continues_and_no_doubled_quote_is_torn() {
        let text = "a'".repeat(100);
        let all = lines(&Keyword::new("LONG", text.as_str(), "").cards());
        assert!(all.iter().all(|l| l.len() <= CARD) && all.len() > 3);
        let mut back = String::new();
        for line in &all {
            let value = line[11..].trim_end().strip_suffix('\'').unwrap();
            back.push_str(&value.strip_suffix('&').unwrap_or(value).replace("''", "'"));
        }
        assert_eq!(back, text);
    }

    #[test]
    fn text_is_broken_at_spaces_and_nothing_is_lost() {
        let text = "word ".repeat(40);
        let all = lines(&text_cards("HISTORY", text.trim_end()));
        assert!(all.len() == 3 && all.iter().all(|l| l.starts_with("HISTORY word")));
        let solid = "x".repeat(150);
        assert_eq!(text_cards("COMMENT", &solid).len(), 3);
        assert_eq!(text_cards("COMMENT", "").len(), 1);
    }

    #[test]
    fn characters_outside_ascii_are_replaced() {
        assert_eq!(to_ascii("3 µJy\nα"), "3 uJy ?");
    }

    #[test]
    fn a_bad_keyword_or_number_is_named() {
        assert!(
            Keyword::new("lower", 1.0, "")
                .fault()
                .unwrap()
                .contains("lower")
        );
        assert!(Keyword::new("TOOLONGKEY", 1.0, "").fault().is_some());
        assert!(Keyword::new("X", f64::NAN, "").fault().is_some());
        assert!(Keyword::new("MJD-OBS", 1.0, "").fault().is_none());
    }
}
