//! The simulation.

use pyo3::prelude::*;
use rom_runtime::{self as rom, Integrator, Loads, PreparedLoads, Settings};

use crate::arrays::{entries, finite};
use crate::errors;
use crate::loads::{LoadCase, LoadSet};
use crate::model::Model;
use crate::outputs::{Ledger, PointOutput, RigidOutput};
use crate::run::{self, Span};
use crate::state::State;

/// Marches one model.
#[pyclass(module = "romgen")]
pub(crate) struct Simulation {
    simulation: rom::Simulation,
    /// What acts where no loads are given.
    nothing: PreparedLoads,
}

/// The integrator of that name.
pub(crate) fn integrator(name: &str) -> PyResult<Integrator> {
    name.parse().map_err(|e| errors::value(format!("integrator {name:?}: {e}")))
}

/// Loads of a loaded equilibrium, and nothing else.
pub(crate) fn nothing(model: &rom::Model) -> PyResult<PreparedLoads> {
    let case = rom::LoadCase {
        name: "none".into(),
        description: String::new(),
        t_end: 1.0,
        dt: 1.0,
        numerical_damping: 0.0,
        loads: vec![],
    };
    model.prepare(&case).map_err(|e| errors::model(&e))
}

/// Calls `with` with the loads that a Python object stands for.
pub(crate) fn load<R>(
    model: &rom::Model,
    loads: Option<&Bound<'_, PyAny>>,
    with: impl FnOnce(&(dyn Loads + Send + Sync)) -> R,
) -> PyResult<R> {
    let Some(loads) = loads else { return Ok(with(&nothing(model)?)) };
    if let Ok(set) = loads.cast::<LoadSet>() {
        return Ok(with(&set.try_borrow()?.set));
    }
    if let Ok(case) = loads.cast::<LoadCase>() {
        return Ok(with(&case.get().prepared));
    }
    Err(errors::kind(format!("loads are a LoadCase, a LoadSet or None, not {}", loads.get_type().name()?)))
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (model, dt, *, integrator = "newmark", numerical_damping = 0.0, max_iterations = 40))]
    fn new(
        model: &Model,
        dt: f64,
        integrator: &str,
        numerical_damping: f64,
        max_iterations: u32,
    ) -> PyResult<Self> {
        let integrator = self::integrator(integrator)?;
        let settings = Settings { dt, integrator, numerical_damping, max_iterations };
        let simulation =
            rom::Simulation::new(model.model.clone(), settings).map_err(|e| errors::settings(&e))?;
        Ok(Self { simulation, nothing: nothing(&model.model)? })
    }

    #[getter]
    fn dt(&self) -> f64 {
        self.simulation.settings().dt
    }

    #[getter]
    fn integrator(&self) -> &'static str {
        self.simulation.settings().integrator.name()
    }

    #[getter]
    fn time(&self) -> f64 {
        self.simulation.state().time
    }

    #[getter]
    fn state(&self) -> State {
        State(self.simulation.state().clone())
    }

    #[setter]
    fn set_state(&mut self, state: &State) -> PyResult<()> {
        self.simulation.restore(&state.0).map_err(|e| errors::settings(&e))
    }

    #[pyo3(signature = (loads = None))]
    fn step(&mut self, loads: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let Self { simulation, nothing } = self;
        let made = match loads {
            None => simulation.step(nothing),
            some => load(&simulation.model().clone(), some, |loads| simulation.step(loads))?,
        };
        made.map_err(|e| errors::step(&e))
    }

    #[pyo3(signature = (loads = None, steps = None, *, t_end = None, every = 1, points = None))]
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        loads: Option<&Bound<'py, PyAny>>,
        steps: Option<u64>,
        t_end: Option<f64>,
        every: u64,
        points: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let state = self.simulation.state();
        let span = Span::new(state.time, self.simulation.settings().dt, steps, t_end, every)?;
        let points = run::points(self.simulation.model(), points)?;
        let Self { simulation, nothing } = self;
        // What is borrowed while the lock is released must not be changed meanwhile: a set is copied, a case is constant.
        match loads {
            None => run::constant(py, simulation, nothing, &span, points),
            Some(object) => {
                if let Ok(set) = object.cast::<LoadSet>() {
                    let set = set.try_borrow()?.set.clone();
                    run::constant(py, simulation, &set, &span, points)
                } else if let Ok(case) = object.cast::<LoadCase>() {
                    run::constant(py, simulation, &case.get().prepared, &span, points)
                } else {
                    Err(errors::kind("loads are a LoadCase, a LoadSet or None; arrays go to run_wrenches"))
                }
            }
        }
    }

    #[pyo3(signature = (loads, wrenches, *, every = 1, points = None))]
    fn run_wrenches<'py>(
        &mut self,
        py: Python<'py>,
        loads: &LoadSet,
        wrenches: &Bound<'py, PyAny>,
        every: u64,
        points: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let n_loaded = loads.width() / 6;
        let (values, shape) = entries("wrenches", wrenches, &[None, Some(n_loaded), Some(6)])?;
        finite("wrenches", &values)?;
        let state = self.simulation.state();
        let steps = shape.first().map(|&rows| rows as u64);
        let span = Span::new(state.time, self.simulation.settings().dt, steps, None, every)?;
        let points = run::points(self.simulation.model(), points)?;
        run::driven(py, &mut self.simulation, loads.clone(), &values, &span, points)
    }

    #[getter]
    fn rigid(&self) -> RigidOutput {
        RigidOutput(self.simulation.rigid_output())
    }

    fn point(&self, name: &str) -> PyResult<PointOutput> {
        let index = self.simulation.model().point(name).map_err(|e| errors::model(&e))?;
        let output = self.simulation.point_output(index);
        output.map(PointOutput).ok_or_else(|| errors::value(format!("no output at point {name}")))
    }

    #[getter]
    fn ledger(&self) -> Ledger {
        Ledger(self.simulation.ledger())
    }

    fn __repr__(&self) -> String {
        format!("Simulation(t={}, dt={}, integrator={:?})", self.time(), self.dt(), self.integrator())
    }
}
