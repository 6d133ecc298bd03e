//! Inertia sections about a rest state: what the gyroscopic operators need of each Gauss point, precomputed.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::beam::{Beam, InertiaPoint, SectionState};
use super::gyroscopic::turning_moment;
use super::inertia::{rigid_map, structural_map};
use super::rotation_field::RotationField;
use crate::configuration::Configuration;
use crate::math::so3::skew;
use crate::mesh::LumpedMass;

/// An inertia section and how `N` nodes move it.
#[derive(Clone, Debug)]
pub struct Station<const N: usize> {
    /// `J`: section velocity per nodal rate - (N of 6 x 6).
    pub j: [Matrix6<f64>; N],
    /// `A_RC`: section velocity per rate of A - (6 x 6).
    pub a_rc: Matrix6<f64>,
    /// Section mass times integration weight - (6 x 6).
    pub mass: Matrix6<f64>,
    /// Rotation part of `D_J` for unit moments about the three section axes - (3 of N x N of 3 x 3).
    pub turn: [[[Matrix3<f64>; N]; N]; 3],
}

impl<const N: usize> Station<N> {
    /// The inertia points of an element.
    pub fn of_beam(beam: &Beam<N>, at: &Configuration) -> Vec<Self> {
        let state = at.of(beam);
        let field = RotationField::new(&state.triads);
        let station = |point: &InertiaPoint<N>| {
            let section = SectionState::new(&state, &field, &point.shape);
            Station {
                j: structural_map(beam, &section, point),
                a_rc: rigid_map(&section.rotation.triad, &section.position),
                mass: point.mass * point.weight,
                turn: std::array::from_fn(|k| turning_moment(beam, &field, &section, &unit(k))),
            }
        };
        beam.inertia_points().iter().map(station).collect()
    }
}

impl Station<1> {
    /// A mass on a node: the spin of the node is the spin of the mass, so only the curvature of the rotation vector remains.
    pub fn of_mass(lump: &LumpedMass, at: &Configuration) -> Self {
        let q = at.rotation_matrix(lump.node);
        let mut j = Matrix6::identity();
        j.fixed_view_mut::<3, 3>(0, 0).copy_from(&q.transpose());
        let turn = std::array::from_fn(|k| [[skew(&unit(k)) * -0.5]]);
        Station { j: [j], a_rc: rigid_map(&q, &at.positions[lump.node]), mass: lump.mass, turn }
    }
}

fn unit(k: usize) -> Vector3<f64> {
    Vector3::ith(k, 1.0)
}
