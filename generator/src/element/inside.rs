//! A section inside an element, which the nodes carry by the interpolation of the element: what acts or is measured between nodes.
//!
//! With the ends of the element at `x_a`, its section triads `Lam_a`, and the section frame `E` of the drawing there,
//!
//! ```text
//! R = sum N_a x_a        Q = Lam E^t        dR = sum N_a dx_a        spin of the section: sum B_a E_a^t w_a
//! ```
//!
//! so that `Q` is the identity in the drawing, as it is for a node. A force `F` and a moment `m` (axes of `Q`) do the same virtual work
//! as the nodal loads `(N_a F, E_a B_a^t E^t m)`, whose derivative in the nodal spins `w_b` is
//!
//! ```text
//! (N_a dF/dw W_b,   E_a (d(B_a^t m)/dw_b E_b^t + B_a^t E^t dm/dw W_b)),      W_b = E B_b E_b^t
//! ```
//!
//! (theory section 6); rigid levers at the ends of the element come on top.

use std::sync::Arc;

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::beam::{Beam, BeamState, SectionState};
use super::inertia_force::BeamRates;
use super::internal_force::{split, stack};
use super::rotation_field::RotationField;
use super::shape::Shape;
use crate::math::so3::skew;

/// A section at a place inside an element with `N` nodes.
#[derive(Clone, Debug)]
pub struct Inside<const N: usize> {
    beam: Arc<Beam<N>>,
    shape: Shape<N>,
    /// Section frame of the drawing, `E`.
    frame: Matrix3<f64>,
}

/// A force and a moment on a carrier (a node or a section), with their derivatives in its spin and in that of frame A.
#[derive(Clone, Copy, Debug)]
pub struct CarrierForce {
    /// Force (in the axes of the configuration, N), moment (axes of the carrier, N m).
    pub force: Vector6<f64>,
    /// Derivative of force and moment in the spin of the carrier (its own axes).
    pub by_spin: [Matrix3<f64>; 2],
    /// Derivative in the spin of frame A; zero unless the load is constant in A.
    pub by_frame_spin: [Matrix3<f64>; 2],
}

/// The same on the nodes.
#[derive(Clone, Copy, Debug)]
pub struct SpreadForce<const N: usize> {
    /// Force, and moment in the node frame, on every node.
    pub force: [Vector6<f64>; N],
    /// Derivative of row `a` in the spin of node `b` (node frames); zero unless asked for.
    pub by_spin: [[[Matrix3<f64>; 2]; N]; N],
    /// Derivative in the spin of frame A.
    pub by_frame_spin: [[Matrix3<f64>; 2]; N],
}

/// Position, rotation and rates of a carrier's frame.
#[derive(Clone, Copy, Debug)]
pub struct InsideMotion {
    /// Position, velocity, acceleration, in the axes of the configuration.
    pub translation: [Vector3<f64>; 3],
    /// Rotation `Q`.
    pub rotation: Matrix3<f64>,
    /// Spin and its rate, axes of `Q`.
    pub spin: [Vector3<f64>; 2],
}

impl<const N: usize> Inside<N> {
    /// At `x` in 0..1 along an element.
    pub fn new(beam: Arc<Beam<N>>, x: f64) -> Self {
        let shape = Shape::at(x, beam.length);
        let frame = RotationField::new(&beam.frames).at(&shape).triad;
        Self { beam, shape, frame }
    }

    /// Node indices.
    pub fn nodes(&self) -> &[usize; N] {
        &self.beam.nodes
    }

    /// Section frame of the drawing there, `E`: from section axes to those of the carrier.
    pub fn frame(&self) -> &Matrix3<f64> {
        &self.frame
    }

    /// Position and rotation `Q` from those of the nodes.
    pub fn pose(
        &self,
        position: impl Fn(usize) -> Vector3<f64>,
        rotation: impl Fn(usize) -> Matrix3<f64>,
    ) -> (Vector3<f64>, Matrix3<f64>) {
        let state = self.beam.state(position, rotation);
        let section = RotationField::new(&state.triads).at(&self.shape);
        (state.position(&self.shape), section.triad * self.frame.transpose())
    }

    /// Motion from that of the nodes.
    pub fn motion(&self, state: &BeamState<N>, nodal: BeamRates<N>) -> InsideMotion {
        let rates = self.beam.end_rates(state, nodal);
        let field = RotationField::new(&state.triads);
        let section = field.at(&self.shape);
        let local = |v: &[Vector3<f64>; N]| -> [Vector3<f64>; N] {
            std::array::from_fn(|a| self.beam.frames[a].tr_mul(&v[a]))
        };
        let (spin, spin_rate) = (local(&rates.spin), local(&rates.spin_rate));
        let b1 = field.b1(&section, &field.rates(&spin, &spin_rate, false));
        let sum = |v: &[Vector3<f64>; N]| (0..N).map(|a| v[a] * self.shape.n[a]).sum::<Vector3<f64>>();
        let w: Vector3<f64> = (0..N).map(|a| section.b[a] * spin[a]).sum();
        let w_dot: Vector3<f64> = (0..N).map(|a| section.b[a] * spin_rate[a] + b1[a] * spin[a]).sum();
        InsideMotion {
            translation: [state.position(&self.shape), sum(&rates.velocity), sum(&rates.acceleration)],
            rotation: section.triad * self.frame.transpose(),
            spin: [self.frame * w, self.frame * w_dot],
        }
    }

    /// The element that carries it.
    pub fn beam(&self) -> &Beam<N> {
        &self.beam
    }

    /// `(dR, spin)` of the carrier per `(dR, spin)` of each node.
    pub fn maps(&self, state: &BeamState<N>) -> [Matrix6<f64>; N] {
        let field = RotationField::new(&state.triads);
        let section = SectionState::new(state, &field, &self.shape);
        let levers = self.beam.lever_maps(state);
        std::array::from_fn(|a| {
            let mut map = Matrix6::identity() * self.shape.n[a];
            let turn = self.frame * section.rotation.b[a] * self.beam.frames[a].transpose();
            map.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
            levers.as_ref().map_or(map, |levers| map * levers[a])
        })
    }

    /// The nodal loads that do the same virtual work, and where asked their derivatives. `rotation` of the nodes in the axes of the force.
    pub fn spread(
        &self,
        rotation: impl Fn(usize) -> Matrix3<f64>,
        on: &CarrierForce,
        with_stiffness: bool,
    ) -> SpreadForce<N> {
        // Rotations alone decide who carries what.
        let state = self.beam.state(|_| Vector3::zeros(), rotation);
        let field = RotationField::new(&state.triads);
        let section = field.at(&self.shape);
        let (f, m) = split(&on.force);
        let local = self.frame.tr_mul(&m);
        let zero = [Matrix3::zeros(); 2];
        let mut out =
            SpreadForce { force: [Vector6::zeros(); N], by_spin: [[zero; N]; N], by_frame_spin: [zero; N] };
        let up: [Matrix3<f64>; N] =
            std::array::from_fn(|a| self.beam.frames[a] * section.b[a].transpose() * self.frame.transpose());
        for a in 0..N {
            let n = self.shape.n[a];
            out.force[a] = stack(&(f * n), &(up[a] * m));
            out.by_frame_spin[a] = [on.by_frame_spin[0] * n, up[a] * on.by_frame_spin[1]];
        }
        if with_stiffness {
            let turn = field.derivative_bt(&section, &local);
            for a in 0..N {
                for b in 0..N {
                    let own = on.by_spin.map(|d| d * up[b].transpose());
                    let turned = self.beam.frames[a] * turn[a][b] * self.beam.frames[b].transpose();
                    out.by_spin[a][b] = [own[0] * self.shape.n[a], up[a] * own[1] + turned];
                }
            }
        }
        self.to_nodes(&state, &mut out);
        out
    }

    /// From the ends of the element to its nodes, where levers are between.
    fn to_nodes(&self, state: &BeamState<N>, out: &mut SpreadForce<N>) {
        let Some(levers) = &self.beam.levers else { return };
        for a in 0..N {
            let q = state.triads[a] * self.beam.frames[a].transpose();
            let arm = skew(&levers[a]) * q.transpose();
            for by in out.by_spin[a].iter_mut().chain([&mut out.by_frame_spin[a]]) {
                by[1] += arm * by[0];
            }
            let g: Vector3<f64> = q.tr_mul(&out.force[a].fixed_rows::<3>(0));
            out.by_spin[a][a][1] += skew(&levers[a]) * skew(&g);
            let moment = levers[a].cross(&g);
            let mut rows = out.force[a].fixed_rows_mut::<3>(3);
            rows += moment;
        }
    }
}
