//! The measurement equation, one term a file: what a source adds to a visibility.
//!
//! The phase convention is that of [`vis2cat_formats`].

mod predict;
pub mod shape;
mod source;

pub use predict::{phase_turns, predict};
pub use source::Source;
