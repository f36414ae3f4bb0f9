//! CFITSIO on a block of memory: the one place with foreign calls.
//!
//! CFITSIO is given memory and never a path: no extended file-name syntax (`file.fits[1]`) can be
//! triggered by a user's file name, no file is shared between its handles, and it sees only what
//! [`super::scan`] has checked. Blocks are of fixed size, without a reallocation function.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

use fitsio_sys::{
    ffclos, ffcmsg, ffcrtb, ffflus, ffgcvd, ffgcvs, ffgerr, ffghadll, ffimem, ffmahd, ffomem,
    ffpcld, ffpcls, ffprec, fitsfile,
};

/// CFITSIO's `READONLY`, fitsio.h.
const READ_ONLY: c_int = 0;
/// CFITSIO's `BINARY_TBL`, fitsio.h.
const BINARY_TABLE: c_int = 2;

/// CFITSIO said no; the text is its own.
#[derive(Debug)]
pub(super) struct CfitsioError(pub(super) String);

type Result<T> = std::result::Result<T, CfitsioError>;

/// A FITS file in memory.
pub(super) struct MemoryFits {
    fits: *mut fitsfile,
    memory: Box<Memory>,
}

/// What CFITSIO keeps pointers to for as long as the file is open: must not move.
struct Memory {
    start: *mut c_void,
    size: usize,
    bytes: Vec<u8>,
}

impl Memory {
    fn new(mut bytes: Vec<u8>) -> Self {
        Self {
            start: bytes.as_mut_ptr().cast(),
            size: bytes.len(),
            bytes,
        }
    }
}

impl MemoryFits {
    /// Opens a file held in `bytes` for reading, at its first extension.
    pub(super) fn open(bytes: Vec<u8>) -> Result<Self> {
        let mut memory = Box::new(Memory::new(bytes));
        let mut fits = ptr::null_mut();
        let mut status = 0;
        // SAFETY: `memory` is boxed and lives in `Self` next to the handle, so the two addresses
        // stay valid until `drop` closes the file; the name is a literal with its NUL.
        unsafe {
            ffcmsg();
            ffomem(
                &raw mut fits,
                c"memory".as_ptr(),
                READ_ONLY,
                &raw mut memory.start,
                &raw mut memory.size,
                0,
                None,
                &raw mut status,
            );
        }
        check(status)?;
        let open = Self { fits, memory };
        let mut kind = 0;
        // SAFETY: the handle is open; `kind` outlives the call.
        unsafe { ffmahd(open.fits, 2, &raw mut kind, &raw mut status) };
        check(status)?;
        Ok(open)
    }

    /// Starts an empty file in a block of at most `max_bytes`.
    pub(super) fn create(max_bytes: usize) -> Result<Self> {
        let mut memory = Box::new(Memory::new(vec![0; max_bytes]));
        let mut fits = ptr::null_mut();
        let mut status = 0;
        // SAFETY: as in `open`; without a reallocation function CFITSIO stops at `size`.
        unsafe {
            ffcmsg();
            ffimem(
                &raw mut fits,
                &raw mut memory.start,
                &raw mut memory.size,
                0,
                None,
                &raw mut status,
            );
        }
        check(status)?;
        Ok(Self { fits, memory })
    }

    /// Elements of a column from the first row on, converted to `f64`.
    pub(super) fn read_numbers(&mut self, column: usize, count: usize) -> Result<Vec<f64>> {
        let mut values = vec![0.0; count];
        let mut status = 0;
        // SAFETY: the array has room for the `count` elements asked for; nulval 0 means that
        // undefined values come as NaN and `anynul` is not needed.
        unsafe {
            ffgcvd(
                self.fits,
                column as c_int,
                1,
                1,
                count as i64,
                0.0,
                values.as_mut_ptr(),
                ptr::null_mut(),
                &raw mut status,
            );
        }
        check(status)?;
        Ok(values)
    }

    /// The string in one cell, of at most `width` bytes.
    pub(super) fn read_text(&mut self, column: usize, row: usize, width: usize) -> Result<Vec<u8>> {
        // CFITSIO writes at most the column's width and a NUL; the rest is margin.
        let mut text = vec![0u8; width + 81];
        let mut cell: *mut c_char = text.as_mut_ptr().cast();
        let mut null = *b"\0\0";
        let mut status = 0;
        // SAFETY: one cell is asked for and its buffer is longer than the column is wide.
        unsafe {
            ffgcvs(
                self.fits,
                column as c_int,
                row as i64 + 1,
                1,
                1,
                null.as_mut_ptr().cast(),
                &raw mut cell,
                ptr::null_mut(),
                &raw mut status,
            );
        }
        check(status)?;
        let end = text.iter().position(|&b| b == 0).unwrap_or(text.len());
        text.truncate(end);
        Ok(text)
    }

    /// Appends a binary table; `columns` are (name, format, unit).
    pub(super) fn create_table(
        &mut self,
        name: &str,
        n_row: usize,
        columns: &[(&str, &str, &str)],
    ) -> Result<()> {
        let strings = |pick: fn(&(&str, &str, &str)) -> String| -> Result<Vec<CString>> {
            columns
                .iter()
                .map(|column| c_string(&pick(column)))
                .collect()
        };
        let names = strings(|c| c.0.to_owned())?;
        let forms = strings(|c| c.1.to_owned())?;
        let units = strings(|c| c.2.to_owned())?;
        let pointers = |s: &[CString]| s.iter().map(|s| s.as_ptr().cast_mut()).collect::<Vec<_>>();
        let (mut names_p, mut forms_p, mut units_p) =
            (pointers(&names), pointers(&forms), pointers(&units));
        let extname = c_string(name)?;
        let mut status = 0;
        // SAFETY: three arrays of `columns.len()` NUL-terminated strings that outlive the call;
        // CFITSIO only reads them.
        unsafe {
            ffcrtb(
                self.fits,
                BINARY_TABLE,
                n_row as i64,
                columns.len() as c_int,
                names_p.as_mut_ptr(),
                forms_p.as_mut_ptr(),
                units_p.as_mut_ptr(),
                extname.as_ptr(),
                &raw mut status,
            );
        }
        check(status)
    }

    /// Appends one header card, 80 bytes.
    pub(super) fn write_card(&mut self, card: &[u8]) -> Result<()> {
        let card = CString::new(card).map_err(|_| CfitsioError("NUL in a card".into()))?;
        let mut status = 0;
        // SAFETY: a NUL-terminated card that outlives the call.
        unsafe { ffprec(self.fits, card.as_ptr(), &raw mut status) };
        check(status)
    }

    /// Fills a column with numbers from its first row on.
    pub(super) fn write_numbers(&mut self, column: usize, values: &[f64]) -> Result<()> {
        let mut values = values.to_vec();
        let mut status = 0;
        // SAFETY: the array holds the `len` elements that are announced.
        unsafe {
            ffpcld(
                self.fits,
                column as c_int,
                1,
                1,
                values.len() as i64,
                values.as_mut_ptr(),
                &raw mut status,
            );
        }
        check(status)
    }

    /// Fills a column with strings, one a row.
    pub(super) fn write_texts(&mut self, column: usize, texts: &[String]) -> Result<()> {
        let strings = texts
            .iter()
            .map(|t| c_string(t))
            .collect::<Result<Vec<_>>>()?;
        let mut pointers: Vec<_> = strings.iter().map(|s| s.as_ptr().cast_mut()).collect();
        let mut status = 0;
        // SAFETY: as many NUL-terminated strings as announced, alive during the call.
        unsafe {
            ffpcls(
                self.fits,
                column as c_int,
                1,
                1,
                pointers.len() as i64,
                pointers.as_mut_ptr(),
                &raw mut status,
            );
        }
        check(status)
    }

    /// The bytes of the current HDU, padded to whole blocks.
    pub(super) fn current_hdu(&mut self) -> Result<Vec<u8>> {
        let (mut head, mut data, mut end) = (0, 0, 0);
        let mut status = 0;
        // SAFETY: the handle is open; the three results outlive the calls.
        unsafe {
            ffflus(self.fits, &raw mut status);
            ffghadll(
                self.fits,
                &raw mut head,
                &raw mut data,
                &raw mut end,
                &raw mut status,
            );
        }
        check(status)?;
        // SAFETY: CFITSIO keeps no buffered bytes after the flush, and wrote `memory.bytes`
        // through the pointer it was given; the block was neither moved nor freed.
        let block = unsafe {
            std::slice::from_raw_parts(self.memory.start.cast::<u8>(), self.memory.bytes.len())
        };
        block
            .get(head as usize..end as usize)
            .map(<[u8]>::to_vec)
            .ok_or_else(|| CfitsioError("the table outgrew its block of memory".into()))
    }
}

impl Drop for MemoryFits {
    fn drop(&mut self) {
        let mut status = 0;
        // SAFETY: the handle is open and is never used again; the memory stays ours.
        unsafe { ffclos(self.fits, &raw mut status) };
    }
}

fn c_string(text: &str) -> Result<CString> {
    CString::new(text).map_err(|_| CfitsioError("NUL in a string".into()))
}

/// CFITSIO's status as a result with its text.
fn check(status: c_int) -> Result<()> {
    if status <= 0 {
        return Ok(());
    }
    let mut text = [0 as c_char; 31];
    // SAFETY: ffgerr writes at most 30 characters and a NUL.
    let text = unsafe {
        ffgerr(status, text.as_mut_ptr());
        CStr::from_ptr(text.as_ptr())
    };
    Err(CfitsioError(format!(
        "{} (CFITSIO status {status})",
        text.to_string_lossy()
    )))
}
