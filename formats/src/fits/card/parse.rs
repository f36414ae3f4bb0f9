//! One 80-byte header card, read (Standard, sections 4.1 and 4.2).

use super::Value;
use crate::fits::CARD_BYTES;

/// The keyword of a card: columns 1 to 8 without trailing blanks.
pub(in crate::fits) fn keyword(card: &[u8; CARD_BYTES]) -> String {
    printable(&card[..8])
}

/// The free text of a commentary card (HISTORY, COMMENT): columns 9 to 80.
pub(in crate::fits) fn commentary(card: &[u8; CARD_BYTES]) -> String {
    printable(&card[8..])
}

/// The value of a card; `None` where columns 9 and 10 are not the value indicator `= `.
pub(in crate::fits) fn value(card: &[u8; CARD_BYTES]) -> Option<Value> {
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

/// The rest of a string on a `CONTINUE` card; `None` where there is none.
pub(in crate::fits) fn continuation(card: &[u8; CARD_BYTES]) -> Option<String> {
    let rest = printable(&card[8..]);
    match text(rest.trim_start().strip_prefix('\'')?) {
        Value::Text(text) => Some(text),
        _ => None,
    }
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
    if let Ok(integer) = token.parse::<i128>() {
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
pub(in crate::fits) fn printable(bytes: &[u8]) -> String {
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
}
