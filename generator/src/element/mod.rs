//! Geometrically exact beam elements: one quantity a file.
//!
//! An element interpolates positions with Lagrange polynomials and section rotations *relative to one of its own nodes*,
//! so that strains and velocities do not change when the whole body is rotated, whatever its attitude in A, and no
//! rotation vector ever approaches 2 pi ([`rotation_field`]).

pub mod beam;
pub mod gyroscopic;
pub mod inertia;
pub mod inertia_force;
pub mod inside;
pub mod internal_force;
pub(crate) mod kinematics;
mod lever;
pub mod rotation_field;
pub mod shape;
pub mod station;
pub mod viscous;
pub mod weight;

#[cfg(test)]
pub(crate) mod dual_reference;
#[cfg(test)]
pub(crate) mod tests;
