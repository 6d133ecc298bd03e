//! Rigid levers from nodes to element ends: how a rigid link is eliminated.
//!
//! An element end at the lever `r` of its node (node frame, constant) has the node's rotation and
//!
//! ```text
//! x = R + Q r      xdot = Rdot + Q W~ r      xddot = Rddot + Q (A~ + W~ W~) r
//! dx = L (dR, w) with L = [[I, -Q r~], [0, I]]
//! ```
//!
//! for a spin `w` of the node. A force `f` on the end (in A) is `L^t` of it on the node, `(f, r x g)` with `g = Q^t f`, and turning the
//! node adds the stiffness `r~ g~` about spins. The kernels work on ends; what they give goes through here.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::beam::{Beam, BeamState};
use super::inertia_force::{BeamRates, RateFactors};
use super::internal_force::ElementMatrix;
use crate::math::so3::skew;

impl<const N: usize> Beam<N> {
    /// Rotation `Q` of a node.
    fn node_rotation(&self, state: &BeamState<N>, a: usize) -> Matrix3<f64> {
        state.triads[a] * self.frames[a].transpose()
    }

    /// Ends of the element from its nodes: their positions in A (or G) and rotations `Q`.
    pub fn state(
        &self,
        position: impl Fn(usize) -> Vector3<f64>,
        rotation: impl Fn(usize) -> Matrix3<f64>,
    ) -> BeamState<N> {
        let rotations = self.nodes.map(rotation);
        let mut positions = self.nodes.map(position);
        if let Some(levers) = &self.levers {
            for a in 0..N {
                positions[a] += rotations[a] * levers[a];
            }
        }
        BeamState { positions, triads: std::array::from_fn(|a| rotations[a] * self.frames[a]) }
    }

    /// Rates of the ends from those of the nodes.
    pub fn end_rates(&self, state: &BeamState<N>, mut rates: BeamRates<N>) -> BeamRates<N> {
        if let Some(levers) = &self.levers {
            for a in 0..N {
                let (q, r) = (self.node_rotation(state, a), &levers[a]);
                let (w, w1) = (&rates.spin[a], &rates.spin_rate[a]);
                rates.velocity[a] += q * w.cross(r);
                rates.acceleration[a] += q * (w1.cross(r) + w.cross(&w.cross(r)));
            }
        }
        rates
    }

    /// `L` of every node.
    pub(super) fn lever_maps(&self, state: &BeamState<N>) -> Option<[Matrix6<f64>; N]> {
        let levers = self.levers.as_ref()?;
        Some(std::array::from_fn(|a| {
            let mut map = Matrix6::identity();
            let arm = self.node_rotation(state, a) * skew(&levers[a]);
            map.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm);
            map
        }))
    }

    /// Turns forces on the ends into forces on the nodes.
    pub(super) fn force_to_nodes(&self, state: &BeamState<N>, force: &mut [Vector6<f64>; N]) {
        let Some(maps) = self.lever_maps(state) else { return };
        for (f, map) in force.iter_mut().zip(&maps) {
            *f = map.tr_mul(f);
        }
    }

    /// Turns the columns of a tangent from the ends' position and spin to those of the nodes.
    pub(super) fn columns_to_nodes(&self, state: &BeamState<N>, tangent: &mut ElementMatrix<N>) {
        let Some(maps) = self.lever_maps(state) else { return };
        for row in tangent {
            row.iter_mut().zip(&maps).for_each(|(block, map)| *block *= map);
        }
    }

    /// Turns the rows of a tangent, and the forces on the ends it belongs to, into those of the nodes. Rotation columns are
    /// `theta` with `spin = tangential theta`.
    pub(super) fn rows_to_nodes(
        &self,
        state: &BeamState<N>,
        force: &mut [Vector6<f64>; N],
        tangent: &mut ElementMatrix<N>,
        tangential: &[Matrix3<f64>; N],
    ) {
        let (Some(levers), Some(maps)) = (&self.levers, self.lever_maps(state)) else { return };
        for a in 0..N {
            tangent[a].iter_mut().for_each(|block| *block = maps[a].tr_mul(block));
            let local: Vector3<f64> = self.node_rotation(state, a).tr_mul(&force[a].fixed_rows::<3>(0));
            let mut corner = tangent[a][a].fixed_view_mut::<3, 3>(3, 3);
            corner += skew(&levers[a]) * skew(&local) * tangential[a];
        }
        self.force_to_nodes(state, force);
    }

    /// Second derivative in `theta` of the work of a force (A) on the end: `(g r^t + r g^t)/2 - (g . r) I`, which is `r~ g~` about
    /// spins less the `(r x g)~ / 2` of the rotation vector. Zero without a lever.
    pub(super) fn lever_turning(
        &self,
        state: &BeamState<N>,
        a: usize,
        force: &Vector3<f64>,
    ) -> Option<Matrix3<f64>> {
        let r = &self.levers.as_ref()?[a];
        let g = self.node_rotation(state, a).tr_mul(force);
        Some((g * r.transpose() + r * g.transpose()) * 0.5 - Matrix3::identity() * g.dot(r))
    }

    /// Velocity and acceleration of the end (A) per increment `theta` of the node whose rates follow by `factors`, beyond those of
    /// a node at the end: the rates of the lever with the end's own position held. `rates` are those of the ends.
    pub(super) fn lever_rate_variation(
        &self,
        state: &BeamState<N>,
        rates: &BeamRates<N>,
        a: usize,
        factors: RateFactors,
        tangential: &Matrix3<f64>,
    ) -> Option<[Matrix3<f64>; 2]> {
        let r = &self.levers.as_ref()?[a];
        let q = self.node_rotation(state, a);
        let (w, w1) = (&rates.spin[a], &rates.spin_rate[a]);
        let RateFactors { velocity: cv, acceleration: ca } = factors;
        let arm = skew(r);
        let moving = w.cross(r);
        let turned = w1.cross(r) + w.cross(&moving);
        let velocity = -(skew(&moving) * tangential + arm * cv);
        let acceleration = -(skew(&turned) * tangential + arm * ca + (skew(&moving) + skew(w) * arm) * cv);
        Some([q * velocity, q * acceleration])
    }
}
