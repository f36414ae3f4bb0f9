//! Any bytes as UVFITS: an error or rows, nothing else.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "read.rs"]
mod read;

fuzz_target!(|bytes: &[u8]| read::file(bytes, b"SIMPLE  ="));
