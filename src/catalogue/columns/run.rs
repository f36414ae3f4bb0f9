//! `RUN`: how the run was made.

use super::{ColumnDef, Get, plain};
use crate::catalogue::RunEntry;

/// Keys and values as text.
#[rustfmt::skip]
pub(in crate::catalogue) const RUN: &[ColumnDef<RunEntry>] = &[
    plain("KEY", "meta.id;meta.main", "option, version, count or result", Get::Text(|r| &r.key)),
    plain("VALUE", "meta.note", "its value as text", Get::Text(|r| &r.value)),
    plain("COMMENT", "meta.note", "unit and meaning", Get::Text(|r| &r.comment)),
];
