//! What the modes of a model miss of the static response to loads on its points and to loads per length (docs/validity.md): the residual
//! flexibility
//!
//! ```text
//! G_PL = D_P^t (K_SS^{-1} (D_L - M_SR M_RR^{-1} R_L) - sum_j phi_j (phi_j^t f_L) / omega_j^2)
//! ```
//!
//! between the node of a loaded point `L` and that of a named point `P`; force and displacement in A, moment and rotation in the axes of
//! the node. With it goes the motion of A, `-M_RR^{-1} M_RS` times that field, as `Phi_R` goes with `Phi_S`.

use nalgebra::Vector6;
use rom_runtime::data::{MissingData, MissingLine};

use super::missing_lines::{Column, LineStations};
use super::modes::Modes;
use super::residual::{CarriedLoad, ResidualSelection, subtract};
use crate::assembly::{Assembly, MassMatrix};
use crate::carrier::Carrier;
use crate::configuration::Configuration;
use crate::element::internal_force::{split, stack};
use crate::mesh::Mesh;
use crate::solve::eigen::{EigenError, FreeBody};

/// Most pairs of loaded and named points that are kept: looking at them is to cost a fraction of a step.
const MOST_PAIRS: usize = 256;

/// Points that carry loads in a load case or in the equilibrium; the first of them where there are many.
pub(super) fn loaded_points(mesh: &Mesh) -> Vec<usize> {
    // All selections but that by name are of points there are.
    let loaded = ResidualSelection::Loaded.points(mesh).unwrap_or_default();
    let most = MOST_PAIRS / mesh.points.len().max(1);
    loaded.iter().map(|loaded| loaded.point).take(most).collect()
}

/// The residual flexibility between some points, loads per length, and all points.
///
/// # Errors
/// A mass matrix of the rigid body that is not positive definite.
#[allow(clippy::too_many_arguments)]
pub(super) fn missing(
    mesh: &Mesh,
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    body: &FreeBody<'_>,
    modes: &Modes,
    loaded: &[usize],
    mut lines: Vec<MissingLine>,
) -> Result<MissingData, EigenError> {
    let rigid_mass = mass.rr.cholesky().ok_or(EigenError::MassNotDefinite)?;
    let mut rigid = Vec::with_capacity(36 * loaded.len());
    let carriers: Vec<_> = Carrier::of_points(mesh).iter().map(|carrier| carrier.placed(at)).collect();
    let mut flexibility = Vec::with_capacity(36 * loaded.len() * carriers.len());
    let held = Vector6::zeros();
    let at_node =
        |psi: &'_ [Vector6<f64>], node: usize| assembly.unknown[node].map_or(held, |block| psi[block]);
    let at_points = |psi: &[Vector6<f64>]| -> Vec<Vector6<f64>> {
        carriers.iter().map(|maps| maps.iter().map(|(node, map)| map * at_node(psi, *node)).sum()).collect()
    };
    let moves_a = |psi: &[Vector6<f64>]| -> Vector6<f64> {
        let momentum: Vector6<f64> = mass.sr.iter().zip(psi).map(|(sr, x)| sr.tr_mul(x)).sum();
        -rigid_mass.solve(&momentum)
    };
    let on_lines: Vec<_> = lines.iter().map(|line| LineStations::new(mesh, at, line)).collect();
    // What every line reads of each source, source by source.
    let mut read: Vec<Vec<Vec<f64>>> = vec![Vec::new(); lines.len()];
    let mut read_by_lines = |psi: Option<&[Vector6<f64>]>| {
        for (read, line) in read.iter_mut().zip(&on_lines) {
            let motion = |node: usize| psi.map_or(held, |psi| at_node(psi, node));
            read.push(line.read(modes, motion));
        }
    };
    for &point in loaded {
        let missed: [Vec<Vector6<f64>>; 6] =
            std::array::from_fn(|k| missed_by_point(mesh, assembly, at, body, modes, point, k));
        let columns = missed.each_ref().map(|psi| at_points(psi));
        let moves_a = missed.each_ref().map(|psi| moves_a(psi));
        for named in 0..carriers.len() {
            flexibility.extend((0..6).flat_map(|row| columns.iter().map(move |column| column[named][row])));
        }
        rigid.extend((0..6).flat_map(|row| moves_a.iter().map(move |velocity| velocity[row])));
        missed.iter().for_each(|psi| read_by_lines(Some(psi)));
    }
    for (line, on_line) in lines.iter_mut().zip(&on_lines) {
        for load in on_line.loads(at.positions.len()) {
            let missed = load.map(|load| missed(assembly, body, modes, &load));
            read_by_lines(missed.as_deref());
            let psi = missed.unwrap_or_else(|| vec![held; assembly.n_blocks()]);
            line.flexibility.extend(at_points(&psi).iter().flatten());
            line.rigid.extend(moves_a(&psi).iter());
        }
    }
    for (line, read) in lines.iter_mut().zip(&read) {
        let readings = read.first().map_or(0, Vec::len);
        line.readings.extend((0..readings).flat_map(|row| read.iter().map(move |source| source[row])));
    }
    let loaded = loaded.iter().map(|&point| point as u32).collect();
    Ok(MissingData { loaded, flexibility, rigid, lines })
}

/// Response to a column of a load per length, less what the modes hold of it - (n).
fn missed(assembly: &Assembly, body: &FreeBody<'_>, modes: &Modes, load: &Column) -> Vec<Vector6<f64>> {
    let Column { nodal, resultant } = load;
    let mut psi = body.static_response(&assembly.gather(nodal), resultant);
    for (j, (omega, phi_r)) in modes.omega.iter().zip(&modes.phi_r).enumerate() {
        let elastic: f64 = nodal.iter().enumerate().map(|(node, f)| modes.at_node(node)[j].dot(f)).sum();
        subtract(assembly, modes, j, (elastic + phi_r.dot(resultant)) / (omega * omega), &mut psi);
    }
    psi
}

/// Response to a unit load on what carries a point, less what the modes hold of it - (n).
fn missed_by_point(
    mesh: &Mesh,
    assembly: &Assembly,
    at: &Configuration,
    body: &FreeBody<'_>,
    modes: &Modes,
    point: usize,
    component: usize,
) -> Vec<Vector6<f64>> {
    let carrier = Carrier::new(mesh, mesh.points[point].place);
    let mut unit = Vector6::zeros();
    unit[component] = 1.0;
    let (position, rotation) = carrier.at(at);
    let (force, moment) = split(&unit);
    let resultant = stack(&force, &(position.cross(&force) + rotation * moment));
    let load = CarriedLoad { carrier: &carrier, force: unit, resultant };
    let mut psi = load.response(assembly, at, body);
    load.subtract_modes(assembly, at, modes, &mut psi);
    psi
}
