//! Force and moment on a point, and the axes in which their components are given.

use crate::loads::LoadFrame;
use crate::math::{Mat3, Vec3, add, axpy, mul, mul_t};
use crate::real::{LANES, Lanes, Real};

use super::entry::Entry;

/// Force and moment on one point, by the frame their components are in: G, A, node.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wrench<R = f64> {
    pub(crate) dead: ([R; 3], [R; 3]),
    pub(crate) body: ([R; 3], [R; 3]),
    pub(crate) node: ([R; 3], [R; 3]),
}

impl<R: Real> Wrench<R> {
    #[inline(always)]
    fn in_axes(&mut self, frame: Axes) -> (&mut Vec3<R>, &mut Vec3<R>) {
        let (f, m) = match frame {
            Axes::Inertial => &mut self.dead,
            Axes::Body => &mut self.body,
            Axes::Node => &mut self.node,
        };
        (f, m)
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, frame: Axes, factor: R, force: Vec3<R>, moment: Vec3<R>) {
        self.add_force(frame, factor, force);
        self.add_moment(frame, factor, moment);
    }

    #[inline(always)]
    pub(super) fn add_force(&mut self, frame: Axes, factor: R, force: Vec3<R>) {
        let (f, _) = self.in_axes(frame);
        *f = axpy(*f, factor, force);
    }

    #[inline(always)]
    pub(super) fn add_moment(&mut self, frame: Axes, factor: R, moment: Vec3<R>) {
        let (_, m) = self.in_axes(frame);
        *m = axpy(*m, factor, moment);
    }

    /// Force and moment in A: of the loads constant in G, and of those that turn with the body or its node.
    pub(crate) fn in_a(&self, attitude: &Mat3<R>, node: &Mat3<R>) -> [(Vec3<R>, Vec3<R>); 2] {
        let own = |body, own| add(body, mul(node, own));
        [
            (mul_t(attitude, self.dead.0), mul_t(attitude, self.dead.1)),
            (own(self.body.0, self.node.0), own(self.body.1, self.node.1)),
        ]
    }
}

impl Wrench {
    /// The same in other numbers.
    #[inline]
    pub(super) fn of<R: Real>(&self) -> Wrench<R> {
        let of = |(f, m): (Vec3, Vec3)| (f.map(R::of), m.map(R::of));
        Wrench { dead: of(self.dead), body: of(self.body), node: of(self.node) }
    }
}

impl Wrench<Lanes> {
    /// Adds an entry to one lane.
    #[inline(always)]
    pub(super) fn add_lane(&mut self, lane: usize, entry: &Entry, factor: f64) {
        let add = |sums: &mut Vec3<Lanes>, values: Vec3| {
            for (sum, value) in sums.iter_mut().zip(values) {
                sum.set(lane, sum.get(lane) + factor * value);
            }
        };
        let (f, m) = self.in_axes(entry.axes);
        add(f, entry.force);
        if entry.has_moment {
            add(m, entry.moment);
        }
    }

    /// Wrenches of the instances of a chunk.
    #[inline(always)]
    pub(crate) fn side_by_side(each: &[Wrench; LANES]) -> Self {
        let pair = |part: fn(&Wrench) -> (Vec3, Vec3)| {
            let pairs = each.each_ref().map(part);
            (Lanes::side_by_side(&pairs.map(|pair| pair.0)), Lanes::side_by_side(&pairs.map(|pair| pair.1)))
        };
        Wrench { dead: pair(|w| w.dead), body: pair(|w| w.body), node: pair(|w| w.node) }
    }
}

/// Axes in which components are given; a section frame is a constant turn of the node's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Axes {
    Inertial,
    Body,
    Node,
}

/// Components in the axes that carry them, section frames turned into node axes once.
pub(crate) fn resolve(frame: &LoadFrame, force: Vec3, moment: Vec3) -> (Axes, Vec3, Vec3) {
    match frame {
        LoadFrame::Dead => (Axes::Inertial, force, moment),
        LoadFrame::Body => (Axes::Body, force, moment),
        LoadFrame::Follower { section } => (Axes::Node, mul(section, force), mul(section, moment)),
    }
}
