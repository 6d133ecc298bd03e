//! The grammar of expressions, token by token.

use std::fmt::Write as _;
use std::ops::Range;

use super::{BINARY, ExpressionError, Operand, Operands, UNARY, fail};

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
pub(super) struct Scanner<'a> {
    text: &'a str,
    at: usize,
    out: String,
    operands: Operands,
    /// Open parentheses with their places, and whether a `^` waits at that level for another operator.
    open: Vec<(Open, usize)>,
    power: Vec<bool>,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, at: 0, out: String::new(), operands: Vec::new(), open: Vec::new(), power: vec![false] }
    }

    /// The rewritten text and its operands.
    pub(super) fn scan(mut self) -> Result<(String, Operands), ExpressionError> {
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
                _ => crate::input::diagnostic::suggest(name, "functions", known),
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
