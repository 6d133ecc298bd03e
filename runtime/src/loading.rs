//! Loads made ready for a model: load cases ([`PreparedLoads`]); wrenches a host sets every step are [`crate::LoadSet`].
//!
//! Both know which points they load; the modal shapes of those points are gathered once, so that the positions of all
//! loaded points are one matrix times `q` and the generalised loads the transposed matrix times the forces.

use alloc::{collections::BTreeMap, sync::Arc, vec, vec::Vec};

use crate::base_motion::BaseMotion;
use crate::curve::{Curve, CurveScratch};
use crate::dense::Dense;
use crate::direct::Direct;
use crate::error::ModelError;
use crate::estimate::Estimated;
use crate::expression::Variables;
use crate::forward::{Forward, ForwardVariables};
use crate::identity::Identity;
use crate::loads::{DistributedFrame, DistributedLoad, Load, LoadCase, LoadFrame};
use crate::math::{
    Mat3, Vec3, Vec6, add, add_scaled, axpy, constant, constant_vector, cross, join, mat_mul, mul, mul_t,
    rotation_and_tangential, split,
};
use crate::model::Model;
use crate::polynomial::Polynomial;
use crate::projected::Projected;
use crate::real::{LANES, Lanes, Real};
use crate::time::TimeFunction;
use crate::validate;

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
    fn add_force(&mut self, frame: Axes, factor: R, force: Vec3<R>) {
        let (f, _) = self.in_axes(frame);
        *f = axpy(*f, factor, force);
    }

    #[inline(always)]
    fn add_moment(&mut self, frame: Axes, factor: R, moment: Vec3<R>) {
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
    fn of<R: Real>(&self) -> Wrench<R> {
        let of = |(f, m): (Vec3, Vec3)| (f.map(R::of), m.map(R::of));
        Wrench { dead: of(self.dead), body: of(self.body), node: of(self.node) }
    }
}

impl Wrench<Lanes> {
    /// Adds an entry to one lane.
    #[inline(always)]
    fn add_lane(&mut self, lane: usize, entry: &Entry, factor: f64) {
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

/// The loaded points of a model and their modal shapes.
#[derive(Clone, Debug)]
pub(crate) struct LoadMap {
    pub(crate) n_modes: usize,
    pub(crate) n_points: usize,
    pub(crate) slots: Vec<Slot>,
    pub(crate) n_dof: usize,
    /// Displacements of all slots per unit modal amplitude - (n_dof x m).
    pub(crate) displacement: Dense,
    /// Elastic generalised loads from the forces on all slots and from their resultant, `(Phi_S^t, Phi_R^t)`
    /// - (m x (n_dof + 6)).
    pub(crate) projection: Dense,
    /// Second and third order of the displacements of all slots - (n_dof rows).
    pub(crate) curve: Curve,
    /// The same by monomials, for the Jacobian.
    pub(crate) polynomial: Polynomial,
}

/// A loaded point. It has three columns in the map, six when its rotation matters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Slot {
    point: usize,
    node_position: Vec3,
    node_rotation: Mat3,
    offset: Vec3,
    /// Where it is without deformation.
    position: Vec3,
    rotates: bool,
    /// Whether moments act, and loads in node axes.
    moments: bool,
    follows: bool,
}

/// What acts on a point, as far as it is known when loads are prepared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Loaded {
    pub(crate) point: usize,
    pub(crate) moments: bool,
    pub(crate) follows: bool,
}

impl LoadMap {
    /// The point of each slot.
    pub(crate) fn points(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.slots.iter().map(|slot| slot.point)
    }

    /// `points`: each point once.
    pub(crate) fn new(model: &Model, points: &[Loaded]) -> Self {
        let m = model.n_modes();
        let mut slots = Vec::with_capacity(points.len());
        // Which point and which of its six components every column is.
        let mut dofs: Vec<(usize, usize)> = Vec::new();
        for &Loaded { point: index, moments, follows } in points {
            let Some(point) = model.carrier(index) else { continue };
            let node_turns = point.phi.iter().any(|phi| split(phi).1 != [0.0; 3]);
            let rotates = node_turns && (moments || follows || point.offset != [0.0; 3]);
            dofs.extend((0..if rotates { 6 } else { 3 }).map(|component| (index, component)));
            slots.push(Slot {
                point: index,
                node_position: point.node_position,
                node_rotation: point.node_rotation,
                offset: point.offset,
                position: point.position,
                rotates,
                moments,
                follows,
            });
        }
        let n_dof = dofs.len();
        let shape = |dof: usize, mode: usize| {
            let (point, component) = dofs.get(dof)?;
            model.carrier(*point)?.phi.get(mode)?.get(*component).copied()
        };
        let rigid = |component: usize, mode: usize| model.phi_r.get(mode)?.get(component).copied();
        let displacement = Dense::new(n_dof, m, |dof, mode| shape(dof, mode).unwrap_or(0.0));
        let projection = Dense::new(m, n_dof + 6, |mode, dof| {
            match dof.checked_sub(n_dof) {
                None => shape(dof, mode),
                Some(component) => rigid(component, mode),
            }
            .unwrap_or(0.0)
        });
        let curve = curve(model, dofs.iter().copied());
        let polynomial = polynomial(model, dofs.iter().copied());
        LoadMap {
            n_modes: m,
            n_points: model.n_points(),
            slots,
            n_dof,
            displacement,
            projection,
            curve,
            polynomial,
        }
    }
}

/// Second and third order of displacements: (point, component).
fn curve(model: &Model, dofs: impl Iterator<Item = (usize, usize)> + Clone) -> Curve {
    let Some(lagrangian) = &model.data().lagrangian else { return Curve::default() };
    let rows = dofs.filter_map(|(point, component)| Some((lagrangian.points.get(point)?, component)));
    Curve::gather(model.n_modes(), rows)
}

/// The same by monomials.
pub(crate) fn polynomial(model: &Model, dofs: impl Iterator<Item = (usize, usize)>) -> Polynomial {
    let Some(lagrangian) = &model.data().lagrangian else { return Polynomial::default() };
    Polynomial::gather(dofs.filter_map(|(point, component)| Some((lagrangian.points.get(point)?, component))))
}

/// Displacements of all points and stations.
pub(crate) fn whole_curve(model: &Model) -> Polynomial {
    polynomial(model, (0..model.n_carriers()).flat_map(|point| (0..6).map(move |k| (point, k))))
}

/// Scratch for the loads of one evaluation.
#[derive(Clone, Debug)]
pub(crate) struct LoadWorkspace {
    wrenches: Vec<Wrench>,
    displacement: Vec<f64>,
    /// On every column, then the resultant.
    force: Vec<f64>,
    /// For the curve of any selection of points.
    curve: CurveScratch,
}

impl LoadWorkspace {
    pub(crate) fn new(model: &Model) -> Self {
        let n = model.n_carriers();
        LoadWorkspace {
            wrenches: vec![Wrench::default(); n],
            displacement: vec![0.0; 6 * n],
            force: vec![0.0; 6 * n + 6],
            curve: CurveScratch::new(
                model.n_modes(),
                6 * n,
                model.data().lagrangian.iter().flat_map(|it| &it.points),
            ),
        }
    }
}

/// Generalised loads at the deformed state (theory section 4): elastic rows `Phi_S^t Q_S + Phi_R^t Q_R` and rigid rows
/// `Q_R`, into `external` - (m + 6). `attitude` is `C^{GA}`.
#[inline(always)]
pub(crate) fn generalised_loads(
    loads: &Acting,
    variables: &Variables,
    q: &[f64],
    attitude: &Mat3,
    work: &mut LoadWorkspace,
    external: &mut [f64],
) {
    let map = loads.map();
    let (Some(wrenches), Some(displacement), Some(force), Some((elastic, rigid))) = (
        work.wrenches.get_mut(..map.slots.len()),
        work.displacement.get_mut(..map.n_dof),
        work.force.get_mut(..map.n_dof + 6),
        external.split_at_mut_checked(q.len()),
    ) else {
        return;
    };
    wrenches.fill(Wrench::default());
    loads.gather(variables, wrenches);
    map.displacement.apply(q, displacement);
    if !map.curve.is_empty() {
        map.curve.add_values(q, &mut work.curve, displacement);
    }
    let mut resultant = nodal_forces(&map.slots, wrenches, attitude, displacement, force);
    elastic.fill(0.0);
    for forces in loads.projected() {
        forces.add(forces.time().value(variables), attitude, q, elastic, &mut resultant);
    }
    let direct = loads.direct().map(|direct| (direct, direct.on_frame_a(attitude, q)));
    if let Some((_, on_a)) = &direct {
        add_scaled(&mut resultant, 1.0, &on_a.resultant);
    }
    if let Some(last) = force.last_chunk_mut::<6>() {
        *last = resultant;
    }
    map.projection.add(force, elastic);
    if !map.curve.is_empty() {
        map.curve.pull_back(force, &mut work.curve, elastic);
    }
    if let Some((direct, on_a)) = &direct {
        direct.add_to_modes(on_a, elastic);
    }
    for (rigid, resultant) in rigid.iter_mut().zip(resultant) {
        *rigid = resultant;
    }
}

/// Forces on the columns of every slot, `(f_A, T(theta)^t Q^t m_A)`, and the resultant about the origin of A.
#[inline(always)]
pub(crate) fn nodal_forces<R: Real>(
    slots: &[Slot],
    wrenches: &[Wrench<R>],
    attitude: &Mat3<R>,
    mut displacement: &[R],
    mut force: &mut [R],
) -> Vec6<R> {
    let zero = [R::of(0.0); 3];
    let (mut force_sum, mut moment_sum) = (zero, zero);
    for (slot, wrench) in slots.iter().zip(wrenches) {
        let Some((&translation, rest)) = displacement.split_first_chunk::<3>() else { break };
        let Some((force_of_slot, rest_of_force)) = force.split_first_chunk_mut::<3>() else { break };
        (displacement, force) = (rest, rest_of_force);
        let mut f = add(mul_t(attitude, wrench.dead.0), wrench.body.0);
        let mut m = zero;
        if slot.moments {
            m = add(mul_t(attitude, wrench.dead.1), wrench.body.1);
        }
        let position = if slot.rotates {
            let Some((&theta, rest)) = displacement.split_first_chunk::<3>() else { break };
            let Some((moment_of_slot, rest_of_force)) = force.split_first_chunk_mut::<3>() else { break };
            (displacement, force) = (rest, rest_of_force);
            let (turn, tangential) = rotation_and_tangential(theta);
            let node = mat_mul(&constant(&slot.node_rotation), &turn);
            if slot.follows {
                f = add(f, mul(&node, wrench.node.0));
                m = add(m, mul(&node, wrench.node.1));
            }
            let arm = mul(&node, constant_vector(&slot.offset));
            *moment_of_slot = mul_t(&tangential, mul_t(&node, add(m, cross(arm, f))));
            add(add(constant_vector(&slot.node_position), translation), arm)
        } else {
            if slot.follows {
                let node = constant(&slot.node_rotation);
                f = add(f, mul(&node, wrench.node.0));
                m = add(m, mul(&node, wrench.node.1));
            }
            add(constant_vector(&slot.position), translation)
        };
        *force_of_slot = f;
        force_sum = add(force_sum, f);
        moment_sum = add(moment_sum, add(m, cross(position, f)));
    }
    join(force_sum, moment_sum)
}

/// A load case made ready for a model.
#[derive(Clone, Debug)]
pub struct PreparedLoads {
    acting: Acting,
}

/// A load on a slot. Entries whose functions of time are equal share it and follow each other.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    slot: usize,
    axes: Axes,
    force: Vec3,
    moment: Vec3,
    /// Most have none.
    has_moment: bool,
    time: Arc<TimeFunction>,
}

impl Entry {
    fn new(slot: usize, axes: Axes, force: Vec3, moment: Vec3, time: Arc<TimeFunction>) -> Self {
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

/// What acts on a body, whoever made it: steps are compiled for this alone.
#[derive(Clone, Debug)]
pub struct Acting {
    /// Of all but what a host sets.
    identity: Identity,
    pub(crate) map: LoadMap,
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
            map,
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

fn add_forward_entries(entries: &[Entry], variables: &ForwardVariables, slots: &mut [Wrench<Forward>]) {
    for entry in entries {
        if let Some(slot) = slots.get_mut(entry.slot) {
            entry.add_to(slot, entry.time.along(variables));
        }
    }
}

/// The entries with their factors at an instant.
#[inline(always)]
fn with_factors<'a>(entries: &'a [Entry], variables: &Variables) -> impl Iterator<Item = (&'a Entry, f64)> {
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
fn add_entries(entries: &[Entry], variables: &Variables, slots: &mut [Wrench]) {
    for (entry, factor) in with_factors(entries, variables) {
        if let Some(slot) = slots.get_mut(entry.slot) {
            entry.add_to(slot, factor);
        }
    }
}

impl Loads for PreparedLoads {}
