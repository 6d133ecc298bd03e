//! Offline generator.
pub mod input;
pub mod mesh;
