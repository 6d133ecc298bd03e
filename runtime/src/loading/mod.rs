//! Loads made ready for a model: load cases ([`PreparedLoads`]); wrenches a host sets every step are [`crate::LoadSet`].
//!
//! Both know which points they load; the modal shapes of those points are gathered once, so that the positions of all
//! loaded points are one matrix times `q` and the generalised loads the transposed matrix times the forces.

mod entry;
mod generalised;
mod map;
mod prepare;
mod wrench;

use alloc::{collections::BTreeMap, sync::Arc, vec::Vec};

use crate::base_motion::BaseMotion;
use crate::direct::Direct;
use crate::estimate::Estimated;
use crate::expression::Variables;
use crate::forward::{Forward, ForwardVariables};
use crate::identity::Identity;
use crate::projected::Projected;
use crate::real::Lanes;

use entry::{add_entries, add_forward_entries, with_factors};

pub(crate) use entry::Entry;
pub(crate) use generalised::{LoadWorkspace, generalised_loads, nodal_forces};
pub(crate) use map::{LoadMap, Loaded, polynomial, whole_curve};
pub(crate) use prepare::station_axes;
pub(crate) use wrench::{Axes, Wrench, resolve};

/// Loads a simulation can be stepped with: [`PreparedLoads`], [`crate::LoadSet`], or a reference to one of them (a batch takes the same
/// loads for many instances so). Sealed.
pub trait Loads: sealed::Acts {}

impl<L: Loads + ?Sized> Loads for &L {}

pub(crate) mod sealed {
    pub trait Acts {
        /// What a step needs to know about the loads.
        fn acting(&self) -> &super::Acting;
    }

    impl<A: Acts + ?Sized> Acts for &A {
        fn acting(&self) -> &super::Acting {
            (**self).acting()
        }
    }
}

/// A load case made ready for a model.
#[derive(Clone, Debug)]
pub struct PreparedLoads {
    acting: Acting,
}

/// What acts on a body, whoever made it: steps are compiled for this alone.
#[derive(Clone, Debug)]
pub struct Acting {
    /// Of all but what a host sets.
    identity: Identity,
    /// The same in all copies, hundreds of them in a batch.
    pub(crate) map: Arc<LoadMap>,
    /// That a host sets, on the first slots of the map.
    pub(crate) wrenches: Vec<Wrench>,
    /// What a host applies besides, on no point.
    pub(crate) direct: Option<Direct>,
    /// Of a load case.
    entries: Vec<Entry>,
    projected: Vec<Projected>,
    /// Carriers that are loaded one by one: those of the slots, then those that only projected forces act on.
    loaded: Vec<usize>,
    pub(crate) base: Option<BaseMotion>,
    /// Loads per length, once more, for the estimate of errors; no step reads them.
    pub(crate) estimated: Estimated,
}

impl Acting {
    pub(crate) fn new(map: LoadMap, entries: Vec<Entry>, mut projected: Vec<Projected>) -> Self {
        let mut loaded: Vec<usize> = map.points().collect();
        let mut places: BTreeMap<usize, usize> =
            loaded.iter().enumerate().map(|(place, point)| (*point, place)).collect();
        for (point, _) in projected.iter_mut().flat_map(|forces| &mut forces.points) {
            let place = *places.entry(*point).or_insert(loaded.len());
            if place == loaded.len() {
                loaded.push(*point);
            }
            *point = place;
        }
        Acting {
            identity: Identity::new(),
            map: Arc::new(map),
            wrenches: Vec::new(),
            direct: None,
            entries,
            projected,
            loaded,
            base: None,
            estimated: Estimated::default(),
        }
    }

    /// The same where map, load case, equilibrium and motion of A are: in all copies, whatever hosts set in them.
    #[inline]
    pub(crate) fn identity(&self) -> Identity {
        self.identity
    }

    /// Whether nothing acts but what load case and equilibrium say.
    pub(crate) fn is_prepared(&self) -> bool {
        self.wrenches.is_empty() && self.direct.is_none()
    }

    /// Which points are loaded.
    #[inline]
    pub(crate) fn map(&self) -> &LoadMap {
        &self.map
    }

    /// Forces that are projected.
    #[inline]
    pub(crate) fn projected(&self) -> &[Projected] {
        &self.projected
    }

    /// Carriers that are loaded one by one.
    pub(crate) fn loaded(&self) -> &[usize] {
        &self.loaded
    }

    /// Adds all wrenches at `variables` to the (zeroed) wrenches of [`Acting::loaded`].
    pub(crate) fn gather_all(&self, variables: &Variables, wrenches: &mut [Wrench]) {
        self.gather(variables, wrenches);
        self.projected.iter().for_each(|forces| forces.add_to_points(variables, wrenches));
    }

    /// What a host applies besides, on no point.
    #[inline]
    pub(crate) fn direct(&self) -> Option<&Direct> {
        self.direct.as_ref()
    }

    /// What moves frame A in the load case; none in free flight.
    #[inline]
    pub(crate) fn base(&self) -> Option<&BaseMotion> {
        self.base.as_ref()
    }

    /// Adds the wrenches at `variables` to the (zeroed) slots.
    #[inline(always)]
    pub(crate) fn gather(&self, variables: &Variables, slots: &mut [Wrench]) {
        for (slot, wrench) in slots.iter_mut().zip(&self.wrenches) {
            *slot = *wrench;
        }
        add_entries(&self.entries, variables, slots);
    }

    /// Loads of the load case and the equilibrium.
    #[inline(always)]
    pub(crate) fn entries(&self) -> &[Entry] {
        // Every field by name: what is new has to act in a batch too.
        let Acting {
            identity: _,
            map: _,
            wrenches: _,
            direct: _,
            entries,
            projected: _,
            loaded: _,
            base: _,
            estimated: _,
        } = self;
        entries
    }

    /// Adds the entries to one lane of the slots of a batch.
    #[inline(always)]
    pub(crate) fn add_entries_to_lane(
        &self,
        variables: &Variables,
        lane: usize,
        slots: &mut [Wrench<Lanes>],
    ) {
        for (entry, factor) in with_factors(&self.entries, variables) {
            if let Some(slot) = slots.get_mut(entry.slot) {
                slot.add_lane(lane, entry, factor);
            }
        }
    }

    /// As [`Acting::gather`], with the slopes of what expressions see.
    pub(crate) fn gather_forward(&self, variables: &ForwardVariables, slots: &mut [Wrench<Forward>]) {
        let Acting {
            identity: _,
            map: _,
            wrenches,
            direct: _,
            entries,
            projected: _,
            loaded: _,
            base: _,
            estimated: _,
        } = self;
        for (slot, wrench) in slots.iter_mut().zip(wrenches) {
            *slot = wrench.of();
        }
        add_forward_entries(entries, variables, slots);
    }
}

impl sealed::Acts for Acting {
    fn acting(&self) -> &Acting {
        self
    }
}

impl Loads for Acting {}

impl sealed::Acts for PreparedLoads {
    fn acting(&self) -> &Acting {
        &self.acting
    }
}

impl Loads for PreparedLoads {}
