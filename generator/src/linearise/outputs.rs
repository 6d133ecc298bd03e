//! What is looked at: frame A, points, stations, sensors, modes, section forces, the wrench on what moves A. All vectors are components in A,
//! so that the matrices are constant while the body turns; those of sensors and sections in their own axes.

use nalgebra::{Quaternion, Vector3};
use rom_runtime::{Jacobian, Method, Model, SectionForces, StepError};

use super::inputs::{loaded_points, unknown};
use super::steady::At;
use super::{Channel, Column, Frame, LineariseError, Request};

/// A group of outputs.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Output {
    /// Velocity, angular velocity, turn and displacement of A.
    Frame,
    /// Displacement, velocity and acceleration of a named point.
    Point(usize),
    /// Displacement, turn and velocity of every station of a block.
    Stations(usize),
    /// What a sensor reads.
    Sensor(usize),
    /// Force and moment at a place of internal loads.
    Section(usize),
    /// Amplitudes and rates of the modes.
    Modes,
    /// Wrench on what moves A.
    Reaction,
}

/// The outputs asked for: `A`, points, blocks of stations, sensors, places of internal loads, `modes`, `reaction`. Without a wish A (or the
/// reaction, where A is moved), all sensors and places of internal loads, and the points that load cases load.
pub(super) fn select(model: &Model, request: &Request) -> Result<Vec<Output>, LineariseError> {
    let driven = model.is_clamped() || request.case.motion.is_some();
    let data = model.data();
    let Some(wanted) = &request.outputs else {
        let mut out = vec![if driven { Output::Reaction } else { Output::Frame }];
        out.extend((0..data.sensors.len()).map(Output::Sensor));
        out.extend((0..data.cuts.len()).map(Output::Section));
        out.extend(loaded_points(model).map(Output::Point));
        return Ok(out);
    };
    let mut out = Vec::new();
    for name in wanted {
        let before = out.len();
        if name == "A" {
            // The frame, whether or not a point has its name.
            out.push(Output::Frame);
            continue;
        }
        out.extend(data.points.iter().position(|point| point.name == *name).map(Output::Point));
        out.extend(data.stations.iter().position(|block| block.name == *name).map(Output::Stations));
        out.extend(data.sensors.iter().position(|sensor| sensor.name == *name).map(Output::Sensor));
        out.extend(data.cuts.iter().position(|cut| cut.name == *name).map(Output::Section));
        out.extend((name == "modes").then_some(Output::Modes));
        out.extend((name == "reaction" && driven).then_some(Output::Reaction));
        if out.len() == before {
            let all = ["A", "modes"].into_iter().chain(driven.then_some("reaction"));
            let points = data.points.iter().map(|point| point.name.as_str()).filter(|name| *name != "A");
            let sensors = data.sensors.iter().map(|sensor| sensor.name.as_str());
            let blocks = data.stations.iter().map(|block| block.name.as_str());
            let all = all.chain(points).chain(sensors).chain(model.section_names()).chain(blocks);
            return Err(unknown("output", name, all));
        }
    }
    Ok(out)
}

impl Output {
    pub(super) fn channels(&self, model: &Model) -> Vec<Channel> {
        let data = model.data();
        let all = |groups: Vec<[Channel; 3]>| groups.into_iter().flatten().collect::<Vec<Channel>>();
        match self {
            Output::Frame => all(vec![
                Channel::xyz("v_A", "m/s", "velocity of the origin of A, components in A"),
                Channel::xyz("w_A", "rad/s", "angular velocity of A, components in A"),
                Channel::xyz("theta_A", "rad", "small turn of A about its own axes"),
                Channel::xyz("r_A", "m", "displacement of the origin of A, components in A"),
            ]),
            Output::Point(index) => {
                let name = &data.points[*index].name;
                let of = |what: &str, unit, words: &str| {
                    Channel::xyz(
                        &format!("{name}.{what}"),
                        unit,
                        &format!("{words} of {name}, components in A"),
                    )
                };
                all(vec![
                    of("dR_A", "m", "displacement relative to A"),
                    of("v_A", "m/s", "inertial velocity"),
                    of("w_A", "rad/s", "angular velocity of the node"),
                    of("a_A", "m/s^2", "inertial acceleration"),
                    of("alpha_A", "rad/s^2", "angular acceleration of the node"),
                ])
            }
            Output::Sensor(index) => {
                let name = &data.sensors[*index].name;
                let of = |what: &str, unit, words: &str| {
                    Channel::xyz(
                        &format!("{name}.{what}"),
                        unit,
                        &format!("{words} that {name} reads, its axes"),
                    )
                };
                all(vec![
                    of("a", "m/s^2", "acceleration"),
                    of("w", "rad/s", "angular velocity"),
                    of("alpha", "rad/s^2", "angular acceleration"),
                ])
            }
            Output::Stations(block) => {
                let block = &data.stations[*block];
                // Shapes of stations are absolute there.
                let axes = if model.method() == Method::MeanAxes { "the mean axes" } else { "A" };
                let of_station = |k: usize| {
                    let name = format!("{}.{k}", block.name);
                    let of = |what: &str, unit, words: &str| {
                        let words = format!("{words} of station {name}, components in {axes}");
                        Channel::xyz(&format!("{name}.{what}"), unit, &words)
                    };
                    all(vec![
                        of("dR_A", "m", &format!("displacement relative to {axes}")),
                        of("theta_A", "rad", &format!("small turn relative to {axes} of the section")),
                        of("v_A", "m/s", "inertial velocity"),
                        of("w_A", "rad/s", "angular velocity of the section"),
                    ])
                };
                (1..=block.sections.len()).flat_map(of_station).collect()
            }
            Output::Section(index) => {
                let name = &data.cuts[*index].name;
                let words =
                    |what: &str| format!("{what} on the positive face of the section at {name}, its axes");
                all(vec![
                    Channel::xyz(&format!("{name}.F"), "N", &words("force")),
                    Channel::xyz(&format!("{name}.M"), "N m", &words("moment")),
                ])
            }
            Output::Modes => super::states(model, true),
            Output::Reaction => all(vec![
                Channel::xyz("reaction.F", "N", "force of the body on what moves A, components in A"),
                Channel::xyz(
                    "reaction.M",
                    "N m",
                    "moment of the same about the origin of A, components in A",
                ),
            ]),
        }
    }

    /// Along a column, with the section forces along it.
    pub(super) fn along(
        &self,
        model: &Model,
        jacobian: &mut Jacobian,
        frame: &Frame,
        column: &Column,
        sections: &[[f64; 6]],
    ) -> Vec<f64> {
        let m = model.n_modes();
        let along = column.direction(m);
        let theta = Vector3::from_row_slice(&column.state[2 * m + 6..2 * m + 9]);
        // Of a vector with the components `here` in G: components in A change as A turns besides.
        let in_a = |slope: [f64; 3], here: [f64; 3]| -> [f64; 3] {
            let turned = theta.cross(&frame.c.tr_mul(&Vector3::from(here)));
            (frame.c.tr_mul(&Vector3::from(slope)) - turned).into()
        };
        match self {
            Output::Frame => {
                let of = jacobian.rigid_output(along);
                let displacement: [f64; 3] = frame.c.tr_mul(&Vector3::from(of.r_g)).into();
                [of.v_a, of.w_a, theta.into(), displacement].concat()
            }
            Output::Point(index) => {
                let u_dot = jacobian.accelerations().to_vec();
                let here = model.point_motion(jacobian.state(), &u_dot, *index);
                let slopes = (jacobian.point_output(along, *index), jacobian.point_motion(along, *index));
                match (here, slopes) {
                    (Some(here), (Some(output), Some(motion))) => [
                        output.dr_a,
                        in_a(motion.v_g, here.v_g),
                        in_a(motion.w_g, here.w_g),
                        in_a(motion.a_g, here.a_g),
                        in_a(motion.alpha_g, here.alpha_g),
                    ]
                    .concat(),
                    // The index comes from the model.
                    _ => vec![f64::NAN; 15],
                }
            }
            Output::Stations(block) => {
                let u_dot = jacobian.accelerations().to_vec();
                let mut out = Vec::new();
                for station in 0..model.data().stations[*block].sections.len() {
                    let here = model.station_motion(jacobian.state(), &u_dot, *block, station);
                    let (Some(here), Some((motion, moved))) =
                        (here, jacobian.station_motion(along, *block, station))
                    else {
                        // The indices come from the model.
                        out.extend([f64::NAN; 12]);
                        continue;
                    };
                    let turn = frame.c.tr_mul(&spin(motion.attitude, here.attitude)) - theta;
                    out.extend(moved);
                    out.extend(turn.iter());
                    out.extend(in_a(motion.v_g, here.v_g));
                    out.extend(in_a(motion.w_g, here.w_g));
                }
                out
            }
            Output::Section(index) => sections[*index].to_vec(),
            Output::Sensor(index) => {
                let of = jacobian.sensor_reading(along, *index);
                of.map_or(vec![f64::NAN; 9], |of| [of.a, of.w, of.alpha].concat())
            }
            Output::Modes => column.state[..2 * m].to_vec(),
            Output::Reaction => column.reaction.to_vec(),
        }
    }
}

/// The small turn, in the axes turned into, of a quaternion (scalar first) that changes by `slope`.
fn spin(slope: [f64; 4], here: [f64; 4]) -> Vector3<f64> {
    let of = |[w, x, y, z]: [f64; 4]| Quaternion::new(w, x, y, z);
    2.0 * (of(slope) * of(here).conjugate()).imag()
}

/// Section forces along a column: as the state and its accelerations change, and what loads along it add.
pub(super) fn sections(model: &Model, at: &mut At, column: &Column) -> Result<Vec<[f64; 6]>, StepError> {
    let mut found = vec![SectionForces::default(); model.section_names().len()];
    at.jacobian.section_forces(column.direction(model.n_modes()), &at.loads, &mut found)?;
    let mut found: Vec<[f64; 6]> = found.iter().map(|section| section.best).collect();
    for (sum, of_loads) in found.iter_mut().zip(&column.sections) {
        sum.iter_mut().zip(of_loads).for_each(|(sum, x)| *sum += x);
    }
    Ok(found)
}
