//! What this package needs of casacore tables, with no radio meaning.
//!
//! A table is a directory: `table.dat` says what columns there are, and storage managers keep their
//! cells in `table.f*` beside it. All of that is casacore's (3.5, bundled by `rubbl_casatables`); what
//! goes wrong there comes back as an error that names table, column and row.
//!
//! casacore is not made for threads, not even for two tables of two readers: every call to it is made
//! under one lock for the whole process.
//!
//! # Limits
//! A cell is looked at (type, shape) before anything of its size is allocated, and so are the headers of
//! the usual storage managers (`stored`). But casacore parses table.dat, the buckets of incremental
//! storage managers and the texts of standard ones, and it trusts them: a table made for it can crash us.
//! So can a disk that fills up while a table is written: casacore throws where it closes,
//! which ends the process. Nothing has its final name then; the hidden directory is left.
//!
//! # Source
//! van Diepen, "Casacore Table Data System" (casacore note 255); casacore's manual of the module
//! Tables.

mod cell;
mod create;
mod range;
mod stored;
mod table;

pub(crate) use cell::Value;
pub(crate) use create::{Column, Kind, NewTable};
pub(crate) use table::{Reference, Table};

use std::sync::{Mutex, MutexGuard, PoisonError};

use rubbl_casatables::TableError;

static CASACORE: Mutex<()> = Mutex::new(());

/// Nobody else calls casacore as long as this is held.
fn lock() -> MutexGuard<'static, ()> {
    CASACORE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How casacore says that a cell was never filled, which does no harm.
const EMPTY_CELL: &str = "no array in row";

/// A table of casacore's, which may go from thread to thread.
struct Handle {
    table: Option<rubbl_casatables::Table>,
    /// Why nothing more can be asked of it: casacore does not survive a second try at a storage
    /// manager that it could not make sense of.
    broken: Option<String>,
}

// SAFETY: casacore keeps nothing by thread, and every call is made under `CASACORE`.
#[allow(unsafe_code)]
unsafe impl Send for Handle {}

impl Handle {
    fn new(table: rubbl_casatables::Table) -> Self {
        Self {
            table: Some(table),
            broken: None,
        }
    }

    /// Calls casacore; after it has failed it is not called again.
    fn with<T>(
        &mut self,
        call: impl FnOnce(&mut rubbl_casatables::Table) -> Result<T, TableError>,
    ) -> Result<T, String> {
        if let Some(why) = &self.broken {
            return Err(why.clone());
        }
        let Some(table) = &mut self.table else {
            return Err("the table is closed".into());
        };
        let _alone = lock();
        call(table).map_err(|error| {
            let what = words(&error);
            if matches!(error, TableError::Casacore(_)) && !what.contains(EMPTY_CELL) {
                self.broken = Some(what.clone());
            }
            what
        })
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        let _alone = lock();
        self.table = None;
    }
}

/// casacore's words, in one line; it has none for some errors.
fn words(error: &TableError) -> String {
    match error.to_string().replace('\n', " ") {
        text if text.trim().is_empty() => "casacore gives no reason".into(),
        text => text,
    }
}
