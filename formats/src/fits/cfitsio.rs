//! CFITSIO on a block of memory: the one place with foreign calls.
//!
//! CFITSIO is given memory and never a path: no extended file-name syntax (`file.fits[1]`) can be
//! triggered by a user's file name, no file is shared between its handles, and it sees only what
//! [`super::scan`] has checked. Blocks are of fixed size, without a reallocation function.
//!
//! Columns are written through the `fitsio` crate. Reading goes to the C functions: `fitsio` knows no
//! missing integers and takes strings for UTF-8.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_ulong, c_void};
use std::ptr;

use fitsio::tables::WritesCol;
use fitsio::{FileOpenMode, FitsFile};
use fitsio_sys::{ffcmsg, ffesum, ffflus, ffgcks, ffgcvd, ffgcvs, ffgerr, ffmahd, ffmkys, ffomem};

/// CFITSIO said no; the text is its own.
#[derive(Debug)]
pub(super) struct CfitsioError(pub(super) String);

type Result<T> = std::result::Result<T, CfitsioError>;

impl From<fitsio::errors::Error> for CfitsioError {
    fn from(error: fitsio::errors::Error) -> Self {
        Self(error.to_string())
    }
}

/// A FITS file in memory.
pub(super) struct MemoryFits {
    /// Stands first: it is closed before its memory goes.
    fits: FitsFile,
    memory: Box<Memory>,
}

/// What CFITSIO keeps pointers to for as long as the file is open: must not move.
struct Memory {
    start: *mut c_void,
    size: usize,
    bytes: Vec<u8>,
}

impl MemoryFits {
    /// Opens a file held in `bytes` for reading, at its first extension.
    pub(super) fn read(bytes: Vec<u8>) -> Result<Self> {
        let mut open = Self::open(bytes, FileOpenMode::READONLY)?;
        open.go_to(1)?;
        Ok(open)
    }

    /// Opens a file held in `bytes`, complete but for cells and sums, to fill them in.
    pub(super) fn edit(bytes: Vec<u8>) -> Result<Self> {
        Self::open(bytes, FileOpenMode::READWRITE)
    }

    fn open(mut bytes: Vec<u8>, mode: FileOpenMode) -> Result<Self> {
        let mut memory = Box::new(Memory {
            start: bytes.as_mut_ptr().cast(),
            size: bytes.len(),
            bytes,
        });
        let mut handle = ptr::null_mut();
        let mut status = 0;
        // SAFETY: `memory` is boxed and lives in `Self` behind the handle, so the two addresses stay
        // valid until the file is closed; the name is a literal with its NUL.
        unsafe {
            ffcmsg();
            ffomem(
                &raw mut handle,
                c"memory".as_ptr(),
                c_int::from(mode == FileOpenMode::READWRITE),
                &raw mut memory.start,
                &raw mut memory.size,
                0,
                None,
                &raw mut status,
            );
        }
        check(status)?;
        // SAFETY: CFITSIO has just made the handle, and nobody else has it.
        let fits = unsafe { FitsFile::from_raw(handle, mode) }?;
        Ok(Self { fits, memory })
    }

    /// Makes HDU `hdu`, from 0, the current one.
    fn go_to(&mut self, hdu: usize) -> Result<()> {
        let (mut kind, mut status) = (0, 0);
        // SAFETY: the handle is open; `kind` outlives the call.
        unsafe {
            let handle = self.fits.as_raw();
            ffmahd(handle, hdu as c_int + 1, &raw mut kind, &raw mut status);
        }
        check(status)
    }

    /// Elements of a column from the first row on, converted to `f64`; `missing` stands for those
    /// that are `TNULLn`, where it is not 0.
    pub(super) fn read_numbers(
        &mut self,
        column: usize,
        count: usize,
        missing: f64,
    ) -> Result<Vec<f64>> {
        let mut values = vec![0.0; count];
        let (mut any_missing, mut status) = (0, 0);
        // SAFETY: the array has room for the `count` elements asked for. CFITSIO writes through
        // `any_missing` without looking whether it is null as soon as it meets a `TNULLn`.
        unsafe {
            ffgcvd(
                self.fits.as_raw(),
                column as c_int,
                1,
                1,
                count as i64,
                missing,
                values.as_mut_ptr(),
                &raw mut any_missing,
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
                self.fits.as_raw(),
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

    /// Fills a column of HDU `hdu` from its first row on.
    pub(super) fn write_column<T: WritesCol>(
        &mut self,
        hdu: usize,
        name: &str,
        values: &[T],
    ) -> Result<()> {
        if !values.is_empty() {
            let table = self.fits.hdu(hdu)?;
            table.write_col(&mut self.fits, name, values)?;
        }
        Ok(())
    }

    /// Fills in `DATASUM` and `CHECKSUM` of HDU `hdu`.
    ///
    /// Not by CFITSIO's `ffpcks`, which writes the date beside them.
    pub(super) fn write_sums(&mut self, hdu: usize) -> Result<()> {
        self.go_to(hdu)?;
        let (data_sum, _) = self.sums()?;
        self.set_text(c"DATASUM", &data_sum.to_string())?;
        let (_, whole_sum) = self.sums()?;
        let mut code = [0u8; 17];
        // SAFETY: ffesum writes 16 characters and a NUL.
        unsafe { ffesum(whole_sum, 1, code.as_mut_ptr().cast()) };
        self.set_text(c"CHECKSUM", &String::from_utf8_lossy(&code[..16]))
    }

    /// Sums of the current HDU's data and of all of it.
    fn sums(&mut self) -> Result<(c_ulong, c_ulong)> {
        let (mut data, mut whole, mut status) = (0, 0, 0);
        // SAFETY: the handle is open; the three results outlive the call.
        unsafe {
            ffgcks(
                self.fits.as_raw(),
                &raw mut data,
                &raw mut whole,
                &raw mut status,
            );
        }
        check(status)?;
        Ok((data, whole))
    }

    /// Changes the value of a keyword and keeps its comment.
    fn set_text(&mut self, key: &CStr, value: &str) -> Result<()> {
        let value = CString::new(value).map_err(|_| CfitsioError("NUL in a string".into()))?;
        let mut status = 0;
        // SAFETY: three strings with their NUL, alive during the call.
        unsafe {
            ffmkys(
                self.fits.as_raw(),
                key.as_ptr(),
                value.as_ptr(),
                c"&".as_ptr(),
                &raw mut status,
            );
        }
        check(status)
    }

    /// Closes the file and gives its bytes back.
    pub(super) fn into_bytes(mut self) -> Result<Vec<u8>> {
        let mut status = 0;
        // SAFETY: the handle is open.
        unsafe { ffflus(self.fits.as_raw(), &raw mut status) };
        check(status)?;
        drop(self.fits);
        Ok(self.memory.bytes)
    }
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
