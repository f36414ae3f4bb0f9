//! `TRUTH`: the sources that went into a simulation.

use super::{ColumnDef, real};
use crate::catalogue::CatalogueSource;
use crate::units::{ARCSEC, DEG, MICROJY};

/// Named as in `CATALOGUE`, so that either can be read as a list of sources.
#[rustfmt::skip]
pub(in crate::catalogue) const TRUTH: &[ColumnDef<CatalogueSource>] = &[
    real("RA", "deg", "pos.eq.ra;meta.main", "right ascension, ICRS", |r| r.position.ra_rad / DEG),
    real("DEC", "deg", "pos.eq.dec;meta.main", "declination, ICRS", |r| r.position.dec_rad / DEG),
    real("Total_flux", "uJy", "phot.flux.density;{band}", "total flux density", |r| r.flux_jy / MICROJY),
    real("Spectral_index", "", "spect.index", "spectral index", |r| r.spectral_index),
    real("Scale_length", "arcsec", "src.morph.scLength", "scale-length, harmonic mean of the axes", |r| r.scale_rad / ARCSEC),
    real("E1", "", "src.ellipticity", "(a-b)/(a+b) cos 2phi, phi from east to north", |r| r.e.e1),
    real("E2", "", "src.ellipticity", "(a-b)/(a+b) sin 2phi, phi from east to north", |r| r.e.e2),
    real("SNR", "", "stat.snr", "S sqrt(Y) in the visibilities", |r| r.snr),
];
