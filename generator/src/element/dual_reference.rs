//! Energies of an element written once more for dual numbers, from the definitions alone: quaternions, no operator of the
//! production code. Their exact derivatives are what the hand-written operators are tested against.

use nalgebra::{Matrix6, UnitQuaternion, Vector3};
use num_dual::Dual;

use super::beam::{Beam, BeamState};
pub(crate) use super::kinematics::Number;
use super::kinematics::{
    Vec3, add, angular_rate, conjugate, constant, exp, multiply, rotate, section, strain,
};

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

fn cross<D: Number>(a: Vec3<D>, b: Vec3<D>) -> Vec3<D> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
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
        let [g1, g2, g3, k1, k2, k3] = strain(beam, state, x, point);
        energy += quadratic(&point.stiffness, [g1, g2, g3], [k1, k2, k3]) * point.weight;
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
