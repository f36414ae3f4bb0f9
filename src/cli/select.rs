//! Flags that say what part of a file is wanted.

use clap::Args;
use vis2cat_formats::{ReadOptions, Selection};

/// Flags of commands that read a file.
#[derive(Debug, Clone, Args)]
pub(crate) struct ReadArgs {
    /// Name or number of the field, where the file holds several
    #[arg(long, value_name = "FIELD")]
    field: Option<String>,
    /// Numbers of the spectral windows, as `vis2cat info` lists them, as in 0,2 [default: all]
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',')]
    spw: Vec<i64>,
    /// Column of visibilities of a Measurement Set [default: CORRECTED_DATA where filled, or DATA]
    #[arg(long, value_name = "NAME")]
    data_column: Option<String>,
}

impl ReadArgs {
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            data_column: self.data_column.clone(),
            select: Selection {
                field: self.field.clone(),
                spws: self.spw.clone(),
                ..Selection::default()
            },
            ..ReadOptions::default()
        }
    }
}
