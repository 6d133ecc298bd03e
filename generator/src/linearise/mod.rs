//! Linear state-space models of a reduced model about a steady state: a trim, or a steady rotation.
//!
//! ```text
//! x_dot = A x + B u,   y = C x + D u        x, u, y: small changes from the steady state
//! ```
//!
//! All of them are components in frame A, so that the matrices are constant though the body turns. They come from
//! [`rom_runtime::Jacobian`], which is exact.

mod inputs;
mod outputs;
mod poles;
mod steady;
mod symmetry;

use std::sync::Arc;

use nalgebra::{DMatrix, Matrix3, Vector3};
use rom_runtime::loads::LoadCase;
use rom_runtime::{Direction, Jacobian, Model, ModelError, StepError};

use crate::solve::dense::DenseError;

pub use poles::Pole;
pub use steady::Steady;

/// What to linearise about, and what acts and is looked at.
#[derive(Clone, Debug)]
pub struct Request {
    /// Its loads act, at `time`; the state begins as its `initial` says.
    pub case: LoadCase,
    /// Time at which loads are taken, s.
    pub time: f64,
    /// Velocity of the origin of A in A, m/s, instead of the case's.
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity of A in A, rad/s, instead of the case's.
    pub rate: Option<[f64; 3]>,
    /// Loads of the equilibrium whose factors may change for the balance.
    pub balance: Vec<String>,
    /// Whether a wrench on A, constant in A, balances what is left.
    pub hold: bool,
    /// Names of inputs; the usual ones where none are given.
    pub inputs: Option<Vec<String>>,
    /// Names of outputs; the usual ones where none are given.
    pub outputs: Option<Vec<String>>,
    /// Whether to leave out states that nothing depends on: position, heading.
    pub reduce: bool,
}

impl Request {
    /// About the state of a load case, with the usual inputs and outputs.
    pub fn new(case: LoadCase) -> Self {
        Request {
            case,
            time: 0.0,
            velocity: None,
            rate: None,
            balance: Vec::new(),
            hold: false,
            inputs: None,
            outputs: None,
            reduce: false,
        }
    }

    /// About the model's own equilibrium.
    pub fn of_equilibrium() -> Self {
        Request::new(LoadCase::empty("equilibrium"))
    }
}

/// A state, an input or an output.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name: that of the results where there is one, with the component after a dot.
    pub name: String,
    /// Unit.
    pub unit: &'static str,
    /// What it is.
    pub description: String,
}

impl Channel {
    fn new(name: impl Into<String>, unit: &'static str, description: impl Into<String>) -> Self {
        Channel { name: name.into(), unit, description: description.into() }
    }

    /// Three components.
    fn xyz(name: &str, unit: &'static str, description: &str) -> [Self; 3] {
        ["x", "y", "z"].map(|axis| Channel::new(format!("{name}.{axis}"), unit, description))
    }
}

/// A linear model.
#[derive(Clone, Debug)]
pub struct StateSpace {
    /// (states x states).
    pub a: DMatrix<f64>,
    /// (states x inputs).
    pub b: DMatrix<f64>,
    /// (outputs x states).
    pub c: DMatrix<f64>,
    /// (outputs x inputs).
    pub d: DMatrix<f64>,
    /// What `x` is.
    pub states: Vec<Channel>,
    /// What `u` is.
    pub inputs: Vec<Channel>,
    /// What `y` is.
    pub outputs: Vec<Channel>,
    /// Outputs left out because they depend on states left out.
    pub dropped: Vec<String>,
    /// Number of states that nothing depends on, left out or not.
    pub ignorable: usize,
    /// Eigenvalues of the full `A` in ascending order of frequency.
    pub poles: Vec<Pole>,
    /// Where it holds.
    pub steady: Steady,
}

/// Why there is no linear model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LineariseError {
    /// A name that the model does not have.
    #[error("the model has no {what} {name:?}; it has: {available}")]
    Unknown {
        /// Kind of thing.
        what: &'static str,
        /// Asked for.
        name: String,
        /// What there is.
        available: String,
    },
    /// A number that makes no sense.
    #[error("{what} is {found}, expected {expected}")]
    Value {
        /// Quantity.
        what: &'static str,
        /// Found.
        found: f64,
        /// Expected.
        expected: &'static str,
    },
    /// The accelerations do not vanish.
    #[error(
        "no steady state: {left}, {relative:.1e} of what the loads, the weight and the turn of the body amount to (1e-6 is accepted)"
    )]
    NotSteady {
        /// The accelerations that are left, in words.
        left: String,
        /// Their size relative to those of the loads.
        relative: f64,
    },
    /// The forces change as the body moves on.
    #[error(
        "no steady state: as the body moves on with its velocity, loads constant in G, the weight or loads that depend on the position change \
         the accelerations by {found:.3e} m/s^2 a second"
    )]
    Passing {
        /// Change of the accelerations, m/s^3.
        found: f64,
    },
    /// What moves A accelerates it.
    #[error(
        "no steady state: the load case accelerates frame A by {found} m/s^2 (origin) and {turning} rad/s^2 at t = {time} s"
    )]
    Accelerated {
        /// Of the origin, m/s^2.
        found: f64,
        /// Of the rotation, rad/s^2.
        turning: f64,
        /// Time, s.
        time: f64,
    },
    /// From the runtime.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// From the runtime.
    #[error(transparent)]
    Step(#[from] StepError),
    /// No eigenvalues.
    #[error(transparent)]
    Dense(#[from] DenseError),
}

/// Linearises a model.
///
/// # Errors
/// Unknown names, numbers that are not finite, no steady state near the one asked for.
pub fn linearise(model: &Arc<Model>, request: &Request) -> Result<StateSpace, LineariseError> {
    let inputs = inputs::select(model, request)?;
    let outputs = outputs::select(model, request)?;
    let (steady, mut at, weights) = steady::find(model, request)?;
    let full = matrices(model, &mut at, &steady, &inputs, &outputs)?;
    symmetry::split(full, &weights, steady, request.reduce)
}

/// A direction of the state space: in the coordinates of the runtime.
#[derive(Clone, Debug)]
pub(crate) struct Column {
    /// - (2 m + 12).
    state: Vec<f64>,
    /// Rates along it - (2 m + 12).
    rates: Vec<f64>,
    /// Of [`rom_runtime::Reaction::total`].
    reaction: [f64; 6],
    /// What loads along it add to the section forces at every place; none along a state.
    sections: Vec<[f64; 6]>,
}

impl Column {
    fn add(&mut self, factor: f64, other: &Column) {
        let sum = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(a, b)| *a += factor * b);
        sum(&mut self.state, &other.state);
        sum(&mut self.rates, &other.rates);
        sum(&mut self.reaction, &other.reaction);
        for (to, from) in self.sections.iter_mut().zip(&other.sections) {
            sum(to, from);
        }
    }

    /// The same for outputs of a model of `m` modes.
    fn direction(&self, m: usize) -> Direction<'_> {
        Direction { state: &self.state, u_dot: &self.rates[m..2 * m + 6] }
    }
}

/// The matrices with all states: `q, q_dot, v, w, theta, r`, or the modal ones alone where A is moved.
struct Full {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    states: Vec<Channel>,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
}

fn matrices(
    model: &Model,
    at: &mut steady::At,
    steady: &Steady,
    inputs: &[inputs::Input],
    outputs: &[outputs::Output],
) -> Result<Full, LineariseError> {
    let frame = Frame::new(steady);
    let columns = frame.columns(model, &at.jacobian, steady.driven);
    let states = states(model, steady.driven);
    let n = states.len();
    let mut by_input = Vec::new();
    for input in inputs {
        by_input.extend(input.columns(model, &mut at.jacobian)?);
    }
    let rows = |columns: &[Column]| {
        let rates: Vec<Vec<f64>> = columns.iter().map(|c| frame.rates(model, c, steady.driven)).collect();
        DMatrix::from_fn(n, columns.len(), |i, j| rates[j][i])
    };
    let (a, b) = (rows(&columns), rows(&by_input));
    let cut = outputs.iter().any(|output| matches!(output, outputs::Output::Section(_)));
    let mut look = |columns: &[Column]| -> Result<DMatrix<f64>, LineariseError> {
        let mut seen: Vec<Vec<f64>> = Vec::with_capacity(columns.len());
        for column in columns {
            let sections = if cut { outputs::sections(model, at, column)? } else { Vec::new() };
            let along = |o: &outputs::Output| o.along(model, &mut at.jacobian, &frame, column, &sections);
            seen.push(outputs.iter().flat_map(along).collect());
        }
        let rows = outputs.iter().map(|output| output.channels(model).len()).sum();
        Ok(DMatrix::from_fn(rows, columns.len(), |i, j| seen[j][i]))
    };
    let (c, d) = (look(&columns)?, look(&by_input)?);
    let channels = |of: Vec<Vec<Channel>>| of.into_iter().flatten().collect();
    Ok(Full {
        a,
        b,
        c,
        d,
        states,
        inputs: channels(inputs.iter().map(|input| input.channels(model)).collect()),
        outputs: channels(outputs.iter().map(|output| output.channels(model)).collect()),
    })
}

fn states(model: &Model, driven: bool) -> Vec<Channel> {
    let numbers = &model.data().modes.number;
    let modal = |name: &str, unit, what: &str| {
        let of = |n: &u32| Channel::new(format!("{name}.{n}"), unit, format!("{what} of elastic mode {n}"));
        numbers.iter().map(of).collect::<Vec<Channel>>()
    };
    let mut out = modal("q", "1", "amplitude");
    out.extend(modal("q_dot", "1/s", "rate of the amplitude"));
    if !driven {
        out.extend(Channel::xyz("v", "m/s", "velocity of the origin of the axes, components in them"));
        out.extend(Channel::xyz("w", "rad/s", "angular velocity of the axes, components in them"));
        out.extend(Channel::xyz("theta", "rad", "small turn of the axes about themselves"));
        out.extend(Channel::xyz("r", "m", "displacement of the origin of the axes, components in them"));
    }
    out
}

/// Frame A at the steady state.
pub(crate) struct Frame {
    /// `C^{GA}`.
    c: Matrix3<f64>,
    w: Vector3<f64>,
}

impl Frame {
    fn new(steady: &Steady) -> Self {
        let [s, x, y, z] = steady.attitude;
        let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(s, x, y, z));
        let w = Vector3::from_row_slice(&steady.velocity[3..]);
        Frame { c: turn.to_rotation_matrix().into_inner(), w }
    }

    /// Directions of the states in the order of [`states`]: the true velocity of A instead of `beta*`, displacements in A.
    fn columns(&self, model: &Model, jacobian: &Jacobian, driven: bool) -> Vec<Column> {
        let (n, m) = (jacobian.size(), model.n_modes());
        let of = |k: usize| {
            let mut state = vec![0.0; n];
            state[k] = 1.0;
            Column {
                state,
                rates: jacobian.column(k).collect(),
                reaction: std::array::from_fn(|row| jacobian.reaction()[row * n + k]),
                sections: Vec::new(),
            }
        };
        let phi = &model.data().modes.phi_r;
        let mut columns: Vec<Column> = (0..2 * m).map(of).collect();
        let rigid: Vec<Column> = (2 * m..n).map(of).collect();
        for (j, column) in columns[m..].iter_mut().enumerate() {
            // A rate at constant velocity of A.
            (0..6).for_each(|k| column.add(-phi[k * m + j], &rigid[k]));
        }
        if driven {
            return columns;
        }
        columns.extend_from_slice(&rigid[..9]);
        for axis in 0..3 {
            let (state, rates) = (vec![0.0; n], vec![0.0; n]);
            let mut column = Column { state, rates, reaction: [0.0; 6], sections: Vec::new() };
            (0..3).for_each(|k| column.add(self.c[(k, axis)], &rigid[9 + k]));
            columns.push(column);
        }
        columns
    }

    /// Rates of the states along a column.
    fn rates(&self, model: &Model, column: &Column, driven: bool) -> Vec<f64> {
        let m = model.n_modes();
        let rates = &column.rates;
        let mut out = rates[..2 * m].to_vec();
        if driven {
            return out;
        }
        let phi = &model.data().modes.phi_r;
        let moved = |k: usize| (0..m).map(|j| phi[k * m + j] * rates[m + j]).sum::<f64>();
        out.extend((0..6).map(|k| rates[2 * m + k] + moved(k)));
        out.extend_from_slice(&rates[2 * m + 6..2 * m + 9]);
        let three = |x: &[f64]| Vector3::from_row_slice(&x[2 * m + 9..2 * m + 12]);
        // In axes that turn on.
        let displacement = self.c.tr_mul(&three(&column.state));
        let rate = self.c.tr_mul(&three(rates)) - self.w.cross(&displacement);
        out.extend(rate.iter());
        out
    }
}
