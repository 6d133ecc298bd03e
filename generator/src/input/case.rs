//! How a load case moves frame A and where it starts: as written, and as the runtime takes them.

use std::borrow::Cow;

use rom_runtime::loads::InitialState;
use rom_runtime::time::TimeFunction;
use rom_runtime::{BaseMotion, Drive};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use toml::de::DeValue;

use super::diagnostic::Span;
use super::distributed::DistributedFile;
use super::equilibrium::{AttitudeFile, AxesFile};
use super::loads::{LoadCaseFile, LoadContext, LoadFile, TimeRef};
use super::read::{Node, Read, Reader, table};
use super::values::{List, Named, Number, Text, Triple};
use crate::math::so3::scalar_first;

/// Jump of a velocity, m/s or rad/s, that is rounding.
const JUMP: f64 = 1e-9;

table! {
    /// Motion of frame A prescribed by functions of time, instead of free flight. What is not given is zero: an empty table holds A.
    MotionFile {
        /// Axes of the components. Default: those of A.
        axes: Option<AxesFile>,
        /// Velocity of the origin of A, m/s.
        velocity: Option<DriveFile>,
        /// Inertial acceleration of the origin of A, m/s^2, instead of its velocity.
        acceleration: Option<DriveFile>,
        /// Angular velocity of A, rad/s.
        angular_velocity: Option<DriveFile>,
        /// Angular acceleration of A, rad/s^2, instead of its angular velocity.
        angular_acceleration: Option<DriveFile>,
    }
}

table! {
    /// Three components over time.
    DriveFile {
        /// Along or about x.
        x: Option<ComponentFile>,
        /// Along or about y.
        y: Option<ComponentFile>,
        /// Along or about z.
        z: Option<ComponentFile>,
    }
}

/// A number, a time function by name, or one in place.
#[derive(Clone, Debug)]
pub(crate) struct ComponentFile {
    value: ComponentValue,
    span: Span,
}

#[derive(Clone, Debug)]
enum ComponentValue {
    Constant(f64),
    Time(TimeRef),
}

impl Read for ComponentFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let value = match node.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => {
                ComponentValue::Constant(Number::read(node, reader)?.value)
            }
            _ => ComponentValue::Time(TimeRef::read(node, reader)?),
        };
        Some(Self { value, span: node.span().into() })
    }
}

impl JsonSchema for ComponentFile {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "DriveComponent".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let time = generator.subschema_for::<TimeRef>();
        json_schema!({ "anyOf": [{ "type": "number" }, time] })
    }
}

table! {
    /// Where a run starts. What is not given is as in the equilibrium, at rest.
    InitialFile {
        /// Attitude of A.
        attitude: Option<AttitudeFile>,
        /// Position of the reference in G, m.
        position: Option<Triple>,
        /// Velocity of the origin of A, m/s.
        velocity: Option<Triple>,
        /// Angular velocity of A, rad/s.
        angular_velocity: Option<Triple>,
        /// Axes of the two velocities. Default: those of A.
        axes: Option<AxesFile>,
        /// Amplitudes of the elastic modes 1, 2, ..., scaled to a generalised mass of 1 kg m^2.
        amplitudes: Option<List<Number>>,
        /// Rates of the amplitudes, 1/s.
        rates: Option<List<Number>>,
        /// Start in the static shape under the loads of this load case, taken at t = 0, with the reference held.
        shape_of: Option<Text>,
        /// Start in the static shape under these loads, with the reference held.
        shape_loads: Option<List<LoadFile>>,
        /// The same for loads per length, besides.
        shape_distributed_loads: Option<List<DistributedFile>>,
    }
}

/// Checks the motion of A.
pub(crate) fn resolve_motion(
    file: &MotionFile,
    context: &LoadContext<'_>,
    reader: &mut Reader,
) -> Option<BaseMotion> {
    let pair = |velocity: &Option<DriveFile>, acceleration: &Option<DriveFile>, reader: &mut Reader| match (
        velocity,
        acceleration,
    ) {
        (Some(_), Some(both)) => {
            reader.error_help(both.span, "the velocity is given already", "give one of the two")
        }
        (Some(given), None) => resolve_drive(given, false, context, reader),
        (None, Some(given)) => resolve_drive(given, true, context, reader),
        (None, None) => Some(Drive::default()),
    };
    let translation = pair(&file.velocity, &file.acceleration, reader);
    let rotation = pair(&file.angular_velocity, &file.angular_acceleration, reader);
    let inertial = file.axes == Some(AxesFile::Inertial);
    Some(BaseMotion { translation: translation?, rotation: rotation?, inertial })
}

fn resolve_drive(
    file: &DriveFile,
    acceleration: bool,
    context: &LoadContext<'_>,
    reader: &mut Reader,
) -> Option<Drive> {
    let components = [&file.x, &file.y, &file.z].map(|component| match component {
        None => Some(None),
        Some(given) => resolve_component(given, acceleration, context, reader).map(Some),
    });
    let [x, y, z] = components;
    Some(Drive { acceleration, components: [x?, y?, z?] })
}

fn resolve_component(
    file: &ComponentFile,
    acceleration: bool,
    context: &LoadContext<'_>,
    reader: &mut Reader,
) -> Option<TimeFunction> {
    let function = match &file.value {
        ComponentValue::Constant(value) => TimeFunction::Constant { value: *value },
        ComponentValue::Time(time) => context.time(time, reader)?,
    };
    if !function.is_of_time_alone() {
        let message = "the motion of A cannot depend on itself: this expression has other variables than t";
        return reader.error(file.span, message);
    }
    if !acceleration && function.largest_jump() > JUMP {
        let message = format!("this velocity jumps by {}, which no force can do", function.largest_jump());
        return reader.error_help(file.span, message, "use a ramp or a table, or give the acceleration");
    }
    Some(function)
}

/// Checks the start of a load case.
pub(crate) fn resolve_initial(
    file: &InitialFile,
    motion: Option<&MotionFile>,
    cases: &Named<LoadCaseFile>,
    context: &LoadContext<'_>,
    reader: &mut Reader,
) -> Option<InitialState> {
    if let Some(motion) = motion {
        let pairs = [
            (&file.velocity, motion.acceleration.is_some()),
            (&file.angular_velocity, motion.angular_acceleration.is_some()),
        ];
        for (given, starts_from_it) in pairs {
            if let (Some(given), false) = (given, starts_from_it) {
                let message = "the motion of A says what this velocity is, from t = 0 on";
                let help = "leave it out, or give the motion by its acceleration";
                reader.error_help::<()>(given.span, message, help);
            }
        }
    }
    let (mut shape, mut distributed) = (Vec::new(), Vec::new());
    if let Some(name) = &file.shape_of {
        let index = cases.find(name, "load case", "load cases", reader)?;
        let case = cases.items[index].1.as_ref();
        let loads = case.and_then(|case| case.loads.as_ref());
        // What is wrong with these is said where they are.
        let mut quiet = Reader::new(&reader.source, reader.parameters, Vec::new());
        shape.extend(context.loads(loads.map_or(&[], |list| &list.items), &mut quiet).unwrap_or_default());
        let spread = case.and_then(|case| case.distributed_loads.as_ref());
        distributed.extend(context.distributed(spread, &mut quiet).unwrap_or_default());
    }
    if let Some(loads) = &file.shape_loads {
        shape.extend(context.loads(&loads.items, reader)?);
    }
    distributed.extend(context.distributed(file.shape_distributed_loads.as_ref(), reader)?);
    let numbers = |list: &Option<List<Number>>| -> Option<Vec<f64>> {
        list.iter().flat_map(|list| &list.items).map(|n| n.as_ref().map(|n| n.value)).collect()
    };
    Some(InitialState {
        attitude: file.attitude.as_ref().map(|attitude| scalar_first(&attitude.quaternion())),
        position: file.position.as_ref().map(|p| p.value.into()),
        velocity: file.velocity.as_ref().map(|v| v.value.into()),
        angular_velocity: file.angular_velocity.as_ref().map(|w| w.value.into()),
        inertial: file.axes == Some(AxesFile::Inertial),
        amplitudes: numbers(&file.amplitudes)?,
        rates: numbers(&file.rates)?,
        shape,
        shape_distributed: distributed,
    })
}
