//! The loads of the instances of a chunk.

use alloc::{vec, vec::Vec};

use crate::equations::check_loads;
use crate::error::StepError;
use crate::expression::Variables;
use crate::identity::Identity;
use crate::loading::{Acting, Entry, Wrench};
use crate::math::{Mat3, Vec6, add, join, mul_t};
use crate::model::Model;
use crate::real::{LANES, Lanes, Real};
use crate::time::TimeFunction;

use super::equations::LaneMotion;

/// How much what acts on the instances has in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Likeness {
    Different,
    /// Other numbers in the same places.
    Form,
    /// All but the functions of time.
    Equal,
}

/// What a chunk knows of the loads of its instances; found anew when they are others.
#[derive(Clone, Debug)]
pub(super) struct KnownLoads {
    of: [Identity; LANES],
    /// Why an instance cannot be stepped under its loads.
    refused: [Option<StepError>; LANES],
    any_refused: bool,
    /// Whether the loads act on the same points, so that the instances can be stepped side by side, and none moves frame A.
    together: bool,
    /// Loads on points.
    entries: Likeness,
    /// Whether the projected forces of all of them differ in nothing but their functions of time.
    projected_alike: bool,
}

impl KnownLoads {
    pub(super) fn new() -> Self {
        KnownLoads {
            of: [Identity::NONE; LANES],
            refused: [None; LANES],
            any_refused: false,
            together: false,
            entries: Likeness::Different,
            projected_alike: false,
        }
    }

    /// Looks at the loads where they are not those of before.
    pub(super) fn look(&mut self, model: &Model, lanes: &[&Acting; LANES]) {
        if self.of.iter().zip(lanes).all(|(known, loads)| loads.identity().is(*known)) {
            return;
        }
        self.of = lanes.map(|loads| loads.identity());
        self.refused = lanes.map(|loads| check_loads(model, loads).err());
        self.any_refused = self.refused.iter().any(Option::is_some);
        let [first, ..] = lanes;
        let slots = &first.map().slots;
        self.together = lanes.iter().all(|loads| {
            loads.base().is_none()
                && loads.map().slots == *slots
                && loads.direct().is_none_or(|direct| direct.parts().is_some())
        });
        self.entries = lanes
            .iter()
            .map(|loads| likeness(first.entries(), loads.entries()))
            .min()
            .unwrap_or(Likeness::Different);
        self.projected_alike = lanes.iter().all(|loads| {
            let (these, those) = (loads.projected(), first.projected());
            these.len() == those.len() && these.iter().zip(those).all(|(a, b)| a.acts_as(b))
        });
    }

    pub(super) fn refused(&self) -> Option<&[Option<StepError>; LANES]> {
        self.any_refused.then_some(&self.refused)
    }

    pub(super) fn together(&self) -> bool {
        self.together
    }
}

fn likeness(first: &[Entry], other: &[Entry]) -> Likeness {
    let pairs = || first.iter().zip(other);
    if first.len() != other.len() || !pairs().all(|(a, b)| a.has_form_of(b)) {
        Likeness::Different
    } else if pairs().all(|(a, b)| a.acts_as(b)) {
        Likeness::Equal
    } else {
        Likeness::Form
    }
}

/// The loads of every instance of a chunk.
pub(super) struct LaneLoads<'a> {
    pub(super) lanes: &'a [&'a Acting; LANES],
    pub(super) known: &'a KnownLoads,
}

/// What hosts set, side by side: constant over a step.
#[derive(Clone, Debug)]
pub(super) struct HeldLoads {
    /// On every slot there can be.
    wrenches: Vec<Wrench<Lanes>>,
    on_a: Wrench<Lanes>,
    /// On the modes - (m).
    modal: Vec<Lanes>,
}

impl HeldLoads {
    pub(super) fn new(model: &Model) -> Self {
        HeldLoads {
            wrenches: vec![Wrench::default(); model.n_carriers()],
            on_a: Wrench::default(),
            modal: vec![Lanes::default(); model.n_modes()],
        }
    }

    /// Takes over what is set now.
    #[inline(always)]
    pub(super) fn take(&mut self, loads: &LaneLoads) {
        let lanes = loads.lanes;
        let [first, ..] = lanes;
        for (slot, held) in self.wrenches.iter_mut().enumerate().take(first.map().slots.len()) {
            let each = lanes.map(|loads| loads.wrenches.get(slot).copied().unwrap_or_default());
            *held = Wrench::side_by_side(&each);
        }
        if first.direct().is_none() {
            return;
        }
        let parts = lanes.map(|loads| loads.direct().and_then(|direct| direct.parts()));
        self.on_a =
            Wrench::side_by_side(&parts.map(|parts| parts.map_or_else(Wrench::default, |parts| *parts.0)));
        for (mode, held) in self.modal.iter_mut().enumerate() {
            *held =
                Lanes(parts.map(|parts| parts.and_then(|parts| parts.1.get(mode)).copied().unwrap_or(0.0)));
        }
    }

    pub(super) fn wrenches(&self) -> &[Wrench<Lanes>] {
        &self.wrenches
    }

    pub(super) fn modal(&self) -> &[Lanes] {
        &self.modal
    }

    /// As `Direct::on_frame_a` in a model written about A.
    #[inline(always)]
    pub(super) fn on_frame_a(&self, attitude: &Mat3<Lanes>) -> Vec6<Lanes> {
        let Wrench { dead, body, node } = self.on_a;
        let turned = |dead, body, node| add(add(mul_t(attitude, dead), body), node);
        join(turned(dead.0, body.0, node.0), turned(dead.1, body.1, node.1))
    }
}

impl LaneLoads<'_> {
    /// Whether the projected forces of all of them differ in nothing but their functions of time.
    pub(super) fn projected_alike(&self) -> bool {
        self.known.projected_alike
    }

    /// Adds the loads of load cases to the wrenches on the slots.
    #[inline(always)]
    pub(super) fn add_entries(&self, at: &LaneMotion, slots: &mut [Wrench<Lanes>]) {
        let [first, ..] = self.lanes;
        if self.known.entries == Likeness::Different {
            for (lane, loads) in self.lanes.iter().enumerate() {
                loads.add_entries_to_lane(&variables(at, lane), lane, slots);
            }
            return;
        }
        // As alone: entries of one function of time follow each other.
        let mut last: Option<([&TimeFunction; LANES], Lanes)> = None;
        for (index, entry) in first.entries().iter().enumerate() {
            let mut each = [entry; LANES];
            for (entry, loads) in each.iter_mut().zip(self.lanes) {
                if let Some(its) = loads.entries().get(index) {
                    *entry = its;
                }
            }
            let times = each.map(Entry::time);
            let factor = match last {
                Some((known, factor)) if same(&known, &times) => factor,
                _ => factors(times, at),
            };
            last = Some((times, factor));
            match slots.get_mut(entry.slot()) {
                Some(slot) if self.known.entries == Likeness::Equal => entry.add_to(slot, factor),
                Some(slot) => Entry::add_side_by_side(&each, slot, factor),
                None => {}
            }
        }
    }

    /// What the functions of time of the projected forces at this place are now.
    #[inline(always)]
    pub(super) fn factors(&self, place: usize, at: &LaneMotion) -> Lanes {
        let [first, ..] = self.lanes;
        let Some(forces) = first.projected().get(place) else { return Lanes::default() };
        let mut times = [forces.time(); LANES];
        for (time, loads) in times.iter_mut().zip(self.lanes) {
            if let Some(its) = loads.projected().get(place) {
                *time = its.time();
            }
        }
        factors(times, at)
    }
}

fn same(a: &[&TimeFunction; LANES], b: &[&TimeFunction; LANES]) -> bool {
    a.iter().zip(b).all(|(a, b)| core::ptr::eq(*a, *b))
}

/// Functions of time, one for each lane.
#[inline(always)]
fn factors(times: [&TimeFunction; LANES], at: &LaneMotion) -> Lanes {
    let [first, ..] = times;
    let t = at.t.get(0);
    if !first.sees_motion() && at.t == Lanes::of(t) && same(&times, &[first; LANES]) {
        return Lanes::of(first.value(&Variables { t, ..Variables::default() }));
    }
    let mut factors = Lanes::default();
    for (lane, time) in times.iter().enumerate() {
        factors.set(lane, time.value(&variables(at, lane)));
    }
    factors
}

#[inline(always)]
pub(super) fn variables(at: &LaneMotion, lane: usize) -> Variables {
    let three = |values: [&Lanes; 3]| values.map(|value| value.get(lane));
    let [v_x, v_y, v_z, w_x, w_y, w_z] = &at.beta;
    let [x, y, z] = &at.position;
    Variables {
        t: at.t.get(lane),
        v_a: three([v_x, v_y, v_z]),
        w_a: three([w_x, w_y, w_z]),
        r_g: three([x, y, z]),
    }
}
