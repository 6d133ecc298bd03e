//! Mass matrix and momenta of modes, summed over the velocities of the sections in space.
//!
//! `Phi^t M_eff Phi` from the assembled blocks is the small difference of large numbers where a heavy part is far from a light
//! reference node: relative to the node it moves a lot, in space hardly. Here the motion of A is added before anything is squared.

use nalgebra::{DMatrix, Matrix6, Vector6};

use super::modes::Modes;
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::beam::{Beam, InertiaPoint, SectionState};
use crate::element::inertia::{rigid_map, structural_map};
use crate::element::rotation_field::RotationField;
use crate::mesh::LumpedMass;

/// Shapes relative to A and the motion of A in each, in the layout of [`Modes`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Shapes<'a> {
    /// `phi_S` - (n x m).
    pub phi_s: &'a [Vector6<f64>],
    /// `phi_R` - (m).
    pub phi_r: &'a [Vector6<f64>],
}

impl<'a> From<&'a Modes> for Shapes<'a> {
    fn from(modes: &'a Modes) -> Self {
        Self { phi_s: &modes.phi_s, phi_r: &modes.phi_r }
    }
}

impl Shapes<'_> {
    fn at_node(&self, node: usize) -> &[Vector6<f64>] {
        let m = self.phi_r.len();
        &self.phi_s[node * m..(node + 1) * m]
    }
}

/// What the sections add up to.
#[derive(Clone, Debug)]
pub(super) struct ModalMass {
    /// `Phi^t M Phi` with the rigid rows - (m x m).
    pub elastic: DMatrix<f64>,
    /// Momentum and moment of momentum about A per unit rate, `M_RS phi_S + M_RR phi_R` - (m).
    pub momentum: Vec<Vector6<f64>>,
}

/// Sums over all sections and lumped masses about a configuration.
pub(super) fn modal_mass(assembly: &Assembly, at: &Configuration, shapes: Shapes<'_>) -> ModalMass {
    let m = shapes.phi_r.len();
    let mut sum = ModalMass { elastic: DMatrix::zeros(m, m), momentum: vec![Vector6::zeros(); m] };
    for (index, beam) in assembly.beams.iter().enumerate() {
        match beam {
            AnyBeam::Two(b) => add_element(&mut sum, assembly, index, b, at, shapes),
            AnyBeam::Three(b) => add_element(&mut sum, assembly, index, b, at, shapes),
        }
    }
    for lump in &assembly.lumped {
        visit_lump(lump, at, shapes, &mut |section| sum.add_whole(section));
    }
    sum.elastic = (&sum.elastic + sum.elastic.transpose()) * 0.5;
    sum
}

impl ModalMass {
    fn add(&mut self, mass: &Matrix6<f64>, rates: &[Vector6<f64>]) {
        for (c, rate) in rates.iter().enumerate() {
            let momentum = mass * rate;
            for (r, other) in rates.iter().enumerate() {
                self.elastic[(r, c)] += other.dot(&momentum);
            }
        }
    }

    fn add_whole(&mut self, section: SectionRates<'_>) {
        let rates = section.whole();
        self.add(section.mass, &rates);
        let map = section.a_rc.transpose() * section.mass;
        for (p, rate) in self.momentum.iter_mut().zip(&rates) {
            *p += map * rate;
        }
    }
}

fn add_element<const N: usize>(
    sum: &mut ModalMass,
    assembly: &Assembly,
    index: usize,
    beam: &Beam<N>,
    at: &Configuration,
    shapes: Shapes<'_>,
) {
    let Some(reduced) = assembly.coupling_points(index, beam) else {
        return visit_points(beam, at, shapes, beam.inertia_points(), &mut |section| sum.add_whole(section));
    };
    // M_SS by all points, the rest by fewer: the whole by the fewer, and the difference of M_SS.
    visit_points(beam, at, shapes, beam.inertia_points(), &mut |section| {
        sum.add(section.mass, section.elastic);
    });
    visit_points(beam, at, shapes, &reduced, &mut |section| {
        sum.add(&-section.mass, section.elastic);
        sum.add_whole(section);
    });
}

/// An inertia section in the modes: velocities in its own axes per unit modal rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectionRates<'a> {
    /// Mass matrix times the weight of the section.
    pub mass: &'a Matrix6<f64>,
    /// `A_RC`.
    pub a_rc: &'a Matrix6<f64>,
    /// Relative to A - (m).
    pub elastic: &'a [Vector6<f64>],
    /// By the motion of A - (m).
    pub rigid: &'a [Vector6<f64>],
}

impl SectionRates<'_> {
    /// In space - (m).
    pub(super) fn whole(&self) -> Vec<Vector6<f64>> {
        self.elastic.iter().zip(self.rigid).map(|(e, r)| e + r).collect()
    }
}

/// Calls `visitor` at some inertia points of an element.
pub(super) fn visit_points<const N: usize>(
    beam: &Beam<N>,
    at: &Configuration,
    shapes: Shapes<'_>,
    points: &[InertiaPoint<N>],
    visitor: &mut dyn FnMut(SectionRates<'_>),
) {
    let state = at.of(beam);
    let field = RotationField::new(&state.triads);
    for point in points {
        let section = SectionState::new(&state, &field, &point.shape);
        let j = structural_map(beam, &state, &section, point);
        let a_rc = rigid_map(&section.rotation.triad, &section.position);
        let elastic: Vec<Vector6<f64>> = (0..shapes.phi_r.len())
            .map(|l| (0..N).map(|a| j[a] * shapes.at_node(beam.nodes[a])[l]).sum())
            .collect();
        let rigid: Vec<_> = shapes.phi_r.iter().map(|r| a_rc * r).collect();
        let mass = point.mass * point.weight;
        visitor(SectionRates { mass: &mass, a_rc: &a_rc, elastic: &elastic, rigid: &rigid });
    }
}

/// Calls `visitor` for a lumped mass.
pub(super) fn visit_lump(
    lump: &LumpedMass,
    at: &Configuration,
    shapes: Shapes<'_>,
    visitor: &mut dyn FnMut(SectionRates<'_>),
) {
    let q = at.rotation_matrix(lump.node);
    let a_rc = rigid_map(&q, &at.positions[lump.node]);
    let mut j = Matrix6::identity();
    j.fixed_view_mut::<3, 3>(0, 0).copy_from(&q.transpose());
    let elastic: Vec<_> = shapes.at_node(lump.node).iter().map(|s| j * s).collect();
    let rigid: Vec<_> = shapes.phi_r.iter().map(|r| a_rc * r).collect();
    visitor(SectionRates { mass: &lump.mass, a_rc: &a_rc, elastic: &elastic, rigid: &rigid });
}
