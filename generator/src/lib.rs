//! Offline generator.
#![allow(missing_docs)]
pub mod element;
pub mod math;
pub mod mesh;
