//! Checks of everything a model file can say, so that nothing after [`crate::Model::new`] has to doubt it.

mod cuts;
mod lagrangian;

use alloc::{
    borrow::ToOwned,
    format,
    string::{String, ToString},
    vec::Vec,
};

use crate::base_motion::BaseMotion;
use crate::data::{
    DampingData, LineData, ModelData, ModesData, PictureData, PointData, RigidData, StationSet, StationsData,
    TensorData, ValidityData,
};
use crate::error::ModelError;
use crate::loads::{DistributedLoad, InitialState, Load, LoadCase, LoadFrame};
use crate::time::TimeFunction;

/// Most elastic modes a model may have: bounds the work done before the first step.
pub(crate) const MAX_MODES: usize = 4096;
/// How far a stored rotation may be from orthonormal: files hold rounded numbers, not wrong ones.
const ROTATION_TOLERANCE: f64 = 1e-9;
/// Jump of a velocity that is rounding, m/s or rad/s.
const JUMP: f64 = 1e-9;
/// How far `M_RR` may be from the mass and centre of mass stored beside it, relative.
const INERTIA_TOLERANCE: f64 = 1e-6;

type Check = Result<(), ModelError>;

/// Everything but the positive definiteness of `M_RR`, which its factorisation finds.
pub(crate) fn model(data: &ModelData) -> Check {
    let m = data.modes.omega.len();
    modes(&data.modes, residual(data)?)?;
    rigid(&data.rigid)?;
    tensor("tensor c", &data.c, m + 6, m + 6, |r| r < 6, "r < 6")?;
    tensor("tensor k", &data.k, m + 6, m, |rs| rs < 36 && rs / 6 <= rs % 6, "r * 6 + s with r <= s < 6")?;
    for (index, point) in data.points.iter().enumerate() {
        self::point(index, point, m)?;
    }
    names("point", data.points.iter().map(|point| point.name.as_str()))?;
    names("line", data.lines.iter().map(|line| line.name.as_str()))?;
    for line in &data.lines {
        self::line(line, m)?;
    }
    names("block of stations", data.stations.iter().map(|block| block.name.as_str()))?;
    for block in &data.stations {
        self::block(block, m)?;
    }
    names("load case", data.load_cases.iter().map(|case| case.name.as_str()))?;
    for case in &data.load_cases {
        load_case(case, data.points.len(), &data.lines)?;
    }
    if let Some(picture) = &data.picture {
        self::picture(picture, m)?;
    }
    if let Some(curve) = &data.picture_curve {
        let nodes = data.picture.as_ref().map_or(0, |picture| picture.positions.len() / 3);
        lagrangian::picture_curve(curve, nodes, m)?;
    }
    if let Some(trim) = &data.trim {
        array("elastic_force of the trim", &trim.elastic_force, m)?;
        finite_at(|| "elastic_energy of the trim".to_owned(), 0, trim.elastic_energy)?;
        unit_quaternion("squared length of the attitude of the trim", &trim.attitude)?;
        array("reaction of the trim", &trim.reaction, 6)?;
        array("scales of the trim", &trim.scales, 2)?;
        shape("displacements of the trim", trim.displacements.len(), data.points.len())?;
        array("displacements of the trim", trim.displacements.as_flattened(), 3 * data.points.len())?;
        for (index, (name, factor)) in trim.factors.iter().enumerate() {
            finite_at(|| format!("factor on \"{name}\" of the trim"), index, *factor)?;
        }
        let loads = trim.loads.len() + trim.distributed.len();
        if !trim.load_names.is_empty() {
            shape("load_names of the trim", trim.load_names.len(), loads)?;
        }
        for (index, trim) in trim.loads.iter().enumerate() {
            load(&format!("load {} of the trim", index + 1), trim, data.points.len())?;
        }
        for (index, trim) in trim.distributed.iter().enumerate() {
            distributed(&format!("distributed load {} of the trim", index + 1), trim, &data.lines)?;
        }
    }
    let sets = data.lines.iter().map(|line| &line.stations);
    let sets = sets.chain(data.stations.iter().map(|block| &block.sections));
    let places = data.points.len() + sets.map(StationSet::len).sum::<usize>();
    if let Some(it) = &data.lagrangian {
        lagrangian::lagrangian(it, m, places)?;
    }
    names("place of internal loads", data.cuts.iter().map(|cut| cut.name.as_str()))?;
    for cut in &data.cuts {
        cuts::cut(cut, m, places)?;
    }
    if let Some(gravity) = &data.gravity {
        array("acceleration of gravity", &gravity.acceleration, 3)?;
        let expected = if gravity.second_moment.is_empty() { 0 } else { 3 * m * m };
        array("second_moment of gravity", &gravity.second_moment, expected)?;
    }
    if let Some(validity) = &data.validity {
        self::validity(validity, m, data.points.len(), &data.lines)?;
    }
    if let Some(selection) = &data.selection {
        every("target of the selection", &[selection.target], |x| x > 0.0, "more than zero")?;
        let errors: Vec<f64> = selection.errors.iter().map(|(_, error)| *error).collect();
        every("error of the selection", &errors, |x| x >= 0.0, "zero or more")?;
    }
    if let Some(damping) = &data.damping {
        self::damping(&data.modes, damping)?;
    }
    if let Some(clamped) = &data.clamped {
        array("participation of the clamped modes", &clamped.participation, 6 * m)?;
        every(
            "phi_r of a clamped structure",
            &data.modes.phi_r,
            |x| x == 0.0,
            "zero: A is held in its modes",
        )?;
    }
    names("sensor", data.sensors.iter().map(|sensor| sensor.name.as_str()))?;
    for sensor in &data.sensors {
        indices(&format!("point of sensor \"{}\"", sensor.name), &[sensor.point], data.points.len())?;
        rotation_matrix(&format!("axes of sensor \"{}\"", sensor.name), &sensor.axes)?;
    }
    for (index, (name, value)) in data.provenance.parameters.iter().enumerate() {
        finite_at(|| format!("parameter {name}"), index, *value)?;
    }
    for (index, check) in data.checks.iter().enumerate() {
        finite_at(|| format!("check \"{}\"", check.name), index, check.value)?;
        finite_at(|| format!("limit of check \"{}\"", check.name), index, check.limit)?;
    }
    Ok(())
}

fn validity(validity: &ValidityData, m: usize, n_points: usize, lines: &[LineData]) -> Check {
    indices("modes of the validity", &[validity.modes], m + 1)?;
    let kept = validity.modes as usize;
    let pairs = kept * (kept + 1) / 2;
    array("fields of the validity", &validity.fields, pairs * (13 + m))?;
    shape("points of the validity", validity.points.len(), n_points)?;
    for (index, shapes) in validity.points.iter().enumerate() {
        array(&format!("second derivatives at point {index} of the validity"), shapes, 6 * pairs)?;
    }
    array("amplitude of the validity", &validity.amplitude, 2 * m)?;
    every("amplitude of the validity", &validity.amplitude, |x| x >= 0.0, "zero or more")?;
    array("stiffening of the validity", &validity.stiffening, 3 * m)?;
    every("stiffening of the validity", &validity.stiffening, |x| x >= 0.0, "zero or more")?;
    if let Some(curve) = &validity.curve {
        self::lagrangian::curve_validity(curve, m, n_points)?;
    }
    let loaded = &validity.missing.loaded;
    indices("loaded points of the validity", loaded, n_points)?;
    array(
        "residual flexibility of the validity",
        &validity.missing.flexibility,
        36 * loaded.len() * n_points,
    )?;
    array("rigid part of the residual flexibility", &validity.missing.rigid, 36 * loaded.len())?;
    let sources = validity.missing.n_sources();
    for (index, line) in validity.missing.lines.iter().enumerate() {
        let what = format!("load per length {} of the validity", index + 1);
        on_stations(&what, line.member, &line.force, &line.moment, lines)?;
        let columns = line.columns();
        array(&format!("residual flexibility of {what}"), &line.flexibility, 6 * columns * n_points)?;
        array(&format!("rigid part of {what}"), &line.rigid, 6 * columns)?;
        array(&format!("readings of {what}"), &line.readings, line.n_readings(m) * sources)?;
        array(&format!("curvature of {what}"), &line.curvature, line.n_curvature() * pairs)?;
    }
    Ok(())
}

/// Number of residual modes.
fn residual(data: &ModelData) -> Result<usize, ModelError> {
    let Some(residual) = &data.residual else { return Ok(0) };
    let m = data.modes.omega.len();
    indices("number of residual modes", &[residual.count], m + 1)?;
    for (index, load) in residual.loads.iter().enumerate() {
        indices(&format!("point of residual load {index}"), &[load.point], data.points.len())?;
        indices(&format!("axis of residual load {index}"), &[load.axis], 3)?;
        every(
            &format!("share missed of residual load {index}"),
            &[load.missed],
            |share| (0.0..=1.0).contains(&share),
            "from 0 to 1",
        )?;
    }
    Ok(residual.count as usize)
}

/// The last `residual` of them are residual modes, with frequencies in an order of their own.
fn modes(modes: &ModesData, residual: usize) -> Check {
    let m = modes.omega.len();
    if m > MAX_MODES {
        return Err(ModelError::Index {
            what: "number of elastic modes".to_owned(),
            index: 0,
            found: m,
            limit: MAX_MODES + 1,
        });
    }
    shape("number of modes", modes.number.len(), m)?;
    positive("omega of modes", &modes.omega)?;
    array("generalised mass", &modes.mass, m)?;
    positive("generalised mass", &modes.mass)?;
    array("damping ratio", &modes.damping_ratio, m)?;
    every("damping ratio", &modes.damping_ratio, |x| x >= 0.0, "zero or more")?;
    array("phi_r", &modes.phi_r, 6 * m)?;
    array("first_moment", &modes.first_moment, 3 * m)?;
    array("kinetic_share", &modes.kinetic_share, 6 * m)?;
    if let Some(next) = modes.next_omega {
        positive("next_omega", &[next])?;
    }
    let (own, added) =
        modes.omega.split_at_checked(m.saturating_sub(residual)).unwrap_or((&modes.omega, &[]));
    ordered("omega of modes", own.windows(2), "ascending frequency", |a, b| a <= b)?;
    ordered("omega of residual modes", added.windows(2), "ascending frequency", |a, b| a <= b)?;
    ordered("number of modes", modes.number.windows(2), "ascending, without repetition", |a, b| a < b)
}

/// The diagonal is that of the ratios: every pair of modes has to lose energy.
fn damping(modes: &ModesData, damping: &DampingData) -> Check {
    let m = modes.omega.len();
    let what = "damping coupling";
    array(what, &damping.coupling, m * m)?;
    let own = |i: usize| {
        let mode = modes.omega.get(i).zip(modes.mass.get(i)).zip(modes.damping_ratio.get(i));
        mode.map_or(0.0, |((omega, mass), ratio)| 2.0 * ratio * omega * mass)
    };
    for (index, &found) in damping.coupling.iter().enumerate() {
        let (i, j) = (index / m, index % m);
        let mirrored = damping.coupling.get(j * m + i).copied().unwrap_or(0.0);
        let most = if i == j { 0.0 } else { libm::sqrt(own(i) * own(j)) };
        if found != mirrored || found.abs() > most * (1.0 + 1e-9) {
            let expected = "symmetric, zero on the diagonal, at most the root of the product of the two modes' own damping";
            return Err(ModelError::Value { what: what.to_owned(), index, found, expected });
        }
    }
    Ok(())
}

fn rigid(rigid: &RigidData) -> Check {
    positive("mass", &[rigid.mass])?;
    array("centre_of_mass", &rigid.centre_of_mass, 3)?;
    array("initial_position", &rigid.initial_position, 3)?;
    array("mass_matrix", &rigid.mass_matrix, 36)?;
    let (mass, [x, y, z]) = (rigid.mass, rigid.centre_of_mass);
    // M_RR = [[m I, -m c~], [m c~, J]]: the translation rows must say the same as mass and centre of mass.
    let expected = [
        [mass, 0.0, 0.0, 0.0, mass * z, -mass * y],
        [0.0, mass, 0.0, -mass * z, 0.0, mass * x],
        [0.0, 0.0, mass, mass * y, -mass * x, 0.0],
    ];
    for (index, (&found, expected)) in rigid.mass_matrix.iter().zip(expected.iter().flatten()).enumerate() {
        let inertia =
            [21, 28, 35].iter().filter_map(|&i| rigid.mass_matrix.get(i)).fold(0.0, |a: f64, b| a.max(*b));
        let scale = if index % 6 < 3 { mass } else { libm::sqrt(mass * inertia.max(0.0)) };
        if (found - expected).abs() > INERTIA_TOLERANCE * scale {
            return Err(ModelError::Value {
                what: "mass_matrix".to_owned(),
                index,
                found,
                expected: "[m I, -m c~] in its first three rows, with the mass m and centre of mass c stored beside it",
            });
        }
    }
    Ok(())
}

fn tensor(
    name: &str,
    tensor: &TensorData,
    rows: usize,
    columns: usize,
    velocity: impl Fn(u32) -> bool,
    expected: &'static str,
) -> Check {
    let nnz = tensor.value.len();
    array(name, &tensor.value, nnz)?;
    for (index, what) in [(&tensor.i, "i"), (&tensor.l, "l"), (&tensor.r, "r")] {
        shape(&format!("{name}, index {what}"), index.len(), nnz)?;
    }
    indices(&format!("{name}, index i"), &tensor.i, rows)?;
    indices(&format!("{name}, index l"), &tensor.l, columns)?;
    if let Some((index, &found)) = tensor.r.iter().enumerate().find(|&(_, &r)| !velocity(r)) {
        return Err(ModelError::Value {
            what: format!("{name}, index r"),
            index,
            found: f64::from(found),
            expected,
        });
    }
    let keys = tensor.i.iter().zip(&tensor.l).zip(&tensor.r);
    if let Some(index) = keys.clone().zip(keys.skip(1)).position(|(a, b)| a >= b) {
        return Err(ModelError::Order {
            what: name.to_owned(),
            index: index + 1,
            expected: "entries sorted by i, then l, then r, without repetition",
        });
    }
    every(name, &[tensor.threshold, tensor.dropped_norm], |x| x >= 0.0 && x.is_finite(), "zero or more")
}

fn point(index: usize, point: &PointData, m: usize) -> Check {
    let what = |part: &str| format!("{part} of point {index} \"{}\"", point.name);
    array(&what("node_position"), &point.node_position, 3)?;
    array(&what("node_rotation"), &point.node_rotation, 4)?;
    unit_quaternion(&what("squared length of node_rotation"), &point.node_rotation)?;
    array(&what("offset"), &point.offset, 3)?;
    array(&what("phi_translation"), &point.phi_translation, 3 * m)?;
    array(&what("phi_rotation"), &point.phi_rotation, 3 * m)?;
    for (member, section) in &point.sections {
        rotation_matrix(&what(&format!("section frame of member \"{member}\"")), section)?;
    }
    Ok(())
}

fn picture(picture: &PictureData, m: usize) -> Check {
    let nodes = picture.positions.len() / 3;
    array("picture positions", &picture.positions, 3 * nodes)?;
    array("picture phi_translation", &picture.phi_translation, 3 * nodes * m)?;
    for (line, nodes_of_line) in picture.lines.iter().enumerate() {
        indices(&format!("picture line {line}"), nodes_of_line, nodes)?;
    }
    Ok(())
}

fn line(line: &LineData, m: usize) -> Check {
    let what = |part: &str| format!("{part} of line \"{}\"", line.name);
    positive(&what("length"), &[line.length])?;
    let elements = line.knots.len().saturating_sub(1);
    array(&what("knots"), &line.knots, elements.max(1) + 1)?;
    ordered(&what("knots"), line.knots.windows(2), "ascending fractions", |a, b| a < b)?;
    let ends = [line.knots.first(), line.knots.last()].map(|x| x.copied().unwrap_or(f64::NAN));
    every(&what("first knot"), &ends[..1], |x| x == 0.0, "0")?;
    every(&what("last knot"), &ends[1..], |x| x == 1.0, "1")?;
    if !line.stations.is_empty() {
        shape(&what("number of stations"), line.stations.len(), 3 * elements)?;
    }
    stations(&what("stations"), &line.stations, m)
}

fn block(block: &StationsData, m: usize) -> Check {
    let what = |part: &str| format!("{part} of stations \"{}\"", block.name);
    let n = block.sections.len();
    every(&what("number"), &[n as f64], |n| n > 0.0, "at least one station")?;
    let counted = block.members.iter().map(|(_, count)| *count as usize).sum();
    shape(&what("stations of the members"), counted, n)?;
    array(&what("fraction"), &block.fraction, n)?;
    every(&what("fraction"), &block.fraction, |f| (0.0..=1.0).contains(&f), "from 0 to 1")?;
    array(&what("offset"), &block.offset, 3 * n)?;
    stations(&what("sections"), &block.sections, m)
}

/// Arrays of one length, with unit quaternions.
fn stations(of: &str, set: &StationSet, m: usize) -> Check {
    let n = set.len();
    array(&format!("position of {of}"), &set.position, 3 * n)?;
    array(&format!("rotation of {of}"), &set.rotation, 4 * n)?;
    for rotation in set.rotation.as_chunks::<4>().0 {
        unit_quaternion(&format!("squared length of a rotation of {of}"), rotation)?;
    }
    array(&format!("phi_translation of {of}"), &set.phi_translation, 3 * n * m)?;
    array(&format!("phi_rotation of {of}"), &set.phi_rotation, 3 * n * m)
}

/// A load case on its own, for a model with `n_points` points and these lines.
pub(crate) fn load_case(case: &LoadCase, n_points: usize, lines: &[LineData]) -> Check {
    let what = |part: &str| format!("{part} of load case \"{}\"", case.name);
    positive(&what("t_end"), &[case.t_end])?;
    positive(&what("dt"), &[case.dt])?;
    every(
        &what("numerical_damping"),
        &[case.numerical_damping],
        |a| (0.0..=1.0).contains(&a),
        "from 0 to 1",
    )?;
    for (index, load) in case.loads.iter().enumerate() {
        self::load(&what(&format!("load {index}")), load, n_points)?;
    }
    for (index, load) in case.distributed.iter().enumerate() {
        distributed(&what(&format!("distributed load {index}")), load, lines)?;
    }
    if let Some(motion) = &case.motion {
        base_motion(&what("motion"), motion)?;
    }
    let Some(initial) = &case.initial else { return Ok(()) };
    initial_state(&what("initial"), initial, case, n_points, lines)
}

/// Functions of time alone, and velocities that do not jump.
fn base_motion(what: &str, motion: &BaseMotion) -> Check {
    for (part, drive) in [("translation", &motion.translation), ("rotation", &motion.rotation)] {
        for (index, function) in drive.components.iter().enumerate() {
            let Some(function) = function else { continue };
            let what = format!("{part} in the {what}");
            time_function(&what, function)?;
            let (found, expected) = if !function.is_of_time_alone() {
                (f64::NAN, "a function of the time alone")
            } else if !drive.acceleration && function.largest_jump() > JUMP {
                (function.largest_jump(), "a velocity without jumps (a ramp, or an acceleration)")
            } else {
                continue;
            };
            return Err(ModelError::Value { what, index, found, expected });
        }
    }
    Ok(())
}

fn initial_state(
    what: &str,
    initial: &InitialState,
    case: &LoadCase,
    n_points: usize,
    lines: &[LineData],
) -> Check {
    let part = |part: &str| format!("{part} of {what}");
    if let Some(attitude) = &initial.attitude {
        unit_quaternion(&part("squared length of the attitude"), attitude)?;
    }
    array(
        &part("position"),
        initial.position.as_slice().as_flattened(),
        3 * initial.position.iter().count(),
    )?;
    let given =
        case.motion.as_ref().map(|motion| (motion.translation.acceleration, motion.rotation.acceleration));
    let velocities = [
        ("velocity", &initial.velocity, given.is_some_and(|given| !given.0)),
        ("angular_velocity", &initial.angular_velocity, given.is_some_and(|given| !given.1)),
    ];
    for (name, velocity, prescribed) in velocities {
        let Some(velocity) = velocity else { continue };
        array(&part(name), velocity, 3)?;
        if prescribed {
            let (what, expected) = (part(name), "none where the motion of A gives it");
            return Err(ModelError::Value { what, index: 0, found: velocity[0], expected });
        }
    }
    array(&part("amplitudes"), &initial.amplitudes, initial.amplitudes.len())?;
    array(&part("rates"), &initial.rates, initial.rates.len())?;
    for (index, load) in initial.shape.iter().enumerate() {
        self::load(&part(&format!("load {index} of the shape")), load, n_points)?;
    }
    for (index, load) in initial.shape_distributed.iter().enumerate() {
        distributed(&part(&format!("distributed load {index} of the shape")), load, lines)?;
    }
    Ok(())
}

fn load(what: &str, load: &Load, n_points: usize) -> Check {
    indices(&format!("point of {what}"), &[load.point], n_points)?;
    array(&format!("force of {what}"), &load.force, 3)?;
    array(&format!("moment of {what}"), &load.moment, 3)?;
    if let LoadFrame::Follower { section } = &load.frame {
        rotation_matrix(&format!("section frame of {what}"), section)?;
    }
    time_function(&format!("time function of {what}"), &load.time)
}

fn distributed(what: &str, load: &DistributedLoad, lines: &[LineData]) -> Check {
    on_stations(what, load.member, &load.force, &load.moment, lines)?;
    time_function(&format!("time function of {what}"), &load.time)
}

/// Vectors on the stations of a member.
fn on_stations(what: &str, member: u32, force: &[f64], moment: &[f64], lines: &[LineData]) -> Check {
    indices(&format!("member of {what}"), &[member], lines.len())?;
    if let Some(line) = lines.get(member as usize) {
        let n = 3 * line.stations.len();
        if n == 0 {
            return Err(ModelError::NoStations { what: what.to_owned(), member: line.name.clone() });
        }
        for (part, values) in [("force", force), ("moment", moment)] {
            array(&format!("{part} of {what}"), values, if values.is_empty() { 0 } else { n })?;
        }
    }
    Ok(())
}

fn time_function(what: &str, time: &TimeFunction) -> Check {
    let values: &[f64] = match *time {
        TimeFunction::Constant { value } => &[value],
        TimeFunction::Step { value, start, end } => &[value, start, end],
        TimeFunction::Ramp { rate, start, end } => &[rate, start, end],
        TimeFunction::Triangle { peak, start, at, end } => &[peak, start, at, end],
        TimeFunction::Sine { amplitude, omega, phase, start, end } => &[amplitude, omega, phase, start, end],
        TimeFunction::OneMinusCosine { amplitude, start, duration } => &[amplitude, start, duration],
        TimeFunction::Table { ref value, .. } => value,
        TimeFunction::Expression { .. } => &[],
    };
    array(what, values, values.len())?;
    match time {
        TimeFunction::Step { start, end, .. }
        | TimeFunction::Ramp { start, end, .. }
        | TimeFunction::Sine { start, end, .. } => {
            ordered(what, [[*start, *end]].iter().map(<[f64; 2]>::as_slice), "start <= end", |a, b| a <= b)
        }
        TimeFunction::Triangle { start, at, end, .. } => {
            let instants = [*start, *at, *end];
            ordered(what, instants.windows(2), "start <= at <= end", |a, b| a <= b)?;
            every(what, &[end - start], |length| length > 0.0, "start before end")
        }
        TimeFunction::OneMinusCosine { duration, .. } => {
            positive(&format!("duration of {what}"), &[*duration])
        }
        TimeFunction::Table { t, value } => {
            array(&format!("instants of the {what}"), t, t.len())?;
            shape(&format!("values of the {what}"), value.len(), t.len())?;
            every(&format!("length of the {what}"), &[t.len() as f64], |n| n > 0.0, "at least one instant")?;
            ordered(&format!("instants of the {what}"), t.windows(2), "strictly increasing", |a, b| a < b)
        }
        TimeFunction::Expression { program } => program.check().map_err(|problem| ModelError::Expression {
            what: what.to_owned(),
            expression: program.source.clone(),
            problem,
        }),
        TimeFunction::Constant { .. } => Ok(()),
    }
}

fn unit_quaternion(what: &str, quaternion: &[f64; 4]) -> Check {
    array(what, quaternion, 4)?;
    let found: f64 = quaternion.iter().map(|x| x * x).sum();
    if (found - 1.0).abs() > ROTATION_TOLERANCE {
        let (what, expected) = (what.to_owned(), "a unit quaternion");
        return Err(ModelError::Value { what, index: 0, found, expected });
    }
    Ok(())
}

/// A rotation matrix: rows orthonormal and right-handed.
pub(crate) fn rotation_matrix(what: &str, rows: &[[f64; 3]; 3]) -> Check {
    array(what, rows.as_flattened(), 9)?;
    let [a, b, c] = *rows;
    let deviations = [
        crate::math::dot(a, a) - 1.0,
        crate::math::dot(b, b) - 1.0,
        crate::math::dot(a, b),
        crate::math::dot(crate::math::cross(a, b), c) - 1.0,
    ];
    let found = deviations.iter().fold(0.0, |worst: f64, x| worst.max(x.abs()));
    if found > ROTATION_TOLERANCE {
        return Err(ModelError::Value {
            what: format!("deviation from a rotation matrix of the {what}"),
            index: 0,
            found,
            expected: "at most 1e-9",
        });
    }
    Ok(())
}

fn names<'a>(what: &'static str, names: impl Iterator<Item = &'a str> + Clone) -> Check {
    let mut seen = alloc::collections::BTreeSet::new();
    for (index, name) in names.enumerate() {
        if name.is_empty() || !seen.insert(name) {
            return Err(ModelError::Name { what, index, name: name.to_string() });
        }
    }
    Ok(())
}

fn shape(what: &str, found: usize, expected: usize) -> Check {
    if found == expected { Ok(()) } else { Err(ModelError::Shape { what: what.to_owned(), found, expected }) }
}

/// Right number of entries, all finite.
pub(crate) fn array(what: &str, values: &[f64], expected: usize) -> Check {
    shape(what, values.len(), expected)?;
    values.iter().enumerate().try_for_each(|(index, &value)| finite_at(|| what.to_owned(), index, value))
}

fn finite_at(what: impl FnOnce() -> String, index: usize, found: f64) -> Check {
    if found.is_finite() { Ok(()) } else { Err(ModelError::NotFinite { what: what(), index, found }) }
}

fn positive(what: &str, values: &[f64]) -> Check {
    array(what, values, values.len())?;
    every(what, values, |x| x > 0.0, "more than zero")
}

fn every(what: &str, values: &[f64], accept: impl Fn(f64) -> bool, expected: &'static str) -> Check {
    match values.iter().enumerate().find(|&(_, &value)| !accept(value)) {
        Some((index, &found)) => Err(ModelError::Value { what: what.to_owned(), index, found, expected }),
        None => Ok(()),
    }
}

fn indices(what: &str, indices: &[u32], limit: usize) -> Check {
    match indices.iter().enumerate().find(|&(_, &index)| index as usize >= limit) {
        Some((index, &found)) => {
            Err(ModelError::Index { what: what.to_owned(), index, found: found as usize, limit })
        }
        None => Ok(()),
    }
}

fn ordered<'a, T: Copy + 'a>(
    what: &str,
    mut neighbours: impl Iterator<Item = &'a [T]>,
    expected: &'static str,
    in_order: impl Fn(T, T) -> bool,
) -> Check {
    match neighbours.position(|pair| !matches!(pair, &[a, b] if in_order(a, b))) {
        Some(index) => Err(ModelError::Order { what: what.to_owned(), index: index + 1, expected }),
        None => Ok(()),
    }
}
