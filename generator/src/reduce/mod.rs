//! From the finite elements to the reduced model: modes, then constant tensors.

pub mod damping;
pub mod internal_loads;
pub mod lagrangian;
mod missing;
mod missing_lines;
mod modal_mass;
pub mod modes;
pub mod residual;
mod second_forces;
pub mod sections;
pub mod tensors;
pub mod validity;
pub mod weight;

#[cfg(test)]
mod residual_tests;
#[cfg(test)]
mod tests;
