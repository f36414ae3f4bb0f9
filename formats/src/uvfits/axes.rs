//! The regular axes of a group.
//!
//! # Source
//! Memo, section 3.1.3: COMPLEX, STOKES, FREQ, IF, RA, DEC; known by CTYPE, not by place.

use crate::fits::header::Header;
use crate::{Corr, ReadError};

/// One axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    /// Number in the header (the n of NAXISn); 0 where the file has none.
    pub(super) number: usize,
    /// Elements.
    pub(super) len: usize,
    /// Values from one element to the next.
    pub(super) stride: usize,
}

/// The axes by meaning; those that the file does not have are of length 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axes {
    pub(super) complex: Axis,
    pub(super) stokes: Axis,
    pub(super) freq: Axis,
    pub(super) n_if: Axis,
    pub(super) ra: Axis,
    pub(super) dec: Axis,
    /// Values in a group, parameters apart.
    pub(super) n_value: usize,
}

impl Axes {
    /// Reads the axes after the empty NAXIS1.
    pub(super) fn read(header: &Header, lens: &[u64]) -> Result<Self, ReadError> {
        let none = Axis {
            number: 0,
            len: 1,
            stride: 0,
        };
        let mut axes = Self {
            complex: none,
            stokes: none,
            freq: none,
            n_if: none,
            ra: none,
            dec: none,
            n_value: 1,
        };
        for (number, &len) in lens.iter().enumerate().map(|(i, len)| (i + 2, len)) {
            if len == 0 {
                let what = "is 0: the groups hold no visibilities";
                return Err(header.place.malformed(&format!("NAXIS{number}"), what));
            }
            let axis = Axis {
                number,
                len: len as usize,
                stride: axes.n_value,
            };
            axes.n_value *= len as usize;
            axes.place(header, axis)?;
        }
        axes.check(header)?;
        Ok(axes)
    }

    /// Puts an axis where its CTYPE says.
    fn place(&mut self, header: &Header, axis: Axis) -> Result<(), ReadError> {
        let key = format!("CTYPE{}", axis.number);
        let name = header.text(&key).unwrap_or("").to_uppercase();
        let slot = match name.as_str() {
            "COMPLEX" => &mut self.complex,
            "STOKES" => &mut self.stokes,
            "FREQ" => &mut self.freq,
            "IF" => &mut self.n_if,
            _ if name.starts_with("RA") => &mut self.ra,
            _ if name.starts_with("DEC") => &mut self.dec,
            _ if axis.len == 1 => return Ok(()),
            _ => {
                let what = format!("axis '{name}' of length {} is not known", axis.len);
                return Err(header.place.unsupported(&key, what));
            }
        };
        if slot.number != 0 {
            return Err(header
                .place
                .malformed(&key, format!("there is a second axis '{name}'")));
        }
        *slot = axis;
        Ok(())
    }

    fn check(&self, header: &Header) -> Result<(), ReadError> {
        let place = &header.place;
        if self.complex.number == 0 {
            return Err(place.malformed("CTYPE", "there is no COMPLEX axis: no visibilities"));
        }
        if !(2..=3).contains(&self.complex.len) {
            let key = format!("NAXIS{}", self.complex.number);
            let what = format!(
                "the COMPLEX axis has length {}, must be 2 or 3",
                self.complex.len
            );
            return Err(place.malformed(&key, what));
        }
        if self.freq.number == 0 {
            return Err(place.malformed("CTYPE", "there is no FREQ axis"));
        }
        for axis in [self.ra, self.dec] {
            if axis.len != 1 {
                let key = format!("NAXIS{}", axis.number);
                return Err(place.unsupported(&key, "several sky positions in one group"));
            }
        }
        Ok(())
    }

    /// The correlations along STOKES; Stokes I where there is no such axis.
    pub(super) fn corrs(&self, header: &Header) -> Result<Vec<Corr>, ReadError> {
        let number = self.stokes.number;
        if number == 0 {
            return Ok(vec![Corr::I]);
        }
        let first = header.need_real(&format!("CRVAL{number}"))?;
        let pixel = header.real(&format!("CRPIX{number}"))?.unwrap_or(1.0);
        let step = header.real(&format!("CDELT{number}"))?.unwrap_or(1.0);
        (0..self.stokes.len)
            .map(|i| {
                let code = first + (i as f64 + 1.0 - pixel) * step;
                Corr::from_stokes_code(code).ok_or_else(|| {
                    let what = format!(
                        "value {} of the STOKES axis is {code}, no known code",
                        i + 1
                    );
                    header.place.unsupported(&format!("CRVAL{number}"), what)
                })
            })
            .collect()
    }
}

/// Codes of the STOKES axis; memo, table 4.
const STOKES_CODES: [(Corr, i8); 12] = [
    (Corr::I, 1),
    (Corr::Q, 2),
    (Corr::U, 3),
    (Corr::V, 4),
    (Corr::Rr, -1),
    (Corr::Ll, -2),
    (Corr::Rl, -3),
    (Corr::Lr, -4),
    (Corr::Xx, -5),
    (Corr::Yy, -6),
    (Corr::Xy, -7),
    (Corr::Yx, -8),
];

impl Corr {
    /// The correlation of a code on the STOKES axis of a FITS file.
    pub(crate) fn from_stokes_code(code: f64) -> Option<Self> {
        STOKES_CODES
            .iter()
            .find(|(_, c)| (f64::from(*c) - code).abs() < 1e-6)
            .map(|(corr, _)| *corr)
    }

    /// The code on the STOKES axis of a FITS file.
    pub(crate) fn stokes_code(self) -> i8 {
        STOKES_CODES
            .iter()
            .find(|(corr, _)| *corr == self)
            .map_or(0, |(_, code)| *code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stokes_codes_go_there_and_back() {
        for (corr, code) in STOKES_CODES {
            assert_eq!(corr.stokes_code(), code);
            assert_eq!(Corr::from_stokes_code(code.into()), Some(corr));
        }
        assert_eq!(Corr::from_stokes_code(0.0), None);
        assert_eq!(Corr::from_stokes_code(-5.5), None);
        assert_eq!(Corr::from_stokes_code(f64::NAN), None);
    }
}
