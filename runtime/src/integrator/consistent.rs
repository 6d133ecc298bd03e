//! Implicit steps of a model with consistent inertia (docs/beyond.md).
//!
//! The unknowns and the march are those of [`super::implicit`]. Momentum, moment of momentum about the centre of mass and the place of
//! the centre of mass are now those of the deformed body, so that a free body keeps its momenta and moves its centre of mass on a
//! straight line to round-off at any step. An iterate, with its accelerations of A, is corrected by what it misses of the equations:
//!
//! ```text
//! | M_RR   M_Rq                   | | d beta_dot |     | Q_R - h_R - M_RR beta_dot - M_Rq q_ddot             |
//! | M_qR   M_qq + g_v C + g_x K   | | d q_ddot   |  =  | Q_q - h_q - M_qR beta_dot - M_qq q_ddot - C q_dot   |
//!
//! M_RR d beta = p_known + g_v p_dot - p - M_Rq g_v d q_ddot
//! ```
//!
//! The right side is that of the iterate, the matrix that of the first one: it is made and eliminated once a step, and again where the
//! corrections shrink slowly. What is left out of this Jacobian (gyroscopic terms, the curvature of the manifold, the loads, the change of
//! the mass matrix over the step) enters with one or two powers of the step.

use alloc::vec::Vec;

use super::algorithmic::{Algorithmic, LOADED};
use super::implicit::{Evaluation, Implicit, RigidEvaluation, Start, tail};
use super::parameters::Parameters;
use crate::equations::{
    Motion, Workspace, about_centre, about_origin, damp, modal, relative_residual, rigid_force,
};
use crate::four::Four;
use crate::lagrangian::{Accelerations, Lagrangian};
use crate::loading::Acting;
use crate::math::{
    Vec3, Vec6, add, add_6, add_scaled, dot_6, mat_mul, matrix, mul, mul_t, mul_t_6, mul6_symmetric,
    normalised, quaternion, scale, split, sub, sub_6,
};
use crate::model::Model;
use crate::prescribed::PrescribedMotion;
use crate::state::{State, true_velocity};

/// Momentum of a state and its rate. Steps carry it in [`State::algorithmic`].
pub(super) struct LoadedMomentum {
    /// `(p, h_c)` and their inertial rates, in A.
    pub(super) momentum: Vec6,
    pub(super) rate: Vec6,
    /// Centre of mass in A.
    pub(super) centre: Vec3,
}

impl LoadedMomentum {
    /// What a state carries.
    pub(super) fn carried(state: &State) -> Self {
        let [a, b, c, d, e, f, g, h, i, j, k, l, x, y, z]: [f64; LOADED] =
            Algorithmic::of(&state.algorithmic, state.q.len())
                .loaded
                .first_chunk()
                .copied()
                .unwrap_or_default();
        LoadedMomentum { momentum: [a, b, c, d, e, f], rate: [g, h, i, j, k, l], centre: [x, y, z] }
    }

    /// Puts it into a state.
    pub(super) fn carry(&self, state: &mut State) {
        let carried = Algorithmic::of_mut(&mut state.algorithmic, state.q.len()).loaded;
        let numbers = self.momentum.iter().chain(&self.rate).chain(&self.centre);
        carried.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
    }
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
    let accelerations = Accelerations { q_ddot, beta_dot: &beta_dot, fall: [0.0; 3] };
    lagrangian.inertia(&state.q, &state.q_dot, &beta, &accelerations, &mut work.lagrangian);
    let mass = model.data().rigid.mass;
    let centre = scale(1.0 / mass, work.lagrangian.first_moment);
    LoadedMomentum {
        centre,
        momentum: about_centre(centre, &work.lagrangian.momentum),
        rate: about_centre(centre, &work.lagrangian.rigid),
    }
}

/// Of a state in free flight whose accelerations were solved with this scratch: the rates are the loads.
pub(super) fn solved_momentum(model: &Model, work: &Workspace) -> LoadedMomentum {
    let centre = work.lagrangian.centre(model.data().rigid.mass);
    LoadedMomentum {
        centre,
        momentum: about_centre(centre, &work.lagrangian.momentum),
        rate: about_centre(centre, &tail(&work.external)),
    }
}

/// Puts the change of the accelerations in a step into the state at its end, for the guess of the next.
#[inline(always)]
pub(super) fn carry_change(state: &State, next: &mut State) {
    let change = Algorithmic::of_mut(&mut next.algorithmic, state.q.len()).change;
    for ((change, new), old) in change.iter_mut().zip(&next.u_dot).zip(&state.u_dot) {
        *change = new - old;
    }
}

impl Implicit {
    /// First iterate: accelerations that change as they did in the last step, `beta*` by the trapezoidal rule.
    #[inline(always)]
    pub(super) fn guess_consistent(&mut self, model: &Model, state: &State) {
        let change = Algorithmic::of(&state.algorithmic, model.n_modes()).change;
        for ((iterate, u_dot), change) in self.iterate.iter_mut().zip(&state.u_dot).zip(change) {
            *iterate = u_dot + change;
        }
        let Some((q_ddot, rigid)) = self.iterate.split_last_chunk_mut::<6>() else { return };
        self.beta_dot = true_velocity(&model.phi_r, q_ddot, rigid);
        let mut beta_star = state.beta_star;
        add_scaled(&mut beta_star, 0.5 * self.parameters.dt, &add_6(&tail(&state.u_dot), rigid));
        *rigid = beta_star;
    }

    /// As [`Implicit::evaluate`]; `fresh` where the matrix is to be that of the iterate.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn evaluate_consistent(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        start: &Start,
        loads: &Acting,
        time: f64,
        fresh: bool,
        work: &mut Workspace,
    ) -> Evaluation {
        let dt = self.parameters.dt;
        self.update_modes();
        let beta_star = tail(&self.iterate);
        if let Some(u) = self.u.last_chunk_mut::<6>() {
            *u = beta_star;
        }
        let beta = true_velocity(&model.phi_r, modal(&self.u), &beta_star);
        let theta = scale(0.5 * dt, add(start.w, split(&beta).1));
        let turn_quaternion = quaternion(theta);
        let turn = matrix(turn_quaternion);
        let attitude = mat_mul(&start.attitude, &turn);
        let accelerations = Accelerations {
            q_ddot: modal(&self.iterate),
            beta_dot: &self.beta_dot,
            fall: mul_t(&attitude, work.gravity),
        };
        lagrangian.inertia(&self.q, modal(&self.u), &beta, &accelerations, &mut work.lagrangian);

        let inverse_mass = 1.0 / model.data().rigid.mass;
        let centre = scale(inverse_mass, work.lagrangian.first_moment);
        let momentum_origin = work.lagrangian.momentum;
        let v_c = scale(inverse_mass, split(&momentum_origin).0);
        let travelled = scale(0.5 * dt, add(start.v_c, mul(&turn, v_c)));
        let place = add(travelled, sub(start.centre, mul(&turn, centre)));
        let position = add(state.position, mul(&start.attitude, place));
        let here = Motion { t: time, q: &self.q, u: &self.u, attitude, position, beta };
        relative_residual(model, lagrangian, loads, &here, work);

        let rate = about_centre(centre, &tail(&work.external));
        let momentum_known = mul_t_6(&turn, &start.momentum_known);
        let momentum = about_centre(centre, &momentum_origin);
        let mut missing = sub_6(&momentum_known, &momentum);
        add_scaled(&mut missing, self.parameters.velocity_gain, &rate);
        let missing = about_origin(centre, &missing);
        let mut rigid = RigidEvaluation {
            turn_quaternion,
            position,
            theta,
            rate,
            momentum_known,
            momentum,
            centre,
            net: [0.0; 6],
        };
        let mut at = Evaluation { beta, rigid: None, correction: 0.0, size: self.floor };
        if fresh {
            lagrangian.factorise(&mut work.lagrangian, &self.gains);
        }
        rigid.net = self.correct_consistent(model, lagrangian, work, &missing, &mut at);
        at.rigid = Some(rigid);
        at
    }

    /// The image of the iterate and the norms of the change, for the momentum that is missing; returns `M_RR beta*_dot`.
    fn correct_consistent(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        work: &mut Workspace,
        missing: &Vec6,
        at: &mut Evaluation,
    ) -> Vec6 {
        damp(model, modal(&self.u), &mut work.relative);
        let rigid = rigid_force(work);
        let Some((change, _)) = self.image.split_last_chunk_mut::<6>() else { return [0.0; 6] };
        let accelerated = lagrangian.correct(&mut work.lagrangian, &work.relative, &rigid, change);
        self.beta_dot = add_6(&self.beta_dot, &accelerated);
        self.change_modes(model, &mut work.relative, at);
        let beta = work.lagrangian.velocity(missing, &work.relative);
        let change = model.own_velocity(&beta, &work.relative);
        let beta_star = tail(&self.u);
        at.correction += dot_6(&change, &mul6_symmetric(&model.rigid_mass, &change));
        at.correction = at.correction.abs();
        at.size += dot_6(&beta_star, &mul6_symmetric(&model.rigid_mass, &beta_star));
        let Some((q_ddot, beta_image)) = self.image.split_last_chunk_mut::<6>() else { return [0.0; 6] };
        *beta_image = add_6(&beta_star, &change);
        mul6_symmetric(&model.rigid_mass, &model.own_velocity(&self.beta_dot, q_ddot))
    }

    /// Makes the image of the changes of the accelerations, puts those of the rates into `rates`, and adds to the norms.
    fn change_modes(&mut self, model: &Model, rates: &mut [f64], at: &mut Evaluation) {
        let gain = self.parameters.velocity_gain;
        let modes = self.image.iter_mut().zip(&self.iterate).zip(&self.u).zip(&model.elastic);
        for ((((image, old), q_dot), mode), rate) in modes.zip(rates) {
            *rate = gain * *image;
            *image += old;
            at.correction += mode.mass * *rate * *rate;
            at.size += mode.mass * q_dot * q_dot;
        }
    }

    /// As [`Implicit::evaluate_prescribed`]; `fresh` where the matrix is to be that of the iterate.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn evaluate_prescribed_consistent(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        motion: &PrescribedMotion,
        loads: &Acting,
        time: f64,
        fresh: bool,
        work: &mut Workspace,
    ) -> Evaluation {
        self.update_modes();
        let beta_star = model.own_velocity(&motion.velocity, modal(&self.u));
        if let Some(u) = self.u.last_chunk_mut::<6>() {
            *u = beta_star;
        }
        let attitude = matrix(normalised(motion.attitude));
        let accelerations = Accelerations {
            q_ddot: modal(&self.iterate),
            beta_dot: &motion.rate,
            fall: mul_t(&attitude, work.gravity),
        };
        lagrangian.inertia(&self.q, modal(&self.u), &motion.velocity, &accelerations, &mut work.lagrangian);
        let here = Motion {
            t: time,
            q: &self.q,
            u: &self.u,
            attitude,
            position: motion.position,
            beta: motion.velocity,
        };
        relative_residual(model, lagrangian, loads, &here, work);
        damp(model, modal(&self.u), &mut work.relative);
        let mut at = Evaluation { beta: motion.velocity, rigid: None, correction: 0.0, size: self.floor };
        if fresh {
            lagrangian.factorise_held(&mut work.lagrangian, &self.gains);
        }
        lagrangian.correct_held(&mut work.lagrangian, &mut work.relative);
        for (image, change) in self.image.iter_mut().zip(&work.relative) {
            *image = *change;
        }
        self.change_modes(model, &mut work.relative, &mut at);
        at.correction = at.correction.abs();
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
