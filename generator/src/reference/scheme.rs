//! Newmark and generalised-alpha on positions and rotations, as numbers derived once.
//!
//! Per node and step, with `a` the auxiliary accelerations (the true ones for Newmark),
//!
//! ```text
//! u        = dt v_0 + dt^2 ((1/2 - beta) a_0 + beta a_1)       displacement, and rotation vector theta of the step
//! v_1      = v_0 + dt ((1 - gamma) a_0 + gamma a_1)            R_1 = R_0 + u,  Q_1 = Q_0 exp(theta~)
//! (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) x''_1 + alpha_f x''_0
//! ```
//!
//! (Newmark as in the paper; the Lie-group form and the generalised-alpha of Bruels, Cardona & Arnold 2012.) Loads and
//! equilibrium are taken at the end of the step.

use nalgebra::Vector3;

use crate::element::inertia_force::RateFactors;

/// Constants of an implicit scheme for one time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Time step, s.
    pub dt: f64,
    alpha_m: f64,
    alpha_f: f64,
    beta: f64,
    gamma: f64,
}

/// Family of implicit schemes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Newmark: `gamma = 1/2 + a`, `beta = (gamma + 1/2)^2 / 4`.
    Newmark,
    /// Generalised-alpha with `rho_inf = (1 - a)/(1 + a)`, which has the same gamma and beta.
    GeneralizedAlpha,
}

impl Scheme {
    /// With numerical damping `a`.
    pub fn new(family: Family, dt: f64, a: f64) -> Self {
        let gamma = 0.5 + a;
        let beta = 0.25 * (gamma + 0.5) * (gamma + 0.5);
        let (alpha_m, alpha_f) = match family {
            Family::Newmark => (0.0, 0.0),
            Family::GeneralizedAlpha => (0.5 * (1.0 - 3.0 * a), 0.5 * (1.0 - a)),
        };
        Self { dt, alpha_m, alpha_f, beta, gamma }
    }

    /// The same scheme with another step.
    pub fn with_dt(self, dt: f64) -> Self {
        Self { dt, ..self }
    }

    /// Derivatives of the end rates in the increment of the step.
    pub fn factors(&self) -> RateFactors {
        RateFactors {
            velocity: self.gamma / (self.beta * self.dt),
            acceleration: (1.0 - self.alpha_m) / ((1.0 - self.alpha_f) * self.beta * self.dt * self.dt),
        }
    }

    /// Increment of the step if the auxiliary acceleration stays what it was.
    pub fn predict(&self, v0: &Vector3<f64>, a0: &Vector3<f64>) -> Vector3<f64> {
        v0 * self.dt + a0 * (0.5 * self.dt * self.dt)
    }

    /// End values `(velocity, auxiliary acceleration, true acceleration)` of an increment.
    pub fn rates(
        &self,
        increment: &Vector3<f64>,
        v0: &Vector3<f64>,
        a0: &Vector3<f64>,
        acceleration0: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
        let dt = self.dt;
        let a1 = (increment - v0 * dt - a0 * ((0.5 - self.beta) * dt * dt)) / (self.beta * dt * dt);
        let v1 = v0 + (a0 * (1.0 - self.gamma) + a1 * self.gamma) * dt;
        let acceleration1 = (a1 * (1.0 - self.alpha_m) + a0 * self.alpha_m - acceleration0 * self.alpha_f)
            / (1.0 - self.alpha_f);
        (v1, a1, acceleration1)
    }
}
