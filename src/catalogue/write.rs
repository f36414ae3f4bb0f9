//! Both output files: written whole, then named.

use std::path::{Path, PathBuf};

use vis2cat_formats::WriteError;
use vis2cat_formats::fits::{Cards, Column, TableSpec, prepare_tables, refuse_existing};

use super::band::ucd_band;
use super::columns::{
    CATALOGUE, MODES, POSTERIOR, RUN, build, is_of_beam, is_of_flux_cut, is_of_spectrum,
};
use super::header::{CatalogueHeader, minimal};
use super::row::{ModeRow, PosteriorRow, RunEntry, SourceRow};

/// Where the outputs go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CataloguePaths {
    /// `CATALOGUE`, `MODES` and `RUN`.
    pub catalogue: PathBuf,
    /// `POSTERIOR`.
    pub posterior: PathBuf,
}

impl CataloguePaths {
    /// `out.fits` and, beside it, `out.posterior.fits`.
    pub fn new(catalogue: &Path) -> Self {
        Self {
            catalogue: catalogue.to_owned(),
            posterior: catalogue.with_extension("posterior.fits"),
        }
    }

    /// Nothing if both may be written: to be asked before a long run.
    ///
    /// # Errors
    /// One is there and `overwrite` is false, or there is no such folder.
    pub fn refuse_existing(&self, overwrite: bool) -> Result<(), WriteError> {
        let folder = self.catalogue.parent().filter(|f| *f != Path::new(""));
        if let Some(folder) = folder {
            std::fs::read_dir(folder).map_err(|source| WriteError::Io {
                path: self.catalogue.clone(),
                source,
            })?;
        }
        refuse_existing(&self.catalogue, overwrite)?;
        refuse_existing(&self.posterior, overwrite)
    }
}

/// Writes both files; neither has its name before both are whole on disk, the catalogue last.
///
/// `posterior` holds the samples of each source in one piece, as `post_row` and `post_n` of `sources`
/// say.
///
/// # Errors
/// A file exists and `overwrite` is false, cannot be written, or the slices do not fit.
pub fn write(
    paths: &CataloguePaths,
    overwrite: bool,
    header: &CatalogueHeader,
    sources: &[SourceRow],
    modes: &[ModeRow],
    run: &[RunEntry],
    posterior: &[PosteriorRow],
) -> Result<(), WriteError> {
    if let Some(what) = misplaced(sources, posterior) {
        let path = paths.catalogue.clone();
        return Err(WriteError::Parameter { path, what });
    }
    paths.refuse_existing(overwrite)?;
    let band = ucd_band(header.ref_freq_hz);
    let is_there = |column: &Column| {
        (header.has_beam || !is_of_beam(&column.name))
            && (header.has_p_above || !is_of_flux_cut(&column.name))
            && (header.has_spectral_index || !is_of_spectrum(&column.name))
    };
    let mut columns = build(CATALOGUE, sources, band);
    columns.retain(is_there);
    let tables = [
        table("CATALOGUE", columns, header.catalogue()),
        table("MODES", build(MODES, modes, band), header.table()),
        table("RUN", build(RUN, run, band), minimal()),
    ];
    let catalogue = prepare_tables(&paths.catalogue, overwrite, &header.primary(), &tables)?;
    drop(tables);
    let mut columns = build(POSTERIOR, posterior, band);
    columns.retain(is_there);
    let samples = [table("POSTERIOR", columns, header.table())];
    let posterior = prepare_tables(&paths.posterior, overwrite, &header.primary(), &samples)?;
    posterior.commit()?;
    catalogue.commit().inspect_err(|_| {
        if !overwrite {
            // What was just made here goes again: both or neither. What it replaced is gone.
            let _ = std::fs::remove_file(&paths.posterior);
        }
    })
}

fn table(extname: &str, columns: Vec<Column>, cards: Cards) -> TableSpec {
    TableSpec {
        extname: extname.to_owned(),
        columns,
        cards,
    }
}

/// The first source whose slice of `posterior` is not its own, if there is one.
fn misplaced(sources: &[SourceRow], posterior: &[PosteriorRow]) -> Option<String> {
    let own = |source: &&SourceRow| {
        let first = usize::try_from(source.post_row).ok()?;
        let count = usize::try_from(source.post_n).ok()?;
        let slice = posterior.get(first..first.checked_add(count)?)?;
        slice
            .iter()
            .all(|row| row.source_id == source.source_id)
            .then_some(())
    };
    let source = sources.iter().find(|source| own(source).is_none())?;
    Some(format!(
        "source {}: rows {} + {} of POSTERIOR are not its own",
        source.source_id, source.post_row, source.post_n
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_posterior_stands_beside_the_catalogue() {
        let paths = CataloguePaths::new(Path::new("a/field.1.fits"));
        assert_eq!(paths.posterior, Path::new("a/field.1.posterior.fits"));
        let bare = CataloguePaths::new(Path::new("out"));
        assert_eq!(bare.posterior, Path::new("out.posterior.fits"));
    }
}
