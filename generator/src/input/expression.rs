//! Expressions in the input: `"sigma * 70e9"`, `"5*t"`.
//!
//! The grammar is that of ordinary notation: `+ - * / ^ ( )`, numbers, names, functions. A scanner of our own checks it
//! and says where it is broken; the parsing proper is exmex's, run on operands that record the operations done to them.
//! The scanner hands exmex a form in which its conventions cannot matter: exmex would read `-x^2` as `(-x)^2`, loses
//! nested calls of two arguments, and takes names apart that begin with a function's.

use std::fmt::Write as _;
use std::ops::Range;
use std::str::FromStr;

use exmex::{BinOp, Express, FlatEx, MakeOperators, MatchLiteral, Operator};
use rom_runtime::expression::{Binary, Unary};

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
    pub operands: Vec<(Operand, Range<usize>)>,
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

    /// Its value, with `lookup` giving values to names. May be non-finite.
    pub(crate) fn value(&self, lookup: impl Fn(&str) -> f64) -> f64 {
        let mut stack: Vec<f64> = Vec::new();
        for operation in &self.operations {
            let value = match *operation {
                Operation::Operand(index) => match &self.operands[index].0 {
                    Operand::Number(value) => *value,
                    Operand::Name(name) => lookup(name),
                },
                Operation::Unary(function) => match stack.pop() {
                    Some(a) => unary(function, a),
                    None => f64::NAN,
                },
                Operation::Binary(function) => match (stack.pop(), stack.pop()) {
                    (Some(b), Some(a)) => binary(function, a, b),
                    _ => f64::NAN,
                },
            };
            stack.push(value);
        }
        stack.pop().unwrap_or(f64::NAN)
    }
}

fn unary(function: Unary, a: f64) -> f64 {
    match function {
        Unary::Neg => -a,
        Unary::Sin => a.sin(),
        Unary::Cos => a.cos(),
        Unary::Tan => a.tan(),
        Unary::Asin => a.asin(),
        Unary::Acos => a.acos(),
        Unary::Atan => a.atan(),
        Unary::Sinh => a.sinh(),
        Unary::Cosh => a.cosh(),
        Unary::Tanh => a.tanh(),
        Unary::Exp => a.exp(),
        Unary::Ln => a.ln(),
        Unary::Log10 => a.log10(),
        Unary::Sqrt => a.sqrt(),
        Unary::Abs => a.abs(),
        Unary::Sign => f64::from(i8::from(a > 0.0) - i8::from(a < 0.0)),
        Unary::Floor => a.floor(),
        Unary::Ceil => a.ceil(),
    }
}

fn binary(function: Binary, a: f64, b: f64) -> f64 {
    match function {
        Binary::Add => a + b,
        Binary::Sub => a - b,
        Binary::Mul => a * b,
        Binary::Div => a / b,
        Binary::Pow => a.powf(b),
        Binary::Min => a.min(b),
        Binary::Max => a.max(b),
        Binary::Atan2 => a.atan2(b),
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

/// What an open parenthesis belongs to.
enum Open {
    Group,
    Unary,
    /// A function of two arguments; whether its comma has been met.
    Binary {
        name: &'static str,
        comma: bool,
    },
}

/// Checks a text token by token and writes the form for exmex: operands as `{index}`, two-argument calls
/// `f(a, b)` as `((a)f(b))`, a leading minus as a difference from zero.
struct Scanner<'a> {
    text: &'a str,
    at: usize,
    out: String,
    operands: Vec<(Operand, Range<usize>)>,
    /// Open parentheses with their places, and whether a `^` waits at that level for another operator.
    open: Vec<(Open, usize)>,
    power: Vec<bool>,
}

impl<'a> Scanner<'a> {
    fn new(text: &'a str) -> Self {
        Self { text, at: 0, out: String::new(), operands: Vec::new(), open: Vec::new(), power: vec![false] }
    }

    fn scan(mut self) -> Result<(String, Vec<(Operand, Range<usize>)>), ExpressionError> {
        loop {
            self.operand()?;
            if self.operator()? {
                break;
            }
        }
        Ok((self.out, self.operands))
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// Skips blanks and looks at the next character.
    fn peek(&mut self) -> Option<char> {
        self.at += self.rest().len() - self.rest().trim_start().len();
        self.rest().chars().next()
    }

    /// Length of the run of characters at the current place for which `f` holds.
    fn run(&self, f: impl Fn(char) -> bool) -> usize {
        self.rest().find(|c| !f(c)).unwrap_or(self.rest().len())
    }

    fn push(&mut self, operand: Operand, span: Range<usize>) {
        let _ = write!(self.out, "{{{}}}", self.operands.len());
        self.operands.push((operand, span));
    }

    /// One operand, with the signs, functions and parentheses that open before it.
    fn operand(&mut self) -> Result<(), ExpressionError> {
        let mut sign_allowed = matches!(self.out.as_bytes().last(), None | Some(b'('));
        loop {
            let Some(c) = self.peek() else {
                let help = "an operand is missing at the end";
                return fail(self.text.len()..self.text.len(), "this expression ends too early", help);
            };
            let start = self.at;
            match c {
                '0'..='9' | '.' => return self.number(),
                'a'..='z' | 'A'..='Z' | '_' => {
                    if self.name()? {
                        return Ok(());
                    }
                }
                '(' => {
                    self.at += 1;
                    self.out.push('(');
                    self.open.push((Open::Group, start));
                    self.power.push(false);
                }
                '-' | '+' if sign_allowed => {
                    self.at += 1;
                    if c == '-' {
                        self.push(Operand::Number(0.0), start..start + 1);
                        self.out.push('-');
                    }
                    sign_allowed = false;
                    continue;
                }
                '-' | '+' => {
                    let help = "put the signed factor in parentheses: 10^(-3), 2*(-x)";
                    return fail(start..start + 1, format!("`{c}` right after an operator"), help);
                }
                ')' => return fail(start..start + 1, "`)` where a number or a name was expected", ""),
                '*' | '/' | '^' | ',' => {
                    let help = if c == '*' { "the power is written with ^" } else { "" };
                    return fail(
                        start..start + 1,
                        format!("`{c}` where a number or a name was expected"),
                        help,
                    );
                }
                _ => return self.unexpected(c),
            }
            sign_allowed = true;
        }
    }

    fn number(&mut self) -> Result<(), ExpressionError> {
        let start = self.at;
        self.at += self.run(|c| c.is_ascii_digit() || c == '.' || c == '_');
        if self.rest().starts_with(['e', 'E']) {
            let sign = usize::from(self.rest()[1..].starts_with(['+', '-']));
            let digits = self.rest()[1 + sign..].bytes().take_while(u8::is_ascii_digit).count();
            self.at += if digits > 0 { 1 + sign + digits } else { 0 };
        }
        let span = start..self.at;
        match self.text[span.clone()].replace('_', "").parse::<f64>() {
            Ok(value) if value.is_finite() => {
                self.push(Operand::Number(value), span);
                Ok(())
            }
            _ => fail(span.clone(), format!("`{}` is not a number", &self.text[span]), ""),
        }
    }

    /// A name: an operand (true) or a function, which opens a parenthesis (false).
    fn name(&mut self) -> Result<bool, ExpressionError> {
        let start = self.at;
        self.at += self.run(|c| c.is_ascii_alphanumeric() || c == '_');
        let span = start..self.at;
        let name = &self.text[span.clone()];
        let called = self.peek() == Some('(');
        let opens = if let Some((name, _)) = UNARY.iter().find(|(n, _)| *n == name) {
            self.out.push_str(name);
            self.out.push('(');
            Open::Unary
        } else if let Some(&(name, _)) = BINARY.iter().find(|(n, _)| *n == name) {
            self.out.push_str("((");
            Open::Binary { name, comma: false }
        } else if called {
            let known = UNARY.iter().map(|f| f.0).chain(BINARY.iter().map(|f| f.0));
            let help = match name {
                "log" => "ln is the natural, log10 the decimal logarithm".to_owned(),
                "pow" => "the power is written with ^".to_owned(),
                _ => super::diagnostic::suggest(name, "functions", known),
            };
            return fail(span, format!("there is no function `{name}`"), &help);
        } else {
            self.push(Operand::Name(name.to_owned()), span);
            return Ok(true);
        };
        if !called {
            let help = "parameters cannot be called like a function";
            return fail(span, format!("function `{name}` needs its argument in parentheses"), help);
        }
        self.open.push((opens, self.at));
        self.power.push(false);
        self.at += 1;
        Ok(false)
    }

    /// What follows an operand: closing parentheses, then an operator or a comma; true at the end of the text.
    fn operator(&mut self) -> Result<bool, ExpressionError> {
        loop {
            let Some(c) = self.peek() else {
                return match self.open.pop() {
                    Some((_, at)) => fail(at..at + 1, "this `(` is not closed", ""),
                    None => Ok(true),
                };
            };
            let here = self.at..self.at + c.len_utf8();
            match c {
                ')' => self.close(here)?,
                ',' => {
                    let Some((Open::Binary { name, comma: comma @ false }, _)) = self.open.last_mut() else {
                        return fail(
                            here,
                            "`,` outside the arguments of a function of two",
                            "the decimal mark is a point",
                        );
                    };
                    *comma = true;
                    let _ = write!(self.out, "){name}(");
                    self.at += 1;
                    self.set_power(false);
                    return Ok(false);
                }
                '^' if self.power.last() == Some(&true) => {
                    return fail(here, "`a^b^c` can be read in two ways", "write a^(b^c) or (a^b)^c");
                }
                '+' | '-' | '*' | '/' | '^' => {
                    self.out.push(c);
                    self.at += 1;
                    self.set_power(c == '^');
                    return Ok(false);
                }
                '0'..='9' | 'a'..='z' | 'A'..='Z' | '_' | '.' | '(' => {
                    return fail(
                        here,
                        format!("an operator is missing before `{c}`"),
                        "products are written with *",
                    );
                }
                _ => return self.unexpected(c).map(|()| true),
            }
        }
    }

    fn close(&mut self, here: Range<usize>) -> Result<(), ExpressionError> {
        self.at = here.end;
        match self.open.pop() {
            None => return fail(here, "this `)` has no opening one", ""),
            Some((Open::Binary { name, comma: false }, at)) => {
                return fail(at..here.end, format!("function `{name}` takes two arguments"), "");
            }
            Some((Open::Binary { .. }, _)) => self.out.push_str("))"),
            Some((Open::Group | Open::Unary, _)) => self.out.push(')'),
        }
        self.power.pop();
        Ok(())
    }

    fn set_power(&mut self, pending: bool) {
        if let Some(last) = self.power.last_mut() {
            *last = pending;
        }
    }

    fn unexpected(&self, c: char) -> Result<(), ExpressionError> {
        let span = self.at..self.at + c.len_utf8();
        fail(span, format!("`{}` has no meaning in an expression", c.escape_debug()), "")
    }
}

#[cfg(test)]
mod tests;
