//! Radio-interferometer visibilities in, a source catalogue with full posteriors out.
#![doc = include_str!("../ARCHITECTURE.md")]

pub mod catalogue;
pub mod chains;
pub mod checkpoint;
pub mod cli;
pub mod config;
pub mod coords;
pub mod dataset;
pub mod detect;
pub mod evaluate;
pub mod likelihood;
mod normal;
mod polynomial;
pub mod prior;
pub mod report;
pub mod rime;
pub mod run;
pub mod sampler;
pub mod simulate;
pub mod timing;
pub mod units;
