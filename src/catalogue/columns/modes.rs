//! `MODES`: one row for every mode, kept or not.

use super::{ColumnDef, Get, plain, real};
use crate::catalogue::ModeRow;
use crate::units::{ARCSEC, DEG, MICROJY};

/// Where the mode is, how strong, and what became of it.
#[rustfmt::skip]
pub(in crate::catalogue) const MODES: &[ColumnDef<ModeRow>] = &[
    plain("Mode_id", "meta.id;meta.main", "number of the mode", Get::Int(|r| r.mode_id)),
    plain("Tile_id", "meta.id.parent", "the tile in which it was found", Get::Int(|r| r.tile_id)),
    real("RA", "deg", "pos.eq.ra;meta.main", "right ascension, ICRS, posterior mean", |r| r.position.ra_rad / DEG),
    real("DEC", "deg", "pos.eq.dec;meta.main", "declination, ICRS, posterior mean", |r| r.position.dec_rad / DEG),
    real("E_Pos", "arcsec", "stat.error;pos.eq", "1 sigma of the position, the larger of both axes", |r| r.position_sigma_rad / ARCSEC),
    real("L", "rad", "pos.cartesian.x", "direction cosine l, east of the phase centre", |r| r.lm.l),
    real("M", "rad", "pos.cartesian.y", "direction cosine m, north of the phase centre", |r| r.lm.m),
    real("Total_flux", "uJy", "phot.flux.density;{band}", "total flux density, posterior mean", |r| r.flux_jy.mean / MICROJY),
    real("E_Total_flux", "uJy", "stat.error;phot.flux.density;{band}", "1 sigma of Total_flux", |r| r.flux_jy.err / MICROJY),
    real("SNR", "", "stat.snr", "S sqrt(Y) in the visibilities, posterior mean", |r| r.snr),
    real("SNR_peak", "", "stat.snr;stat.max", "X / sqrt(Y) at the best sample", |r| r.snr_peak),
    real("Log_Z", "", "stat.likelihood", "local log evidence against no source", |r| r.log_z.mean),
    real("E_Log_Z", "", "stat.error", "1 sigma of Log_Z", |r| r.log_z.err),
    real("P_source", "", "stat.probability;src", "probability that this is a source, if it is kept or below the cut", |r| r.p_source),
    plain("N_samples", "meta.number", "number of samples", Get::Int(|r| r.n_samples)),
    real("N_eff", "", "meta.number", "effective number of samples", |r| r.n_eff),
    plain("Status", "meta.code.status", "kept, or why it was dropped", Get::Text(|r| r.status.as_str())),
    plain("Source_id", "meta.id.assoc", "the source that it is or is explained by", Get::MaybeInt(|r| r.source_id)),
];
