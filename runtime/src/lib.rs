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
//! To start from, in `runtime/examples`: a host that owns the rigid body (`prescribed_host.rs`), loads that depend on the motion, with
//! snapshot and rewind (`loads_from_state.rs`), an implicit host with the exact [`Jacobian`] (`implicit_host.rs`).
//!
//! [`Model`] is constant and shared, [`State`] is plain data that changes, [`Simulation`] ties both to the memory of a step.
//! Without the feature `std` the crate needs only `alloc`; stepping never allocates.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
// Nothing may panic on any input; modules a step runs through may not even index.
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable))]
extern crate alloc;
// The models of the tests name this crate as its users do.
#[cfg(test)]
extern crate self as rom_runtime;

/// The programs of the page, as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/rust.md")]
struct Page;

#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod base_motion;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod batch;
#[cfg(test)]
#[path = "../tests/common/mod.rs"]
mod common;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod curve;
pub mod data;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod dense;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod direct;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod equations;
mod error;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod estimate;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
pub mod expression;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod expression_rate;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod flat;
pub mod format;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod forward;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod four;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod gravity;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod identity;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod initial;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod integrator;
mod internal_loads;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod jacobian;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod lagrangian;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod limits;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod load_set;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod loading;
pub mod loads;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod math;
mod method;
mod model;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod output;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod picture;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod point_motion;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod polynomial;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod prescribed;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod products;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod projected;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod real;
mod section_axes;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod sensor;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod simulation;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod sparse;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod state;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod static_shape;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod stations;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
mod tensor;
#[cfg_attr(not(test), deny(clippy::indexing_slicing))]
pub mod time;
mod validate;

pub use base_motion::{BaseMotion, Drive};
pub use batch::Batch;
pub use data::ModelData;
pub use equations::{StateRate, Workspace};
pub use error::{ModelError, SettingsError, StepError};
pub use estimate::ErrorEstimate;
pub use flat::FlatLayout;
pub use format::FormatError;
pub use integrator::{Integrator, StableDt, UnknownIntegrator};
pub use internal_loads::{InternalLoads, SectionForces};
pub use jacobian::{Direction, Jacobian};
pub use limits::{LIMIT_LEVELS, LeftOut};
pub use load_set::LoadSet;
pub use loading::{Loads, PreparedLoads};
pub use loads::{DistributedFrame, DistributedLoad, InitialState, Load, LoadCase, LoadFrame};
pub use method::{Method, UnknownMethod};
pub use model::Model;
pub use output::{Ledger, PointOutput, RigidOutput, attitude_rate};
pub use picture::PictureCurve;
pub use point_motion::{PointMotion, into_axes};
pub use prescribed::{PrescribedMotion, Reaction};
pub use sensor::SensorReading;
pub use simulation::{Settings, Simulation};
pub use state::State;
pub use stations::{StationAxes, StationMotion, Stations};
