//! Load cases, and wrenches set from step to step.

use std::sync::Arc;

use pyo3::prelude::*;
use rom_runtime::{self as rom, DistributedFrame, LoadFrame, PreparedLoads};

use crate::arrays::{entries, finite, fixed};
use crate::errors;
use crate::model::Model;
use crate::state::State;

/// A load case made ready for one model. Constant.
#[pyclass(module = "romgen", frozen)]
pub(crate) struct LoadCase {
    pub(crate) case: rom::LoadCase,
    pub(crate) prepared: PreparedLoads,
    start: rom::State,
}

impl LoadCase {
    pub(crate) fn new(model: &rom::Model, case: rom::LoadCase) -> PyResult<Self> {
        let prepared = model.prepare(&case).map_err(|e| errors::model(&e))?;
        let start = model.initial_state(&case).map_err(|e| errors::model(&e))?;
        Ok(Self { case, prepared, start })
    }
}

#[pymethods]
impl LoadCase {
    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.case.name
    }

    /// One line for people; may be empty.
    #[getter]
    fn description(&self) -> &str {
        &self.case.description
    }

    /// End of the run, s.
    #[getter]
    fn t_end(&self) -> f64 {
        self.case.t_end
    }

    /// Time step its author ran it with, s.
    #[getter]
    fn dt(&self) -> f64 {
        self.case.dt
    }

    /// Numerical damping of the implicit integrators.
    #[getter]
    fn numerical_damping(&self) -> f64 {
        self.case.numerical_damping
    }

    /// State in which it starts; a simulation begins there once its ``state`` is set to it.
    #[getter]
    fn initial_state(&self) -> State {
        State(self.start.clone())
    }

    fn __repr__(&self) -> String {
        let case = &self.case;
        format!(
            "LoadCase({:?}, t_end={}, dt={}, {} loads)",
            case.name,
            case.t_end,
            case.dt,
            case.loads.len() + case.distributed.len()
        )
    }
}

/// Wrenches (force in N, moment in N m) on some points, held until they are changed.
///
/// The implicit integrators take them for the loads at the end of the step, RK4 holds them over the step. Without a
/// load case they are all the loads there are: about a loaded equilibrium those in balance there have to be among them, or act
/// besides with ``case=model.equilibrium``.
///
/// Args:
///     points: names of the points, each once.
///     frame: of the components: ``"body"`` (A), ``"dead"`` (G) or ``"follower"`` (axes of the section, turning
///         with it).
///     member: for follower loads where members with different section axes meet: the one to follow.
///     case: a load case that acts besides, and with it the loads of a loaded equilibrium.
///     stations: names of blocks of stations that :meth:`set_stations` can load.
#[pyclass(module = "romgen")]
#[derive(Clone)]
pub(crate) struct LoadSet {
    pub(crate) set: rom::LoadSet,
    model: Arc<rom::Model>,
    points: Vec<usize>,
    frames: Vec<LoadFrame>,
    blocks: Vec<usize>,
}

impl LoadSet {
    pub(crate) fn from_points(
        model: &Arc<rom::Model>,
        points: &[String],
        frame: &str,
        member: Option<&str>,
        case: Option<&LoadCase>,
        stations: &[String],
    ) -> PyResult<Self> {
        let points = points
            .iter()
            .map(|name| model.point(name).map_err(|e| errors::model(&e)))
            .collect::<PyResult<Vec<usize>>>()?;
        let blocks = stations
            .iter()
            .map(|name| model.station_block(name).map_err(|e| errors::model(&e)))
            .collect::<PyResult<Vec<usize>>>()?;
        let set = rom::LoadSet::with_stations(model, &points, &blocks, case.map(|case| &case.case));
        let set = set.map_err(|e| errors::model(&e))?;
        let frames = points.iter().map(|&p| load_frame(model, p, frame, member)).collect::<PyResult<_>>()?;
        Ok(Self { set, model: Arc::clone(model), points, frames, blocks })
    }

    /// Numbers that a row of wrenches has.
    pub(crate) fn width(&self) -> usize {
        6 * self.points.len()
    }

    /// Replaces all loads by the wrenches (force, moment) of a row - (points x 6).
    pub(crate) fn replace(&mut self, row: &[f64]) {
        self.set.clear();
        for ((slot, frame), wrench) in self.frames.iter().enumerate().zip(row.as_chunks::<6>().0) {
            let &[fx, fy, fz, mx, my, mz] = wrench;
            // The slots are those of the set, so that none is missing.
            let _ = self.set.add(slot, frame, [fx, fy, fz], [mx, my, mz]);
        }
    }
}

#[pymethods]
impl LoadSet {
    #[new]
    #[pyo3(signature = (model, points, frame = "body", member = None, case = None, stations = vec![]))]
    fn new(
        model: &Model,
        points: Vec<String>,
        frame: &str,
        member: Option<&str>,
        case: Option<&LoadCase>,
        stations: Vec<String>,
    ) -> PyResult<Self> {
        Self::from_points(&model.model, &points, frame, member, case, &stations)
    }

    /// Names of the points.
    #[getter]
    fn points(&self) -> Vec<&str> {
        self.points.iter().map(|&point| self.model.data().points[point].name.as_str()).collect()
    }

    /// Removes all wrenches; a load case stays.
    fn clear(&mut self) {
        self.set.clear();
    }

    /// Names of the blocks of stations.
    #[getter]
    fn stations(&self) -> Vec<&str> {
        self.blocks.iter().map(|&block| self.model.data().stations[block].name.as_str()).collect()
    }

    /// Replaces what acts on a block of stations: (fx, fy, fz, mx, my, mz) at every station - (n, 6), components in ``"dead"`` (G),
    /// ``"body"`` (A) or ``"follower"`` axes, those of every section.
    #[pyo3(signature = (name, wrenches, frame = "follower"))]
    fn set_stations(&mut self, name: &str, wrenches: &Bound<'_, PyAny>, frame: &str) -> PyResult<()> {
        let Some(slot) = self.stations().iter().position(|known| *known == name) else {
            let known = self.stations().join(", ");
            return Err(errors::value(format!(
                "this set was not made for stations {name}, only for: {known}"
            )));
        };
        let frame = match frame {
            "dead" => DistributedFrame::Dead,
            "body" => DistributedFrame::Body,
            "follower" => DistributedFrame::Follower,
            _ => {
                let expected = "expected \"dead\", \"body\" or \"follower\"";
                return Err(errors::value(format!("frame {frame:?}, {expected}")));
            }
        };
        let n = self.model.data().stations[self.blocks[slot]].sections.len();
        let (values, _) = entries("wrenches", wrenches, &[Some(n), Some(6)])?;
        finite("wrenches", &values)?;
        // Of the right length.
        let _ = self.set.set_stations(slot, frame, &values);
        Ok(())
    }

    /// Replaces all wrenches: (fx, fy, fz, mx, my, mz) on every point - (points, 6). Those on stations become zero.
    fn set(&mut self, wrenches: &Bound<'_, PyAny>) -> PyResult<()> {
        let (values, _) = entries("wrenches", wrenches, &[Some(self.points.len()), Some(6)])?;
        finite("wrenches", &values)?;
        self.replace(&values);
        Ok(())
    }

    /// Adds a force (3) and a moment (3) on one of the points, in the set's frame or in another.
    #[pyo3(signature = (point, force = None, moment = None, frame = None, member = None))]
    fn add(
        &mut self,
        point: &str,
        force: Option<&Bound<'_, PyAny>>,
        moment: Option<&Bound<'_, PyAny>>,
        frame: Option<&str>,
        member: Option<&str>,
    ) -> PyResult<()> {
        let index = self.model.point(point).map_err(|e| errors::model(&e))?;
        let Some(slot) = self.points.iter().position(|&known| known == index) else {
            let known = self.points().join(", ");
            return Err(errors::value(format!("this set was not made for point {point}, only for: {known}")));
        };
        let (force, moment) = (vector("force", force)?, vector("moment", moment)?);
        let frame = match frame {
            Some(name) => load_frame(&self.model, index, name, member)?,
            None => self.frames[slot],
        };
        let _ = self.set.add(slot, &frame, force, moment);
        Ok(())
    }

    /// Adds a force (3) on the origin of frame A and a moment (3), components in ``"body"`` (A) or ``"dead"`` (G) axes.
    #[pyo3(signature = (force = None, moment = None, frame = "body"))]
    fn add_wrench(
        &mut self,
        force: Option<&Bound<'_, PyAny>>,
        moment: Option<&Bound<'_, PyAny>>,
        frame: &str,
    ) -> PyResult<()> {
        let frame = match frame {
            "dead" => LoadFrame::Dead,
            "body" => LoadFrame::Body,
            _ => return Err(errors::value(format!("frame {frame:?}, expected \"dead\" or \"body\""))),
        };
        let (force, moment) = (vector("force", force)?, vector("moment", moment)?);
        self.set.add_wrench(&frame, force, moment);
        Ok(())
    }

    /// Adds generalised forces on the elastic modes - (m): the work of loads in their shapes. What the same loads do to the rigid
    /// motion goes by :meth:`add_wrench`.
    fn add_modal(&mut self, forces: &Bound<'_, PyAny>) -> PyResult<()> {
        let (values, _) = entries("forces", forces, &[Some(self.model.n_modes())])?;
        finite("forces", &values)?;
        // Of the right length.
        let _ = self.set.add_modal(&values);
        Ok(())
    }

    fn __repr__(&self) -> String {
        format!("LoadSet({:?})", self.points())
    }
}

/// A vector, zero where none is given.
fn vector(what: &str, object: Option<&Bound<'_, PyAny>>) -> PyResult<[f64; 3]> {
    let values = object.map_or(Ok([0.0; 3]), |object| fixed(what, object))?;
    finite(what, &values)?;
    Ok(values)
}

/// The frame of that name at a point; `member` chooses where members with different section axes meet.
fn load_frame(model: &rom::Model, point: usize, name: &str, member: Option<&str>) -> PyResult<LoadFrame> {
    match name {
        "dead" => Ok(LoadFrame::Dead),
        "body" => Ok(LoadFrame::Body),
        "follower" => {
            let section = model.section_axes(point, member).map_err(|e| errors::model(&e))?;
            Ok(LoadFrame::Follower { section })
        }
        _ => Err(errors::value(format!("frame {name:?}, expected \"dead\", \"body\" or \"follower\""))),
    }
}
