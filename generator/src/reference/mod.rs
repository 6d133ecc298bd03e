//! The full finite-element dynamics that every reduced model is validated against.

pub mod external;
pub mod linear;
pub mod method;
pub mod motion;
pub mod nonlinear;
pub mod scheme;
