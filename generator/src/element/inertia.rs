//! Mass matrix of an element (theory section 2): `M = int J^t Mcs J ds`, `J = [Lam N, A_RC]`.

use nalgebra::{Matrix6, Vector3};

use super::beam::{Beam, BeamState, InertiaPoint, SectionState};
use super::internal_force::ElementMatrix;
use super::rotation_field::RotationField;
use crate::math::so3::skew;

/// Section velocity in B per nodal rate: columns (Rdot in A, rotation rate in the node frame) of each node - (N of 6 x 6).
pub type StructuralMap<const N: usize> = [Matrix6<f64>; N];

/// Blocks of the mass matrix of one element.
#[derive(Clone, Copy, Debug)]
pub struct ElementMass<const N: usize> {
    /// `M_SS` over pairs of nodes.
    pub ss: ElementMatrix<N>,
    /// `M_SR`: rows of each node, columns `beta` about the origin of A.
    pub sr: [Matrix6<f64>; N],
    /// `M_RR` about the origin of A.
    pub rr: Matrix6<f64>,
}

/// `Lam N`: what nodal rates give as section velocity `(C Rdot, w)`.
pub fn structural_map<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    section: &SectionState<N>,
    point: &InertiaPoint<N>,
) -> StructuralMap<N> {
    let c = section.rotation.triad.transpose();
    let levers = beam.lever_maps(state);
    std::array::from_fn(|a| {
        let mut map = Matrix6::zeros();
        map.fixed_view_mut::<3, 3>(0, 0).copy_from(&(c * point.shape.n[a]));
        map.fixed_view_mut::<3, 3>(3, 3).copy_from(&(section.rotation.b[a] * beam.frames[a].transpose()));
        levers.as_ref().map_or(map, |levers| map * levers[a])
    })
}

/// `A_RC = [[C, -C R~], [0, C]]`: what the rates of A give as section velocity (theory (3)).
pub fn rigid_map(triad: &nalgebra::Matrix3<f64>, position: &Vector3<f64>) -> Matrix6<f64> {
    let c = triad.transpose();
    let mut map = Matrix6::zeros();
    map.fixed_view_mut::<3, 3>(0, 0).copy_from(&c);
    map.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-c * skew(position)));
    map.fixed_view_mut::<3, 3>(3, 3).copy_from(&c);
    map
}

/// Mass blocks by the element's own inertia points.
pub fn mass<const N: usize>(beam: &Beam<N>, state: &BeamState<N>) -> ElementMass<N> {
    mass_at(beam, state, beam.inertia_points())
}

/// Mass blocks by given points.
pub fn mass_at<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    points: &[InertiaPoint<N>],
) -> ElementMass<N> {
    let field = RotationField::new(&state.triads);
    let mut out =
        ElementMass { ss: [[Matrix6::zeros(); N]; N], sr: [Matrix6::zeros(); N], rr: Matrix6::zeros() };
    for point in points {
        let section = SectionState::new(state, &field, &point.shape);
        let j = structural_map(beam, state, &section, point);
        let a_rc = rigid_map(&section.rotation.triad, &section.position);
        let m = point.mass * point.weight;
        let m_a = m * a_rc;
        out.rr += a_rc.transpose() * m_a;
        for a in 0..N {
            out.sr[a] += j[a].transpose() * m_a;
            let left = j[a].transpose() * m;
            for b in 0..N {
                out.ss[a][b] += left * j[b];
            }
        }
    }
    out
}
