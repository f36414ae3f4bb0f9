//! The crate's formats from the outside: whole files in, whole files out.

// Helpers outside of test functions are tests too.
#![allow(clippy::unwrap_used)]

mod dialects;
mod fixtures;
mod made;
mod ms;
mod parts;
mod real;
mod round_trip;
mod support;
mod truncation;
mod uvh5;
mod writing;
