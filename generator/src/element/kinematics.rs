//! Kinematics of an element for numbers of any kind: reals, dual numbers, Taylor series. Written from the definitions alone, with
//! quaternions and without an operator of the other modules, so that each proves the other.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use num_dual::{Dual, DualNum};

use super::beam::{Beam, BeamState, StiffnessPoint};
use super::shape::Shape;

/// Real, dual or nested dual numbers over `f64`.
pub(crate) trait Number: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

pub(crate) type Vec3<D> = [D; 3];
pub(crate) type Quaternion<D> = [D; 4];

pub(crate) fn constant<D: Number>(v: &Vector3<f64>) -> Vec3<D> {
    [v.x, v.y, v.z].map(D::from)
}

pub(crate) fn add<D: Number>(a: Vec3<D>, b: Vec3<D>) -> Vec3<D> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub<D: Number>(a: Vec3<D>, b: Vec3<D>) -> Vec3<D> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale<D: Number>(a: Vec3<D>, f: D) -> Vec3<D> {
    [a[0] * f, a[1] * f, a[2] * f]
}

pub(crate) fn dot<D: Number>(a: Vec3<D>, b: Vec3<D>) -> D {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn multiply<D: Number>(p: Quaternion<D>, q: Quaternion<D>) -> Quaternion<D> {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]
}

pub(crate) fn conjugate<D: Number>(q: Quaternion<D>) -> Quaternion<D> {
    [q[0], -q[1], -q[2], -q[3]]
}

pub(crate) fn rotate<D: Number>(q: Quaternion<D>, v: Vec3<D>) -> Vec3<D> {
    let p = multiply(multiply(q, [D::from(0.0), v[0], v[1], v[2]]), conjugate(q));
    [p[1], p[2], p[3]]
}

/// Quaternion of a rotation vector by the series of cosine and sine: regular at zero, good to |theta| = 6.
pub(crate) fn exp<D: Number>(theta: Vec3<D>) -> Quaternion<D> {
    let half = scale(theta, D::from(0.5));
    let sigma = dot(half, half);
    let (mut cosine, mut sinc) = (D::from(1.0), D::from(1.0));
    for j in (1..=20).rev() {
        let k = f64::from(2 * j);
        cosine = D::from(1.0) - cosine * sigma / (k * (k - 1.0));
        sinc = D::from(1.0) - sinc * sigma / (k * (k + 1.0));
    }
    [cosine, half[0] * sinc, half[1] * sinc, half[2] * sinc]
}

/// Rotation vector of a unit quaternion with positive scalar part.
pub(crate) fn log<D: Number>(q: Quaternion<D>) -> Vec3<D> {
    let q = if q[0].re() < 0.0 { q.map(|c| -c) } else { q };
    let v = [q[1], q[2], q[3]];
    let tangent2 = dot(v, v) / (q[0] * q[0]);
    let factor = if tangent2.re() < 0.2 {
        // atan(x)/x in powers of x^2: 0.2^25 is below round-off, and regular at zero.
        let mut sum = D::from(0.0);
        for k in (0..=30).rev() {
            sum = D::from(1.0 / f64::from(2 * k + 1)) - sum * tangent2;
        }
        sum / q[0]
    } else {
        let s = dot(v, v).sqrt();
        s.atan2(q[0]) / s
    };
    scale(v, factor * 2.0)
}

/// Positions and section rotations (quaternions) of the nodes after the increments `x`.
pub(crate) fn nodal<D: Number, const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    x: &[[D; 6]; N],
) -> ([Vec3<D>; N], [Quaternion<D>; N]) {
    let q = |m: &nalgebra::Matrix3<f64>| {
        let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*m));
        [q.w, q.i, q.j, q.k].map(D::from)
    };
    let node = |a: usize| state.triads[a] * beam.frames[a].transpose();
    let turned = |a: usize| multiply(q(&node(a)), exp([x[a][3], x[a][4], x[a][5]]));
    let position = |a: usize| {
        let lever = beam.levers.map_or_else(Vector3::zeros, |r| r[a]);
        let of_node = constant(&(state.positions[a] - node(a) * lever));
        add(add(of_node, [x[a][0], x[a][1], x[a][2]]), rotate(turned(a), constant(&lever)))
    };
    let rotation = |a: usize| multiply(turned(a), q(&beam.frames[a]));
    (std::array::from_fn(position), std::array::from_fn(rotation))
}

/// Position and rotation of a section, its `R'` and its `psi`, `psi'`.
pub(crate) struct Section<D> {
    pub(crate) position: Vec3<D>,
    pub(crate) slope: Vec3<D>,
    pub(crate) rotation: Quaternion<D>,
    pub(crate) psi: Vec3<D>,
    pub(crate) psi_slope: Vec3<D>,
}

pub(crate) fn section<D: Number, const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    x: &[[D; 6]; N],
    shape: &Shape<N>,
) -> Section<D> {
    let (positions, rotations) = nodal(beam, state, x);
    let r = (N - 1) / 2;
    let zero = [D::from(0.0); 3];
    let mut out = Section { position: zero, slope: zero, rotation: rotations[r], psi: zero, psi_slope: zero };
    for a in 0..N {
        let (n, dn) = (D::from(shape.n[a]), D::from(shape.dn[a]));
        out.position = add(out.position, scale(positions[a], n));
        out.slope = add(out.slope, scale(positions[a], dn));
        if a != r {
            let phi = log(multiply(conjugate(rotations[r]), rotations[a]));
            out.psi = add(out.psi, scale(phi, n));
            out.psi_slope = add(out.psi_slope, scale(phi, dn));
        }
    }
    out.rotation = multiply(rotations[r], exp(out.psi));
    out
}

/// `kappa~ = exp(psi)^t d exp(psi)/ds`, by a dual number in the arc length.
pub(crate) fn curvature<D: Number>(psi: Vec3<D>, psi_slope: Vec3<D>) -> Vec3<D>
where
    Dual<D>: Number,
{
    let moving = std::array::from_fn(|k| Dual::new(psi[k], psi_slope[k]));
    angular_rate(exp(moving))
}

/// `2 conj(q) qdot`: material angular rate of a quaternion that carries its own derivative.
pub(crate) fn angular_rate<D: Number>(q: Quaternion<Dual<D>>) -> Vec3<D> {
    let w = multiply(conjugate(q.map(|c| c.re)), q.map(|c| c.eps));
    [w[1], w[2], w[3]].map(|c| c * 2.0)
}

/// Strains `(gamma, kappa)` at a stiffness point after the increments `x`, as their definitions say.
pub(crate) fn strain<D: Number, const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    x: &[[D; 6]; N],
    point: &StiffnessPoint<N>,
) -> [D; 6]
where
    Dual<D>: Number,
{
    let s = section(beam, state, x, &point.shape);
    let [g1, g2, g3] = sub(rotate(conjugate(s.rotation), s.slope), constant(&point.gamma0));
    let [k1, k2, k3] = sub(curvature(s.psi, s.psi_slope), constant(&point.kappa0));
    [g1, g2, g3, k1, k2, k3]
}
