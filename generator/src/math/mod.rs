//! Rotations: the only mathematics this crate writes itself.

pub mod so3;
pub mod stumpff;
