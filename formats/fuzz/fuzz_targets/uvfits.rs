//! Any bytes as UVFITS: an error or rows, nothing else.

#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

#[path = "read.rs"]
mod read;

const CARD_BYTES: usize = 80;

fuzz_target!(|bytes: &[u8]| read::file(bytes, b"SIMPLE  ="));

// Half of the time one card alone, or what stands where one could, so that the others stay in place.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let n_card = size / CARD_BYTES;
    if seed % 2 == 0 || n_card == 0 {
        return fuzzer_mutate(data, size, max_size);
    }
    let at = seed as usize / 2 % n_card * CARD_BYTES;
    let card = &mut data[at..at + CARD_BYTES];
    let len = fuzzer_mutate(card, CARD_BYTES, CARD_BYTES);
    card[len..].fill(b' ');
    size
});
