//! Gyroscopic operators about a rest state (theory section 3): the forces of a rigid velocity `beta` of A on a body
//! that deforms a little.
//!
//! With `V = A_RC beta` the section velocity of the rigid motion, `A_VW = [[W~, 0], [V~, W~]]` built on it, `P = Mcs V` and
//! `A_PH = [[0, P~], [P~, H~]]`, `A_dW = A_VW - A_PH Mcs^{-1}`:
//!
//! ```text
//! C_SS = int J^t X J   C_RS = int A_RC^t X J      X = A_dW Mcs - Mcs A_VW^t = A_VW Mcs - A_PH - Mcs A_VW^t
//! C_SR = int J^t Y A_RC  C_RR = int A_RC^t Y A_RC    Y = A_VW Mcs
//! K_S - Kstif = int [ D_J(A_VW P) - J^t (A_VW Mcs - A_PH) A_VW^t J ]
//! K_R         = - int A_RC^t A_VW (Mcs A_VW^t + A_PH) J
//! ```
//!
//! C is linear in `beta`; K is quadratic, and is given here as the bilinear form of two velocities, symmetric in them.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::beam::{Beam, BeamState, SectionState};
use super::inertia::{rigid_map, structural_map};
use super::internal_force::{ElementMatrix, split};
use super::rotation_field::RotationField;
use crate::math::so3::skew;

/// `A_VW` of a section velocity.
pub fn a_vw(velocity: &Vector6<f64>) -> Matrix6<f64> {
    let (v, w) = split(velocity);
    let (v, w) = (skew(&v), skew(&w));
    blocks(&w, &Matrix3::zeros(), &v, &w)
}

/// `A_PH` of a section momentum.
pub fn a_ph(momentum: &Vector6<f64>) -> Matrix6<f64> {
    let (p, h) = split(momentum);
    let (p, h) = (skew(&p), skew(&h));
    blocks(&Matrix3::zeros(), &p, &p, &h)
}

/// Section damping operators of the rigid velocity `velocity = A_RC beta`.
#[derive(Clone, Copy, Debug)]
pub struct SectionDamping {
    /// `X`: acts on elastic section rates.
    pub elastic: Matrix6<f64>,
    /// `Y`: acts on rigid section rates.
    pub rigid: Matrix6<f64>,
}

/// `X` and `Y` of one section, per unit length.
pub fn section_damping(mass: &Matrix6<f64>, velocity: &Vector6<f64>) -> SectionDamping {
    let a = a_vw(velocity);
    let rigid = a * mass;
    // A_VW Mcs - Mcs A_VW^t - A_PH, the last built on the momentum of the same velocity.
    let elastic = rigid - mass * a.transpose() - a_ph(&(mass * velocity));
    SectionDamping { elastic, rigid }
}

/// Section stiffness operators of two rigid velocities, symmetrised in them.
#[derive(Clone, Copy, Debug)]
pub struct SectionStiffness {
    /// `-(A_VW Mcs - A_PH) A_VW^t`: rows and columns elastic section displacement.
    pub elastic: Matrix6<f64>,
    /// `-A_VW (Mcs A_VW^t + A_PH)`: rows rigid, columns elastic.
    pub rigid: Matrix6<f64>,
    /// `A_VW P`: inertia force and moment of the steady motion, to be turned with the section by `D_J`.
    pub force: Vector6<f64>,
}

/// Operators of one section, per unit length, for the pair of velocities `u`, `v` (half the sum of both orders).
pub fn section_stiffness(mass: &Matrix6<f64>, u: &Vector6<f64>, v: &Vector6<f64>) -> SectionStiffness {
    let one_way = |u: &Vector6<f64>, v: &Vector6<f64>| {
        let (au, av) = (a_vw(u), a_vw(v));
        let momentum_v = mass * v;
        let momentum_u = mass * u;
        (
            (a_ph(&momentum_u) - au * mass) * av.transpose(),
            -(au * (mass * av.transpose() + a_ph(&momentum_v))),
            au * momentum_v,
        )
    };
    let (e1, r1, f1) = one_way(u, v);
    let (e2, r2, f2) = one_way(v, u);
    SectionStiffness { elastic: (e1 + e2) * 0.5, rigid: (r1 + r2) * 0.5, force: (f1 + f2) * 0.5 }
}

/// Translation part of `D_J(f) = d(J^t f)/d eta` as a section operator: `-f_1~` between section translation (rows) and
/// section rotation (columns).
pub fn turning_force(force: &Vector3<f64>) -> Matrix6<f64> {
    blocks(&Matrix3::zeros(), &-skew(force), &Matrix3::zeros(), &Matrix3::zeros())
}

/// Rotation part of `D_J(f)`: derivative of the nodal moments `B_a^t f_2` in the nodal `theta`, including the `-1/2 m~` of
/// rotation vectors measured from this state. Only the rotation blocks are non-zero; node frames.
pub fn turning_moment<const N: usize>(
    beam: &Beam<N>,
    field: &RotationField<N>,
    section: &SectionState<N>,
    moment: &Vector3<f64>,
) -> [[Matrix3<f64>; N]; N] {
    let turn = field.derivative_bt(&section.rotation, moment);
    let mut out = [[Matrix3::zeros(); N]; N];
    for a in 0..N {
        for b in 0..N {
            let mut block = turn[a][b];
            if a == b {
                block -= skew(&(section.rotation.b[a].transpose() * moment)) * 0.5;
            }
            out[a][b] = beam.frames[a] * block * beam.frames[b].transpose();
        }
    }
    out
}

fn blocks(tt: &Matrix3<f64>, tr: &Matrix3<f64>, rt: &Matrix3<f64>, rr: &Matrix3<f64>) -> Matrix6<f64> {
    let mut m = Matrix6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(tt);
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(tr);
    m.fixed_view_mut::<3, 3>(3, 0).copy_from(rt);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(rr);
    m
}

/// All gyroscopic operators of one element for one velocity `beta` of A (v then w, in A).
#[derive(Clone, Copy, Debug)]
pub struct ElementGyroscopic<const N: usize> {
    /// `C_SS` over pairs of nodes.
    pub c_ss: ElementMatrix<N>,
    /// `C_RS`: six rigid rows, columns of each node.
    pub c_rs: [Matrix6<f64>; N],
    /// `C_SR`: rows of each node, six rigid columns.
    pub c_sr: [Matrix6<f64>; N],
    /// `C_RR`.
    pub c_rr: Matrix6<f64>,
    /// `K_S - Kstif` over pairs of nodes.
    pub k_s: ElementMatrix<N>,
    /// `K_R`: six rigid rows, columns of each node.
    pub k_r: [Matrix6<f64>; N],
}

/// Gyroscopic operators of an element at a rest state.
pub fn gyroscopic<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    beta: &Vector6<f64>,
) -> ElementGyroscopic<N> {
    let zero = Matrix6::zeros();
    let mut out = ElementGyroscopic {
        c_ss: [[zero; N]; N],
        c_rs: [zero; N],
        c_sr: [zero; N],
        c_rr: zero,
        k_s: [[zero; N]; N],
        k_r: [zero; N],
    };
    let field = RotationField::new(&state.triads);
    for point in beam.inertia_points() {
        let section = SectionState::new(state, &field, &point.shape);
        let j = structural_map(beam, state, &section, point);
        let a_rc = rigid_map(&section.rotation.triad, &section.position);
        let velocity = a_rc * beta;
        let c = section_damping(&point.mass, &velocity);
        let k = section_stiffness(&point.mass, &velocity, &velocity);
        let (f, m) = split(&k.force);
        let k_elastic = k.elastic + turning_force(&f);
        let turn = turning_moment(beam, &field, &section, &m);
        let force = section.rotation.triad * f;
        let w = point.weight;
        out.c_rr += a_rc.transpose() * c.rigid * a_rc * w;
        for a in 0..N {
            out.c_sr[a] += j[a].transpose() * c.rigid * a_rc * w;
            out.c_rs[a] += a_rc.transpose() * c.elastic * j[a] * w;
            out.k_r[a] += a_rc.transpose() * k.rigid * j[a] * w;
            if let Some(turning) = beam.lever_turning(state, a, &(force * point.shape.n[a])) {
                let mut corner = out.k_s[a][a].fixed_view_mut::<3, 3>(3, 3);
                corner += turning * w;
            }
            for b in 0..N {
                out.c_ss[a][b] += j[a].transpose() * c.elastic * j[b] * w;
                out.k_s[a][b] += j[a].transpose() * k_elastic * j[b] * w;
                let mut corner = out.k_s[a][b].fixed_view_mut::<3, 3>(3, 3);
                corner += turn[a][b] * w;
            }
        }
    }
    out
}
