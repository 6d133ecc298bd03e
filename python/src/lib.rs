//! The native part of the Python package `romgen`. What users read is in `romgen/_core.pyi`.
//!
//! A thin layer: every class wraps one type of the runtime, arrays are copied at the boundary, and whatever takes longer than
//! a step runs with the interpreter lock released. Runs record the same channels under the same names as `romrun`.

mod arrays;
mod build;
mod errors;
mod jacobian;
mod linearise;
mod loads;
mod model;
mod outputs;
mod run;
mod simulation;
mod state;
mod stations;

use pyo3::prelude::*;

/// Native part of the package `romgen`.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    errors::register(module)?;
    module.add_class::<model::Model>()?;
    module.add_class::<state::State>()?;
    module.add_class::<state::StateRate>()?;
    module.add_class::<loads::LoadCase>()?;
    module.add_class::<loads::LoadSet>()?;
    module.add_class::<stations::Stations>()?;
    module.add_class::<stations::StationMotion>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<outputs::RigidOutput>()?;
    module.add_class::<outputs::PointOutput>()?;
    module.add_class::<outputs::PointMotion>()?;
    module.add_class::<outputs::SensorReading>()?;
    module.add_class::<outputs::Ledger>()?;
    module.add_class::<outputs::Reaction>()?;
    module.add_class::<jacobian::Jacobian>()?;
    module.add_class::<linearise::StateSpace>()?;
    module.add_function(wrap_pyfunction!(linearise::linearise, module)?)?;
    module.add_function(wrap_pyfunction!(build::build, module)?)?;
    module.add_function(wrap_pyfunction!(build::schema, module)?)?;
    Ok(())
}
