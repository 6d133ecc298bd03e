//! Inertia forces of a steady rigid motion, `Qgyr_S(eta, 0, beta)` of theory section 2, and their derivative in the shape: what makes
//! a rotating blade stretch and stiffen.

use nalgebra::Vector6;

use crate::assembly::{AnyBeam, Assembly, BlockMatrix};
use crate::configuration::Configuration;
use crate::element::gyroscopic::{a_vw, section_stiffness, turning_force};
use crate::element::internal_force::{ElementMatrix, split};
use crate::element::station::Station;
use crate::math::so3::skew;

/// A body whose frame A moves with constant velocities.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SteadyMotion {
    /// `beta = (v, w)` of A in A, m/s and rad/s.
    pub(crate) beta: Vector6<f64>,
}

impl SteadyMotion {
    /// Nothing to add for a body at rest or in straight flight.
    pub(crate) fn turns(&self) -> bool {
        self.beta.fixed_rows::<3>(3).amax() > 0.0
    }

    /// Adds the inertia forces on every node, force in A and moment in the node frame, and returns the sums of the magnitudes of forces
    /// and of moments about A's origin.
    pub(crate) fn add_force(
        &self,
        assembly: &Assembly,
        at: &Configuration,
        factor: f64,
        nodal: &mut [Vector6<f64>],
    ) -> (f64, f64) {
        let mut scales = (0.0, 0.0);
        if !self.turns() {
            return scales;
        }
        let mut add = |node: usize, f: Vector6<f64>| {
            nodal[node] += f * factor;
            let (force, moment) = split(&(f * factor));
            scales.0 += force.norm();
            scales.1 += moment.norm() + at.positions[node].norm() * force.norm();
        };
        for beam in &assembly.beams {
            match beam {
                AnyBeam::Two(b) => self.forces(&b.nodes, &Station::of_beam(b, at), &mut add),
                AnyBeam::Three(b) => self.forces(&b.nodes, &Station::of_beam(b, at), &mut add),
            }
        }
        for lump in &assembly.lumped {
            self.forces(&[lump.node], &[Station::of_mass(lump, at)], &mut add);
        }
        scales
    }

    /// Adds the derivative of the inertia forces in the spins and positions of the nodes.
    pub(crate) fn add_stiffness(
        &self,
        assembly: &Assembly,
        at: &Configuration,
        factor: f64,
        k: &mut BlockMatrix,
    ) {
        if !self.turns() {
            return;
        }
        for beam in &assembly.beams {
            match beam {
                AnyBeam::Two(b) => {
                    for station in Station::of_beam(b, at) {
                        assembly.add(k, &b.nodes, &self.stiffness(&station, factor));
                    }
                }
                AnyBeam::Three(b) => {
                    for station in Station::of_beam(b, at) {
                        assembly.add(k, &b.nodes, &self.stiffness(&station, factor));
                    }
                }
            }
        }
        for lump in &assembly.lumped {
            assembly.add(k, &[lump.node], &self.stiffness(&Station::of_mass(lump, at), factor));
        }
    }

    /// `J^t A_VW Mcs V` of every section.
    fn forces<const N: usize>(
        &self,
        nodes: &[usize; N],
        stations: &[Station<N>],
        add: &mut impl FnMut(usize, Vector6<f64>),
    ) {
        for station in stations {
            let velocity = station.a_rc * self.beta;
            let force = a_vw(&velocity) * (station.mass * velocity);
            for a in 0..N {
                add(nodes[a], station.j[a].tr_mul(&force));
            }
        }
    }

    /// `K_S - Kstif` of one section (theory section 3), about spins: without the `-1/2 m~` of the rotation vector.
    fn stiffness<const N: usize>(&self, station: &Station<N>, factor: f64) -> ElementMatrix<N> {
        let velocity = station.a_rc * self.beta;
        let section = section_stiffness(&station.mass, &velocity, &velocity);
        let (force, _) = split(&section.force);
        let elastic = section.elastic + turning_force(&force);
        std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                let mut block = station.j[a].tr_mul(&(elastic * station.j[b]));
                let mut turn = station.turning(&section.force, a, b);
                if a == b {
                    let (_, nodal_moment) = split(&station.j[a].tr_mul(&section.force));
                    turn += skew(&nodal_moment) * 0.5;
                }
                let mut corner = block.fixed_view_mut::<3, 3>(3, 3);
                corner += turn;
                block * factor
            })
        })
    }
}
