//! From the finite elements to the reduced model: modes, then constant tensors.

pub mod modes;
pub mod sections;
pub mod tensors;

#[cfg(test)]
mod tests;
