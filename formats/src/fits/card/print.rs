//! Header cards, written: 80 ASCII characters each (Standard, section 4).

use super::{Cards, Keyword, Value};
use crate::fits::{BLOCK_BYTES, CARD_BYTES};

/// Longest string that one card holds between its quotes.
const MAX_STR: usize = 68;
/// Longest text of a `COMMENT` or `HISTORY` card.
const MAX_TEXT: usize = 72;

type Card = [u8; CARD_BYTES];

impl Cards {
    /// The header: all cards, `END`, and blanks to the end of the block.
    pub(crate) fn header(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut announced = false;
        for keyword in &self.keywords {
            let cards = keyword.cards();
            if cards.len() > 1 && !announced {
                // No part of FITS 4.0, but checkers of older conventions ask for it.
                let note = Keyword::new("LONGSTRN", "OGIP 1.0", "strings may continue");
                bytes.extend(note.cards().concat());
                announced = true;
            }
            bytes.extend(cards.concat());
        }
        let comments = self.comments.iter().map(|text| ("COMMENT", text));
        let history = self.history.iter().map(|text| ("HISTORY", text));
        for (key, text) in comments.chain(history) {
            bytes.extend(text_cards(key, text).concat());
        }
        bytes.extend(card("END"));
        bytes.resize(bytes.len().next_multiple_of(BLOCK_BYTES), b' ');
        bytes
    }
}

impl Keyword {
    /// The keyword as one card, or several for a long string.
    fn cards(&self) -> Vec<Card> {
        let key = &self.key;
        let comment = to_ascii(&self.comment);
        let fixed = match &self.value {
            Value::Text(s) => return string_cards(key, &to_ascii(s), &comment),
            Value::Unreadable(text) => to_ascii(text),
            Value::Integer(i) => i.to_string(),
            Value::Real(x) => float(*x),
            Value::Logical(b) => (if *b { "T" } else { "F" }).to_owned(),
        };
        vec![card(&with_comment(
            format!("{key:<8}= {fixed:>20}"),
            &comment,
        ))]
    }
}

/// `COMMENT` or `HISTORY` cards with `text`, broken at spaces where that is possible.
fn text_cards(key: &str, text: &str) -> Vec<Card> {
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

/// `text` with every character outside printable ASCII replaced: µ by u, others by a question mark.
pub(in crate::fits) fn to_ascii(text: &str) -> String {
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
fn string_cards(key: &str, text: &str, comment: &str) -> Vec<Card> {
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
    if comment.is_empty() || value.len() + 4 > CARD_BYTES {
        return value;
    }
    format!("{value} / {comment}")
}

/// `text` cut or padded with spaces to a card.
fn card(text: &str) -> Card {
    let mut card = [b' '; CARD_BYTES];
    for (to, from) in card.iter_mut().zip(text.bytes()) {
        *to = from;
    }
    card
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fits::card::parse;

    fn lines(cards: &[Card]) -> Vec<String> {
        cards
            .iter()
            .map(|c| String::from_utf8(c.to_vec()).unwrap().trim_end().to_owned())
            .collect()
    }

    #[test]
    fn values_stand_in_the_fixed_format() {
        let line = |value: Value| lines(&Keyword::new("KEY", value, "why").cards()).remove(0);
        assert_eq!(
            line(Value::Integer(-5)),
            "KEY     =                   -5 / why"
        );
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
            let card = Keyword::new("KEY", number, "note").cards()[0];
            assert_eq!(parse::value(&card), Some(Value::Real(number)));
        }
    }

    #[test]
    fn a_long_string_continues_and_no_doubled_quote_is_torn() {
        let text = "a'".repeat(100);
        let all = lines(&Keyword::new("LONG", text.as_str(), "").cards());
        assert!(all.iter().all(|l| l.len() <= CARD_BYTES) && all.len() > 3);
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
}
