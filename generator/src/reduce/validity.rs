//! What a reduced model leaves out: second derivatives of its shapes and what they meet, and the amplitudes and rates up to which
//! that is small (docs/validity.md).
//!
//! ```text
//! K_SS Theta_ij = - d2 f_int(phi_i, phi_j)                                    static modal derivatives
//! e = Theta . Qstif(eta0),  (s, h) = M_RS Theta,  w G w = Theta . Qgyr(eta0, 0, w),  t_k = Theta . M_SS phi_k
//! ```

use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3, Vector6};
use rayon::prelude::*;
use rom_runtime::data::ValidityData;
use rom_runtime::loads::DistributedLoad;

use super::missing::{loaded_points, missing};
use super::missing_lines::{LineStations, declared};
use super::modes::Modes;
use super::second_forces::SecondForces;
use super::tensors::Tensors;
use crate::assembly::{Assembly, BlockMatrix, MassMatrix};
use crate::carrier::Carrier;
use crate::configuration::Configuration;
use crate::equilibrium::SteadyMotion;
use crate::mesh::Mesh;
use crate::solve::dense::symmetric_eigen;
use crate::solve::eigen::{EigenError, FreeBody};

/// Most modes whose pairs are kept: what is stored grows with their square.
const MOST_MODES: usize = 40;
/// Everything a model is to know of its limits. `distributed`: loads per length of the equilibrium, which act besides those of the load
/// cases.
///
/// # Errors
/// As for the modes.
#[allow(clippy::too_many_arguments)]
pub fn validity(
    mesh: &Mesh,
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    body: &FreeBody<'_>,
    modes: &Modes,
    tensors: &Tensors,
    distributed: &[DistributedLoad],
) -> Result<ValidityData, EigenError> {
    let m = modes.m();
    let kept = m.min(MOST_MODES);
    let forces = SecondForces::new(assembly, at, modes);
    let fields = Fields::new(assembly, at, mass, modes);
    let lines = declared(mesh, distributed);
    let mut out = ValidityData {
        modes: kept as u32,
        fields: Vec::with_capacity(kept * (kept + 1) / 2 * (13 + m)),
        points: vec![Vec::new(); mesh.points.len()],
        amplitude: Vec::with_capacity(2 * m),
        stiffening: vec![0.0; 3 * m],
        curve: None,
        missing: missing(mesh, assembly, at, mass, body, modes, &loaded_points(mesh), lines)?,
    };
    let mut curvature = vec![0.0; m];
    let carriers: Vec<_> = Carrier::of_points(mesh).iter().map(|carrier| carrier.placed(at)).collect();
    let on_lines: Vec<_> = out.missing.lines.iter().map(|line| LineStations::new(mesh, at, line)).collect();
    let at_node = |theta: &'_ [Vector6<f64>], node: usize| {
        assembly.unknown[node].map_or_else(Vector6::zeros, |block| theta[block])
    };
    let at_points = |theta: &[Vector6<f64>]| {
        let at_point = |maps: &Vec<(usize, Matrix6<f64>)>| {
            maps.iter().map(|(node, map)| map * at_node(theta, *node)).sum()
        };
        carriers.iter().map(at_point).collect()
    };
    // Every mode with those after it, by itself: in their order whichever thread has it.
    let found: Vec<Vec<Pair>> = (0..kept)
        .into_par_iter()
        .map(|i| {
            let mut thetas = forces.along(i, kept);
            body.held_responses(&mut thetas);
            let pair = |(above, theta): (usize, &Vec<Vector6<f64>>)| Pair {
                row: fields.row(theta),
                curvature: if above == 0 { 0.5 * fields.relative_length(theta, i) } else { 0.0 },
                points: at_points(theta),
                lines: on_lines.iter().map(|line| line.read_curvature(|node| at_node(theta, node))).collect(),
            };
            thetas.iter().enumerate().map(pair).collect()
        })
        .collect();
    let found: Vec<Pair> = found.into_iter().flatten().collect();
    let pairs = (0..kept).flat_map(|i| (i..kept).map(move |j| (i, j)));
    for ((i, j), pair) in pairs.zip(&found) {
        if i == j {
            let weight = 1.0 / (modes.omega[i] * modes.omega[i]);
            (0..3).for_each(|axis| out.stiffening[3 * i + axis] = pair.row[7 + axis].abs() * weight);
            curvature[i] = pair.curvature;
        }
        out.fields.extend(&pair.row);
    }
    for (point, to) in out.points.iter_mut().enumerate() {
        to.extend((0..6).flat_map(|k| found.iter().map(move |pair| pair.points[point][k])));
    }
    for (index, line) in out.missing.lines.iter_mut().enumerate() {
        line.curvature.extend(found.iter().flat_map(|pair| &pair.lines[index]));
    }
    let inertia = inertia_change(mass, modes, tensors)?;
    out.amplitude =
        inertia.into_iter().zip(curvature).flat_map(|(inertia, curvature)| [inertia, curvature]).collect();
    Ok(out)
}

/// What the second derivative of the shapes along a pair of modes meets.
struct Pair {
    /// `e, s, h, G, t` - (13 + m).
    row: Vec<f64>,
    /// Of a mode with itself: its length over twice that of the mode.
    curvature: f64,
    /// At the named points.
    points: Vec<Vector6<f64>>,
    /// As the loads per length read it.
    lines: Vec<Vec<f64>>,
}

/// What the second derivatives are multiplied with, over the unknowns.
struct Fields {
    elastic: Vec<Vector6<f64>>,
    /// `Qgyr` of the unit spins: xx, yy, zz, yz, xz, xy.
    gyroscopic: [Vec<Vector6<f64>>; 6],
    rigid: Vec<Matrix6<f64>>,
    /// `M_SS phi_k` - (m).
    inertia: Vec<Vec<Vector6<f64>>>,
    /// `sqrt(phi_k^t M_SS phi_k)` - (m).
    length: Vec<f64>,
    mass: BlockMatrix,
}

impl Fields {
    fn new(assembly: &Assembly, at: &Configuration, mass: &MassMatrix, modes: &Modes) -> Self {
        let gyroscopic = |spin: Vector3<f64>| {
            let mut nodal = vec![Vector6::zeros(); at.positions.len()];
            let mut beta = Vector6::zeros();
            beta.fixed_rows_mut::<3>(3).copy_from(&spin);
            SteadyMotion { beta }.add_force(assembly, at, 1.0, &mut nodal);
            assembly.gather(&nodal)
        };
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        let own = [x, y, z].map(gyroscopic);
        let mixed = |a: usize, b: usize| {
            let both = gyroscopic([x, y, z][a] + [x, y, z][b]);
            both.iter().zip(&own[a]).zip(&own[b]).map(|((both, a), b)| both - a - b).collect()
        };
        let (yz, xz, xy) = (mixed(1, 2), mixed(0, 2), mixed(0, 1));
        let [xx, yy, zz] = own;
        let shape = |k: usize| -> Vec<Vector6<f64>> {
            let nodal: Vec<_> = (0..at.positions.len()).map(|node| modes.at_node(node)[k]).collect();
            assembly.gather(&nodal)
        };
        let (mut inertia, mut length) = (Vec::new(), Vec::new());
        for k in 0..modes.m() {
            let phi = shape(k);
            let mut momentum = vec![Vector6::zeros(); phi.len()];
            mass.ss.multiply(&phi, &mut momentum);
            length.push(product(&phi, &momentum).max(0.0).sqrt());
            inertia.push(momentum);
        }
        Self {
            elastic: assembly.gather(&assembly.elastic_force(at)),
            gyroscopic: [xx, yy, zz, yz, xz, xy],
            rigid: mass.sr.clone(),
            inertia,
            length,
            mass: mass.ss.clone(),
        }
    }

    /// `e, s, h, G, t` of a pair - (13 + m).
    fn row(&self, theta: &[Vector6<f64>]) -> Vec<f64> {
        let momentum: Vector6<f64> = self.rigid.iter().zip(theta).map(|(sr, x)| sr.transpose() * x).sum();
        let mut row = vec![product(theta, &self.elastic)];
        row.extend(momentum.iter());
        row.extend(self.gyroscopic.iter().map(|field| product(theta, field)));
        row.extend(self.inertia.iter().map(|field| product(theta, field)));
        row
    }

    /// Length of `theta` over that of mode `i`, both in the mass matrix.
    fn relative_length(&self, theta: &[Vector6<f64>], i: usize) -> f64 {
        let mut momentum = vec![Vector6::zeros(); theta.len()];
        self.mass.multiply(theta, &mut momentum);
        product(theta, &momentum).max(0.0).sqrt() / self.length[i].max(f64::MIN_POSITIVE)
    }
}

fn product(a: &[Vector6<f64>], b: &[Vector6<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

/// Relative change of the mass matrix per unit amplitude of each mode: largest eigenvalue of `dM/dq_i` over `M`, in the coordinates
/// `(q_dot, beta*)`.
fn inertia_change(mass: &MassMatrix, modes: &Modes, tensors: &Tensors) -> Result<Vec<f64>, EigenError> {
    let m = modes.m();
    let n = m + 6;
    let rr = mass.rr.cholesky().ok_or(EigenError::MassNotDefinite)?.l();
    let rr_inverse = rr.try_inverse().ok_or(EigenError::MassNotDefinite)?;
    let phi_r = DMatrix::from_fn(6, m, |r, i| modes.phi_r[i][r]);
    // Columns (q_dot, beta*) of (x_dot, beta), scaled by the root of the mass matrix.
    let mut basis = DMatrix::identity(n, n);
    basis.view_mut((m, 0), (6, m)).copy_from(&phi_r);
    let scaled = DMatrix::from_fn(6, 6, |i, j| rr_inverse[(j, i)]);
    basis.view_mut((m, m), (6, 6)).copy_from(&scaled);
    let relative: Vec<DMatrix<f64>> = (3..6)
        .map(|r| {
            let mut transform = DMatrix::identity(n, n);
            transform.view_mut((m, 0), (6, m)).copy_from(&(-&phi_r));
            transform.transpose() * &tensors.c[r] * transform
        })
        .collect();
    (0..m)
        .map(|k| {
            let mut d = DMatrix::zeros(n, n);
            for axis in 0..3 {
                for i in 0..m {
                    let coupling = 0.25 * (relative[axis][(i, k)] - relative[axis][(k, i)]);
                    d[(i, m + 3 + axis)] = coupling;
                    d[(m + 3 + axis, i)] = coupling;
                }
                for other in 0..3 {
                    let j = relative[axis][(k, m + 3 + other)] + relative[other][(k, m + 3 + axis)];
                    d[(m + 3 + axis, m + 3 + other)] = -j;
                }
            }
            // First moment of the mode: M_RS phi_S = -M_RR phi_R.
            let momentum = -(mass.rr * modes.phi_r[k]);
            let s: Matrix3<f64> = crate::math::so3::skew(&momentum.fixed_rows::<3>(0).into_owned());
            for a in 0..3 {
                for b in 0..3 {
                    d[(m + a, m + 3 + b)] = -s[(a, b)];
                    d[(m + 3 + b, m + a)] = -s[(a, b)];
                }
            }
            let change = basis.transpose() * d * &basis;
            let (values, _) = symmetric_eigen(&change)?;
            Ok(values.iter().fold(0.0, |a: f64, b| a.max(b.abs())))
        })
        .collect()
}
