//! The crate's formats from the outside: whole files in, whole files out.

mod dialects;
mod fixtures;
mod made;
mod real;
mod round_trip;
mod support;
mod writing;
