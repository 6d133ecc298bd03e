//! Rotation of the sections along an element, and the operators that carry nodal spins to a section.
//!
//! With the reference node `r` (the first of two, the middle of three) and the section triads `Lam_a` at the nodes,
//!
//! ```text
//! phi_a = log(Lam_r^t Lam_a)      psi(s) = sum_a N_a phi_a      Lam(s) = Lam_r exp(psi~)
//! ```
//!
//! A spin is a material rotation increment, `delta Lam_a = Lam_a w_a~`. Then
//!
//! ```text
//! delta phi_a = G_a w_a - G_a^t w_r,   G = T^{-1}(phi_a)
//! w(s) = sum_a B_a w_a,   B_a = N_a T(psi) G_a  (a != r),   B_r = exp(psi~)^t - sum_a N_a T(psi) G_a^t
//! kappa(s) = T(psi) psi',  delta kappa = sum_a (B_a' + kappa~ B_a) w_a
//! ```
//!
//! (theory section 1 with the rotation vector measured from the element's own node instead of from A).

use nalgebra::{Matrix3, Vector3};

use super::shape::Shape;
use crate::math::so3::{MatrixFunction, log, skew};

/// Largest relative rotation of a node against the element's reference node, rad. At pi the logarithm is no longer unique.
pub const MAX_RELATIVE_ROTATION: f64 = 3.0;

/// Largest rotation of a section triad against that of the reference node, rad.
pub fn relative_rotation(triads: &[Matrix3<f64>]) -> f64 {
    let reference = triads[(triads.len() - 1) / 2].transpose();
    triads.iter().map(|t| log(&(reference * t)).norm()).fold(0.0, f64::max)
}

/// Relative rotations of an element's nodes: what all its sections share.
#[derive(Clone, Copy, Debug)]
pub struct RotationField<const N: usize> {
    reference: usize,
    triad: Matrix3<f64>,
    phi: [Vector3<f64>; N],
    g: [MatrixFunction; N],
    g_matrix: [Matrix3<f64>; N],
}

/// Rotation of one section and the operators there.
#[derive(Clone, Copy, Debug)]
pub struct SectionRotation<const N: usize> {
    /// Section triad `C^{AB}`.
    pub triad: Matrix3<f64>,
    /// Curvature `K = T psi'` in B, 1/m.
    pub curvature: Vector3<f64>,
    /// `B_a`: spin of the section per nodal spin - (N of 3 x 3).
    pub b: [Matrix3<f64>; N],
    /// `B_a'`, 1/m - (N of 3 x 3).
    pub db: [Matrix3<f64>; N],
    shape: Shape<N>,
    psi_slope: Vector3<f64>,
    /// `T(psi)^t` and `exp(psi~)` as functions.
    t_transposed: MatrixFunction,
    exponential: MatrixFunction,
}

/// Time derivatives of a rotation field.
#[derive(Clone, Copy, Debug)]
pub struct FieldRates<const N: usize> {
    phi1: [Vector3<f64>; N],
    phi2: [Vector3<f64>; N],
    g1: [Matrix3<f64>; N],
    g2: [Matrix3<f64>; N],
}

impl<const N: usize> SectionRotation<N> {
    /// `sum_a N_a v_a`; the reference node's `v` is zero.
    fn combine(&self, v: &[Vector3<f64>; N]) -> Vector3<f64> {
        (0..N).map(|a| v[a] * self.shape.n[a]).sum()
    }
}

/// 3 x 3 blocks over pairs of nodes.
pub type NodeBlocks<const N: usize> = [[Matrix3<f64>; N]; N];

impl<const N: usize> RotationField<N> {
    /// From the section triads `C^{AB}` at the nodes.
    pub fn new(triads: &[Matrix3<f64>; N]) -> Self {
        let reference = (N - 1) / 2;
        let triad = triads[reference];
        let mut phi = [Vector3::zeros(); N];
        for a in (0..N).filter(|&a| a != reference) {
            phi[a] = log(&(triad.transpose() * triads[a]));
        }
        let g = phi.map(|p| MatrixFunction::inverse_tangential(&p));
        Self { reference, triad, phi, g, g_matrix: g.map(|g| g.matrix()) }
    }

    /// Nodes other than the reference node.
    fn others(&self) -> impl Iterator<Item = usize> + use<N> {
        let reference = self.reference;
        (0..N).filter(move |&a| a != reference)
    }

    /// Rotation and operators at a point of the element.
    pub fn at(&self, shape: &Shape<N>) -> SectionRotation<N> {
        let (mut psi, mut psi_slope) = (Vector3::zeros(), Vector3::zeros());
        for a in self.others() {
            psi += self.phi[a] * shape.n[a];
            psi_slope += self.phi[a] * shape.dn[a];
        }
        let (exponential, tangential) = MatrixFunction::exponential_and_tangential(&psi);
        let (t, t_slope) = (tangential.matrix(), tangential.rate(&psi_slope));
        let e = exponential.matrix();
        let curvature = t * psi_slope;
        let mut b = [Matrix3::zeros(); N];
        let mut db = [Matrix3::zeros(); N];
        b[self.reference] = e.transpose();
        db[self.reference] = -skew(&curvature) * e.transpose();
        for a in self.others() {
            let (ta, dta) = (t * shape.n[a], t * shape.dn[a] + t_slope * shape.n[a]);
            let g = &self.g_matrix[a];
            b[a] = ta * g;
            db[a] = dta * g;
            b[self.reference] -= ta * g.transpose();
            db[self.reference] -= dta * g.transpose();
        }
        SectionRotation {
            triad: self.triad * e,
            curvature,
            b,
            db,
            shape: *shape,
            psi_slope,
            t_transposed: tangential.transposed(),
            exponential,
        }
    }

    /// Time derivatives of the `phi_a` and of the `G_a` for given nodal spins and their rates (section frames); the second
    /// ones where `second` asks for them.
    pub fn rates(
        &self,
        spin: &[Vector3<f64>; N],
        spin_rate: &[Vector3<f64>; N],
        second: bool,
    ) -> FieldRates<N> {
        let r = self.reference;
        let (zero, matrix) = (Vector3::zeros(), Matrix3::zeros());
        let mut out = FieldRates { phi1: [zero; N], phi2: [zero; N], g1: [matrix; N], g2: [matrix; N] };
        for a in self.others() {
            let g = &self.g_matrix[a];
            out.phi1[a] = g * spin[a] - g.tr_mul(&spin[r]);
            out.g1[a] = self.g[a].rate(&out.phi1[a]);
            if second {
                let g1 = &out.g1[a];
                out.phi2[a] = g * spin_rate[a] - g.tr_mul(&spin_rate[r]) + g1 * spin[a] - g1.tr_mul(&spin[r]);
                out.g2[a] = self.g[a].second_rate(&out.phi1[a], &out.phi2[a]);
            }
        }
        out
    }

    /// First time derivative of `B_a` at a section.
    pub fn b1(&self, section: &SectionRotation<N>, rates: &FieldRates<N>) -> [Matrix3<f64>; N] {
        let psi1 = section.combine(&rates.phi1);
        let t = section.t_transposed.transposed();
        let (t0, t1) = (t.matrix(), t.rate(&psi1));
        let mut b1 = [Matrix3::zeros(); N];
        b1[self.reference] = section.exponential.rate(&psi1).transpose();
        for a in self.others() {
            let (t0, t1) = (t0 * section.shape.n[a], t1 * section.shape.n[a]);
            let (g, g1) = (&self.g_matrix[a], &rates.g1[a]);
            b1[a] = t1 * g + t0 * g1;
            b1[self.reference] -= t1 * g.transpose() + t0 * g1.transpose();
        }
        b1
    }

    /// Second time derivative of `B_a` at a section; `rates` must hold the second ones.
    pub fn b2(&self, section: &SectionRotation<N>, rates: &FieldRates<N>) -> [Matrix3<f64>; N] {
        let (psi1, psi2) = (section.combine(&rates.phi1), section.combine(&rates.phi2));
        let t = section.t_transposed.transposed();
        let (t0, t1, t2) = (t.matrix(), t.rate(&psi1) * 2.0, t.second_rate(&psi1, &psi2));
        let mut b2 = [Matrix3::zeros(); N];
        b2[self.reference] = section.exponential.second_rate(&psi1, &psi2).transpose();
        for a in self.others() {
            let n = section.shape.n[a];
            let (t0, t1, t2) = (t0 * n, t1 * n, t2 * n);
            let (g, g1, g2) = (&self.g_matrix[a], &rates.g1[a], &rates.g2[a]);
            b2[a] = t2 * g + t1 * g1 + t0 * g2;
            b2[self.reference] -= t2 * g.transpose() + t1 * g1.transpose() + t0 * g2.transpose();
        }
        b2
    }

    /// Derivative of `B_a^t f` in the spins of the nodes, `f` fixed: block `(a, b)` times `w_b`.
    pub fn derivative_bt(&self, section: &SectionRotation<N>, f: &Vector3<f64>) -> NodeBlocks<N> {
        let s = &section.shape;
        let h = section.t_transposed.matrix() * f;
        let dt = section.t_transposed.derivative_times(f);
        let de = section.exponential.derivative_times(f);
        self.assemble_derivative(|j| dt * s.n[j], |j| de * s.n[j], |a, inner| inner * s.n[a], |a| h * s.n[a])
    }

    /// Derivative of `B_a'^t m` in the spins of the nodes, `m` fixed: block `(a, b)` times `w_b`, 1/m.
    pub fn derivative_dbt(&self, section: &SectionRotation<N>, m: &Vector3<f64>) -> NodeBlocks<N> {
        let s = &section.shape;
        let t = &section.t_transposed;
        let (h, h_slope) = (t.matrix() * m, t.rate(&section.psi_slope) * m);
        let (dt, dt_slope) = (t.derivative_times(m), t.derivative_times_rate(m, &section.psi_slope));
        let de = section.exponential.derivative_times(m);
        let de_slope = section.exponential.derivative_times_rate(m, &section.psi_slope);
        let mut blocks = self.assemble_derivative(
            |j| dt_slope * s.n[j] + dt * s.dn[j],
            |j| de_slope * s.n[j] + de * s.dn[j],
            |a, inner| inner * s.n[a],
            |a| h * s.dn[a] + h_slope * s.n[a],
        );
        let slope = self.assemble_derivative(
            |j| dt * s.n[j],
            |_| Matrix3::zeros(),
            |a, inner| inner * s.dn[a],
            |_| Vector3::zeros(),
        );
        for a in 0..N {
            for b in 0..N {
                blocks[a][b] += slope[a][b];
            }
        }
        blocks
    }

    /// Common part of the two derivatives above, first in the `phi_j`, then in the spins.
    ///
    /// Rows `a != r` are `G_a^t y_a` and row `r` is `e - sum_a G_a y_a` with `dy_a = weight(a, inner(j)) dphi_j` and
    /// `de = rotation(j) dphi_j`; `arm(a)` is `y_a` itself, which the derivative of `G_a` meets.
    fn assemble_derivative(
        &self,
        inner: impl Fn(usize) -> Matrix3<f64>,
        rotation: impl Fn(usize) -> Matrix3<f64>,
        weight: impl Fn(usize, Matrix3<f64>) -> Matrix3<f64>,
        arm: impl Fn(usize) -> Vector3<f64>,
    ) -> NodeBlocks<N> {
        let r = self.reference;
        let mut blocks = [[Matrix3::zeros(); N]; N];
        let mut add = |row: usize, j: usize, x: Matrix3<f64>| {
            let g = &self.g_matrix[j];
            blocks[row][j] += x * g;
            blocks[row][r] -= x * g.transpose();
        };
        for j in self.others() {
            add(r, j, rotation(j));
            for a in self.others() {
                let y = weight(a, inner(j));
                add(a, j, self.g_matrix[a].transpose() * y);
                add(r, j, -(self.g_matrix[a] * y));
            }
            add(j, j, self.g[j].transposed().derivative_times(&arm(j)));
            add(r, j, -self.g[j].derivative_times(&arm(j)));
        }
        blocks
    }
}
