//! Section forces at a place along a member, from those at the stiffness points of the elements around it.
//!
//! At its stiffness points the section forces of an element are those of statics to second order, where the loads vary within it too;
//! between them they are taken linear. An element with two of these points is enough by itself; one with a single point takes its
//! neighbour along the member too, unless something at the node between them makes the forces jump.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::assembly::AnyBeam;
use crate::configuration::Configuration;
use crate::element::beam::{Beam, BeamState};
use crate::element::internal_force::{strain_maps, stresses};
use crate::element::shape::gauss;
use crate::element::viscous::viscous_stresses;
use crate::mesh::{Cut, Mesh, Place};

/// Section axes that differ by less are one and the same.
const SAME_AXES: f64 = 1e-9;

/// Stiffness points with the weights of their section forces.
#[derive(Clone, Debug)]
pub struct SectionProbe {
    points: Vec<(usize, usize, f64)>,
}

impl SectionProbe {
    /// For a place of a mesh.
    pub fn new(mesh: &Mesh, cut: &Cut) -> Self {
        let element = &mesh.elements[cut.element];
        if element.n_nodes == 3 {
            let [(a, _), (b, _)] = [gauss(2)[0], gauss(2)[1]];
            let towards_b = (cut.x - a) / (b - a);
            return Self { points: vec![(cut.element, 0, 1.0 - towards_b), (cut.element, 1, towards_b)] };
        }
        let range = mesh.members[cut.member].elements.clone();
        let before = (cut.element > range.start).then(|| cut.element - 1);
        let after = (cut.element + 1 < range.end).then_some(cut.element + 1);
        let smooth = |neighbour: &usize| is_smooth(mesh, cut.element, *neighbour);
        let (before, after) = (before.filter(smooth), after.filter(smooth));
        let neighbour = if cut.x < 0.5 { before.or(after) } else { after.or(before) };
        let Some(neighbour) = neighbour else { return Self { points: vec![(cut.element, 0, 1.0)] } };
        // From the middle of the element to that of its neighbour, along the member.
        let distance = 0.5 * (element.length + mesh.elements[neighbour].length);
        let sign = if neighbour > cut.element { 1.0 } else { -1.0 };
        let towards = sign * (cut.x - 0.5) * element.length / distance;
        Self { points: vec![(cut.element, 0, 1.0 - towards), (neighbour, 0, towards)] }
    }

    /// Elastic section forces in a configuration.
    pub fn stress(&self, beams: &[AnyBeam], at: &Configuration) -> Vector6<f64> {
        self.sum(|element, point| match &beams[element] {
            AnyBeam::Two(b) => stresses(b, &at.of(b))[point],
            AnyBeam::Three(b) => stresses(b, &at.of(b))[point],
        })
    }

    /// Elastic and viscous section forces of nodes in motion: positions, rotations, and rates `(R, spin)`, velocities in the axes of the
    /// positions and spins in the node frames. Any rigid motion may be left out of the rates.
    pub fn stress_moving(
        &self,
        beams: &[AnyBeam],
        position: impl Fn(usize) -> Vector3<f64>,
        rotation: impl Fn(usize) -> Matrix3<f64>,
        rate: impl Fn(usize) -> Vector6<f64>,
    ) -> Vector6<f64> {
        fn of<const N: usize>(
            beam: &Beam<N>,
            state: &BeamState<N>,
            rate: &impl Fn(usize) -> Vector6<f64>,
            point: usize,
        ) -> Vector6<f64> {
            let elastic = stresses(beam, state)[point];
            if !beam.is_viscous() {
                return elastic;
            }
            elastic + viscous_stresses(beam, state, &beam.nodes.map(rate))[point]
        }
        self.sum(|element, point| match &beams[element] {
            AnyBeam::Two(b) => of(b, &b.state(&position, &rotation), &rate, point),
            AnyBeam::Three(b) => of(b, &b.state(&position, &rotation), &rate, point),
        })
    }

    fn sum(&self, of: impl Fn(usize, usize) -> Vector6<f64>) -> Vector6<f64> {
        self.points.iter().map(|&(element, point, weight)| of(element, point) * weight).sum()
    }

    /// `S B` about a configuration: section forces per `(R, theta)` of the nodes.
    pub fn stress_maps(&self, beams: &[AnyBeam], at: &Configuration) -> Vec<(usize, Matrix6<f64>)> {
        self.maps(beams, at, false)
    }

    /// `S tau B`: the same per rate of the nodes, of damped strains.
    pub fn viscous_maps(&self, beams: &[AnyBeam], at: &Configuration) -> Vec<(usize, Matrix6<f64>)> {
        self.maps(beams, at, true)
    }

    fn maps(&self, beams: &[AnyBeam], at: &Configuration, viscous: bool) -> Vec<(usize, Matrix6<f64>)> {
        fn of<const N: usize>(
            beam: &Beam<N>,
            at: &Configuration,
            point: usize,
            viscous: bool,
        ) -> Vec<(usize, Matrix6<f64>)> {
            let data = &beam.stiffness_points()[point];
            let factor = if viscous { data.retardation } else { 1.0 };
            let maps = strain_maps(beam, &at.of(beam))[point];
            beam.nodes
                .into_iter()
                .zip(maps)
                .map(|(node, map)| (node, data.stiffness * map * factor))
                .collect()
        }
        let mut out = Vec::new();
        for &(element, point, weight) in &self.points {
            let found = match &beams[element] {
                AnyBeam::Two(b) => of(b, at, point, viscous),
                AnyBeam::Three(b) => of(b, at, point, viscous),
            };
            out.extend(found.into_iter().map(|(node, map)| (node, map * weight)));
        }
        out
    }
}

/// Whether nothing at the node between two elements of a member makes section forces jump: no other member, mass, point or kink.
fn is_smooth(mesh: &Mesh, element: usize, neighbour: usize) -> bool {
    let [first, second] = [element.min(neighbour), element.max(neighbour)].map(|k| &mesh.elements[k]);
    let (end, start) = (first.n_nodes - 1, 0);
    let node = first.nodes[end];
    let no_lever = |r: &Vector3<f64>| *r == Vector3::zeros();
    node == second.nodes[start]
        && (first.frames[end] - second.frames[start]).amax() < SAME_AXES
        && no_lever(&first.levers[end])
        && no_lever(&second.levers[start])
        && node != mesh.reference
        && mesh.lumped.iter().all(|lump| lump.node != node)
        && mesh.points.iter().all(|point| !matches!(point.place, Place::Node(n) if n == node))
        && mesh.elements.iter().filter(|e| e.nodes[..e.n_nodes].contains(&node)).count() == 2
}
