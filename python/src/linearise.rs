//! Linear models.

use std::path::PathBuf;

use numpy::{Complex64, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rom_cli::linearise::Kind;
use rom_generator::linearise::{Channel, LineariseError, Request, StateSpace as Space};

use crate::arrays::{fixed, matrix, vector};
use crate::errors;
use crate::loads::LoadCase;
use crate::model::Model;

/// A linear state-space model, ``x_dot = A x + B u``, ``y = C x + D u``, see :func:`linearise`.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct StateSpace(Space);

type Matrix<'py> = PyResult<Bound<'py, PyArray2<f64>>>;

fn by_rows<'py>(py: Python<'py>, of: &nalgebra::DMatrix<f64>) -> Matrix<'py> {
    let rows = of.transpose().as_slice().to_vec();
    if of.ncols() == 0 || of.nrows() == 0 {
        return Ok(PyArray2::zeros(py, [of.nrows(), of.ncols()], false));
    }
    matrix(py, rows, of.ncols())
}

fn names(of: &[Channel]) -> Vec<String> {
    of.iter().map(|channel| channel.name.clone()).collect()
}

#[pymethods]
impl StateSpace {
    /// (states, states).
    #[getter]
    #[pyo3(name = "A")]
    fn a<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        by_rows(py, &self.0.a)
    }

    /// (states, inputs).
    #[getter]
    #[pyo3(name = "B")]
    fn b<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        by_rows(py, &self.0.b)
    }

    /// (outputs, states).
    #[getter]
    #[pyo3(name = "C")]
    fn c<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        by_rows(py, &self.0.c)
    }

    /// (outputs, inputs).
    #[getter]
    #[pyo3(name = "D")]
    fn d<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        by_rows(py, &self.0.d)
    }

    /// Names of the states.
    #[getter]
    fn states(&self) -> Vec<String> {
        names(&self.0.states)
    }

    /// Names of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        names(&self.0.inputs)
    }

    /// Names of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        names(&self.0.outputs)
    }

    /// Eigenvalues of ``A`` with all states, in ascending order of frequency - (n), complex.
    #[getter]
    fn poles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex64>> {
        let poles: Vec<Complex64> =
            self.0.poles.iter().map(|pole| Complex64::new(pole.re, pole.im)).collect();
        PyArray1::from_vec(py, poles)
    }

    /// The steady state: ``q``, ``velocity`` of A in A (v, w), ``attitude``, ``position``, changed ``factors``, the ``wrench`` that holds A
    /// (or None), and the ``residual`` accelerations relative to those of the loads.
    #[getter]
    fn steady<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (steady, out) = (&self.0.steady, PyDict::new(py));
        out.set_item("q", vector(py, &steady.q))?;
        out.set_item("velocity", vector(py, &steady.velocity))?;
        out.set_item("attitude", vector(py, &steady.attitude))?;
        out.set_item("position", vector(py, &steady.position))?;
        out.set_item(
            "factors",
            steady.factors.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
        )?;
        out.set_item("wrench", steady.wrench.map(|wrench| vector(py, &wrench)))?;
        out.set_item("residual", steady.residual)?;
        Ok(out)
    }

    /// Writes what the ending of the name says, as ``romgen linearise`` does: a MATLAB file ``.mat``, a plot of the poles ``.svg``, a page
    /// ``.html``; anything else is a NumPy archive.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let origin = rom_cli::linearise::Origin {
            name: "Structure".into(),
            command: "Python package romgen".into(),
            tool: concat!("romgen ", env!("CARGO_PKG_VERSION")).into(),
        };
        let kind = Kind::of(&path).unwrap_or(Kind::Npz);
        Ok(rom_cli::linearise::write(&self.0, &path, kind, &origin)?)
    }

    fn __repr__(&self) -> String {
        let Space { states, inputs, outputs, .. } = &self.0;
        format!("StateSpace({} states, {} inputs, {} outputs)", states.len(), inputs.len(), outputs.len())
    }
}

/// A linear model about the equilibrium, a load case or a steady rotation; see docs/linearise.md for states, inputs and outputs.
#[pyfunction]
#[pyo3(signature = (model, load_case = None, *, time = 0.0, velocity = None, rate = None, balance = vec![], hold = false,
    inputs = None, outputs = None, reduce = false))]
#[allow(clippy::too_many_arguments)] // keywords in Python
pub(crate) fn linearise(
    py: Python<'_>,
    model: &Model,
    load_case: Option<&LoadCase>,
    time: f64,
    velocity: Option<&Bound<'_, PyAny>>,
    rate: Option<&Bound<'_, PyAny>>,
    balance: Vec<String>,
    hold: bool,
    inputs: Option<Vec<String>>,
    outputs: Option<Vec<String>>,
    reduce: bool,
) -> PyResult<StateSpace> {
    let request = Request {
        time,
        velocity: velocity.map(|v| fixed("velocity", v)).transpose()?,
        rate: rate.map(|w| fixed("rate", w)).transpose()?,
        balance,
        hold,
        inputs,
        outputs,
        reduce,
        ..load_case.map_or_else(Request::of_equilibrium, |case| Request::new(case.case.clone()))
    };
    let model = model.model.clone();
    py.detach(|| rom_generator::linearise::linearise(&model, &request)).map(StateSpace).map_err(|e| match e {
        LineariseError::Model(e) => errors::model(&e),
        LineariseError::Step(e) => errors::step(&e),
        LineariseError::Unknown { .. } => errors::missing(e.to_string()),
        LineariseError::Value { .. } => errors::value(e.to_string()),
        other => errors::unsteady(other.to_string()),
    })
}
