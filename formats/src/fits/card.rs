//! Header cards (Standard, section 4): what they say.

pub(super) mod parse;
pub(super) mod print;

/// Value of a keyword.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A string, without trailing blanks; longer than one card continues on `CONTINUE` cards.
    Text(String),
    /// A whole number.
    Integer(i128),
    /// Any other finite number.
    Real(f64),
    /// `T` or `F`.
    Logical(bool),
    /// Read, but nothing that the standard knows; cannot be written.
    Unreadable(String),
}

/// Conversions into one kind of [`Value`].
macro_rules! value_from {
    ($($from:ty => $kind:ident),*) => {$(
        impl From<$from> for Value {
            fn from(value: $from) -> Self {
                Self::$kind(value.into())
            }
        }
    )*};
}
value_from!(&str => Text, String => Text, f64 => Real, bool => Logical,
            i32 => Integer, i64 => Integer, u64 => Integer);

impl From<usize> for Value {
    fn from(value: usize) -> Self {
        Self::Integer(value as i128)
    }
}

/// A keyword with value and comment.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyword {
    /// Up to 8 of `A-Z 0-9 - _`.
    pub key: String,
    /// The value.
    pub value: Value,
    /// What it means, with its unit in brackets in front where it has one; cut at the end of the card.
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
        match &self.value {
            Value::Real(x) if !x.is_finite() => Some(format!("keyword {key} is {x}: not finite")),
            Value::Unreadable(text) => Some(format!("keyword {key} is {text}: no FITS value")),
            _ => None,
        }
    }
}

/// A header to be written: keywords, then comments, then history.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cards {
    /// Keywords in the order they are written.
    pub keywords: Vec<Keyword>,
    /// `COMMENT` lines; long ones are split.
    pub comments: Vec<String>,
    /// `HISTORY` lines; long ones are split.
    pub history: Vec<String>,
}

impl Cards {
    /// Appends a keyword.
    pub fn push(&mut self, key: &str, value: impl Into<Value>, comment: &str) {
        self.keywords.push(Keyword::new(key, value, comment));
    }

    /// Why these cannot be a header, if they cannot.
    pub(super) fn fault(&self) -> Option<String> {
        self.keywords.iter().find_map(Keyword::fault)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_keyword_or_number_is_named() {
        let fault = |key: &str, value: f64| Keyword::new(key, value, "").fault();
        assert!(fault("lower", 1.0).unwrap().contains("lower"));
        assert!(fault("TOOLONGKEY", 1.0).is_some());
        assert!(fault("X", f64::NAN).is_some());
        assert!(fault("MJD-OBS", 1.0).is_none());
    }
}
