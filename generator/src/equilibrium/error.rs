//! Why there is no equilibrium to report.

/// No equilibrium was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EquilibriumError {
    /// A setting is out of its range.
    #[error("equilibrium: {what} is {found}; expected {expected}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A load is not a finite number.
    #[error(
        "equilibrium: load {load} of load case `{case}` on {place} is not a finite number at t = {time} s; check its time function"
    )]
    Load {
        /// Number of the load in its case, from 1.
        load: usize,
        /// Load case.
        case: String,
        /// Point or member.
        place: String,
        /// Time, s.
        time: f64,
    },
    /// A load constant in G on a body that turns.
    #[error(
        "equilibrium: load case `{case}` has a dead load on {place}, but the body turns: dead loads turn in its axes, and it is not in a steady state; use body or follower loads"
    )]
    DeadLoadInTurn {
        /// Load case.
        case: String,
        /// Point or member.
        place: String,
    },
    /// Gravity on a body that turns.
    #[error(
        "equilibrium: the body turns, and gravity with it in its axes, so that it is not in a steady state; leave gravity out"
    )]
    GravityInTurn,
    /// The body cannot fly by itself in the equilibrium.
    #[error(
        "equilibrium: not in balance with itself: {force:.4} N and {moment:.4} N m about the reference node would have to hold it; solve for the factor of a load with `balance`, add the loads that are missing, or accept it with `unbalanced = \"warn\"`"
    )]
    Unbalanced {
        /// Reaction force at the reference node, N.
        force: f64,
        /// Reaction moment about it, N m.
        moment: f64,
    },
    /// Factors of loads could not be found.
    #[error("equilibrium: balance: {0}")]
    Balance(String),
    /// No balance could be found beyond a load factor.
    #[error(
        "equilibrium: followed to load factor {reached:.6} of {target}; the next step of {step:.1e} finds no balance near by (out of balance {residual:.2e} at {place}). {why}"
    )]
    NotConverged {
        /// Load factor of the last equilibrium.
        reached: f64,
        /// Load factor asked for.
        target: f64,
        /// Smallest step tried.
        step: f64,
        /// Largest out-of-balance force or moment of the last attempt, N or N m.
        residual: f64,
        /// Where it is.
        place: String,
        /// What the last attempt ended with, and what to do.
        why: &'static str,
    },
    /// The structure buckles under the loads.
    #[error(
        "equilibrium: buckling between load factors {stable_at:.6} and {load_factor:.6}: the tangent has {negative_eigenvalues} negative eigenvalue(s) there; lower the loads, stiffen the structure, or accept unstable equilibria"
    )]
    Buckling {
        /// Last load factor with a stable equilibrium.
        stable_at: f64,
        /// First load factor found unstable.
        load_factor: f64,
        /// Of the tangent with the reference node held.
        negative_eigenvalues: usize,
    },
    /// The structure diverges under loads that follow it.
    #[error(
        "equilibrium: divergence between load factors {stable_at:.6} and {load_factor:.6}: the determinant of the tangent changes its sign; lower the loads, stiffen the structure, or accept unstable equilibria"
    )]
    Divergence {
        /// Last load factor with a positive determinant.
        stable_at: f64,
        /// First load factor with a negative one.
        load_factor: f64,
    },
    /// The tangent is singular.
    #[error(
        "equilibrium: singular tangent at load factor {load_factor:.6} at {place}: a part of the structure has no stiffness"
    )]
    Singular {
        /// Load factor.
        load_factor: f64,
        /// Where.
        place: String,
    },
    /// An element is bent beyond the range of its interpolation.
    #[error(
        "equilibrium: at load factor {load_factor:.6} member `{member}`, element {element}, is bent by {degrees:.0} degrees between its nodes; use more elements"
    )]
    CoarseElement {
        /// Load factor.
        load_factor: f64,
        /// Member name.
        member: String,
        /// Element within the member, from 1.
        element: usize,
        /// Relative rotation of its nodes, degrees.
        degrees: f64,
    },
}
