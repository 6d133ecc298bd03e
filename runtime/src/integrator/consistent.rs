//! Implicit steps of a model with consistent inertia (docs/beyond.md).
//!
//! The unknowns and the march are those of [`super::implicit`]. Momentum, moment of momentum about the centre of mass and the place of
//! the centre of mass are now those of the deformed body, so that a free body keeps its momenta and moves its centre of mass on a
//! straight line to round-off at any step. An iterate is corrected by the mass matrix *at the iterate*, with damping and stiffness:
//!
//! ```text
//! | M_RR   M_Rq                   | | beta_dot |     | Q_R - h_R                                        |
//! | M_qR   M_qq + g_v C + g_x K   | | q_ddot   |  =  | Q_q - h_q - C q_dot + (g_v C + g_x K) q_ddot_old |
//!
//! M_RR beta = p_known + g_v p_dot - M_Rq q_dot
//! ```
//!
//! What is left out of this Jacobian (gyroscopic terms, the curvature of the manifold, the loads) enters with one or two powers of
//! the step.

use alloc::vec::Vec;

use super::implicit::{Evaluation, Implicit, RigidEvaluation, Start, tail};
use super::parameters::Parameters;
use crate::dense::rows;
use crate::equations::{
    Motion, Workspace, about_centre, about_origin, damp, modal, relative_forces, rigid_force,
};
use crate::four::{Four, dot_numbers};
use crate::lagrangian::Lagrangian;
use crate::loading::Acting;
use crate::math::{
    Vec3, Vec6, add, add_scaled, dot_6, join, mat_mul, matrix, mul, mul_t, mul6_symmetric, normalised,
    quaternion, scale, split, sub, sub_6,
};
use crate::model::Model;
use crate::prescribed::PrescribedMotion;
use crate::state::{State, true_velocity};

/// Momentum of a state and its rate.
pub(super) struct LoadedMomentum {
    /// Centre of mass in A and its velocity.
    pub(super) centre: Vec3,
    pub(super) velocity: Vec3,
    /// `(p, h_c)` and their inertial rates, in A.
    pub(super) momentum: Vec6,
    pub(super) rate: Vec6,
}

/// Of a state whose accelerations are known: the loads follow from them.
pub(super) fn loaded_momentum(
    model: &Model,
    lagrangian: &Lagrangian,
    state: &State,
    work: &mut Workspace,
) -> LoadedMomentum {
    let beta = true_velocity(&model.phi_r, &state.q_dot, &state.beta_star);
    let q_ddot = modal(&state.u_dot);
    let beta_dot = true_velocity(&model.phi_r, q_ddot, &tail(&state.u_dot));
    lagrangian.evaluate(&state.q, &state.q_dot, &beta, &mut work.lagrangian);
    let mass = model.data().rigid.mass;
    let centre = scale(1.0 / mass, work.lagrangian.first_moment);
    let loads = lagrangian.rigid_rows(&work.lagrangian, q_ddot, &beta_dot);
    LoadedMomentum {
        centre,
        velocity: scale(1.0 / mass, split(&work.lagrangian.momentum).0),
        momentum: about_centre(centre, &work.lagrangian.momentum),
        rate: about_centre(centre, &loads),
    }
}

impl Implicit {
    /// As [`Implicit::evaluate`], with the mass matrix of the iterate.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn evaluate_consistent(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        start: &Start,
        loads: &Acting,
        time: f64,
        work: &mut Workspace,
    ) -> Evaluation {
        let dt = self.parameters.dt;
        self.update_modes();
        let beta_star = tail(&self.iterate);
        if let Some(u) = self.u.last_chunk_mut::<6>() {
            *u = beta_star;
        }
        let beta = true_velocity(&model.phi_r, modal(&self.u), &beta_star);
        lagrangian.evaluate(&self.q, modal(&self.u), &beta, &mut work.lagrangian);

        let inverse_mass = 1.0 / model.data().rigid.mass;
        let centre = scale(inverse_mass, work.lagrangian.first_moment);
        let momentum_origin = work.lagrangian.momentum;
        let v_c = scale(inverse_mass, split(&momentum_origin).0);
        let theta = scale(0.5 * dt, add(start.w, split(&beta).1));
        let turn_quaternion = quaternion(theta);
        let turn = matrix(turn_quaternion);
        let travelled = scale(0.5 * dt, add(start.v_c, mul(&turn, v_c)));
        let place = add(travelled, sub(start.centre, mul(&turn, centre)));
        let position = add(state.position, mul(&start.attitude, place));
        let attitude = mat_mul(&start.attitude, &turn);
        let here = Motion { t: time, q: &self.q, u: &self.u, attitude, position, beta };
        relative_forces(model, lagrangian, loads, &here, work);

        let rate = about_centre(centre, &tail(&work.external));
        let (p, h) = split(&start.momentum_known);
        let momentum_known = join(mul_t(&turn, p), mul_t(&turn, h));
        let mut target = momentum_known;
        add_scaled(&mut target, self.parameters.velocity_gain, &rate);
        let target = about_origin(centre, &target);
        let momentum = about_centre(centre, &momentum_origin);
        let mut rigid = RigidEvaluation {
            turn_quaternion,
            position,
            theta,
            rate,
            momentum_known,
            momentum,
            net: [0.0; 6],
        };
        let mut at = Evaluation { beta, rigid: None, correction: 0.0, size: self.floor };
        rigid.net = self.substitute_consistent(model, lagrangian, work, &target, &mut at);
        at.rigid = Some(rigid);
        at
    }

    /// The image of the iterate and the norms of the change; returns `M_RR beta*_dot`.
    fn substitute_consistent(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        work: &mut Workspace,
        target: &Vec6,
        at: &mut Evaluation,
    ) -> Vec6 {
        self.add_implicit_forces(model, work);
        let rigid = rigid_force(work);
        let gain = self.parameters.velocity_gain;
        let Some((q_ddot, beta_image)) = self.image.split_last_chunk_mut::<6>() else { return [0.0; 6] };
        let beta_dot = lagrangian.solve(&mut work.lagrangian, &work.relative, &rigid, &self.gains, q_ddot);
        // Rates of the image, in place of the forces that are no longer needed.
        let rates = self.u.iter().zip(q_ddot.iter()).zip(&self.iterate);
        for (to, ((q_dot, image), old)) in work.relative.iter_mut().zip(rates) {
            *to = q_dot + gain * (image - old);
        }
        let beta = work.lagrangian.velocity(target, &work.relative);
        *beta_image = model.own_velocity(&beta, &work.relative);

        let beta_star = tail(&self.u);
        let change = sub_6(beta_image, &beta_star);
        at.correction += dot_6(&change, &mul6_symmetric(&model.rigid_mass, &change));
        at.size += dot_6(&beta_star, &mul6_symmetric(&model.rigid_mass, &beta_star));
        let net = mul6_symmetric(&model.rigid_mass, &model.own_velocity(&beta_dot, q_ddot));
        self.measure(model, at);
        net
    }

    /// Damping of the iterate, and what the gains make of its accelerations.
    fn add_implicit_forces(&self, model: &Model, work: &mut Workspace) {
        damp(model, modal(&self.u), &mut work.relative);
        let rows = rows(&self.gains, model.n_modes().div_ceil(4).max(1));
        for (force, row) in work.relative.iter_mut().zip(rows) {
            *force += dot_numbers(row, modal(&self.iterate));
        }
    }

    /// Adds the modal parts of the norms.
    fn measure(&self, model: &Model, at: &mut Evaluation) {
        let modes = self.image.iter().zip(&self.iterate).zip(&self.u).zip(&model.elastic);
        for (((image, old), q_dot), mode) in modes {
            let change = self.parameters.velocity_gain * (image - old);
            at.correction += mode.mass * change * change;
            at.size += mode.mass * q_dot * q_dot;
        }
        at.correction = at.correction.abs();
    }

    /// As [`Implicit::evaluate_prescribed`], with the mass matrix of the iterate.
    pub(super) fn evaluate_prescribed_consistent(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        motion: &PrescribedMotion,
        loads: &Acting,
        time: f64,
        work: &mut Workspace,
    ) -> Evaluation {
        self.update_modes();
        let beta_star = model.own_velocity(&motion.velocity, modal(&self.u));
        if let Some(u) = self.u.last_chunk_mut::<6>() {
            *u = beta_star;
        }
        lagrangian.evaluate(&self.q, modal(&self.u), &motion.velocity, &mut work.lagrangian);
        let here = Motion {
            t: time,
            q: &self.q,
            u: &self.u,
            attitude: matrix(normalised(motion.attitude)),
            position: motion.position,
            beta: motion.velocity,
        };
        relative_forces(model, lagrangian, loads, &here, work);
        self.add_implicit_forces(model, work);
        let mut at = Evaluation { beta: motion.velocity, rigid: None, correction: 0.0, size: self.floor };
        if let Some((q_ddot, _)) = self.image.split_last_chunk_mut::<6>() {
            lagrangian.solve_held(&mut work.lagrangian, &work.relative, &motion.rate, &self.gains, q_ddot);
        }
        self.measure(model, &mut at);
        at.size += dot_6(&beta_star, &mul6_symmetric(&model.rigid_mass, &beta_star));
        at
    }
}

/// `g_v C + g_x K` of a consistent model; empty for others.
pub(super) fn gains(model: &Model, parameters: &Parameters) -> Vec<Four> {
    let damping = |i: usize| model.elastic.get(i).map_or(0.0, |mode| mode.damping);
    let lagrangian = model.lagrangian.as_ref();
    lagrangian.map_or(Vec::new(), |it| it.gains(damping, parameters.velocity_gain, parameters.position_gain))
}
