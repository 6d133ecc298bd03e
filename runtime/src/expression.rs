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
    pub(crate) fn get(&self, variable: Variable) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use Instruction::{Binary as B, Constant as C, Unary as U, Variable as V};

    fn program(code: &[Instruction]) -> Program {
        Program { source: "test".into(), code: code.into() }
    }

    fn value(code: &[Instruction], variables: &Variables) -> f64 {
        let program = program(code);
        program.check().unwrap();
        program.value(variables)
    }

    #[test]
    fn every_variable_and_operation_means_what_it_says() {
        let variables =
            Variables { t: 0.5, v_a: [1.0, 2.0, 3.0], w_a: [4.0, 5.0, 6.0], r_g: [7.0, 8.0, 9.0] };
        let names = [
            Variable::T,
            Variable::Vx,
            Variable::Vy,
            Variable::Vz,
            Variable::Wx,
            Variable::Wy,
            Variable::Wz,
            Variable::X,
            Variable::Y,
            Variable::Z,
        ];
        let expected = [0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        for (name, expected) in names.into_iter().zip(expected) {
            assert_eq!(value(&[V(name)], &variables), expected, "{name:?}");
        }
        let unary: [(Unary, f64, f64); 21] = [
            (Unary::Neg, 0.3, -0.3),
            (Unary::Sin, 0.3, 0.3_f64.sin()),
            (Unary::Cos, 0.3, 0.3_f64.cos()),
            (Unary::Tan, 0.3, 0.3_f64.tan()),
            (Unary::Asin, 0.3, 0.3_f64.asin()),
            (Unary::Acos, 0.3, 0.3_f64.acos()),
            (Unary::Atan, 0.3, 0.3_f64.atan()),
            (Unary::Sinh, 0.3, 0.3_f64.sinh()),
            (Unary::Cosh, 0.3, 0.3_f64.cosh()),
            (Unary::Tanh, 0.3, 0.3_f64.tanh()),
            (Unary::Exp, 0.3, 0.3_f64.exp()),
            (Unary::Ln, 0.3, 0.3_f64.ln()),
            (Unary::Log10, 0.3, 0.3_f64.log10()),
            (Unary::Sqrt, 0.3, 0.3_f64.sqrt()),
            (Unary::Abs, -0.3, 0.3),
            (Unary::Sign, -0.3, -1.0),
            (Unary::Sign, 0.3, 1.0),
            (Unary::Sign, 0.0, 0.0),
            (Unary::Sign, -0.0, 0.0),
            (Unary::Floor, -0.3, -1.0),
            (Unary::Ceil, 0.3, 1.0),
        ];
        for (function, x, expected) in unary {
            assert!((value(&[C(x), U(function)], &variables) - expected).abs() < 1e-15, "{function:?}");
        }
        let binary: [(Binary, f64); 8] = [
            (Binary::Add, 5.0),
            (Binary::Sub, -1.0),
            (Binary::Mul, 6.0),
            (Binary::Div, 2.0 / 3.0),
            (Binary::Pow, 8.0),
            (Binary::Min, 2.0),
            (Binary::Max, 3.0),
            (Binary::Atan2, 2.0_f64.atan2(3.0)),
        ];
        for (function, expected) in binary {
            assert!(
                (value(&[C(2.0), C(3.0), B(function)], &variables) - expected).abs() < 1e-15,
                "{function:?}"
            );
        }
        // 1 - 2 vx^2
        let code = [C(1.0), C(2.0), V(Variable::Vx), C(2.0), B(Binary::Pow), B(Binary::Mul), B(Binary::Sub)];
        assert_eq!(value(&code, &variables), -1.0);
    }

    #[test]
    fn programs_that_cannot_run_are_refused_and_never_panic() {
        let deep = alloc::vec![C(1.0); MAX_DEPTH + 1];
        let cases: [(&[Instruction], &str); 6] = [
            (&[], "empty"),
            (&[B(Binary::Add)], "underflow"),
            (&[C(1.0), B(Binary::Add)], "underflow"),
            (&[C(1.0), C(2.0)], "more than one"),
            (&[C(f64::NAN)], "not finite"),
            (&deep, "nested too deeply"),
        ];
        for (code, word) in cases {
            let problem = program(code).check().unwrap_err();
            assert!(problem.contains(word), "{problem}");
            let _ = program(code).value(&Variables::default());
        }
        let mut deepest = alloc::vec![C(1.0); MAX_DEPTH];
        deepest.extend(core::iter::repeat_n(B(Binary::Add), MAX_DEPTH - 1));
        assert_eq!(value(&deepest, &Variables::default()), MAX_DEPTH as f64);
    }
}
