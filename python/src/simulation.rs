//! The simulation.

use std::collections::BTreeMap;

use numpy::PyArray1;
use pyo3::prelude::*;
use rom_runtime::{self as rom, Integrator, Loads, PreparedLoads, PrescribedMotion, Settings};

use crate::arrays::{entries, finite, fixed, vector};
use crate::errors;
use crate::jacobian::Jacobian;
use crate::loads::{LoadCase, LoadSet};
use crate::model::Model;
use crate::outputs::{Ledger, PointMotion, PointOutput, Reaction, RigidOutput, SensorReading};
use crate::run::{self, Span};
use crate::state::State;

/// Marches one model from rest at t = 0, or from any state given to :attr:`state`.
///
/// Args:
///     dt: time step, s.
///     integrator: ``"newmark"`` and ``"gen-alpha"`` are implicit, ``"rk4"`` explicit (see :meth:`Model.stable_dt`);
///         ``"energy-momentum"`` keeps the energy of models with consistent inertia.
///     numerical_damping: of the implicit ones, 0 to 1.
///     max_iterations: most iterations of an implicit step, 1 to 1000.
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
    let case = rom::LoadCase::empty("none");
    model.prepare(&case).map_err(|e| errors::model(&e))
}

impl Simulation {
    /// The state now.
    pub(crate) fn now(&self) -> &rom::State {
        self.simulation.state()
    }

    /// Solves the accelerations where the last step left none behind.
    fn know(&mut self, loads: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let Self { simulation, nothing } = self;
        let solved = match loads {
            None => simulation.solve_accelerations(nothing),
            some => load(&simulation.model().clone(), some, |loads| simulation.solve_accelerations(loads))?,
        };
        solved.map_err(|e| errors::step(&e))
    }
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

fn motion(
    velocity: &Bound<'_, PyAny>,
    rate: &Bound<'_, PyAny>,
    attitude: &Bound<'_, PyAny>,
    position: &Bound<'_, PyAny>,
) -> PyResult<PrescribedMotion> {
    Ok(PrescribedMotion {
        velocity: fixed("velocity", velocity)?,
        rate: fixed("rate", rate)?,
        attitude: fixed("attitude", attitude)?,
        position: fixed("position", position)?,
    })
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

    /// Time step, s.
    #[getter]
    fn dt(&self) -> f64 {
        self.simulation.settings().dt
    }

    /// Its name.
    #[getter]
    fn integrator(&self) -> &'static str {
        self.simulation.settings().integrator.name()
    }

    /// Estimates errors from now on, looking at the motion every so many steps; 0 turns it off.
    #[pyo3(signature = (every = 4))]
    fn watch_errors(&mut self, every: u32) {
        self.simulation.watch_errors(every);
    }

    /// Estimated relative errors of the run so far, as a validation measures them, and the use made of the range of the model
    /// (1: terms left out reach a tenth): ``{"indicator", "v_G", "w_G", "dR_A", "amplitude", "rate"}``. None unless errors
    /// are watched (:meth:`watch_errors`).
    #[getter]
    fn error_estimate(&self) -> Option<BTreeMap<&'static str, f64>> {
        let found = self.simulation.error_estimate()?;
        let values = [
            ("indicator", found.indicator()),
            ("v_G", found.v_g),
            ("w_G", found.w_g),
            ("dR_A", found.dr_a),
            ("amplitude", found.amplitude),
            ("rate", found.rate),
        ];
        Some(BTreeMap::from(values))
    }

    /// Time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.simulation.state().time
    }

    /// Acceleration of free fall in G, m/s^2 - (3). It begins as that of the model and may be set at any time; it is no part of the
    /// state.
    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.simulation.gravity())
    }

    #[setter]
    fn set_gravity(&mut self, acceleration: &Bound<'_, PyAny>) -> PyResult<()> {
        let acceleration = fixed("gravity", acceleration)?;
        self.simulation.set_gravity(acceleration).map_err(|e| errors::settings(&e))
    }

    /// A copy of the state; set it to go on from a snapshot or from initial conditions.
    #[getter]
    fn state(&self) -> State {
        State(self.simulation.state().clone())
    }

    #[setter]
    fn set_state(&mut self, state: &State) -> PyResult<()> {
        self.simulation.restore(&state.0).map_err(|e| errors::settings(&e))
    }

    /// One time step; without loads those of a loaded equilibrium act alone.
    #[pyo3(signature = (loads = None))]
    fn step(&mut self, loads: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let Self { simulation, nothing } = self;
        let made = match loads {
            None => simulation.step(nothing),
            some => load(&simulation.model().clone(), some, |loads| simulation.step(loads))?,
        };
        made.map_err(|e| errors::step(&e))
    }

    /// So many steps, or steps up to ``t_end`` (s), without the interpreter lock.
    ///
    /// The first row recorded is the state now. ``every`` records every so many steps, and the last; ``points`` names
    /// the points to record, by default all. Raises :class:`StepError` with what was recorded in ``results``.
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

    /// One step for every row of wrenches - (steps, points of ``loads``, 6) - in the frames of ``loads``.
    ///
    /// The set itself is not changed. Otherwise as :meth:`run`.
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

    /// Begins a motion of frame A that the host prescribes, at the present time.
    ///
    /// Args:
    ///     velocity: (v_A, w_A) of A in its own axes, m/s and rad/s - (6).
    ///     rate: derivative of these components - (6); the inertial acceleration is ``v_A_dot + w_A x v_A``.
    ///     attitude: unit quaternion, scalar first, A to G - (4).
    ///     position: of the origin of A in G, m - (3).
    #[pyo3(signature = (loads, *, velocity, rate, attitude, position))]
    fn prescribe(
        &mut self,
        loads: Option<&Bound<'_, PyAny>>,
        velocity: &Bound<'_, PyAny>,
        rate: &Bound<'_, PyAny>,
        attitude: &Bound<'_, PyAny>,
        position: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let motion = motion(velocity, rate, attitude, position)?;
        let Self { simulation, .. } = self;
        load(&simulation.model().clone(), loads, |loads| simulation.prescribe(loads, &motion))?
            .map_err(|e| errors::step(&e))
    }

    /// One step in which the host moves frame A, to this motion at its end; see :attr:`reaction`.
    #[pyo3(signature = (loads, *, velocity, rate, attitude, position))]
    fn step_prescribed(
        &mut self,
        loads: Option<&Bound<'_, PyAny>>,
        velocity: &Bound<'_, PyAny>,
        rate: &Bound<'_, PyAny>,
        attitude: &Bound<'_, PyAny>,
        position: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let motion = motion(velocity, rate, attitude, position)?;
        let Self { simulation, .. } = self;
        load(&simulation.model().clone(), loads, |loads| simulation.step_prescribed(loads, &motion))?
            .map_err(|e| errors::step(&e))
    }

    /// What the body does to the host at the end of the last prescribed step; None in free flight.
    #[getter]
    fn reaction(&self) -> Option<Reaction> {
        self.simulation.reaction().map(Reaction)
    }

    /// Exact derivatives of the equations of motion at the present state, see :class:`Jacobian`.
    #[pyo3(signature = (loads = None))]
    fn jacobian(&self, loads: Option<&Bound<'_, PyAny>>) -> PyResult<Jacobian> {
        let Self { simulation, nothing } = self;
        match loads {
            None => Jacobian::of(simulation, nothing),
            some => load(&simulation.model().clone(), some, |loads| Jacobian::of(simulation, loads))?,
        }
    }

    /// Motion of frame A.
    #[getter]
    fn rigid(&self) -> RigidOutput {
        RigidOutput(self.simulation.rigid_output())
    }

    /// Where a named point is.
    fn point(&self, name: &str) -> PyResult<PointOutput> {
        let index = self.simulation.model().point(name).map_err(|e| errors::model(&e))?;
        let output = self.simulation.point_output(index);
        output.map(PointOutput).ok_or_else(|| errors::value(format!("no output at point {name}")))
    }

    /// How a named point moves: attitude, velocities, accelerations.
    #[pyo3(signature = (name, loads = None))]
    fn point_motion(&mut self, name: &str, loads: Option<&Bound<'_, PyAny>>) -> PyResult<PointMotion> {
        let index = self.simulation.model().point(name).map_err(|e| errors::model(&e))?;
        self.know(loads)?;
        let motion = self.simulation.point_motion(index);
        motion.map(PointMotion).ok_or_else(|| errors::value(format!("no motion at point {name}")))
    }

    /// What an inertial sensor reads.
    #[pyo3(signature = (name, loads = None))]
    fn sensor(&mut self, name: &str, loads: Option<&Bound<'_, PyAny>>) -> PyResult<SensorReading> {
        let index = self.simulation.model().sensor(name).map_err(|e| errors::model(&e))?;
        self.know(loads)?;
        let reading = self.simulation.sensor_reading(index);
        reading.map(SensorReading).ok_or_else(|| errors::value(format!("no reading of sensor {name}")))
    }

    /// Section forces at the places of internal loads: {name: (Fx, Fy, Fz, Mx, My, Mz)}, N and N m, on the positive face in section axes;
    /// by summation of forces where the model allows it.
    #[pyo3(signature = (loads = None))]
    fn internal_loads<'py>(
        &mut self,
        py: Python<'py>,
        loads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<BTreeMap<String, Bound<'py, PyArray1<f64>>>> {
        let Self { simulation, nothing } = self;
        let model = simulation.model().clone();
        let found = match loads {
            None => simulation.find_section_forces(nothing).map(<[_]>::to_vec),
            some => load(&model, some, |loads| simulation.find_section_forces(loads).map(<[_]>::to_vec))?,
        };
        let found = found.map_err(|e| errors::step(&e))?;
        let each = model.section_names().zip(&found);
        Ok(each.map(|(name, section)| (name.to_owned(), vector(py, &section.best))).collect())
    }

    /// Centre of mass, momenta and energies.
    #[getter]
    fn ledger(&self) -> Ledger {
        Ledger(self.simulation.ledger())
    }

    fn __repr__(&self) -> String {
        format!("Simulation(t={}, dt={}, integrator={:?})", self.time(), self.dt(), self.integrator())
    }
}
