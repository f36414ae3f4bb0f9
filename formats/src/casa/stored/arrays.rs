//! Arrays of any shape, in a file of their own beside that of the storage manager.
//!
//! A cell says where in the file an array is: the lengths of its axes, and then its values.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::stream::{Stream, length};
use super::types::MAX_AXES;

/// Bytes of the version, with which the file begins, and of every other number.
const NUMBER_BYTES: u64 = 4;

#[derive(Debug)]
pub(super) struct Arrays {
    file: File,
    big: bool,
    n_byte: u64,
    /// Bytes of what stands before the lengths: nothing, or how many cells have the array.
    before: u64,
}

impl Arrays {
    /// The arrays of the manager whose file it is; none where no file is.
    pub(super) fn open(manager: &Path, big: bool) -> Result<Option<Self>, String> {
        let mut path = manager.as_os_str().to_owned();
        path.push("i");
        let Ok(file) = File::open(path) else {
            return Ok(None);
        };
        let n_byte = length(&file)?;
        let mut arrays = Self {
            file,
            big,
            n_byte,
            before: 0,
        };
        if n_byte > 0 && arrays.number(0)? > 0 {
            arrays.before = NUMBER_BYTES;
        }
        Ok(Some(arrays))
    }

    /// Whether an array begins at a place; at 0 is none.
    pub(super) fn check(&self, place: u64) -> Result<(), String> {
        if place == 0 {
            return Ok(());
        }
        let shape = place.saturating_add(self.before);
        let n_axis = self.number(shape)?;
        if n_axis > MAX_AXES {
            return Err(format!("the array at byte {place} has {n_axis} axes"));
        }
        let end = shape + NUMBER_BYTES * (1 + u64::from(n_axis));
        if end > self.n_byte {
            return Err(self.nowhere(place));
        }
        Ok(())
    }

    fn number(&self, at: u64) -> Result<u32, String> {
        let mut bytes = [0; NUMBER_BYTES as usize];
        if at.saturating_add(NUMBER_BYTES) > self.n_byte {
            return Err(self.nowhere(at));
        }
        (self.file.read_exact_at(&mut bytes, at)).map_err(|error| error.to_string())?;
        Stream::new(&bytes, self.big).u32()
    }

    fn nowhere(&self, place: u64) -> String {
        format!(
            "an array is at byte {place} of its file, which has {}",
            self.n_byte
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::stream::made::numbers;
    use super::*;

    #[test]
    fn an_array_must_be_in_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let manager = folder.path().join("table.f5");
        assert!(Arrays::open(&manager, true).unwrap().is_none());
        // Version and length; then, from byte 16 on, the cells that have it, two axes and their lengths.
        let bytes = numbers(&[1, 0, 32, 0, 1, 2, 3, 4]);
        std::fs::write(folder.path().join("table.f5i"), &bytes).unwrap();
        let arrays = Arrays::open(&manager, true).unwrap().unwrap();
        assert_eq!((arrays.check(0), arrays.check(16)), (Ok(()), Ok(())));
        assert!(
            arrays
                .check(24)
                .unwrap_err()
                .contains("at byte 24 of its file, which has 32")
        );
        assert!(arrays.check(u64::MAX).is_err());
        // Where the version is 0, nothing is before the axes: there it would have one of them too few.
        let bytes = numbers(&[0, 0, 32, 0, 33, 2, 3, 4]);
        std::fs::write(folder.path().join("table.f5i"), &bytes).unwrap();
        let arrays = Arrays::open(&manager, true).unwrap().unwrap();
        assert!(arrays.check(16).unwrap_err().contains("has 33 axes"));
    }
}
