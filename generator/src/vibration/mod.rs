//! Natural modes as engineers look at them: how they move, what symmetry they have, how their frequencies change with the load.
//!
//! ```text
//! State (shape, steady rotation) --analyse--> ModeSet    frequencies, shapes, masses, symmetry
//!                                --spinning-> Spectrum   frequencies on a turning hub, complex shapes
//! Spectrum, Spectrum, ..         --tracking-> order      which mode is which from one load level to the next
//! ```

pub mod shapes;
pub mod spin;
pub mod symmetry;
#[cfg(test)]
mod tests;
pub mod tracking;

pub use shapes::{ModeSet, Shape, analyse};
pub use spin::spinning;
pub use symmetry::{MirrorPlane, Parity};
pub use tracking::{Spectrum, track};

pub use crate::mesh::Support;

use crate::equilibrium::EquilibriumError;
use crate::solve::dense::DenseError;
use crate::solve::eigen::EigenError;

/// Modes that cannot be had.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VibrationError {
    /// No such equilibrium.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// The eigenproblem failed.
    #[error("modes: {0}")]
    Modes(#[from] EigenError),
    /// The eigenproblem on a turning hub failed.
    #[error("modes on the turning hub: {0}")]
    Dense(#[from] DenseError),
    /// A trim has no meaning on a turning hub.
    #[error(
        "the equilibrium of the structure file solves for the balance of a body in flight, which a body on a turning hub does not need; take `balance` out of it"
    )]
    BalanceInTurn,
}
