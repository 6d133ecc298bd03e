//! Files for ParaView and other readers of VTK: lines along the members with fields on their nodes.
//!
//! A run is one unstructured grid (`.vtu`) per frame and a collection (`.pvd`) that says when each is; the modes of a model are one
//! grid. Numbers are binary (base64 of little-endian IEEE 754), positions and vectors in SI units.

mod grid;
mod run;
mod sections;

pub use grid::{Field, Grid};
pub use run::{FRAMES, write_film, write_modes, write_run};
pub use sections::{Along, Place};

#[cfg(test)]
mod tests;
