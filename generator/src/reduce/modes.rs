//! Elastic modes about a configuration (theory section 4), free-free or of the clamped structure, scaled to unit generalised mass and
//! fixed in sign.
//!
//! The shapes are relative to frame A on the reference node; `phi_R` is the motion of A itself in the mode.

use nalgebra::{DMatrix, Vector6};

use super::modal_mass::{ModalMass, Shapes, modal_mass};
use crate::assembly::{AnyBeam, Assembly, BlockMatrix, MassMatrix};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::internal_force::{geometric_stiffness, strain_maps};
use crate::math::so3::skew;
use crate::mesh::Support;
use crate::solve::dense::graded_eigen;
use crate::solve::eigen::{EigenError, Eigenpairs, FreeBody, SturmCount};

/// Modes whose `omega^2` differ by less than this, relatively, span one space in which the solver's choice is arbitrary.
const CLUSTER: f64 = 1e-8;
/// Most modes of a cluster that are computed beyond those asked for.
const MOST_MORE: usize = 6;

/// Elastic modes of the free body.
#[derive(Clone, Debug)]
pub struct Modes {
    /// Circular frequency, rad/s - (m).
    pub omega: Vec<f64>,
    /// `phi_S`: nodal `(R, theta)` per unit amplitude, mode by mode within a node; zero at the reference node - (n x m).
    pub phi_s: Vec<Vector6<f64>>,
    /// `phi_R`: rates of A per unit modal rate - (m).
    pub phi_r: Vec<Vector6<f64>>,
    /// Frequency of the next mode above, if known, rad/s.
    pub next_omega: Option<f64>,
    /// Proof that no mode below was missed.
    pub sturm: Option<SturmCount>,
    /// Largest entry of `Phi^t M Phi - I`, rigid rows included (scaled by the rigid masses).
    pub orthogonality_error: f64,
    /// Largest relative difference between the iteration's `omega^2` and the energy quotient.
    pub frequency_error: f64,
    /// How many of them, the last, are residual modes ([`super::residual`]) and not modes of the structure.
    pub residual: usize,
}

impl Modes {
    /// Number of modes.
    pub fn m(&self) -> usize {
        self.omega.len()
    }

    /// The modes with the given numbers, from 1, in that order.
    pub fn select(self, numbers: &[usize]) -> Self {
        let m = self.m();
        let pick = |j: &usize| j - 1;
        let phi_s = if m == 0 {
            Vec::new()
        } else {
            self.phi_s.chunks_exact(m).flat_map(|node| numbers.iter().map(move |j| node[pick(j)])).collect()
        };
        Self {
            omega: numbers.iter().map(|j| self.omega[pick(j)]).collect(),
            phi_s,
            phi_r: numbers.iter().map(|j| self.phi_r[pick(j)]).collect(),
            ..self
        }
    }

    /// These modes, then residual ones.
    pub(super) fn followed_by(
        self,
        residual: Self,
        assembly: &Assembly,
        at: &Configuration,
        mass: &MassMatrix,
    ) -> Self {
        let (m, r) = (self.m(), residual.m());
        let nodes = assembly.unknown.len();
        let mut phi_s = Vec::with_capacity(nodes * (m + r));
        for node in 0..nodes {
            phi_s.extend_from_slice(self.at_node(node));
            phi_s.extend_from_slice(residual.at_node(node));
        }
        let phi_r = [self.phi_r, residual.phi_r].concat();
        Self {
            omega: [self.omega, residual.omega].concat(),
            orthogonality_error: orthogonality_error(assembly, at, mass, &phi_s, &phi_r),
            phi_s,
            phi_r,
            residual: r,
            ..self
        }
    }

    /// `phi_S` of one node - (m).
    pub fn at_node(&self, node: usize) -> &[Vector6<f64>] {
        &self.phi_s[node * self.m()..(node + 1) * self.m()]
    }
}

/// The lowest `count` elastic modes.
pub fn elastic_modes(
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    stiffness: &BlockMatrix,
    count: usize,
) -> Result<Modes, EigenError> {
    modes_of(&FreeBody::new(assembly, at, stiffness, mass)?, assembly, at, mass, count)
}

/// The same of a body whose stiffness has been factorised.
pub fn modes_of(
    body: &FreeBody<'_>,
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    count: usize,
) -> Result<Modes, EigenError> {
    let mut pairs = body.lowest(count)?;
    // A cluster that the last mode is in, whole: how it is divided is not to depend on how many modes are asked for.
    let mut whole = pairs.omega2.len();
    while let (Some(last), Some(next)) = (pairs.omega2.last(), pairs.next_omega2) {
        if next - last > CLUSTER * next || whole >= count + MOST_MORE {
            break;
        }
        whole += 1;
        pairs = body.lowest(whole)?;
    }
    let modes = finish(assembly, at, mass, pairs)?;
    if whole == count {
        return Ok(modes);
    }
    let next_omega = modes.omega.get(count).copied();
    Ok(Modes { next_omega, ..modes.select(&(1..=count).collect::<Vec<_>>()) })
}

/// Rayleigh-Ritz on the energies themselves, then rigid parts, canonical clusters and signs.
pub(super) fn finish(
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    pairs: Eigenpairs,
) -> Result<Modes, EigenError> {
    let m = pairs.omega2.len();
    let mut phi_s = scatter(assembly, &pairs.vectors);
    let mut phi_r = rigid_parts(assembly, mass, &phi_s, m)?;
    let k = reduced_stiffness(assembly, at, &phi_s, m);
    let me = momentum_free(assembly, at, mass, &phi_s, &mut phi_r);
    let (omega2, y) = graded_eigen(&k, &me)?;
    combine(&mut phi_s, &y);
    combine(&mut phi_r, &y);
    let frequency_error =
        omega2.iter().zip(&pairs.omega2).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    let fix = canonical(&absolute_motion(at, &phi_s, &phi_r), &omega2);
    combine(&mut phi_s, &fix);
    combine(&mut phi_r, &fix);

    Ok(Modes {
        omega: omega2.iter().map(|x| x.sqrt()).collect(),
        orthogonality_error: orthogonality_error(assembly, at, mass, &phi_s, &phi_r),
        phi_s,
        phi_r,
        next_omega: pairs.next_omega2.map(f64::sqrt),
        sturm: pairs.sturm,
        frequency_error,
        residual: 0,
    })
}

/// `phi_R = -M_RR^-1 M_RS phi_S`; zero for a clamped structure, which has no rigid motion that its modes could take along.
fn rigid_parts(
    assembly: &Assembly,
    mass: &MassMatrix,
    phi_s: &[Vector6<f64>],
    m: usize,
) -> Result<Vec<Vector6<f64>>, EigenError> {
    let mut momentum = vec![Vector6::zeros(); m];
    if assembly.support == Support::Clamped {
        return Ok(momentum);
    }
    let rr = mass.rr.cholesky().ok_or(EigenError::MassNotDefinite)?;
    for (node, unknown) in assembly.unknown.iter().enumerate() {
        let Some(i) = unknown else { continue };
        for (p, phi) in momentum.iter_mut().zip(&phi_s[node * m..]) {
            *p += mass.sr[*i].transpose() * phi;
        }
    }
    Ok(momentum.iter().map(|p| -rr.solve(p)).collect())
}

/// `Phi^t M Phi` of shapes without momentum; what momentum round-off has left in them is taken out of `phi_R`.
fn momentum_free(
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    phi_s: &[Vector6<f64>],
    phi_r: &mut [Vector6<f64>],
) -> DMatrix<f64> {
    let ModalMass { mut elastic, momentum } = modal_mass(assembly, at, Shapes { phi_s, phi_r });
    let Some(rr) = mass.rr.cholesky().filter(|_| assembly.support == Support::Free) else { return elastic };
    let left: Vec<_> = momentum.iter().map(|p| rr.solve(p)).collect();
    for (c, rigid) in left.iter().enumerate() {
        phi_r[c] -= rigid;
        for (r, p) in momentum.iter().enumerate() {
            elastic[(r, c)] -= p.dot(rigid);
        }
    }
    elastic
}

/// Largest entry of `Phi^t M Phi - I` over the elastic columns, rigid rows scaled by the rigid masses.
fn orthogonality_error(
    assembly: &Assembly,
    at: &Configuration,
    mass: &MassMatrix,
    phi_s: &[Vector6<f64>],
    phi_r: &[Vector6<f64>],
) -> f64 {
    let m = phi_r.len();
    let ModalMass { elastic, momentum } = modal_mass(assembly, at, Shapes { phi_s, phi_r });
    let mut error = (elastic - DMatrix::identity(m, m)).amax();
    let free = assembly.support == Support::Free;
    for p in momentum.iter().filter(|_| free) {
        for c in 0..6 {
            error = error.max(p[c].abs() / mass.rr[(c, c)].sqrt());
        }
    }
    error
}

/// Mode vectors over the unknowns as one array over all nodes - (n x m).
pub(super) fn scatter(assembly: &Assembly, vectors: &[Vec<Vector6<f64>>]) -> Vec<Vector6<f64>> {
    let mut phi_s = Vec::with_capacity(assembly.unknown.len() * vectors.len());
    for unknown in &assembly.unknown {
        phi_s.extend(vectors.iter().map(|v| unknown.map_or_else(Vector6::zeros, |i| v[i])));
    }
    phi_s
}

/// Replaces the modes by their combinations with the columns of `y`.
fn combine(phi_s: &mut [Vector6<f64>], y: &DMatrix<f64>) {
    let m = y.nrows();
    if m == 0 {
        return;
    }
    let mut row = vec![Vector6::zeros(); m];
    for node in phi_s.chunks_exact_mut(m) {
        for (j, out) in row.iter_mut().enumerate() {
            *out = node.iter().enumerate().map(|(i, phi)| phi * y[(i, j)]).sum();
        }
        node.copy_from_slice(&row);
    }
}

/// `Phi_S^t Kstif Phi_S` from the strains of the modes: no difference of large numbers, however fine the mesh.
pub(super) fn reduced_stiffness(
    assembly: &Assembly,
    at: &Configuration,
    phi_s: &[Vector6<f64>],
    m: usize,
) -> DMatrix<f64> {
    let mut k = DMatrix::zeros(m, m);
    for beam in &assembly.beams {
        match beam {
            AnyBeam::Two(b) => add_modal_stiffness(&mut k, b, at, phi_s),
            AnyBeam::Three(b) => add_modal_stiffness(&mut k, b, at, phi_s),
        }
    }
    (&k + k.transpose()) * 0.5
}

fn add_modal_stiffness<const N: usize>(
    k: &mut DMatrix<f64>,
    beam: &Beam<N>,
    at: &Configuration,
    phi_s: &[Vector6<f64>],
) {
    let m = k.nrows();
    let state = at.of(beam);
    let phi = |a: usize, j: usize| &phi_s[beam.nodes[a] * m + j];
    for (point, maps) in beam.stiffness_points().iter().zip(strain_maps(beam, &state)) {
        let strain: Vec<Vector6<f64>> = (0..m).map(|j| (0..N).map(|a| maps[a] * phi(a, j)).sum()).collect();
        for j in 0..m {
            let stress = point.stiffness * strain[j] * point.weight;
            for i in 0..m {
                k[(i, j)] += strain[i].dot(&stress);
            }
        }
    }
    let geometric = geometric_stiffness(beam, &state);
    if geometric.iter().flatten().all(|b| b.amax() == 0.0) {
        return;
    }
    for j in 0..m {
        for a in 0..N {
            let force: Vector6<f64> = (0..N).map(|b| geometric[a][b] * phi(b, j)).sum();
            for i in 0..m {
                k[(i, j)] += phi(a, i).dot(&force);
            }
        }
    }
}

/// Translations of the nodes in space, A's own motion included, and behind them their rotations: rows are (node, axis) - (6n x m). Rotations count
/// by so short an arm that they tell the sign only of modes that hardly translate a node, as torsion of a straight beam.
fn absolute_motion(at: &Configuration, phi_s: &[Vector6<f64>], phi_r: &[Vector6<f64>]) -> DMatrix<f64> {
    let (n, m) = (at.positions.len(), phi_r.len());
    let arm = 1e-4 * at.positions.iter().map(|r| r.norm()).fold(0.0, f64::max);
    let mut out = DMatrix::zeros(6 * n, m);
    for (node, r) in at.positions.iter().enumerate() {
        let rotation = at.rotation_matrix(node);
        for j in 0..m {
            let (v, w) = (phi_r[j].fixed_rows::<3>(0), phi_r[j].fixed_rows::<3>(3));
            let phi = &phi_s[node * m + j];
            let t = phi.fixed_rows::<3>(0) + v - skew(r) * w;
            let turn = rotation * phi.fixed_rows::<3>(3) + w;
            out.fixed_view_mut::<3, 1>(3 * node, j).copy_from(&t);
            out.fixed_view_mut::<3, 1>(3 * (n + node), j).copy_from(&(turn * arm));
        }
    }
    out
}

/// Orthogonal matrix that makes the modes unique.
///
/// In a cluster of equal frequencies each mode in turn takes over all of the motion at its own pivot row, so the result
/// does not depend on the basis the solver happened to find. Then the pivot row of every mode is made positive. The pivot
/// is the first row of at least half the largest size: on a beam neighbouring rows have the same sign there, so round-off
/// cannot change the choice.
fn canonical(motion: &DMatrix<f64>, omega2: &[f64]) -> DMatrix<f64> {
    let m = omega2.len();
    let mut q = DMatrix::identity(m, m);
    let mut start = 0;
    while start < m {
        let end = (start + 1..m).find(|&j| omega2[j] - omega2[j - 1] > CLUSTER * omega2[j]).unwrap_or(m);
        for j in start..end {
            let current = motion * q.columns(j, end - j);
            let size: Vec<f64> = current.row_iter().map(|r| r.norm()).collect();
            let largest = size.iter().copied().fold(0.0, f64::max);
            let Some(pivot) = size.iter().position(|&s| s >= 0.5 * largest && s > 0.0) else { continue };
            let direction = current.row(pivot).transpose() / size[pivot];
            align_first(&mut q, j, &direction);
        }
        start = end;
    }
    q
}

/// Householder reflection of columns `j..` of `q` so that the first becomes their combination with `direction`.
fn align_first(q: &mut DMatrix<f64>, j: usize, direction: &nalgebra::DVector<f64>) {
    let p = direction.len();
    if p == 1 {
        let flipped = q.column(j) * direction[0].signum();
        q.set_column(j, &flipped);
        return;
    }
    // H maps e1 to the direction: H = I - 2 u u^t / u^t u with u = e1 - direction.
    let mut u = -direction.clone();
    u[0] += 1.0;
    let square = u.norm_squared();
    if square > 0.0 {
        let block = q.columns(j, p).into_owned();
        let reflected = &block - (&block * &u) * (u.transpose() * (2.0 / square));
        q.columns_mut(j, p).copy_from(&reflected);
    }
}
