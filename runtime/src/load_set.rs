//! Wrenches that a host sets every step.

use alloc::string::{String, ToString};
use alloc::{vec, vec::Vec};
use core::ops::Range;

use crate::direct::Direct;
use crate::error::ModelError;
use crate::estimate::Estimated;
use crate::loading::{Acting, LoadMap, Loaded, Loads, Wrench, resolve, sealed, station_axes};
use crate::loads::{DistributedFrame, LoadCase, LoadFrame};
use crate::math::split;
use crate::model::{Model, unknown};

/// Wrenches on points that a host sets from step to step: made once for the points it will ever load, then only
/// written to, which does not allocate.
///
/// The loads are those at the end of the step for the implicit integrators, and are held over the step by RK4;
/// components stay constant in their frame meanwhile, so a dead load turns with respect to A as A turns.
///
/// A host gives all loads: about a loaded equilibrium those in balance there too (`TrimData::loads`), which an aerodynamic code at the
/// state of the trim brings along by itself. Where they should act by themselves, and the host only add to them, make the set
/// [`LoadSet::with_case`] of `LoadCase::empty("equilibrium")`.
#[derive(Clone, Debug)]
pub struct LoadSet {
    /// The first slots are those of the points and then of the stations given.
    acting: Acting,
    /// Number of points given.
    n_loaded: usize,
    /// Slots of each block of stations given.
    blocks: Vec<Range<usize>>,
}

impl LoadSet {
    /// For the given points (indices into the model's points, each once), all loads zero.
    ///
    /// # Errors
    /// A point that the model does not have, or one given twice.
    pub fn new(model: &Model, points: &[usize]) -> Result<Self, ModelError> {
        Self::with_stations(model, points, &[], None)
    }

    /// The same with a load case acting besides, as [`Model::prepare`] makes it ready: the loads of a loaded equilibrium
    /// are among them.
    ///
    /// # Errors
    /// As [`LoadSet::new`] and [`Model::prepare`].
    pub fn with_case(model: &Model, points: &[usize], case: &LoadCase) -> Result<Self, ModelError> {
        Self::with_stations(model, points, &[], Some(case))
    }

    /// The same with blocks of stations besides (indices, each once; [`Model::station_block`]), for [`LoadSet::set_stations`], and with
    /// or without a load case.
    ///
    /// # Errors
    /// As [`LoadSet::new`] and [`Model::prepare`]; a block that the model does not have, or one given twice.
    pub fn with_stations(
        model: &Model,
        points: &[usize],
        stations: &[usize],
        case: Option<&LoadCase>,
    ) -> Result<Self, ModelError> {
        let mut loaded = Self::loaded(model, points)?;
        let all = &model.data().stations;
        let mut blocks = Vec::with_capacity(stations.len());
        for (index, &block) in stations.iter().enumerate() {
            let Some(data) = all.get(block) else {
                let names = all.iter().map(|block| &block.name);
                return Err(unknown("station block number", &block.to_string(), names));
            };
            if stations.iter().take(index).any(|&other| other == block) {
                return Err(ModelError::Twice { what: "block of stations", name: data.name.clone() });
            }
            let (first, start, n) = (model.first_of_block(block), loaded.len(), data.sections.len());
            loaded.extend((first..first + n).map(|point| Loaded { point, moments: true, follows: true }));
            blocks.push(start..start + n);
        }
        let wrenches = vec![Wrench::default(); loaded.len()];
        let (entries, projected) = match case {
            Some(case) => model.entries(case, &mut loaded)?,
            None => (Vec::new(), Vec::new()),
        };
        let mut acting = Acting::new(LoadMap::new(model, &loaded), entries, projected);
        acting.wrenches = wrenches;
        acting.direct = Some(Direct::new(model));
        acting.base = case.and_then(|case| case.motion.clone());
        acting.estimated = case.map_or_else(Estimated::default, |case| model.estimated(case));
        acting.estimated.all &= stations.is_empty();
        Ok(LoadSet { acting, n_loaded: points.len(), blocks })
    }

    /// Replaces what acts on the `block`-th block of stations given: (force, moment) on every station, N and N m - (n x 6), at the
    /// stations, constant in G, in A or in the axes of every section. Returns false, and does nothing, when there is no such block or
    /// the array has another length. Does not allocate.
    #[must_use]
    pub fn set_stations(&mut self, block: usize, frame: DistributedFrame, wrenches: &[f64]) -> bool {
        let slots = self.blocks.get(block).and_then(|range| self.acting.wrenches.get_mut(range.clone()));
        let (given, rest) = wrenches.as_chunks::<6>();
        match slots {
            Some(slots) if slots.len() == given.len() && rest.is_empty() => {
                for (slot, given) in slots.iter_mut().zip(given) {
                    let (force, moment) = split(given);
                    *slot = Wrench::default();
                    slot.add(station_axes(frame), 1.0, force, moment);
                }
                true
            }
            _ => false,
        }
    }

    /// Adds a force (N) and a moment (N m) on a station of the `block`-th block of stations given, components in `frame`. Returns false (and
    /// does nothing) when there is no such block or station. Does not allocate.
    #[must_use]
    pub fn add_to_station(
        &mut self,
        block: usize,
        station: usize,
        frame: DistributedFrame,
        force: [f64; 3],
        moment: [f64; 3],
    ) -> bool {
        let slots = self.blocks.get(block).and_then(|range| self.acting.wrenches.get_mut(range.clone()));
        match slots.and_then(|slots| slots.get_mut(station)) {
            Some(wrench) => {
                wrench.add(station_axes(frame), 1.0, force, moment);
                true
            }
            None => false,
        }
    }

    /// Number of stations of every block that can be written to.
    pub fn station_counts(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.blocks.iter().map(ExactSizeIterator::len)
    }

    fn loaded(model: &Model, points: &[usize]) -> Result<Vec<Loaded>, ModelError> {
        for (index, &found) in points.iter().enumerate() {
            if found >= model.n_points() {
                let names = model.data().points.iter().map(|point| &point.name);
                return Err(unknown("point number", &found.to_string(), names));
            }
            if points.iter().take(index).any(|&other| other == found) {
                let name =
                    model.data().points.get(found).map_or_else(String::new, |point| point.name.clone());
                return Err(ModelError::Twice { what: "point", name });
            }
        }
        Ok(points.iter().map(|&point| Loaded { point, moments: true, follows: true }).collect())
    }

    /// Removes all wrenches and modal forces; a load case stays.
    pub fn clear(&mut self) {
        self.acting.wrenches.fill(Wrench::default());
        if let Some(direct) = &mut self.acting.direct {
            direct.clear();
        }
    }

    /// Adds a force (N) on the origin of frame A and a moment (N m), components in `frame`; those of a section follow A itself. It
    /// does the work of the true velocity, `(f, m) . beta`: no point is needed where the reference node is.
    pub fn add_wrench(&mut self, frame: &LoadFrame, force: [f64; 3], moment: [f64; 3]) {
        let (axes, force, moment) = resolve(frame, force, moment);
        if let Some(direct) = &mut self.acting.direct {
            direct.add_wrench(axes, force, moment);
        }
    }

    /// Adds generalised forces on the elastic modes, N m per unit amplitude - (m): the work of loads in the shapes
    /// `(Phi_S, Phi_R)`. What they do to the rigid motion goes by [`LoadSet::add_wrench`]; it is not derived from them.
    /// Returns false (and does nothing) when the length is not that of the model's modes.
    #[must_use]
    pub fn add_modal(&mut self, forces: &[f64]) -> bool {
        self.acting.direct.as_mut().is_some_and(|direct| direct.add_modal(forces))
    }

    /// Adds a force (N) and a moment (N m) on the `slot`-th point given to [`LoadSet::new`], components in `frame`.
    /// Returns false (and does nothing) when there is no such slot.
    #[must_use]
    pub fn add(&mut self, slot: usize, frame: &LoadFrame, force: [f64; 3], moment: [f64; 3]) -> bool {
        let (axes, force, moment) = resolve(frame, force, moment);
        match self.acting.wrenches.get_mut(slot).filter(|_| slot < self.n_loaded) {
            Some(wrench) => {
                wrench.add(axes, 1.0, force, moment);
                true
            }
            None => false,
        }
    }

    /// The model's point of every slot that can be written to.
    pub fn points(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.acting.map.points().take(self.n_loaded)
    }
}

impl sealed::Acts for LoadSet {
    fn acting(&self) -> &Acting {
        &self.acting
    }
}

impl Loads for LoadSet {}
