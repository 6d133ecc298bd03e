//! Sums over the inertia sections of the structure in its modes: energy by direction, momentum.
//!
//! They go back to the section velocities and do not use the assembled matrices, so they check those.

use nalgebra::{Vector3, Vector6};

use super::modal_mass::{SectionRates, Shapes, visit_lump, visit_points};
use super::modes::Modes;
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::internal_force::{split, stack};

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
    let mut add = |section: SectionRates<'_>| {
        let triad = section.a_rc.fixed_view::<3, 3>(0, 0).transpose();
        for (l, section_velocity) in section.whole().iter().enumerate() {
            let (p, h) = split(&(section.mass * section_velocity));
            let (v, w) = split(section_velocity);
            let (v, w, p, h) = (triad * v, triad * w, triad * p, triad * h);
            share[l] += stack(&v.component_mul(&p), &w.component_mul(&h));
            momentum[l] += p;
        }
    };
    let shapes = Shapes::from(modes);
    for beam in &assembly.beams {
        match beam {
            AnyBeam::Two(b) => visit_points(b, at, shapes, b.inertia_points(), &mut add),
            AnyBeam::Three(b) => visit_points(b, at, shapes, b.inertia_points(), &mut add),
        }
    }
    for lump in &assembly.lumped {
        visit_lump(lump, at, shapes, &mut add);
    }
    SectionSums { kinetic_share: share.iter().flat_map(|s| (s / s.sum()).data.0[0]).collect(), momentum }
}
