//! Constants of Newmark and of the generalised-alpha method.

use crate::real::Real;

/// Constants of the method, derived once from the numerical damping and the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parameters {
    /// Time step, s.
    pub(crate) dt: f64,
    alpha_m: f64,
    alpha_f: f64,
    pub(crate) beta: f64,
    pub(crate) gamma: f64,
    /// `d q_dot_1 / d q_ddot_1 = gamma dt (1 - alpha_f)/(1 - alpha_m)`.
    pub(crate) velocity_gain: f64,
    /// `d q_1 / d q_ddot_1`.
    pub(crate) position_gain: f64,
}

impl Parameters {
    /// Newmark with `gamma = 1/2 + a`, `beta = (gamma + 1/2)^2/4`.
    pub(crate) fn newmark(dt: f64, a: f64) -> Self {
        Self::new(dt, a, 0.0, 0.0)
    }

    /// Generalised-alpha with `rho_inf = (1 - a)/(1 + a)`: `alpha_m = (2 rho - 1)/(rho + 1)`, `alpha_f = rho/(rho + 1)`.
    pub(crate) fn generalized_alpha(dt: f64, a: f64) -> Self {
        Self::new(dt, a, 0.5 * (1.0 - 3.0 * a), 0.5 * (1.0 - a))
    }

    fn new(dt: f64, a: f64, alpha_m: f64, alpha_f: f64) -> Self {
        let gamma = 0.5 + a;
        let beta = 0.25 * (gamma + 0.5) * (gamma + 0.5);
        let share = (1.0 - alpha_f) / (1.0 - alpha_m);
        Parameters {
            dt,
            alpha_m,
            alpha_f,
            beta,
            gamma,
            velocity_gain: dt * gamma * share,
            position_gain: dt * dt * beta * share,
        }
    }

    /// The part of `a_1` that is known at the start of a step.
    #[inline(always)]
    pub(crate) fn known<R: Real>(&self, x_ddot: R, a: R) -> R {
        (R::of(self.alpha_f) * x_ddot - R::of(self.alpha_m) * a) / R::of(1.0 - self.alpha_m)
    }

    /// `a_1` from `x_ddot_1` and its known part.
    #[inline(always)]
    pub(crate) fn auxiliary<R: Real>(&self, x_ddot: R, known: R) -> R {
        R::of((1.0 - self.alpha_f) / (1.0 - self.alpha_m)) * x_ddot + known
    }
}
