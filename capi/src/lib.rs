//! The runtime for C and C++: `include/rom.h` is made from this crate by cbindgen, `include/rom.hpp` wraps it.
//!
//! A thin skin: every function checks its pointers and sizes (`pointers.rs`), does its work through `rom-runtime`, and turns
//! errors and panics into a status and a text (`status.rs`). All mechanics is in the runtime.
//!
//! This crate and the FMU are the only ones with unsafe code; it is confined to turning the caller's pointers into
//! references, on the promises that the header makes the caller give.
#![allow(unsafe_code, non_camel_case_types)]
#![warn(clippy::undocumented_unsafe_blocks)]
// The header speaks of pointers as C does.
#![allow(clippy::missing_safety_doc)]

mod evaluator;
mod loads;
mod model;
mod outputs;
mod pointers;
mod sections;
mod simulation;
mod stations;
mod status;
mod version;

pub use evaluator::*;
pub use loads::*;
pub use model::*;
pub use outputs::*;
pub use sections::*;
pub use simulation::*;
pub use stations::*;
pub use status::{rom_last_error, rom_status, rom_status_text};
pub use version::*;
