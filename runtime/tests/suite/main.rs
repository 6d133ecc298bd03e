//! Tests of the runtime from outside, in one program: each of its own would compile and link the same again. What counts allocations
//! has to be alone (`tests/no_alloc.rs`).

#[path = "../common/mod.rs"]
mod common;

mod batch;
mod consistent;
mod convergence;
mod direct_loads;
mod equations;
mod heavy_top;
mod jacobian;
mod lagrangian_file;
mod methods;
#[cfg(feature = "std")]
mod model_file;
mod oscillator;
mod point_motion;
mod prescribed;
mod properties;
mod refusals;
mod rigid_body;
mod stations;
