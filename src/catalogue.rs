//! The source catalogue: what a run found, written as FITS tables.
//!
//! | file | tables |
//! |---|---|
//! | `out.fits` | `CATALOGUE`, one row a source; `MODES`, one row for every mode found, kept or not; `RUN`, key and value |
//! | `out.posterior.fits` | `POSTERIOR`, the samples of all sources; `Post_row` and `Post_n` of `CATALOGUE` cut out those of one source |
//!
//! Rows hold radians and janskys as the rest of the program does; [`write()`] converts to degrees,
//! arcseconds and microjanskys. Equal rows give equal bytes: no clock, no machine, no thread count.
//! Positions are ICRS.

mod band;
mod columns;
mod header;
mod list;
mod name;
mod posterior;
mod read;
mod row;
mod summary;
mod truth;
mod write;

pub use header::{CatalogueHeader, PriorRange};
pub use name::{ACRONYM, source_name};
pub use posterior::{Ellipse, Summary, WeightedSample, equal_weight, posterior_rows, summarise};
pub use read::{FoundCatalogue, FoundMode, FoundRow, FoundSamples, SearchedField, read_catalogue};
pub use row::{Estimate, Flags, ModeRow, PosteriorRow, RunEntry, SourceRow};
pub(crate) use summary::aligned;
pub use summary::summary_table;
pub use truth::{CatalogueSource, SourceList, read_source_list, read_sources, write_truth};
pub use write::{CataloguePaths, write};
