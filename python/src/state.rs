//! State and its rate.

use numpy::PyArray1;
use pyo3::prelude::*;
use rom_runtime as rom;

use crate::arrays::{entries, finite, fixed, vector};
use crate::errors;
use crate::model::Model;

type Array<'py> = Bound<'py, PyArray1<f64>>;

/// Everything of a state but its model, for pickles: time and its carry, q, q_dot, beta_star, attitude, position, u_dot,
/// algorithmic, whether accelerations are known.
type Parts = (f64, f64, Vec<f64>, Vec<f64>, [f64; 6], [f64; 4], [f64; 3], Vec<f64>, Vec<f64>, bool);

/// Everything that changes while a model is marched. Plain data: copy it to take a snapshot; can be pickled.
///
/// A new one is at rest and undeformed at t = 0, A along G with its origin where the model says. Changing a part by hand
/// makes the next step solve the accelerations anew.
#[pyclass(module = "romgen")]
#[derive(Clone)]
pub(crate) struct State(pub(crate) rom::State);

impl State {
    /// Takes new physical values: accelerations are solved anew by the next step.
    fn set(
        &mut self,
        what: &str,
        values: &Bound<'_, PyAny>,
        of: impl Fn(&mut rom::State) -> &mut [f64],
    ) -> PyResult<()> {
        let to = of(&mut self.0);
        let (values, _) = entries(what, values, &[Some(to.len())])?;
        finite(what, &values)?;
        to.copy_from_slice(&values);
        self.0.accelerations_known = false;
        Ok(())
    }
}

#[pymethods]
impl State {
    #[new]
    fn new(model: &Model) -> Self {
        Self(rom::State::at_rest(&model.model))
    }

    /// Time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    #[setter]
    fn set_time(&mut self, time: f64) -> PyResult<()> {
        finite("time", &[time])?;
        (self.0.time, self.0.time_carry) = (time, 0.0);
        self.0.accelerations_known = false;
        Ok(())
    }

    /// Modal amplitudes - (m).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.q)
    }

    #[setter]
    fn set_q(&mut self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set("q", values, |state| &mut state.q)
    }

    /// Modal rates, 1/s - (m).
    #[getter]
    fn q_dot<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.q_dot)
    }

    #[setter]
    fn set_q_dot(&mut self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set("q_dot", values, |state| &mut state.q_dot)
    }

    /// Rigid part of the velocity of A, in A: v* (m/s), w* (rad/s) - (6). The true one is :meth:`Model.velocity`.
    #[getter]
    fn beta_star<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.beta_star)
    }

    #[setter]
    fn set_beta_star(&mut self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set("beta_star", values, |state| &mut state.beta_star)
    }

    /// Quaternion, scalar first, turns components in A into components in G - (4). Scaled to unit length when set.
    #[getter]
    fn attitude<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.attitude)
    }

    /// Scaled to unit length.
    #[setter]
    fn set_attitude(&mut self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        let zeta: [f64; 4] = fixed("attitude", values)?;
        let norm = zeta.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(norm.is_finite() && norm > 0.0) {
            return Err(errors::value(format!(
                "attitude {zeta:?} is no rotation, expected a quaternion, scalar first"
            )));
        }
        self.0.attitude = zeta.map(|x| x / norm);
        self.0.accelerations_known = false;
        Ok(())
    }

    /// Position of the origin of A in G, m - (3).
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.position)
    }

    #[setter]
    fn set_position(&mut self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set("position", values, |state| &mut state.position)
    }

    /// Accelerations (q_ddot, beta_star_dot), valid where ``accelerations_known`` - (m + 6).
    #[getter]
    fn u_dot<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.u_dot)
    }

    /// Whether ``u_dot`` belongs to the rest of the state.
    #[getter]
    fn accelerations_known(&self) -> bool {
        self.0.accelerations_known
    }

    /// A snapshot; stepping on from it gives the same bits.
    fn copy(&self) -> Self {
        self.clone()
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.clone()
    }

    fn __eq__(&self, other: &State) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        format!("State(time={}, position={:?}, attitude={:?})", self.0.time, self.0.position, self.0.attitude)
    }

    #[staticmethod]
    fn _from_parts(parts: Parts) -> Self {
        let (
            time,
            time_carry,
            q,
            q_dot,
            beta_star,
            attitude,
            position,
            u_dot,
            algorithmic,
            accelerations_known,
        ) = parts;
        Self(rom::State {
            time,
            time_carry,
            q,
            q_dot,
            beta_star,
            attitude,
            position,
            u_dot,
            algorithmic,
            accelerations_known,
        })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Parts,))> {
        let s = self.0.clone();
        let parts = (
            s.time,
            s.time_carry,
            s.q,
            s.q_dot,
            s.beta_star,
            s.attitude,
            s.position,
            s.u_dot,
            s.algorithmic,
            s.accelerations_known,
        );
        Ok((py.get_type::<Self>().getattr("_from_parts")?, (parts,)))
    }
}

/// Time derivative of a state.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct StateRate(pub(crate) rom::StateRate);

#[pymethods]
impl StateRate {
    /// Modal rates, 1/s - (m).
    #[getter]
    fn q_dot<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.q_dot)
    }

    /// (q_ddot, beta_star_dot): 1/s^2, m/s^2, rad/s^2 - (m + 6).
    #[getter]
    fn u_dot<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.u_dot)
    }

    /// Rate of the quaternion, 1/s - (4).
    #[getter]
    fn attitude_dot<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.attitude_dot)
    }

    /// Velocity of the origin of A in G, m/s - (3).
    #[getter]
    fn position_dot<'py>(&self, py: Python<'py>) -> Array<'py> {
        vector(py, &self.0.position_dot)
    }

    fn __repr__(&self) -> String {
        format!("StateRate(u_dot={:?})", self.0.u_dot)
    }
}
