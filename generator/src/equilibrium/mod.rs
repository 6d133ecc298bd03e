//! Nonlinear static equilibrium with the reference node held (theory section 3): `Qstif_S(eta) = Qext_S(eta)`, or, about a steady
//! rotation of the body, `Qstif_S(eta) + Qgyr_S(eta, 0, beta) = Qext_S(eta)`.
//!
//! ```text
//! solve(mesh, case, settings)
//!   stepping   load factor 0 -> 1, steps halved and doubled, stability watched       [`stepping`]
//!     newton   damped Newton on the exact tangent, rotations updated by Q exp(theta~) [`newton`]
//!       balance   Qstif_S + Qgyr_S - Qext_S and its derivative, sparse                         [`balance`]
//! ```
//!
//! A holds its axes, in a given attitude against G's, in which dead loads and gravity are constant. The reference node has no unknowns; what keeps it
//! in place is the reaction, the opposite of the out-of-balance load of a body that should fly free.

mod balance;
mod error;
mod newton;
mod steady_motion;
mod stepping;
#[cfg(test)]
mod tests;
pub mod trim;
#[cfg(test)]
mod trim_tests;

pub use error::EquilibriumError;
pub use stepping::LoadPath;

use nalgebra::{UnitQuaternion, Vector3, Vector6};
use rom_runtime::loads::{Load, LoadCase};

use crate::configuration::Configuration;
use crate::mesh::Mesh;

/// Reaction at the reference node, relative to the loads, below which a body flies by itself: it accelerates by the reaction over its
/// mass, and a millionth of the loads is no more than their rounding.
pub const SELF_BALANCED: f64 = 1e-6;

/// What to do about an equilibrium that the structure would leave by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum WhenUnstable {
    /// An error with the load factor of the loss of stability.
    #[default]
    Refuse,
    /// Carry on: the path is followed past the buckling load, and [`Equilibrium::stability`] tells.
    Accept,
}

/// How the equilibrium is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquilibriumSettings {
    /// Time at which the loads are taken, s.
    pub time: f64,
    /// Steady velocities `beta` of A in A: translation (m/s), rotation (rad/s). With a rotation the inertia forces of the deformed
    /// body belong to the loads; dead loads, which turn in A then, are refused.
    pub beta: Vector6<f64>,
    /// Attitude of A, components in A to components in G: dead loads and gravity are given in G.
    pub attitude: UnitQuaternion<f64>,
    /// Load steps to begin with; steps are halved and doubled as the iteration fares.
    pub load_steps: usize,
    /// Last correction of Newton's iteration, relative to the size of the structure (rotations: rad). The iteration converges
    /// quadratically, so that what is left after it is of the order of its square.
    pub tolerance: f64,
    /// Unstable equilibria.
    pub when_unstable: WhenUnstable,
}

impl Default for EquilibriumSettings {
    fn default() -> Self {
        Self {
            time: 0.0,
            beta: Vector6::zeros(),
            attitude: UnitQuaternion::identity(),
            load_steps: 1,
            tolerance: 1e-9,
            when_unstable: WhenUnstable::Refuse,
        }
    }
}

/// Whether a structure with its reference node held stays in an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// The loads have a potential and the tangent is positive definite.
    Stable,
    /// The loads have a potential and the tangent has negative eigenvalues: buckled.
    Unstable {
        /// How many.
        negative_eigenvalues: usize,
    },
    /// The loads follow the structure, so that the tangent is not symmetric. A negative determinant proves divergence (an odd
    /// number of real eigenvalues below zero); a positive one does not exclude flutter, which is not a matter of statics.
    Following {
        /// Whether the determinant is negative.
        diverged: bool,
    },
}

impl Stability {
    /// Whether the equilibrium is known to be unstable.
    pub fn is_unstable(self) -> bool {
        matches!(self, Self::Unstable { .. } | Self::Following { diverged: true })
    }
}

/// A structure in balance with its loads.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// Where every node is.
    pub configuration: Configuration,
    /// Loads in balance: those of the case at their time, times the load factor, constant from now on.
    pub loads: Vec<Load>,
    /// Attitude of A, components in A to components in G.
    pub attitude: UnitQuaternion<f64>,
    /// Factors that were solved for, by the name of the loads; contained in `loads`.
    pub factors: Vec<(String, f64)>,
    /// Steady velocities of A that belong to the balance: translation (m/s), rotation (rad/s).
    pub beta: Vector6<f64>,
    /// Factor on the loads of the case and on the inertia forces of a steady rotation (on the square of its rate).
    pub load_factor: f64,
    /// Force on the reference node that holds it, N, in A.
    pub reaction_force: Vector3<f64>,
    /// Moment on the reference node that holds it, N m, in A about its origin.
    pub reaction_moment: Vector3<f64>,
    /// Sum of the magnitudes of all forces, N.
    pub force_scale: f64,
    /// Sum of the magnitudes of all moments and of force times distance from the origin of A, N m.
    pub moment_scale: f64,
    /// Largest out-of-balance force (N) or moment (N m) on a node.
    pub residual: f64,
    /// Elastic forces on the nodes, which carry the loads: force in A (N), moment in the node frame (N m) - (nodes).
    pub elastic_force: Vec<Vector6<f64>>,
    /// Elastic energy, J.
    pub energy: f64,
    /// Stability with the reference node held.
    pub stability: Stability,
    /// Load steps that succeeded.
    pub load_steps: usize,
    /// Load steps that were given up and halved.
    pub refused_steps: usize,
    /// Newton iterations, those of refused steps included.
    pub iterations: usize,
}

/// How far an equilibrium is from flying by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfBalance {
    /// Reaction force over the sum of the magnitudes of all forces; 0 balanced, 1 all carried by the reference node.
    pub force: f64,
    /// Reaction moment over the sum of the magnitudes of all moments.
    pub moment: f64,
}

impl SelfBalance {
    /// Whether both parts are below `tolerance`.
    pub fn within(&self, tolerance: f64) -> bool {
        self.force <= tolerance && self.moment <= tolerance
    }
}

impl Equilibrium {
    /// Reaction relative to the loads: a body that flies free in this state would have none.
    pub fn self_balance(&self) -> SelfBalance {
        let ratio = |reaction: f64, scale: f64| if scale > 0.0 { reaction / scale } else { 0.0 };
        SelfBalance {
            force: ratio(self.reaction_force.norm(), self.force_scale),
            moment: ratio(self.reaction_moment.norm(), self.moment_scale),
        }
    }
}

/// Equilibrium of a structure under gravity and the loads of a case, from its drawing.
///
/// # Errors
/// Settings out of range, a load that is not a number, no equilibrium within reach of the path (limit load), loss of stability
/// unless that is accepted, a mechanism, elements bent beyond the range of their interpolation.
pub fn solve(
    mesh: &Mesh,
    case: &LoadCase,
    settings: &EquilibriumSettings,
) -> Result<Equilibrium, EquilibriumError> {
    let mut path = LoadPath::new(mesh, case, settings)?;
    path.advance_to(1.0)?;
    Ok(path.equilibrium())
}
