//! Generalised loads of all that acts, in one evaluation (theory section 4).

use alloc::{vec, vec::Vec};

use crate::curve::CurveScratch;
use crate::expression::Variables;
use crate::math::{
    Mat3, Vec6, add, add_scaled, constant, constant_vector, cross, join, mat_mul, mul, mul_t,
    rotation_and_tangential,
};
use crate::model::Model;
use crate::real::Real;

use super::map::Slot;
use super::{Acting, Wrench};

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
