//! The equations of motion of [`crate::equations`] for the instances of a chunk: the same operations in the same order.

use alloc::{vec, vec::Vec};

use crate::equations::rigid_net;
use crate::expression::Variables;
use crate::loading::{Acting, LoadMap, Wrench, nodal_forces};
use crate::math::{Mat3, Vec3, Vec6, add, join, mul_t, mul6_symmetric, split};
use crate::model::Model;
use crate::real::{LANES, Lanes, Real};
use crate::tensor::Windows;

/// The loads of every instance of a chunk.
pub(super) struct LaneLoads<'a> {
    pub(super) lanes: [&'a Acting; LANES],
    /// Whether the projected forces of all of them differ in nothing but their functions of time.
    alike: bool,
}

impl<'a> LaneLoads<'a> {
    pub(super) fn new(lanes: [&'a Acting; LANES]) -> Self {
        let [first, ..] = &lanes;
        let as_first = |loads: &&Acting| {
            let (these, those) = (loads.projected(), first.projected());
            these.len() == those.len() && these.iter().zip(those).all(|(a, b)| a.acts_as(b))
        };
        LaneLoads { alike: lanes.iter().all(as_first), lanes }
    }
}

/// Scratch of an evaluation, as [`crate::Workspace`].
#[derive(Clone, Debug)]
pub(super) struct LaneWorkspace {
    products: Windows<Lanes>,
    pub(super) gyroscopic: Vec<Lanes>,
    pub(super) external: Vec<Lanes>,
    wrenches: Vec<Wrench<Lanes>>,
    displacement: Vec<Lanes>,
    force: Vec<Lanes>,
    /// Amplitudes and elastic rows of one instance - (m).
    one: (Vec<f64>, Vec<f64>),
    damped: Vec<Lanes>,
    /// In G, m/s^2.
    gravity: Vec3,
}

/// What the forces depend on.
pub(super) struct LaneMotion<'a> {
    pub(super) t: Lanes,
    pub(super) q: &'a [Lanes],
    pub(super) u: &'a [Lanes],
    pub(super) attitude: Mat3<Lanes>,
    pub(super) position: Vec3<Lanes>,
    pub(super) beta: Vec6<Lanes>,
}

impl LaneWorkspace {
    pub(super) fn new(model: &Model) -> Self {
        let (n, points, zero) = (model.n_modes() + 6, model.n_points(), Lanes::default());
        LaneWorkspace {
            products: model.contraction.products(),
            gyroscopic: vec![zero; n],
            external: vec![zero; n],
            wrenches: vec![Wrench::default(); points],
            displacement: vec![zero; 6 * points],
            force: vec![zero; 6 * points + 6],
            one: (vec![0.0; model.n_modes()], vec![0.0; model.n_modes()]),
            damped: vec![zero; model.n_modes()],
            gravity: model.gravity(),
        }
    }
}

/// As [`crate::equations::forces`].
#[inline(always)]
pub(super) fn forces(model: &Model, loads: &LaneLoads, at: &LaneMotion, work: &mut LaneWorkspace) {
    model.contraction.apply(at.u, at.q, &at.beta, &mut work.products, &mut work.gyroscopic);
    if let Some(damping) = &model.damping {
        damping.apply(at.u, &mut work.damped);
        for (force, damped) in work.gyroscopic.iter_mut().zip(&work.damped) {
            *force += *damped;
        }
    }
    generalised_loads(loads, at, work);
    if work.gravity != [0.0; 3] {
        model.weight.add(mul_t(&at.attitude, work.gravity.map(Lanes::of)), at.q, &mut work.external);
    }
    if let Some(trim) = &model.data().trim {
        for (external, elastic) in work.external.iter_mut().zip(&trim.elastic_force) {
            *external -= Lanes::of(*elastic);
        }
    }
}

/// As [`crate::loading::generalised_loads`]; all instances load the same points.
#[inline(always)]
fn generalised_loads(loads: &LaneLoads, at: &LaneMotion, work: &mut LaneWorkspace) {
    let [first, ..] = loads.lanes;
    // Every field by name: what is new has to act here too.
    // Points on a curve come with consistent inertia, which has no lanes.
    let LoadMap {
        n_modes: _,
        n_points: _,
        slots,
        n_dof,
        displacement: shapes,
        projection,
        curve: _,
        polynomial: _,
    } = first.map();
    let n_dof = *n_dof;
    let LaneWorkspace { external, wrenches, displacement, force, one, .. } = work;
    let (Some(wrenches), Some(displacement), Some(force), Some((elastic, rigid))) = (
        wrenches.get_mut(..slots.len()),
        displacement.get_mut(..n_dof),
        force.get_mut(..n_dof + 6),
        external.split_at_mut_checked(at.q.len()),
    ) else {
        return;
    };
    wrenches.fill(Wrench::default());
    for (lane, loads) in loads.lanes.iter().enumerate() {
        loads.gather_lane(&variables(at, lane), lane, wrenches);
    }
    shapes.apply(at.q, displacement);
    let mut resultant = nodal_forces(slots, wrenches, &at.attitude, displacement, force);
    elastic.fill(Lanes::default());
    if loads.alike {
        for (place, forces) in first.projected().iter().enumerate() {
            forces.add(factors(loads, place, at), &at.attitude, at.q, elastic, &mut resultant);
        }
    } else {
        add_one_by_one(loads, at, one, elastic, &mut resultant);
    }
    // Of one type, either all of the loads have this part or none.
    let is_direct = first.direct().is_some();
    if is_direct {
        let on_a = on_frame_a(loads, &at.attitude);
        for (resultant, on_a) in resultant.iter_mut().zip(on_a) {
            *resultant += on_a;
        }
    }
    if let Some(last) = force.last_chunk_mut::<6>() {
        *last = resultant;
    }
    projection.add(force, elastic);
    if is_direct {
        add_modal(loads, elastic);
    }
    for (rigid, resultant) in rigid.iter_mut().zip(resultant) {
        *rigid = resultant;
    }
}

/// What the functions of time of the projected forces at this place are now.
#[inline(always)]
fn factors(loads: &LaneLoads, place: usize, at: &LaneMotion) -> Lanes {
    let mut factors = Lanes::default();
    for (lane, loads) in loads.lanes.iter().enumerate() {
        if let Some(forces) = loads.projected().get(place) {
            factors.set(lane, forces.time().value(&variables(at, lane)));
        }
    }
    factors
}

/// Projected forces that differ from lane to lane.
fn add_one_by_one(
    loads: &LaneLoads,
    at: &LaneMotion,
    (q, rows): &mut (Vec<f64>, Vec<f64>),
    elastic: &mut [Lanes],
    resultant: &mut Vec6<Lanes>,
) {
    for (lane, loads) in loads.lanes.iter().enumerate() {
        q.iter_mut().zip(at.q).for_each(|(to, from)| *to = from.get(lane));
        rows.fill(0.0);
        let attitude = at.attitude.map(|row| row.map(|x| x.get(lane)));
        let mut sum = resultant.map(|x| x.get(lane));
        for forces in loads.projected() {
            forces.add(forces.time().value(&variables(at, lane)), &attitude, q, rows, &mut sum);
        }
        elastic.iter_mut().zip(rows.iter()).for_each(|(to, from)| to.set(lane, *from));
        resultant.iter_mut().zip(sum).for_each(|(to, from)| to.set(lane, from));
    }
}

#[inline(always)]
fn variables(at: &LaneMotion, lane: usize) -> Variables {
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

/// As `Direct::on_frame_a` in a model written about A.
#[inline(always)]
fn on_frame_a(loads: &LaneLoads, attitude: &Mat3<Lanes>) -> Vec6<Lanes> {
    let mut wrench = Wrench::<Lanes>::default();
    for (lane, loads) in loads.lanes.iter().enumerate() {
        if let Some((one, _)) = loads.direct().and_then(|direct| direct.parts()) {
            wrench.set_lane(lane, one);
        }
    }
    let Wrench { dead, body, node } = wrench;
    let turned = |dead, body, node| add(add(mul_t(attitude, dead), body), node);
    join(turned(dead.0, body.0, node.0), turned(dead.1, body.1, node.1))
}

#[inline(always)]
fn add_modal(loads: &LaneLoads, elastic: &mut [Lanes]) {
    for (lane, loads) in loads.lanes.iter().enumerate() {
        if let Some((_, modal)) = loads.direct().and_then(|direct| direct.parts()) {
            for (elastic, force) in elastic.iter_mut().zip(modal) {
                elastic.set(lane, elastic.get(lane) + force);
            }
        }
    }
}

/// As [`crate::equations::accelerations`].
#[inline(always)]
pub(super) fn accelerations(model: &Model, at: &LaneMotion, work: &LaneWorkspace, u_dot: &mut [Lanes]) {
    let net = work.external.iter().zip(&work.gyroscopic);
    let elastic = model.elastic.iter().zip(at.q).zip(at.u);
    for ((u_dot, (external, gyroscopic)), ((mode, q), q_dot)) in u_dot.iter_mut().zip(net).zip(elastic) {
        let net = *external - *gyroscopic;
        let own = net - Lanes::of(mode.damping) * *q_dot - Lanes::of(mode.stiffness) * *q;
        *u_dot = own * Lanes::of(mode.inverse_mass);
    }
    if let Some(rigid) = u_dot.last_chunk_mut::<6>() {
        *rigid = mul6_symmetric(&model.rigid_mass_inverse, &rigid_net(&work.external, &work.gyroscopic));
    }
}

/// Velocity and angular velocity.
#[inline(always)]
pub(super) fn parts(beta: &Vec6<Lanes>) -> (Vec3<Lanes>, Vec3<Lanes>) {
    split(beta)
}
