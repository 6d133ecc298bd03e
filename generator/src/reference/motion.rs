//! Motion of all nodes in the inertial frame G.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::base::Moved;
use crate::carrier::NodeMotion;
use crate::configuration::Configuration;
use crate::element::beam::{Beam, BeamState};
use crate::element::inertia_force::BeamRates;
use crate::mesh::Mesh;

/// Positions, rotations and rates of all nodes. Angular quantities in the node frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Time, s.
    pub time: f64,
    /// Positions in G, m - (n).
    pub position: Vec<Vector3<f64>>,
    /// Rotations, node frame to G - (n).
    pub rotation: Vec<UnitQuaternion<f64>>,
    /// Velocities in G, m/s - (n).
    pub velocity: Vec<Vector3<f64>>,
    /// Angular velocities, node frame, rad/s - (n).
    pub spin: Vec<Vector3<f64>>,
    /// Accelerations in G, m/s^2 - (n).
    pub acceleration: Vec<Vector3<f64>>,
    /// Rates of the components of `spin`, rad/s^2 - (n).
    pub spin_rate: Vec<Vector3<f64>>,
    /// Auxiliary accelerations of the integrator: translation and rotation - (n).
    pub(crate) auxiliary: Vec<[Vector3<f64>; 2]>,
}

/// Motion of frame A: of the reference node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameMotion {
    /// Position of the origin in G, m.
    pub position: Vector3<f64>,
    /// A to G.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity of the origin in G, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity in A, rad/s.
    pub spin: Vector3<f64>,
}

impl Motion {
    /// At rest in a configuration, A on G's axes and the reference node where the drawing has it.
    pub fn at_rest(mesh: &Mesh, at: &Configuration) -> Self {
        let n = at.positions.len();
        let zero = vec![Vector3::zeros(); n];
        Self {
            time: 0.0,
            position: at.positions.iter().map(|r| r + mesh.reference_position).collect(),
            rotation: at.rotations.clone(),
            velocity: zero.clone(),
            spin: zero.clone(),
            acceleration: zero.clone(),
            spin_rate: zero,
            auxiliary: vec![[Vector3::zeros(); 2]; n],
        }
    }

    /// Gives the body, in addition, the velocity of a rigid motion: of the origin of A (m/s, in G) and angular (rad/s, in G).
    pub fn add_rigid_velocity(&mut self, reference: usize, velocity: &Vector3<f64>, spin: &Vector3<f64>) {
        let origin = self.position[reference];
        for node in 0..self.position.len() {
            self.velocity[node] += velocity + spin.cross(&(self.position[node] - origin));
            self.spin[node] += self.rotation[node].inverse() * spin;
        }
    }

    /// Gives the reference node the motion of a base.
    pub(super) fn set_frame(&mut self, reference: usize, moved: &Moved) {
        let FrameMotion { position, rotation, velocity, spin } = moved.frame;
        self.position[reference] = position;
        self.rotation[reference] = rotation;
        self.velocity[reference] = velocity;
        self.spin[reference] = spin;
        self.acceleration[reference] = moved.acceleration;
        self.spin_rate[reference] = moved.spin_rate;
        self.auxiliary[reference] = [moved.acceleration, moved.spin_rate];
    }

    /// Rotation matrix of a node, node frame to G.
    pub fn rotation_matrix(&self, node: usize) -> Matrix3<f64> {
        self.rotation[node].to_rotation_matrix().into_inner()
    }

    /// Motion of frame A, which sits on the reference node.
    pub fn frame(&self, reference: usize) -> FrameMotion {
        FrameMotion {
            position: self.position[reference],
            rotation: self.rotation[reference],
            velocity: self.velocity[reference],
            spin: self.spin[reference],
        }
    }

    /// How a node moves.
    pub fn of_node(&self, node: usize) -> NodeMotion {
        NodeMotion {
            position: self.position[node],
            rotation: self.rotation[node],
            velocity: self.velocity[node],
            spin: self.spin[node],
            acceleration: self.acceleration[node],
            spin_rate: self.spin_rate[node],
        }
    }

    /// Ends of an element.
    pub fn of<const N: usize>(&self, beam: &Beam<N>) -> BeamState<N> {
        beam.state(|n| self.position[n], |n| self.rotation_matrix(n))
    }

    /// Rates of an element's ends; `state` is what [`Self::of`] gives.
    pub fn rates_of<const N: usize>(&self, beam: &Beam<N>, state: &BeamState<N>) -> BeamRates<N> {
        let nodal = BeamRates {
            velocity: beam.nodes.map(|n| self.velocity[n]),
            spin: beam.nodes.map(|n| self.spin[n]),
            acceleration: beam.nodes.map(|n| self.acceleration[n]),
            spin_rate: beam.nodes.map(|n| self.spin_rate[n]),
        };
        beam.end_rates(state, nodal)
    }
}
