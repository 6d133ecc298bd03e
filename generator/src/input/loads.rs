//! Load cases and time functions: as written, and as the runtime takes them.

use std::borrow::Cow;

use nalgebra::{Matrix3, Vector3};
use rom_runtime::loads::{DistributedLoad, Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::case::{InitialFile, MotionFile, resolve_initial, resolve_motion};
use super::distributed::DistributedFile;
use super::read::{Node, Read, Reader, table, words};
use super::times::{TimeFile, Times, resolve_times};
use super::values::{At, List, Named, Number, Text, Triple, positive};
use super::{Line, PointTable};

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
        /// Loads, acting together. Default: none.
        loads: Option<List<LoadFile>>,
        /// Loads per length along members, acting besides. Default: none.
        distributed_loads: Option<List<DistributedFile>>,
        /// Motion of frame A, instead of free flight.
        motion: Option<MotionFile>,
        /// Where the run starts. Default: at rest in the equilibrium.
        initial: Option<InitialFile>,
    }
}

table! {
    /// A force and/or a moment at a named point, times a function of time.
    LoadFile {
        /// Name, for people and for the balance of an equilibrium. Several loads may share one.
        name: Option<Text>,
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

/// What loads refer to: time functions and points.
pub(crate) struct LoadContext<'a> {
    times: &'a Named<TimeFile>,
    time_functions: Times,
    /// A point whose frames are missing is in error itself.
    points: &'a PointTable,
}

impl<'a> LoadContext<'a> {
    /// Checks the time functions.
    pub(crate) fn new(times: &'a Named<TimeFile>, points: &'a PointTable, reader: &mut Reader) -> Self {
        Self { times, time_functions: resolve_times(times, reader), points }
    }

    /// Finds a time function.
    pub(crate) fn time(&self, time: &TimeRef, reader: &mut Reader) -> Option<TimeFunction> {
        match time {
            TimeRef::Inline(time) => time.resolve(reader),
            TimeRef::Name(name) => self
                .times
                .find(name, "time function", "time functions", reader)
                .and_then(|i| self.time_functions[i].1.clone()),
        }
    }

    /// Checks a list of loads.
    pub(crate) fn loads(&self, list: &[Option<LoadFile>], reader: &mut Reader) -> Option<Vec<Load>> {
        // All of them, so that every error is reported.
        let loads: Vec<Option<Load>> =
            list.iter().map(|load| resolve_load(load.as_ref()?, self, reader)).collect();
        loads.into_iter().collect()
    }
}

impl LoadContext<'_> {
    /// The function of time that a load names or holds; constant 1 where it has none.
    pub(crate) fn time_or_one(&self, time: Option<&TimeRef>, reader: &mut Reader) -> Option<TimeFunction> {
        match time {
            None => Some(TimeFunction::Constant { value: 1.0 }),
            Some(time) => self.time(time, reader),
        }
    }

    /// The members that distributed loads can act on.
    pub(crate) fn lines(&self) -> &[Line] {
        &self.points.lines
    }

    /// Checks a list of distributed loads.
    pub(crate) fn distributed(
        &self,
        list: Option<&List<DistributedFile>>,
        reader: &mut Reader,
    ) -> Option<Vec<DistributedLoad>> {
        // All of them, so that every error is reported.
        let given = list.iter().flat_map(|list| &list.items);
        let loads: Vec<_> = given.map(|load| load.as_ref()?.resolve(self, reader)).collect();
        loads.into_iter().collect()
    }
}

/// Checks the load cases against what they refer to.
pub(crate) fn resolve_load_cases(
    cases: &Named<LoadCaseFile>,
    context: &LoadContext<'_>,
    reader: &mut Reader,
) -> Vec<LoadCase> {
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
        let loads = context.loads(case.loads.as_ref().map_or(&[], |list| &list.items), reader);
        let distributed = context.distributed(case.distributed_loads.as_ref(), reader);
        let motion = case.motion.as_ref().map(|motion| resolve_motion(motion, context, reader));
        let start = |initial| resolve_initial(initial, case.motion.as_ref(), cases, context, reader);
        let initial = case.initial.as_ref().map(start);
        let (Some([t_end, dt, numerical_damping]), Some(loads), Some(distributed)) =
            (settings, loads, distributed)
        else {
            continue;
        };
        let description = case.description.as_ref().map_or(String::new(), |d| d.value.clone());
        list.push(LoadCase {
            name: name.value.clone(),
            description,
            t_end,
            dt,
            numerical_damping,
            loads,
            distributed,
            motion: motion.flatten(),
            initial: initial.flatten(),
        });
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

fn resolve_load(load: &LoadFile, context: &LoadContext<'_>, reader: &mut Reader) -> Option<Load> {
    let time = context.time_or_one(load.time.as_ref(), reader);
    if load.force.is_none() && load.moment.is_none() {
        reader.error::<()>(load.span, "a load needs `force`, `moment` or both");
    }
    let frame = resolve_frame(load, context.points, reader);
    let components = |v: &Option<Triple>| v.as_ref().map_or(Vector3::zeros(), |v| v.value).into();
    let (point, frame) = frame?;
    Some(Load { point, frame, force: components(&load.force), moment: components(&load.moment), time: time? })
}

fn resolve_frame(load: &LoadFile, points: &PointTable, reader: &mut Reader) -> Option<(u32, LoadFrame)> {
    let index = points.find(&load.point, reader)?;
    let sections = &points.points[index].1;
    let frame = match load.frame {
        Frame::Dead => LoadFrame::Dead,
        Frame::Body => LoadFrame::Body,
        // No sections: the point is in error itself.
        Frame::Follower if sections.is_empty() => return None,
        Frame::Follower => {
            let e = section_frame(&load.point, load.member.as_ref(), sections, reader)?;
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

/// The one section frame at a point, or that of the member named.
pub(crate) fn section_frame(
    point: &Text,
    member: Option<&Text>,
    sections: &[(String, Matrix3<f64>)],
    reader: &mut Reader,
) -> Option<Matrix3<f64>> {
    let mut candidates: Vec<&(String, Matrix3<f64>)> = sections.iter().collect();
    let mut at = point.span;
    if let Some(member) = member {
        candidates.retain(|(name, _)| *name == member.value);
        at = member.span;
        if candidates.is_empty() {
            let help = super::diagnostic::suggest(
                &member.value,
                "members there",
                sections.iter().map(|s| s.0.as_str()),
            );
            let message = format!("no member `{}` at point `{}`", member.value.escape_debug(), point.value);
            return reader.error_help(at, message, help);
        }
    }
    let first = candidates.first()?.1;
    if candidates.iter().all(|(_, e)| (e - first).amax() < SAME_FRAME) {
        return Some(first);
    }
    let point = &point.value;
    if member.is_some() {
        let message = format!("the member has a corner at point `{point}`: two section frames meet there");
        return reader.error_help(at, message, "split the member at the point and name the part to follow");
    }
    let names: Vec<String> = candidates.iter().map(|(name, _)| format!("`{name}`")).collect();
    let message = format!("members with different section axes meet at point `{point}`");
    reader.error_help(at, message, format!("say which one to follow with `member = `: {}", names.join(", ")))
}
