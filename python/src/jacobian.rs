//! Derivatives of the equations of motion.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use rom_runtime as rom;

use crate::arrays::{matrix, vector};
use crate::errors;
use crate::simulation::load;

/// Exact derivatives of the equations of motion at a state, see :meth:`Simulation.jacobian` and :meth:`Model.jacobian`.
#[pyclass(module = "romgen")]
pub(crate) struct Jacobian(rom::Jacobian);

impl Jacobian {
    /// At a state under loads.
    pub(crate) fn new(
        model: &Arc<rom::Model>,
        state: &rom::State,
        loads: &(dyn rom::Loads + Send + Sync),
    ) -> PyResult<Self> {
        let mut jacobian = rom::Jacobian::new(Arc::clone(model));
        jacobian.evaluate(state, loads).map_err(|e| errors::step(&e))?;
        Ok(Self(jacobian))
    }

    /// At the state of a simulation.
    pub(crate) fn of(simulation: &rom::Simulation, loads: &(dyn rom::Loads + Send + Sync)) -> PyResult<Self> {
        let mut jacobian = rom::Jacobian::new(Arc::clone(simulation.model()));
        simulation.jacobian(loads, &mut jacobian).map_err(|e| errors::step(&e))?;
        Ok(Self(jacobian))
    }
}

#[pymethods]
impl Jacobian {
    /// Derivative of the rates of the states by the states - (n, n), n = 2 m + 12, in the order of :attr:`states`.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, self.0.matrix().to_vec(), self.0.size())
    }

    /// Names of the states: amplitudes ``q``, rates ``q_dot``, rigid part ``beta*`` of the velocity of A in A, small turn ``theta`` of A
    /// about its own axes, position ``r_G``. The rate of ``theta`` is relative to the motion at hand.
    #[getter]
    fn states(&self) -> Vec<String> {
        let numbers = &self.0.model().data().modes.number;
        let modal =
            ["q", "q_dot"].into_iter().flat_map(|name| numbers.iter().map(move |n| format!("{name}.{n}")));
        let rigid = ["v*", "w*", "theta", "r_G"];
        modal
            .chain(rigid.into_iter().flat_map(|name| ["x", "y", "z"].map(|axis| format!("{name}.{axis}"))))
            .collect()
    }

    /// Accelerations ``(q_ddot, beta*_dot)`` there - (m + 6).
    #[getter]
    fn accelerations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.0.accelerations())
    }

    /// Derivative of the rates of the states by a factor on these loads - (n): what they add. With a :class:`LoadSet` of one unit force it is
    /// the column of that force.
    fn by_load<'py>(
        &mut self,
        py: Python<'py>,
        loads: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut column = vec![0.0; self.0.size()];
        let model = Arc::clone(self.0.model());
        load(&model, Some(loads), |loads| self.0.by_load(loads, &mut column))?
            .map_err(|e| errors::step(&e))?;
        Ok(vector(py, &column))
    }
}
