//! The axes of the visibilities: rows, channels, correlations.
//!
//! # Source
//! Memo, sections 3.1 (polarization_array) and 4 (shapes).

use crate::h5::{Dataset, Group, Kind};
use crate::{Corr, ReadError};

/// How long the axes are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Axes {
    pub(super) n_row: usize,
    pub(super) n_chan: usize,
    pub(super) n_corr: usize,
    /// Whether there is an axis of spectral windows, of length 1, behind the rows: files before
    /// version 1.0.
    pub(super) old: bool,
}

impl Axes {
    /// The shape of the visibilities, which the counts in the header must bear out.
    ///
    /// `Nbls`, `Ntimes` and `Nants_data` are not looked at: real files have them wrong.
    pub(super) fn read(header: &Group, visdata: &Dataset) -> Result<Self, ReadError> {
        let (n_row, n_spw, n_chan, n_corr, old) = match *visdata.shape.as_slice() {
            [n_row, n_chan, n_corr] => (n_row, 1, n_chan, n_corr, false),
            [n_row, n_spw, n_chan, n_corr] => (n_row, n_spw, n_chan, n_corr, true),
            _ => {
                let what = format!(
                    "has shape {:?}, must be (Nblts, Nfreqs, Npols)",
                    visdata.shape
                );
                return Err(visdata.malformed(what));
            }
        };
        if n_spw != 1 {
            let what = format!(
                "has an axis of {n_spw} spectral windows, which only the first files had; read and \
                 write it with pyuvdata"
            );
            return Err(visdata.unsupported(what));
        }
        if visdata.kind != Kind::Complex {
            return Err(visdata.wrong_kind("compounds of two numbers r and i"));
        }
        for (name, len) in [("Nblts", n_row), ("Nfreqs", n_chan), ("Npols", n_corr)] {
            let announced = header.need(name)?.count()?;
            if announced != len {
                let what = format!("is {announced}, but Data/visdata has {len}");
                return Err(header.malformed(name, what));
            }
            if len == 0 {
                return Err(header.malformed(name, "is 0: the file holds no visibilities"));
            }
        }
        Ok(Self {
            n_row,
            n_chan,
            n_corr,
            old,
        })
    }

    /// The shape of Data/visdata, Data/flags and Data/nsamples.
    pub(super) fn shape(&self) -> Vec<usize> {
        let mut shape = vec![self.n_row, self.n_chan, self.n_corr];
        if self.old {
            shape.insert(1, 1);
        }
        shape
    }

    /// The correlations by their codes, which are those of AIPS.
    pub(super) fn corrs(&self, header: &Group) -> Result<Vec<Corr>, ReadError> {
        let codes = header.need("polarization_array")?;
        codes.check_shape_is(&[self.n_corr])?;
        let corrs: Result<Vec<Corr>, ReadError> = codes
            .wholes()?
            .into_iter()
            .map(|code| {
                Corr::from_stokes_code(code as f64)
                    .ok_or_else(|| codes.unsupported(format!("{code} is no known correlation")))
            })
            .collect();
        let corrs = corrs?;
        let twice = (0..corrs.len()).find(|&i| corrs[..i].contains(&corrs[i]));
        match twice {
            Some(i) => Err(codes.malformed(format!("has {:?} twice", corrs[i]))),
            None => Ok(corrs),
        }
    }
}
