//! From a load case to what acts: loads that can be projected, the others by slot, every point and function of time once.

use alloc::{collections::BTreeMap, sync::Arc, vec::Vec};

use crate::error::ModelError;
use crate::estimate::Estimated;
use crate::loads::{DistributedFrame, DistributedLoad, Load, LoadCase, LoadFrame};
use crate::math::Vec3;
use crate::model::Model;
use crate::projected::Projected;
use crate::time::TimeFunction;
use crate::validate;

use super::map::Loaded;
use super::{Acting, Axes, Entry, LoadMap, PreparedLoads, resolve};

/// Entries, and forces that are projected.
type Entries = (Vec<Entry>, Vec<Projected>);

impl Model {
    /// Makes a load case ready: checks it against this model, adds the loads of a loaded equilibrium, and gathers what the evaluation
    /// needs.
    ///
    /// # Errors
    /// What is wrong with the case: unknown points, non-finite vectors, time functions that cannot be evaluated.
    pub fn prepare(&self, case: &LoadCase) -> Result<PreparedLoads, ModelError> {
        let mut points = Vec::new();
        let (entries, projected) = self.entries(case, &mut points)?;
        let mut acting = Acting::new(LoadMap::new(self, &points), entries, projected);
        acting.base = case.motion.clone();
        acting.estimated = self.estimated(case);
        Ok(PreparedLoads { acting })
    }

    /// The loads per length of a case and of the equilibrium, as the estimate of errors knows them.
    pub(crate) fn estimated(&self, case: &LoadCase) -> Estimated {
        let trim = self.data().trim.iter().flat_map(|trim| &trim.distributed);
        Estimated::new(self, trim.chain(&case.distributed))
    }

    /// The loads of a case and of the equilibrium, by slot or projected; `points` gains those of the slots it does not have yet.
    pub(crate) fn entries(&self, case: &LoadCase, points: &mut Vec<Loaded>) -> Result<Entries, ModelError> {
        validate::load_case(case, self.n_points(), &self.data().lines)?;
        let mut entries = Vec::with_capacity(case.loads.len());
        let (mut slots, mut times, mut groups) = (Slots::new(points), Times::default(), Groups::default());
        let trim = self.data().trim.iter().flat_map(|trim| &trim.distributed);
        for load in trim.chain(&case.distributed) {
            let time = times.shared(&load.time);
            if self.projects_line(load) {
                groups.add(load.frame == DistributedFrame::Dead, time, |group| group.take_line(self, load));
            } else {
                self.station_entries(load, time, &mut slots, &mut entries);
            }
        }
        let mut enter = |load: &Load, time| {
            let (axes, force, moment) = resolve(&load.frame, load.force, load.moment);
            let slot = slots.of(load.point as usize, axes, moment);
            entries.push(Entry::new(slot, axes, force, moment, time));
        };
        let trim = self.data().trim.iter().flat_map(|trim| &trim.loads);
        for load in trim.chain(&case.loads) {
            let time = times.shared(&load.time);
            if self.projects(load) {
                groups.add(load.frame == LoadFrame::Dead, time, |group| group.loads.push(load));
            } else {
                enter(load, time);
            }
        }
        // One force costs less by its own point.
        let (few, many): (Vec<_>, Vec<_>) = groups.0.into_iter().partition(|group| group.is_one_force());
        for group in few {
            group.loads.iter().for_each(|load| enter(load, Arc::clone(&group.time)));
        }
        // One after another, loads of one function of time have it evaluated once.
        entries.sort_by_key(|entry| times.place(&entry.time));
        Ok((entries, many.into_iter().map(|group| group.projected(self)).collect()))
    }

    /// Whether a load on a point can be projected: a force that does not turn with its node, on a point that moves as its node does. On a
    /// curved manifold positions are not linear in the amplitudes.
    fn projects(&self, load: &Load) -> bool {
        let on_node = self.carrier(load.point as usize).is_some_and(|point| point.offset == [0.0; 3]);
        let turns = matches!(load.frame, LoadFrame::Follower { .. });
        on_node && !turns && load.moment == [0.0; 3] && !self.is_curved()
    }

    /// The same of a distributed load.
    fn projects_line(&self, load: &DistributedLoad) -> bool {
        load.frame != DistributedFrame::Follower && load.moment.iter().all(|m| *m == 0.0) && !self.is_curved()
    }

    fn is_curved(&self) -> bool {
        self.data().lagrangian.as_ref().is_some_and(|it| it.geometric)
    }

    /// A distributed load station by station.
    fn station_entries(
        &self,
        load: &DistributedLoad,
        time: Arc<TimeFunction>,
        slots: &mut Slots<'_>,
        entries: &mut Vec<Entry>,
    ) {
        let axes = station_axes(load.frame);
        let first = self.first_station(load.member as usize);
        let (force, moment) = (load.force.as_chunks::<3>().0, load.moment.as_chunks::<3>().0);
        for n in 0..force.len().max(moment.len()) {
            let at = |list: &[Vec3]| list.get(n).copied().unwrap_or([0.0; 3]);
            let (force, moment) = (at(force), at(moment));
            let slot = slots.of(first + n, axes, moment);
            entries.push(Entry::new(slot, axes, force, moment, Arc::clone(&time)));
        }
    }

    /// No loads at all, not even those of a loaded equilibrium.
    pub fn no_loads(&self) -> PreparedLoads {
        PreparedLoads { acting: Acting::new(LoadMap::new(self, &[]), Vec::new(), Vec::new()) }
    }
}

/// The axes of a section are those of its station.
pub(crate) fn station_axes(frame: DistributedFrame) -> Axes {
    match frame {
        DistributedFrame::Dead => Axes::Inertial,
        DistributedFrame::Body => Axes::Body,
        DistributedFrame::Follower => Axes::Node,
    }
}

/// Forces that may be projected, by their axes and function of time.
#[derive(Default)]
struct Groups<'a>(Vec<Group<'a>>);

struct Group<'a> {
    dead: bool,
    time: Arc<TimeFunction>,
    /// On points.
    loads: Vec<&'a Load>,
    /// On stations, by their number among all carriers.
    stations: Vec<(usize, Vec3)>,
}

impl<'a> Groups<'a> {
    /// Adds to the group, made where there is none yet.
    fn add(&mut self, dead: bool, time: Arc<TimeFunction>, add: impl FnOnce(&mut Group<'a>)) {
        let known = self.0.iter_mut().find(|group| group.dead == dead && Arc::ptr_eq(&group.time, &time));
        if let Some(group) = known {
            return add(group);
        }
        let mut group = Group { dead, time, loads: Vec::new(), stations: Vec::new() };
        add(&mut group);
        self.0.push(group);
    }
}

impl Group<'_> {
    fn take_line(&mut self, model: &Model, load: &DistributedLoad) {
        let first = model.first_station(load.member as usize);
        let forces = load.force.as_chunks::<3>().0.iter().enumerate();
        self.stations.extend(forces.map(|(n, force)| (first + n, *force)));
    }

    fn is_one_force(&self) -> bool {
        self.loads.len() == 1 && self.stations.is_empty()
    }

    fn projected(&self, model: &Model) -> Projected {
        let points: Vec<_> = self.loads.iter().map(|load| (load.point as usize, load.force)).collect();
        let forces: Vec<_> = points.iter().chain(&self.stations).copied().collect();
        Projected::new(model, self.dead, Arc::clone(&self.time), &forces, points)
    }
}

/// Functions of time, each once.
#[derive(Default)]
struct Times(Vec<Arc<TimeFunction>>);

impl Times {
    /// The function that is equal.
    fn shared(&mut self, time: &TimeFunction) -> Arc<TimeFunction> {
        if let Some(known) = self.0.iter().find(|known| known.as_ref() == time) {
            return Arc::clone(known);
        }
        let new = Arc::new(time.clone());
        self.0.push(Arc::clone(&new));
        new
    }

    fn place(&self, time: &Arc<TimeFunction>) -> Option<usize> {
        self.0.iter().position(|known| Arc::ptr_eq(known, time))
    }
}

/// Loaded points and stations, each once.
struct Slots<'a> {
    points: &'a mut Vec<Loaded>,
    of_point: BTreeMap<usize, usize>,
}

impl<'a> Slots<'a> {
    fn new(points: &'a mut Vec<Loaded>) -> Self {
        let of_point = points.iter().enumerate().map(|(slot, loaded)| (loaded.point, slot)).collect();
        Slots { points, of_point }
    }

    /// The slot of a point or station, made where there is none yet.
    fn of(&mut self, point: usize, axes: Axes, moment: Vec3) -> usize {
        let slot = *self.of_point.entry(point).or_insert(self.points.len());
        if slot == self.points.len() {
            self.points.push(Loaded { point, moments: false, follows: false });
        }
        if let Some(loaded) = self.points.get_mut(slot) {
            loaded.moments |= moment != [0.0; 3];
            loaded.follows |= axes == Axes::Node;
        }
        slot
    }
}
