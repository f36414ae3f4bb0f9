//! Numbers, texts and objects in a row, as casacore's class AipsIO writes them.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::RangeInclusive;

/// Stands before the outermost object.
pub(super) const MAGIC: u32 = 0xbebe_bebe;

/// Bytes of a whole file.
pub(super) fn length(file: &File) -> Result<u64, String> {
    let metadata = file.metadata().map_err(|error| error.to_string())?;
    Ok(metadata.len())
}

/// Bytes of a file from a place on; fewer at its end.
pub(super) fn read(mut file: &File, at: u64, n_byte: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let found = file.seek(SeekFrom::Start(at));
    let found = found.and_then(|_| file.take(n_byte).read_to_end(&mut bytes));
    found.map(|_| bytes).map_err(|error| error.to_string())
}

/// casacore takes what it does not know for what it knows.
pub(super) fn check_version(
    of: &str,
    version: u32,
    known: RangeInclusive<u32>,
) -> Result<(), String> {
    if known.contains(&version) {
        return Ok(());
    }
    Err(format!(
        "{of} is of layout {version}, those from {} to {} are known",
        known.start(),
        known.end()
    ))
}

/// What is left of some bytes. Errors are words for what is wrong with them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stream<'a> {
    rest: &'a [u8],
    /// Whether the most significant byte comes first.
    big: bool,
}

/// An object of which no more than the start has been read.
#[derive(Debug)]
pub(super) struct Object<'a> {
    pub(super) name: String,
    pub(super) version: u32,
    /// What comes after it.
    after: &'a [u8],
}

impl Object<'_> {
    /// Its layout, if it is one of those.
    pub(super) fn known(&self, known: RangeInclusive<u32>) -> Result<u32, String> {
        check_version(&self.name, self.version, known).map(|()| self.version)
    }
}

impl<'a> Stream<'a> {
    pub(super) fn new(rest: &'a [u8], big: bool) -> Self {
        Self { rest, big }
    }

    fn bytes(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = (self.rest.split_at_checked(n))
            .ok_or("what it announces is not there: it is truncated or damaged")?;
        self.rest = rest;
        Ok(taken)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Passes over bytes.
    pub(super) fn pass(&mut self, n: u64) -> Result<(), String> {
        self.bytes(usize::try_from(n).unwrap_or(usize::MAX))
            .map(drop)
    }

    /// What begins with its length, as a stream of its own.
    pub(super) fn part(&mut self) -> Result<Self, String> {
        let n = self.u32()? as usize;
        Ok(Self::new(self.bytes(n)?, self.big))
    }

    pub(super) fn byte(&mut self) -> Result<u8, String> {
        Ok(self.bytes(1)?[0])
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        let mut bytes = [0; 4];
        bytes.copy_from_slice(self.bytes(4)?);
        Ok(if self.big {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        })
    }

    pub(super) fn u64(&mut self) -> Result<u64, String> {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(self.bytes(8)?);
        Ok(if self.big {
            u64::from_be_bytes(bytes)
        } else {
            u64::from_le_bytes(bytes)
        })
    }

    /// A number that has grown to 64 bits in newer files.
    pub(super) fn grown(&mut self, is_wide: bool) -> Result<u64, String> {
        if is_wide {
            self.u64()
        } else {
            Ok(self.u32()?.into())
        }
    }

    pub(super) fn text(&mut self) -> Result<String, String> {
        let n = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.bytes(n)?).into_owned())
    }

    /// The start of the object that all others are in.
    pub(super) fn outermost(&mut self) -> Result<Object<'a>, String> {
        if self.u32()? != MAGIC {
            return Err("does not begin as a table's file does".into());
        }
        self.object()
    }

    /// The start of an object in another.
    pub(super) fn object(&mut self) -> Result<Object<'a>, String> {
        let start = self.rest;
        let n = self.u32()? as usize;
        let name = self.text()?;
        let version = self.u32()?;
        // Only an object that goes on beyond our bytes has nothing after it.
        let after = start.get(n..).unwrap_or_default();
        Ok(Object {
            name,
            version,
            after,
        })
    }

    /// Passes over the rest of an object.
    pub(super) fn leave(&mut self, object: &Object<'a>) {
        self.rest = object.after;
    }

    /// Passes over an object.
    pub(super) fn skip(&mut self) -> Result<(), String> {
        let object = self.object()?;
        self.leave(&object);
        Ok(())
    }

    /// An object that is a list of numbers, of 64 bits each or of 32.
    pub(super) fn list(&mut self, is_wide: bool) -> Result<Vec<u64>, String> {
        self.object()?;
        let n = self.u32()? as usize;
        self.numbers(n, is_wide)
    }

    /// Numbers of 64 bits each or of 32.
    pub(super) fn numbers(&mut self, n: usize, is_wide: bool) -> Result<Vec<u64>, String> {
        if n > self.rest.len() / 4 {
            return Err(format!(
                "announces a list of {n} numbers, which is not there"
            ));
        }
        (0..n).map(|_| self.grown(is_wide)).collect()
    }

    /// An object that is a shape, fastest axis first.
    pub(super) fn shape(&mut self) -> Result<Vec<i64>, String> {
        let before = self.rest;
        let is_wide = self.object()?.version > 1;
        self.rest = before;
        let signed = |len: u64| {
            if is_wide {
                len as i64
            } else {
                i64::from(len as i32)
            }
        };
        Ok(self.list(is_wide)?.into_iter().map(signed).collect())
    }
}

/// For tests: bytes as casacore would write them.
#[cfg(test)]
pub(super) mod made {
    /// An object with a name and what is in it.
    pub(in super::super) fn object(name: &str, inside: &[u8]) -> Vec<u8> {
        let mut bytes = text(name);
        bytes.extend([0, 0, 0, 2]);
        bytes.extend(inside);
        let n_byte = (bytes.len() + 4) as u32;
        [&n_byte.to_be_bytes()[..], &bytes].concat()
    }

    pub(in super::super) fn text(text: &str) -> Vec<u8> {
        [&(text.len() as u32).to_be_bytes()[..], text.as_bytes()].concat()
    }

    pub(in super::super) fn numbers(numbers: &[u32]) -> Vec<u8> {
        numbers
            .iter()
            .flat_map(|number| number.to_be_bytes())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: [u8; 6] = [0, 0, 0, 2, b'a', b'b'];

    #[test]
    fn what_is_not_there_is_told() {
        assert_eq!(Stream::new(&TEXT, true).text().unwrap(), "ab");
        assert!(Stream::new(&TEXT[..5], true).text().is_err());
        assert!(Stream::new(&TEXT, false).text().is_err());
        assert!(Stream::new(&TEXT, true).outermost().is_err());
    }

    #[test]
    fn a_shape_has_a_sign() {
        let mut bytes = vec![0, 0, 0, 25, 0, 0, 0, 1, b'S', 0, 0, 0, 1, 0, 0, 0, 2];
        bytes.extend([0xff; 4]);
        bytes.extend([0, 0, 0, 7]);
        assert_eq!(Stream::new(&bytes, true).shape().unwrap(), [-1, 7]);
        bytes.truncate(24);
        assert!(Stream::new(&bytes, true).shape().is_err());
    }
}
