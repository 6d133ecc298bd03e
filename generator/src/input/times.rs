//! Time functions of loads: as written, and as the runtime takes them.

use std::borrow::Cow;

use rom_runtime::time::TimeFunction;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::parameters::Place;
use super::program::compile;
use super::read::{Fields, Node, Read, Reader, table, tagged};
use super::values::{List, Named, Number, Text, positive};

/// A time function: a shape, or an expression.
#[derive(Clone, Debug)]
pub(crate) enum TimeFile {
    Shape(TimeShape),
    Expression(ExpressionTime),
}

impl Read for TimeFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let fields = Fields::of(node, reader)?;
        if fields.has("shape") {
            return TimeShape::read(node, reader).map(Self::Shape);
        }
        if !fields.has("expression") {
            let help = "shapes: constant, step, ramp, triangle, sine, one-minus-cosine, table";
            return reader.error_help(
                node.span().into(),
                "a time function needs `shape` or `expression`",
                help,
            );
        }
        ExpressionTime::read_fields(fields, reader).map(Self::Expression)
    }
}

impl JsonSchema for TimeFile {
    fn schema_name() -> Cow<'static, str> {
        "Time".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let shape = generator.subschema_for::<TimeShape>();
        let expression = generator.subschema_for::<ExpressionTime>();
        json_schema!({ "description": "A function of time.", "anyOf": [shape, expression] })
    }
}

table! {
    /// A function of time and of the rigid motion, in ordinary notation.
    ExpressionTime {
        /// Of `t` (s), `vx vy vz` (velocity of A in A, m/s), `wx wy wz` (angular velocity of A in A, rad/s), `x y z`
        /// (position of A in G, m) and the parameters.
        expression: Formula,
    }
}

/// A compiled formula.
#[derive(Clone, Debug)]
pub(crate) struct Formula(rom_runtime::expression::Program);

impl Read for Formula {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = Text::read(node, reader)?;
        let place = Place::new(&reader.source, text.span, &text.value);
        compile(&text.value, &place, reader.parameters, &mut reader.errors).map(Self)
    }
}

impl JsonSchema for Formula {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Formula".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string" })
    }
}

tagged! {
    /// A time function of a common shape.
    TimeShape by "shape" {
        "constant" => Constant,
        "step" => Step,
        "ramp" => Ramp,
        "triangle" => Triangle,
        "sine" => Sine,
        "one-minus-cosine" => OneMinusCosine,
        "table" => TableTime,
    }
}

table! {
    /// The same at all times.
    Constant {
        /// Value. Default 1.
        value: Option<Number>,
    }
}

table! {
    /// Zero, then `value` from `start` on, zero again from `end` on.
    Step {
        /// Value. Default 1.
        value: Option<Number>,
        /// Start, s. Default 0.
        start: Option<Number>,
        /// End, s. Default: none.
        end: Option<Number>,
    }
}

table! {
    /// Zero up to `start`, then `rate (t - start)`, constant from `end` on.
    Ramp {
        /// Slope, 1/s.
        rate: Number,
        /// Start, s. Default 0.
        start: Option<Number>,
        /// End of the slope, s. Default: none.
        end: Option<Number>,
    }
}

table! {
    /// From zero at `start` to `peak` at `at` and back to zero at `end`, zero outside.
    Triangle {
        /// Height. Default 1.
        peak: Option<Number>,
        /// Start, s. Default 0.
        start: Option<Number>,
        /// Time of the peak, s.
        at: Number,
        /// End, s.
        end: Number,
    }
}

table! {
    /// `amplitude sin(omega (t - start) + phase)` from `start` to `end`, zero outside.
    Sine {
        /// Amplitude. Default 1.
        amplitude: Option<Number>,
        /// Circular frequency, rad/s ("2*pi*f" for f in Hz).
        omega: Number,
        /// Phase at `start`, rad. Default 0.
        phase: Option<Number>,
        /// Start, s. Default 0.
        start: Option<Number>,
        /// End, s. Default: none.
        end: Option<Number>,
    }
}

table! {
    /// `amplitude/2 (1 - cos(2 pi (t - start)/duration))` for `duration` from `start`, zero outside.
    OneMinusCosine {
        /// Largest value. Default 1.
        amplitude: Option<Number>,
        /// Start, s. Default 0.
        start: Option<Number>,
        /// Duration, s.
        duration: Number,
    }
}

table! {
    /// Linear between the entries of a table, constant before the first and after the last.
    TableTime {
        /// Times, s, rising.
        t: List<Number>,
        /// Values at these times, as many.
        value: List<Number>,
    }
}

fn or(number: &Option<Number>, default: f64) -> f64 {
    number.as_ref().map_or(default, |n| n.value)
}

/// `end`, where given, after `start`.
fn end_after(start: f64, end: &Option<Number>, reader: &mut Reader) -> Option<f64> {
    match end {
        Some(end) => after(start, end, "start", reader),
        None => Some(f64::MAX),
    }
}

fn after(start: f64, end: &Number, name: &str, reader: &mut Reader) -> Option<f64> {
    if end.value > start {
        return Some(end.value);
    }
    reader.error(end.span, format!("this time is {} s, expected one after `{name}`, {start} s", end.value))
}

impl TimeFile {
    /// Checks the function.
    pub(crate) fn resolve(&self, reader: &mut Reader) -> Option<TimeFunction> {
        match self {
            Self::Shape(shape) => shape.resolve(reader),
            Self::Expression(e) => Some(TimeFunction::Expression { program: e.expression.0.clone() }),
        }
    }
}

impl TimeShape {
    fn resolve(&self, reader: &mut Reader) -> Option<TimeFunction> {
        Some(match self {
            Self::Constant(c) => TimeFunction::Constant { value: or(&c.value, 1.0) },
            Self::Step(s) => {
                let start = or(&s.start, 0.0);
                TimeFunction::Step { value: or(&s.value, 1.0), start, end: end_after(start, &s.end, reader)? }
            }
            Self::Ramp(r) => {
                let start = or(&r.start, 0.0);
                TimeFunction::Ramp { rate: r.rate.value, start, end: end_after(start, &r.end, reader)? }
            }
            Self::Triangle(t) => {
                let start = or(&t.start, 0.0);
                let at = after(start, &t.at, "start", reader);
                let end = after(t.at.value, &t.end, "at", reader);
                TimeFunction::Triangle { peak: or(&t.peak, 1.0), start, at: at?, end: end? }
            }
            Self::Sine(s) => {
                let start = or(&s.start, 0.0);
                TimeFunction::Sine {
                    amplitude: or(&s.amplitude, 1.0),
                    omega: s.omega.value,
                    phase: or(&s.phase, 0.0),
                    start,
                    end: end_after(start, &s.end, reader)?,
                }
            }
            Self::OneMinusCosine(c) => TimeFunction::OneMinusCosine {
                amplitude: or(&c.amplitude, 1.0),
                start: or(&c.start, 0.0),
                duration: positive(&c.duration, "the duration", "s", reader)?,
            },
            Self::TableTime(table) => table.resolve(reader)?,
        })
    }
}

impl TableTime {
    fn resolve(&self, reader: &mut Reader) -> Option<TimeFunction> {
        let t: Vec<&Number> = self.t.items.iter().flatten().collect();
        let value: Vec<f64> = self.value.items.iter().flatten().map(|n| n.value).collect();
        if t.len() != self.t.items.len() || value.len() != self.value.items.len() {
            return None;
        }
        if t.is_empty() {
            return reader.error(self.t.span, "an empty table, expected at least one time");
        }
        if t.len() != value.len() {
            let message = format!("{} values for {} times", value.len(), t.len());
            return reader.error(self.value.span, message);
        }
        for pair in t.windows(2) {
            after(pair[0].value, pair[1], "the time before", reader)?;
        }
        Some(TimeFunction::Table { t: t.iter().map(|n| n.value).collect(), value })
    }
}

/// Time functions by name; `None` where one is wrong.
pub(crate) type Times = Vec<(String, Option<TimeFunction>)>;

/// Checks the named time functions.
pub(crate) fn resolve_times(times: &Named<TimeFile>, reader: &mut Reader) -> Times {
    let one = |(name, time): &(Text, Option<TimeFile>)| {
        (name.value.clone(), time.as_ref().and_then(|time| time.resolve(reader)))
    };
    times.items.iter().map(one).collect()
}
