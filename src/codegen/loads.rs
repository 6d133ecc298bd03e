//! The load case as a C function.

use std::fmt::Write;

use rom_runtime::expression::{Binary, Instruction, Program, Unary, Variable};
use rom_runtime::time::TimeFunction;
use rom_runtime::{DistributedFrame, DistributedLoad, LoadFrame};

use super::number::Scalar;
use super::tables::Tables;

/// Whether a time function jumps at an instant.
pub(super) fn has_jumps(tables: &Tables) -> bool {
    tables.times().any(|time| {
        matches!(time, TimeFunction::Step { .. } | TimeFunction::Ramp { .. } | TimeFunction::Sine { .. })
    })
}

/// `load_case`, which adds the wrenches at an instant.
pub(super) fn function(tables: &Tables, scalar: Scalar) -> Result<String, String> {
    let mut out = String::new();
    let writer = Writer { scalar };
    let (mut arrays, mut body) = (String::new(), String::new());
    for (index, load) in tables.loads.iter().enumerate() {
        let factor = writer.time_function(&load.time, index, &mut arrays)?;
        let _ = writeln!(body, "    factor = {factor};");
        let (axes, force, moment) = match &load.frame {
            LoadFrame::Dead => ("dead", load.force, load.moment),
            LoadFrame::Body => ("body", load.force, load.moment),
            LoadFrame::Follower { section } => {
                ("node", turned(section, load.force), turned(section, load.moment))
            }
        };
        for (what, vector) in [("force", force), ("moment", moment)] {
            for (k, value) in vector.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                let (place, value) = (tables.place(load.point), scalar.literal(*value));
                let _ = writeln!(body, "    wrench[{place}].{axes}_{what}[{k}] += factor * {value};");
            }
        }
    }
    for (line, (first, load)) in tables.lines.iter().enumerate() {
        let factor = writer.time_function(&load.time, tables.loads.len() + line, &mut arrays)?;
        let _ = writeln!(body, "    factor = {factor};");
        writer.distributed(line, *first, load, &mut arrays, &mut body);
    }
    out += "\n/* ---- The load case. ---- */\n\n";
    if tables.times().any(|time| matches!(time, TimeFunction::Table { .. })) {
        out += TABLE;
    }
    if tables.times().any(|time| matches!(time, TimeFunction::OneMinusCosine { .. })) {
        out += ONE_MINUS_COSINE;
    }
    let signs = |time: &TimeFunction| match time {
        TimeFunction::Expression { program } => program.code.contains(&Instruction::Unary(Unary::Sign)),
        _ => false,
    };
    if tables.times().any(signs) {
        out += SIGN;
    }
    out += &arrays;
    out += "/* Adds the loads at time t, with velocity and angular velocity of A in A and the position of its origin in G. */\n";
    out += "static void load_case(rom_real t, const rom_real v[3], const rom_real w[3], const rom_real r[3], rom_wrench *wrench)\n{\n";
    if !(tables.loads.is_empty() && tables.lines.is_empty()) {
        out += "    rom_real factor;\n";
    }
    if !tables.lines.is_empty() {
        out += "    int i, k;\n";
    }
    out += "    (void)t; (void)v; (void)w; (void)r; (void)wrench;\n";
    out += &body;
    out += "}\n\n";
    Ok(out)
}

/// Linear interpolation, constant outside.
const TABLE: &str = "\
static rom_real table(rom_real t, int n, const rom_real *instant, const rom_real *value)
{
    int i = 0;
    while (i < n && instant[i] <= t)
        i++;
    if (i == 0)
        return value[0];
    if (i == n)
        return value[n - 1];
    return value[i - 1] + (value[i] - value[i - 1]) * ((t - instant[i - 1]) / (instant[i] - instant[i - 1]));
}

";

const ONE_MINUS_COSINE: &str = "\
static rom_real one_minus_cosine(rom_real s, rom_real amplitude)
{
    const rom_real sine = rom_sin(R(3.141592653589793) * s);
    return s <= R(0.0) || s >= R(1.0) ? R(0.0) : amplitude * sine * sine;
}

";

const SIGN: &str = "\
static rom_real sign(rom_real x)
{
    return x > R(0.0) ? R(1.0) : x < R(0.0) ? R(-1.0) : R(0.0);
}

";

/// An end that is never reached.
const NEVER: f64 = 1e30;

struct Writer {
    scalar: Scalar,
}

impl Writer {
    fn number(&self, x: f64) -> String {
        let literal = self.scalar.literal(x);
        if x < 0.0 { format!("({literal})") } else { literal }
    }

    /// Forces and moments on the stations of a member, from the carrier `first` on, per unit factor.
    fn distributed(
        &self,
        line: usize,
        first: usize,
        load: &DistributedLoad,
        arrays: &mut String,
        body: &mut String,
    ) {
        let axes = match load.frame {
            DistributedFrame::Dead => "dead",
            DistributedFrame::Body => "body",
            DistributedFrame::Follower => "node",
        };
        for (what, values) in [("force", &load.force), ("moment", &load.moment)] {
            if values.is_empty() {
                continue;
            }
            let rows: Vec<String> = values.chunks(3).map(|row| self.scalar.list(row)).collect();
            let (n, rows) = (rows.len(), rows.join(",\n    "));
            let name = format!("{}_{line}", what.to_ascii_uppercase());
            let _ = writeln!(arrays, "static const rom_real {name}[{n}][3] = {{\n    {rows}\n}};\n");
            let _ = writeln!(body, "    for (i = 0; i < {n}; i++)\n        for (k = 0; k < 3; k++)");
            let _ =
                writeln!(body, "            wrench[{first} + i].{axes}_{what}[k] += factor * {name}[i][k];");
        }
    }

    /// C expression of the factor at time `t`; tables go to `arrays`.
    fn time_function(
        &self,
        time: &TimeFunction,
        index: usize,
        arrays: &mut String,
    ) -> Result<String, String> {
        let n = |x: f64| self.number(x);
        let zero = n(0.0);
        let within = |start: f64, end: f64| {
            let begun = format!("reached(t, {})", n(start));
            if end > NEVER { begun } else { format!("{begun} && !reached(t, {})", n(end)) }
        };
        Ok(match time {
            TimeFunction::Constant { value } => n(*value),
            TimeFunction::Step { value, start, end } => {
                format!("{} ? {} : {zero}", within(*start, *end), n(*value))
            }
            TimeFunction::Ramp { rate, start, end } => {
                let until = if *end > NEVER { "t".to_owned() } else { format!("rom_fmin(t, {})", n(*end)) };
                format!("reached(t, {0}) ? {1} * ({until} - {0}) : {zero}", n(*start), n(*rate))
            }
            TimeFunction::Triangle { peak, start, at, end } => {
                let (rise, fall) = (self.number(at - start), self.number(end - at));
                let up = if at > start {
                    format!("t < {0} ? {1} * ((t - {2}) / {rise}) : ", n(*at), n(*peak), n(*start))
                } else {
                    String::new()
                };
                let down = if end > at {
                    format!("{} * (({} - t) / {fall})", n(*peak), n(*end))
                } else {
                    zero.clone()
                };
                format!("t <= {} || t >= {} ? {zero} : {up}{down}", n(*start), n(*end))
            }
            TimeFunction::Sine { amplitude, omega, phase, start, end } => format!(
                "{} ? {} * rom_sin({} * (t - {}) + {}) : {zero}",
                within(*start, *end),
                n(*amplitude),
                n(*omega),
                n(*start),
                n(*phase)
            ),
            TimeFunction::OneMinusCosine { amplitude, start, duration } => {
                format!("one_minus_cosine((t - {}) / {}, {})", n(*start), n(*duration), n(*amplitude))
            }
            TimeFunction::Table { t, value } => {
                let (instants, values) = (self.scalar.list(t), self.scalar.list(value));
                let _ = writeln!(arrays, "static const rom_real INSTANT_{index}[] = {instants};");
                let _ = writeln!(arrays, "static const rom_real FACTOR_{index}[] = {values};\n");
                format!("table(t, {}, INSTANT_{index}, FACTOR_{index})", t.len())
            }
            TimeFunction::Expression { program } => self.expression(program)?,
        })
    }

    fn expression(&self, program: &Program) -> Result<String, String> {
        let broken = || format!("the expression {:?} of a load cannot be evaluated", program.source);
        let mut stack: Vec<String> = Vec::new();
        for instruction in &program.code {
            let term = match instruction {
                Instruction::Constant(value) => self.number(*value),
                Instruction::Variable(variable) => name(*variable).to_owned(),
                Instruction::Unary(function) => {
                    let x = stack.pop().ok_or_else(broken)?;
                    match function {
                        Unary::Neg => format!("(-{x})"),
                        other => format!("{}({x})", unary(*other)),
                    }
                }
                Instruction::Binary(function) => {
                    let (y, x) = (stack.pop().ok_or_else(broken)?, stack.pop().ok_or_else(broken)?);
                    match binary(*function) {
                        (operator, true) => format!("({x} {operator} {y})"),
                        (function, false) => format!("{function}({x}, {y})"),
                    }
                }
            };
            stack.push(term);
        }
        stack.pop().filter(|_| stack.is_empty()).ok_or_else(broken)
    }
}

fn name(variable: Variable) -> &'static str {
    match variable {
        Variable::T => "t",
        Variable::Vx => "v[0]",
        Variable::Vy => "v[1]",
        Variable::Vz => "v[2]",
        Variable::Wx => "w[0]",
        Variable::Wy => "w[1]",
        Variable::Wz => "w[2]",
        Variable::X => "r[0]",
        Variable::Y => "r[1]",
        Variable::Z => "r[2]",
    }
}

fn unary(function: Unary) -> &'static str {
    match function {
        Unary::Neg => "-",
        Unary::Sin => "rom_sin",
        Unary::Cos => "rom_cos",
        Unary::Tan => "rom_tan",
        Unary::Asin => "rom_asin",
        Unary::Acos => "rom_acos",
        Unary::Atan => "rom_atan",
        Unary::Sinh => "rom_sinh",
        Unary::Cosh => "rom_cosh",
        Unary::Tanh => "rom_tanh",
        Unary::Exp => "rom_exp",
        Unary::Ln => "rom_log",
        Unary::Log10 => "rom_log10",
        Unary::Sqrt => "rom_sqrt",
        Unary::Abs => "rom_fabs",
        Unary::Sign => "sign",
        Unary::Floor => "rom_floor",
        Unary::Ceil => "rom_ceil",
    }
}

/// Operator or function, and whether it is an operator.
fn binary(function: Binary) -> (&'static str, bool) {
    match function {
        Binary::Add => ("+", true),
        Binary::Sub => ("-", true),
        Binary::Mul => ("*", true),
        Binary::Div => ("/", true),
        Binary::Pow => ("rom_pow", false),
        Binary::Min => ("rom_fmin", false),
        Binary::Max => ("rom_fmax", false),
        Binary::Atan2 => ("rom_atan2", false),
    }
}

fn turned(section: &[[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
    section.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}
