//! Energies of an element written once more for dual numbers, from the definitions alone: quaternions, no operator of the
//! production code. Their exact derivatives are what the hand-written operators are tested against.

use nalgebra::{Matrix6, UnitQuaternion, Vector3};
use num_dual::{Dual, DualNum};

use super::beam::{Beam, BeamState};
use super::shape::Shape;

/// Real, dual or nested dual numbers over `f64`.
pub(crate) trait Number: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

type Vec3<D> = [D; 3];
type Quaternion<D> = [D; 4];

/// Motion of one element: nodal `(R, theta)` increments from a state, their rates, and the rates of A.
#[derive(Clone, Debug)]
pub(crate) struct Motion<D, const N: usize> {
    pub x: [[D; 6]; N],
    pub x_dot: [[D; 6]; N],
    pub beta: [D; 6],
}

impl<D: Number, const N: usize> Motion<D, N> {
    pub(crate) fn rest() -> Self {
        let zero = D::from(0.0);
        Self { x: [[zero; 6]; N], x_dot: [[zero; 6]; N], beta: [zero; 6] }
    }
}

fn constant<D: Number>(v: &Vector3<f64>) -> Vec3<D> {
    [v.x, v.y, v.z].map(D::from)
}

fn add<D: Number>(a: Vec3<D>, b: Vec3<D>) -> Vec3<D> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn sub<D: Number>(a: Vec3<D>, b: Vec3<D>) -> Vec3<D> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scale<D: Number>(a: Vec3<D>, f: D) -> Vec3<D> {
    [a[0] * f, a[1] * f, a[2] * f]
}

fn dot<D: Number>(a: Vec3<D>, b: Vec3<D>) -> D {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross<D: Number>(a: Vec3<D>, b: Vec3<D>) -> Vec3<D> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn multiply<D: Number>(p: Quaternion<D>, q: Quaternion<D>) -> Quaternion<D> {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]
}

fn conjugate<D: Number>(q: Quaternion<D>) -> Quaternion<D> {
    [q[0], -q[1], -q[2], -q[3]]
}

fn rotate<D: Number>(q: Quaternion<D>, v: Vec3<D>) -> Vec3<D> {
    let p = multiply(multiply(q, [D::from(0.0), v[0], v[1], v[2]]), conjugate(q));
    [p[1], p[2], p[3]]
}

/// Quaternion of a rotation vector by the series of cosine and sine: regular at zero, good to |theta| = 6.
fn exp<D: Number>(theta: Vec3<D>) -> Quaternion<D> {
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
fn log<D: Number>(q: Quaternion<D>) -> Vec3<D> {
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
fn nodal<D: Number, const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    x: &[[D; 6]; N],
) -> ([Vec3<D>; N], [Quaternion<D>; N]) {
    let q = |m: &nalgebra::Matrix3<f64>| {
        let q = UnitQuaternion::from_matrix_eps(m, 1e-15, 200, UnitQuaternion::identity());
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
struct Section<D> {
    position: Vec3<D>,
    slope: Vec3<D>,
    rotation: Quaternion<D>,
    psi: Vec3<D>,
    psi_slope: Vec3<D>,
}

fn section<D: Number, const N: usize>(
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
fn curvature<D: Number>(psi: Vec3<D>, psi_slope: Vec3<D>) -> Vec3<D>
where
    Dual<D>: Number,
{
    let moving = std::array::from_fn(|k| Dual::new(psi[k], psi_slope[k]));
    angular_rate(exp(moving))
}

/// `2 conj(q) qdot`: material angular rate of a quaternion that carries its own derivative.
fn angular_rate<D: Number>(q: Quaternion<Dual<D>>) -> Vec3<D> {
    let w = multiply(conjugate(q.map(|c| c.re)), q.map(|c| c.eps));
    [w[1], w[2], w[3]].map(|c| c * 2.0)
}

fn quadratic<D: Number>(m: &Matrix6<f64>, a: Vec3<D>, b: Vec3<D>) -> D {
    let v = [a[0], a[1], a[2], b[0], b[1], b[2]];
    let mut sum = D::from(0.0);
    for i in 0..6 {
        for j in 0..6 {
            sum += v[i] * v[j] * m[(i, j)];
        }
    }
    sum * 0.5
}

/// Elastic energy of the element after the increments `x`, J.
pub(crate) fn elastic_energy<D: Number, const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    x: &[[D; 6]; N],
) -> D
where
    Dual<D>: Number,
{
    let mut energy = D::from(0.0);
    for point in beam.stiffness_points() {
        let s = section(beam, state, x, &point.shape);
        let gamma = sub(rotate(conjugate(s.rotation), s.slope), constant(&point.gamma0));
        let kappa = sub(curvature(s.psi, s.psi_slope), constant(&point.kappa0));
        energy += quadratic(&point.stiffness, gamma, kappa) * point.weight;
    }
    energy
}

/// Kinetic energy of the element, J. Velocities come from a dual number in time, not from an operator.
pub(crate) fn kinetic_energy<D: Number, const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    motion: &Motion<D, N>,
) -> D
where
    Dual<D>: Number,
{
    let moving: [[Dual<D>; 6]; N] =
        std::array::from_fn(|a| std::array::from_fn(|k| Dual::new(motion.x[a][k], motion.x_dot[a][k])));
    let v = [motion.beta[0], motion.beta[1], motion.beta[2]];
    let w = [motion.beta[3], motion.beta[4], motion.beta[5]];
    let mut energy = D::from(0.0);
    for point in beam.inertia_points() {
        let s = section(beam, state, &moving, &point.shape);
        let to_section = conjugate(s.rotation.map(|c| c.re));
        let position = s.position.map(|c| c.re);
        let velocity = add(s.position.map(|c| c.eps), add(v, cross(w, position)));
        let spin = add(angular_rate(s.rotation), rotate(to_section, w));
        energy += quadratic(&point.mass, rotate(to_section, velocity), spin) * point.weight;
    }
    energy
}

/// Kinetic energy of a mass on a node, J: velocity and spin in the node frame, by a dual number in time.
pub(crate) fn lumped_kinetic_energy<D: Number>(
    mass: &Matrix6<f64>,
    position: &Vector3<f64>,
    rotation: &UnitQuaternion<f64>,
    motion: &Motion<D, 1>,
) -> D
where
    Dual<D>: Number,
{
    let moving: [Dual<D>; 6] = std::array::from_fn(|k| Dual::new(motion.x[0][k], motion.x_dot[0][k]));
    let q0 = [rotation.w, rotation.i, rotation.j, rotation.k].map(Dual::<D>::from);
    let q = multiply(q0, exp([moving[3], moving[4], moving[5]]));
    let place = add(constant(position), [moving[0], moving[1], moving[2]]);
    let v = [motion.beta[0], motion.beta[1], motion.beta[2]];
    let w = [motion.beta[3], motion.beta[4], motion.beta[5]];
    let to_node = conjugate(q.map(|c| c.re));
    let velocity = add(place.map(|c| c.eps), add(v, cross(w, place.map(|c| c.re))));
    let spin = add(angular_rate(q), rotate(to_node, w));
    quadratic(mass, rotate(to_node, velocity), spin)
}
