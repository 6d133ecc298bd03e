//! Reduced-order models of flexible bodies that fly: reads a `.rom` file and marches the modal and rigid-body equations.
//!
//! ```no_run
//! use std::sync::Arc;
//! use rom_runtime::{Model, Settings, Simulation};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let model = Arc::new(Model::read_path("fmb.rom")?);
//! let case = model.load_case("lc2")?;
//! let loads = model.prepare(case)?;
//! let tip = model.point("P")?;
//! let settings = Settings { dt: case.dt, numerical_damping: case.numerical_damping, ..Settings::default() };
//! let mut simulation = Simulation::new(model.clone(), settings)?;
//! for _ in 0..1000 {
//!     simulation.step(&loads)?;
//! }
//! println!("{:?}", simulation.point_output(tip));
//! # Ok(())
//! # }
//! ```
//!
//! [`Model`] is constant and shared, [`State`] is plain data that changes, [`Simulation`] ties both to the memory of a step.
//! Without the feature `std` the crate needs only `alloc`; stepping never allocates.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;
// The models of the tests name this crate as its users do.
#[cfg(test)]
extern crate self as rom_runtime;

pub mod data;
mod equations;
mod error;
pub mod expression;
pub mod format;
mod integrator;
mod loading;
pub mod loads;
mod math;
mod model;
mod output;
mod simulation;
mod state;
mod tensor;
pub mod time;
mod validate;

pub use data::ModelData;
pub use equations::{StateRate, Workspace};
pub use error::{ModelError, SettingsError, StepError};
pub use format::FormatError;
pub use integrator::{Integrator, StableDt, UnknownIntegrator};
pub use loading::{LoadSet, Loads, PreparedLoads};
pub use loads::{Load, LoadCase, LoadFrame};
pub use model::Model;
pub use output::{Ledger, PointOutput, RigidOutput};
pub use simulation::{Settings, Simulation};
pub use state::State;
