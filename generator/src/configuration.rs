//! Where every node of the structure is: positions in A and rotations from the drawing.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::element::beam::{Beam, BeamState};
use crate::mesh::Mesh;

/// Positions and rotations of all nodes in A. The reference node is at the origin, unrotated.
#[derive(Clone, Debug)]
pub struct Configuration {
    /// Positions in A, m - (n).
    pub positions: Vec<Vector3<f64>>,
    /// Rotations `Q`, node frame to A; identity in the drawing - (n).
    pub rotations: Vec<UnitQuaternion<f64>>,
}

impl Configuration {
    /// The stress-free shape as drawn.
    pub fn drawing(mesh: &Mesh) -> Self {
        Self { positions: mesh.nodes.clone(), rotations: vec![UnitQuaternion::identity(); mesh.nodes.len()] }
    }

    /// Rotation matrix `Q` of a node.
    pub fn rotation_matrix(&self, node: usize) -> Matrix3<f64> {
        self.rotations[node].to_rotation_matrix().into_inner()
    }

    /// Positions and section triads of an element's ends.
    pub fn of<const N: usize>(&self, beam: &Beam<N>) -> BeamState<N> {
        beam.state(|n| self.positions[n], |n| self.rotation_matrix(n))
    }
}
