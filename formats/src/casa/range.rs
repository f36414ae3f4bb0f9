//! Many cells at once: our few lines of C++ over casacore's `getColumnRange`.
//!
//! `rubbl_casatables` reads a cell at a time, and every time makes an object for the column, which
//! takes far longer than the cell. This is a second handle of the same table, and the first to be opened:
//! there casacore may throw what it will.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, OsStr, c_char, c_int, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use super::cell::Value;
use super::lock;

const WORDS: usize = 512;
/// Longer than any path.
const PATH: usize = 8192;

unsafe extern "C" {
    fn vis2cat_table_open(path: *const c_char, error: *mut c_char, len: usize) -> *mut c_void;
    fn vis2cat_table_close(table: *mut c_void);
    fn vis2cat_table_named(
        table: *const c_void,
        name: *const c_char,
        path: *mut c_char,
        error: *mut c_char,
        len: usize,
    ) -> c_int;
    fn vis2cat_table_range(
        table: *const c_void,
        column: *const c_char,
        kind: c_int,
        row: u64,
        n_row: u64,
        axes: *const u64,
        n_axis: usize,
        out: *mut c_void,
        error: *mut c_char,
        len: usize,
    ) -> c_int;
}

/// A table whose columns are read.
pub(super) struct Ranges {
    table: *mut c_void,
}

// SAFETY: casacore keeps nothing by thread, and every call is made under the one lock.
unsafe impl Send for Ranges {}

/// What came of a read.
pub(super) enum Read {
    /// The values are there.
    Fine,
    /// Not all of the cells are of the type and shape wanted; nothing is wrong with the table.
    Irregular,
    /// casacore's words; it must not be called again.
    Failed(String),
}

impl Ranges {
    /// Opens a table; errors in casacore's words.
    pub(super) fn open(path: &Path) -> Result<Self, String> {
        let path = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|e| e.to_string())?;
        let mut error = [0; WORDS];
        let _alone = lock();
        // SAFETY: the path ends in a zero, and so will the error, within its length.
        let table = unsafe { vis2cat_table_open(path.as_ptr(), error.as_mut_ptr(), WORDS) };
        if table.is_null() {
            return Err(said(&error));
        }
        Ok(Self { table })
    }

    /// Where the table is that a keyword names; nothing if there is no such keyword.
    pub(super) fn named(&self, keyword: &CStr) -> Option<PathBuf> {
        let (mut path, mut error) = ([0; PATH], [0; PATH]);
        let _alone = lock();
        // SAFETY: the table is open; path and error have the length told, and will end in a zero.
        let code = unsafe {
            vis2cat_table_named(
                self.table,
                keyword.as_ptr(),
                path.as_mut_ptr(),
                error.as_mut_ptr(),
                PATH,
            )
        };
        // SAFETY: it was filled with zeros, and the last is never written to.
        let path = unsafe { CStr::from_ptr(path.as_ptr()) };
        (code == 0).then(|| PathBuf::from(OsStr::from_bytes(path.to_bytes())))
    }

    /// Fills `out` with the cells from `row` on, each of the shape `shape`, slowest axis first.
    pub(super) fn read<T: Value>(
        &mut self,
        column: &str,
        row: u64,
        shape: &[usize],
        out: &mut [T],
    ) -> Read {
        let per_row: usize = shape.iter().product();
        let Ok(column) = CString::new(column) else {
            return Read::Irregular;
        };
        if per_row == 0 || !out.len().is_multiple_of(per_row) {
            return Read::Irregular;
        }
        let axes: Vec<u64> = shape.iter().rev().map(|&len| len as u64).collect();
        let n_row = (out.len() / per_row) as u64;
        let mut error = [0; WORDS];
        let _alone = lock();
        // SAFETY: the table is open; `out` has room for `n_row` cells of `axes`, and casacore's type of
        // number `T::DATA_TYPE` is laid out as T; the C++ side writes only after it has compared the
        // column's type and every cell's shape with these.
        let code = unsafe {
            vis2cat_table_range(
                self.table,
                column.as_ptr(),
                T::DATA_TYPE as c_int,
                row,
                n_row,
                axes.as_ptr(),
                axes.len(),
                out.as_mut_ptr().cast(),
                error.as_mut_ptr(),
                WORDS,
            )
        };
        match code {
            0 => Read::Fine,
            1 => Read::Irregular,
            _ => Read::Failed(said(&error)),
        }
    }
}

impl Drop for Ranges {
    fn drop(&mut self) {
        let _alone = lock();
        // SAFETY: it was opened, and nobody uses it any more.
        unsafe { vis2cat_table_close(self.table) };
    }
}

/// What stands before the first zero, in one line.
fn said(error: &[c_char]) -> String {
    // SAFETY: it was filled with zeros, and the last is never written to.
    let text = unsafe { CStr::from_ptr(error.as_ptr()) };
    match text.to_string_lossy().replace('\n', " ") {
        text if text.trim().is_empty() => "casacore gives no reason".into(),
        text => text,
    }
}
