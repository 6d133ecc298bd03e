//! An integrator for the long run of consistent models: it keeps energy and momenta at any step (docs/beyond.md).
//!
//! With the centre of mass apart, `T = 1/2 m v_c^2 + 1/2 xi . M_c(q) xi`, `xi = (w, q_dot)` and the momenta `(Pi, mu) = M_c xi`. From the
//! identity
//!
//! ```text
//! T_1 - T_0 = xi_m . (mu_1 - mu_0) - (F_1 - F_0),     F(q) = 1/2 xi_0 . M_c(q) xi_1,    xi_m = (xi_0 + xi_1)/2                (B.8)
//! ```
//!
//! the steps
//!
//! ```text
//! q_1 - q_0 = dt q_dot_m
//! mu_1 - mu_0 = dt (G(q_0, q_1) + Q_q - Q_v . c_i),           G . (q_1 - q_0) = F_1 - F_0 - (U_1 - U_0)
//! Pi_1 - Pi_0 = dt (Pi_m x w_m + Q_w - c x Q_v),              C_1 = C_0 cay(dt w_m)                                          (B.9)
//! m (v_c1 - v_c0) = dt C_m Q_v,                               r_c1 - r_c0 = dt (v_c0 + v_c1)/2
//! ```
//!
//! change the energy by the work of the loads, which are taken in the middle of the step, and keep momentum, moment of momentum in inertial
//! axes and the straight line of the centre of mass without loads. `G` is the gradient in the middle with Gonzalez' correction along
//! `q_1 - q_0` (J. Nonlinear Sci. 6, 1996). The derivative of `F` is that of `T` at `xi_m` less that at `(xi_1 - xi_0)/2`. Uniform gravity
//! acts on the centre of mass alone, so that its energy is kept as well.
//!
//! The iteration has the mass matrix, damping and stiffness in its matrix, as those of [`super::consistent`]; where it contracts slowly, on
//! long steps, the Jacobian is found by differences.

use alloc::{vec, vec::Vec};

use super::consistent::gains;
use super::implicit::{SLOW, TOLERANCE};
use super::newton::{factorise, substitute};
use super::parameters::Parameters;
use crate::dense::rows_mut;
use crate::equations::{Motion, Workspace, damp, relative_forces};
use crate::error::StepError;
use crate::four::Four;
use crate::lagrangian::Lagrangian;
use crate::loading::Acting;
use crate::math::{
    Mat3, Vec3, Vec6, add, add_scaled, axpy, cross, dot, join, mat_mul, matrix, mul, mul_t, normalised,
    quaternion_product, scale, split, sub,
};
use crate::model::Model;
use crate::state::{State, true_velocity};

/// Corrections that stop shrinking below this are round-off: the energy is kept to it, step by step.
const STAGNATION: f64 = 1e-12;
/// Relative step of the differences: the root of round-off.
const DIFFERENCE: f64 = 1e-7;

/// Memory of the integrator. Vectors of `m + 3` hold those of the modes first, then those of the spin.
#[derive(Clone, Debug)]
pub(crate) struct EnergyMomentum {
    dt: f64,
    /// `dt/2 C + dt^2/4 K`.
    gains: Vec<Four>,
    /// `xi_0`, `xi_1` and the momenta of both.
    start: Vec<f64>,
    iterate: Vec<f64>,
    momenta_0: Vec<f64>,
    momenta: Vec<f64>,
    residual: Vec<f64>,
    correction: Vec<f64>,
    /// Amplitudes at the end and in the middle, rates in the middle.
    q_1: Vec<f64>,
    q_m: Vec<f64>,
    rates: Vec<f64>,
    /// `(q_dot_m, beta*_m)`.
    u: Vec<f64>,
    gradient: Vec<f64>,
    /// Of the residual by `xi_1` - ((m + 3) x (m + 3)).
    jacobian: Vec<f64>,
    pivots: Vec<usize>,
    trial: Vec<f64>,
}

/// What a step knows at its start.
struct Start {
    attitude: Mat3,
    /// Centre of mass in G and its velocity.
    centre: Vec3,
    velocity: Vec3,
    /// Size of the energies: what their round-off is measured against.
    energy: f64,
}

/// What an evaluation finds of the end of the step.
#[derive(Clone, Copy, Default)]
struct End {
    turn: [f64; 4],
    /// Centre of mass in G and its velocity.
    centre: Vec3,
    velocity: Vec3,
    /// Centre of mass in A, and velocity of A where it rests.
    arm: Vec3,
    own: Vec3,
    /// Squared sizes of the correction and of the velocities.
    correction: f64,
    size: f64,
}

impl EnergyMomentum {
    pub(crate) fn new(model: &Model, dt: f64) -> Self {
        let m = model.n_modes();
        let vector = || vec![0.0; m + 3];
        EnergyMomentum {
            dt,
            gains: gains(model, &Parameters::newmark(dt, 0.0)),
            start: vector(),
            iterate: vector(),
            momenta_0: vector(),
            momenta: vector(),
            residual: vector(),
            correction: vector(),
            q_1: vec![0.0; m],
            q_m: vec![0.0; m],
            rates: vec![0.0; m],
            u: vec![0.0; m + 6],
            gradient: vec![0.0; m],
            jacobian: vec![0.0; (m + 3) * (m + 3)],
            pivots: vec![0; m + 3],
            trial: vector(),
        }
    }

    /// One step from `state` into `next`, in free flight.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn step(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        loads: &Acting,
        max_iterations: u32,
        work: &mut Workspace,
        next: &mut State,
    ) -> Result<(), StepError> {
        next.copy_from(state);
        next.advance_time(self.dt);
        let start = self.begin(model, lagrangian, state, work);
        let end = self.solve(model, lagrangian, state, &start, loads, max_iterations, work, next.time)?;
        self.finish(model, state, &end, next);
        Ok(())
    }

    fn begin(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        work: &mut Workspace,
    ) -> Start {
        let (v, w) = split(&true_velocity(&model.phi_r, &state.q_dot, &state.beta_star));
        put(&mut self.start, &state.q_dot, w);
        copy(&mut self.iterate, &self.start);
        let own = lagrangian.evaluate_centred(&state.q, &state.q_dot, w, &mut work.lagrangian);
        if let Some((modal, spin)) = self.momenta_0.split_last_chunk_mut::<3>() {
            *spin = work.lagrangian.centred_momenta(own, w, modal);
        }
        let attitude = matrix(state.attitude);
        let centre = work.lagrangian.centre(lagrangian.mass());
        let kinetic: f64 = self.momenta_0.iter().zip(&self.start).map(|(mu, xi)| mu * xi).sum();
        Start {
            attitude,
            centre: add(state.position, mul(&attitude, centre)),
            velocity: mul(&attitude, sub(v, own)),
            energy: kinetic.abs() + lagrangian.elastic_energy(&state.q).abs(),
        }
    }

    /// Iterates until the correction is round-off.
    #[allow(clippy::too_many_arguments)]
    fn solve(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        start: &Start,
        loads: &Acting,
        max_iterations: u32,
        work: &mut Workspace,
        time: f64,
    ) -> Result<End, StepError> {
        let (mut previous, mut relative) = (f64::INFINITY, f64::INFINITY);
        let (mut newton, mut slow) = (false, true);
        for iteration in 0..max_iterations {
            let mut at = self.evaluate(model, lagrangian, state, start, loads, work);
            if newton {
                if slow {
                    self.differentiate(model, lagrangian, state, start, loads, work);
                }
                copy(&mut self.correction, &self.residual);
                substitute(&self.jacobian, &self.pivots, self.correction.len(), &mut self.correction);
                at.correction = Self::norm(model, &self.correction);
            }
            let (correction, size) = (libm::sqrt(at.correction), libm::sqrt(at.size));
            let ratio = if previous.is_finite() { correction / previous } else { 1.0 };
            relative = correction / size;
            if !correction.is_finite() {
                let mode = self.correction.iter().take(model.n_modes()).position(|x| !x.is_finite());
                return Err(StepError::Diverged { time, mode });
            }
            // The iterate stays as it was evaluated: its own error has to be round-off.
            if correction <= TOLERANCE * size || (ratio > 0.5 && correction <= STAGNATION * size) {
                return Ok(at);
            }
            slow = ratio > SLOW;
            let give_up = !newton && ((iteration >= 2 && slow) || iteration >= 12);
            if give_up && ratio > 1.0 {
                copy(&mut self.iterate, &self.start);
            } else {
                add_scaled(&mut self.iterate, 1.0, &self.correction);
            }
            newton |= give_up;
            previous = if give_up { f64::INFINITY } else { correction };
            slow |= give_up;
        }
        Err(StepError::NotConverged { time, iterations: max_iterations, residual: relative })
    }

    /// Residual of (B.9) at the iterate, and its correction by the mass matrix at the end of the step.
    fn evaluate(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        start: &Start,
        loads: &Acting,
        work: &mut Workspace,
    ) -> End {
        let mut end = self.residual(model, lagrangian, state, start, loads, work);
        let Some((modal, spin)) = self.residual.split_last_chunk::<3>() else { return end };
        let Some((modal_correction, spin_correction)) = self.correction.split_last_chunk_mut::<3>() else {
            return end;
        };
        let rigid = join([0.0; 3], *spin);
        let beta = lagrangian.solve(&mut work.lagrangian, modal, &rigid, &self.gains, modal_correction);
        *spin_correction = split(&beta).1;
        end.correction = Self::norm(model, &self.correction);
        end.size += Self::norm(model, &self.iterate);
        end
    }

    /// Squared size of rates in the norm of kinetic energy.
    fn norm(model: &Model, x: &[f64]) -> f64 {
        let Some((modal, spin)) = x.split_last_chunk::<3>() else { return 0.0 };
        let modal: f64 = modal.iter().zip(&model.elastic).map(|(x, mode)| mode.mass * x * x).sum();
        let [_, _, _, x, y, z] = &model.rigid_mass;
        modal + x[3] * spin[0] * spin[0] + y[4] * spin[1] * spin[1] + z[5] * spin[2] * spin[2]
    }

    fn residual(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        start: &Start,
        loads: &Acting,
        work: &mut Workspace,
    ) -> End {
        let dt = self.dt;
        let (Some((rates_0, &w_0)), Some((rates_1, &w_1))) =
            (self.start.split_last_chunk::<3>(), self.iterate.split_last_chunk::<3>())
        else {
            return End::default();
        };
        for (((q_1, q_m), q), (r_0, r_1)) in
            self.q_1.iter_mut().zip(&mut self.q_m).zip(&state.q).zip(rates_0.iter().zip(rates_1))
        {
            *q_1 = q + 0.5 * dt * (r_0 + r_1);
            *q_m = 0.5 * (q + *q_1);
        }
        self.gradient.fill(0.0);
        // dF/dq in the middle: dT/dq at half the difference off that at the mean.
        let mut own = [0.0; 3];
        let mut w_m = [0.0; 3];
        for (sign, factor) in [(-1.0, -1.0), (1.0, 1.0)] {
            for (rate, (r_0, r_1)) in self.rates.iter_mut().zip(rates_0.iter().zip(rates_1)) {
                *rate = 0.5 * (r_1 + sign * r_0);
            }
            w_m = scale(0.5, axpy(w_1, sign, w_0));
            own = lagrangian.evaluate_centred(&self.q_m, &self.rates, w_m, &mut work.lagrangian);
            lagrangian.add_kinetic_gradient(factor, own, w_m, &mut work.lagrangian, &mut self.gradient);
        }
        let mut end = self.move_centre(model, lagrangian, state, start, loads, own, w_m, work);
        let torque = end.arm;
        // Momenta at the end, with the mass matrix for the correction.
        let Some((rates_1, _)) = self.iterate.split_last_chunk::<3>() else { return end };
        let own = lagrangian.evaluate_centred(&self.q_1, rates_1, w_1, &mut work.lagrangian);
        let Some((modal, spin)) = self.momenta.split_last_chunk_mut::<3>() else { return end };
        *spin = work.lagrangian.centred_momenta(own, w_1, modal);
        self.correct_gradient(lagrangian, state, start);
        end.arm = work.lagrangian.centre(lagrangian.mass());
        end.own = own;

        let (Some((modal_0, &spin_0)), Some((modal_1, &spin_1)), Some((modal, spin))) = (
            self.momenta_0.split_last_chunk::<3>(),
            self.momenta.split_last_chunk::<3>(),
            self.residual.split_last_chunk_mut::<3>(),
        ) else {
            return end;
        };
        let forces = self.gradient.iter().zip(&work.relative);
        for ((residual, (mu_0, mu_1)), (gradient, force)) in
            modal.iter_mut().zip(modal_0.iter().zip(modal_1)).zip(forces)
        {
            *residual = mu_0 - mu_1 + dt * (gradient + force);
        }
        let turning = add(cross(scale(0.5, add(spin_0, spin_1)), w_m), torque);
        *spin = axpy(sub(spin_0, spin_1), dt, turning);
        end
    }

    /// Loads in the middle of the step: those on the amplitudes with the elastic forces into `work.relative`, the moment about the centre of
    /// mass into `arm`, and where they take the centre of mass.
    #[allow(clippy::too_many_arguments)]
    fn move_centre(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        start: &Start,
        loads: &Acting,
        own: Vec3,
        w: Vec3,
        work: &mut Workspace,
    ) -> End {
        let (dt, mass) = (self.dt, lagrangian.mass());
        let turn = cayley(scale(dt, w));
        // Half of that rotation.
        let half = matrix(normalised([1.0 + turn[0], turn[1], turn[2], turn[3]]));
        let attitude = mat_mul(&start.attitude, &half);
        let centre = work.lagrangian.centre(mass);
        let place = axpy(start.centre, 0.5 * dt, start.velocity);
        let v = add(own, mul_t(&attitude, start.velocity));
        let beta: Vec6 = join(v, w);
        for (u, rate) in self.u.iter_mut().zip(&self.rates) {
            *u = *rate;
        }
        if let Some(last) = self.u.last_chunk_mut::<6>() {
            *last = model.own_velocity(&beta, &self.rates);
        }
        lagrangian.elastic_forces(&self.q_m, &mut work.lagrangian);
        let here = Motion {
            t: state.time + 0.5 * dt,
            q: &self.q_m,
            u: &self.u,
            attitude,
            position: sub(place, mul(&attitude, centre)),
            beta,
        };
        relative_forces(model, lagrangian, loads, &here, work);
        damp(model, &self.rates, &mut work.relative);
        let (force, moment) = split(&work.external.last_chunk::<6>().copied().unwrap_or_default());
        // Where the centre of mass rests A moves against it.
        work.lagrangian.add_coupled(&join(scale(-1.0 / mass, force), [0.0; 3]), &mut work.relative);
        let velocity = axpy(start.velocity, dt / mass, mul(&attitude, force));
        let fall = scale(dt / mass, force);
        End {
            turn,
            centre: axpy(start.centre, 0.5 * dt, add(start.velocity, velocity)),
            velocity,
            arm: sub(moment, cross(centre, force)),
            size: mass * (dot(fall, fall) + dot(velocity, velocity)),
            ..End::default()
        }
    }

    /// Gonzalez' correction: what the gradients in the middle miss of the differences of `F` and of the energy of self-stress.
    fn correct_gradient(&mut self, lagrangian: &Lagrangian, state: &State, start: &Start) {
        let of_1: f64 = self.momenta.iter().zip(&self.start).map(|(mu, xi)| mu * xi).sum();
        let of_0: f64 = self.momenta_0.iter().zip(&self.iterate).map(|(mu, xi)| mu * xi).sum();
        let moved = || self.q_1.iter().zip(&state.q).map(|(q_1, q_0)| q_1 - q_0);
        let along: f64 = moved().zip(&self.gradient).map(|(moved, gradient)| moved * gradient).sum();
        let missed =
            0.5 * (of_1 - of_0) - along - lagrangian.self_stress_defect(&state.q, &self.q_m, &self.q_1);
        let squared: f64 = moved().map(|moved| moved * moved).sum();
        // Below the round-off of the energies there is nothing to correct.
        let size = start.energy + of_1.abs() + of_0.abs();
        if missed.abs() > 16.0 * f64::EPSILON * size && squared > 0.0 {
            let factor = missed / squared;
            for (gradient, (q_1, q_0)) in self.gradient.iter_mut().zip(self.q_1.iter().zip(&state.q)) {
                *gradient += factor * (q_1 - q_0);
            }
        }
    }

    /// The Jacobian by differences of the residual at the iterate, whose residual stays.
    #[cold]
    fn differentiate(
        &mut self,
        model: &Model,
        lagrangian: &Lagrangian,
        state: &State,
        start: &Start,
        loads: &Acting,
        work: &mut Workspace,
    ) {
        let n = self.iterate.len();
        copy(&mut self.trial, &self.residual);
        let largest = |x: &[f64]| x.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let Some((modal, spin)) = self.iterate.split_last_chunk::<3>() else { return };
        let (m, sizes) = (modal.len(), [largest(modal).max(1e-3), largest(spin).max(1e-3)]);
        for column in 0..n {
            let step = DIFFERENCE * if column < m { sizes[0] } else { sizes[1] };
            let Some(value) = self.iterate.get(column).copied() else { break };
            set(&mut self.iterate, column, value + step);
            self.residual(model, lagrangian, state, start, loads, work);
            set(&mut self.iterate, column, value);
            for (row, (there, here)) in
                rows_mut(&mut self.jacobian, n).zip(self.residual.iter().zip(&self.trial))
            {
                set(row, column, (here - there) / step);
            }
        }
        copy(&mut self.residual, &self.trial);
        factorise(&mut self.jacobian, &mut self.pivots, n);
    }

    fn finish(&self, model: &Model, state: &State, end: &End, next: &mut State) {
        copy(&mut next.q, &self.q_1);
        let Some((rates, &w)) = self.iterate.split_last_chunk::<3>() else { return };
        copy(&mut next.q_dot, rates);
        next.attitude = normalised(quaternion_product(state.attitude, end.turn));
        let attitude = matrix(next.attitude);
        next.position = sub(end.centre, mul(&attitude, end.arm));
        let v = add(mul_t(&attitude, end.velocity), end.own);
        next.beta_star = model.own_velocity(&join(v, w), rates);
        next.accelerations_known = false;
    }
}

/// `(1 - theta~/2)^-1 (1 + theta~/2)` as a quaternion.
fn cayley(theta: Vec3) -> [f64; 4] {
    normalised([1.0, 0.5 * theta[0], 0.5 * theta[1], 0.5 * theta[2]])
}

fn put(to: &mut [f64], modal: &[f64], spin: Vec3) {
    if let Some((to_modal, to_spin)) = to.split_last_chunk_mut::<3>() {
        copy(to_modal, modal);
        *to_spin = spin;
    }
}

fn copy(to: &mut [f64], from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

fn set(values: &mut [f64], at: usize, x: f64) {
    if let Some(value) = values.get_mut(at) {
        *value = x;
    }
}
