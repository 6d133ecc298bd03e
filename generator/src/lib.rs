//! Offline part of the tool: structure file -> mesh -> modes -> constant tensors -> contents of a model file.
//!
//! ```text
//! input::Structure --mesh()--> mesh::Mesh --build()--> rom_runtime::data::ModelData
//! ```

pub mod assembly;
pub mod build;
pub mod carrier;
pub mod configuration;
pub mod element;
pub mod equilibrium;
pub mod input;
pub mod linearise;
pub mod math;
pub mod mesh;
pub mod picture;
pub mod reduce;
pub mod reference;
pub mod section_probe;
pub mod solve;
#[cfg(test)]
pub(crate) mod test_structures;
pub mod vibration;

pub use build::{BuildError, BuildOptions, Elastic, Inertia, ModeSelection, Reduction, Stage};
pub use reduce::residual::ResidualSelection;
