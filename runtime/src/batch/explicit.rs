//! RK4 of [`crate::integrator::rk4`] for the instances of a chunk: the same operations in the same order.

use alloc::{vec, vec::Vec};

use super::equations::{LaneLoads, LaneMotion, LaneWorkspace, accelerations, forces, parts};
use super::state::LaneState;
use crate::equations::attitude_rate;
use crate::integrator::rk4::copy;
use crate::math::{matrix, mul, normalised};
use crate::model::Model;
use crate::real::{Lanes, Real};
use crate::state::true_velocity;

/// Stage vectors in the flat order `q`, `u = (q_dot, beta*)`, `zeta`, `r_G`.
#[derive(Clone, Debug)]
pub(super) struct LaneStages {
    start: Vec<Lanes>,
    stage: Vec<Lanes>,
    slope: Vec<Lanes>,
    sum: Vec<Lanes>,
}

impl LaneStages {
    pub(super) fn new(model: &Model) -> Self {
        let zero = vec![Lanes::default(); 2 * model.n_modes() + 13];
        LaneStages { start: zero.clone(), stage: zero.clone(), slope: zero.clone(), sum: zero }
    }
}

/// One step of `dt` from `state` into `next`.
#[inline(always)]
pub(super) fn step(
    model: &Model,
    dt: f64,
    state: &LaneState,
    loads: &LaneLoads,
    work: &mut LaneWorkspace,
    stages: &mut LaneStages,
    next: &mut LaneState,
) {
    next.copy_from(state);
    next.advance_time(Lanes::of(dt));
    let LaneStages { start, stage, slope, sum } = stages;
    pack(state, start);
    let middle = state.time + Lanes::of(0.5 * dt);
    let tableau = [(state.time, 0.0, 1.0), (middle, 0.5, 2.0), (middle, 0.5, 2.0), (next.time, 1.0, 1.0)];
    sum.fill(Lanes::default());
    slope.fill(Lanes::default());
    for (t, fraction, weight) in tableau {
        let h = Lanes::of(fraction * dt);
        for ((stage, start), slope) in stage.iter_mut().zip(start.iter()).zip(slope.iter()) {
            *stage = *start + h * *slope;
        }
        rate(model, loads, t, stage, work, slope);
        add_scaled(sum, Lanes::of(weight), slope);
    }
    add_scaled(start, Lanes::of(dt / 6.0), sum);
    unpack(start, next);
    next.accelerations_known = Default::default();
}

#[inline(always)]
fn add_scaled(a: &mut [Lanes], s: Lanes, b: &[Lanes]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += s * *b;
    }
}

#[inline(always)]
fn rate(model: &Model, loads: &LaneLoads, t: Lanes, y: &[Lanes], work: &mut LaneWorkspace, dy: &mut [Lanes]) {
    let m = model.n_modes();
    let (Some((q, rest)), Some((q_rate, rate_rest))) = (y.split_at_checked(m), dy.split_at_mut_checked(m))
    else {
        return;
    };
    let (Some((u, rest)), Some((u_rate, rate_rest))) =
        (rest.split_at_checked(m + 6), rate_rest.split_at_mut_checked(m + 6))
    else {
        return;
    };
    let (Some((&zeta, rest)), Some((zeta_rate, r_rate))) =
        (rest.split_first_chunk::<4>(), rate_rest.split_first_chunk_mut::<4>())
    else {
        return;
    };
    let (Some((q_dot, beta_star)), Some(&position), Some(r_rate)) =
        (u.split_last_chunk::<6>(), rest.first_chunk::<3>(), r_rate.first_chunk_mut::<3>())
    else {
        return;
    };
    let beta = true_velocity(&model.phi_r, q_dot, beta_star);
    let at = LaneMotion { t, q, u, attitude: matrix(zeta), position, beta };
    forces(model, loads, &at, work);
    accelerations(model, &at, work, u_rate);
    let (v, w) = parts(&beta);
    for (rate, q_dot) in q_rate.iter_mut().zip(q_dot) {
        *rate = *q_dot;
    }
    *zeta_rate = attitude_rate(zeta, w);
    *r_rate = mul(&at.attitude, v);
}

#[inline(always)]
fn pack(state: &LaneState, y: &mut [Lanes]) {
    let rest = copy(&state.q, y);
    let rest = copy(&state.q_dot, rest);
    let rest = copy(&state.beta_star, rest);
    let rest = copy(&state.attitude, rest);
    copy(&state.position, rest);
}

#[inline(always)]
fn unpack(y: &[Lanes], state: &mut LaneState) {
    let LaneState { q, q_dot, beta_star, attitude, position, .. } = state;
    let parts: [&mut [Lanes]; 5] = [q, q_dot, beta_star, &mut *attitude, position];
    let mut y = y;
    for part in parts {
        let Some((values, rest)) = y.split_at_checked(part.len()) else { break };
        copy(values, part);
        y = rest;
    }
    *attitude = normalised(*attitude);
}
