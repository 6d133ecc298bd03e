//! Where a run begins.

use nalgebra::{UnitQuaternion, Vector3, Vector6};

use super::method::Prepared;
use super::motion::{FrameMotion, Motion};
use crate::element::internal_force::split;
use crate::math::so3::MatrixFunction;

/// Motion of frame A and of the structure in it at t = 0.
#[derive(Clone, Debug)]
pub struct Start {
    /// Frame A.
    pub frame: FrameMotion,
    /// Displacements `(R, theta)` from the equilibrium - (block rows).
    pub x: Vec<Vector6<f64>>,
    /// Their rates - (block rows).
    pub x_dot: Vec<Vector6<f64>>,
}

impl Start {
    /// At rest in the equilibrium, the reference node where the drawing has it.
    pub fn at_rest(prepared: &Prepared) -> Self {
        let zero = vec![Vector6::zeros(); prepared.assembly.n_blocks()];
        let rotation =
            prepared.equilibrium.as_ref().map_or(UnitQuaternion::identity(), |found| found.attitude);
        let frame = FrameMotion {
            position: prepared.mesh.reference_position,
            rotation,
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
        };
        Self { frame, x: zero.clone(), x_dot: zero }
    }

    /// The same as the absolute motion of all nodes.
    pub fn motion(&self, prepared: &Prepared) -> Motion {
        let at = prepared.displaced(&self.x);
        let FrameMotion { position, rotation, velocity, spin } = self.frame;
        let mut out = Motion::at_rest(&prepared.mesh, &at);
        for node in 0..at.positions.len() {
            let (r, q) = (at.positions[node], at.rotations[node]);
            let (mut r_dot, mut relative) = (Vector3::zeros(), Vector3::zeros());
            if let Some(i) = prepared.assembly.unknown[node] {
                let (rate, theta_dot) = split(&self.x_dot[i]);
                r_dot = rate;
                relative = MatrixFunction::tangential(&split(&self.x[i]).1).matrix() * theta_dot;
            }
            out.position[node] = position + rotation * r;
            out.rotation[node] = rotation * q;
            out.velocity[node] = velocity + rotation * (r_dot + spin.cross(&r));
            out.spin[node] = relative + q.inverse() * spin;
        }
        out
    }
}
