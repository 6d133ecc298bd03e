//! What acts on the structure: wrenches on points and on A, factors on loads of the equilibrium, forces on the modes, and the
//! acceleration of A where it is moved.

use rom_runtime::loads::{DistributedLoad, Load};
use rom_runtime::time::TimeFunction;
use rom_runtime::{DistributedFrame, Jacobian, LoadCase, LoadFrame, LoadSet, Model, SectionForces};

use super::{Channel, Column, LineariseError, Request};

/// A group of inputs.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Input {
    /// Force and moment on a named point, components in A.
    Point(usize),
    /// Force on the origin of A and moment, components in A.
    Frame,
    /// Rate of the velocities of A, components in A, where something moves it.
    Rate,
    /// Factor on loads of the equilibrium.
    Factor(String),
    /// Generalised forces on the modes.
    Modes,
    /// Force and moment on every station of a block, components in A.
    Stations(usize),
}

/// The inputs asked for: points, `A`, names of loads of the equilibrium, blocks of stations, `modes`. Without a wish the points that load cases load, A, and
/// all loads of the equilibrium.
pub(super) fn select(model: &Model, request: &Request) -> Result<Vec<Input>, LineariseError> {
    let driven = model.is_clamped() || request.case.motion.is_some();
    let frame = if driven { Input::Rate } else { Input::Frame };
    let data = model.data();
    let loads = names(model);
    let Some(wanted) = &request.inputs else {
        let mut out: Vec<Input> = loaded_points(model).map(Input::Point).collect();
        out.push(frame);
        out.extend(loads.into_iter().map(Input::Factor));
        return Ok(out);
    };
    let mut out = Vec::new();
    for name in wanted {
        let before = out.len();
        if name == "A" {
            // The frame, whether or not a point has its name.
            out.push(frame.clone());
            continue;
        }
        out.extend(data.points.iter().position(|point| point.name == *name).map(Input::Point));
        out.extend(loads.contains(name).then(|| Input::Factor(name.clone())));
        out.extend(data.stations.iter().position(|block| block.name == *name).map(Input::Stations));
        out.extend((name == "modes").then_some(Input::Modes));
        if out.len() == before {
            let points = data.points.iter().map(|point| point.name.as_str()).filter(|name| *name != "A");
            let all = ["A", "modes"].into_iter().chain(points).chain(loads.iter().map(String::as_str));
            let blocks = data.stations.iter().map(|block| block.name.as_str());
            return Err(unknown("input", name, all.chain(blocks)));
        }
    }
    Ok(out)
}

/// Points that some load case loads.
pub(super) fn loaded_points(model: &Model) -> impl Iterator<Item = usize> {
    let data = model.data();
    let loads = || data.load_cases.iter().flat_map(|case| &case.loads);
    (0..data.points.len()).filter(move |&i| loads().any(|load| load.point as usize == i))
}

/// Names of the loads of the equilibrium, each once.
pub(super) fn names(model: &Model) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for name in model.data().trim.iter().flat_map(|trim| &trim.load_names) {
        if !name.is_empty() && !out.contains(name) {
            out.push(name.clone());
        }
    }
    out
}

pub(super) fn unknown<'a>(
    what: &'static str,
    name: &str,
    available: impl Iterator<Item = &'a str>,
) -> LineariseError {
    let all: Vec<&str> = available.collect();
    LineariseError::Unknown { what, name: name.into(), available: all.join(", ") }
}

/// The loads of a name in the equilibrium, at a factor.
pub(super) fn of_name(model: &Model, name: &str, factor: f64) -> (Vec<Load>, Vec<DistributedLoad>) {
    let time = || TimeFunction::Constant { value: factor };
    let Some(trim) = &model.data().trim else { return (Vec::new(), Vec::new()) };
    let (points, members) = trim.load_names.split_at(trim.loads.len().min(trim.load_names.len()));
    let loads = trim.loads.iter().zip(points).filter(|(_, of)| *of == name);
    let distributed = trim.distributed.iter().zip(members).filter(|(_, of)| *of == name);
    (
        loads.map(|(load, _)| Load { time: time(), ..load.clone() }).collect(),
        distributed.map(|(load, _)| DistributedLoad { time: time(), ..load.clone() }).collect(),
    )
}

/// Along a factor on the loads of a name.
pub(super) fn factor_column(
    model: &Model,
    jacobian: &mut Jacobian,
    name: &str,
) -> Result<Column, LineariseError> {
    let (loads, distributed) = of_name(model, name, 1.0);
    // Every load case comes with the loads of the equilibrium: what it adds is the difference.
    let with = model.prepare(&LoadCase { loads, distributed, ..LoadCase::empty("equilibrium") })?;
    let mut column = load_column(jacobian, &with)?;
    column.add(-1.0, &load_column(jacobian, &model.prepare(&LoadCase::empty("equilibrium"))?)?);
    Ok(column)
}

/// Along a factor on loads.
pub(super) fn load_column(
    jacobian: &mut Jacobian,
    loads: &impl rom_runtime::Loads,
) -> Result<Column, LineariseError> {
    let n = jacobian.size();
    let mut rates = vec![0.0; n];
    let reaction = jacobian.by_load(loads, &mut rates)?;
    let mut sections = vec![SectionForces::default(); jacobian.model().section_names().len()];
    jacobian.section_forces_of_load(loads, &mut sections)?;
    let sections = sections.iter().map(|section| section.best).collect();
    Ok(Column { state: vec![0.0; n], rates, reaction, sections })
}

/// Along a component of a wrench on A, in A.
pub(super) fn wrench_column(
    model: &Model,
    jacobian: &mut Jacobian,
    component: usize,
) -> Result<Column, LineariseError> {
    let (force, moment) = unit(component);
    let mut set = LoadSet::new(model, &[])?;
    set.add_wrench(&LoadFrame::Body, force, moment);
    load_column(jacobian, &set)
}

fn unit(component: usize) -> ([f64; 3], [f64; 3]) {
    let one = |first: usize| std::array::from_fn(|k| f64::from(u8::from(first + k == component)));
    (one(0), one(3))
}

impl Input {
    pub(super) fn channels(&self, model: &Model) -> Vec<Channel> {
        let wrench = |of: &str, on: &str| {
            let force = Channel::xyz(&format!("{of}.F"), "N", &format!("force on {on}, components in A"));
            let moment = Channel::xyz(&format!("{of}.M"), "N m", &format!("moment on {on}, components in A"));
            force.into_iter().chain(moment).collect::<Vec<_>>()
        };
        match self {
            Input::Point(index) => {
                let name = &model.data().points[*index].name;
                wrench(name, name)
            }
            Input::Frame => wrench("A", "the origin of A"),
            Input::Rate => {
                let v = Channel::xyz(
                    "v_A_dot",
                    "m/s^2",
                    "rate of the velocity of the origin of A, components in A",
                );
                let w =
                    Channel::xyz("w_A_dot", "rad/s^2", "rate of the angular velocity of A, components in A");
                v.into_iter().chain(w).collect()
            }
            Input::Factor(name) => {
                vec![Channel::new(name, "1", format!("factor on the loads \"{name}\" of the equilibrium"))]
            }
            Input::Modes => {
                let of = |n: &u32| {
                    Channel::new(format!("f.{n}"), "N m", format!("generalised force on elastic mode {n}"))
                };
                model.data().modes.number.iter().map(of).collect()
            }
            Input::Stations(block) => {
                let block = &model.data().stations[*block];
                let names = (1..=block.sections.len()).map(|k| format!("{}.{k}", block.name));
                names.flat_map(|name| wrench(&name, &format!("station {name}"))).collect()
            }
        }
    }

    /// Along each of its inputs.
    pub(super) fn columns(
        &self,
        model: &Model,
        jacobian: &mut Jacobian,
    ) -> Result<Vec<Column>, LineariseError> {
        match self {
            Input::Point(index) => {
                let mut set = LoadSet::new(model, &[*index])?;
                let mut out = Vec::new();
                for (force, moment) in (0..6).map(unit) {
                    set.clear();
                    // The set has this slot.
                    let _ = set.add(0, &LoadFrame::Body, force, moment);
                    out.push(load_column(jacobian, &set)?);
                }
                Ok(out)
            }
            Input::Stations(block) => {
                let mut set = LoadSet::with_stations(model, &[], &[*block], None)?;
                let mut wrenches = vec![0.0; 6 * model.data().stations[*block].sections.len()];
                let mut out = Vec::with_capacity(wrenches.len());
                for k in 0..wrenches.len() {
                    wrenches.fill(0.0);
                    wrenches[k] = 1.0;
                    // As many wrenches as stations.
                    let _ = set.set_stations(0, DistributedFrame::Body, &wrenches);
                    out.push(load_column(jacobian, &set)?);
                }
                Ok(out)
            }
            Input::Frame => (0..6).map(|k| wrench_column(model, jacobian, k)).collect(),
            Input::Rate => {
                let n = jacobian.size();
                let mut of = |k: usize| {
                    let mut rates = vec![0.0; n];
                    let reaction = jacobian.by_rate(k, &mut rates)?;
                    Ok(Column { state: vec![0.0; n], rates, reaction, sections: Vec::new() })
                };
                (0..6).map(&mut of).collect()
            }
            Input::Factor(name) => Ok(vec![factor_column(model, jacobian, name)?]),
            Input::Modes => {
                let m = model.n_modes();
                let mut set = LoadSet::new(model, &[])?;
                let mut out = Vec::new();
                for mode in 0..m {
                    let mut forces = vec![0.0; m];
                    forces[mode] = 1.0;
                    set.clear();
                    // As many forces as modes.
                    let _ = set.add_modal(&forces);
                    out.push(load_column(jacobian, &set)?);
                }
                Ok(out)
            }
        }
    }
}
