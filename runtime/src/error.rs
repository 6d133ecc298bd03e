//! Errors of the model, of a simulation's settings and of a step. Those of the file are in [`crate::format`].

use alloc::string::String;

/// What is wrong with the contents of a model or of a load case.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A simplified model was asked for a method that needs what it left out.
    #[error("a model simplified to `{from}` cannot run as `{to}`: start from the model file again")]
    Method {
        /// Method of the model.
        from: &'static str,
        /// Method asked for.
        to: &'static str,
    },
    /// A clamped structure was asked for a method of free bodies.
    #[error("the structure is clamped, and `{to}` is a method for bodies that fly; take rom")]
    Clamped {
        /// Method asked for.
        to: &'static str,
    },
    /// An array has the wrong number of entries.
    #[error("{what} has {found} entries, expected {expected}")]
    Shape {
        /// Array.
        what: String,
        /// Entries found.
        found: usize,
        /// Entries expected.
        expected: usize,
    },
    /// A number is NaN or infinite.
    #[error("{what} holds {found} at entry {index}, expected a finite number")]
    NotFinite {
        /// Array or scalar.
        what: String,
        /// Entry, from 0.
        index: usize,
        /// Value found.
        found: f64,
    },
    /// A number is outside its range.
    #[error("{what} is {found} at entry {index}, expected {expected}")]
    Value {
        /// Array or scalar.
        what: String,
        /// Entry, from 0.
        index: usize,
        /// Value found.
        found: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// An index points outside of what it indexes.
    #[error("{what} is {found} at entry {index}, expected less than {limit}")]
    Index {
        /// Array.
        what: String,
        /// Entry, from 0.
        index: usize,
        /// Index found.
        found: usize,
        /// First index that is too large.
        limit: usize,
    },
    /// Entries are not in the order the format fixes.
    #[error("{what} is out of order at entry {index}: {expected}")]
    Order {
        /// Array.
        what: String,
        /// First entry out of order, from 0.
        index: usize,
        /// The order expected.
        expected: &'static str,
    },
    /// Two things have the same name, or one has none.
    #[error("{what} {index} is named \"{name}\", expected a name that is not empty and not used before")]
    Name {
        /// Kind of thing.
        what: &'static str,
        /// Which, from 0.
        index: usize,
        /// Name found.
        name: String,
    },
    /// An expression cannot be evaluated.
    #[error("expression \"{expression}\" of {what} cannot be evaluated: {problem}")]
    Expression {
        /// Load it belongs to.
        what: String,
        /// As written.
        expression: String,
        /// What is wrong with its program.
        problem: &'static str,
    },
    /// A distributed load on a member without stations to carry it.
    #[error(
        "{what} is on member \"{member}\", whose shapes are not in this model; build it with --all-nodes, or with this load in the structure file"
    )]
    NoStations {
        /// Load.
        what: String,
        /// Name of the member.
        member: String,
    },
    /// A matrix should be symmetric positive definite.
    #[error("{what} is not symmetric positive definite: {problem} at row {row}")]
    NotPositiveDefinite {
        /// Matrix.
        what: &'static str,
        /// In words.
        problem: &'static str,
        /// Row, from 0.
        row: usize,
    },
    /// Members with different section axes meet at a point, and which is meant is open.
    #[error("sections with different axes meet at point {point}, name one of: {members}")]
    Ambiguous {
        /// Point.
        point: String,
        /// What could be named.
        members: String,
    },
    /// Something is to be loaded twice by one set of loads.
    #[error("{what} {name} is given twice to a set of loads, expected each {what} once")]
    Twice {
        /// Kind of thing.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// Something the caller asked for by name or number (from 0) is not in the model.
    #[error("the model has no {what} {name}; it has: {available}")]
    Unknown {
        /// Kind of thing.
        what: &'static str,
        /// Asked for.
        name: String,
        /// What there is.
        available: String,
    },
}

/// Why a simulation cannot be set up.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// A setting is outside its range.
    #[error("{what} is {found}, expected {expected}")]
    Value {
        /// Setting.
        what: &'static str,
        /// Value found.
        found: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The explicit integrator would blow up.
    #[error(
        "time step {dt} s is too long for the explicit RK4: mode {mode} at {omega} rad/s needs dt <= {stable_dt} s; \
         take a shorter step, fewer modes, or an implicit integrator (newmark, gen-alpha)"
    )]
    Unstable {
        /// Time step asked for, s.
        dt: f64,
        /// Longest stable one, s.
        stable_dt: f64,
        /// Number of the mode in the structure's list of elastic modes, from 1.
        mode: u32,
        /// Its circular frequency, rad/s.
        omega: f64,
    },
    /// The integrator has no equations for the model.
    #[error("integrator {integrator}: {reason}")]
    Integrator {
        /// Its name.
        integrator: &'static str,
        /// Why, and what to do.
        reason: &'static str,
    },
    /// A state does not belong to this model or cannot be started from.
    #[error("state cannot be used: {what} is {found}, expected {expected}")]
    State {
        /// Which part.
        what: &'static str,
        /// Found.
        found: f64,
        /// Expected.
        expected: f64,
    },
}

/// Why a step was not made. The state is then the one before the step.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The implicit equations did not converge within the iteration cap.
    #[error(
        "step to t = {time} s did not converge: relative residual {residual:e} after {iterations} iterations; \
         take a shorter time step"
    )]
    NotConverged {
        /// Time the step was going to, s.
        time: f64,
        /// Iterations made.
        iterations: u32,
        /// Last correction relative to the velocities (in the norm of kinetic energy).
        residual: f64,
    },
    /// A state variable became NaN or infinite.
    #[error(
        "step to t = {time} s diverged: {} is no longer finite; check the loads, or take a shorter time step",
        DivergedAt(*.mode)
    )]
    Diverged {
        /// Time the step was going to, s.
        time: f64,
        /// Elastic mode (from 0), or none when it was the rigid motion.
        mode: Option<usize>,
    },
    /// The motion prescribed for frame A cannot be used.
    #[error("prescribed motion of frame A: {what} is {found}, expected {expected}")]
    Motion {
        /// Which part.
        what: &'static str,
        /// Found.
        found: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The model has no equations for a prescribed motion of frame A.
    #[error("the motion of frame A cannot be prescribed: {reason}")]
    NotInFrameA {
        /// Why, and what to do.
        reason: &'static str,
    },
    /// A batch was not given loads for each of its instances.
    #[error("loads for {found} instances, expected {expected}: one for each instance of the batch")]
    LoadCount {
        /// Loads given.
        found: usize,
        /// Instances of the batch.
        expected: usize,
    },
    /// The loads were prepared for a model with other points or modes.
    #[error("the loads were prepared for another model ({found_modes} modes, this one has {modes})")]
    ForeignLoads {
        /// Modes of the model the loads were prepared for.
        found_modes: usize,
        /// Modes of this model.
        modes: usize,
    },
    /// The state is one of a model with another number of modes.
    #[error("the state is that of another model ({found_modes} modes, this one has {modes})")]
    ForeignState {
        /// Modes of the state.
        found_modes: usize,
        /// Modes of this model.
        modes: usize,
    },
}

struct DivergedAt(Option<usize>);

impl core::fmt::Display for DivergedAt {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0 {
            Some(mode) => write!(f, "the amplitude of elastic mode {mode} (from 0)"),
            None => f.write_str("the rigid motion"),
        }
    }
}
