//! RK4 of [`crate::integrator::rk4`] for the instances of a chunk: the same operations in the same order.

use alloc::{vec, vec::Vec};

use super::equations::{LaneMotion, LaneWorkspace, accelerations, forces};
use super::loads::LaneLoads;
use super::state::{LaneState, Motion, MotionMut, copy};
use crate::equations::attitude_rate;
use crate::math::{matrix, mul, normalised, split};
use crate::model::Model;
use crate::real::{Lanes, Real};
use crate::state::true_velocity;

/// Stage vectors in the order of a motion.
#[derive(Clone, Debug)]
pub(super) struct LaneStages {
    stage: Vec<Lanes>,
    slope: Vec<Lanes>,
    sum: Vec<Lanes>,
}

impl LaneStages {
    pub(super) fn new(model: &Model) -> Self {
        let zero = vec![Lanes::default(); 2 * model.n_modes() + 13];
        LaneStages { stage: zero.clone(), slope: zero.clone(), sum: zero }
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
    next.take_time(state);
    next.advance_time(Lanes::of(dt));
    next.copy_accelerations(state);
    next.accelerations_known = Default::default();
    let LaneStages { stage, slope, sum } = stages;
    let zero = Lanes::default();
    // As the stages to come are made: the start and nothing of a slope, which turns -0 into +0.
    stage.iter_mut().zip(&state.motion).for_each(|(stage, start)| *stage = *start + zero);
    let middle = state.time + Lanes::of(0.5 * dt);
    // Time, and fraction of dt from the start to the next stage, where there is one.
    let tableau = [(state.time, Some(0.5)), (middle, Some(0.5)), (middle, Some(1.0)), (next.time, None)];
    for (place, (t, fraction)) in tableau.into_iter().enumerate() {
        rate(model, loads, t, stage, work, slope);
        let all = state.motion.iter().zip(slope.iter()).zip(sum.iter_mut());
        if let Some(fraction) = fraction {
            let h = Lanes::of(fraction * dt);
            let two = Lanes::of(2.0);
            for (((start, slope), sum), stage) in all.zip(stage.iter_mut()) {
                // 0 + 1 slope, then 2 slope.
                *sum = if place == 0 { zero + *slope } else { *sum + two * *slope };
                *stage = *start + h * *slope;
            }
        } else {
            let h = Lanes::of(dt / 6.0);
            for (((start, slope), sum), end) in all.zip(&mut next.motion) {
                *end = *start + h * (*sum + *slope);
            }
        }
    }
    if let Some(end) = MotionMut::of(&mut next.motion) {
        *end.attitude = normalised(*end.attitude);
    }
}

#[inline(always)]
fn rate(model: &Model, loads: &LaneLoads, t: Lanes, y: &[Lanes], work: &mut LaneWorkspace, dy: &mut [Lanes]) {
    let (Some(here), Some(rate)) = (Motion::of(y), MotionMut::of(dy)) else { return };
    let beta = true_velocity(&model.phi_r, here.q_dot, here.beta_star);
    let attitude = matrix(*here.attitude);
    let at = LaneMotion { t, modal: y, q: here.q, u: here.u, attitude, position: *here.position, beta };
    forces(model, loads, &at, work);
    accelerations(model, &at, work, rate.u);
    let (v, w) = split(&beta);
    copy(rate.q, here.q_dot);
    *rate.attitude = attitude_rate(*here.attitude, w);
    *rate.position = mul(&at.attitude, v);
}
