//! Inertia sections about a rest state: what the gyroscopic operators need of each Gauss point, precomputed.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

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
    /// The same for unit forces, which only the levers of element ends turn: on the diagonal - (3 of N of 3 x 3).
    pub lever_turn: Option<[[Matrix3<f64>; N]; 3]>,
}

impl<const N: usize> Station<N> {
    /// The inertia points of an element.
    pub fn of_beam(beam: &Beam<N>, at: &Configuration) -> Vec<Self> {
        let state = at.of(beam);
        let field = RotationField::new(&state.triads);
        let station = |point: &InertiaPoint<N>| {
            let section = SectionState::new(&state, &field, &point.shape);
            Station {
                j: structural_map(beam, &state, &section, point),
                a_rc: rigid_map(&section.rotation.triad, &section.position),
                mass: point.mass * point.weight,
                turn: std::array::from_fn(|k| turning_moment(beam, &field, &section, &unit(k))),
                lever_turn: beam.levers.map(|_| {
                    std::array::from_fn(|k| {
                        let force = section.rotation.triad.column(k).into_owned();
                        std::array::from_fn(|a| {
                            let share = force * point.shape.n[a];
                            beam.lever_turning(&state, a, &share).unwrap_or_else(Matrix3::zeros)
                        })
                    })
                }),
            }
        };
        beam.inertia_points().iter().map(station).collect()
    }
}

impl<const N: usize> Station<N> {
    /// Rotation part of `D_J` for a section force `(f, m)`: block `(a, b)`.
    pub fn turning(&self, force: &Vector6<f64>, a: usize, b: usize) -> Matrix3<f64> {
        let mut block: Matrix3<f64> = (0..3).map(|k| self.turn[k][a][b] * force[3 + k]).sum();
        if let Some(levers) = self.lever_turn.as_ref().filter(|_| a == b) {
            block += (0..3).map(|k| levers[k][a] * force[k]).sum::<Matrix3<f64>>();
        }
        block
    }
}

impl Station<1> {
    /// A mass on a node: the spin of the node is the spin of the mass, so only the curvature of the rotation vector remains.
    pub fn of_mass(lump: &LumpedMass, at: &Configuration) -> Self {
        let q = at.rotation_matrix(lump.node);
        let mut j = Matrix6::identity();
        j.fixed_view_mut::<3, 3>(0, 0).copy_from(&q.transpose());
        let turn = std::array::from_fn(|k| [[skew(&unit(k)) * -0.5]]);
        Station {
            j: [j],
            a_rc: rigid_map(&q, &at.positions[lump.node]),
            mass: lump.mass,
            turn,
            lever_turn: None,
        }
    }
}

fn unit(k: usize) -> Vector3<f64> {
    Vector3::ith(k, 1.0)
}
