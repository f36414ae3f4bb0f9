//! Simulated observations: an array, a field and a list of sources become visibilities.
//!
//! ```text
//! Array (table or CSV) ---+                        Source list
//! Earth orientation ------+-> Simulation ----------+--> chunk after chunk -> VisWriter
//! centre, time, channels -+   (observation, plan)      (uvw, model, noise)
//! ```
//!
//! Memory is a chunk, whatever the length of the observation. What is simulated is a point in time
//! and frequency: nothing is smeared over the sample or the channel, there is no primary beam, and
//! no autocorrelation is written.

pub mod array;
mod config;
mod describe;
mod earth;
mod error;
mod noise;
mod observe;
mod pointing;
mod predict;
mod rows;
mod time;
mod uvw;

pub use array::{Array, Dish};
pub use config::SimulateConfig;
pub use earth::{EarthTable, Orientation};
pub use error::SimulateError;
pub use observe::{Simulation, SimulationSummary, observation, simulate};
pub use pointing::{Pointing, Site};
pub use time::{format_utc, parse_utc};
pub use uvw::UvwFrame;
