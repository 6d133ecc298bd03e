//! Time integrators: one file per family.

pub(crate) mod algorithmic;
pub(crate) mod consistent;
pub(crate) mod energy_momentum;
pub(crate) mod implicit;
pub(crate) mod newton;
pub(crate) mod parameters;
mod prescribed;
pub(crate) mod rk4;

use core::fmt;

/// How a simulation is marched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// Newmark with numerical damping `a`: `gamma = 1/2 + a`, `beta_N = (gamma + 1/2)^2/4`. Implicit, stable for any
    /// step, second order without numerical damping and first order with it.
    #[default]
    Newmark,
    /// Classical Runge-Kutta: explicit, fourth order, limited step.
    Rk4,
    /// Generalised-alpha (Chung & Hulbert; Bruels & Cardona on the rotations). Implicit, stable for any step, second
    /// order; high frequencies are damped with spectral radius `rho_inf = (1 - a)/(1 + a)`, `a` being the same numerical
    /// damping as Newmark's (both then have the same gamma and beta_N).
    GeneralizedAlpha,
    /// Energy-momentum method for the long run: implicit, second order, without numerical damping. It keeps energy, momentum and moment
    /// of momentum of a free body, and its energy in uniform gravity, at any step. For models with consistent inertia in free flight.
    EnergyMomentum,
}

impl Integrator {
    /// All of them.
    pub const ALL: [Integrator; 4] =
        [Integrator::Newmark, Integrator::Rk4, Integrator::GeneralizedAlpha, Integrator::EnergyMomentum];

    /// Those that march a model: the energy-momentum method needs a model with consistent inertia that flies.
    pub fn of(model: &crate::Model) -> impl Iterator<Item = Integrator> {
        let has_energy = model.lagrangian.is_some() && !model.is_clamped();
        Self::ALL.into_iter().filter(move |it| has_energy || *it != Integrator::EnergyMomentum)
    }

    /// Whether it has numerical damping to set ([`crate::Settings::numerical_damping`]).
    pub fn has_numerical_damping(self) -> bool {
        matches!(self, Integrator::Newmark | Integrator::GeneralizedAlpha)
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Integrator::Newmark => "newmark",
            Integrator::Rk4 => "rk4",
            Integrator::GeneralizedAlpha => "gen-alpha",
            Integrator::EnergyMomentum => "energy-momentum",
        }
    }

    /// Longest stable time step of the model's linear oscillators and what limits it; none when there is no limit.
    pub fn stable_dt(self, model: &crate::Model) -> Option<StableDt> {
        if self != Integrator::Rk4 {
            return None;
        }
        let modes = &model.data().modes;
        let limits = modes
            .number
            .iter()
            .zip(&modes.omega)
            .zip(&modes.damping_ratio)
            .map(|((&mode, &omega), &ratio)| StableDt { dt: rk4::stable_dt(omega, ratio), mode, omega });
        limits.min_by(|a, b| a.dt.total_cmp(&b.dt))
    }
}

/// Stability limit of an explicit integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableDt {
    /// Longest stable step, s.
    pub dt: f64,
    /// Number of the mode that sets it, in the structure's list of elastic modes, from 1.
    pub mode: u32,
    /// Its circular frequency, rad/s.
    pub omega: f64,
}

impl fmt::Display for Integrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl core::str::FromStr for Integrator {
    type Err = UnknownIntegrator;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|integrator| integrator.name() == name).ok_or(UnknownIntegrator)
    }
}

/// The name is not one of an integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of: newmark, rk4, gen-alpha, energy-momentum")]
pub struct UnknownIntegrator;
