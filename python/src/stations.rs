//! Blocks of stations, for aerodynamic codes.

use std::sync::Arc;

use numpy::PyArray2;
use pyo3::prelude::*;
use rom_runtime::{self as rom, StationAxes};

use crate::arrays::{matrix, vector};
use crate::errors;
use crate::model::Model;
use crate::simulation::Simulation;
use crate::state::State;

type Array<'py> = PyResult<Bound<'py, PyArray2<f64>>>;

/// A block of stations of a model: where they are and how they move, in one call.
///
/// Args:
///     model: the model, or a simplification of it (:meth:`Model.with_method`).
///     name: of the block.
#[pyclass(module = "romgen")]
pub(crate) struct Stations {
    stations: rom::Stations,
    model: Arc<rom::Model>,
}

impl Stations {
    fn data(&self) -> &rom::data::StationsData {
        &self.model.data().stations[self.stations.block()]
    }
}

#[pymethods]
impl Stations {
    #[new]
    fn new(model: &Model, name: &str) -> PyResult<Self> {
        let model = Arc::clone(&model.model);
        let block = model.station_block(name).map_err(|e| errors::model(&e))?;
        let stations = rom::Stations::new(&model, block).map_err(|e| errors::model(&e))?;
        Ok(Self { stations, model })
    }

    /// Name of the block.
    #[getter]
    fn name(&self) -> &str {
        &self.data().name
    }

    /// Members that it goes along, with the number of stations on each, in the order of the stations.
    #[getter]
    fn members(&self) -> Vec<(&str, u32)> {
        self.data().members.iter().map(|(name, count)| (name.as_str(), *count)).collect()
    }

    /// Place of every station as a fraction of the length of its member - (n).
    #[getter]
    fn fraction<'py>(&self, py: Python<'py>) -> Bound<'py, numpy::PyArray1<f64>> {
        vector(py, &self.data().fraction)
    }

    /// From the axis to the stations, section axes, m - (n, 3).
    #[getter]
    fn offset<'py>(&self, py: Python<'py>) -> Array<'py> {
        matrix(py, self.data().offset.clone(), 3)
    }

    fn __len__(&self) -> usize {
        self.stations.len()
    }

    /// Where the stations are and how they move in a state, or in that of a simulation.
    ///
    /// Args:
    ///     of: a :class:`Simulation` or a :class:`State` of the model.
    ///     axes: ``"inertial"``: everything in G. ``"body"``: positions from the origin of A and attitudes against it; velocities are
    ///         those against G with components in A. ``"section"``: as ``"body"``, velocities with components in the axes of every section.
    #[pyo3(signature = (of, axes = "inertial"))]
    fn read(&mut self, of: &Bound<'_, PyAny>, axes: &str) -> PyResult<StationMotion> {
        let axes = match axes {
            "inertial" => StationAxes::Inertial,
            "body" => StationAxes::Body,
            "section" => StationAxes::Section,
            _ => {
                let expected = "expected \"inertial\", \"body\" or \"section\"";
                return Err(errors::value(format!("axes {axes:?}, {expected}")));
            }
        };
        let Self { stations, model } = self;
        let motion = if let Ok(simulation) = of.cast::<Simulation>() {
            stations.read(model, simulation.try_borrow()?.now(), axes)
        } else if let Ok(state) = of.cast::<State>() {
            stations.read(model, &state.try_borrow()?.0, axes)
        } else {
            let found = of.get_type().name()?;
            return Err(errors::kind(format!("stations are read from a Simulation or a State, not {found}")));
        };
        motion.map(|motion| StationMotion(motion.clone())).map_err(|e| errors::settings(&e))
    }

    fn __repr__(&self) -> String {
        format!("Stations({:?}, {})", self.name(), self.stations.len())
    }
}

/// Where stations are and how they move.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct StationMotion(rom::StationMotion);

#[pymethods]
impl StationMotion {
    /// Positions, m - (n, 3).
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Array<'py> {
        matrix(py, self.0.position.clone(), 3)
    }

    /// Attitudes of the section axes: unit quaternions, scalar first - (n, 4).
    #[getter]
    fn attitude<'py>(&self, py: Python<'py>) -> Array<'py> {
        matrix(py, self.0.attitude.clone(), 4)
    }

    /// Velocities against G, m/s - (n, 3).
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> Array<'py> {
        matrix(py, self.0.velocity.clone(), 3)
    }

    /// Angular velocities of the sections against G, rad/s - (n, 3).
    #[getter]
    fn angular_velocity<'py>(&self, py: Python<'py>) -> Array<'py> {
        matrix(py, self.0.angular_velocity.clone(), 3)
    }

    fn __repr__(&self) -> String {
        format!("StationMotion({} stations)", self.0.attitude.len() / 4)
    }
}
