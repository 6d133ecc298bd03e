//! Load cases and time functions: as written, and as the runtime takes them.

use std::borrow::Cow;

use nalgebra::{Matrix3, Vector3};
use rom_runtime::loads::{Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::PointTable;
use super::parameters::Place;
use super::program::compile;
use super::read::{At, Fields, List, Named, Node, Number, Read, Reader, Text, Triple, table, tagged, words};

/// Most time steps a load case may ask for.
const MOST_STEPS: f64 = 1e8;

/// Largest numerical damping accepted.
const MOST_DAMPING: f64 = 1.0;

/// Section frames nearer to each other than this are one.
const SAME_FRAME: f64 = 1e-9;

table! {
    /// A load case: what acts, for how long, and the time step its author ran it with.
    LoadCaseFile {
        /// A line about it.
        description: Option<Text>,
        /// End of the run, s.
        t_end: Number,
        /// Time step, s.
        dt: Number,
        /// Numerical damping `a` of the implicit integrators (Newmark: gamma = 1/2 + a), 0 to 1. Default 0.01.
        numerical_damping: Option<Number>,
        /// Loads, acting together.
        loads: List<LoadFile>,
    }
}

table! {
    /// A force and/or a moment at a named point, times a function of time.
    LoadFile {
        /// Named point where it acts.
        point: Text,
        /// Frame in which its components are constant.
        frame: Frame,
        /// For a follower load: the member whose section it follows. Needed where members with different section axes meet.
        member: Option<Text>,
        /// Force, N per unit of the time function. Default zero.
        force: Option<Triple>,
        /// Moment, N m per unit of the time function. Default zero.
        moment: Option<Triple>,
        /// Name of a time function, or one in place. Default: constant 1.
        time: Option<TimeRef>,
    }
}

words! {
    /// Frame in which the components of a load are constant.
    Frame {
        /// The inertial frame G, whose axes are those of the drawing at t = 0.
        "dead" => Dead,
        /// The local axes of the section, turning with it.
        "follower" => Follower,
        /// The body frame A, turning with the reference node.
        "body" => Body,
    }
}

/// A time function by name or in place.
#[derive(Clone, Debug)]
pub(crate) enum TimeRef {
    Name(Text),
    Inline(Box<TimeFile>),
}

impl Read for TimeRef {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        if node.get_ref().is_table() {
            return TimeFile::read(node, reader).map(|time| Self::Inline(Box::new(time)));
        }
        Text::read(node, reader).map(Self::Name)
    }
}

impl JsonSchema for TimeRef {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "TimeRef".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let name = generator.subschema_for::<Text>();
        let inline = generator.subschema_for::<TimeFile>();
        json_schema!({ "anyOf": [name, inline] })
    }
}

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

pub(crate) fn positive(number: &Number, what: &str, unit: &str, reader: &mut Reader) -> Option<f64> {
    if number.value > 0.0 {
        return Some(number.value);
    }
    reader.error(number.span, format!("{what} is {} {unit}, expected a positive number", number.value))
}

impl TimeFile {
    fn resolve(&self, reader: &mut Reader) -> Option<TimeFunction> {
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

/// Checks the load cases against the points they act on. A point whose frames are `None` is in error itself.
pub(crate) fn resolve_load_cases(
    cases: &Named<LoadCaseFile>,
    times: &Named<TimeFile>,
    points: &PointTable,
    reader: &mut Reader,
) -> Vec<LoadCase> {
    let time_functions = resolve_times(times, reader);
    let mut list = Vec::new();
    for (name, case) in &cases.items {
        if name.value == "all" {
            reader.error_help::<()>(
                name.span,
                "`all` cannot name a load case",
                "it stands for all load cases",
            );
        }
        let Some(case) = case else { continue };
        let settings = check_settings(case, reader);
        let loads: Vec<Option<Load>> = case
            .loads
            .items
            .iter()
            .map(|load| resolve_load(load.as_ref()?, times, &time_functions, points, reader))
            .collect();
        let (Some([t_end, dt, numerical_damping]), Some(loads)) = (settings, loads.into_iter().collect())
        else {
            continue;
        };
        let description = case.description.as_ref().map_or(String::new(), |d| d.value.clone());
        list.push(LoadCase { name: name.value.clone(), description, t_end, dt, numerical_damping, loads });
    }
    list
}

fn check_settings(case: &LoadCaseFile, reader: &mut Reader) -> Option<[f64; 3]> {
    let dt = positive(&case.dt, "the time step", "s", reader);
    let t_end = positive(&case.t_end, "the end of the run", "s", reader);
    let damping = match &case.numerical_damping {
        None => Some(0.01),
        Some(a) if (0.0..=MOST_DAMPING).contains(&a.value) => Some(a.value),
        Some(a) => {
            let message =
                format!("the numerical damping is {}, expected a number from 0 to {MOST_DAMPING}", a.value);
            reader.error(a.span, message)
        }
    };
    let (dt, t_end) = (dt?, t_end?);
    if dt > t_end {
        return reader
            .error(case.dt.span, format!("the time step is {dt} s, longer than the run of {t_end} s"));
    }
    if t_end / dt > MOST_STEPS {
        let message = format!("{:.0} time steps, at most {MOST_STEPS:e} are accepted", t_end / dt);
        return reader.error(case.dt.span, message);
    }
    Some([t_end, dt, damping?])
}

fn resolve_load(
    load: &LoadFile,
    times: &Named<TimeFile>,
    time_functions: &Times,
    points: &PointTable,
    reader: &mut Reader,
) -> Option<Load> {
    let time = match &load.time {
        None => Some(TimeFunction::Constant { value: 1.0 }),
        Some(TimeRef::Inline(time)) => time.resolve(reader),
        Some(TimeRef::Name(name)) => times
            .find(name, "time function", "time functions", reader)
            .and_then(|i| time_functions[i].1.clone()),
    };
    if load.force.is_none() && load.moment.is_none() {
        reader.error::<()>(load.span, "a load needs `force`, `moment` or both");
    }
    let frame = resolve_frame(load, points, reader);
    let components = |v: &Option<Triple>| v.as_ref().map_or(Vector3::zeros(), |v| v.value).into();
    let (point, frame) = frame?;
    Some(Load { point, frame, force: components(&load.force), moment: components(&load.moment), time: time? })
}

fn resolve_frame(load: &LoadFile, points: &PointTable, reader: &mut Reader) -> Option<(u32, LoadFrame)> {
    let name = &load.point;
    let Some(index) = points.points.iter().position(|(n, _)| *n == name.value) else {
        let help =
            super::diagnostic::suggest(&name.value, "points", points.points.iter().map(|(n, _)| n.as_str()));
        return reader.error_help(
            name.span,
            format!("there is no point `{}`", name.value.escape_debug()),
            help,
        );
    };
    let sections = &points.points[index].1;
    let frame = match load.frame {
        Frame::Dead => LoadFrame::Dead,
        Frame::Body => LoadFrame::Body,
        // No sections: the point is in error itself.
        Frame::Follower if sections.is_empty() => return None,
        Frame::Follower => {
            let e = follower_frame(load, sections, reader)?;
            LoadFrame::Follower { section: [0, 1, 2].map(|i| [e[(i, 0)], e[(i, 1)], e[(i, 2)]]) }
        }
    };
    if let (Some(At { value, span }), Frame::Dead | Frame::Body) = (&load.member, load.frame) {
        let message =
            format!("`member = {value:?}` says which section a follower load follows, but this one is not");
        return reader.error_help(*span, message, "leave `member` out, or write frame = \"follower\"");
    }
    Some((index as u32, frame))
}

fn follower_frame(
    load: &LoadFile,
    sections: &[(String, Matrix3<f64>)],
    reader: &mut Reader,
) -> Option<Matrix3<f64>> {
    let mut candidates: Vec<&(String, Matrix3<f64>)> = sections.iter().collect();
    let mut at = load.point.span;
    if let Some(member) = &load.member {
        candidates.retain(|(name, _)| *name == member.value);
        at = member.span;
        if candidates.is_empty() {
            let help = super::diagnostic::suggest(
                &member.value,
                "members there",
                sections.iter().map(|s| s.0.as_str()),
            );
            let message =
                format!("no member `{}` at point `{}`", member.value.escape_debug(), load.point.value);
            return reader.error_help(at, message, help);
        }
    }
    let first = candidates.first()?.1;
    if candidates.iter().all(|(_, e)| (e - first).amax() < SAME_FRAME) {
        return Some(first);
    }
    let point = &load.point.value;
    if load.member.is_some() {
        let message = format!("the member has a corner at point `{point}`: two section frames meet there");
        return reader.error_help(at, message, "split the member at the point and name the part to follow");
    }
    let names: Vec<String> = candidates.iter().map(|(name, _)| format!("`{name}`")).collect();
    let message = format!("members with different section axes meet at point `{point}`");
    reader.error_help(at, message, format!("say which one to follow with `member = `: {}", names.join(", ")))
}
