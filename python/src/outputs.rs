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
    /// Position of the origin of A in G, m - (3).
    #[getter]
    fn r_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.r_g)
    }

    /// Its velocity, components in G, m/s - (3).
    #[getter]
    fn v_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.v_g)
    }

    /// Angular velocity of A, components in G, rad/s - (3).
    #[getter]
    fn w_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.w_g)
    }

    /// Velocity of the origin, components in A, m/s - (3).
    #[getter]
    fn v_A<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.v_a)
    }

    /// Angular velocity, components in A, rad/s - (3).
    #[getter]
    fn w_A<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.w_a)
    }

    /// Attitude quaternion, scalar first, A to G - (4).
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
    /// Displacement from the equilibrium in A, m - (3).
    #[getter]
    fn dR_A<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.dr_a)
    }

    /// Position in G, m - (3).
    #[getter]
    fn R_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.r_g)
    }

    fn __repr__(&self) -> String {
        format!("PointOutput(dR_A={:?}, R_G={:?})", self.0.dr_a, self.0.r_g)
    }
}

/// How a named point moves, seen from G.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct PointMotion(pub(crate) rom_runtime::PointMotion);

#[pymethods]
#[allow(non_snake_case)] // components in G, as in the result files
impl PointMotion {
    /// Attitude quaternion of the node's axes, scalar first, node to G - (4).
    #[getter]
    fn zeta<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.attitude)
    }

    /// Velocity in G, m/s - (3).
    #[getter]
    fn v_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.v_g)
    }

    /// Angular velocity in G, rad/s - (3).
    #[getter]
    fn w_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.w_g)
    }

    /// Acceleration in G, m/s^2 - (3).
    #[getter]
    fn a_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.a_g)
    }

    /// Angular acceleration in G, rad/s^2 - (3).
    #[getter]
    fn alpha_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.alpha_g)
    }

    fn __repr__(&self) -> String {
        let o = &self.0;
        format!(
            "PointMotion(zeta={:?}, v_G={:?}, w_G={:?}, a_G={:?}, alpha_G={:?})",
            o.attitude, o.v_g, o.w_g, o.a_g, o.alpha_g
        )
    }
}

/// What an inertial sensor reads, in its own axes.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct SensorReading(pub(crate) rom_runtime::SensorReading);

#[pymethods]
impl SensorReading {
    /// Acceleration, less that of free fall where the sensor feels gravity, m/s^2 - (3).
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.a)
    }

    /// Angular velocity, rad/s - (3).
    #[getter]
    fn w<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.w)
    }

    /// Angular acceleration, rad/s^2 - (3).
    #[getter]
    fn alpha<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.alpha)
    }

    fn __repr__(&self) -> String {
        format!("SensorReading(a={:?}, w={:?}, alpha={:?})", self.0.a, self.0.w, self.0.alpha)
    }
}

/// Quantities whose balance tells whether a result can be trusted.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct Ledger(pub(crate) rom_runtime::Ledger);

#[pymethods]
#[allow(non_snake_case)] // components in G, as in the result files
impl Ledger {
    /// Centre of mass in G, m - (3).
    #[getter]
    fn r_CM_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.r_cm_g)
    }

    /// Linear momentum in G, kg m/s - (3).
    #[getter]
    fn p_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.linear_momentum_g)
    }

    /// Angular momentum about the origin of G, kg m^2/s - (3).
    #[getter]
    fn L_G<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.angular_momentum_g)
    }

    /// Kinetic energy, J.
    #[getter]
    fn E_kin(&self) -> f64 {
        self.0.kinetic_energy
    }

    /// Elastic energy of the kept modes, J.
    #[getter]
    fn E_el(&self) -> f64 {
        self.0.elastic_energy
    }

    /// Potential energy in the field of gravity, zero with the centre of mass at the origin of G, J.
    #[getter]
    fn E_grav(&self) -> f64 {
        self.0.gravity_energy
    }

    fn __repr__(&self) -> String {
        let o = &self.0;
        format!(
            "Ledger(r_CM_G={:?}, p_G={:?}, L_G={:?}, E_kin={}, E_el={}, E_grav={})",
            o.r_cm_g,
            o.linear_momentum_g,
            o.angular_momentum_g,
            o.kinetic_energy,
            o.elastic_energy,
            o.gravity_energy
        )
    }
}

/// What the body does to a host that moves its frame A: wrenches about the origin of A, axes of A, on the host.
///
/// A host that carries mass and inertia of the undeformed body applies ``loads + increment``, one that applies the loads
/// itself too the ``increment`` alone, one without inertia of the body the ``total``.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct Reaction(pub(crate) rom_runtime::Reaction);

#[pymethods]
impl Reaction {
    /// Inertia of the undeformed body, -(M_RR beta_dot + C_RR(beta) beta), N and N m - (6).
    #[getter]
    fn inertia<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.inertia)
    }

    /// Resultant of the loads at the deformed points, N and N m - (6).
    #[getter]
    fn loads<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.loads)
    }

    /// What elasticity adds, N and N m - (6).
    #[getter]
    fn increment<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.increment)
    }

    /// Sum of the three, zero in free flight - (6).
    #[getter]
    fn total<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.total())
    }

    fn __repr__(&self) -> String {
        let o = &self.0;
        format!("Reaction(inertia={:?}, loads={:?}, increment={:?})", o.inertia, o.loads, o.increment)
    }
}
