//! What is read from a state.

use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays::vector;

type Array<'py> = Bound<'py, PyArray1<f64>>;

/// Motion of frame A.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct RigidOutput(pub(crate) rom_runtime::RigidOutput);

#[pymethods]
#[allow(non_snake_case)] // components in G and A, as in the result files
impl RigidOutput {
    #[getter]
    fn r_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.r_g)
    }

    #[getter]
    fn v_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.v_g)
    }

    #[getter]
    fn w_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.w_g)
    }

    #[getter]
    fn v_A<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.v_a)
    }

    #[getter]
    fn w_A<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.w_a)
    }

    #[getter]
    fn zeta<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.zeta)
    }

    fn __repr__(&self) -> String {
        let o = &self.0;
        format!("RigidOutput(r_G={:?}, v_G={:?}, w_G={:?}, zeta={:?})", o.r_g, o.v_g, o.w_g, o.zeta)
    }
}

/// Where a named point is.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct PointOutput(pub(crate) rom_runtime::PointOutput);

#[pymethods]
#[allow(non_snake_case)] // components in G and A, as in the result files
impl PointOutput {
    #[getter]
    fn dR_A<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.dr_a)
    }

    #[getter]
    fn R_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.r_g)
    }

    fn __repr__(&self) -> String {
        format!("PointOutput(dR_A={:?}, R_G={:?})", self.0.dr_a, self.0.r_g)
    }
}

/// Centre of mass, momenta, energies.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct Ledger(pub(crate) rom_runtime::Ledger);

#[pymethods]
#[allow(non_snake_case)] // components in G, as in the result files
impl Ledger {
    #[getter]
    fn r_CM_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.r_cm_g)
    }

    #[getter]
    fn p_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.linear_momentum_g)
    }

    #[getter]
    fn L_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.angular_momentum_g)
    }

    #[getter]
    fn E_kin(&self) -> f64 {
        self.0.kinetic_energy
    }

    #[getter]
    fn E_el(&self) -> f64 {
        self.0.elastic_energy
    }

    fn __repr__(&self) -> String {
        let o = &self.0;
        format!(
            "Ledger(r_CM_G={:?}, p_G={:?}, L_G={:?}, E_kin={}, E_el={})",
            o.r_cm_g, o.linear_momentum_g, o.angular_momentum_g, o.kinetic_energy, o.elastic_energy
        )
    }
}
