//! A header's keywords, and the size of the data behind it.

use std::io::{self, Read};

use super::super::{BLOCK, CARD};

/// The keywords of an HDU in order; values as text, strings without quotes.
#[derive(Debug, Clone, Default)]
pub(super) struct Header {
    cards: Vec<(String, String)>,
}

impl Header {
    /// Reads up to the block with `END`: the header and its bytes, or what is wrong with it.
    pub(super) fn read(file: &mut impl Read, left: u64) -> io::Result<Result<(Self, u64), String>> {
        let mut header = Self::default();
        let mut used = 0;
        let mut block = [0_u8; BLOCK];
        while left - used >= BLOCK as u64 {
            file.read_exact(&mut block)?;
            used += BLOCK as u64;
            for card in block.chunks_exact(CARD) {
                if card.starts_with(b"END     ") {
                    return Ok(Ok((header, used)));
                }
                header.push(card);
            }
            if !header.starts_hdu(true) && !header.starts_hdu(false) {
                break; // No header at all: do not read gigabytes of something else.
            }
        }
        if header.starts_hdu(true) || header.starts_hdu(false) {
            return Ok(Err("the file is cut: no END in this header".to_owned()));
        }
        Ok(Err("no FITS header here".to_owned()))
    }

    fn push(&mut self, card: &[u8]) {
        let (key, rest) = card.split_at(8);
        let key = String::from_utf8_lossy(key).trim_end().to_owned();
        if key == "CONTINUE" {
            if let Some((_, value)) = self.cards.last_mut()
                && value.ends_with('&')
            {
                value.pop();
                value.push_str(&value_text(rest));
            }
        } else if let Some(value) = rest.strip_prefix(b"= ") {
            self.cards.push((key, value_text(value)));
        }
    }

    /// The value of `key`.
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        let found = self.cards.iter().find(|(k, _)| k == key);
        found.map(|(_, value)| value.as_str())
    }

    /// The whole number under `key`; `Ok(None)` if there is none.
    pub(super) fn size(&self, key: &str) -> Result<Option<u64>, String> {
        let number = |text: &str| {
            text.parse::<u64>()
                .map_err(|_| format!("{key} = {text}: not a size"))
        };
        self.get(key).map(number).transpose()
    }

    /// Whether the first keyword is the one that a primary or an extension HDU must start with.
    pub(super) fn starts_hdu(&self, primary: bool) -> bool {
        let wanted = if primary { "SIMPLE" } else { "XTENSION" };
        self.cards.first().is_some_and(|(key, _)| key == wanted)
    }

    /// Bytes of the data unit with its padding (FITS 4.0 equations 1, 2 and 4).
    pub(super) fn data_size(&self) -> Result<u64, String> {
        let bits = self.get("BITPIX").unwrap_or_default();
        let bytes = match bits.trim_start_matches('-') {
            "8" => 1,
            "16" => 2,
            "32" => 4,
            "64" => 8,
            _ => {
                return Err(format!(
                    "BITPIX = {bits:?}: expected 8, 16, 32, 64, -32, -64"
                ));
            }
        };
        let axes = self.size("NAXIS")?.ok_or("no NAXIS")?;
        if axes == 0 {
            return Ok(0);
        }
        let axes = (1..=axes.min(999)).map(|i| {
            let key = format!("NAXIS{i}");
            self.size(&key)?.ok_or(format!("no {key}"))
        });
        let mut axes = axes.collect::<Result<Vec<u64>, String>>()?;
        if axes[0] == 0 && self.get("GROUPS") == Some("T") {
            axes[0] = 1; // Random groups.
        }
        let product = |sizes: &[u64]| sizes.iter().try_fold(1_u64, |all, &n| all.checked_mul(n));
        let parameters = self.size("PCOUNT")?.unwrap_or(0);
        let groups = self.size("GCOUNT")?.unwrap_or(1);
        product(&axes)
            .and_then(|n| n.checked_add(parameters))
            .and_then(|n| product(&[n, groups, bytes]))
            .and_then(|n| n.checked_next_multiple_of(BLOCK as u64))
            .filter(|&n| i64::try_from(n).is_ok())
            .ok_or_else(|| "the size of the data overflows".to_owned())
    }
}

/// The value in columns 11 to 80 of a card: a string's content, or the text before the comment.
fn value_text(field: &[u8]) -> String {
    let field = String::from_utf8_lossy(field);
    let field = field.trim_start();
    let Some(quoted) = field.strip_prefix('\'') else {
        let end = field.find('/').unwrap_or(field.len());
        return field[..end].trim_end().to_owned();
    };
    let mut text = String::new();
    let mut chars = quoted.chars().peekable();
    while let Some(c) = chars.next() {
        if c == '\'' && chars.next_if_eq(&'\'').is_none() {
            break;
        }
        text.push(c);
    }
    text.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(cards: &[&str]) -> Header {
        let mut header = Header::default();
        for card in cards {
            header.push(format!("{card:<80}").as_bytes());
        }
        header
    }

    #[test]
    fn values_are_found_with_quotes_comments_and_continuation() {
        let h = header(&[
            "SIMPLE  =                    T / conforms",
            "OBJECT  = 'it''s / here  '     / name",
            "LONG    = 'one &'",
            "CONTINUE  'two&'",
            "CONTINUE  ' three' / end",
            "HISTORY = not a value",
            "EMPTY   =                      / nothing",
        ]);
        assert_eq!(h.get("SIMPLE"), Some("T"));
        assert_eq!(h.get("OBJECT"), Some("it's / here"));
        assert_eq!(h.get("LONG"), Some("one two three"));
        assert_eq!(h.get("EMPTY"), Some(""));
        assert!(h.get("NOPE").is_none() && h.starts_hdu(true));
    }

    #[test]
    fn the_data_size_is_checked_arithmetic() {
        let size = |cards: &[&str]| header(cards).data_size();
        let table = [
            "BITPIX  = 8",
            "NAXIS   = 2",
            "NAXIS1  = 10",
            "NAXIS2  = 300",
        ];
        assert_eq!(size(&table), Ok(5760));
        let groups = [
            "BITPIX  = -32",
            "NAXIS   = 2",
            "NAXIS1  = 0",
            "NAXIS2  = 3",
            "GROUPS  = T",
            "PCOUNT  = 7",
            "GCOUNT  = 100",
        ];
        assert_eq!(size(&groups), Ok(5760));
        assert_eq!(size(&["BITPIX  = 8", "NAXIS   = 0"]), Ok(0));
        let huge = [
            "BITPIX  = 64",
            "NAXIS   = 2",
            "NAXIS1  = 4294967296",
            "NAXIS2  = 4294967296",
        ];
        assert!(size(&huge).is_err());
        assert!(size(&["BITPIX  = 7", "NAXIS   = 0"]).is_err());
        assert!(size(&["BITPIX  = 8", "NAXIS   = 1", "NAXIS1  = -1"]).is_err());
    }
}
