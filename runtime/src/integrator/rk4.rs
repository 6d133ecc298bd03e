//! Explicit classical Runge-Kutta of fourth order on `(q, q_dot, beta*, zeta, r_G)`.

use alloc::{vec, vec::Vec};

use self::Accelerations::{Solve, Solved};
use super::prescribed::between;
use crate::equations::{self, Motion, Workspace, attitude_rate, forces};
use crate::four::{Four, add_scaled, plus};
use crate::loading::Acting;
use crate::math::{Vec6, matrix, mul, normalised, split};
use crate::model::Model;
use crate::prescribed::{Held, PrescribedMotion};
use crate::state::{State, true_velocity};

/// Stage vectors, padded. The flat order is `q`, `u = (q_dot, beta*)`, `zeta`, `r_G`.
#[derive(Clone, Debug)]
pub(crate) struct Stages {
    start: Vec<Four>,
    stage: Vec<Four>,
    slope: Vec<Four>,
    sum: Vec<Four>,
}

impl Stages {
    pub(crate) fn new(model: &Model) -> Self {
        let zero = vec![[0.0; 4]; (2 * model.n_modes() + 13).div_ceil(4)];
        Stages { start: zero.clone(), stage: zero.clone(), slope: zero.clone(), sum: zero }
    }
}

/// Motion of A that a host prescribes over a step.
#[derive(Clone, Copy)]
pub(crate) struct Course<'a> {
    pub(crate) start: &'a PrescribedMotion,
    pub(crate) end: &'a PrescribedMotion,
    pub(crate) held: &'a Held,
}

/// One step of `dt` from `state` into `next`, on the course of a host where there is one. `solved`: the accelerations of the state are those
/// under these loads.
#[allow(clippy::too_many_arguments)]
pub(crate) fn step(
    model: &Model,
    dt: f64,
    state: &State,
    loads: &Acting,
    course: Option<Course>,
    solved: bool,
    work: &mut Workspace,
    stages: &mut Stages,
    next: &mut State,
) {
    work.vectors.run(
        (model, dt, state, loads, course, solved, work, stages, next),
        #[inline(always)]
        |(model, dt, state, loads, course, solved, work, stages, next)| {
            march(model, dt, state, loads, course.as_ref(), solved, work, stages, next);
        },
    );
}

#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn march(
    model: &Model,
    dt: f64,
    state: &State,
    loads: &Acting,
    course: Option<&Course>,
    solved: bool,
    work: &mut Workspace,
    stages: &mut Stages,
    next: &mut State,
) {
    next.copy_from(state);
    next.advance_time(dt);
    let Stages { start, stage, slope, sum } = stages;
    pack(state, start.as_flattened_mut());
    // (time, fraction of dt to the stage, weight of its slope); the last stage sits exactly on the end of the step.
    let middle = state.time + 0.5 * dt;
    let tableau = [(state.time, 0.0, 1.0), (middle, 0.5, 2.0), (middle, 0.5, 2.0), (next.time, 1.0, 1.0)];
    sum.fill([0.0; 4]);
    slope.fill([0.0; 4]);
    let mut solved = solved.then_some(state.u_dot.as_slice());
    for (t, fraction, weight) in tableau {
        let h = fraction * dt;
        for ((stage, start), slope) in stage.iter_mut().zip(start.iter()).zip(slope.iter()) {
            *stage = plus(*start, h, *slope);
        }
        let stage = stage.as_flattened_mut();
        let held = course.map(|course| {
            let motion = between(course.start, course.end, dt, fraction);
            put_motion(model, &motion, stage);
            (course.held, motion.rate)
        });
        let accelerations = solved.take().map_or(Solve(held.as_ref()), Solved);
        rate(model, loads, t, stage, accelerations, work, slope.as_flattened_mut());
        add_scaled(sum, weight, slope);
    }
    add_scaled(start, dt / 6.0, sum);
    unpack(start.as_flattened(), next);
    if let Some(course) = course {
        model.set_motion(next, course.end);
    }
    next.accelerations_known = false;
}

/// Puts `beta*`, attitude and position of a prescribed motion into the flat state.
fn put_motion(model: &Model, motion: &PrescribedMotion, y: &mut [f64]) {
    let m = model.n_modes();
    let Some((modes, rigid)) = y.split_at_mut_checked(2 * m) else { return };
    let beta_star = model.own_velocity(&motion.velocity, modes.get(m..).unwrap_or_default());
    let values = beta_star.iter().chain(&motion.attitude).chain(&motion.position);
    for (y, value) in rigid.iter_mut().zip(values) {
        *y = *value;
    }
}

/// Where the accelerations of a stage come from.
enum Accelerations<'a> {
    /// The equations of motion; where A is held, under its prescribed rate.
    Solve(Option<&'a (&'a Held, Vec6)>),
    /// They are known.
    Solved(&'a [f64]),
}

/// Slope of the flat state.
#[inline(always)]
fn rate(
    model: &Model,
    loads: &Acting,
    t: f64,
    y: &[f64],
    accelerations: Accelerations,
    work: &mut Workspace,
    dy: &mut [f64],
) {
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
    let at = Motion { t, q, u, attitude: matrix(zeta), position, beta };
    match accelerations {
        Solve(held) => {
            forces(model, loads, &at, work);
            match held {
                None => equations::accelerations(model, &at, work, u_rate),
                Some((held, rate)) => model.held_accelerations(held, &at, rate, work, u_rate),
            }
        }
        Solved(known) => {
            copy(known, u_rate);
        }
    }
    let (v, w) = split(&beta);
    copy(q_dot, q_rate);
    *zeta_rate = attitude_rate(zeta, w);
    *r_rate = mul(&at.attitude, v);
}

#[inline(always)]
fn pack(state: &State, y: &mut [f64]) {
    let rest = copy(&state.q, y);
    let rest = copy(&state.q_dot, rest);
    let rest = copy(&state.beta_star, rest);
    let rest = copy(&state.attitude, rest);
    copy(&state.position, rest);
}

/// Copies to the start of `to`; what is left of it.
#[inline(always)]
pub(crate) fn copy<'a, R: Copy>(from: &[R], to: &'a mut [R]) -> &'a mut [R] {
    let Some((start, rest)) = to.split_at_mut_checked(from.len()) else { return &mut [] };
    for (to, from) in start.iter_mut().zip(from) {
        *to = *from;
    }
    rest
}

#[inline(always)]
fn unpack(y: &[f64], state: &mut State) {
    let State { q, q_dot, beta_star, attitude, position, .. } = state;
    let parts: [&mut [f64]; 5] = [q, q_dot, beta_star, &mut *attitude, position];
    let mut y = y;
    for part in parts {
        let Some((values, rest)) = y.split_at_checked(part.len()) else { break };
        copy(values, part);
        y = rest;
    }
    *attitude = normalised(*attitude);
}

/// Longest step for which the oscillator `omega`, damping ratio `ratio`, does not grow: the smallest positive `dt` with
/// `|R(lambda dt)| = 1`, `R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24`. It is `2 sqrt(2) / omega` without damping.
pub(crate) fn stable_dt(omega: f64, ratio: f64) -> f64 {
    // Eigenvalues of unit frequency: a complex pair, or two negative reals of which the larger decides.
    let (real, imaginary) = if ratio < 1.0 {
        (-ratio, libm::sqrt(1.0 - ratio * ratio))
    } else {
        (-(ratio + libm::sqrt(ratio * ratio - 1.0)), 0.0)
    };
    if ratio == 0.0 {
        return 2.0 * core::f64::consts::SQRT_2 / omega;
    }
    let size = libm::sqrt(real * real + imaginary * imaginary);
    let grows = |x: f64| growth(real / size * x, imaginary / size * x) > 1.0;
    // The boundary of the region is between 2.6 and 3.4 from the origin along every ray of the left half plane.
    let (mut low, mut high) = (2.5, 3.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    low / size / omega
}

/// `|R(x + i y)|^2`.
fn growth(x: f64, y: f64) -> f64 {
    let (mut re, mut im) = (1.0, 0.0);
    for n in [4.0, 3.0, 2.0, 1.0] {
        (re, im) = (1.0 + (x * re - y * im) / n, (x * im + y * re) / n);
    }
    re * re + im * im
}
