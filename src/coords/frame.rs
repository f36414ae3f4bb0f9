//! Celestial frames of old files, turned to ICRS.

use vis2cat_formats::Frame;

use super::{Lm, RaDec};
use crate::rime::Source;
use crate::rime::shape::Ellipticity;
use crate::units::ARCSEC;

/// A phase centre in ICRS, and how far the file's own axes are turned about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IcrsCentre {
    /// Phase centre, ICRS.
    pub centre: RaDec,
    /// Direction of the file's north, from ICRS north towards east [rad].
    pub north_rad: f64,
}

impl IcrsCentre {
    /// The ICRS centre of a field whose phase centre is `native` in `frame`.
    pub fn new(native: RaDec, frame: Frame) -> Self {
        let centre = to_icrs(native, frame);
        let step_rad = 60.0 * ARCSEC;
        let northern = RaDec::from_lm(
            Lm {
                l: 0.0,
                m: step_rad,
            },
            native,
        );
        let north = to_icrs(northern, frame).to_lm(centre);
        Self {
            centre,
            north_rad: north.l.atan2(north.m),
        }
    }

    /// A direction, given as a unit vector in ICRS, in the file's own axes: east, north, towards the
    /// phase centre.
    pub fn from_icrs(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin_ra, cos_ra) = self.centre.ra_rad.sin_cos();
        let (sin_dec, cos_dec) = self.centre.dec_rad.sin_cos();
        let along = x * cos_ra + y * sin_ra;
        let (east, north) = (y * cos_ra - x * sin_ra, z * cos_dec - along * sin_dec);
        let (sin, cos) = self.north_rad.sin_cos();
        [
            east * cos - north * sin,
            north * cos + east * sin,
            along * cos_dec + z * sin_dec,
        ]
    }

    /// `source` with its position and shape about the ICRS axes.
    pub fn turn(&self, source: &Source) -> Source {
        let (sin, cos) = self.north_rad.sin_cos();
        let (sin2, cos2) = (2.0 * self.north_rad).sin_cos();
        let (lm, e) = (source.lm, source.e);
        Source {
            lm: Lm {
                l: lm.l * cos + lm.m * sin,
                m: lm.m * cos - lm.l * sin,
            },
            e: Ellipticity {
                e1: e.e1 * cos2 + e.e2 * sin2,
                e2: e.e2 * cos2 - e.e1 * sin2,
            },
            ..*source
        }
    }
}

fn to_icrs(native: RaDec, frame: Frame) -> RaDec {
    let (ra_rad, dec_rad) = frame.to_icrs(native.ra_rad, native.dec_rad);
    RaDec { ra_rad, dec_rad }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::DEG;

    #[test]
    fn a_direction_turns_as_a_source_does() {
        let native = RaDec {
            ra_rad: 40.0 * DEG,
            dec_rad: 62.0 * DEG,
        };
        let lm = Lm { l: 0.03, m: -0.02 };
        for frame in [Frame::Icrs, Frame::Fk4(1950.0)] {
            let icrs = IcrsCentre::new(native, frame);
            let source = Source {
                lm,
                ..Source::default()
            };
            let at = RaDec::from_lm(icrs.turn(&source).lm, icrs.centre);
            let [l, m, n] = icrs.from_icrs(at.unit_vector());
            assert!((l - lm.l).abs() < 1e-12 && (m - lm.m).abs() < 1e-12);
            assert!((n - 1.0 - lm.n_minus_1()).abs() < 1e-12);
        }
    }

    fn close(a: RaDec, ra_deg: f64, dec_deg: f64, tolerance_arcsec: f64) {
        let want = RaDec {
            ra_rad: ra_deg * DEG,
            dec_rad: dec_deg * DEG,
        };
        let off = a.to_lm(want);
        assert!(off.l.hypot(off.m) < tolerance_arcsec * ARCSEC, "{a:?}");
    }

    /// Reference values by astropy's FK5 and FK4 frames transformed to ICRS, but for the equinox of
    /// 1975: ERFA's pmat76 and fk5hz, since astropy precesses FK5 by later constants (0.1 arcsec).
    #[test]
    fn old_frames_agree_with_astropy_and_erfa() {
        let native = RaDec {
            ra_rad: 187.5 * DEG,
            dec_rad: 12.0 * DEG,
        };
        close(
            to_icrs(native, Frame::Fk5(2000.0)),
            187.499994874,
            12.000001785,
            1e-3,
        );
        close(
            to_icrs(native, Frame::Fk5(1975.0)),
            187.816359341,
            11.862047789,
            1e-3,
        );
        close(
            to_icrs(native, Frame::Fk4(1950.0)),
            188.132704822,
            11.724209986,
            0.2,
        );
    }

    #[test]
    fn a_turned_source_lies_where_its_own_direction_says() {
        let (native, frame) = (
            RaDec {
                ra_rad: 1.0,
                dec_rad: 1.2,
            },
            Frame::Fk4(1950.0),
        );
        let icrs = IcrsCentre::new(native, frame);
        let source = Source {
            lm: Lm { l: 2e-3, m: -1e-3 },
            ..Source::default()
        };
        let direct = to_icrs(RaDec::from_lm(source.lm, native), frame).to_lm(icrs.centre);
        let turned = icrs.turn(&source).lm;
        assert!((direct.l - turned.l).hypot(direct.m - turned.m) < 1e-2 * ARCSEC);
        assert!(icrs.north_rad.abs() > 1e-3);
    }
}
