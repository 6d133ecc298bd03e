//! Modes about a shape with the figures that describe them.

use nalgebra::{Vector3, Vector6};

use super::symmetry::{MirrorPlane, Parity, mirror_planes, parity};
use super::{Support, VibrationError};
use crate::assembly::{Assembly, MassMatrix};
use crate::configuration::Configuration;
use crate::element::internal_force::split;
use crate::mesh::Mesh;
use crate::reduce::modes::{Modes, elastic_modes};
use crate::reduce::sections::section_sums;

/// Modes about a shape, ascending in frequency.
#[derive(Clone, Debug)]
pub struct ModeSet {
    /// The shape they are about.
    pub at: Configuration,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in A, m.
    pub centre_of_mass: Vector3<f64>,
    /// What holds the structure.
    pub support: Support,
    /// Planes through the centre of mass about which the nodes are mirror images of each other.
    pub planes: Vec<MirrorPlane>,
    /// The modes.
    pub modes: Vec<Shape>,
    /// Frequency of the next mode above, if known, rad/s.
    pub next_omega: Option<f64>,
}

/// One mode, scaled to `phi^t M phi = 1 kg m^2`: its amplitude has the unit 1, its shape the units per unit amplitude.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Circular frequency, rad/s.
    pub omega: f64,
    /// Displacements of the nodes in space, the motion of A included, axes of A, m - (nodes).
    pub translations: Vec<Vector3<f64>>,
    /// Rotations of the nodes, axes of A, rad - (nodes).
    pub rotations: Vec<Vector3<f64>>,
    /// Motion of A: translation (m), rotation (rad); zero where it is clamped.
    pub frame: Vector6<f64>,
    /// Generalised mass with the largest displacement of a node scaled to 1 m, kg; infinite where no node moves but turns.
    pub mass_at_unit_displacement: f64,
    /// Share of the kinetic energy: translation along and rotation about x, y, z of A.
    pub kinetic_share: [f64; 6],
    /// Linear momentum over the root of the mass: what the centre of mass moves, scaled to round-off for free modes.
    pub drift: f64,
    /// Masses that take part when the clamped node is shaken: along (kg) and about (kg m^2) x, y, z of A. Zero for free modes.
    pub effective_mass: [f64; 6],
    /// Symmetry about each of the planes of the set.
    pub parity: Vec<Parity>,
}

/// The lowest `count` elastic modes about a shape.
///
/// # Errors
/// An unstable shape, a mechanism, more modes than there are.
pub fn analyse(
    mesh: &Mesh,
    at: Configuration,
    support: Support,
    count: usize,
) -> Result<ModeSet, VibrationError> {
    let mut assembly = Assembly::new(mesh);
    assembly.support = support;
    let mass = assembly.mass(&at);
    let stiffness = assembly.stiffness(&at);
    let modes = elastic_modes(&assembly, &at, &mass, &stiffness, count)?;
    let sums = section_sums(&assembly, &at, &modes);
    let (total, centre) = Assembly::centre_of_mass(&mass.rr);
    let planes = mirror_planes(&at.positions, &centre);
    let size = at.positions.iter().map(|r| (r - centre).norm()).fold(0.0, f64::max);
    let shape = |j: usize| {
        let (translations, rotations) = in_space(&at, &modes, j);
        let largest = translations.iter().map(Vector3::norm).fold(0.0, f64::max);
        let turned = rotations.iter().map(Vector3::norm).fold(0.0, f64::max);
        // Displacements that are round-off of a turn about the axis of the members.
        let moves = largest > 1e-9 * size * turned;
        Shape {
            omega: modes.omega[j],
            frame: modes.phi_r[j],
            mass_at_unit_displacement: if moves { 1.0 / (largest * largest) } else { f64::INFINITY },
            kinetic_share: std::array::from_fn(|k| sums.kinetic_share[6 * j + k]),
            drift: sums.momentum[j].norm() / total.sqrt(),
            effective_mass: match support {
                Support::Free => [0.0; 6],
                Support::Clamped => participation(&assembly, &mass, &modes, j).map(|p| p * p).into(),
            },
            parity: planes.iter().map(|plane| parity(plane, &translations, &rotations, 0.1 * size)).collect(),
            translations,
            rotations,
        }
    };
    let shapes = (0..modes.m()).map(shape).collect();
    Ok(ModeSet {
        mass: total,
        centre_of_mass: centre,
        support,
        planes,
        modes: shapes,
        next_omega: modes.next_omega,
        at,
    })
}

/// `M_RS phi_S`: momentum and moment of momentum about A per unit rate of a mode.
fn participation(assembly: &Assembly, mass: &MassMatrix, modes: &Modes, j: usize) -> Vector6<f64> {
    let rows = assembly.unknown.iter().enumerate().filter_map(|(node, row)| Some((node, (*row)?)));
    rows.map(|(node, row)| mass.sr[row].transpose() * modes.at_node(node)[j]).sum()
}

/// Displacements and rotations of the nodes in space in one mode, axes of A.
pub(super) fn in_space(
    at: &Configuration,
    modes: &Modes,
    j: usize,
) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let (v, w) = split(&modes.phi_r[j]);
    let nodes = at.positions.iter().zip(&at.rotations).enumerate();
    nodes
        .map(|(node, (r, q))| {
            let (translation, rotation) = split(&modes.at_node(node)[j]);
            (translation + v + w.cross(r), q * rotation + w)
        })
        .unzip()
}
