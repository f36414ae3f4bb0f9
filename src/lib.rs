//! Radio-interferometer visibilities in, a source catalogue with full posteriors out.
#![doc = include_str!("../ARCHITECTURE.md")]

pub mod catalogue;
pub mod coords;
pub mod likelihood;
pub mod prior;
pub mod rime;
pub mod sampler;
pub mod units;
