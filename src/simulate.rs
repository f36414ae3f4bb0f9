//! Simulated observations: an array, a field and a list of sources become visibilities.
//!
//! ```text
//! Array (table or CSV) ---+                        Source list
//! Earth orientation ------+-> Simulation ----------+--> chunk after chunk -> VisWriter
//! centre, time, channels -+   (observation, plan)      (uvw, model, noise)
//! ```
//!
//! Memory is a chunk, whatever the length of the observation. Smearing over the sample and the channel,
//! a primary beam and a spectral index are simulated where they are asked for; no autocorrelation is
//! written.
//!
//! # Examples
//! ```
//! use vis2cat::coords::RaDec;
//! use vis2cat::simulate::{Array, SimulateConfig, Simulation, parse_utc};
//! use vis2cat::units::DEG;
//!
//! let simulation = Simulation::new(&SimulateConfig {
//!     array: Array::find("vla-a")?,
//!     centre: RaDec { ra_rad: 187.7 * DEG, dec_rad: 12.4 * DEG },
//!     start_mjd: Some(parse_utc("2020-03-01T08:00:00")?),
//!     duration_s: 600.0,
//!     ..SimulateConfig::default()
//! })?;
//! assert_eq!(simulation.observation().n_row, 351 * 10);
//! # Ok::<(), vis2cat::simulate::SimulateError>(())
//! ```

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
