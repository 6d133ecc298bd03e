//! Residual modes (residual attachment modes): what the kept modes miss of the static response to loads on named points
//! (theory section 4.1).
//!
//! ```text
//! u_a   = K_SS^{-1} (f_S - M_SR M_RR^{-1} f_R)                 static response, the load balanced by rigid acceleration
//! psi_a = u_a - sum_j phi_j (phi_j^t f_a) / omega_j^2          over the kept modes
//! ```
//!
//! The `psi` carry no momentum and are orthogonal to the kept modes in `M` and in `K`. A Rayleigh-Ritz step among themselves makes
//! them pseudo-modes with `phi^t M phi = 1` and frequencies of their own; from there on they are modes like the others.

use nalgebra::{DMatrix, Vector3, Vector6};
use rom_runtime::data::{ResidualData, ResidualLoad};
use rom_runtime::loads::Load;

use super::modes::{Modes, finish, reduced_stiffness, scatter};
use crate::assembly::{Assembly, MassMatrix};
use crate::carrier::Carrier;
use crate::configuration::Configuration;
use crate::element::internal_force::stack;
use crate::mesh::Mesh;
use crate::solve::dense::symmetric_eigen;
use crate::solve::eigen::{EigenError, Eigenpairs, FreeBody};

/// Directions in which the kept modes miss less than this share of the strain energy of a unit load are left out: the static
/// deflection under the load is then right to this fraction, and nothing is made from round-off.
const NEGLIGIBLE: f64 = 1e-8;

/// Which points get residual modes, which complete the static response to loads on them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ResidualSelection {
    /// None.
    #[default]
    None,
    /// Every point that carries loads, in a load case of the structure or in its equilibrium: for forces where forces act, for moments
    /// where moments do.
    Loaded,
    /// These, by name: for forces, and for moments where moments act.
    Points(Vec<String>),
}

/// What can act on a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadedPoint {
    /// Index in the mesh.
    pub point: usize,
    /// Whether forces act.
    pub forces: bool,
    /// Whether moments act.
    pub moments: bool,
}

/// A unit load along an axis of A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitLoad {
    /// Index of its point in the mesh.
    pub point: usize,
    /// A moment, not a force.
    pub moment: bool,
    /// Axis of A, 0 to 2.
    pub axis: usize,
    /// Share of the strain energy of the static response that the modes of the structure miss, 0 to 1.
    pub missed: f64,
}

impl std::fmt::Display for ResidualSelection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Loaded => f.write_str("all"),
            Self::Points(names) => f.write_str(&names.join(",")),
        }
    }
}

impl ResidualSelection {
    /// What can act on each point selected.
    ///
    /// # Errors
    /// A name that no point has, in words.
    pub fn points(&self, mesh: &Mesh) -> Result<Vec<LoadedPoint>, String> {
        let trim = mesh.trim.iter().flat_map(|trim| &trim.case.loads);
        let loads: Vec<&Load> = trim.chain(mesh.load_cases.iter().flat_map(|case| &case.loads)).collect();
        let acts = |point: usize, vector: fn(&Load) -> [f64; 3]| {
            loads.iter().any(|load| load.point as usize == point && vector(load) != [0.0; 3])
        };
        let loaded = |point: usize| LoadedPoint {
            point,
            forces: acts(point, |load| load.force),
            moments: acts(point, |load| load.moment),
        };
        let find = |name: &String| {
            let index = mesh.points.iter().position(|p| p.name == *name);
            index.map(|index| LoadedPoint { forces: true, ..loaded(index) }).ok_or_else(|| {
                let known: Vec<&str> = mesh.points.iter().map(|p| p.name.as_str()).collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                format!("there is no point `{name}`; the structure has {known}")
            })
        };
        match self {
            Self::None => Ok(Vec::new()),
            Self::Points(names) => names.iter().map(find).collect(),
            Self::Loaded => {
                Ok((0..mesh.points.len()).map(loaded).filter(|p| p.forces || p.moments).collect())
            }
        }
    }
}

/// `modes` followed by residual modes for unit forces and moments on the points; and those unit loads.
///
/// # Errors
/// As for the modes themselves.
pub fn with_residual_modes(
    mesh: &Mesh,
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    body: &FreeBody<'_>,
    modes: Modes,
    points: &[LoadedPoint],
) -> Result<(Modes, Vec<UnitLoad>), EigenError> {
    let mut loads = unit_loads(points);
    let mut vectors = Vec::with_capacity(loads.len());
    for load in &mut loads {
        let carrier = Carrier::new(mesh, mesh.points[load.point].place);
        let (force, resultant) = applied(&mesh.points[load.point].offset, &carrier, at, load);
        let on_carrier = CarriedLoad { carrier: &carrier, force, resultant };
        let mut psi = on_carrier.response(assembly, at, body);
        // Twice the strain energy: f . u, with A moving by -M_RR^{-1} M_RS u_S.
        let total = body.strain_work(&psi);
        let held = on_carrier.subtract_modes(assembly, at, &modes, &mut psi);
        load.missed = if total > 0.0 { (1.0 - held / total).clamp(0.0, 1.0) } else { 0.0 };
        if total > 0.0 {
            psi.iter_mut().for_each(|x| *x /= total.sqrt());
        }
        vectors.push(psi);
    }
    vectors.iter_mut().for_each(|psi| orthogonalise(assembly, mass, &modes, psi));
    let mut kept = independent(assembly, at, &vectors)?;
    // Small parts of their loads' responses have lost digits; what they lack is orthogonality, which the equations rely on.
    kept.iter_mut().for_each(|psi| orthogonalise(assembly, mass, &modes, psi));
    // Never more than the structure has left.
    let room = body.size().saturating_sub(modes.m());
    let kept: Vec<_> = kept.into_iter().take(room).collect();
    let pairs = Eigenpairs { omega2: vec![1.0; kept.len()], vectors: kept, next_omega2: None, sturm: None };
    let residual = finish(assembly, at, mass, pairs)?;
    Ok((modes.followed_by(residual, assembly, at, mass), loads))
}

/// A load on what carries a point: force in A and moment in the carrier's own axes, and the resultant about the origin of A.
pub(super) struct CarriedLoad<'a> {
    pub carrier: &'a Carrier,
    pub force: Vector6<f64>,
    pub resultant: Vector6<f64>,
}

impl CarriedLoad<'_> {
    /// Static response, inertia relieved - (n).
    pub(super) fn response(
        &self,
        assembly: &Assembly,
        at: &Configuration,
        body: &FreeBody<'_>,
    ) -> Vec<Vector6<f64>> {
        let mut forces = vec![Vector6::zeros(); assembly.n_blocks()];
        for (node, map) in self.carrier.placed(at) {
            if let Some(i) = assembly.unknown[node] {
                forces[i] += map.tr_mul(&self.force);
            }
        }
        body.static_response(&forces, &self.resultant)
    }

    /// Takes off the response what the modes hold of it, and gives the work that the load does on that.
    pub(super) fn subtract_modes(
        &self,
        assembly: &Assembly,
        at: &Configuration,
        modes: &Modes,
        psi: &mut [Vector6<f64>],
    ) -> f64 {
        let mut held = 0.0;
        let shapes = self.carrier.shapes(at, |node| modes.at_node(node));
        for (j, (phi_s, phi_r)) in shapes.iter().zip(&modes.phi_r).enumerate() {
            let p = phi_s.dot(&self.force) + phi_r.dot(&self.resultant);
            let amplitude = p / (modes.omega[j] * modes.omega[j]);
            held += p * amplitude;
            subtract(assembly, modes, j, amplitude, psi);
        }
        held
    }
}

/// Forces then moments along the axes of A, point by point.
fn unit_loads(points: &[LoadedPoint]) -> Vec<UnitLoad> {
    let kinds = points.iter().flat_map(|p| [(p.point, false, p.forces), (p.point, true, p.moments)]);
    let loads = kinds
        .filter(|&(.., acts)| acts)
        .flat_map(|(point, moment, _)| (0..3).map(move |axis| UnitLoad { point, moment, axis, missed: 1.0 }));
    loads.collect()
}

/// On what carries the point: force in A, moment in its own axes; and the resultant about the origin of A.
fn applied(
    offset: &Vector3<f64>,
    carrier: &Carrier,
    at: &Configuration,
    load: &UnitLoad,
) -> (Vector6<f64>, Vector6<f64>) {
    let (position, rotation) = carrier.at(at);
    let unit = Vector3::ith(load.axis, 1.0);
    let arm = rotation * offset;
    let (force, moment) = if load.moment { (Vector3::zeros(), unit) } else { (unit, arm.cross(&unit)) };
    (
        stack(&force, &rotation.inverse_transform_vector(&moment)),
        stack(&force, &(position.cross(&force) + moment)),
    )
}

pub(super) fn subtract(
    assembly: &Assembly,
    modes: &Modes,
    j: usize,
    amplitude: f64,
    psi: &mut [Vector6<f64>],
) {
    for (node, unknown) in assembly.unknown.iter().enumerate() {
        if let Some(i) = unknown {
            psi[*i] -= modes.at_node(node)[j] * amplitude;
        }
    }
}

/// Takes off the parts `phi_j phi_j^t M_eff psi` along the kept modes.
fn orthogonalise(assembly: &Assembly, mass: &MassMatrix, modes: &Modes, psi: &mut [Vector6<f64>]) {
    let mut momentum = vec![Vector6::zeros(); psi.len()];
    mass.ss.multiply(psi, &mut momentum);
    let rigid: Vector6<f64> = mass.sr.iter().zip(psi.iter()).map(|(sr, x)| sr.transpose() * x).sum();
    for (j, phi_r) in modes.phi_r.iter().enumerate() {
        let elastic =
            assembly.unknown.iter().enumerate().filter_map(|(node, unknown)| Some((node, (*unknown)?)));
        let along = elastic.map(|(node, i)| modes.at_node(node)[j].dot(&momentum[i])).sum::<f64>()
            + phi_r.dot(&rigid);
        subtract(assembly, modes, j, along, psi);
    }
}

/// Combinations of the vectors that are independent in strain energy, from the largest energy down.
fn independent(
    assembly: &Assembly,
    at: &Configuration,
    vectors: &[Vec<Vector6<f64>>],
) -> Result<Vec<Vec<Vector6<f64>>>, EigenError> {
    let n = vectors.len();
    let gram: DMatrix<f64> = reduced_stiffness(assembly, at, &scatter(assembly, vectors), n);
    let (energy, y) = symmetric_eigen(&gram)?;
    let combine = |k: usize| {
        let scale = 1.0 / energy[k].sqrt();
        (0..assembly.n_blocks())
            .map(|i| vectors.iter().enumerate().map(|(a, psi)| psi[i] * (y[(a, k)] * scale)).sum())
            .collect()
    };
    Ok((0..n).rev().filter(|&k| energy[k] > NEGLIGIBLE).map(combine).collect())
}

/// For the model file.
pub fn residual_data(count: usize, loads: &[UnitLoad]) -> ResidualData {
    let load = |load: &UnitLoad| ResidualLoad {
        point: load.point as u32,
        moment: load.moment,
        axis: load.axis as u32,
        missed: load.missed,
    };
    ResidualData { count: count as u32, loads: loads.iter().map(load).collect() }
}
