//! Why a nonlinear simulation stops.

/// The nonlinear simulation stopped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NonlinearError {
    /// Newton's iteration does not converge, however small the step.
    #[error(
        "no convergence at t = {time:.6} s even with steps of {dt:.1e} s: out of balance {residual:.2e} at {place} after {iterations} iterations"
    )]
    NotConverged {
        /// Time at the end of the failed step, s.
        time: f64,
        /// Smallest step tried, s.
        dt: f64,
        /// Iterations of the last attempt.
        iterations: usize,
        /// Largest out-of-balance force or moment, N or N m.
        residual: f64,
        /// Where it is.
        place: String,
    },
    /// The tangent matrix is singular.
    #[error(
        "singular tangent at t = {time:.6} s at {place}: a part of the structure has no mass or no stiffness"
    )]
    Singular {
        /// Time, s.
        time: f64,
        /// Where.
        place: String,
    },
    /// An element is bent beyond the range of its interpolation.
    #[error(
        "at t = {time:.6} s member `{member}`, element {element}, is bent by {degrees:.0} degrees between its nodes; use more elements"
    )]
    CoarseElement {
        /// Time, s.
        time: f64,
        /// Member name.
        member: String,
        /// Element within the member, from 1.
        element: usize,
        /// Relative rotation of its nodes, degrees.
        degrees: f64,
    },
}
