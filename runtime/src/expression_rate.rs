//! Slopes of expressions: forward differentiation of the same programs.

use crate::expression::{Binary, Instruction, MAX_DEPTH, Program, Unary, Variable};
use crate::forward::{Forward, ForwardVariables};
use crate::real::Real;

/// Rate of a program at time `t`, 1/s, all other variables being zero; NaN for a program that cannot run.
pub(crate) fn rate(program: &Program, t: f64) -> f64 {
    let of = |variable| match variable {
        Variable::T => {
            let mut t = Forward::of(t);
            t.seed(0, 1.0);
            t
        }
        _ => Forward::of(0.0),
    };
    run(program, of).map_or(f64::NAN, |x| x.slope(0))
}

/// Value and slopes of a program; NaN for a program that cannot run.
pub(crate) fn along(program: &Program, variables: &ForwardVariables) -> Forward {
    run(program, |variable| variables.get(variable)).unwrap_or(Forward::of(f64::NAN))
}

impl ForwardVariables {
    fn get(&self, variable: Variable) -> Forward {
        match variable {
            Variable::T => Forward::of(self.t),
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

fn run(program: &Program, variable: impl Fn(Variable) -> Forward) -> Option<Forward> {
    let mut stack = [Forward::of(0.0); MAX_DEPTH];
    let mut depth = 0_usize;
    for instruction in &program.code {
        let value = match *instruction {
            Instruction::Constant(value) => Forward::of(value),
            Instruction::Variable(name) => variable(name),
            Instruction::Unary(function) => {
                depth = depth.checked_sub(1)?;
                let x = stack.get(depth)?;
                x.mapped(function.apply(x.value), slope(function, x.value))
            }
            Instruction::Binary(function) => {
                depth = depth.checked_sub(2)?;
                let (x, y) = (stack.get(depth)?, stack.get(depth + 1)?);
                let value = function.apply(x.value, y.value);
                let (by_x, by_y) = slopes(function, x.value, y.value, value);
                x.mapped(value, by_x) + y.mapped(0.0, by_y)
            }
        };
        *stack.get_mut(depth)? = value;
        depth += 1;
    }
    stack.first().copied()
}

fn slope(function: Unary, x: f64) -> f64 {
    match function {
        Unary::Neg => -1.0,
        Unary::Sin => libm::cos(x),
        Unary::Cos => -libm::sin(x),
        Unary::Tan => {
            let t = libm::tan(x);
            1.0 + t * t
        }
        Unary::Asin => 1.0 / libm::sqrt(1.0 - x * x),
        Unary::Acos => -1.0 / libm::sqrt(1.0 - x * x),
        Unary::Atan => 1.0 / (1.0 + x * x),
        Unary::Sinh => libm::cosh(x),
        Unary::Cosh => libm::sinh(x),
        Unary::Tanh => {
            let t = libm::tanh(x);
            1.0 - t * t
        }
        Unary::Exp => libm::exp(x),
        Unary::Ln => 1.0 / x,
        Unary::Log10 => core::f64::consts::LOG10_E / x,
        Unary::Sqrt => 0.5 / libm::sqrt(x),
        // At zero the mean of both sides, so that v |v| has its slope zero there.
        Unary::Abs => Unary::Sign.apply(x),
        Unary::Sign | Unary::Floor | Unary::Ceil => 0.0,
    }
}

fn slopes(function: Binary, x: f64, y: f64, value: f64) -> (f64, f64) {
    match function {
        Binary::Add => (1.0, 1.0),
        Binary::Sub => (1.0, -1.0),
        Binary::Mul => (y, x),
        Binary::Div => (1.0 / y, -value / y),
        Binary::Pow => {
            let by_x = if y == 0.0 { 0.0 } else { y * libm::pow(x, y - 1.0) };
            // 0^y is zero for all positive y.
            (by_x, if value == 0.0 { 0.0 } else { value * libm::log(x) })
        }
        Binary::Min => (f64::from(u8::from(x <= y)), f64::from(u8::from(x > y))),
        Binary::Max => (f64::from(u8::from(x >= y)), f64::from(u8::from(x < y))),
        Binary::Atan2 => {
            let square = x * x + y * y;
            (y / square, -x / square)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::Variables;
    use crate::time::TimeFunction;
    use num_dual::{Dual64, DualNum};

    fn unary(function: Unary, x: Dual64) -> Dual64 {
        match function {
            Unary::Neg => -x,
            Unary::Sin => x.sin(),
            Unary::Cos => x.cos(),
            Unary::Tan => x.tan(),
            Unary::Asin => x.asin(),
            Unary::Acos => x.acos(),
            Unary::Atan => x.atan(),
            Unary::Sinh => x.sinh(),
            Unary::Cosh => x.cosh(),
            Unary::Tanh => x.tanh(),
            Unary::Exp => x.exp(),
            Unary::Ln => x.ln(),
            Unary::Log10 => x.log10(),
            Unary::Sqrt => x.sqrt(),
            Unary::Abs => {
                if x.re < 0.0 {
                    -x
                } else {
                    x
                }
            }
            Unary::Sign | Unary::Floor | Unary::Ceil => Dual64::from_re(function.apply(x.re)),
        }
    }

    /// Every function of one argument at a point of its domain against dual numbers.
    #[test]
    fn slopes_of_functions_are_those_of_dual_numbers() {
        use Unary::*;
        let all = [
            Neg, Sin, Cos, Tan, Asin, Acos, Atan, Sinh, Cosh, Tanh, Exp, Ln, Log10, Sqrt, Abs, Sign, Floor,
            Ceil,
        ];
        for function in all {
            for x in [0.3, 0.77] {
                let expected = unary(function, Dual64::new(x, 1.0));
                assert!(
                    (slope(function, x) - expected.eps).abs() < 1e-14 * expected.eps.abs().max(1.0),
                    "{function:?}"
                );
            }
        }
        assert_eq!((slope(Abs, -2.0), slope(Abs, 0.0)), (-1.0, 0.0));
        for (x, y) in [(0.3, 1.7), (2.0, -0.6)] {
            let (dx, dy) = (Dual64::new(x, 1.0), Dual64::new(y, 1.0));
            let (cx, cy) = (Dual64::from_re(x), Dual64::from_re(y));
            let pairs = [
                (Binary::Add, (dx + cy).eps, (cx + dy).eps),
                (Binary::Sub, (dx - cy).eps, (cx - dy).eps),
                (Binary::Mul, (dx * cy).eps, (cx * dy).eps),
                (Binary::Div, (dx / cy).eps, (cx / dy).eps),
                (Binary::Pow, dx.powd(cy).eps, cx.powd(dy).eps),
                (Binary::Atan2, dx.atan2(cy).eps, cx.atan2(dy).eps),
            ];
            for (function, by_x, by_y) in pairs {
                let found = slopes(function, x, y, function.apply(x, y));
                assert!((found.0 - by_x).abs() < 1e-14 * by_x.abs().max(1.0), "{function:?}");
                assert!((found.1 - by_y).abs() < 1e-14 * by_y.abs().max(1.0), "{function:?}");
            }
        }
    }

    /// `-3 t |t| + sin(2 t) t / (1 + t^2)`, by hand.
    #[test]
    fn the_rate_of_a_program() {
        use Instruction::{Binary as B, Constant as C, Unary as U, Variable as V};
        let t = V(Variable::T);
        let code = [
            C(-3.0),
            t,
            B(Binary::Mul),
            t,
            U(Unary::Abs),
            B(Binary::Mul),
            t,
            C(2.0),
            B(Binary::Mul),
            U(Unary::Sin),
            t,
            B(Binary::Mul),
            C(1.0),
            t,
            C(2.0),
            B(Binary::Pow),
            B(Binary::Add),
            B(Binary::Div),
            B(Binary::Add),
        ];
        let program = Program { source: "test".into(), code: code.into() };
        program.check().unwrap();
        for t in [-0.7_f64, 0.4, 2.0] {
            let d = 1.0 + t * t;
            let expected = -6.0 * t.abs() + (2.0 * (2.0 * t).cos() * t + (2.0 * t).sin()) / d
                - (2.0 * t).sin() * t * 2.0 * t / (d * d);
            assert!((rate(&program, t) - expected).abs() < 1e-14, "{} {expected}", rate(&program, t));
        }
        // A root at zero of a constant has no rate.
        let root = Program {
            source: "test".into(),
            code: [C(0.0), U(Unary::Sqrt), t_times(), B(Binary::Add)].into(),
        };
        assert_eq!(rate(&root, 1.0), 1.0);
    }

    fn t_times() -> Instruction {
        Instruction::Variable(Variable::T)
    }

    /// The rate of every shape between its kinks is the slope of its values.
    #[test]
    fn rates_of_shapes_are_slopes() {
        use TimeFunction as F;
        let functions = [
            F::Constant { value: 3.0 },
            F::Step { value: 2.0, start: 0.5, end: 2.5 },
            F::Ramp { rate: 3.0, start: 1.0, end: 2.0 },
            F::Triangle { peak: 2.0, start: 0.2, at: 1.1, end: 2.9 },
            F::Sine { amplitude: 2.0, omega: 5.0, phase: 0.3, start: 0.4, end: 2.2 },
            F::OneMinusCosine { amplitude: 2.0, start: 0.3, duration: 2.0 },
            F::Table { t: vec![0.0, 1.0, 2.0], value: vec![1.0, 4.0, -2.0] },
        ];
        for function in functions {
            for t in [0.1, 0.7, 1.3, 2.05, 2.4, 3.1] {
                let at = |t: f64| function.value(&Variables { t, ..Variables::default() });
                let h = 1e-6;
                let slope = (at(t + h) - at(t - h)) / (2.0 * h);
                assert!((function.rate(t) - slope).abs() < 1e-8, "{function:?} at {t}");
            }
        }
    }
}
