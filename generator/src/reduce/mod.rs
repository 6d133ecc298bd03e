//! From the finite elements to the reduced model: modes, then constant tensors.

pub mod damping;
pub mod lagrangian;
pub mod modes;
pub mod sections;
pub mod tensors;
pub mod weight;

#[cfg(test)]
mod tests;
