//! Many steps at once, recorded as `romrun` records them.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rom_cli::march::{ERRORS_EVERY, HELP_REDUCED, Outcome, Recording, Reduced, record};
use rom_cli::run::TimeGrid;
use rom_runtime::{Loads, Model, Simulation, StepError};
use serde_json::{Map, Value};

use crate::arrays;
use crate::errors;
use crate::loads::LoadSet;

/// The instants of a run that goes on from where a simulation stands.
pub(crate) struct Span {
    start: f64,
    grid: TimeGrid,
}

impl Span {
    /// Either a number of steps or an end, s.
    pub(crate) fn new(
        start: f64,
        dt: f64,
        steps: Option<u64>,
        t_end: Option<f64>,
        every: u64,
    ) -> PyResult<Self> {
        let duration = match (steps, t_end) {
            (Some(0), None) => return Err(errors::value("a run has at least one step")),
            (Some(steps), None) => steps as f64 * dt,
            (None, Some(t_end)) => t_end - start,
            _ => return Err(errors::value("give either steps or t_end")),
        };
        if duration <= 0.0 {
            return Err(errors::value(format!(
                "the simulation stands at {start} s, t_end has to be later than that"
            )));
        }
        let grid = TimeGrid::new(dt, duration, every).map_err(|e| errors::value(e.message))?;
        Ok(Self { start, grid })
    }
}

/// Indices of points to record: those named, or all.
pub(crate) fn points(model: &Model, names: Option<Vec<String>>) -> PyResult<Vec<usize>> {
    match names {
        None => Ok((0..model.n_points()).collect()),
        Some(names) => names.iter().map(|name| model.point(name).map_err(|e| errors::model(&e))).collect(),
    }
}

/// A run under loads that know their time.
pub(crate) fn constant<'py>(
    py: Python<'py>,
    simulation: &mut Simulation,
    loads: &(impl Loads + Sync),
    span: &Span,
    points: Vec<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    start(simulation, loads)?;
    run(py, simulation, span, points, |simulation| step(simulation, loads))
}

/// A run under one row of wrenches per step - (steps x points x 6).
pub(crate) fn driven<'py>(
    py: Python<'py>,
    simulation: &mut Simulation,
    mut loads: LoadSet,
    wrenches: &[f64],
    span: &Span,
    points: Vec<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    // No points, no columns: rows of nothing.
    let width = loads.width();
    let mut rows = (0..).map(|step| wrenches.get(step * width..(step + 1) * width).unwrap_or(&[]));
    loads.replace(wrenches.get(..width).unwrap_or(&[]));
    start(simulation, &loads.set)?;
    run(py, simulation, span, points, |simulation| {
        loads.replace(rows.next().unwrap_or(&[]));
        step(simulation, &loads.set)
    })
}

/// The section forces at the start, under the loads of the first step, where the model tells any.
fn start(simulation: &mut Simulation, loads: &impl Loads) -> PyResult<()> {
    if simulation.section_forces().is_empty() {
        return Ok(());
    }
    simulation.find_section_forces(loads).map(|_| ()).map_err(|e| errors::step(&e))
}

/// A step, and the section forces after it where the model tells any.
fn step(simulation: &mut Simulation, loads: &impl Loads) -> Result<(), StepError> {
    simulation.step(loads)?;
    if simulation.section_forces().is_empty() {
        Ok(())
    } else {
        simulation.find_section_forces(loads).map(|_| ())
    }
}

fn run<'py>(
    py: Python<'py>,
    simulation: &mut Simulation,
    span: &Span,
    points: Vec<usize>,
    step: impl FnMut(&mut Simulation) -> Result<(), StepError> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let data = simulation.model().data();
    let recording = Recording {
        grid: span.grid,
        points: points.iter().map(|&i| (i, data.points[i].name.clone())).collect(),
        point_motion: false,
        rates: false,
        sensors: Vec::new(),
        sections: simulation.model().section_names().map(String::from).collect(),
        modes: data.modes.number.clone(),
        reaction: false,
        help: HELP_REDUCED,
    };
    let metadata = metadata(simulation, span);
    simulation.watch_errors(ERRORS_EVERY);
    let mut marching = Reduced::new(simulation, step);
    let outcome = py.detach(|| record(&mut marching, &recording, metadata, |_, _| ()));
    results(py, outcome, span.start)
}

fn metadata(simulation: &Simulation, span: &Span) -> Map<String, Value> {
    let (model, settings) = (simulation.model(), simulation.settings());
    let mut map = Map::new();
    let mut add = |name: &str, value: Value| map.insert(name.to_owned(), value);
    add("tool", concat!("romgen (Python) ", env!("CARGO_PKG_VERSION")).into());
    add("structure", model.data().provenance.name.as_str().into());
    add("input_sha256", model.data().provenance.input_sha256.as_str().into());
    add("method", model.method().name().into());
    add("integrator", settings.integrator.name().into());
    add("dt", settings.dt.into());
    add("every", span.grid.every.into());
    add("numerical_damping", settings.numerical_damping.into());
    map
}

/// Results as the package's own dict of arrays; a failed run raises, with what was recorded.
fn results(py: Python<'_>, outcome: Outcome, start: f64) -> PyResult<Bound<'_, PyAny>> {
    let (arrays, units, descriptions, components) =
        (PyDict::new(py), PyDict::new(py), PyDict::new(py), PyDict::new(py));
    for channel in outcome.results.channels() {
        let mut data = channel.data.clone();
        if channel.name == "t" {
            data.iter_mut().for_each(|t| *t += start);
        }
        if channel.components.is_empty() {
            arrays.set_item(&channel.name, arrays::vector(py, &data))?;
        } else {
            arrays.set_item(&channel.name, arrays::matrix(py, data, channel.width())?)?;
        }
        units.set_item(&channel.name, &channel.unit)?;
        descriptions.set_item(&channel.name, &channel.description)?;
        components.set_item(&channel.name, channel.components.clone())?;
    }
    let text = Value::Object(outcome.results.metadata).to_string();
    let metadata = py.import("json")?.call_method1("loads", (text,))?;
    let class = py.import("romgen._results")?.getattr("Results")?;
    let results = class.call1((arrays, units, descriptions, components, metadata))?;
    match outcome.failure {
        None => Ok(results),
        Some(failure) => {
            let error = errors::StepError::new_err(format!("{}\n{}", failure.message, failure.help));
            error.value(py).setattr("results", results)?;
            Err(error)
        }
    }
}
