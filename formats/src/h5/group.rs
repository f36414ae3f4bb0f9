//! Groups: what is in them, and where it leads.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use hdf5::LinkType;

use super::collections::{self, Place};
use super::dataset::{Dataset, ELSEWHERE};
use super::raw_file::RawFile;
use super::{COPY_AGAIN, is_locked, names, raw, unreadable};
use crate::ReadError;

/// How often a file that is locked is tried again, and after how long.
const MOST_TRIES: u32 = 20;
const WAIT: Duration = Duration::from_millis(50);

/// A group of a file that is open for reading.
#[derive(Debug)]
pub(crate) struct Group {
    path: PathBuf,
    /// From the root, without a slash in front; empty for the root.
    name: String,
    inner: hdf5::Group,
    /// Whether each member leads out of the file.
    members: BTreeMap<String, bool>,
}

impl Group {
    /// The root of a file.
    pub(crate) fn open(path: &Path) -> Result<Self, ReadError> {
        let file = open_when_free(path).map_err(|error| ReadError::Malformed {
            path: path.to_owned(),
            place: "file".into(),
            what: unreadable(&error),
        })?;
        let group = file
            .as_group()
            .map_err(|error| damaged(path, "file", &error))?;
        Self::look(path, String::new(), group)
    }

    fn look(path: &Path, name: String, group: hdf5::Group) -> Result<Self, ReadError> {
        let place = if name.is_empty() { "file" } else { &name };
        let object = raw::object(&group, ".").map_err(|error| damaged(path, place, &error))?;
        names::check(path, object.address).map_err(|what| ReadError::Malformed {
            path: path.to_owned(),
            place: place.to_owned(),
            what: format!("{what}; {COPY_AGAIN}"),
        })?;
        let members = group
            .iter_visit_default(BTreeMap::new(), |_, member, info, members| {
                let leads_out = info.link_type == LinkType::External;
                members.insert(member.to_owned(), leads_out);
                true
            })
            .map_err(|error| damaged(path, place, &error))?;
        Ok(Self {
            path: path.to_owned(),
            name,
            inner: group,
            members,
        })
    }

    /// Names of what is in the group, sorted.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.members.keys().map(String::as_str)
    }

    /// A group in this one; `None` where there is none of that name.
    pub(crate) fn group(&self, name: &str) -> Result<Option<Self>, ReadError> {
        if !self.in_file(name)? {
            return Ok(None);
        }
        if self.is_dataset(name) {
            return Err(self.malformed(name, "must be a group, is a dataset"));
        }
        let full = self.full(name);
        let group = (self.inner.group(name)).map_err(|error| damaged(&self.path, &full, &error))?;
        Self::look(&self.path, full, group).map(Some)
    }

    /// Whether there is a dataset of that name.
    pub(crate) fn is_dataset(&self, name: &str) -> bool {
        self.members.get(name) == Some(&false)
            && raw::object(&self.inner, name).is_ok_and(|object| object.is_dataset)
    }

    /// A dataset; `None` where there is none of that name, or one without a value.
    pub(crate) fn dataset(&self, name: &str) -> Result<Option<Dataset>, ReadError> {
        if !self.in_file(name)? {
            return Ok(None);
        }
        let full = self.full(name);
        let damaged = |error: hdf5::Error| damaged(&self.path, &full, &error);
        let object = raw::object(&self.inner, name).map_err(damaged)?;
        if object.is_group {
            return Err(self.malformed(name, "must be a dataset, is a group"));
        }
        // libhdf5 follows virtual ones as it opens them.
        let place = RawFile::open(&self.path)
            .and_then(|mut raw| collections::place(&mut raw, object.address))
            .map_err(|what| self.malformed(name, format!("{what}; {COPY_AGAIN}")))?;
        if matches!(place, Place::Virtual) {
            return Err(self.unsupported(name, ELSEWHERE));
        }
        let dataset = self.inner.dataset(name).map_err(damaged)?;
        Dataset::look(&self.path, full.clone(), dataset, place)
    }

    /// A dataset that must be there.
    pub(crate) fn need(&self, name: &str) -> Result<Dataset, ReadError> {
        self.dataset(name)?
            .ok_or_else(|| self.malformed(name, "is missing; the file may not have been finished"))
    }

    /// The file is at fault at `name`.
    pub(crate) fn malformed(&self, name: &str, what: impl Into<String>) -> ReadError {
        ReadError::Malformed {
            path: self.path.clone(),
            place: self.full(name),
            what: what.into(),
        }
    }

    /// We cannot read what stands at `name`.
    pub(crate) fn unsupported(&self, name: &str, what: impl Into<String>) -> ReadError {
        ReadError::Unsupported {
            path: self.path.clone(),
            place: self.full(name),
            what: what.into(),
        }
    }

    /// Whether there is a member of that name; one outside of the file is an error.
    fn in_file(&self, name: &str) -> Result<bool, ReadError> {
        match self.members.get(name) {
            None => Ok(false),
            Some(false) => Ok(true),
            Some(true) => {
                let what = "is a link to another file, which is not followed; copy the data into \
                            this file, with h5repack or h5copy";
                Err(self.unsupported(name, what))
            }
        }
    }

    fn full(&self, name: &str) -> String {
        match (self.name.is_empty(), name.is_empty()) {
            (true, true) => "file".to_owned(),
            (true, false) => name.to_owned(),
            (false, true) => self.name.clone(),
            (false, false) => format!("{}/{name}", self.name),
        }
    }
}

/// Opens a file; one that is locked, once it is free, unless that takes too long.
///
/// A process that was started while a file was open for writing holds its lock until it runs its own program.
fn open_when_free(path: &Path) -> Result<hdf5::File, hdf5::Error> {
    let mut n_try = 0;
    loop {
        // Chunks are asked for whole and once: a cache would only be one more copy of each.
        let opened = hdf5::File::with_options()
            .with_fapl(|access| access.chunk_cache(1, 0, 0.0))
            .open(path);
        match opened {
            Err(error) if n_try < MOST_TRIES && is_locked(&error) => {
                n_try += 1;
                std::thread::sleep(WAIT);
            }
            done => return done,
        }
    }
}

fn damaged(path: &Path, place: &str, error: &hdf5::Error) -> ReadError {
    ReadError::Malformed {
        path: path.to_owned(),
        place: place.to_owned(),
        what: unreadable(error),
    }
}
