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

use super::algorithmic::Algorithmic;
use super::consistent::{LoadedMomentum, carry_change, gains, loaded_momentum, solved_momentum};
use super::newton::Newton;
use super::parameters::Parameters;
use super::prescribed::finish_prescribed;
pub(crate) use crate::equations::tail;
use crate::equations::{Motion, Workspace, about_centre, about_origin, forces, rigid_net};
use crate::error::StepError;
use crate::four::Four;
use crate::loading::Acting;
use crate::math::{
    Mat3, Vec3, Vec6, add, add_scaled, cross, dot, join, mat_mul, matrix, mul, mul_t_6, mul6_symmetric,
    normalised, quaternion, quaternion_product, scale, split, sub,
};
use crate::model::Model;
use crate::prescribed::{Held, PrescribedMotion};
use crate::real::Real;
use crate::state::{State, true_velocity};

/// Most iterations of plain substitution before Newton takes over.
pub(crate) const MAX_SUBSTITUTIONS: u32 = 12;
/// Contraction per iteration above which plain substitution is given up.
pub(crate) const SLOW: f64 = 0.2;
/// The error left after the last correction, relative to the velocities in the norm of kinetic energy. A few dozen
/// round-offs: what is left is below what the sums of a step lose anyway.
pub(crate) const TOLERANCE: f64 = 32.0 * f64::EPSILON;
/// Corrections that stop shrinking below this are round-off of forces that cancel.
pub(crate) const STAGNATION: f64 = 1e-9;

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
    pub(super) force_known: Vec<f64>,
    /// Iterate: `q_ddot_1`, then `beta*_1` - (m + 6).
    pub(super) iterate: Vec<f64>,
    /// Where substitution takes the iterate - (m + 6).
    pub(super) image: Vec<f64>,
    pub(super) q: Vec<f64>,
    pub(super) u: Vec<f64>,
    /// Squared norm of what `force_known`, the forces of the equilibrium and the weight do to the velocities in a step: forces that
    /// cancel set the floor of round-off.
    pub(super) floor: f64,
    /// The part of the equilibrium in it.
    equilibrium_floor: f64,
    newton: Newton,
    /// The iteration matrix with A held.
    pub(super) held: Option<Held>,
    /// `g_v C + g_x K` of a consistent model, which its mass matrix gains - (m rows).
    pub(super) gains: Vec<Four>,
    /// Accelerations of A at the iterate of a consistent model.
    pub(super) beta_dot: Vec6,
}

/// What a step knows at its start, rigid part.
pub(super) struct Start {
    pub(super) attitude: Mat3,
    pub(super) w: Vec3,
    /// Centre of mass in A and its velocity.
    pub(super) centre: Vec3,
    pub(super) v_c: Vec3,
    /// `(p, h_c)_1` without its share of the rate at the end, in the axes of A at the start.
    pub(super) momentum_known: Vec6,
    /// Part of the auxiliary rate at the end known at the start, same axes.
    rate_known: Vec6,
}

/// The six rigid rows of a step.
pub(super) enum RigidRows {
    /// Unknown: solved with the modal ones.
    Free(Start),
    /// Known: the host moves A.
    Prescribed(PrescribedMotion),
}

/// Results of one evaluation at an iterate.
pub(crate) struct Evaluation {
    pub(crate) beta: Vec6,
    /// Rigid rows; none where the motion of A is prescribed.
    pub(crate) rigid: Option<RigidEvaluation>,
    /// Squared size of the correction and of the velocities.
    pub(super) correction: f64,
    pub(super) size: f64,
}

/// What an evaluation finds in the rigid rows.
pub(crate) struct RigidEvaluation {
    /// Rotation of the step.
    pub(super) turn_quaternion: [f64; 4],
    pub(super) position: Vec3,
    pub(crate) theta: Vec3,
    /// Inertial rate of `(p, h_c)` at the end, in A.
    pub(crate) rate: Vec6,
    /// `exp(-theta~)` applied to the known momentum.
    pub(crate) momentum_known: Vec6,
    /// `(p, h_c)` of the iterate, in A.
    pub(crate) momentum: Vec6,
    /// Centre of mass in A.
    pub(super) centre: Vec3,
    /// `Q_R - N_R`, which is `M_RR beta*_dot`.
    pub(super) net: Vec6,
}

impl RigidEvaluation {
    /// `(p, h_c)` that the equation of the step asks for with the rate of the iterate, in A.
    #[inline(always)]
    fn momentum_at_end(&self, velocity_gain: f64) -> Vec6 {
        let mut momentum = self.momentum_known;
        add_scaled(&mut momentum, velocity_gain, &self.rate);
        momentum
    }
}

impl Implicit {
    pub(crate) fn new(model: &Model, parameters: Parameters) -> Self {
        let m = model.n_modes();
        let diagonal: Vec<f64> = model
            .elastic
            .iter()
            .map(|e| e.mass + parameters.velocity_gain * e.damping + parameters.position_gain * e.stiffness)
            .collect();
        let inverse_diagonal: Vec<f64> = diagonal.iter().map(|d| 1.0 / d).collect();
        Implicit {
            parameters,
            held: Held::new(&model.phi_r, &model.rigid_mass_inverse, &diagonal),
            equilibrium_floor: floor_of_equilibrium(model, parameters.velocity_gain, &inverse_diagonal),
            inverse_diagonal,
            diagonal,
            q_known: vec![0.0; m],
            q_dot_known: vec![0.0; m],
            force_known: vec![0.0; m],
            iterate: vec![0.0; m + 6],
            image: vec![0.0; m + 6],
            q: vec![0.0; m],
            u: vec![0.0; m + 6],
            floor: 0.0,
            newton: Newton::new(model),
            gains: gains(model, &parameters),
            beta_dot: [0.0; 6],
        }
    }

    /// One step from `state`, whose accelerations are known, into `next`; with the motion of A at its end where a host
    /// prescribes it.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn step(
        &mut self,
        model: &Model,
        state: &State,
        loads: &Acting,
        motion: Option<&PrescribedMotion>,
        max_iterations: u32,
        work: &mut Workspace,
        next: &mut State,
    ) -> Result<(), StepError> {
        work.vectors.run(
            (self, model, state, loads, motion, max_iterations, work, next),
            #[inline(always)]
            |(this, model, state, loads, motion, max_iterations, work, next)| {
                this.march(model, state, loads, motion, max_iterations, work, next)
            },
        )
    }

    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn march(
        &mut self,
        model: &Model,
        state: &State,
        loads: &Acting,
        motion: Option<&PrescribedMotion>,
        max_iterations: u32,
        work: &mut Workspace,
        next: &mut State,
    ) -> Result<(), StepError> {
        next.copy_from(state);
        next.advance_time(self.parameters.dt);
        self.begin(model, state, work.gravity);
        let rows = self.rigid_rows(model, state, motion);
        self.guess(model, state, &rows);
        let evaluation = self.solve(model, state, &rows, loads, max_iterations, work, next.time)?;
        self.finish(model, state, next);
        match (&rows, &evaluation.rigid) {
            (RigidRows::Free(start), Some(at)) => self.finish_rigid(model, state, start, at, next),
            (RigidRows::Prescribed(motion), _) => finish_prescribed(model, motion, work, next),
            (RigidRows::Free(_), None) => {}
        }
        carry_change(state, next);
        Ok(())
    }

    /// What is known of the modes at the start of the step.
    #[inline(always)]
    fn begin(&mut self, model: &Model, state: &State, gravity: Vec3) {
        let Parameters { dt, beta, gamma, velocity_gain, .. } = self.parameters;
        self.floor = self.equilibrium_floor + floor_of_weight(model, velocity_gain, gravity);
        let auxiliary = Algorithmic::of(&state.algorithmic, model.n_modes()).modes;
        let modal = state.q.iter().zip(&state.q_dot).zip(state.u_dot.iter().zip(auxiliary));
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
            self.floor += mode.mass * velocity * velocity;
        }
    }

    #[inline(always)]
    fn rigid_rows(&self, model: &Model, state: &State, motion: Option<&PrescribedMotion>) -> RigidRows {
        match motion {
            Some(motion) => RigidRows::Prescribed(*motion),
            None => RigidRows::Free(self.begin_rigid(model, state)),
        }
    }

    /// What is known of the rigid motion at the start of the step.
    #[inline(always)]
    fn begin_rigid(&self, model: &Model, state: &State) -> Start {
        let Parameters { dt, gamma, .. } = self.parameters;
        let beta_star_dot = tail(&state.u_dot);
        let (v, w) = split(&true_velocity(&model.phi_r, &state.q_dot, &state.beta_star));
        let (centre, v_c, momentum, rate) = match &model.lagrangian {
            None => {
                let c = model.centre_of_mass;
                let momentum = about_centre(c, &mul6_symmetric(&model.rigid_mass, &state.beta_star));
                let net = mul6_symmetric(&model.rigid_mass, &beta_star_dot);
                (c, add(v, cross(w, c)), momentum, inertial_rate(model, w, &momentum, &net))
            }
            Some(_) => {
                let LoadedMomentum { momentum, rate, centre } = LoadedMomentum::carried(state);
                (centre, scale(1.0 / model.data().rigid.mass, split(&momentum).0), momentum, rate)
            }
        };
        let auxiliary = tail(Algorithmic::of(&state.algorithmic, model.n_modes()).rigid);
        let mut rate_known = [0.0; 6];
        let mut momentum_known = momentum;
        for (((known, momentum), rate), a) in
            rate_known.iter_mut().zip(&mut momentum_known).zip(&rate).zip(&auxiliary)
        {
            *known = self.parameters.known(*rate, *a);
            *momentum += dt * ((1.0 - gamma) * a + gamma * *known);
        }
        Start { attitude: matrix(state.attitude), w, centre, v_c, momentum_known, rate_known }
    }

    /// First iterate: forces on the modes as at the start of the step, but for the elastic and damping ones, which are those at the
    /// end. Where A is moved, accelerations as at the start; those of A in any case.
    #[inline(always)]
    fn guess(&mut self, model: &Model, state: &State, rows: &RigidRows) {
        if model.lagrangian.is_some() {
            return self.guess_consistent(model, state);
        }
        if matches!(rows, RigidRows::Free(_)) {
            let motion = state.q.iter().zip(&state.q_dot).zip(&state.u_dot);
            let known = self.force_known.iter().zip(&self.inverse_diagonal);
            for (((iterate, mode), ((q, q_dot), q_ddot)), (known, inverse)) in
                self.iterate.iter_mut().zip(&model.elastic).zip(motion).zip(known)
            {
                let force = mode.mass * q_ddot + mode.damping * q_dot + mode.stiffness * q;
                *iterate = (force - known) * inverse;
            }
        } else {
            for (iterate, u_dot) in self.iterate.iter_mut().zip(&state.u_dot) {
                *iterate = *u_dot;
            }
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
    #[inline(always)]
    fn solve(
        &mut self,
        model: &Model,
        state: &State,
        rows: &RigidRows,
        loads: &Acting,
        max_iterations: u32,
        work: &mut Workspace,
        time: f64,
    ) -> Result<Evaluation, StepError> {
        let (mut previous, mut relative) = (f64::INFINITY, f64::INFINITY);
        let (mut newton, mut shrinks_slowly) = (false, true);
        for iteration in 0..max_iterations {
            let fresh = iteration == 0 || (iteration >= 2 && shrinks_slowly);
            let mut at = self.evaluate_rows(model, state, rows, loads, time, fresh, work)?;
            if newton {
                at.correction = self.newton_correction(model, &at, shrinks_slowly);
            }
            core::mem::swap(&mut self.iterate, &mut self.image);
            let correction = libm::sqrt(at.correction);
            let size = libm::sqrt(at.size);
            let ratio = if previous.is_finite() { correction / previous } else { 1.0 };
            relative = correction / size;
            // Error left after this correction, for a contraction by `ratio` (not trusted below a hundredth: attitude and position are
            // those of the iterate before it).
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
            // The iteration of a consistent model has damping, stiffness and the mass matrix of the iterate in it already.
            let give_up = !newton
                && model.lagrangian.is_none()
                && ((iteration >= 2 && shrinks_slowly) || iteration >= MAX_SUBSTITUTIONS);
            newton |= give_up;
            if give_up && ratio > 1.0 {
                self.guess(model, state, rows);
            }
            previous = if give_up { f64::INFINITY } else { correction };
            shrinks_slowly |= give_up;
        }
        Err(StepError::NotConverged { time, iterations: max_iterations, residual: relative })
    }

    /// Evaluates the equations at the iterate and writes where substitution takes it to `image`; `fresh` where a consistent model is to
    /// make its matrix anew.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn evaluate_rows(
        &mut self,
        model: &Model,
        state: &State,
        rows: &RigidRows,
        loads: &Acting,
        time: f64,
        fresh: bool,
        work: &mut Workspace,
    ) -> Result<Evaluation, StepError> {
        match rows {
            RigidRows::Free(start) => Ok(match &model.lagrangian {
                None => self.evaluate(model, state, start, loads, time, work),
                Some(lagrangian) => {
                    self.evaluate_consistent(model, lagrangian, state, start, loads, time, fresh, work)
                }
            }),
            RigidRows::Prescribed(motion) => {
                self.evaluate_prescribed(model, motion, loads, time, fresh, work)
            }
        }
    }

    /// With the rigid rows unknown.
    #[inline(always)]
    fn evaluate(
        &mut self,
        model: &Model,
        state: &State,
        start: &Start,
        loads: &Acting,
        time: f64,
        work: &mut Workspace,
    ) -> Evaluation {
        let Parameters { dt, velocity_gain, .. } = self.parameters;
        self.update_modes();
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

        let net = rigid_net(&work.external, &work.gyroscopic);
        let momentum_origin = mul6_symmetric(&model.rigid_mass, &beta_star);
        let momentum = about_centre(c, &momentum_origin);
        let rate = inertial_rate(model, w, &momentum, &net);
        let momentum_known = mul_t_6(&turn, &start.momentum_known);
        let rigid = RigidEvaluation {
            turn_quaternion,
            position,
            theta,
            rate,
            momentum_known,
            momentum,
            centre: c,
            net,
        };
        let target = about_origin(c, &rigid.momentum_at_end(velocity_gain));
        let mut at = Evaluation { beta, rigid: Some(rigid), correction: 0.0, size: self.floor };
        self.substitute(model, work, &beta_star, &momentum_origin, &target, &mut at);
        at
    }

    /// `q` and `q_dot` of the iterate.
    #[inline(always)]
    pub(super) fn update_modes(&mut self) {
        let Parameters { velocity_gain, position_gain, .. } = self.parameters;
        let known = self.q_known.iter().zip(&self.q_dot_known);
        for (((q, q_dot), q_ddot), (q_known, q_dot_known)) in
            self.q.iter_mut().zip(&mut self.u).zip(&self.iterate).zip(known)
        {
            *q = q_known + position_gain * q_ddot;
            *q_dot = q_dot_known + velocity_gain * q_ddot;
        }
    }

    /// `q_ddot = (Q - N - known)/diagonal`, `beta* = M_RR^-1 target`, and the norms of the change.
    #[inline(always)]
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

    /// Writes the modes of the converged step into `next`.
    #[inline(always)]
    fn finish(&mut self, model: &Model, state: &State, next: &mut State) {
        self.update_modes();
        for ((q, q_dot), (new_q, new_q_dot)) in
            next.q.iter_mut().zip(&mut next.q_dot).zip(self.q.iter().zip(&self.u))
        {
            *q = *new_q;
            *q_dot = *new_q_dot;
        }
        let m = model.n_modes();
        let old = state.u_dot.iter().zip(Algorithmic::of(&state.algorithmic, m).modes);
        let auxiliary = Algorithmic::of_mut(&mut next.algorithmic, m).modes;
        for ((a, q_ddot), (old_q_ddot, old_a)) in auxiliary.iter_mut().zip(&self.iterate).zip(old) {
            *a = self.parameters.auxiliary(*q_ddot, self.parameters.known(*old_q_ddot, *old_a));
        }
        for (u_dot, q_ddot) in next.u_dot.iter_mut().zip(&self.iterate).take(m) {
            *u_dot = *q_ddot;
        }
        next.accelerations_known = true;
    }

    /// Writes the rigid motion of the converged step into `next`.
    #[inline(always)]
    fn finish_rigid(
        &self,
        model: &Model,
        state: &State,
        start: &Start,
        at: &RigidEvaluation,
        next: &mut State,
    ) {
        next.beta_star = tail(&self.iterate);
        next.attitude = normalised(quaternion_product(state.attitude, at.turn_quaternion));
        next.position = at.position;

        // Auxiliary rates, with the part known at the start turned along.
        let turn = matrix(at.turn_quaternion);
        let known = mul_t_6(&turn, &start.rate_known);
        let auxiliary = Algorithmic::of_mut(&mut next.algorithmic, model.n_modes()).rigid;
        for ((a, rate), known) in auxiliary.iter_mut().zip(&at.rate).zip(&known) {
            *a = self.parameters.auxiliary(*rate, *known);
        }
        if model.lagrangian.is_some() {
            // As the step's equation has it: what the last iterate misses does not add up over the steps.
            let momentum = at.momentum_at_end(self.parameters.velocity_gain);
            LoadedMomentum { momentum, rate: at.rate, centre: at.centre }.carry(next);
        }
        if let Some(u_dot) = next.u_dot.last_chunk_mut::<6>() {
            *u_dot = mul6_symmetric(&model.rigid_mass_inverse, &at.net);
        }
    }
}

/// What the forces of the equilibrium, which cancel, would do to the velocities in a step if each acted alone: without it a body
/// that rests in balance would have nothing but round-off to measure its round-off against. `gain` is that of velocities.
pub(crate) fn floor_of_equilibrium(model: &Model, gain: f64, inverse_diagonal: &[f64]) -> f64 {
    let Some(trim) = &model.data().trim else { return 0.0 };
    let elastic = trim.elastic_force.iter().zip(inverse_diagonal).zip(&model.elastic);
    let energy = |mass: f64, velocity: f64| mass * velocity * velocity;
    let elastic: f64 =
        elastic.map(|((force, inverse), mode)| energy(mode.mass, gain * inverse * force)).sum();
    let [force, moment] = trim.scales;
    let [_, _, _, x, y, z] = &model.rigid_mass_inverse;
    let turning = x[3] + y[4] + z[5];
    elastic + gain * gain * (force * force / model.data().rigid.mass + moment * moment * turning)
}

/// The same of the weight in the field `gravity`.
#[inline(always)]
pub(crate) fn floor_of_weight(model: &Model, gain: f64, gravity: Vec3) -> f64 {
    let fall = scale(gain, gravity);
    model.data().rigid.mass * dot(fall, fall)
}

/// Sets `algorithmic` from `u_dot` at the start of a motion: auxiliary and true accelerations are the same there, and no step has changed
/// them.
pub(crate) fn start_algorithmic(model: &Model, state: &mut State, work: &mut Workspace) {
    start_modes(state);
    start_algorithmic_rigid(model, state, work);
}

/// As [`start_algorithmic`], in free flight right after the accelerations of the state were solved with this scratch.
pub(crate) fn start_free(model: &Model, state: &mut State, work: &mut Workspace) {
    start_modes(state);
    if model.lagrangian.is_some() {
        start_loaded(&solved_momentum(model, work), state);
    } else {
        start_algorithmic_rigid(model, state, work);
    }
}

fn start_modes(state: &mut State) {
    let parts = Algorithmic::of_mut(&mut state.algorithmic, state.q.len());
    for (a, u_dot) in parts.modes.iter_mut().zip(&state.u_dot) {
        *a = *u_dot;
    }
    parts.change.fill(0.0);
}

fn start_loaded(loaded: &LoadedMomentum, state: &mut State) {
    start_rigid(state, &loaded.rate);
    loaded.carry(state);
}

/// The rigid part of [`start_algorithmic`].
pub(super) fn start_algorithmic_rigid(model: &Model, state: &mut State, work: &mut Workspace) {
    if let Some(lagrangian) = &model.lagrangian {
        let loaded = loaded_momentum(model, lagrangian, state, work);
        return start_loaded(&loaded, state);
    }
    let (_, w) = split(&true_velocity(&model.phi_r, &state.q_dot, &state.beta_star));
    let momentum = about_centre(model.centre_of_mass, &mul6_symmetric(&model.rigid_mass, &state.beta_star));
    let net = mul6_symmetric(&model.rigid_mass, &tail(&state.u_dot));
    start_rigid(state, &inertial_rate(model, w, &momentum, &net));
}

fn start_rigid(state: &mut State, rate: &Vec6) {
    let auxiliary = Algorithmic::of_mut(&mut state.algorithmic, state.q.len()).rigid;
    auxiliary.iter_mut().zip(rate).for_each(|(a, rate)| *a = *rate);
}

/// Rate in inertial axes, components in A, of `(p, h_c)` from the rate `net` of `(p, h)` in A components:
/// `p_dot + w x p`, `h_c_dot + w x h_c`.
#[inline(always)]
pub(crate) fn inertial_rate<R: Real>(
    model: &Model,
    w: Vec3<R>,
    momentum: &Vec6<R>,
    net: &Vec6<R>,
) -> Vec6<R> {
    let ((p, h), (p_dot, h_dot)) = (split(momentum), split(&about_centre(model.centre_of_mass, net)));
    join(add(p_dot, cross(w, p)), add(h_dot, cross(w, h)))
}

#[cfg(test)]
mod tests;
