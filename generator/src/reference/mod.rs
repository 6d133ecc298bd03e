//! The full finite-element dynamics that every reduced model is validated against.

pub mod anderson;
pub mod constant_mass;
pub mod external;
pub mod floating;
pub mod linear;
pub mod method;
pub mod motion;
pub mod nonlinear;
pub mod scheme;
pub mod start;

#[cfg(test)]
mod gravity_tests;
#[cfg(test)]
mod tests;
