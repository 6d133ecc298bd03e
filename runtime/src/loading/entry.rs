//! Loads of a load case on their slots, with their functions of time.

use alloc::sync::Arc;

use crate::expression::Variables;
use crate::forward::{Forward, ForwardVariables};
use crate::math::{Vec3, constant_vector};
use crate::real::{LANES, Lanes, Real};
use crate::time::TimeFunction;

use super::{Axes, Wrench};

/// A load on a slot. Entries whose functions of time are equal share it and follow each other.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(super) slot: usize,
    pub(super) axes: Axes,
    pub(super) force: Vec3,
    pub(super) moment: Vec3,
    /// Most have none.
    pub(super) has_moment: bool,
    pub(super) time: Arc<TimeFunction>,
}

impl Entry {
    pub(super) fn new(slot: usize, axes: Axes, force: Vec3, moment: Vec3, time: Arc<TimeFunction>) -> Self {
        Entry { slot, axes, force, moment, has_moment: moment != [0.0; 3], time }
    }

    #[inline(always)]
    pub(crate) fn add_to<R: Real>(&self, wrench: &mut Wrench<R>, factor: R) {
        wrench.add_force(self.axes, factor, constant_vector(&self.force));
        if self.has_moment {
            wrench.add_moment(self.axes, factor, constant_vector(&self.moment));
        }
    }

    /// As [`Entry::add_to`], entries of one form.
    #[inline(always)]
    pub(crate) fn add_side_by_side(each: &[&Entry; LANES], wrench: &mut Wrench<Lanes>, factor: Lanes) {
        let [first, ..] = each;
        wrench.add_force(first.axes, factor, Lanes::side_by_side(&each.map(|entry| entry.force)));
        if first.has_moment {
            wrench.add_moment(first.axes, factor, Lanes::side_by_side(&each.map(|entry| entry.moment)));
        }
    }

    #[inline(always)]
    pub(crate) fn slot(&self) -> usize {
        self.slot
    }

    /// The factor on it over time.
    #[inline(always)]
    pub(crate) fn time(&self) -> &TimeFunction {
        &self.time
    }

    /// Whether `other` acts in the same place and axes.
    pub(crate) fn has_form_of(&self, other: &Entry) -> bool {
        (self.slot, self.axes, self.has_moment) == (other.slot, other.axes, other.has_moment)
    }

    /// Whether `other`, of the same form, differs in nothing but the function of time.
    pub(crate) fn acts_as(&self, other: &Entry) -> bool {
        (self.force, self.moment) == (other.force, other.moment)
    }
}

pub(super) fn add_forward_entries(
    entries: &[Entry],
    variables: &ForwardVariables,
    slots: &mut [Wrench<Forward>],
) {
    for entry in entries {
        if let Some(slot) = slots.get_mut(entry.slot) {
            entry.add_to(slot, entry.time.along(variables));
        }
    }
}

/// The entries with their factors at an instant.
#[inline(always)]
pub(super) fn with_factors<'a>(
    entries: &'a [Entry],
    variables: &Variables,
) -> impl Iterator<Item = (&'a Entry, f64)> {
    let mut last: Option<(&Arc<TimeFunction>, f64)> = None;
    entries.iter().map(move |entry| {
        let factor = match last {
            Some((time, factor)) if Arc::ptr_eq(time, &entry.time) => factor,
            _ => entry.time.value(variables),
        };
        last = Some((&entry.time, factor));
        (entry, factor)
    })
}

#[inline(always)]
pub(super) fn add_entries(entries: &[Entry], variables: &Variables, slots: &mut [Wrench]) {
    for (entry, factor) in with_factors(entries, variables) {
        if let Some(slot) = slots.get_mut(entry.slot) {
            entry.add_to(slot, factor);
        }
    }
}
