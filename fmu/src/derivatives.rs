//! Directional derivatives: how outputs and rates of the states change along changes of states and inputs.
//!
//! The states of the description are `q`, `q_dot`, `v_A`, `w_A`, `zeta`, `r_G`; those of [`Jacobian`] have the rigid part of the velocity
//! and a small turn of A instead, and are those of the mean axes in a mean-axes model. One is linear in the other at a state.

use std::sync::Arc;

use rom_runtime::{
    Direction, Jacobian, LoadSet, Loads, Model, PointMotion, SectionForces, SensorReading, State,
    attitude_rate,
};

use crate::run::fill;
use crate::variables::{InputBlock, Role, station_output};

/// The derivatives at a state, and a direction.
pub(crate) struct Derivatives {
    jacobian: Jacobian,
    /// Whether it is where the simulation and the inputs are.
    current: bool,
    /// A change of the inputs, as loads.
    loads: LoadSet,
    seed: Seed,
    /// Change of the state in the coordinates of the Jacobian - (2 m + 12).
    state: Vec<f64>,
    /// Change of the rates of these coordinates by the loads - (2 m + 12).
    column: Vec<f64>,
    /// Change of the accelerations - (m + 6).
    u_dot: Vec<f64>,
    /// Change of the reaction.
    reaction: [f64; 6],
    /// Sections: along the direction, and what the loads add.
    sections: [Vec<SectionForces>; 2],
    /// Indices of the blocks of stations among the variables.
    stations: Vec<usize>,
}

/// Changes of what may be known.
#[derive(Default)]
struct Seed {
    v_a: [f64; 3],
    w_a: [f64; 3],
    zeta: [f64; 4],
    r_g: [f64; 3],
    inputs: Vec<f64>,
}

impl Derivatives {
    pub(crate) fn new(model: &Arc<Model>, stations: Vec<usize>) -> Result<Self, String> {
        let points: Vec<usize> = (0..model.n_points()).collect();
        let jacobian = Jacobian::new(Arc::clone(model));
        let (n, m) = (jacobian.size(), model.n_modes());
        let sections = vec![SectionForces::default(); model.section_names().len()];
        Ok(Derivatives {
            jacobian,
            current: false,
            loads: LoadSet::with_stations(model, &points, &stations, None).map_err(|e| e.to_string())?,
            stations,
            seed: Seed::default(),
            state: vec![0.0; n],
            column: vec![0.0; n],
            u_dot: vec![0.0; m + 6],
            reaction: [0.0; 6],
            sections: [sections.clone(), sections],
        })
    }

    /// State or inputs have changed.
    pub(crate) fn forget(&mut self) {
        self.current = false;
    }

    pub(crate) fn evaluate(
        &mut self,
        state: &State,
        gravity: [f64; 3],
        loads: &dyn Loads,
    ) -> Result<(), String> {
        if !self.current {
            self.jacobian.set_gravity(gravity);
            self.jacobian.evaluate(state, loads).map_err(|e| e.to_string())?;
            self.current = true;
        }
        Ok(())
    }

    /// Sets the direction.
    pub(crate) fn seed(
        &mut self,
        seeds: impl Iterator<Item = (Role, f64)>,
        blocks: &[InputBlock],
    ) -> Result<(), String> {
        let m = self.jacobian.model().n_modes();
        self.state.fill(0.0);
        self.seed = Seed { inputs: vec![0.0; 6 * blocks.len()], ..Seed::default() };
        for (known, change) in seeds {
            let place = match known {
                // A simpler method leaves modes out.
                Role::Amplitude(i) | Role::Rate(i) if i >= m => None,
                Role::Amplitude(i) => self.state.get_mut(i),
                Role::Rate(i) => self.state.get_mut(m + i),
                Role::Frame(i @ 0..3) => self.seed.r_g.get_mut(i),
                Role::Frame(i @ 9..12) => self.seed.v_a.get_mut(i - 9),
                Role::Frame(i @ 12..15) => self.seed.w_a.get_mut(i - 12),
                Role::Frame(i @ 15..19) => self.seed.zeta.get_mut(i - 15),
                Role::Input(i) => self.seed.inputs.get_mut(i),
                _ => return Err("a derivative is by inputs and continuous states only".to_owned()),
            };
            if let Some(place) = place {
                *place += change;
            }
        }
        self.place_frame(m);
        fill(&mut self.loads, blocks, &self.seed.inputs);
        let by_load = self.jacobian.by_load(&self.loads, &mut self.column).map_err(|e| e.to_string())?;
        let n = self.state.len();
        let along = |row: &[f64]| row.iter().zip(&self.state).map(|(a, x)| a * x).sum::<f64>();
        let rows = self.jacobian.matrix().chunks_exact(n).zip(&self.column).skip(m);
        for (to, (row, load)) in self.u_dot.iter_mut().zip(rows) {
            *to = along(row) + load;
        }
        for (to, (row, load)) in
            self.reaction.iter_mut().zip(self.jacobian.reaction().chunks_exact(n).zip(by_load))
        {
            *to = along(row) + load;
        }
        Ok(())
    }

    /// The rigid coordinates of the Jacobian that change the motion of A by the seed: those that are there already move it too, and each
    /// adds to its own by what is missing, velocities after the spin on which they depend.
    fn place_frame(&mut self, m: usize) {
        let ([s, a, b, c], [ds, da, db, dc]) = (self.jacobian.state().attitude, self.seed.zeta);
        // Vector part of zeta^-1 d zeta, twice; the part along zeta is no turn.
        let theta = [
            s * da - a * ds - b * dc + c * db,
            s * db - b * ds - c * da + a * dc,
            s * dc - c * ds - a * db + b * da,
        ];
        let rigid = 2 * m;
        let set = |state: &mut [f64], first: usize, values: [f64; 3]| {
            state.iter_mut().skip(first).zip(values).for_each(|(to, value)| *to += value);
        };
        set(&mut self.state, rigid + 6, theta.map(|half| 2.0 * half));
        let missing = |wanted: [f64; 3], found: [f64; 3]| std::array::from_fn(|k| wanted[k] - found[k]);
        let found = self.jacobian.rigid_output(Direction { state: &self.state, u_dot: &[] });
        set(&mut self.state, rigid + 3, missing(self.seed.w_a, found.w_a));
        let found = self.jacobian.rigid_output(Direction { state: &self.state, u_dot: &[] });
        set(&mut self.state, rigid, missing(self.seed.v_a, found.v_a));
        set(&mut self.state, rigid + 9, missing(self.seed.r_g, found.r_g));
    }

    /// Change of an output or of the rate of a state along the direction, under the loads that act.
    pub(crate) fn of(&mut self, unknown: Role, loads: &dyn Loads) -> Result<f64, String> {
        let m = self.jacobian.model().n_modes();
        let along = Direction { state: &self.state, u_dot: &self.u_dot };
        let at = |parts: &[&[f64]], place: usize| parts.iter().copied().flatten().nth(place).copied();
        let found = match unknown {
            Role::Amplitude(i) | Role::Rate(i) | Role::Acceleration(i) if i >= m => Some(0.0),
            Role::Amplitude(i) => self.state.get(i).copied(),
            Role::Rate(i) => self.state.get(m + i).copied(),
            Role::Acceleration(i) => self.u_dot.get(i).copied(),
            // States are what they are set to, the length of the quaternion too.
            Role::Frame(i @ 15..19) => self.seed.zeta.get(i - 15).copied(),
            Role::Frame(i) => {
                let out = self.jacobian.rigid_output(along);
                at(&[&out.r_g, &out.v_g, &out.w_g, &out.v_a, &out.w_a], i)
            }
            Role::FrameRate(i @ 0..6) => self.jacobian.frame_rate(along).get(i).copied(),
            Role::FrameRate(i) => {
                let state = self.jacobian.state();
                let w = self.jacobian.model().rigid_output(state).w_a;
                let turned = attitude_rate(state.attitude, self.seed.w_a);
                at(&[&turned], i - 6).zip(at(&[&attitude_rate(self.seed.zeta, w)], i - 6)).map(|(a, b)| a + b)
            }
            Role::Ledger(i) => {
                let of = self.jacobian.ledger(along);
                let energies = [of.kinetic_energy, of.elastic_energy, of.gravity_energy];
                at(&[&of.r_cm_g, &of.linear_momentum_g, &of.angular_momentum_g, &energies], i)
            }
            Role::Point(point, i @ 0..6) => {
                let out = self.jacobian.point_output(along, point);
                out.and_then(|out| at(&[&out.dr_a, &out.r_g], i))
            }
            Role::Point(point, i) => {
                let out = self.jacobian.point_motion(along, point);
                out.and_then(|PointMotion { attitude, v_g, w_g, a_g, alpha_g }| {
                    at(&[&attitude, &v_g, &w_g, &a_g, &alpha_g], i - 6)
                })
            }
            Role::Sensor(sensor, i) => {
                let out = self.jacobian.sensor_reading(along, sensor);
                out.and_then(|SensorReading { a, w, alpha }| at(&[&a, &w, &alpha], i))
            }
            Role::Section(section, i) => {
                let [state, load] = &mut self.sections;
                self.jacobian.section_forces(along, loads, state).map_err(|e| e.to_string())?;
                self.jacobian.section_forces_of_load(&self.loads, load).map_err(|e| e.to_string())?;
                let pair = state.get(section).zip(load.get(section));
                pair.and_then(|(a, b)| Some(a.best.get(i)? + b.best.get(i)?))
            }
            Role::Reaction(i) => self.reaction.get(i).copied(),
            Role::Station(slot, i) => self.of_station(slot, i),
            _ => None,
        };
        found.ok_or_else(|| "a derivative is of outputs and of rates of states only".to_owned())
    }

    fn of_station(&mut self, slot: usize, place: usize) -> Option<f64> {
        let along = Direction { state: &self.state, u_dot: &self.u_dot };
        let block = *self.stations.get(slot)?;
        let n = self.jacobian.model().data().stations.get(block)?.sections.len();
        let (output, station, component) = station_output(n, place)?;
        if output == 0 {
            return self.jacobian.station_position(along, block, station)?.get(component).copied();
        }
        let (motion, _) = self.jacobian.station_motion(along, block, station)?;
        match output {
            1 => motion.attitude.get(component).copied(),
            2 => motion.v_g.get(component).copied(),
            _ => motion.w_g.get(component).copied(),
        }
    }
}
