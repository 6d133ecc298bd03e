//! The full finite-element dynamics that every reduced model is validated against.

pub mod anderson;
mod applied;
pub mod base;
mod bordered;
pub mod constant_mass;
pub mod damping;
pub mod external;
pub mod floating;
pub mod linear;
pub mod method;
pub mod motion;
mod nodal_system;
pub mod nonlinear;
mod nonlinear_error;
pub mod scheme;
pub mod start;

#[cfg(test)]
mod damping_tests;
#[cfg(test)]
mod gravity_tests;
#[cfg(test)]
mod output_tests;
#[cfg(test)]
mod tests;
