//! Offline generator.
#![allow(missing_docs)]
pub mod assembly;
pub mod build;
pub mod configuration;
pub mod element;
pub mod input;
pub mod math;
pub mod mesh;
pub mod reduce;
pub mod solve;
#[cfg(test)]
pub(crate) mod test_structures;
