//! Integration tests, one module a topic.

#![allow(clippy::unwrap_used)] // helpers of tests are tests

mod catalogue;
mod chains;
mod checkpoint;
mod cli;
mod convert;
mod dataset;
mod detect;
mod evaluate;
mod inputs;
mod instrument;
mod oracles;
mod pyuvdata;
mod report;
mod sampler;
mod select;
mod simulate;
mod support;
