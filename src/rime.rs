//! The measurement equation, one term a file: what a source adds to a visibility.
//!
//! The phase convention is that of [`vis2cat_formats`].

pub mod shape;
mod source;

pub use source::Source;
