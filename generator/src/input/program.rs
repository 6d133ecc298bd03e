//! Expressions of time and of the rigid motion, compiled for the runtime.

use rom_runtime::expression::{Instruction, MAX_DEPTH, Program, Variable};

use super::diagnostic::{Diagnostic, suggest};
use super::expression::{Expression, Operand, Operation};
use super::parameters::{Parameters, Place};

/// Names of the variables in time expressions.
pub(crate) const VARIABLES: [(&str, Variable); 10] = [
    ("t", Variable::T),
    ("vx", Variable::Vx),
    ("vy", Variable::Vy),
    ("vz", Variable::Vz),
    ("wx", Variable::Wx),
    ("wy", Variable::Wy),
    ("wz", Variable::Wz),
    ("x", Variable::X),
    ("y", Variable::Y),
    ("z", Variable::Z),
];

/// Compiles an expression, parameters becoming constants. What is wrong with it is reported.
pub(crate) fn compile(
    text: &str,
    place: &Place,
    parameters: &Parameters,
    errors: &mut Vec<Diagnostic>,
) -> Option<Program> {
    let expression = Expression::parse(text)
        .map_err(|e| errors.push(Diagnostic::new(&place.source, place.part(&e.span), e.message, e.help)))
        .ok()?;
    let mut complete = true;
    let operands: Vec<Instruction> = expression
        .operands
        .iter()
        .map(|(operand, at)| match operand {
            Operand::Number(value) => Instruction::Constant(*value),
            Operand::Name(name) => match (variable(name), parameters.get(name)) {
                (Some(v), _) => Instruction::Variable(v),
                (None, Some(Some(value))) => Instruction::Constant(value),
                (None, found) => {
                    complete = false;
                    if found.is_none() {
                        errors.push(unknown(name, place, at, parameters));
                    }
                    Instruction::Constant(0.0)
                }
            },
        })
        .collect();
    if !complete {
        return None;
    }
    let code: Vec<Instruction> = expression
        .operations
        .iter()
        .map(|operation| match *operation {
            Operation::Operand(index) => operands[index],
            Operation::Unary(function) => Instruction::Unary(function),
            Operation::Binary(function) => Instruction::Binary(function),
        })
        .collect();
    if depth(&code) > MAX_DEPTH {
        let message = format!(
            "this expression keeps {} intermediate results, at most {MAX_DEPTH} are possible",
            depth(&code)
        );
        let help = "write long sums as a + b + c, without parentheses that open to the right".to_owned();
        errors.push(Diagnostic::new(&place.source, place.span, message, Some(help)));
        return None;
    }
    check_at_start(&expression, place, parameters, errors)?;
    Some(Program { source: text.to_owned(), code })
}

fn variable(name: &str) -> Option<Variable> {
    VARIABLES.iter().find(|(n, _)| *n == name).map(|(_, v)| *v)
}

fn unknown(name: &str, place: &Place, at: &std::ops::Range<usize>, parameters: &Parameters) -> Diagnostic {
    let list = parameters.list();
    let names = VARIABLES.iter().map(|v| v.0).chain(list.iter().map(|(n, _)| n.as_str()));
    let help = suggest(name, "names usable here", names);
    let message = format!("there is no variable or parameter `{name}`");
    Diagnostic::new(&place.source, place.part(at), message, Some(help))
}

/// A function of time alone has to have a value when the run starts.
fn check_at_start(
    e: &Expression,
    place: &Place,
    parameters: &Parameters,
    errors: &mut Vec<Diagnostic>,
) -> Option<()> {
    if e.names().any(|(name, _)| name != "t" && variable(name).is_some()) {
        return Some(());
    }
    let value = e.value(|name| parameters.get(name).flatten().unwrap_or(0.0));
    if value.is_finite() {
        return Some(());
    }
    let message = format!("this expression is {value} at t = 0, expected a finite value");
    errors.push(Diagnostic::new(&place.source, place.span, message, None));
    None
}

/// Largest number of values on the stack at once.
fn depth(code: &[Instruction]) -> usize {
    let (mut now, mut most) = (0_usize, 0);
    for instruction in code {
        match instruction {
            Instruction::Constant(_) | Instruction::Variable(_) => now += 1,
            Instruction::Unary(_) => {}
            Instruction::Binary(_) => now = now.saturating_sub(1),
        }
        most = most.max(now);
    }
    most
}
