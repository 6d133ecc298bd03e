//! Weight of an element in a uniform field `g`: every section is pulled at its centre of mass.
//!
//! With `m` the mass and `s` the first moment of a section per length, in its own axes,
//!
//! ```text
//! V = -g . int (m R + Lam s) ds      force on node a: N_a m g      moment on node a: B_a^t (s x C g)
//! ```
//!
//! These are the inertia forces of a body at rest whose origin accelerates by `-g`, by the same quadrature.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::beam::{Beam, BeamState, InertiaPoint};
use super::internal_force::{ElementMatrix, stack};
use super::rotation_field::RotationField;
use crate::math::so3::skew;
use crate::mesh::LumpedMass;

/// Mass and first moment of a section or lump from `[[m I, -s~], [s~, J]]`.
pub(crate) fn mass_and_moment(mass: &Matrix6<f64>) -> (f64, Vector3<f64>) {
    let m = mass.fixed_view::<3, 3>(0, 0).trace() / 3.0;
    let twice =
        Vector3::new(mass[(2, 4)] - mass[(1, 5)], mass[(0, 5)] - mass[(2, 3)], mass[(1, 3)] - mass[(0, 4)]);
    (m, twice * -0.5)
}

/// Force (axes of `g`, N) and moment (node frame, N m) on every node.
pub fn weight<const N: usize>(beam: &Beam<N>, state: &BeamState<N>, g: &Vector3<f64>) -> [Vector6<f64>; N] {
    let mut out = on_ends(beam, state, g);
    beam.force_to_nodes(state, &mut out);
    out
}

/// The same on the ends of the element.
fn on_ends<const N: usize>(beam: &Beam<N>, state: &BeamState<N>, g: &Vector3<f64>) -> [Vector6<f64>; N] {
    let mut out = [Vector6::zeros(); N];
    let field = RotationField::new(&state.triads);
    for point in beam.inertia_points() {
        let (m, s) = mass_and_moment(&point.mass);
        let eccentric = s.amax() > 0.0;
        let section = eccentric.then(|| field.at(&point.shape));
        for a in 0..N {
            let force = g * (m * point.weight * point.shape.n[a]);
            let moment = section.as_ref().map_or(Vector3::zeros(), |section| {
                let moment = s.cross(&section.triad.tr_mul(g)) * point.weight;
                beam.frames[a] * section.b[a].tr_mul(&moment)
            });
            out[a] += stack(&force, &moment);
        }
    }
    out
}

/// Derivative of [`weight`] in the spins of the nodes (node frames); none where no section has its mass beside its axis and no end is
/// off its node, so that the weight does not depend on the shape.
pub fn weight_tangent<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    g: &Vector3<f64>,
) -> Option<ElementMatrix<N>> {
    let eccentric = |point: &InertiaPoint<N>| mass_and_moment(&point.mass).1.amax() > 0.0;
    if beam.levers.is_none() && !beam.inertia_points().iter().any(eccentric) {
        return None;
    }
    let mut out = [[Matrix6::zeros(); N]; N];
    let field = RotationField::new(&state.triads);
    for point in beam.inertia_points() {
        let (_, s) = mass_and_moment(&point.mass);
        let section = field.at(&point.shape);
        let pull = section.triad.tr_mul(g);
        let turn = field.derivative_bt(&section, &s.cross(&pull));
        let own = skew(&s) * skew(&pull);
        for a in 0..N {
            for b in 0..N {
                let block: Matrix3<f64> = section.b[a].tr_mul(&(own * section.b[b])) + turn[a][b];
                let mut corner = out[a][b].fixed_view_mut::<3, 3>(3, 3);
                corner += beam.frames[a] * block * beam.frames[b].transpose() * point.weight;
            }
        }
    }
    // Only rotations turn the weight: columns of the ends are those of the nodes.
    beam.rows_to_nodes(state, &mut on_ends(beam, state, g), &mut out, &[Matrix3::identity(); N]);
    Some(out)
}

/// Force and moment of a mass on a node turned by `q`.
pub fn lump_weight(lump: &LumpedMass, q: &Matrix3<f64>, g: &Vector3<f64>) -> Vector6<f64> {
    let (m, s) = mass_and_moment(&lump.mass);
    stack(&(g * m), &s.cross(&q.tr_mul(g)))
}

/// Derivative of [`lump_weight`] in the spin of the node; none where the mass is centred on it.
pub fn lump_weight_tangent(
    lump: &LumpedMass,
    q: &Matrix3<f64>,
    g: &Vector3<f64>,
) -> Option<ElementMatrix<1>> {
    let (_, s) = mass_and_moment(&lump.mass);
    let mut block = Matrix6::zeros();
    block.fixed_view_mut::<3, 3>(3, 3).copy_from(&(skew(&s) * skew(&q.tr_mul(g))));
    (s.amax() > 0.0).then_some([[block]])
}
