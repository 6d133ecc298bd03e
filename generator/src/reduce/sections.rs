//! Sums over the inertia sections of the structure in its modes: energy by direction, momentum.
//!
//! They go back to the section velocities and do not use the assembled matrices, so they check those.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::modes::Modes;
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::beam::{Beam, SectionState};
use crate::element::inertia::{rigid_map, structural_map};
use crate::element::internal_force::{split, stack};
use crate::element::rotation_field::RotationField;

/// What the sections add up to.
#[derive(Clone, Debug)]
pub struct SectionSums {
    /// Share of each mode's kinetic energy by direction: translation along and rotation about x, y, z of A; the power of
    /// each component of momentum and velocity, over the whole - (m x 6).
    pub kinetic_share: Vec<f64>,
    /// Linear momentum of each mode per unit rate, in A, A's own motion included, kg m/s - (m).
    pub momentum: Vec<Vector3<f64>>,
}

/// Sums over all sections and lumped masses.
pub fn section_sums(assembly: &Assembly, at: &Configuration, modes: &Modes) -> SectionSums {
    let m = modes.m();
    let mut share = vec![Vector6::zeros(); m];
    let mut momentum = vec![Vector3::zeros(); m];
    let mut add = |triad: &Matrix3<f64>, mass: &Matrix6<f64>, velocity: &dyn Fn(usize) -> Vector6<f64>| {
        for l in 0..m {
            let section_velocity = velocity(l);
            let (p, h) = split(&(mass * section_velocity));
            let (v, w) = split(&section_velocity);
            let (v, w, p, h) = (triad * v, triad * w, triad * p, triad * h);
            share[l] += stack(&v.component_mul(&p), &w.component_mul(&h));
            momentum[l] += p;
        }
    };
    for beam in &assembly.beams {
        match beam {
            AnyBeam::Two(b) => visit_sections(b, at, modes, &mut add),
            AnyBeam::Three(b) => visit_sections(b, at, modes, &mut add),
        }
    }
    for lump in &assembly.lumped {
        let q = at.rotation_matrix(lump.node);
        let a_rc = rigid_map(&q, &at.positions[lump.node]);
        add(&q, &lump.mass, &|l| {
            let (v, w) = split(&modes.at_node(lump.node)[l]);
            stack(&(q.transpose() * v), &w) + a_rc * modes.phi_r[l]
        });
    }
    SectionSums { kinetic_share: share.iter().flat_map(|s| (s / s.sum()).data.0[0]).collect(), momentum }
}

type SectionVisitor<'a> = dyn FnMut(&Matrix3<f64>, &Matrix6<f64>, &dyn Fn(usize) -> Vector6<f64>) + 'a;

/// Calls `visit` with triad, weighted mass and modal section velocities at every inertia point of an element.
fn visit_sections<const N: usize>(
    beam: &Beam<N>,
    at: &Configuration,
    modes: &Modes,
    visit: &mut SectionVisitor<'_>,
) {
    let state = at.of(beam);
    let field = RotationField::new(&state.triads);
    for point in beam.inertia_points() {
        let section = SectionState::new(&state, &field, &point.shape);
        let j = structural_map(beam, &state, &section, point);
        let a_rc = rigid_map(&section.rotation.triad, &section.position);
        visit(&section.rotation.triad, &(point.mass * point.weight), &|l| {
            let elastic: Vector6<f64> = (0..N).map(|a| j[a] * modes.at_node(beam.nodes[a])[l]).sum();
            elastic + a_rc * modes.phi_r[l]
        });
    }
}
