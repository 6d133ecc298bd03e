//! Elastic forces of an element and their exact tangent (`Qstif_S` and `Kstif` of theory sections 2 and 3).
//!
//! With `Gam = C R'` and `kappa = T psi'`, `(F, M) = S (Gam - Gam0, kappa - kappa0)`,
//!
//! ```text
//! force on node a:   N_a' Lam F
//! moment on node a:  B_a^t (F x Gam + M x kappa) + B_a'^t M        (about the nodal spin w_a, section frame)
//! ```

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::beam::{Beam, BeamState, StiffnessPoint};
use super::rotation_field::{RotationField, SectionRotation};
use crate::math::so3::skew;

/// 6 x 6 blocks over pairs of nodes: rows and columns (position in A, rotation `theta` in the node frame).
pub type ElementMatrix<const N: usize> = [[Matrix6<f64>; N]; N];

/// Elastic forces, and the tangent where asked.
#[derive(Clone, Copy, Debug)]
pub struct InternalForce<const N: usize> {
    /// Force in A (N) and moment in the node frame (N m) on every node.
    pub force: [Vector6<f64>; N],
    /// Elastic energy, J.
    pub energy: f64,
}

/// Section strains `(gamma, kappa)` in B at a Gauss point.
pub fn strain<const N: usize>(
    state: &BeamState<N>,
    field: &RotationField<N>,
    point: &StiffnessPoint<N>,
) -> Vector6<f64> {
    let section = field.at(&point.shape);
    let gamma = section.triad.transpose() * state.slope(&point.shape) - point.gamma0;
    let kappa = section.curvature - point.kappa0;
    stack(&gamma, &kappa)
}

/// Elastic forces and energy.
pub fn internal_force<const N: usize>(beam: &Beam<N>, state: &BeamState<N>) -> InternalForce<N> {
    let field = RotationField::new(&state.triads);
    let mut out = InternalForce { force: [Vector6::zeros(); N], energy: 0.0 };
    for point in beam.stiffness_points() {
        add_point(&mut out, None, Parts::HESSIAN, beam, state, &field, point);
    }
    beam.force_to_nodes(state, &mut out.force);
    out
}

/// Elastic forces with their derivative in `(R, theta)`, `theta` being measured from this very state
/// (`Q = Q0 exp(theta~)`): the Hessian of the elastic energy in these coordinates, hence symmetric.
pub fn internal_force_and_stiffness<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
) -> (InternalForce<N>, ElementMatrix<N>) {
    force_and_parts(beam, state, Parts::HESSIAN, None)
}

/// Elastic forces with their derivative in the increments of a step: columns `(R, theta)` with `spin = tangential theta`, rows
/// force and moment about the spin. Not symmetric where moments are at work.
pub fn spin_tangent<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    tangential: &[Matrix3<f64>; N],
) -> (InternalForce<N>, ElementMatrix<N>) {
    let (out, mut k) = force_and_parts(beam, state, Parts::SPIN, None);
    to_increments(&mut k, tangential);
    (out, k)
}

/// Turns the columns of a tangent from spins to the increments `theta` with `spin = tangential theta`.
pub fn to_increments<const N: usize>(k: &mut ElementMatrix<N>, tangential: &[Matrix3<f64>; N]) {
    for row in k {
        for (block, t) in row.iter_mut().zip(tangential) {
            let turned = block.fixed_view::<6, 3>(0, 3) * t;
            block.fixed_view_mut::<6, 3>(0, 3).copy_from(&turned);
        }
    }
}

/// The part of the stiffness that the stresses make; zero at an unstressed state.
pub fn geometric_stiffness<const N: usize>(beam: &Beam<N>, state: &BeamState<N>) -> ElementMatrix<N> {
    force_and_parts(beam, state, Parts { material: false, ..Parts::HESSIAN }, None).1
}

/// Section forces `(F, M)` at the stiffness points, as many as there are.
pub type Stresses = [Vector6<f64>; 2];

/// Section forces that the strains of a state make.
pub fn stresses<const N: usize>(beam: &Beam<N>, state: &BeamState<N>) -> Stresses {
    let field = RotationField::new(&state.triads);
    let mut out = [Vector6::zeros(); 2];
    for (stress, point) in out.iter_mut().zip(beam.stiffness_points()) {
        *stress = point.stiffness * strain(state, &field, point);
    }
    out
}

/// Nodal forces of given section forces, whatever the strains: `int B^t (F, M)`.
pub fn force_of_stresses<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    given: &Stresses,
) -> [Vector6<f64>; N] {
    let field = RotationField::new(&state.triads);
    let mut out = InternalForce { force: [Vector6::zeros(); N], energy: 0.0 };
    for (point, stress) in beam.stiffness_points().iter().zip(given) {
        add_point(&mut out, None, Parts { stress: Some(*stress), ..Parts::SPIN }, beam, state, &field, point);
    }
    beam.force_to_nodes(state, &mut out.force);
    out.force
}

/// Material stiffness of a state with the geometric stiffness of given section forces, in spins (as [`spin_tangent`] with `T = I`).
pub fn stiffness_of_stresses<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    given: &Stresses,
) -> ElementMatrix<N> {
    force_and_parts(beam, state, Parts::SPIN, Some(given)).1
}

/// Which parts of the stiffness to add up.
#[derive(Clone, Copy)]
struct Parts {
    material: bool,
    /// Curvature of the rotation vector: the term that makes the tangent a Hessian.
    curvature: bool,
    /// Section force at the point where it is not that of the strains.
    stress: Option<Vector6<f64>>,
}

impl Parts {
    const HESSIAN: Self = Self { material: true, curvature: true, stress: None };
    const SPIN: Self = Self { material: true, curvature: false, stress: None };
}

fn force_and_parts<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    parts: Parts,
    given: Option<&Stresses>,
) -> (InternalForce<N>, ElementMatrix<N>) {
    let field = RotationField::new(&state.triads);
    let mut out = InternalForce { force: [Vector6::zeros(); N], energy: 0.0 };
    let mut k = [[Matrix6::zeros(); N]; N];
    for (index, point) in beam.stiffness_points().iter().enumerate() {
        let parts = Parts { stress: given.map(|s| s[index]), ..parts };
        add_point(&mut out, Some(&mut k), parts, beam, state, &field, point);
    }
    beam.columns_to_nodes(state, &mut k);
    beam.rows_to_nodes(state, &mut out.force, &mut k, &[Matrix3::identity(); N]);
    // The moment about theta is T(theta)^t m, whose derivative at theta = 0 has the term -1/2 m~.
    for a in 0..if parts.curvature { N } else { 0 } {
        let m: Vector3<f64> = out.force[a].fixed_rows::<3>(3).into();
        let mut block = k[a][a].fixed_view_mut::<3, 3>(3, 3);
        block -= skew(&m) * 0.5;
    }
    (out, k)
}

/// Linear strains at every stiffness point: rows `(gamma, kappa)`, columns `(R, theta)` of each node.
pub fn strain_maps<const N: usize>(beam: &Beam<N>, state: &BeamState<N>) -> Vec<[Matrix6<f64>; N]> {
    let field = RotationField::new(&state.triads);
    let levers = beam.lever_maps(state);
    let at_point = |point: &StiffnessPoint<N>| {
        let section = field.at(&point.shape);
        let gamma = section.triad.transpose() * state.slope(&point.shape);
        let mut maps = strain_operator(point, &section, &gamma);
        for (map, frame) in maps.iter_mut().zip(&beam.frames) {
            let turned = map.fixed_view::<6, 3>(0, 3) * frame.transpose();
            map.fixed_view_mut::<6, 3>(0, 3).copy_from(&turned);
        }
        if let Some(levers) = &levers {
            maps.iter_mut().zip(levers).for_each(|(map, lever)| *map *= lever);
        }
        maps
    };
    beam.stiffness_points().iter().map(at_point).collect()
}

/// Strain-displacement operator per node: rows (gamma, kappa), columns (R in A, spin in the section frame).
fn strain_operator<const N: usize>(
    point: &StiffnessPoint<N>,
    section: &SectionRotation<N>,
    gamma: &Vector3<f64>,
) -> [Matrix6<f64>; N] {
    let c = section.triad.transpose();
    std::array::from_fn(|a| {
        let mut op = Matrix6::zeros();
        op.fixed_view_mut::<3, 3>(0, 0).copy_from(&(c * point.shape.dn[a]));
        op.fixed_view_mut::<3, 3>(0, 3).copy_from(&(skew(gamma) * section.b[a]));
        let bending = section.db[a] + skew(&section.curvature) * section.b[a];
        op.fixed_view_mut::<3, 3>(3, 3).copy_from(&bending);
        op
    })
}

fn add_point<const N: usize>(
    out: &mut InternalForce<N>,
    stiffness: Option<&mut ElementMatrix<N>>,
    parts: Parts,
    beam: &Beam<N>,
    state: &BeamState<N>,
    field: &RotationField<N>,
    point: &StiffnessPoint<N>,
) {
    let section = field.at(&point.shape);
    let c = section.triad.transpose();
    let gamma = c * state.slope(&point.shape);
    let kappa = section.curvature;
    let strain = stack(&(gamma - point.gamma0), &(kappa - point.kappa0));
    let stress = parts.stress.unwrap_or_else(|| point.stiffness * strain);
    let (f, m) = split(&stress);
    let w = point.weight;
    out.energy += 0.5 * w * strain.dot(&stress);
    let f_a = section.triad * f;
    let couple = f.cross(&gamma) + m.cross(&kappa);
    for a in 0..N {
        let moment = section.b[a].transpose() * couple + section.db[a].transpose() * m;
        out.force[a] += stack(&(f_a * (w * point.shape.dn[a])), &(beam.frames[a] * moment * w));
    }
    let Some(k) = stiffness else { return };

    let strain_operator = strain_operator(point, &section, &gamma);
    let turn_couple = field.derivative_bt(&section, &couple);
    let turn_moment = field.derivative_dbt(&section, &m);
    for a in 0..N {
        let left = strain_operator[a].transpose() * point.stiffness;
        for b in 0..N {
            let mut block = if parts.material { left * strain_operator[b] } else { Matrix6::zeros() };
            // Geometric part: the forces keep their size in B while the section turns and strains.
            let turn_force = -section.triad * skew(&f) * section.b[b] * point.shape.dn[a];
            let mut corner = block.fixed_view_mut::<3, 3>(0, 3);
            corner += turn_force;
            let strain_rate = strain_operator[b];
            let moment_rate = section.b[a].transpose()
                * (skew(&f) * strain_rate.fixed_view::<3, 6>(0, 0)
                    + skew(&m) * strain_rate.fixed_view::<3, 6>(3, 0));
            let mut rows = block.fixed_view_mut::<3, 6>(3, 0);
            rows += moment_rate;
            let mut corner = block.fixed_view_mut::<3, 3>(3, 3);
            corner += turn_couple[a][b] + turn_moment[a][b];
            k[a][b] += to_node_frames(&block, &beam.frames[a], &beam.frames[b]) * w;
        }
    }
}

/// Turns the spin rows by `E_a` and the spin columns by `E_b^t`: section frames to node frames.
pub(super) fn to_node_frames(block: &Matrix6<f64>, ea: &Matrix3<f64>, eb: &Matrix3<f64>) -> Matrix6<f64> {
    let mut out = *block;
    let rr = ea * block.fixed_view::<3, 3>(3, 3) * eb.transpose();
    let tr = block.fixed_view::<3, 3>(0, 3) * eb.transpose();
    let rt = ea * block.fixed_view::<3, 3>(3, 0);
    out.fixed_view_mut::<3, 3>(3, 3).copy_from(&rr);
    out.fixed_view_mut::<3, 3>(0, 3).copy_from(&tr);
    out.fixed_view_mut::<3, 3>(3, 0).copy_from(&rt);
    out
}

/// `(a, b)` as one six-vector.
#[inline]
pub fn stack(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}

/// A six-vector as `(a, b)`.
#[inline]
pub fn split(v: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(v[0], v[1], v[2]), Vector3::new(v[3], v[4], v[5]))
}
