//! Everything that changes while a model is marched.

use alloc::{vec, vec::Vec};

use crate::error::SettingsError;
use crate::integrator::algorithmic;
use crate::math::Vec6;
use crate::model::Model;
use crate::real::Real;

/// The state of a simulation: plain data. A clone is a snapshot, and stepping on from it gives the same bits.
///
/// The first eight fields are the physical state. `u_dot` and `algorithmic` are what the implicit integrators carry
/// from step to step; set `accelerations_known` to false after changing anything by hand, and the next step solves them
/// anew from the equations of motion.
#[derive(Debug, PartialEq)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// What rounding has taken from `time` so far (compensated summation), s.
    pub time_carry: f64,
    /// Modal amplitudes - (m).
    pub q: Vec<f64>,
    /// Modal rates, 1/s - (m).
    pub q_dot: Vec<f64>,
    /// Rigid part of the velocity of A, in A: v* (m/s), w* (rad/s). The true one is `Phi_R q_dot + beta*` - (6).
    pub beta_star: [f64; 6],
    /// Attitude quaternion zeta, scalar first, components in A to components in G - (4).
    pub attitude: [f64; 4],
    /// Position `r_G` of the origin of A in G, m - (3).
    pub position: [f64; 3],
    /// Accelerations `(q_ddot, beta*_dot)` at `time`, 1/s^2, m/s^2 and rad/s^2 - (m + 6).
    pub u_dot: Vec<f64>,
    /// Auxiliary variable of the generalised-alpha method: `a` of every mode, then the inertial rate of momentum and of
    /// moment of momentum about the centre of mass, in A - (m + 6). Of models with consistent inertia also these momenta, their true
    /// rates, and the centre of mass, in A, which the next step need not evaluate, and the change of `u_dot` in the last step, from which the
    /// next one guesses its own - (2 m + 27).
    pub algorithmic: Vec<f64>,
    /// Whether `u_dot` and `algorithmic` belong to the rest of the state.
    pub accelerations_known: bool,
}

impl Clone for State {
    fn clone(&self) -> Self {
        State {
            q: self.q.clone(),
            q_dot: self.q_dot.clone(),
            u_dot: self.u_dot.clone(),
            algorithmic: self.algorithmic.clone(),
            ..*self
        }
    }

    /// Takes no memory where the lengths agree: one snapshot can be taken over and over.
    fn clone_from(&mut self, other: &Self) {
        let State { q, q_dot, u_dot, algorithmic, .. } = self;
        for (to, from) in
            [(q, &other.q), (q_dot, &other.q_dot), (u_dot, &other.u_dot), (algorithmic, &other.algorithmic)]
        {
            to.clone_from(from);
        }
        self.copy_from(other);
    }
}

impl State {
    /// At rest in the equilibrium at t = 0, with the attitude of A and the place of its origin that the model says.
    pub fn at_rest(model: &Model) -> Self {
        let m = model.n_modes();
        State {
            time: 0.0,
            time_carry: 0.0,
            q: vec![0.0; m],
            q_dot: vec![0.0; m],
            beta_star: [0.0; 6],
            attitude: model.initial_attitude(),
            position: model.data().rigid.initial_position,
            u_dot: vec![0.0; m + 6],
            algorithmic: vec![0.0; algorithmic::length(model)],
            accelerations_known: false,
        }
    }

    /// Copies without allocating (the lengths must agree, see [`State::check`]).
    pub(crate) fn copy_from(&mut self, other: &State) {
        self.time = other.time;
        self.time_carry = other.time_carry;
        self.beta_star = other.beta_star;
        self.attitude = other.attitude;
        self.position = other.position;
        self.accelerations_known = other.accelerations_known;
        let arrays = [
            (&mut self.q, &other.q),
            (&mut self.q_dot, &other.q_dot),
            (&mut self.u_dot, &other.u_dot),
            (&mut self.algorithmic, &other.algorithmic),
        ];
        for (to, from) in arrays {
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from;
            }
        }
    }

    /// Whether the state fits the model: lengths, finite numbers, a unit quaternion (to 1e-6).
    ///
    /// # Errors
    /// [`SettingsError::State`], naming the part.
    pub fn check(&self, model: &Model) -> Result<(), SettingsError> {
        let m = model.n_modes();
        let lengths = [
            ("length of q", self.q.len(), m),
            ("length of q_dot", self.q_dot.len(), m),
            ("length of u_dot", self.u_dot.len(), m + 6),
            ("length of algorithmic", self.algorithmic.len(), algorithmic::length(model)),
        ];
        for (what, found, expected) in lengths {
            if found != expected {
                return Err(SettingsError::State { what, found: found as f64, expected: expected as f64 });
            }
        }
        let norm2: f64 = self.attitude.iter().map(|x| x * x).sum();
        // Spelt so that a NaN fails too.
        let unit = (norm2 - 1.0).abs() <= 1e-6;
        if !unit {
            return Err(SettingsError::State {
                what: "squared length of attitude",
                found: norm2,
                expected: 1.0,
            });
        }
        let arrays: [(&str, &[f64]); 8] = [
            ("time", &[self.time, self.time_carry]),
            ("an entry of q", &self.q),
            ("an entry of q_dot", &self.q_dot),
            ("an entry of beta_star", &self.beta_star),
            ("an entry of attitude", &self.attitude),
            ("an entry of position", &self.position),
            ("an entry of u_dot", &self.u_dot),
            ("an entry of algorithmic", &self.algorithmic),
        ];
        for (what, values) in arrays {
            if let Some(&found) = values.iter().find(|x| !x.is_finite()) {
                return Err(SettingsError::State { what, found, expected: 0.0 });
            }
        }
        Ok(())
    }

    /// Advances the time by `dt`, keeping what rounding takes away for the next call.
    pub(crate) fn advance_time(&mut self, dt: f64) {
        let increment = dt + self.time_carry;
        let time = self.time + increment;
        self.time_carry = increment - (time - self.time);
        self.time = time;
    }

    /// Time after a step of `dt`, as [`State::advance_time`] will have it.
    pub(crate) fn time_after(&self, dt: f64) -> f64 {
        self.time + (dt + self.time_carry)
    }

    /// Attitude as a nalgebra quaternion, components in A to components in G.
    pub fn attitude_quaternion(&self) -> nalgebra::UnitQuaternion<f64> {
        let [w, x, y, z] = self.attitude;
        nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
    }
}

/// True velocity of A in A, `beta = Phi_R q_dot + beta*` (theory section 4).
#[inline(always)]
pub(crate) fn true_velocity<R: Real>(phi_r: &[Vec6], q_dot: &[R], beta_star: &Vec6<R>) -> Vec6<R> {
    let mut beta = *beta_star;
    for (phi, q_dot) in phi_r.iter().zip(q_dot) {
        for (beta, phi) in beta.iter_mut().zip(phi) {
            *beta += R::of(*phi) * *q_dot;
        }
    }
    beta
}
