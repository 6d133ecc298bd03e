//! Offline generator.
pub mod mesh;
