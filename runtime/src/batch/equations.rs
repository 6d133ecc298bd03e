//! The equations of motion of [`crate::equations`] for the instances of a chunk: the same operations in the same order.

use alloc::{sync::Arc, vec, vec::Vec};

use super::contraction::LaneContraction;
use super::loads::{HeldLoads, LaneLoads, variables};
use crate::equations::rigid_net;
use crate::loading::{LoadMap, Wrench, nodal_forces};
use crate::math::{Mat3, Vec3, Vec6, constant_vector, mul_t, mul6_symmetric};
use crate::model::Model;
use crate::real::{Lanes, Real};

/// Scratch of an evaluation, as [`crate::Workspace`].
#[derive(Clone, Debug)]
pub(super) struct LaneWorkspace {
    /// The same for all batches of a model and their copies.
    contraction: Arc<LaneContraction>,
    pub(super) gyroscopic: Vec<Lanes>,
    pub(super) external: Vec<Lanes>,
    /// Of the step that is made.
    pub(super) held: HeldLoads,
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
    /// `(q, u)`, and what comes after it in a motion.
    pub(super) modal: &'a [Lanes],
    pub(super) q: &'a [Lanes],
    pub(super) u: &'a [Lanes],
    pub(super) attitude: Mat3<Lanes>,
    pub(super) position: Vec3<Lanes>,
    pub(super) beta: Vec6<Lanes>,
}

impl LaneWorkspace {
    /// With room for loads on every point and station.
    pub(super) fn new(model: &Model) -> Self {
        let (n, carriers, zero) = (model.n_modes() + 6, model.n_carriers(), Lanes::default());
        LaneWorkspace {
            contraction: Arc::new(LaneContraction::new(&model.contraction)),
            gyroscopic: vec![zero; n],
            external: vec![zero; n],
            held: HeldLoads::new(model),
            wrenches: vec![Wrench::default(); carriers],
            displacement: vec![zero; 6 * carriers],
            force: vec![zero; 6 * carriers + 6],
            one: (vec![0.0; model.n_modes()], vec![0.0; model.n_modes()]),
            damped: vec![zero; model.n_modes()],
            gravity: model.gravity(),
        }
    }
}

/// As [`crate::equations::forces`].
#[inline(always)]
pub(super) fn forces(model: &Model, loads: &LaneLoads, at: &LaneMotion, work: &mut LaneWorkspace) {
    work.contraction.apply(at.modal, &at.beta, &mut work.gyroscopic);
    if let Some(damping) = &model.damping {
        damping.apply(at.u, &mut work.damped);
        for (force, damped) in work.gyroscopic.iter_mut().zip(&work.damped) {
            *force += *damped;
        }
    }
    generalised_loads(loads, at, work);
    if work.gravity != [0.0; 3] {
        model.weight.add(mul_t(&at.attitude, constant_vector(&work.gravity)), at.q, &mut work.external);
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
    let LaneWorkspace { external, held, wrenches, displacement, force, one, .. } = work;
    let (Some(wrenches), Some(displacement), Some(force), Some((elastic, rigid))) = (
        wrenches.get_mut(..slots.len()),
        displacement.get_mut(..n_dof),
        force.get_mut(..n_dof + 6),
        external.split_at_mut_checked(at.q.len()),
    ) else {
        return;
    };
    wrenches.iter_mut().zip(held.wrenches()).for_each(|(wrench, held)| *wrench = *held);
    loads.add_entries(at, wrenches);
    shapes.apply(at.q, displacement);
    let mut resultant = nodal_forces(slots, wrenches, &at.attitude, displacement, force);
    elastic.fill(Lanes::default());
    if loads.projected_alike() {
        for (place, forces) in first.projected().iter().enumerate() {
            forces.add(loads.factors(place, at), &at.attitude, at.q, elastic, &mut resultant);
        }
    } else {
        add_one_by_one(loads, at, one, elastic, &mut resultant);
    }
    // Of one type, either all of the loads have this part or none.
    let is_direct = first.direct().is_some();
    if is_direct {
        let on_a = held.on_frame_a(&at.attitude);
        for (resultant, on_a) in resultant.iter_mut().zip(&on_a) {
            *resultant += *on_a;
        }
    }
    if let Some(last) = force.last_chunk_mut::<6>() {
        *last = resultant;
    }
    projection.add(force, elastic);
    if is_direct {
        for (elastic, force) in elastic.iter_mut().zip(held.modal()) {
            *elastic += *force;
        }
    }
    // As one: lanes taken out of an array by value are copied one by one.
    if let Some(rigid) = rigid.first_chunk_mut::<6>() {
        *rigid = resultant;
    }
}

/// Projected forces that differ from lane to lane.
#[inline(always)]
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
