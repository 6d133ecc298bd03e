//! Expressions in the input: `"sigma * 70e9"`, `"5*t"`.
//!
//! The grammar is that of ordinary notation: `+ - * / ^ ( )`, numbers, names, functions. A scanner of our own checks it
//! and says where it is broken; the parsing proper is exmex's, run on operands that record the operations done to them.
//! The scanner hands exmex a form in which its conventions cannot matter: exmex would read `-x^2` as `(-x)^2`, loses
//! nested calls of two arguments, and takes names apart that begin with a function's.

mod scan;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::str::FromStr;

use exmex::{BinOp, Express, FlatEx, MakeOperators, MatchLiteral, Operator};
use rom_runtime::expression::{Binary, Unary};
use scan::Scanner;

/// Longest text of an expression, bytes.
pub(crate) const LONGEST: usize = 2000;

/// Functions of one argument.
pub(crate) const UNARY: [(&str, Unary); 17] = [
    ("sin", Unary::Sin),
    ("cos", Unary::Cos),
    ("tan", Unary::Tan),
    ("asin", Unary::Asin),
    ("acos", Unary::Acos),
    ("atan", Unary::Atan),
    ("sinh", Unary::Sinh),
    ("cosh", Unary::Cosh),
    ("tanh", Unary::Tanh),
    ("exp", Unary::Exp),
    ("ln", Unary::Ln),
    ("log10", Unary::Log10),
    ("sqrt", Unary::Sqrt),
    ("abs", Unary::Abs),
    ("sign", Unary::Sign),
    ("floor", Unary::Floor),
    ("ceil", Unary::Ceil),
];

/// Functions of two arguments.
pub(crate) const BINARY: [(&str, Binary); 3] =
    [("min", Binary::Min), ("max", Binary::Max), ("atan2", Binary::Atan2)];

/// Constants known by name.
pub(crate) const CONSTANTS: [(&str, f64); 2] =
    [("pi", std::f64::consts::PI), ("deg", std::f64::consts::PI / 180.0)];

/// What is wrong with an expression, and where in its text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ExpressionError {
    pub span: Range<usize>,
    pub message: String,
    pub help: Option<String>,
}

/// An error as a result, for returning it.
fn fail<T>(span: Range<usize>, message: impl Into<String>, help: &str) -> Result<T, ExpressionError> {
    let help = (!help.is_empty()).then(|| help.to_owned());
    Err(ExpressionError { span, message: message.into(), help })
}

/// A number or a name in an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Operand {
    Number(f64),
    Name(String),
}

/// Operands in the order of the text, with their places.
pub(crate) type Operands = Vec<(Operand, Range<usize>)>;

/// One operation, in postfix order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operation {
    /// Push an operand, by index.
    Operand(usize),
    Unary(Unary),
    Binary(Binary),
}

/// A parsed expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Expression {
    pub operands: Operands,
    /// Postfix.
    pub operations: Vec<Operation>,
}

impl Expression {
    /// Parses a text.
    pub(crate) fn parse(text: &str) -> Result<Self, ExpressionError> {
        if text.len() > LONGEST {
            let message =
                format!("this expression has {} characters, at most {LONGEST} are accepted", text.len());
            return fail(0..text.len(), message, "name parts of it as parameters");
        }
        let (rewritten, operands) = Scanner::new(text).scan()?;
        // The scanner only lets well-formed text through, so these errors would be ours; they are reported all the same.
        let internal = |e: exmex::ExError| ExpressionError {
            span: 0..text.len(),
            message: format!("this expression cannot be parsed: {}", e.msg()),
            help: None,
        };
        let parsed = FlatEx::<Tape, Operators, NoLiterals>::parse_wo_compile(&rewritten).map_err(internal)?;
        let variables: Vec<Tape> = parsed
            .var_names()
            .iter()
            .map(|name| Tape(vec![Operation::Operand(name.parse().unwrap_or(0))]))
            .collect();
        let Tape(operations) = parsed.eval(&variables).map_err(internal)?;
        Ok(Self { operands, operations })
    }

    /// Names it uses, with their places.
    pub(crate) fn names(&self) -> impl Iterator<Item = (&str, Range<usize>)> {
        self.operands.iter().filter_map(|(operand, span)| match operand {
            Operand::Name(name) => Some((name.as_str(), span.clone())),
            Operand::Number(_) => None,
        })
    }

    /// Its value, with `lookup` giving values to names. May be non-finite. The functions are the runtime's, which are the
    /// same on every machine.
    pub(crate) fn value(&self, lookup: impl Fn(&str) -> f64) -> f64 {
        let mut stack: Vec<f64> = Vec::new();
        for operation in &self.operations {
            let value = match *operation {
                Operation::Operand(index) => match &self.operands[index].0 {
                    Operand::Number(value) => *value,
                    Operand::Name(name) => lookup(name),
                },
                Operation::Unary(function) => match stack.pop() {
                    Some(a) => function.apply(a),
                    None => f64::NAN,
                },
                Operation::Binary(function) => match (stack.pop(), stack.pop()) {
                    (Some(b), Some(a)) => function.apply(a, b),
                    _ => f64::NAN,
                },
            };
            stack.push(value);
        }
        stack.pop().unwrap_or(f64::NAN)
    }
}

/// The operand type given to exmex: remembers the operations that led to it.
#[derive(Clone, Debug, Default)]
struct Tape(Vec<Operation>);

impl Tape {
    fn unary(mut self, function: Unary) -> Self {
        self.0.push(Operation::Unary(function));
        self
    }

    fn binary(mut self, mut other: Self, function: Binary) -> Self {
        self.0.append(&mut other.0);
        self.0.push(Operation::Binary(function));
        self
    }
}

/// Numbers are operands by index; exmex never sees a literal.
impl FromStr for Tape {
    type Err = &'static str;

    fn from_str(_: &str) -> Result<Self, Self::Err> {
        Err("no literals")
    }
}

#[derive(Clone, Debug)]
struct NoLiterals;

impl MatchLiteral for NoLiterals {
    fn is_literal(_: &str) -> Option<&str> {
        None
    }
}

#[derive(Clone, Debug)]
struct Operators;

impl MakeOperators<Tape> for Operators {
    fn make<'a>() -> Vec<Operator<'a, Tape>> {
        macro_rules! infix {
            ($sign:literal, $prio:literal, $function:ident) => {
                Operator::make_bin(
                    $sign,
                    BinOp {
                        apply: |a, b| Tape::binary(a, b, Binary::$function),
                        prio: $prio,
                        is_commutative: false,
                    },
                )
            };
        }
        macro_rules! functions {
            ($($name:literal $function:ident),*) => {
                [$(Operator::make_unary($name, |a| Tape::unary(a, Unary::$function))),*]
            };
        }
        let mut all = vec![
            infix!("+", 0, Add),
            infix!("-", 0, Sub),
            infix!("*", 1, Mul),
            infix!("/", 1, Div),
            infix!("^", 2, Pow),
            infix!("min", 0, Min),
            infix!("max", 0, Max),
            infix!("atan2", 0, Atan2),
        ];
        all.extend(functions!(
            "sin" Sin, "cos" Cos, "tan" Tan, "asin" Asin, "acos" Acos, "atan" Atan, "sinh" Sinh,
            "cosh" Cosh, "tanh" Tanh, "exp" Exp, "ln" Ln, "log10" Log10, "sqrt" Sqrt, "abs" Abs, "sign" Sign,
            "floor" Floor, "ceil" Ceil
        ));
        all
    }
}
