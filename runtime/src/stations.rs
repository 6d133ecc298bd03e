//! Blocks of stations: where many places on the members are and how they move, in one call, for aerodynamic codes.
//!
//! A station sits at `r = R0 + t + N o` in A, with `N = N0 exp(theta~)` its section axes, and `(t, theta) = Phi q` for all stations at
//! once, of second and third order besides on a curved manifold. With the spin `W = T(theta) theta_dot` of the section relative to A (section axes),
//!
//! ```text
//! v_P = v + w x r + t_dot + N (W x o)        w_P = w + N W
//! ```
//!
//! are the rates whose power with the forces and moments of [`crate::LoadSet::set_stations`] is that of the generalised loads.
//!
//! ```no_run
//! # use std::sync::Arc;
//! # use rom_runtime::{DistributedFrame, LoadSet, Model, Settings, Simulation, StationAxes, Stations};
//! # fn aerodynamics(velocity: &[f64], wrenches: &mut [f64]) {}
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let model = Arc::new(Model::read_path("hale.rom")?);
//! let block = model.station_block("wing")?;
//! let mut stations = Stations::new(&model, block)?;
//! let mut loads = LoadSet::with_stations(&model, &[], &[block], Some(model.load_case("gust")?))?;
//! let mut simulation = Simulation::new(model.clone(), Settings::default())?;
//! let mut wrenches = vec![0.0; 6 * stations.len()];
//! for _ in 0..100 {
//!     let motion = stations.read(&model, simulation.state(), StationAxes::Section)?;
//!     aerodynamics(&motion.velocity, &mut wrenches);
//!     let _fits = loads.set_stations(0, DistributedFrame::Follower, &wrenches);
//!     simulation.step(&loads)?;
//! }
//! # Ok(())
//! # }
//! ```

use alloc::{string::ToString, vec, vec::Vec};

use crate::dense::Dense;
use crate::error::{ModelError, SettingsError};
use crate::loading::polynomial;
use crate::math::{
    Mat3, Vec3, add, combine, cross, mat_mul, matrix, mul, mul_t, quaternion, quaternion_product,
    rotation_and_tangential, split, sub,
};
use crate::model::{Model, unknown};
use crate::polynomial::{Jet, Polynomial};
use crate::state::State;

/// Axes in which the motion of stations is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationAxes {
    /// Positions, attitudes and velocities in G.
    Inertial,
    /// In A: positions from its origin, attitudes against it; the velocities, against G, have components in A.
    Body,
    /// Positions and attitudes as for [`StationAxes::Body`]; the velocities, against G, have components in the axes of every section.
    Section,
}

/// Where the stations of a block are and how they move.
#[derive(Clone, Debug, PartialEq)]
pub struct StationMotion {
    /// Positions, m - (n x 3).
    pub position: Vec<f64>,
    /// Attitudes of the section axes: unit quaternions, scalar first - (n x 4).
    pub attitude: Vec<f64>,
    /// Velocities against G, m/s - (n x 3).
    pub velocity: Vec<f64>,
    /// Angular velocities of the sections against G, rad/s - (n x 3).
    pub angular_velocity: Vec<f64>,
}

/// A block of stations made ready for reading; everything is allocated when it is made.
#[derive(Clone, Debug)]
pub struct Stations {
    block: usize,
    n_modes: usize,
    sections: Vec<Section>,
    /// Displacements `(t, theta)` of all stations per unit modal amplitude - (6 n x m).
    shapes: Dense,
    /// Second and third order of the same - (6 n rows).
    curve: Polynomial,
    jets: Vec<Jet>,
    displacement: Vec<f64>,
    rate: Vec<f64>,
    motion: StationMotion,
}

#[derive(Clone, Copy, Debug)]
struct Section {
    position: Vec3,
    quaternion: [f64; 4],
    rotation: Mat3,
    offset: Vec3,
}

impl Stations {
    /// For the block of this index ([`Model::station_block`]).
    ///
    /// # Errors
    /// A block that the model does not have.
    pub fn new(model: &Model, block: usize) -> Result<Self, ModelError> {
        let blocks = &model.data().stations;
        let Some(data) = blocks.get(block) else {
            let names = blocks.iter().map(|block| &block.name);
            return Err(unknown("station block number", &block.to_string(), names));
        };
        let (first, n, m) = (model.first_of_block(block), data.sections.len(), model.n_modes());
        let sections = (first..first + n).filter_map(|index| model.carrier(index)).map(|point| Section {
            position: point.node_position,
            quaternion: point.node_quaternion,
            rotation: point.node_rotation,
            offset: point.offset,
        });
        let shape =
            |row: usize, mode: usize| model.carrier(first + row / 6)?.phi.get(mode)?.get(row % 6).copied();
        let curve = polynomial(model, (0..6 * n).map(|row| (first + row / 6, row % 6)));
        Ok(Stations {
            jets: curve.jets(),
            curve,
            block,
            n_modes: m,
            sections: sections.collect(),
            shapes: Dense::new(6 * n, m, |row, mode| shape(row, mode).unwrap_or(0.0)),
            displacement: vec![0.0; 6 * n],
            rate: vec![0.0; 6 * n],
            motion: StationMotion {
                position: vec![0.0; 3 * n],
                attitude: vec![0.0; 4 * n],
                velocity: vec![0.0; 3 * n],
                angular_velocity: vec![0.0; 3 * n],
            },
        })
    }

    /// Index of the block.
    pub fn block(&self) -> usize {
        self.block
    }

    /// Number of stations.
    pub fn len(&self) -> usize {
        self.sections.len()
    }

    /// Whether there are none: never so.
    pub fn is_empty(&self) -> bool {
        self.sections.is_empty()
    }

    /// Where they are and how they move in a state of the model they were made for. Does not allocate.
    ///
    /// # Errors
    /// A state of another model.
    pub fn read(
        &mut self,
        model: &Model,
        state: &State,
        axes: StationAxes,
    ) -> Result<&StationMotion, SettingsError> {
        if let Some(&found) = [state.q.len(), model.n_modes()].iter().find(|found| **found != self.n_modes) {
            let (found, expected) = (found as f64, self.n_modes as f64);
            return Err(SettingsError::State { what: "number of modes for stations", found, expected });
        }
        self.shapes.apply(&state.q, &mut self.displacement);
        self.shapes.apply(&state.q_dot, &mut self.rate);
        if !self.curve.is_empty() {
            self.curve.prepare(&state.q, &state.q_dot, &mut self.jets);
            let (value, rate) = (&mut self.displacement, &mut self.rate);
            self.curve.values_and_rates(&mut self.jets, &state.q_dot, value, rate);
        }
        let (v, w) = split(&model.velocity(state));
        let to_g = matrix(state.attitude);
        // A mean-axes model is written about the centre of mass; A sits on the reference node, which moves in the modes.
        let origin = model
            .relative
            .as_ref()
            .map_or([0.0; 3], |a| add(a.origin, split(&combine(&a.phi_r, &state.q)).0));
        let motion = &mut self.motion;
        let out = motion
            .position
            .as_chunks_mut::<3>()
            .0
            .iter_mut()
            .zip(motion.attitude.as_chunks_mut::<4>().0)
            .zip(motion.velocity.as_chunks_mut::<3>().0)
            .zip(motion.angular_velocity.as_chunks_mut::<3>().0);
        let moved = self.displacement.as_chunks::<6>().0.iter().zip(self.rate.as_chunks::<6>().0);
        for ((section, (moved, rate)), (((position, attitude), velocity), angular)) in
            self.sections.iter().zip(moved).zip(out)
        {
            let ((t, theta), (t_dot, theta_dot)) = (split(moved), split(rate));
            let (turn, tangential) = rotation_and_tangential(theta);
            let node = mat_mul(&section.rotation, &turn);
            let spin = mul(&tangential, theta_dot);
            let r = add(section.position, add(t, mul(&node, section.offset)));
            let r_dot = add(t_dot, mul(&node, cross(spin, section.offset)));
            let (v_p, w_p) = (add(v, add(cross(w, r), r_dot)), add(w, mul(&node, spin)));
            let against_a = quaternion_product(section.quaternion, quaternion(theta));
            let inertial = axes == StationAxes::Inertial;
            *position = if inertial { add(state.position, mul(&to_g, r)) } else { sub(r, origin) };
            *attitude = if inertial { quaternion_product(state.attitude, against_a) } else { against_a };
            let seen = |x: Vec3| match axes {
                StationAxes::Inertial => mul(&to_g, x),
                StationAxes::Body => x,
                StationAxes::Section => mul_t(&node, x),
            };
            *velocity = seen(v_p);
            *angular = seen(w_p);
        }
        Ok(motion)
    }
}
