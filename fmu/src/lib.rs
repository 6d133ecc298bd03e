//! A reduced model as a functional mock-up unit for co-simulation, FMI 2.0 and 3.0.
//!
//! The library in every FMU is the same: it reads `resources/model.rom` and derives the variables from it
//! ([`variables`]), as does the description that `romgen export` writes beside it ([`description`]). An [`instance`] is a
//! simulation with the parameters and inputs of FMI; `interface` turns it into the functions of both standards.
//!
//! This crate and the C interface are the only ones with unsafe code; here it is confined to `interface`.

mod derivatives;
pub mod description;
pub mod instance;
pub mod interface;
pub mod parameters;
mod run;
pub mod snapshot;
pub mod token;
pub mod variables;
mod xml;

/// File of the model in the resources of an FMU.
pub const MODEL_FILE: &str = "model.rom";

/// File of the blocks of stations among the variables, beside the model: their indices, one a line. Missing where there are none.
pub const STATIONS_FILE: &str = "stations.txt";
