//! `POSTERIOR` read back.

use std::path::Path;

use vis2cat_formats::ReadError;

use super::super::list::{ListTable, Unit, malformed};
use super::{FoundRow, whole};

/// Posterior samples, a column each; those of one source are consecutive.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FoundSamples {
    /// Weights; those of a source sum to 1.
    pub weight: Vec<f64>,
    /// Right ascension, ICRS [rad].
    pub ra_rad: Vec<f64>,
    /// Declination, ICRS [rad].
    pub dec_rad: Vec<f64>,
    /// Total flux density [Jy].
    pub flux_jy: Vec<f64>,
    /// Scale-length [rad].
    pub scale_rad: Vec<f64>,
    /// Ellipticity along l.
    pub e1: Vec<f64>,
    /// Ellipticity along the diagonal.
    pub e2: Vec<f64>,
    /// Spectral index; NaN where it was not free.
    pub spectral_index: Vec<f64>,
}

/// Reads the samples in `path` and tells each of `rows` which are its own: `Post_row` and `Post_n` of
/// `catalogue` say so.
pub(super) fn read(
    path: &Path,
    catalogue: &ListTable,
    rows: &mut [FoundRow],
) -> Result<FoundSamples, ReadError> {
    let table = ListTable::find(path, "POSTERIOR")?;
    let table = table.ok_or_else(|| {
        malformed(
            path,
            "POSTERIOR".to_owned(),
            "there is no binary table of this name; move the file away to do without samples",
        )
    })?;
    let number = |name| table.need(name, Unit::NONE);
    let source_id = number("Source_id")?;
    let first = catalogue.need("Post_row", Unit::NONE)?;
    let count = catalogue.need("Post_n", Unit::NONE)?;
    for (i, row) in rows.iter_mut().enumerate() {
        let own = |ids: &[f64]| ids.iter().all(|id| whole(*id) == row.source_id);
        let slice = whole(first[i]).zip(whole(count[i]));
        let slice = slice.map(|(first, count)| first as usize..(first + count) as usize);
        row.samples = (slice.filter(|s| source_id.get(s.clone()).is_some_and(own)))
            .ok_or_else(|| not_its_own(path, i))?;
    }
    Ok(FoundSamples {
        weight: number("weight")?,
        ra_rad: table.need("ra", Unit::angle("deg"))?,
        dec_rad: table.need("dec", Unit::angle("deg"))?,
        flux_jy: table.need("flux", Unit::FLUX)?,
        scale_rad: table.need("scale", Unit::angle("arcsec"))?,
        e1: number("e1")?,
        e2: number("e2")?,
        spectral_index: table.column_or("spectral_index", Unit::NONE, f64::NAN)?,
    })
}

fn not_its_own(path: &Path, row: usize) -> ReadError {
    let place = format!("POSTERIOR, samples of row {} of the catalogue", row + 1);
    let what = "they are not there: the file belongs to another catalogue; move it away to do \
                without samples";
    malformed(path, place, what)
}
