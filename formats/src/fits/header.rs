//! The cards of one header, looked up by keyword.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::card::Value;
use crate::ReadError;

/// Where in a file we are, for error messages.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    /// File.
    pub(crate) path: PathBuf,
    /// HDU in words: `primary HDU`, `HDU 2 (AIPS AN)`.
    pub(crate) hdu: String,
}

impl Place {
    /// The file as a whole.
    pub(crate) fn file(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            hdu: "file".into(),
        }
    }

    /// The file is at fault at `at` (keyword, column or group).
    pub(crate) fn malformed(&self, at: &str, what: impl Into<String>) -> ReadError {
        ReadError::Malformed {
            path: self.path.clone(),
            place: self.name(at),
            what: what.into(),
        }
    }

    /// We cannot read what stands at `at`.
    pub(crate) fn unsupported(&self, at: &str, what: impl Into<String>) -> ReadError {
        ReadError::Unsupported {
            path: self.path.clone(),
            place: self.name(at),
            what: what.into(),
        }
    }

    /// The operating system refused.
    pub(crate) fn io(&self, source: std::io::Error) -> ReadError {
        ReadError::Io {
            path: self.path.clone(),
            source,
        }
    }

    fn name(&self, at: &str) -> String {
        if at.is_empty() {
            self.hdu.clone()
        } else {
            format!("{}: {at}", self.hdu)
        }
    }
}

/// One header.
#[derive(Debug, Clone)]
pub(crate) struct Header {
    /// For messages.
    pub(crate) place: Place,
    /// HISTORY cards, in order.
    pub(crate) history: Vec<String>,
    values: HashMap<String, Value>,
    /// Keywords that came twice with different values.
    doubled: Vec<String>,
}

impl Header {
    /// No cards yet.
    pub(crate) fn new(place: Place) -> Self {
        Self {
            place,
            history: Vec::new(),
            values: HashMap::new(),
            doubled: Vec::new(),
        }
    }

    /// Takes one card's value; the first one stands.
    pub(crate) fn insert(&mut self, key: String, value: Value) {
        match self.values.get(&key) {
            None => {
                self.values.insert(key, value);
            }
            Some(first) if *first != value => self.doubled.push(key),
            Some(_) => {}
        }
    }

    /// Appends to the string under `key`, where that ends in the mark of continuation.
    pub(crate) fn extend(&mut self, key: &str, more: &str) {
        if let Some(Value::Text(text)) = self.values.get_mut(key)
            && text.ends_with('&')
        {
            text.pop();
            text.push_str(more);
        }
    }

    /// The value of a keyword, of whatever kind.
    pub(crate) fn value(&self, key: &str) -> Option<&Value> {
        self.values.get(key)
    }

    /// Refuses a keyword that came twice with different values: two readers would disagree.
    pub(crate) fn once(&self, key: &str) -> Result<(), ReadError> {
        if self.doubled.iter().any(|k| k == key) {
            return Err(self
                .place
                .malformed(key, "stands twice with different values"));
        }
        Ok(())
    }

    /// A string; `None` where it is missing, blank or no string.
    pub(crate) fn text(&self, key: &str) -> Option<&str> {
        match self.values.get(key) {
            Some(Value::Text(text)) if !text.trim().is_empty() => Some(text.trim()),
            _ => None,
        }
    }

    /// A logical, false where it is missing.
    pub(crate) fn logical(&self, key: &str) -> bool {
        self.values.get(key) == Some(&Value::Logical(true))
    }

    /// A number; `None` where it is missing.
    pub(crate) fn real(&self, key: &str) -> Result<Option<f64>, ReadError> {
        match self.values.get(key) {
            None => Ok(None),
            Some(Value::Integer(i)) => Ok(Some(*i as f64)),
            Some(Value::Real(r)) => Ok(Some(*r)),
            Some(other) => Err(self.not_a("number", key, other)),
        }
    }

    /// A number that must be there.
    pub(crate) fn need_real(&self, key: &str) -> Result<f64, ReadError> {
        self.real(key)?.ok_or_else(|| self.missing(key))
    }

    /// An integer; `None` where it is missing.
    pub(crate) fn integer(&self, key: &str) -> Result<Option<i64>, ReadError> {
        match self.values.get(key) {
            None => Ok(None),
            Some(Value::Integer(i)) if i64::try_from(*i).is_ok() => Ok(Some(*i as i64)),
            Some(other) => Err(self.not_a("whole number", key, other)),
        }
    }

    /// An integer of zero or more that must be there.
    pub(crate) fn need_count(&self, key: &str) -> Result<u64, ReadError> {
        let value = self.integer(key)?.ok_or_else(|| self.missing(key))?;
        u64::try_from(value).map_err(|_| {
            self.place
                .malformed(key, format!("is {value}, must not be negative"))
        })
    }

    fn missing(&self, key: &str) -> ReadError {
        self.place.malformed(key, "keyword is missing")
    }

    fn not_a(&self, kind: &str, key: &str, found: &Value) -> ReadError {
        let found = match found {
            Value::Integer(i) => i.to_string(),
            Value::Real(r) => r.to_string(),
            Value::Logical(l) => if *l { "T" } else { "F" }.to_owned(),
            Value::Text(text) | Value::Unreadable(text) => format!("'{text}'"),
        };
        self.place
            .malformed(key, format!("must be a {kind}, found {found}"))
    }
}
