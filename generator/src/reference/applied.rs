//! Loads and weight on a structure displaced from its equilibrium, as forces on its rows: taken at the deformed point, with the
//! current lever arm.

use nalgebra::{Matrix3, Vector3, Vector6};
use rom_runtime::expression::Variables;

use super::external::ExternalLoads;
use super::floating::Rows;
use super::method::Prepared;
use crate::element::internal_force::{split, stack};
use crate::math::so3::{MatrixFunction, exp};

/// A displaced structure in a frame A somewhere.
pub(crate) struct Displaced<'a> {
    pub(crate) prepared: &'a Prepared,
    /// Displacements `(R, theta)` - (block rows).
    pub(crate) x: &'a [Vector6<f64>],
    /// `C^{GA}`.
    pub(crate) frame: Matrix3<f64>,
}

impl Displaced<'_> {
    /// Takes the loads and the weight off the rows.
    pub(crate) fn subtract(&self, loads: &ExternalLoads, variables: Variables, rows: &mut Rows) {
        self.subtract_weight(rows);
        let frame = self.frame;
        for load in loads.evaluate(variables, frame, false, |node| frame * self.node_rotation(node)) {
            for (node, force) in load.forces() {
                let (force, moment) = split(&force);
                self.subtract_from(node, &frame.tr_mul(&force), &moment, rows);
            }
        }
    }

    /// Weight of the deformed body.
    fn subtract_weight(&self, rows: &mut Rows) {
        let Prepared { mesh, assembly, .. } = self.prepared;
        if mesh.gravity.amax() == 0.0 {
            return;
        }
        let now = self.prepared.displaced(self.x);
        assembly.visit_weight(&now, &self.frame.tr_mul(&mesh.gravity), &mut |node, weight| {
            let (force, moment) = split(&weight);
            self.subtract_from(node, &force, &moment, rows);
        });
    }

    /// A force (in A) and a moment (in the node frame) on a node.
    fn subtract_from(&self, node: usize, force: &Vector3<f64>, moment: &Vector3<f64>, rows: &mut Rows) {
        if let Some(i) = self.prepared.assembly.unknown[node] {
            let t = MatrixFunction::tangential(&split(&self.x[i]).1).matrix();
            rows.s[i] -= stack(force, &t.tr_mul(moment));
        }
        let moment = self.node_rotation(node) * moment + self.node_position(node).cross(force);
        rows.r -= stack(force, &moment);
    }

    pub(crate) fn node_position(&self, node: usize) -> Vector3<f64> {
        let rest = self.prepared.at.positions[node];
        self.prepared.assembly.unknown[node].map_or(rest, |i| rest + split(&self.x[i]).0)
    }

    /// `Q = Q0 exp(theta)`, node frame to A.
    pub(crate) fn node_rotation(&self, node: usize) -> Matrix3<f64> {
        let rest = self.prepared.at.rotation_matrix(node);
        self.prepared.assembly.unknown[node].map_or(rest, |i| rest * exp(&split(&self.x[i]).1))
    }
}
