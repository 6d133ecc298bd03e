//! Newmark and generalised-alpha of [`crate::integrator::implicit`] for the instances of a chunk, as long as plain substitution
//! carries them: the same operations in the same order. An instance that needs Newton's corrections, or fails, is left to the
//! single step.

use alloc::{vec, vec::Vec};

use super::equations::{LaneMotion, LaneWorkspace, forces};
use super::loads::LaneLoads;
use super::state::{LaneState, Motion, MotionMut, copy};
use crate::equations::{about_centre, about_origin, rigid_net, tail};
use crate::integrator::algorithmic::Algorithmic;
use crate::integrator::implicit::{
    MAX_SUBSTITUTIONS, SLOW, STAGNATION, TOLERANCE, floor_of_equilibrium, floor_of_weight, inertial_rate,
};
use crate::integrator::parameters::Parameters;
use crate::math::{
    Mat3, Vec3, Vec6, add, constant_vector, cross, mat_mul, matrix, mul, mul_t_6, mul6_symmetric, normalised,
    quaternion, quaternion_product, scale, split, sub,
};
use crate::model::Model;
use crate::real::{LANES, Lanes, Real};
use crate::state::true_velocity;

/// Memory of a step, as `Implicit`.
#[derive(Clone, Debug)]
pub(super) struct LaneImplicit {
    parameters: Parameters,
    inverse_diagonal: Vec<f64>,
    q_known: Vec<Lanes>,
    q_dot_known: Vec<Lanes>,
    force_known: Vec<Lanes>,
    iterate: Vec<Lanes>,
    image: Vec<Lanes>,
    /// `(q, u)` at the end of the step - (2 m + 6).
    modal: Vec<Lanes>,
    floor: Lanes,
    /// The part of the equilibrium and the weight in it.
    constant_floor: f64,
}

/// What a step knows at its start, rigid part.
struct Start {
    attitude: Mat3<Lanes>,
    w: Vec3<Lanes>,
    v_c: Vec3<Lanes>,
    momentum_known: Vec6<Lanes>,
    rate_known: Vec6<Lanes>,
}

/// What an evaluation finds.
#[derive(Clone, Copy, Default)]
struct Evaluation {
    correction: Lanes,
    size: Lanes,
    turn_quaternion: [Lanes; 4],
    position: Vec3<Lanes>,
    rate: Vec6<Lanes>,
    net: Vec6<Lanes>,
}

impl Evaluation {
    /// Takes over what the end of a step needs, in the lanes chosen.
    #[inline(always)]
    fn take(&mut self, chosen: &[bool; LANES], from: &Evaluation) {
        let to = self.turn_quaternion.iter_mut().chain(&mut self.position).chain(&mut self.rate);
        let from_numbers = from.turn_quaternion.iter().chain(&from.position).chain(&from.rate);
        for (to, from) in to.chain(&mut self.net).zip(from_numbers.chain(&from.net)) {
            to.take(chosen, from);
        }
    }
}

/// How far the iteration of one instance is.
#[derive(Clone, Copy)]
struct Progress {
    previous: f64,
    running: bool,
    /// To be stepped alone.
    alone: bool,
}

impl LaneImplicit {
    pub(super) fn new(model: &Model, parameters: Parameters) -> Self {
        let (m, zero) = (model.n_modes(), Lanes::default());
        let diagonal = model
            .elastic
            .iter()
            .map(|e| e.mass + parameters.velocity_gain * e.damping + parameters.position_gain * e.stiffness);
        let inverse_diagonal: Vec<f64> = diagonal.map(|d| 1.0 / d).collect();
        let gain = parameters.velocity_gain;
        LaneImplicit {
            parameters,
            constant_floor: floor_of_equilibrium(model, gain, &inverse_diagonal)
                + floor_of_weight(model, gain, model.gravity()),
            inverse_diagonal,
            q_known: vec![zero; m],
            q_dot_known: vec![zero; m],
            force_known: vec![zero; m],
            iterate: vec![zero; m + 6],
            image: vec![zero; m + 6],
            modal: vec![zero; 2 * m + 6],
            floor: zero,
        }
    }

    /// One step from `state`, whose accelerations are known, into `next`; which of the `wanted` instances are to be stepped alone
    /// instead.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        model: &Model,
        state: &LaneState,
        loads: &LaneLoads,
        wanted: &[bool; LANES],
        max_iterations: u32,
        work: &mut LaneWorkspace,
        next: &mut LaneState,
    ) -> [bool; LANES] {
        next.take_time(state);
        next.advance_time(Lanes::of(self.parameters.dt));
        let (Some(from), time) = (Motion::of(&state.motion), next.time) else { return *wanted };
        self.begin(model, state, &from);
        let start = self.begin_rigid(model, state, &from);
        self.guess(model, state, &from);
        let (at, alone) = self.solve(model, &from, &start, loads, wanted, max_iterations, work, time);
        self.finish(model, state, next);
        self.finish_rigid(model, &from, &start, &at, next);
        alone
    }

    #[inline(always)]
    fn begin(&mut self, model: &Model, state: &LaneState, from: &Motion) {
        let Parameters { dt, beta, gamma, .. } = self.parameters;
        let gain = self.parameters.velocity_gain;
        self.floor = Lanes::of(self.constant_floor);
        let auxiliary = Algorithmic::of(&state.algorithmic, model.n_modes()).modes;
        let modal = from.q.iter().zip(from.q_dot).zip(state.u_dot.iter().zip(auxiliary));
        let known = self.q_known.iter_mut().zip(&mut self.q_dot_known).zip(&mut self.force_known);
        let constants = model.elastic.iter().zip(&self.inverse_diagonal);
        for ((((q, q_dot), (q_ddot, a)), ((q_known, q_dot_known), force_known)), (mode, inverse)) in
            modal.zip(known).zip(constants)
        {
            let a_known = self.parameters.known(*q_ddot, *a);
            *q_known = *q
                + Lanes::of(dt) * *q_dot
                + Lanes::of(dt * dt) * (Lanes::of(0.5 - beta) * *a + Lanes::of(beta) * a_known);
            *q_dot_known =
                *q_dot + Lanes::of(dt) * (Lanes::of(1.0 - gamma) * *a + Lanes::of(gamma) * a_known);
            *force_known = Lanes::of(mode.damping) * *q_dot_known + Lanes::of(mode.stiffness) * *q_known;
            let velocity = Lanes::of(gain * inverse) * *force_known;
            self.floor += Lanes::of(mode.mass) * velocity * velocity;
        }
    }

    #[inline(always)]
    fn guess(&mut self, model: &Model, state: &LaneState, from: &Motion) {
        let motion = from.q.iter().zip(from.q_dot).zip(&state.u_dot);
        let known = self.force_known.iter().zip(&self.inverse_diagonal);
        for (((iterate, mode), ((q, q_dot), q_ddot)), (known, inverse)) in
            self.iterate.iter_mut().zip(&model.elastic).zip(motion).zip(known)
        {
            let force = Lanes::of(mode.mass) * *q_ddot
                + Lanes::of(mode.damping) * *q_dot
                + Lanes::of(mode.stiffness) * *q;
            *iterate = (force - *known) * Lanes::of(*inverse);
        }
        let rates = tail(&state.u_dot);
        if let Some(iterate) = self.iterate.last_chunk_mut::<6>() {
            for ((iterate, beta), rate) in iterate.iter_mut().zip(from.beta_star).zip(&rates) {
                *iterate = *beta + Lanes::of(self.parameters.dt) * *rate;
            }
        }
    }

    #[inline(always)]
    fn begin_rigid(&self, model: &Model, state: &LaneState, from: &Motion) -> Start {
        let Parameters { dt, gamma, .. } = self.parameters;
        let beta_star_dot = tail(&state.u_dot);
        let c = model.centre_of_mass;
        let (v, w) = split(&true_velocity(&model.phi_r, from.q_dot, from.beta_star));
        let momentum = about_centre(c, &mul6_symmetric(&model.rigid_mass, from.beta_star));
        let rate = inertial_rate(model, w, &momentum, &mul6_symmetric(&model.rigid_mass, &beta_star_dot));
        let auxiliary = tail(Algorithmic::of(&state.algorithmic, model.n_modes()).rigid);
        let mut rate_known = [Lanes::default(); 6];
        let mut momentum_known = momentum;
        for (((known, momentum), rate), a) in
            rate_known.iter_mut().zip(&mut momentum_known).zip(&rate).zip(&auxiliary)
        {
            *known = self.parameters.known(*rate, *a);
            *momentum += Lanes::of(dt) * (Lanes::of(1.0 - gamma) * *a + Lanes::of(gamma) * *known);
        }
        let v_c = add(v, cross(w, constant_vector(&c)));
        Start { attitude: matrix(*from.attitude), w, v_c, momentum_known, rate_known }
    }

    /// Substitutes until every instance has converged or has been given up.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn solve(
        &mut self,
        model: &Model,
        from: &Motion,
        start: &Start,
        loads: &LaneLoads,
        wanted: &[bool; LANES],
        max_iterations: u32,
        work: &mut LaneWorkspace,
        time: Lanes,
    ) -> (Evaluation, [bool; LANES]) {
        let mut progress = wanted.map(|running| Progress { previous: f64::INFINITY, running, alone: false });
        let mut found = Evaluation::default();
        for iteration in 0..max_iterations {
            let at = self.evaluate(model, from, start, loads, time, work);
            let running = progress.map(|progress| progress.running);
            if running == [true; LANES] {
                found = at;
                core::mem::swap(&mut self.iterate, &mut self.image);
            } else {
                found.take(&running, &at);
                for (iterate, image) in self.iterate.iter_mut().zip(&self.image) {
                    iterate.take(&running, image);
                }
            }
            for ((progress, correction), size) in
                progress.iter_mut().zip(&at.correction.0).zip(&at.size.0).filter(|((p, _), _)| p.running)
            {
                judge(progress, iteration, libm::sqrt(*correction), libm::sqrt(*size));
            }
            if progress.iter().all(|progress| !progress.running) {
                break;
            }
        }
        (found, progress.map(|progress| progress.alone || progress.running))
    }

    #[inline(always)]
    fn evaluate(
        &mut self,
        model: &Model,
        from: &Motion,
        start: &Start,
        loads: &LaneLoads,
        time: Lanes,
        work: &mut LaneWorkspace,
    ) -> Evaluation {
        let Parameters { dt, velocity_gain, .. } = self.parameters;
        self.update_modes();
        let beta_star = tail(&self.iterate);
        if let Some(rigid) = self.modal.last_chunk_mut::<6>() {
            *rigid = beta_star;
        }
        let (q, u) = self.modal.split_at_checked(model.n_modes()).unwrap_or_default();
        let q_dot = u.split_last_chunk::<6>().map_or(&[][..], |u| u.0);
        let beta = true_velocity(&model.phi_r, q_dot, &beta_star);
        let (v, w) = split(&beta);
        let c = constant_vector(&model.centre_of_mass);
        let half = Lanes::of(0.5 * dt);
        let turn_quaternion = quaternion(scale(half, add(start.w, w)));
        let turn = matrix(turn_quaternion);
        let travelled = scale(half, add(start.v_c, mul(&turn, add(v, cross(w, c)))));
        let position = add(*from.position, mul(&start.attitude, add(travelled, sub(c, mul(&turn, c)))));
        let attitude = mat_mul(&start.attitude, &turn);
        let motion = LaneMotion { t: time, modal: &self.modal, q, u, attitude, position, beta };
        forces(model, loads, &motion, work);

        let net = rigid_net(&work.external, &work.gyroscopic);
        let momentum_origin = mul6_symmetric(&model.rigid_mass, &beta_star);
        let momentum = about_centre(model.centre_of_mass, &momentum_origin);
        let rate = inertial_rate(model, w, &momentum, &net);
        let mut target = mul_t_6(&turn, &start.momentum_known);
        for (target, rate) in target.iter_mut().zip(&rate) {
            *target += Lanes::of(velocity_gain) * *rate;
        }
        let target = about_origin(model.centre_of_mass, &target);
        let (correction, size) = self.substitute(model, work, &beta_star, &momentum_origin, &target);
        Evaluation { correction, size, turn_quaternion, position, rate, net }
    }

    #[inline(always)]
    fn update_modes(&mut self) {
        let Parameters { velocity_gain, position_gain, .. } = self.parameters;
        let known = self.q_known.iter().zip(&self.q_dot_known);
        let Some((q, u)) = self.modal.split_at_mut_checked(self.q_known.len()) else { return };
        for (((q, q_dot), q_ddot), (q_known, q_dot_known)) in
            q.iter_mut().zip(u).zip(&self.iterate).zip(known)
        {
            *q = *q_known + Lanes::of(position_gain) * *q_ddot;
            *q_dot = *q_dot_known + Lanes::of(velocity_gain) * *q_ddot;
        }
    }

    /// Fills the image; squared sizes of the correction and of the velocities.
    #[inline(always)]
    fn substitute(
        &mut self,
        model: &Model,
        work: &LaneWorkspace,
        beta_star: &Vec6<Lanes>,
        momentum: &Vec6<Lanes>,
        target: &Vec6<Lanes>,
    ) -> (Lanes, Lanes) {
        let gain = Lanes::of(self.parameters.velocity_gain);
        let (mut correction, mut size) = (Lanes::default(), self.floor);
        let forces =
            work.external.iter().zip(&work.gyroscopic).zip(&self.force_known).zip(&self.inverse_diagonal);
        let rates = self.modal.iter().skip(model.n_modes());
        let iterate = self.iterate.iter().zip(rates).zip(&model.elastic);
        for ((image, (((external, gyroscopic), known), inverse)), ((old, q_dot), mode)) in
            self.image.iter_mut().zip(forces).zip(iterate)
        {
            *image = (*external - *gyroscopic - *known) * Lanes::of(*inverse);
            let change = gain * (*image - *old);
            correction += Lanes::of(mode.mass) * change * change;
            size += Lanes::of(mode.mass) * *q_dot * *q_dot;
        }
        let beta_image = mul6_symmetric(&model.rigid_mass_inverse, target);
        for (((image, old), target), momentum) in beta_image.iter().zip(beta_star).zip(target).zip(momentum) {
            correction += (*image - *old) * (*target - *momentum);
            size += *old * *momentum;
        }
        if let Some(image) = self.image.last_chunk_mut::<6>() {
            *image = beta_image;
        }
        (correction.each(f64::abs), size)
    }

    #[inline(always)]
    fn finish(&mut self, model: &Model, state: &LaneState, next: &mut LaneState) {
        self.update_modes();
        // The rigid velocities among them are those of the last evaluation, not yet those found.
        copy(&mut next.motion, &self.modal);
        let m = model.n_modes();
        let old = state.u_dot.iter().zip(Algorithmic::of(&state.algorithmic, m).modes);
        let auxiliary = Algorithmic::of_mut(&mut next.algorithmic, m).modes;
        for ((a, q_ddot), (old_q_ddot, old_a)) in auxiliary.iter_mut().zip(&self.iterate).zip(old) {
            *a = self.parameters.auxiliary(*q_ddot, self.parameters.known(*old_q_ddot, *old_a));
        }
        for (u_dot, q_ddot) in next.u_dot.iter_mut().zip(&self.iterate).take(m) {
            *u_dot = *q_ddot;
        }
        next.accelerations_known = [true; LANES];
    }

    #[inline(always)]
    fn finish_rigid(
        &self,
        model: &Model,
        from: &Motion,
        start: &Start,
        at: &Evaluation,
        next: &mut LaneState,
    ) {
        let Some(end) = MotionMut::of(&mut next.motion) else { return };
        if let Some(rigid) = end.u.last_chunk_mut::<6>() {
            *rigid = tail(&self.iterate);
        }
        *end.attitude = normalised(quaternion_product(*from.attitude, at.turn_quaternion));
        *end.position = at.position;
        let turn = matrix(at.turn_quaternion);
        let known = mul_t_6(&turn, &start.rate_known);
        let auxiliary = Algorithmic::of_mut(&mut next.algorithmic, model.n_modes()).rigid;
        for ((a, rate), known) in auxiliary.iter_mut().zip(&at.rate).zip(&known) {
            *a = self.parameters.auxiliary(*rate, *known);
        }
        if let Some(u_dot) = next.u_dot.last_chunk_mut::<6>() {
            *u_dot = mul6_symmetric(&model.rigid_mass_inverse, &at.net);
        }
    }
}

/// Whether an instance has converged, goes on, or is given up, as in `Implicit::solve`.
#[inline(always)]
fn judge(progress: &mut Progress, iteration: u32, correction: f64, size: f64) {
    let ratio = if progress.previous.is_finite() { correction / progress.previous } else { 1.0 };
    let left = correction * ratio.clamp(0.01, 1.0);
    if left <= TOLERANCE * size || (ratio > 0.5 && correction <= STAGNATION * size) {
        progress.running = false;
        return;
    }
    let give_up = (iteration >= 2 && ratio > SLOW) || iteration >= MAX_SUBSTITUTIONS;
    if give_up || !correction.is_finite() {
        progress.running = false;
        progress.alone = true;
    }
    progress.previous = correction;
}
