//! The model.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rom_generator::input::{self, PointTable};
use rom_runtime::{self as rom, Method};

use crate::arrays::{matrix, vector};
use crate::build::assignments;
use crate::errors;
use crate::jacobian::Jacobian;
use crate::loads::{LoadCase, LoadSet};
use crate::outputs::{Ledger, PointOutput, RigidOutput};
use crate::simulation::load;
use crate::state::{State, StateRate};

/// A reduced model: constant, to be shared by any number of simulations and threads. Can be pickled.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct Model {
    pub(crate) model: Arc<rom::Model>,
    /// The model of the file where `model` is simplified from it.
    file: Arc<rom::Model>,
}

impl Model {
    pub(crate) fn new(model: rom::Model) -> Self {
        let model = Arc::new(model);
        Self { file: Arc::clone(&model), model }
    }
}

#[pymethods]
impl Model {
    /// Reads a model file, or the bytes of one.
    #[staticmethod]
    fn load(py: Python<'_>, source: &Bound<'_, PyAny>) -> PyResult<Self> {
        let read = if let Ok(bytes) = source.cast::<PyBytes>() {
            rom::Model::from_bytes(bytes.as_bytes())
        } else {
            let path: PathBuf =
                source.extract().map_err(|_| errors::kind("a model is loaded from a path or from bytes"))?;
            py.detach(|| rom::Model::read_path(path))
        };
        read.map(Self::new).map_err(|e| errors::format(&e))
    }

    /// Writes the model file; whoever opens it sees the old one or the whole new one.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.file.write_path(path).map_err(|e| errors::format(&e))
    }

    /// Contents of the model file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.file.to_bytes().map_err(|e| errors::format(&e))?))
    }

    /// The same body by a simpler method (``"mean-axes"``, ``"rigid"``), or by the full one again (``"rom"``).
    fn with_method(&self, method: &str) -> PyResult<Self> {
        let method: Method = method.parse().map_err(|e| errors::value(format!("method {method:?}: {e}")))?;
        let model = self.file.with_method(method).map_err(|e| errors::model(&e))?;
        Ok(Self { model: Arc::new(model), file: Arc::clone(&self.file) })
    }

    /// Name of the structure.
    #[getter]
    fn name(&self) -> &str {
        &self.model.data().provenance.name
    }

    /// How the equations are simplified.
    #[getter]
    fn method(&self) -> &'static str {
        self.model.method().name()
    }

    /// Number of elastic modes m.
    #[getter]
    fn n_modes(&self) -> usize {
        self.model.n_modes()
    }

    /// Names of points.
    #[getter]
    fn points(&self) -> Vec<&str> {
        self.model.data().points.iter().map(|point| point.name.as_str()).collect()
    }

    /// Names of load cases.
    #[getter]
    fn load_cases(&self) -> Vec<&str> {
        self.model.data().load_cases.iter().map(|case| case.name.as_str()).collect()
    }

    /// Parameters of the structure.
    #[getter]
    fn parameters(&self) -> std::collections::BTreeMap<&str, f64> {
        self.model.data().provenance.parameters.iter().map(|(name, value)| (name.as_str(), *value)).collect()
    }

    /// The structure file, verbatim.
    #[getter]
    fn structure_text(&self) -> &str {
        &self.model.data().provenance.input_text
    }

    /// Checks that the generator made: (what, value, limit).
    #[getter]
    fn checks(&self) -> Vec<(&str, f64, f64)> {
        self.model.data().checks.iter().map(|c| (c.name.as_str(), c.value, c.limit)).collect()
    }

    /// Numbers of the modes in the structure's list of elastic modes, from 1 - (m).
    #[getter]
    fn mode_numbers(&self) -> Vec<u32> {
        self.model.data().modes.number.clone()
    }

    /// Circular frequencies, rad/s - (m).
    #[getter]
    fn omega<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.model.data().modes.omega)
    }

    /// Critical damping ratios, 1 - (m).
    #[getter]
    fn damping_ratio<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.model.data().modes.damping_ratio)
    }

    /// Total mass, kg.
    #[getter]
    fn mass(&self) -> f64 {
        self.model.data().rigid.mass
    }

    /// Centre of mass in A, m - (3).
    #[getter]
    fn centre_of_mass<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.model.data().rigid.centre_of_mass)
    }

    /// Rigid mass matrix about the origin of A: kg, kg m, kg m^2 - (6, 6), v then w.
    #[getter]
    fn mass_matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, self.model.data().rigid.mass_matrix.clone(), 6)
    }

    /// Inertia about the origin of A with the modes free to respond - (6, 6): what a sudden acceleration meets.
    #[getter]
    fn apparent_inertia<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let inertia = self.model.apparent_inertia().map_err(|e| crate::errors::step(&e))?;
        matrix(py, inertia.as_flattened().to_vec(), 6)
    }

    /// Acceleration of free fall in G, under which the model is marched, m/s^2 - (3): zero in weightlessness.
    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.model.gravity())
    }

    /// What acts in the equilibrium that the model is about, and nothing else: the loads in balance there, to which those of a
    /// :class:`LoadSet` are added where this is its ``case``.
    #[getter]
    fn equilibrium(&self) -> PyResult<LoadCase> {
        LoadCase::new(&self.model, rom::LoadCase::empty("equilibrium"))
    }

    /// Names of inertial sensors.
    #[getter]
    fn sensors(&self) -> Vec<String> {
        self.model.data().sensors.iter().map(|sensor| sensor.name.clone()).collect()
    }

    /// Names of blocks of stations; see :class:`Stations`.
    #[getter]
    fn stations(&self) -> Vec<&str> {
        self.model.data().stations.iter().map(|block| block.name.as_str()).collect()
    }

    /// Longest stable time step of the oscillators, s; None without limit.
    fn stable_dt(&self, integrator: &str) -> PyResult<Option<f64>> {
        Ok(crate::simulation::integrator(integrator)?.stable_dt(&self.model).map(|limit| limit.dt))
    }

    /// A load case of the model, ready to be stepped with.
    fn load_case(&self, name: &str) -> PyResult<LoadCase> {
        let case = self.model.load_case(name).map_err(|e| errors::model(&e))?;
        LoadCase::new(&self.model, case.clone())
    }

    /// Load cases of a file of their own (path, text or dict); ``parameters`` gives its parameters other values.
    #[pyo3(signature = (source, parameters = None))]
    fn read_load_cases(
        &self,
        source: &Bound<'_, PyAny>,
        parameters: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Vec<LoadCase>> {
        let (text, name) = crate::build::text(source)?;
        let data = self.model.data();
        let table = PointTable::new(&data.points, &data.lines, &data.provenance.parameters);
        let cases = input::read_load_cases(&text, &name, &table, &assignments(parameters)?);
        let cases = cases.map_err(|e| errors::input(&e))?;
        cases.into_iter().map(|case| LoadCase::new(&self.model, case)).collect()
    }

    /// Wrenches on these points, to be set from step to step; see :class:`LoadSet`.
    #[pyo3(signature = (points, frame = "body", member = None, case = None, stations = vec![]))]
    fn load_set(
        &self,
        points: Vec<String>,
        frame: &str,
        member: Option<&str>,
        case: Option<&LoadCase>,
        stations: Vec<String>,
    ) -> PyResult<LoadSet> {
        LoadSet::from_points(&self.model, &points, frame, member, case, &stations)
    }

    /// Right-hand side of the equations of motion, for hosts that integrate themselves.
    #[pyo3(signature = (state, loads = None))]
    fn derivatives(&self, state: &State, loads: Option<&Bound<'_, PyAny>>) -> PyResult<StateRate> {
        state.0.check(&self.model).map_err(|e| errors::settings(&e))?;
        let (mut work, mut rate) = (rom::Workspace::new(&self.model), rom::StateRate::new(&self.model));
        load(&self.model, loads, |loads| self.model.derivatives(&state.0, loads, &mut work, &mut rate))?
            .map_err(|e| errors::step(&e))?;
        Ok(StateRate(rate))
    }

    /// Exact derivatives of the equations of motion at a state, see :class:`Jacobian`.
    #[pyo3(signature = (state, loads = None))]
    fn jacobian(&self, state: &State, loads: Option<&Bound<'_, PyAny>>) -> PyResult<Jacobian> {
        state.0.check(&self.model).map_err(|e| errors::settings(&e))?;
        load(&self.model, loads, |loads| Jacobian::new(&self.model, &state.0, loads))?
    }

    /// True velocity of A in A, ``Phi_R q_dot + beta_star``: (v, w), m/s and rad/s - (6).
    fn velocity<'py>(&self, py: Python<'py>, state: &State) -> PyResult<Bound<'py, PyArray1<f64>>> {
        state.0.check(&self.model).map_err(|e| errors::settings(&e))?;
        Ok(vector(py, &self.model.velocity(&state.0)))
    }

    /// Motion of frame A.
    fn rigid_output(&self, state: &State) -> PyResult<RigidOutput> {
        state.0.check(&self.model).map_err(|e| errors::settings(&e))?;
        Ok(RigidOutput(self.model.rigid_output(&state.0)))
    }

    /// Where a named point is.
    fn point_output(&self, state: &State, point: &str) -> PyResult<PointOutput> {
        state.0.check(&self.model).map_err(|e| errors::settings(&e))?;
        let index = self.model.point(point).map_err(|e| errors::model(&e))?;
        let output = self.model.point_output(&state.0, index);
        output.map(PointOutput).ok_or_else(|| errors::value(format!("no output at point {point}")))
    }

    /// Centre of mass, momenta and energies.
    fn ledger(&self, state: &State) -> PyResult<Ledger> {
        state.0.check(&self.model).map_err(|e| errors::settings(&e))?;
        Ok(Ledger(self.model.ledger(&state.0)))
    }

    fn __repr__(&self) -> String {
        format!("Model({:?}, {} modes, method {:?})", self.name(), self.n_modes(), self.method())
    }

    #[staticmethod]
    fn _unpickle(bytes: &[u8], method: &str) -> PyResult<Self> {
        let model = rom::Model::from_bytes(bytes).map_err(|e| errors::format(&e))?;
        Self::new(model).with_method(method)
    }

    #[allow(clippy::type_complexity)] // the shape that pickle asks for
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>, &'static str))> {
        Ok((py.get_type::<Self>().getattr("_unpickle")?, (self.to_bytes(py)?, self.method())))
    }
}
