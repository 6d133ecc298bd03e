//! Expressions of time and rigid velocities as a small stack program: evaluated without allocation.
use alloc::{string::String, vec::Vec};
use serde::{Deserialize, Serialize};

/// A compiled expression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// The expression as written.
    #[serde(deserialize_with = "crate::format::text::string")]
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

/// What an expression can see.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Variables {
    /// Time, s.
    pub t: f64,
    /// Velocity of the origin of A in A, m/s - (3).
    pub v_a: [f64; 3],
    /// Angular velocity of A in A, rad/s - (3).
    pub w_a: [f64; 3],
    /// Position of the origin of A in G, m - (3).
    pub r_g: [f64; 3],
}

/// Most values an expression may hold at once.
pub const MAX_DEPTH: usize = 32;

impl Program {
    /// Checks that the program leaves exactly one value and never holds more than [`MAX_DEPTH`].
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self) -> Result<(), &'static str> {
        let mut depth = 0_usize;
        for instruction in &self.code {
            let (takes, gives) = match instruction {
                Instruction::Constant(value) if !value.is_finite() => {
                    return Err("a constant is not finite");
                }
                Instruction::Constant(_) | Instruction::Variable(_) => (0, 1),
                Instruction::Unary(_) => (1, 1),
                Instruction::Binary(_) => (2, 1),
            };
            depth =
                depth.checked_sub(takes).ok_or("an operation lacks an operand (stack underflow)")? + gives;
            if depth > MAX_DEPTH {
                return Err("it is nested too deeply (more than 32 values at once)");
            }
        }
        match depth {
            0 => Err("it is empty"),
            1 => Ok(()),
            _ => Err("it leaves more than one value"),
        }
    }

    /// Value of a program that passed [`Program::check`]; NaN for one that would not. Does not allocate.
    pub fn value(&self, variables: &Variables) -> f64 {
        self.run(variables).unwrap_or(f64::NAN)
    }

    fn run(&self, variables: &Variables) -> Option<f64> {
        let mut stack = [0.0; MAX_DEPTH];
        let mut depth = 0_usize;
        for instruction in &self.code {
            let value = match *instruction {
                Instruction::Constant(value) => value,
                Instruction::Variable(variable) => variables.get(variable),
                Instruction::Unary(function) => {
                    depth = depth.checked_sub(1)?;
                    function.apply(*stack.get(depth)?)
                }
                Instruction::Binary(function) => {
                    depth = depth.checked_sub(2)?;
                    function.apply(*stack.get(depth)?, *stack.get(depth + 1)?)
                }
            };
            *stack.get_mut(depth)? = value;
            depth += 1;
        }
        stack.first().copied()
    }
}

impl Variables {
    fn get(&self, variable: Variable) -> f64 {
        match variable {
            Variable::T => self.t,
            Variable::Vx => self.v_a[0],
            Variable::Vy => self.v_a[1],
            Variable::Vz => self.v_a[2],
            Variable::Wx => self.w_a[0],
            Variable::Wy => self.w_a[1],
            Variable::Wz => self.w_a[2],
            Variable::X => self.r_g[0],
            Variable::Y => self.r_g[1],
            Variable::Z => self.r_g[2],
        }
    }
}

impl Unary {
    /// Value of the function.
    pub fn apply(self, x: f64) -> f64 {
        match self {
            Self::Neg => -x,
            Self::Sin => libm::sin(x),
            Self::Cos => libm::cos(x),
            Self::Tan => libm::tan(x),
            Self::Asin => libm::asin(x),
            Self::Acos => libm::acos(x),
            Self::Atan => libm::atan(x),
            Self::Sinh => libm::sinh(x),
            Self::Cosh => libm::cosh(x),
            Self::Tanh => libm::tanh(x),
            Self::Exp => libm::exp(x),
            Self::Ln => libm::log(x),
            Self::Log10 => libm::log10(x),
            Self::Sqrt => libm::sqrt(x),
            Self::Abs => x.abs(),
            // Zero at zero, so that sign(v) v^2 is drag at rest too.
            Self::Sign => {
                if x == 0.0 {
                    0.0
                } else {
                    x.signum()
                }
            }
            Self::Floor => libm::floor(x),
            Self::Ceil => libm::ceil(x),
        }
    }
}

impl Binary {
    /// Value of the function.
    pub fn apply(self, x: f64, y: f64) -> f64 {
        match self {
            Self::Add => x + y,
            Self::Sub => x - y,
            Self::Mul => x * y,
            Self::Div => x / y,
            Self::Pow => libm::pow(x, y),
            Self::Min => x.min(y),
            Self::Max => x.max(y),
            Self::Atan2 => libm::atan2(x, y),
        }
    }
}
