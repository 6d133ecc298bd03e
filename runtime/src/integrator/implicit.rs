//! Newmark and generalised-alpha, one code: Newmark is `alpha_m = alpha_f = 0`.
//!
//! The equations of motion hold at the end of every step, where the loads are taken too (a load that jumps inside a
//! step acts from its end on, so a jump costs one order). With `a` the auxiliary accelerations,
//!
//! ```text
//! (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) x_ddot_1 + alpha_f x_ddot_0
//! x_1 = x_0 + dt x_dot_0 + dt^2 ((1/2 - beta) a_0 + beta a_1),   x_dot_1 = x_dot_0 + dt ((1 - gamma) a_0 + gamma a_1)
//! ```
//!
//! The modal rows are these with `x = q`. The rigid rows integrate the momentum `p` and the moment of momentum `h_c`
//! about the centre of mass **in inertial axes**: `x_dot = C (p, h_c)`, with the rotation of the step
//! `C_1 = C_0 exp(dt/2 (w_0 + w_1)~)`. Components in A would turn with it: then a free body's momentum
//! would drift by `(w dt)^2/12` of a turn and numerical damping would slow down a spin. This way momentum changes by
//! the impulse of the loads and by nothing else, at any step, and the energy of a free rigid body is kept too unless numerical
//! damping is asked for. Likewise the position follows the velocity of the centre
//! of mass, `v_c = v + w x c`, by the trapezoidal rule in inertial axes.
//!
//! Per step the unknowns are `q_ddot_1` and `beta*_1`. Everything but gyroscopic forces, loads and the rotation of the
//! step is linear and constant, and its factors are computed once; the rest is iterated, by plain substitution while
//! that contracts fast, else by Newton ([`super::newton`]).

use alloc::{vec, vec::Vec};

use super::newton::Newton;
use super::parameters::Parameters;
use crate::equations::{Motion, Workspace, about_centre, about_origin, forces, rigid_net};
use crate::error::StepError;
use crate::loading::Loads;
use crate::math::{
    Mat3, Vec3, Vec6, add, cross, join, mat_mul, matrix, mul, mul_t, mul6_symmetric, normalised, quaternion,
    quaternion_product, scale, split, sub,
};
use crate::model::Model;
use crate::state::{State, true_velocity};

/// Most iterations of plain substitution before Newton takes over.
const MAX_SUBSTITUTIONS: u32 = 12;
/// Contraction per iteration above which plain substitution is given up.
const SLOW: f64 = 0.2;
/// The error left after the last correction, relative to the velocities in the norm of kinetic energy. A few dozen
/// round-offs: what is left is below what the sums of a step lose anyway.
const TOLERANCE: f64 = 32.0 * f64::EPSILON;
/// Corrections that stop shrinking below this are round-off of forces that cancel.
const STAGNATION: f64 = 1e-9;

/// Memory and factors of an implicit integrator.
#[derive(Clone, Debug)]
pub(crate) struct Implicit {
    pub(crate) parameters: Parameters,
    /// Diagonal of the constant iteration matrix, `m (1 + 2 zeta omega g_v + omega^2 g_x)` - (m).
    pub(crate) diagonal: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    /// `q_1`, `q_dot_1` without their share of `q_ddot_1`, and the forces they give - (m).
    q_known: Vec<f64>,
    q_dot_known: Vec<f64>,
    force_known: Vec<f64>,
    /// Iterate: `q_ddot_1`, then `beta*_1` - (m + 6).
    iterate: Vec<f64>,
    /// Where substitution takes the iterate - (m + 6).
    image: Vec<f64>,
    q: Vec<f64>,
    u: Vec<f64>,
    newton: Newton,
}

/// What a step knows at its start, rigid part.
struct Start {
    attitude: Mat3,
    w: Vec3,
    /// Velocity of the centre of mass in A.
    v_c: Vec3,
    /// `(p, h_c)_1` without its share of the rate at the end, in the axes of A at the start.
    momentum_known: Vec6,
    /// Part of the auxiliary rate at the end known at the start, same axes.
    rate_known: Vec6,
    /// Squared norm of what `force_known` does to the velocities: forces that cancel set the floor of round-off.
    floor: f64,
}

/// Results of one evaluation at an iterate.
pub(crate) struct Evaluation {
    /// Rotation of the step.
    turn_quaternion: [f64; 4],
    position: Vec3,
    pub(crate) theta: Vec3,
    pub(crate) beta: Vec6,
    /// Inertial rate of `(p, h_c)` at the end, in A.
    pub(crate) rate: Vec6,
    /// `exp(-theta~)` applied to the known momentum.
    pub(crate) momentum_known: Vec6,
    /// `(p, h_c)` of the iterate, in A.
    pub(crate) momentum: Vec6,
    /// `Q_R - N_R`.
    net: Vec6,
    /// Squared size of the correction and of the velocities.
    correction: f64,
    size: f64,
}

impl Implicit {
    pub(crate) fn new(model: &Model, parameters: Parameters) -> Self {
        let m = model.n_modes();
        let diagonal: Vec<f64> = model
            .elastic
            .iter()
            .map(|e| e.mass + parameters.velocity_gain * e.damping + parameters.position_gain * e.stiffness)
            .collect();
        Implicit {
            parameters,
            inverse_diagonal: diagonal.iter().map(|d| 1.0 / d).collect(),
            diagonal,
            q_known: vec![0.0; m],
            q_dot_known: vec![0.0; m],
            force_known: vec![0.0; m],
            iterate: vec![0.0; m + 6],
            image: vec![0.0; m + 6],
            q: vec![0.0; m],
            u: vec![0.0; m + 6],
            newton: Newton::new(model),
        }
    }

    /// One step from `state`, whose accelerations are known, into `next`.
    pub(crate) fn step<L: Loads + ?Sized>(
        &mut self,
        model: &Model,
        state: &State,
        loads: &L,
        max_iterations: u32,
        work: &mut Workspace,
        next: &mut State,
    ) -> Result<(), StepError> {
        next.copy_from(state);
        next.advance_time(self.parameters.dt);
        let start = self.begin(model, state);
        let evaluation = self.solve(model, state, &start, loads, max_iterations, work, next.time)?;
        self.finish(model, state, &start, &evaluation, next);
        Ok(())
    }

    /// Everything known at the start of the step, and the first iterate.
    fn begin(&mut self, model: &Model, state: &State) -> Start {
        let Parameters { dt, beta, gamma, .. } = self.parameters;
        let mut floor = 0.0;
        let modal = state.q.iter().zip(&state.q_dot).zip(state.u_dot.iter().zip(&state.algorithmic));
        let known = self.q_known.iter_mut().zip(&mut self.q_dot_known).zip(&mut self.force_known);
        let constants = model.elastic.iter().zip(&self.inverse_diagonal);
        for ((((q, q_dot), (q_ddot, a)), ((q_known, q_dot_known), force_known)), (mode, inverse)) in
            modal.zip(known).zip(constants)
        {
            let a_known = self.parameters.known(*q_ddot, *a);
            *q_known = q + dt * q_dot + dt * dt * ((0.5 - beta) * a + beta * a_known);
            *q_dot_known = q_dot + dt * ((1.0 - gamma) * a + gamma * a_known);
            *force_known = mode.damping * *q_dot_known + mode.stiffness * *q_known;
            let velocity = self.parameters.velocity_gain * inverse * *force_known;
            floor += mode.mass * velocity * velocity;
        }
        self.guess(state);

        let beta_star_dot = tail(&state.u_dot);
        let c = model.centre_of_mass;
        let (v, w) = split(&true_velocity(&model.phi_r, &state.q_dot, &state.beta_star));
        let momentum = about_centre(c, &mul6_symmetric(&model.rigid_mass, &state.beta_star));
        let rate = inertial_rate(model, w, &momentum, &mul6_symmetric(&model.rigid_mass, &beta_star_dot));
        let auxiliary = tail(&state.algorithmic);
        let mut rate_known = [0.0; 6];
        let mut momentum_known = momentum;
        for (((known, momentum), rate), a) in
            rate_known.iter_mut().zip(&mut momentum_known).zip(&rate).zip(&auxiliary)
        {
            *known = self.parameters.known(*rate, *a);
            *momentum += dt * ((1.0 - gamma) * a + gamma * *known);
        }
        Start {
            attitude: matrix(state.attitude),
            w,
            v_c: add(v, cross(w, c)),
            momentum_known,
            rate_known,
            floor,
        }
    }

    /// First iterate: accelerations as at the start of the step.
    fn guess(&mut self, state: &State) {
        for (iterate, u_dot) in self.iterate.iter_mut().zip(&state.u_dot) {
            *iterate = *u_dot;
        }
        let rates = tail(&state.u_dot);
        if let Some(iterate) = self.iterate.last_chunk_mut::<6>() {
            for ((iterate, beta), rate) in iterate.iter_mut().zip(&state.beta_star).zip(&rates) {
                *iterate = beta + self.parameters.dt * rate;
            }
        }
    }

    /// Iterates until the correction is round-off.
    #[allow(clippy::too_many_arguments)]
    fn solve<L: Loads + ?Sized>(
        &mut self,
        model: &Model,
        state: &State,
        start: &Start,
        loads: &L,
        max_iterations: u32,
        work: &mut Workspace,
        time: f64,
    ) -> Result<Evaluation, StepError> {
        let (mut previous, mut relative) = (f64::INFINITY, f64::INFINITY);
        let (mut newton, mut shrinks_slowly) = (false, true);
        for iteration in 0..max_iterations {
            let mut at = self.evaluate(model, state, start, loads, time, work);
            if newton {
                at.correction = self.newton_correction(model, &at, shrinks_slowly);
            }
            core::mem::swap(&mut self.iterate, &mut self.image);
            let correction = libm::sqrt(at.correction);
            let size = libm::sqrt(at.size);
            let ratio = if previous.is_finite() { correction / previous } else { 1.0 };
            relative = correction / size;
            // Error left after this correction, for a contraction by `ratio` (not trusted below a hundredth).
            let left = correction * ratio.clamp(0.01, 1.0);
            if left <= TOLERANCE * size || (ratio > 0.5 && correction <= STAGNATION * size) {
                return Ok(at);
            }
            if !correction.is_finite() {
                let mode = self.image.iter().take(model.n_modes()).position(|x| !x.is_finite());
                return Err(StepError::Diverged { time, mode });
            }
            // The first Newton correction is not to be compared with the last substitution.
            shrinks_slowly = ratio > SLOW;
            let give_up = !newton && ((iteration >= 2 && shrinks_slowly) || iteration >= MAX_SUBSTITUTIONS);
            newton |= give_up;
            if give_up && ratio > 1.0 {
                self.guess(state);
            }
            previous = if give_up { f64::INFINITY } else { correction };
            shrinks_slowly |= give_up;
        }
        Err(StepError::NotConverged { time, iterations: max_iterations, residual: relative })
    }

    /// Evaluates the equations at the iterate and writes where substitution takes it to `image`.
    fn evaluate<L: Loads + ?Sized>(
        &mut self,
        model: &Model,
        state: &State,
        start: &Start,
        loads: &L,
        time: f64,
        work: &mut Workspace,
    ) -> Evaluation {
        let Parameters { dt, velocity_gain, position_gain, .. } = self.parameters;
        let known = self.q_known.iter().zip(&self.q_dot_known);
        for (((q, q_dot), q_ddot), (q_known, q_dot_known)) in
            self.q.iter_mut().zip(&mut self.u).zip(&self.iterate).zip(known)
        {
            *q = q_known + position_gain * q_ddot;
            *q_dot = q_dot_known + velocity_gain * q_ddot;
        }
        let beta_star = tail(&self.iterate);
        if let Some(u) = self.u.last_chunk_mut::<6>() {
            *u = beta_star;
        }
        let beta =
            true_velocity(&model.phi_r, self.u.split_last_chunk::<6>().map_or(&[], |u| u.0), &beta_star);
        let (v, w) = split(&beta);
        let c = model.centre_of_mass;
        let theta = scale(0.5 * dt, add(start.w, w));
        let turn_quaternion = quaternion(theta);
        let turn = matrix(turn_quaternion);
        // r_1 = r_0 + dt/2 (C_0 v_c0 + C_1 v_c1) - (C_1 - C_0) c
        let travelled = scale(0.5 * dt, add(start.v_c, mul(&turn, add(v, cross(w, c)))));
        let position = add(state.position, mul(&start.attitude, add(travelled, sub(c, mul(&turn, c)))));
        let motion = Motion {
            t: time,
            q: &self.q,
            u: &self.u,
            attitude: mat_mul(&start.attitude, &turn),
            position,
            beta,
        };
        forces(model, loads, &motion, work);

        let net = rigid_net(model, work);
        let momentum_origin = mul6_symmetric(&model.rigid_mass, &beta_star);
        let momentum = about_centre(c, &momentum_origin);
        let rate = inertial_rate(model, w, &momentum, &net);
        let (p, h) = split(&start.momentum_known);
        let momentum_known = join(mul_t(&turn, p), mul_t(&turn, h));
        let mut target = momentum_known;
        for (target, rate) in target.iter_mut().zip(&rate) {
            *target += velocity_gain * rate;
        }
        let target = about_origin(c, &target);
        let mut at = Evaluation {
            turn_quaternion,
            position,
            theta,
            beta,
            rate,
            momentum_known,
            momentum,
            net,
            correction: 0.0,
            size: start.floor,
        };
        self.substitute(model, work, &beta_star, &momentum_origin, &target, &mut at);
        at
    }

    /// `q_ddot = (Q - N - known)/diagonal`, `beta* = M_RR^-1 target`, and the norms of the change.
    #[inline]
    fn substitute(
        &mut self,
        model: &Model,
        work: &Workspace,
        beta_star: &Vec6,
        momentum: &Vec6,
        target: &Vec6,
        at: &mut Evaluation,
    ) {
        let gain = self.parameters.velocity_gain;
        let forces =
            work.external.iter().zip(&work.gyroscopic).zip(&self.force_known).zip(&self.inverse_diagonal);
        let iterate = self.iterate.iter().zip(&self.u).zip(&model.elastic);
        for ((image, (((external, gyroscopic), known), inverse)), ((old, q_dot), mode)) in
            self.image.iter_mut().zip(forces).zip(iterate)
        {
            *image = (external - gyroscopic - known) * inverse;
            let change = gain * (*image - old);
            at.correction += mode.mass * change * change;
            at.size += mode.mass * q_dot * q_dot;
        }
        let beta_image = mul6_symmetric(&model.rigid_mass_inverse, target);
        for (((image, old), target), momentum) in beta_image.iter().zip(beta_star).zip(target).zip(momentum) {
            at.correction += (image - old) * (target - momentum);
            at.size += old * momentum;
        }
        if let Some(image) = self.image.last_chunk_mut::<6>() {
            *image = beta_image;
        }
        // The quadratic form is positive but for round-off.
        at.correction = at.correction.abs();
    }

    /// Replaces the image by a Newton correction of the iterate; returns its squared norm.
    #[cold]
    fn newton_correction(&mut self, model: &Model, at: &Evaluation, refresh: bool) -> f64 {
        if refresh {
            self.newton.factorise(model, &self.parameters, &self.diagonal, &self.q, &self.u, at);
        }
        let correction =
            self.newton.solve(model, &self.parameters, &self.diagonal, &self.iterate, at, &mut self.image);
        // A singular Jacobian leaves the substitution in place.
        correction.unwrap_or(at.correction)
    }

    /// Writes the converged step into `next`.
    fn finish(&mut self, model: &Model, state: &State, start: &Start, at: &Evaluation, next: &mut State) {
        let Parameters { velocity_gain, position_gain, .. } = self.parameters;
        let known = self.q_known.iter().zip(&self.q_dot_known);
        for (((q, q_dot), q_ddot), (q_known, q_dot_known)) in
            next.q.iter_mut().zip(&mut next.q_dot).zip(&self.iterate).zip(known)
        {
            *q = q_known + position_gain * q_ddot;
            *q_dot = q_dot_known + velocity_gain * q_ddot;
        }
        next.beta_star = tail(&self.iterate);
        next.attitude = normalised(quaternion_product(state.attitude, at.turn_quaternion));
        next.position = at.position;

        // Auxiliary accelerations: modal, then rigid with the part known at the start turned along.
        let old = state.u_dot.iter().zip(&state.algorithmic);
        for ((a, q_ddot), (old_q_ddot, old_a)) in
            next.algorithmic.iter_mut().zip(&self.iterate).zip(old).take(model.n_modes())
        {
            *a = self.parameters.auxiliary(*q_ddot, self.parameters.known(*old_q_ddot, *old_a));
        }
        let turn = matrix(at.turn_quaternion);
        let (p, h) = split(&start.rate_known);
        let known = join(mul_t(&turn, p), mul_t(&turn, h));
        if let Some(algorithmic) = next.algorithmic.last_chunk_mut::<6>() {
            for ((a, rate), known) in algorithmic.iter_mut().zip(&at.rate).zip(&known) {
                *a = self.parameters.auxiliary(*rate, *known);
            }
        }
        for (u_dot, q_ddot) in next.u_dot.iter_mut().zip(&self.iterate) {
            *u_dot = *q_ddot;
        }
        if let Some(u_dot) = next.u_dot.last_chunk_mut::<6>() {
            *u_dot = mul6_symmetric(&model.rigid_mass_inverse, &at.net);
        }
        next.accelerations_known = true;
    }
}

/// Sets `algorithmic` from `u_dot` at the start of a motion: auxiliary and true accelerations are the same there.
pub(crate) fn start_algorithmic(model: &Model, state: &mut State) {
    for (a, u_dot) in state.algorithmic.iter_mut().zip(&state.u_dot) {
        *a = *u_dot;
    }
    let (_, w) = split(&true_velocity(&model.phi_r, &state.q_dot, &state.beta_star));
    let momentum = about_centre(model.centre_of_mass, &mul6_symmetric(&model.rigid_mass, &state.beta_star));
    let net = mul6_symmetric(&model.rigid_mass, &tail(&state.u_dot));
    if let Some(algorithmic) = state.algorithmic.last_chunk_mut::<6>() {
        *algorithmic = inertial_rate(model, w, &momentum, &net);
    }
}

/// Rate in inertial axes, components in A, of `(p, h_c)` from the rate `net` of `(p, h)` in A components:
/// `p_dot + w x p`, `h_c_dot + w x h_c`.
#[inline]
fn inertial_rate(model: &Model, w: Vec3, momentum: &Vec6, net: &Vec6) -> Vec6 {
    let ((p, h), (p_dot, h_dot)) = (split(momentum), split(&about_centre(model.centre_of_mass, net)));
    join(add(p_dot, cross(w, p)), add(h_dot, cross(w, h)))
}

fn tail(values: &[f64]) -> Vec6 {
    values.last_chunk::<6>().copied().unwrap_or_default()
}

#[cfg(test)]
#[path = "../../tests/common/mod.rs"]
mod common;

#[cfg(test)]
mod tests {
    use super::common::{Lumped, Random};
    use super::*;

    /// The step's equations at an iterate: what Newton drives to zero.
    fn residual(
        implicit: &mut Implicit,
        model: &Model,
        state: &State,
        start: &Start,
        work: &mut Workspace,
    ) -> Vec<f64> {
        let at = implicit.evaluate(model, state, start, &model.no_loads(), state.time, work);
        let gain = implicit.parameters.velocity_gain;
        let elastic = implicit.iterate.iter().zip(&implicit.image).zip(&implicit.diagonal);
        let mut residual: Vec<f64> =
            elastic.map(|((iterate, image), diagonal)| diagonal * (iterate - image)).collect();
        residual.extend((0..6).map(|row| at.momentum[row] - at.momentum_known[row] - gain * at.rate[row]));
        residual
    }

    #[test]
    fn the_jacobian_is_the_derivative_of_the_equations_of_a_step() {
        let mut lumped = Lumped::random(3, 5);
        lumped.damping_ratio = 0.1;
        let model = Model::new(lumped.data(5)).unwrap();
        let mut random = Random::new(8);
        let mut state = State::at_rest(&model);
        state.q = random.array::<3>(0.3).into();
        state.q_dot = random.array::<3>(1.0).into();
        state.beta_star = random.array(2.0);
        state.u_dot = random.array::<9>(2.0).into();
        state.algorithmic = random.array::<9>(2.0).into();
        let mut work = Workspace::new(&model);
        let mut implicit = Implicit::new(&model, Parameters::generalized_alpha(0.3, 0.2));
        let start = implicit.begin(&model, &state);

        // A Newton correction x solves J x = -residual: J x by central differences must be -residual.
        let here = residual(&mut implicit, &model, &state, &start, &mut work);
        let at = implicit.evaluate(&model, &state, &start, &model.no_loads(), state.time, &mut work);
        implicit.newton_correction(&model, &at, true);
        let iterate = implicit.iterate.clone();
        let correction: Vec<f64> =
            implicit.image.iter().zip(&iterate).map(|(image, iterate)| image - iterate).collect();
        let h = 1e-5;
        let mut moved = |h: f64| {
            for ((place, iterate), x) in implicit.iterate.iter_mut().zip(&iterate).zip(&correction) {
                *place = iterate + h * x;
            }
            residual(&mut implicit, &model, &state, &start, &mut work)
        };
        let (after, before) = (moved(h), moved(-h));
        let size = here.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        for ((after, before), here) in after.iter().zip(&before).zip(&here) {
            let slope = (after - before) / (2.0 * h);
            // Central difference: h^2 and round-off over h, both below 1e-9.
            assert!((slope + here).abs() < 1e-8 * size, "{slope} instead of {}", -here);
        }
    }
}
