//! `CATALOGUE`: one row a source.

use super::{ColumnDef, Get, plain, real};
use crate::catalogue::SourceRow;
use crate::units::{ARCSEC, DEG, MICROJY};

/// Columns that are there where spectral indices are free.
const SPECTRAL_INDEX: &str = "Spectral_index";
const E_SPECTRAL_INDEX: &str = "E_Spectral_index";

/// True for columns that are there where spectral indices are free.
pub(in crate::catalogue) fn is_of_spectrum(name: &str) -> bool {
    name.eq_ignore_ascii_case(SPECTRAL_INDEX) || name == E_SPECTRAL_INDEX
}

/// Columns that are there where a primary beam was applied.
const APP_FLUX: &str = "App_flux";
const PB_GAIN: &str = "PB_gain";

/// True for columns that are there where a primary beam was applied.
pub(in crate::catalogue) fn is_of_beam(name: &str) -> bool {
    name == APP_FLUX || name == PB_GAIN
}

/// Column that is there where sources were selected by the probability to be bright.
const P_ABOVE: &str = "P_above";

/// True for the column that is there where sources were selected by the probability to be bright.
pub(in crate::catalogue) fn is_of_flux_cut(name: &str) -> bool {
    name == P_ABOVE
}

/// Names and identifiers, position, flux density, shape, significance, quality, samples.
#[rustfmt::skip]
pub(in crate::catalogue) const CATALOGUE: &[ColumnDef<SourceRow>] = &[
    plain("Source_name", "meta.id;meta.main", "IAU name, coordinates truncated", Get::Text(|r| &r.name)),
    plain("Source_id", "meta.id", "number of the source in this catalogue", Get::Int(|r| r.source_id)),
    plain("Group_id", "meta.id.parent", "Source_id of the brightest that it was sampled jointly with", Get::Int(|r| r.group_id)),
    real("RA", "deg", "pos.eq.ra;meta.main", "right ascension, ICRS, posterior mean", |r| r.posterior.position.ra_rad / DEG),
    real("DEC", "deg", "pos.eq.dec;meta.main", "declination, ICRS, posterior mean", |r| r.posterior.position.dec_rad / DEG),
    real("E_RA", "arcsec", "stat.error;pos.eq.ra", "1 sigma towards east on the sky, includes cos(dec)", |r| r.posterior.e_ra_rad / ARCSEC),
    real("E_DEC", "arcsec", "stat.error;pos.eq.dec", "1 sigma towards north", |r| r.posterior.e_dec_rad / ARCSEC),
    real("Corr_RA_DEC", "", "stat.correlation;pos.eq.ra;pos.eq.dec", "correlation of the errors of position", |r| r.posterior.corr_ra_dec),
    real("L", "rad", "pos.cartesian.x", "direction cosine l, east of the phase centre", |r| r.posterior.lm.l),
    real("M", "rad", "pos.cartesian.y", "direction cosine m, north of the phase centre", |r| r.posterior.lm.m),
    real("Total_flux", "uJy", "phot.flux.density;{band}", "total flux density, posterior mean", |r| r.posterior.flux_jy.mean / MICROJY),
    real("E_Total_flux", "uJy", "stat.error;phot.flux.density;{band}", "1 sigma of Total_flux", |r| r.posterior.flux_jy.err / MICROJY),
    real("Total_flux_lo", "uJy", "phot.flux.density;{band};stat.min", "16th percentile of the flux density", |r| r.posterior.flux_lo_jy / MICROJY),
    real("Total_flux_hi", "uJy", "phot.flux.density;{band};stat.max", "84th percentile of the flux density", |r| r.posterior.flux_hi_jy / MICROJY),
    real(APP_FLUX, "uJy", "phot.flux.density;{band}", "Total_flux times PB_gain: what the dishes saw", |r| r.posterior.flux_jy.mean * r.pb_gain / MICROJY),
    real(PB_GAIN, "", "arith.factor;instr.beam", "primary beam at the position, middle of the band", |r| r.pb_gain),
    real(SPECTRAL_INDEX, "", "spect.index", "spectral index, S proportional to frequency to this power", |r| r.posterior.spectral_index.mean),
    real(E_SPECTRAL_INDEX, "", "stat.error;spect.index", "1 sigma of Spectral_index", |r| r.posterior.spectral_index.err),
    real("Scale_length", "arcsec", "src.morph.scLength", "scale-length, harmonic mean of the axes", |r| r.posterior.scale_rad.mean / ARCSEC),
    real("E_Scale_length", "arcsec", "stat.error;src.morph.scLength", "1 sigma of Scale_length", |r| r.posterior.scale_rad.err / ARCSEC),
    real("E1", "", "src.ellipticity", "(a-b)/(a+b) cos 2phi, phi from east to north", |r| r.posterior.e1.mean),
    real("E_E1", "", "stat.error;src.ellipticity", "1 sigma of E1", |r| r.posterior.e1.err),
    real("E2", "", "src.ellipticity", "(a-b)/(a+b) sin 2phi, phi from east to north", |r| r.posterior.e2.mean),
    real("E_E2", "", "stat.error;src.ellipticity", "1 sigma of E2", |r| r.posterior.e2.err),
    real("Corr_E1_E2", "", "stat.correlation;src.ellipticity", "correlation of E1 and E2", |r| r.posterior.corr_e1_e2),
    real("Maj", "arcsec", "phys.angSize.smajAxis;stat.fwhm", "full major axis at half maximum", |r| r.posterior.maj_rad.mean / ARCSEC),
    real("E_Maj", "arcsec", "stat.error;phys.angSize.smajAxis", "1 sigma of Maj", |r| r.posterior.maj_rad.err / ARCSEC),
    real("Min", "arcsec", "phys.angSize.sminAxis;stat.fwhm", "full minor axis at half maximum", |r| r.posterior.min_rad.mean / ARCSEC),
    real("E_Min", "arcsec", "stat.error;phys.angSize.sminAxis", "1 sigma of Min", |r| r.posterior.min_rad.err / ARCSEC),
    real("PA", "deg", "pos.posAng", "position angle of Maj, north through east, circular mean", |r| r.posterior.pa_rad.mean / DEG),
    real("E_PA", "deg", "stat.error;pos.posAng", "circular standard deviation of PA", |r| r.posterior.pa_rad.err / DEG),
    real("SNR", "", "stat.snr", "S sqrt(Y) in the visibilities, posterior mean", |r| r.snr),
    real("SNR_peak", "", "stat.snr;stat.max", "X / sqrt(Y) at the best sample", |r| r.snr_peak),
    real("Log_Z", "", "stat.likelihood", "local log evidence against no source, others removed", |r| r.log_z.mean),
    real("E_Log_Z", "", "stat.error", "1 sigma of Log_Z", |r| r.log_z.err),
    real("P_source", "", "stat.probability;src", "probability that this is a source", |r| r.p_source),
    real(P_ABOVE, "", "stat.probability;src", "the same, and that it is brighter than the flux cut", |r| r.p_above),
    real("N_eff", "", "meta.number", "effective number of samples", |r| r.posterior.n_eff),
    real("Max_dlogL", "", "stat.value", "largest ln L difference, exact minus fast engine", |r| r.max_dlog_l),
    plain("Flags", "meta.code.qual", "bits, see the comments of this header", Get::Bits(|r| r.flags.0)),
    plain("Mode_id", "meta.id.assoc", "the mode of MODES that this source came from", Get::Int(|r| r.mode_id)),
    plain("Post_row", "meta.record", "first row in POSTERIOR, from 0", Get::Int(|r| r.post_row)),
    plain("Post_n", "meta.number", "number of rows in POSTERIOR", Get::Int(|r| r.post_n)),
];
