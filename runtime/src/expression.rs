//! Expressions of time and rigid velocities as a small stack program: evaluated without allocation.
use alloc::{string::String, vec::Vec};
use serde::{Deserialize, Serialize};

/// A compiled expression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// The expression as written.
    pub source: String,
    /// Instructions in postfix order.
    pub code: Vec<Instruction>,
}

/// One instruction of the stack machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Instruction {
    /// Push a constant.
    Constant(f64),
    /// Push a variable.
    Variable(Variable),
    /// Replace the top by a function of it.
    Unary(Unary),
    /// Replace the two topmost by a function of them.
    Binary(Binary),
}

/// Variables an expression may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Variable {
    /// Time, s.
    T,
    /// Velocity of the origin of A in A, m/s.
    Vx,
    Vy,
    Vz,
    /// Angular velocity of A in A, rad/s.
    Wx,
    Wy,
    Wz,
    /// Position of the origin of A in G, m.
    X,
    Y,
    Z,
}

/// Functions of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Unary {
    Neg,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Log10,
    Sqrt,
    Abs,
    Sign,
    Floor,
    Ceil,
}

/// Functions of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Pow,
    Min,
    Max,
    Atan2,
}
