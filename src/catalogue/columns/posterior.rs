//! `POSTERIOR`: one row a sample, sources one after the other.

use super::{ColumnDef, Get, plain, real};
use crate::catalogue::PosteriorRow;
use crate::units::{ARCSEC, DEG, MICROJY};

/// Weight, likelihood and parameters, the names in lower case as chains have them.
#[rustfmt::skip]
pub(in crate::catalogue) const POSTERIOR: &[ColumnDef<PosteriorRow>] = &[
    plain("Source_id", "meta.id", "number of the source in CATALOGUE", Get::Int(|r| r.source_id)),
    plain("Mode_id", "meta.id.assoc", "number of the mode in MODES", Get::Int(|r| r.mode_id)),
    real("weight", "", "stat.weight", "posterior weight, sums to 1 over a source", |r| r.weight),
    real("log_l", "", "stat.likelihood", "ln L - ln L0, of all members of a group", |r| r.log_l),
    real("ra", "deg", "pos.eq.ra", "right ascension, ICRS", |r| r.position.ra_rad / DEG),
    real("dec", "deg", "pos.eq.dec", "declination, ICRS", |r| r.position.dec_rad / DEG),
    real("l", "rad", "pos.cartesian.x", "direction cosine l, east of the phase centre", |r| r.source.lm.l),
    real("m", "rad", "pos.cartesian.y", "direction cosine m, north of the phase centre", |r| r.source.lm.m),
    real("flux", "uJy", "phot.flux.density;{band}", "total flux density", |r| r.source.flux_jy / MICROJY),
    real("spectral_index", "", "spect.index", "spectral index", |r| r.source.tilt),
    real("scale", "arcsec", "src.morph.scLength", "scale-length, harmonic mean of the axes", |r| r.source.scale_rad / ARCSEC),
    real("e1", "", "src.ellipticity", "(a-b)/(a+b) cos 2phi, phi from east to north", |r| r.source.e.e1),
    real("e2", "", "src.ellipticity", "(a-b)/(a+b) sin 2phi, phi from east to north", |r| r.source.e.e2),
    real("maj", "arcsec", "phys.angSize.smajAxis;stat.fwhm", "full major axis at half maximum", |r| r.ellipse.maj_rad / ARCSEC),
    real("min", "arcsec", "phys.angSize.sminAxis;stat.fwhm", "full minor axis at half maximum", |r| r.ellipse.min_rad / ARCSEC),
    real("pa", "deg", "pos.posAng", "position angle of maj, north through east", |r| r.ellipse.pa_rad / DEG),
];
