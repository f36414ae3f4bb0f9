//! The random parameters: what PTYPEn, PSCALn and PZEROn say.
//!
//! # Source
//! FITS Standard 4.0, section 6.1.2 (repeated names are summed); memo, section 3.1.2.

use super::C_M_S;
use crate::ReadError;
use crate::date::{CarefulSum, MJD_ZERO_JD};
use crate::fits::header::Header;

/// Most parameters that the standard's three digits allow.
const MAX_PARAMETERS: u64 = 999;

/// One parameter of the file.
#[derive(Debug, Clone, Copy)]
struct Term {
    /// Its place in the group.
    at: usize,
    scale: f64,
    zero: f64,
}

/// A quantity: the sum of all parameters of its name.
#[derive(Debug, Clone, Default)]
pub(super) struct Quantity(Vec<Term>);

impl Quantity {
    /// Whether the file has it.
    pub(super) fn is_there(&self) -> bool {
        !self.0.is_empty()
    }

    /// Its value in a group whose raw parameter `at` is `raw(at)`.
    pub(super) fn value(&self, raw: impl Fn(usize) -> f64) -> f64 {
        self.0
            .iter()
            .map(|term| term.zero + term.scale * raw(term.at))
            .sum()
    }

    /// Its value as a Julian date, turned into a modified one without losing digits.
    pub(super) fn mjd(&self, raw: impl Fn(usize) -> f64) -> f64 {
        let mut sum = CarefulSum::default();
        sum.add(-MJD_ZERO_JD);
        for term in &self.0 {
            sum.add(term.zero);
            sum.add(term.scale * raw(term.at));
        }
        sum.total()
    }
}

/// What the axes of u, v, w are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Projection {
    /// w points at the phase centre.
    Sin,
    /// w points at the north celestial pole (east-west arrays).
    Ncp,
}

/// All quantities that we know, and the unit of u, v, w.
#[derive(Debug, Clone)]
pub(super) struct Parameters {
    /// Parameters in a group.
    pub(super) n_param: usize,
    pub(super) uvw: [Quantity; 3],
    /// From the file's unit to metres.
    pub(super) uvw_to_m: f64,
    pub(super) projection: Projection,
    pub(super) date: Quantity,
    pub(super) baseline: Quantity,
    pub(super) ant1: Quantity,
    pub(super) ant2: Quantity,
    pub(super) subarray: Quantity,
    pub(super) source: Quantity,
    pub(super) freq_sel: Quantity,
    pub(super) int_time: Quantity,
}

impl Parameters {
    /// Reads PTYPEn, PSCALn, PZEROn of the primary header.
    pub(super) fn read(header: &Header, ref_hz: f64) -> Result<Self, ReadError> {
        let n_param = header.need_count("PCOUNT")?;
        if n_param > MAX_PARAMETERS {
            let what = format!("is {n_param}, at most {MAX_PARAMETERS} can be named");
            return Err(header.place.malformed("PCOUNT", what));
        }
        let mut named = Vec::new();
        for at in 0..n_param as usize {
            let number = at + 1;
            let name = header
                .text(&format!("PTYPE{number}"))
                .unwrap_or("")
                .to_uppercase();
            let term = Term {
                at,
                scale: header.real(&format!("PSCAL{number}"))?.unwrap_or(1.0),
                zero: header.real(&format!("PZERO{number}"))?.unwrap_or(0.0),
            };
            named.push((name, term));
        }
        let called = |name: &str| {
            Quantity(
                named
                    .iter()
                    .filter(|(n, _)| n == name)
                    .map(|(_, term)| *term)
                    .collect(),
            )
        };
        let (uvw, uvw_to_m, projection) = read_uvw(header, &named, ref_hz)?;
        let parameters = Self {
            n_param: n_param as usize,
            uvw,
            uvw_to_m,
            projection,
            date: called("DATE"),
            baseline: called("BASELINE"),
            ant1: called("ANTENNA1"),
            ant2: called("ANTENNA2"),
            subarray: called("SUBARRAY"),
            source: called("SOURCE"),
            freq_sel: called("FREQSEL"),
            int_time: called("INTTIM"),
        };
        parameters.check(header)?;
        Ok(parameters)
    }

    /// Whether rows name their antennas one by one.
    pub(super) fn has_antenna_pair(&self) -> bool {
        self.ant1.is_there() && self.ant2.is_there()
    }

    fn check(&self, header: &Header) -> Result<(), ReadError> {
        let missing = |name: &str| {
            let what = format!("no random parameter is called {name}");
            Err(header.place.malformed("PTYPE", what))
        };
        if !self.date.is_there() {
            return missing("DATE");
        }
        if !self.baseline.is_there() && !self.has_antenna_pair() {
            return missing("BASELINE, nor ANTENNA1 and ANTENNA2");
        }
        Ok(())
    }
}

/// The three coordinates, which must be of one kind.
fn read_uvw(
    header: &Header,
    named: &[(String, Term)],
    ref_hz: f64,
) -> Result<([Quantity; 3], f64, Projection), ReadError> {
    let mut uvw: [Quantity; 3] = Default::default();
    let mut kinds = Vec::new();
    for (letters, quantity) in ["UU", "VV", "WW"].iter().zip(&mut uvw) {
        for (name, term) in named {
            let Some(suffix) = name.strip_prefix(letters) else {
                continue;
            };
            let kind = UvwKind::parse(suffix, term.scale, ref_hz).ok_or_else(|| {
                let key = format!("PTYPE{}", term.at + 1);
                header
                    .place
                    .unsupported(&key, format!("coordinate type '{name}' is not known"))
            })?;
            kinds.push(kind);
            quantity.0.push(*term);
        }
        if !quantity.is_there() {
            let what = format!("no random parameter is called {letters}");
            return Err(header.place.malformed("PTYPE", what));
        }
    }
    if kinds.iter().any(|kind| *kind != kinds[0]) {
        return Err(header
            .place
            .malformed("PTYPE", "UU, VV and WW are of different types"));
    }
    let to_m = if kinds[0].in_wavelengths {
        C_M_S / ref_hz
    } else {
        C_M_S
    };
    Ok((uvw, to_m, kinds[0].projection))
}

/// What follows the letters UU, VV, WW.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct UvwKind {
    in_wavelengths: bool,
    projection: Projection,
}

impl UvwKind {
    /// Nothing, `--`, `---SIN`, `---NCP` are in seconds after PSCAL. `-L`, `-L-SIN`, `-L-NCP` are in
    /// wavelengths at the reference frequency, except that AIPS also puts its inverse into PSCAL
    /// and so makes seconds of them: then they are taken for that.
    fn parse(suffix: &str, scale: f64, ref_hz: f64) -> Option<Self> {
        let words: Vec<&str> = suffix
            .split('-')
            .filter(|word| !word.trim().is_empty())
            .collect();
        let (in_wavelengths, projection) = match words.as_slice() {
            [] | ["SIN"] => (false, Projection::Sin),
            ["NCP"] => (false, Projection::Ncp),
            ["L"] | ["L", "SIN"] => (true, Projection::Sin),
            ["L", "NCP"] => (true, Projection::Ncp),
            _ => return None,
        };
        let scaled_to_s = (0.5..2.0).contains(&(scale.abs() * ref_hz));
        Some(Self {
            in_wavelengths: in_wavelengths && !scaled_to_s,
            projection,
        })
    }
}

/// Coordinates with w towards the pole, turned about u until w points at the declination.
pub(super) fn from_ncp(uvw_m: [f64; 3], dec_rad: f64) -> [f64; 3] {
    let (sin, cos) = dec_rad.sin_cos();
    let [u, v, w] = uvw_m;
    [u, v * sin + w * cos, w * sin - v * cos]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_uvw_has_its_unit() {
        let kind = |suffix, scale| UvwKind::parse(suffix, scale, 1.4e9);
        let seconds = UvwKind {
            in_wavelengths: false,
            projection: Projection::Sin,
        };
        for suffix in ["", "--", "---SIN", "-"] {
            assert_eq!(kind(suffix, 1.0), Some(seconds));
        }
        assert_eq!(kind("-L-SIN", 1.0 / 1.4e9), Some(seconds));
        assert!(kind("-L", 1.0).unwrap().in_wavelengths);
        assert_eq!(kind("---NCP", 1.0).unwrap().projection, Projection::Ncp);
        assert_eq!(kind("---TAN", 1.0), None);
    }

    #[test]
    fn pole_coordinates_turn_about_u() {
        let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        let pole = 90f64.to_radians();
        assert!(close(from_ncp([1.0, 2.0, 3.0], pole), [1.0, 2.0, 3.0]));
        // On the equator the pole lies along v.
        assert!(close(from_ncp([1.0, 2.0, 3.0], 0.0), [1.0, 3.0, -2.0]));
    }

    #[test]
    fn repeated_parameters_are_summed() {
        let term = |at, zero| Term {
            at,
            scale: 1.0,
            zero,
        };
        let date = Quantity(vec![term(0, 2_457_368.5), term(1, 0.0)]);
        let raw = [0.25, 1e-9];
        assert_eq!(date.mjd(|at| raw[at]), 57_368.25 + 1e-9);
        assert_eq!(date.value(|at| raw[at]), 2_457_368.75 + 1e-9);
    }
}
