//! The simulation of an instance: its loads, its outputs, and steps of any length made of internal ones.

use std::sync::Arc;

use rom_runtime::data::TrimData;
use rom_runtime::loads::LoadCase;
use rom_runtime::{
    LoadSet, Loads, Method, Model, PointMotion, PreparedLoads, SensorReading, Settings, Simulation, State,
    StationAxes, StationMotion, Stations, attitude_rate,
};

use crate::derivatives::Derivatives;
use crate::parameters::{DEFAULT_DT, Parameters};
use crate::variables::{InputBlock, Role};

/// How far a communication step may miss a whole number of internal steps and still be made of them, in steps: what
/// rounding does to times.
pub(crate) const WHOLE: f64 = 1e-6;

/// A simulation under the parameters of the instance.
pub(crate) struct Run {
    model: Arc<Model>,
    settings: Settings,
    gravity: [f64; 3],
    pub(crate) simulation: Simulation,
    /// For the last step of another length than `dt`: that length and a simulation with it.
    odd: Option<(f64, Simulation)>,
    case: PreparedLoads,
    /// The load case and the inputs. Used only where an input is not zero: without, results are those of `romrun` to the bit.
    set: LoadSet,
    /// Whether no step has been made since the start: its accelerations are to be those under the inputs of the first one.
    pub(crate) fresh: bool,
    /// Inputs of the last step, under which the accelerations of the simulation are.
    pub(crate) held: Vec<f64>,
    /// The same state under the inputs of now, where they are others.
    probe: Option<Box<Probe>>,
    derivatives: Option<Box<Derivatives>>,
    /// The outputs read last, until state or inputs change: hosts read them one component after the other.
    read: Option<(Group, [f64; LARGEST])>,
    stations: Vec<Block>,
}

/// A block of stations.
struct Block {
    stations: Stations,
    /// What they do, in the order of the outputs; empty where state or inputs have changed since.
    values: Vec<f64>,
}

/// A simulation that is never stepped.
struct Probe {
    simulation: Simulation,
    state: State,
    /// Whether it is where the simulation and the inputs are.
    current: bool,
}

/// Outputs that are computed together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group {
    Frame,
    Ledger,
    Point(usize),
    PointMotion(usize),
    Sensor(usize),
    Section(usize),
    FrameRates,
    Reaction,
}

/// Components of the largest group.
const LARGEST: usize = 19;

impl Run {
    pub(crate) fn new(
        file: &Arc<Model>,
        parameters: &Parameters,
        stations: &[usize],
        time: f64,
    ) -> Result<Self, String> {
        let model = simplified(file, parameters)?;
        let case = load_case(file, parameters)?;
        let integrator = parameters.integrator()?;
        let numerical_damping = match parameters.numerical_damping {
            own if own >= 0.0 => own,
            // That of the load case is meant for the integrators that have one to adjust.
            _ if integrator.has_numerical_damping() => case.numerical_damping,
            _ => 0.0,
        };
        let dt = if parameters.dt == 0.0 { case.dt } else { parameters.dt };
        let settings = Settings { dt, integrator, numerical_damping, ..Settings::default() };
        let points: Vec<usize> = (0..model.n_points()).collect();
        let mut state = if parameters.initial == Parameters::of(file).initial {
            model.initial_state(&case).map_err(|e| e.to_string())?
        } else {
            initial_state(&model, parameters)?
        };
        state.time = time;
        let mut run = Run {
            simulation: Simulation::new(Arc::clone(&model), settings).map_err(|e| e.to_string())?,
            odd: None,
            case: model.prepare(&case).map_err(|e| e.to_string())?,
            set: LoadSet::with_stations(&model, &points, stations, Some(&case)).map_err(|e| e.to_string())?,
            gravity: parameters.gravity,
            fresh: true,
            held: Vec::new(),
            probe: None,
            derivatives: None,
            read: None,
            stations: stations.iter().map(|block| Block::new(&model, *block)).collect::<Result<_, _>>()?,
            settings,
            model,
        };
        if run.gravity != run.model.gravity() {
            run.simulation.set_gravity(run.gravity).map_err(|e| e.to_string())?;
        }
        run.simulation.restore(&state).map_err(|e| e.to_string())?;
        Ok(run)
    }

    /// Internal time step, s.
    pub(crate) fn dt(&self) -> f64 {
        self.settings.dt
    }

    /// The state with the accelerations under the inputs of now, and the loads: the simulation itself where they are those of the last
    /// step.
    fn settled(
        &mut self,
        anew: bool,
        blocks: &[InputBlock],
        inputs: &[f64],
    ) -> Result<(&mut Simulation, &dyn Loads), String> {
        let changed = !self.fresh && self.held != inputs;
        let loads = acting(&mut self.set, &self.case, blocks, inputs);
        if !(changed || anew) {
            self.simulation.solve_accelerations(loads).map_err(|e| e.to_string())?;
            return Ok((&mut self.simulation, loads));
        }
        let simulation = &self.simulation;
        let new = || {
            Box::new(Probe {
                simulation: simulation.clone(),
                state: simulation.state().clone(),
                current: false,
            })
        };
        let probe = self.probe.get_or_insert_with(new);
        if !probe.current {
            probe.state.clone_from(simulation.state());
            probe.state.accelerations_known = false;
            probe.simulation.restore(&probe.state).map_err(|e| e.to_string())?;
            probe.simulation.solve_accelerations(loads).map_err(|e| e.to_string())?;
            probe.current = true;
        }
        Ok((&mut probe.simulation, loads))
    }

    pub(crate) fn outputs(
        &mut self,
        group: Group,
        blocks: &[InputBlock],
        inputs: &[f64],
    ) -> Result<&[f64; LARGEST], String> {
        if !matches!(&self.read, Some((known, _)) if *known == group) {
            let found = match group {
                Group::Frame | Group::Ledger | Group::Point(_) => outputs(&mut self.simulation, None, group),
                _ => {
                    // The simulation does not keep the reaction of a state that it was set to.
                    let (simulation, loads) = self.settled(group == Group::Reaction, blocks, inputs)?;
                    outputs(simulation, Some(loads), group)
                }
            };
            let found = found.ok_or("the model has no such point, sensor or section")?;
            if found.iter().any(|value| !value.is_finite()) {
                return Err("the accelerations under these inputs are not finite".to_owned());
            }
            self.read = Some((group, found));
        }
        self.read.as_ref().map(|(_, values)| values).ok_or_else(|| "there are no outputs".to_owned())
    }

    /// What the stations of a block do.
    pub(crate) fn station(&mut self, slot: usize, place: usize) -> Result<f64, String> {
        let block = self.stations.get_mut(slot).ok_or("there is no such block of stations")?;
        if block.values.is_empty() {
            block.read(&self.model, self.simulation.state())?;
        }
        block.values.get(place).copied().ok_or_else(|| "the block has no such station".to_owned())
    }

    /// Acceleration of a mode under the inputs of now; zero for modes that a simpler method leaves out.
    pub(crate) fn modal_acceleration(
        &mut self,
        mode: usize,
        blocks: &[InputBlock],
        inputs: &[f64],
    ) -> Result<f64, String> {
        let (simulation, _) = self.settled(false, blocks, inputs)?;
        let u_dot = &simulation.state().u_dot;
        Ok(u_dot.split_last_chunk::<6>().and_then(|(modes, _)| modes.get(mode)).copied().unwrap_or(0.0))
    }

    /// How `unknowns` change along changes of states and inputs, to first order, by the equations of motion as they are now.
    pub(crate) fn directional_derivative(
        &mut self,
        seeds: impl Iterator<Item = (Role, f64)>,
        unknowns: impl Iterator<Item = Role>,
        blocks: &[InputBlock],
        inputs: &[f64],
    ) -> Result<Vec<f64>, String> {
        let (model, stations) = (&self.model, &self.stations);
        let loads = acting(&mut self.set, &self.case, blocks, inputs);
        let new = || {
            let blocks = stations.iter().map(|block| block.stations.block()).collect();
            Derivatives::new(model, blocks).map(Box::new)
        };
        let derivatives = match &mut self.derivatives {
            Some(known) => known,
            empty => empty.insert(new()?),
        };
        derivatives.evaluate(self.simulation.state(), self.simulation.gravity(), loads)?;
        derivatives.seed(seeds, blocks)?;
        unknowns.map(|unknown| derivatives.of(unknown, loads)).collect()
    }

    /// State or inputs have changed.
    pub(crate) fn changed(&mut self) {
        self.read = None;
        self.stations.iter_mut().for_each(|block| block.values.clear());
        if let Some(probe) = &mut self.probe {
            probe.current = false;
        }
        if let Some(derivatives) = &mut self.derivatives {
            derivatives.forget();
        }
    }

    pub(crate) fn inputs_changed(&mut self) -> Result<(), String> {
        self.changed();
        if self.fresh && self.simulation.state().accelerations_known {
            let state = State { accelerations_known: false, ..self.simulation.state().clone() };
            self.simulation.restore(&state).map_err(|e| e.to_string())?;
        }
        Ok(())
    }

    /// Steps up to the time `end`.
    pub(crate) fn advance(&mut self, end: f64, blocks: &[InputBlock], inputs: &[f64]) -> Result<(), String> {
        let before = self.simulation.state().time;
        self.changed();
        self.fresh = false;
        let outcome = self.march(end - before, blocks, inputs);
        // Where the very first of the steps failed the accelerations are still those under the inputs before.
        if self.simulation.state().time != before || outcome.is_ok() {
            self.held.clear();
            self.held.extend_from_slice(inputs);
        }
        outcome
    }

    fn march(&mut self, left: f64, blocks: &[InputBlock], inputs: &[f64]) -> Result<(), String> {
        let dt = self.settings.dt;
        let (steps, step) = division(left, dt);
        if step == dt {
            let loads = acting(&mut self.set, &self.case, blocks, inputs);
            return march(&mut self.simulation, loads, steps);
        }
        // Steps of the same length from a host whose times are rounded are steps of the same length.
        let known = self.odd.take().filter(|(length, _)| (length - step).abs() <= 1e-11 * step);
        let (length, mut odd) = match known {
            Some(odd) => odd,
            None => (step, self.of_length(step)?),
        };
        odd.restore(self.simulation.state()).map_err(|e| e.to_string())?;
        let loads = acting(&mut self.set, &self.case, blocks, inputs);
        let outcome = march(&mut odd, loads, steps);
        self.simulation.restore(odd.state()).map_err(|e| e.to_string())?;
        self.odd = Some((length, odd));
        outcome
    }

    fn of_length(&self, dt: f64) -> Result<Simulation, String> {
        let settings = Settings { dt, ..self.settings };
        let mut simulation = Simulation::new(Arc::clone(&self.model), settings).map_err(|e| e.to_string())?;
        if self.gravity != self.model.gravity() {
            simulation.set_gravity(self.gravity).map_err(|e| e.to_string())?;
        }
        Ok(simulation)
    }

    /// Length of the last steps that were not of `dt`; zero if there were none. Part of the state: the next ones may take it over.
    pub(crate) fn odd_length(&self) -> f64 {
        self.odd.as_ref().map_or(0.0, |(length, _)| *length)
    }

    pub(crate) fn set_odd_length(&mut self, length: f64) -> Result<(), String> {
        if length != self.odd_length() {
            self.odd = if length > 0.0 { Some((length, self.of_length(length)?)) } else { None };
        }
        Ok(())
    }
}

impl Block {
    fn new(model: &Model, block: usize) -> Result<Self, String> {
        let stations = Stations::new(model, block).map_err(|e| e.to_string())?;
        Ok(Block { values: Vec::with_capacity(13 * stations.len()), stations })
    }

    fn read(&mut self, model: &Model, state: &State) -> Result<(), String> {
        let motion = self.stations.read(model, state, StationAxes::Inertial).map_err(|e| e.to_string())?;
        let StationMotion { position, attitude, velocity, angular_velocity } = motion;
        for part in [position, attitude, velocity, angular_velocity] {
            self.values.extend_from_slice(part);
        }
        Ok(())
    }
}

/// Number and length of the steps in an interval.
fn division(left: f64, dt: f64) -> (u64, f64) {
    let ratio = left / dt;
    let nearest = ratio.round().max(1.0);
    let miss = (ratio - nearest).abs();
    if miss <= 1e-9 * nearest.max(1.0) {
        (nearest as u64, dt)
    } else if miss <= WHOLE {
        (nearest as u64, left / nearest)
    } else {
        let steps = ratio.ceil().max(1.0);
        (steps as u64, left / steps)
    }
}

/// The accelerations at the end are those under the loads of the last step, whatever the integrator.
fn march(simulation: &mut Simulation, loads: &dyn Loads, steps: u64) -> Result<(), String> {
    let result = (0..steps).try_for_each(|_| simulation.step(loads));
    result.and_then(|()| simulation.solve_accelerations(loads)).map_err(|e| e.to_string())
}

fn acting<'a>(
    set: &'a mut LoadSet,
    case: &'a PreparedLoads,
    blocks: &[InputBlock],
    inputs: &[f64],
) -> &'a dyn Loads {
    if inputs.iter().all(|input| *input == 0.0) {
        return case;
    }
    fill(set, blocks, inputs);
    set
}

/// Puts the inputs into a set with a slot for every point of the model and for the blocks of stations.
pub(crate) fn fill(set: &mut LoadSet, blocks: &[InputBlock], inputs: &[f64]) {
    set.clear();
    for (block, wrench) in blocks.iter().zip(inputs.chunks_exact(6)) {
        if let [fx, fy, fz, mx, my, mz] = *wrench
            && wrench.iter().any(|component| *component != 0.0)
        {
            let (force, moment) = ([fx, fy, fz], [mx, my, mz]);
            let _ = match block {
                InputBlock::Point { point, frame } => set.add(*point, frame, force, moment),
                InputBlock::Station { slot, station, frame } => {
                    set.add_to_station(*slot, *station, *frame, force, moment)
                }
            };
        }
    }
}

/// The model by the method chosen, without the loads of its equilibrium where they are not wanted.
fn simplified(file: &Arc<Model>, parameters: &Parameters) -> Result<Arc<Model>, String> {
    let mut model = Arc::clone(file);
    let method = parameters.method()?;
    if !parameters.equilibrium_loads
        && let Some(trim) = &file.data().trim
    {
        let mut data = file.data().clone();
        data.trim = Some(TrimData { loads: Vec::new(), ..trim.clone() });
        model = Arc::new(Model::new(data).map_err(|e| e.to_string())?);
    }
    if method != Method::Rom {
        model = Arc::new(model.with_method(method).map_err(|e| e.to_string())?);
    }
    Ok(model)
}

/// The load case chosen; an empty one for none.
fn load_case(model: &Model, parameters: &Parameters) -> Result<LoadCase, String> {
    let cases = &model.data().load_cases;
    let none = || LoadCase { dt: DEFAULT_DT, ..LoadCase::empty("none") };
    if parameters.load_case == 0 {
        return Ok(none());
    }
    let place = usize::try_from(parameters.load_case - 1).ok();
    let case = place.and_then(|place| cases.get(place));
    case.cloned().ok_or_else(|| {
        format!("parameter load_case is {}, expected 0 (none) to {}", parameters.load_case, cases.len())
    })
}

/// Frame A moving as the parameters say, the modes at rest.
fn initial_state(model: &Model, parameters: &Parameters) -> Result<State, String> {
    let initial = &parameters.initial;
    let length = initial.zeta.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(1e-3..1e3).contains(&length) {
        return Err(format!("parameter initial_zeta has the length {length}, expected a unit quaternion"));
    }
    let mut state = State::at_rest(model);
    let rest = model.rigid_output(&state);
    // To the bit where nothing has been changed.
    if initial.zeta != state.attitude {
        state.attitude = initial.zeta.map(|x| x / length);
    }
    if initial.r_g != rest.r_g || initial.zeta != rest.zeta {
        state.position = [0.0; 3];
        // The state of a mean-axes model is about the centre of mass.
        let origin = model.rigid_output(&state).r_g;
        for ((position, wanted), origin) in state.position.iter_mut().zip(&initial.r_g).zip(&origin) {
            *position = wanted - origin;
        }
    }
    if initial.v_a != [0.0; 3] || initial.w_a != [0.0; 3] {
        let (v, w) = (initial.v_a, initial.w_a);
        state.beta_star = [0.0, 0.0, 0.0, w[0], w[1], w[2]];
        let turning = model.rigid_output(&state).v_a;
        for ((velocity, wanted), turning) in state.beta_star.iter_mut().zip(&v).zip(&turning) {
            *velocity = wanted - turning;
        }
    }
    Ok(state)
}

/// The outputs of a group; for all but the first three accelerations have to be known, and the loads given under which they are.
fn outputs(simulation: &mut Simulation, loads: Option<&dyn Loads>, group: Group) -> Option<[f64; LARGEST]> {
    let mut values = [0.0; LARGEST];
    let mut fill = |parts: &[&[f64]]| {
        values.iter_mut().zip(parts.iter().copied().flatten()).for_each(|(to, from)| *to = *from);
    };
    match group {
        Group::Frame => {
            let out = simulation.rigid_output();
            fill(&[&out.r_g, &out.v_g, &out.w_g, &out.v_a, &out.w_a, &out.zeta]);
        }
        Group::Ledger => {
            let out = simulation.ledger();
            let energies = [out.kinetic_energy, out.elastic_energy, out.gravity_energy];
            fill(&[&out.r_cm_g, &out.linear_momentum_g, &out.angular_momentum_g, &energies]);
        }
        Group::Point(point) => {
            let out = simulation.point_output(point)?;
            fill(&[&out.dr_a, &out.r_g]);
        }
        Group::PointMotion(point) => {
            let PointMotion { attitude, v_g, w_g, a_g, alpha_g } = simulation.point_motion(point)?;
            fill(&[&attitude, &v_g, &w_g, &a_g, &alpha_g]);
        }
        Group::Sensor(sensor) => {
            let SensorReading { a, w, alpha } = simulation.sensor_reading(sensor)?;
            fill(&[&a, &w, &alpha]);
        }
        Group::Section(section) => {
            let found = simulation.find_section_forces(loads?).ok()?;
            fill(&[&found.get(section)?.best]);
        }
        Group::FrameRates => {
            let state = simulation.state();
            let rates = simulation.model().frame_rate(state, &state.u_dot)?;
            fill(&[&rates, &attitude_rate(state.attitude, simulation.rigid_output().w_a)]);
        }
        Group::Reaction => fill(&[&simulation.reaction().map_or([0.0; 6], |reaction| reaction.total())]),
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_divided_into_whole_steps_where_it_is_a_multiple() {
        assert_eq!(division(0.01, 0.01), (1, 0.01));
        assert_eq!(division(0.30000000000000004 - 0.2, 0.01), (10, 0.01));
        assert_eq!(division(0.02, 0.01), (2, 0.01));
        let (steps, step) = division(0.025, 0.01);
        assert_eq!(steps, 3);
        assert!((step - 0.025 / 3.0).abs() < 1e-17);
        assert_eq!(division(0.004, 0.01), (1, 0.004));
        // A little more than a step is one step, a little longer.
        assert_eq!(division(0.01 * (1.0 + 1e-7), 0.01), (1, 0.01 * (1.0 + 1e-7)));
    }
}
