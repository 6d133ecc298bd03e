//! What carries a named point, a load or a station: a node, or a section inside an element that stands for one.

use std::sync::Arc;

use nalgebra::{Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3, Vector6};
use rom_runtime::PointMotion;

use crate::assembly::{AnyBeam, beam_of};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::inertia_force::BeamRates;
use crate::element::inside::{CarrierForce, Inside, SpreadForce};
use crate::math::so3::scalar_first;
use crate::mesh::{Mesh, Place};

/// Most nodes that carry one place.
const MOST: usize = 3;

/// A node, or a section inside an element: both have a position and a rotation that is the identity in the drawing.
#[derive(Clone, Debug)]
pub enum Carrier {
    /// A node.
    Node(usize),
    /// A section of an element with two nodes.
    Two(Inside<2>),
    /// A section of an element with three nodes.
    Three(Inside<3>),
}

/// Position, rotation and rates of a node or what stands for one; angular quantities in its own axes.
#[derive(Clone, Copy, Debug)]
pub struct NodeMotion {
    /// Position, m.
    pub position: Vector3<f64>,
    /// Own axes to those of the position.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub spin: Vector3<f64>,
    /// Acceleration, m/s^2.
    pub acceleration: Vector3<f64>,
    /// Rates of the components of `spin`, rad/s^2.
    pub spin_rate: Vector3<f64>,
}

/// A load on the nodes that carry it.
#[derive(Clone, Copy, Debug)]
pub struct AppliedForce {
    count: usize,
    nodes: [usize; MOST],
    force: [Vector6<f64>; MOST],
    by_spin: [[[Matrix3<f64>; 2]; MOST]; MOST],
    by_frame_spin: [[Matrix3<f64>; 2]; MOST],
}

impl Carrier {
    /// What carries a place of a mesh.
    pub fn new(mesh: &Mesh, place: Place) -> Self {
        match place {
            Place::Node(node) => Self::Node(node),
            Place::Inside { element, x } => Self::inside(&SharedBeam::new(mesh, element), x),
        }
    }

    /// The section at `x` in 0..1 along an element.
    pub fn inside(beam: &SharedBeam, x: f64) -> Self {
        match beam {
            SharedBeam::Two(beam) => Self::Two(Inside::new(Arc::clone(beam), x)),
            SharedBeam::Three(beam) => Self::Three(Inside::new(Arc::clone(beam), x)),
        }
    }

    /// Carriers of all named points of a mesh.
    pub fn of_points(mesh: &Mesh) -> Vec<Self> {
        mesh.points.iter().map(|p| Self::new(mesh, p.place)).collect()
    }

    /// Section frame of the drawing at a section, from section axes to those of the carrier; a node has none of its own.
    pub fn drawing_frame(&self) -> Matrix3<f64> {
        match self {
            Self::Node(_) => Matrix3::identity(),
            Self::Two(inside) => *inside.frame(),
            Self::Three(inside) => *inside.frame(),
        }
    }

    /// The nodes.
    pub fn nodes(&self) -> &[usize] {
        match self {
            Self::Node(node) => std::slice::from_ref(node),
            Self::Two(inside) => inside.nodes(),
            Self::Three(inside) => inside.nodes(),
        }
    }

    /// Position and rotation from those of the nodes, in their axes.
    pub fn pose(
        &self,
        position: impl Fn(usize) -> Vector3<f64>,
        rotation: impl Fn(usize) -> UnitQuaternion<f64>,
    ) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let matrix = |node: usize| rotation(node).to_rotation_matrix().into_inner();
        let (r, q) = match self {
            Self::Node(node) => return (position(*node), rotation(*node)),
            Self::Two(inside) => inside.pose(position, matrix),
            Self::Three(inside) => inside.pose(position, matrix),
        };
        (r, quaternion(q))
    }

    /// Position and rotation in a configuration.
    pub fn at(&self, at: &Configuration) -> (Vector3<f64>, UnitQuaternion<f64>) {
        self.pose(|node| at.positions[node], |node| at.rotations[node])
    }

    /// Rotation matrix from those of the nodes.
    pub fn rotation(&self, rotation: impl Fn(usize) -> Matrix3<f64>) -> Matrix3<f64> {
        match self {
            Self::Node(node) => rotation(*node),
            Self::Two(inside) => inside.pose(|_| Vector3::zeros(), rotation).1,
            Self::Three(inside) => inside.pose(|_| Vector3::zeros(), rotation).1,
        }
    }

    /// Motion from that of the nodes.
    pub fn motion(&self, of: impl Fn(usize) -> NodeMotion) -> NodeMotion {
        match self {
            Self::Node(node) => of(*node),
            Self::Two(inside) => motion_inside(inside, of),
            Self::Three(inside) => motion_inside(inside, of),
        }
    }

    /// `(dR, theta)` of the carrier per `(dR, theta)` of each of its nodes about a configuration.
    pub fn maps(&self, at: &Configuration) -> Vec<Matrix6<f64>> {
        match self {
            Self::Node(_) => vec![Matrix6::identity()],
            Self::Two(inside) => inside.maps(&at.of(inside.beam())).to_vec(),
            Self::Three(inside) => inside.maps(&at.of(inside.beam())).to_vec(),
        }
    }

    /// Its nodes, each with the map of its motion.
    pub fn placed(&self, at: &Configuration) -> Vec<(usize, Matrix6<f64>)> {
        self.nodes().iter().copied().zip(self.maps(at)).collect()
    }

    /// As [`Self::placed`], with rotations in section axes.
    pub fn placed_in_section(&self, at: &Configuration) -> Vec<(usize, Matrix6<f64>)> {
        let mut turn = Matrix6::identity();
        turn.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.drawing_frame().transpose());
        self.placed(at).into_iter().map(|(node, map)| (node, turn * map)).collect()
    }

    /// Displacement `(dR, theta)` of the carrier from those of its nodes about a configuration, a column for each mode.
    pub fn shapes<'a>(
        &self,
        at: &Configuration,
        of_node: impl Fn(usize) -> &'a [Vector6<f64>],
    ) -> Vec<Vector6<f64>> {
        if let Self::Node(node) = self {
            return of_node(*node).to_vec();
        }
        let maps = self.maps(at);
        let mut sum = vec![Vector6::zeros(); of_node(self.nodes()[0]).len()];
        for (&node, map) in self.nodes().iter().zip(&maps) {
            sum.iter_mut().zip(of_node(node)).for_each(|(sum, phi)| *sum += map * phi);
        }
        sum
    }

    /// The nodal loads that do the same virtual work as a force on the carrier; with their derivatives where asked.
    pub fn apply(
        &self,
        rotation: impl Fn(usize) -> Matrix3<f64>,
        on: &CarrierForce,
        with_stiffness: bool,
    ) -> AppliedForce {
        match self {
            Self::Node(node) => {
                let CarrierForce { force, by_spin, by_frame_spin } = *on;
                let one =
                    SpreadForce { force: [force], by_spin: [[by_spin]], by_frame_spin: [by_frame_spin] };
                AppliedForce::new(&[*node], &one)
            }
            Self::Two(inside) => {
                AppliedForce::new(inside.nodes(), &inside.spread(rotation, on, with_stiffness))
            }
            Self::Three(inside) => {
                AppliedForce::new(inside.nodes(), &inside.spread(rotation, on, with_stiffness))
            }
        }
    }
}

fn motion_inside<const N: usize>(inside: &Inside<N>, of: impl Fn(usize) -> NodeMotion) -> NodeMotion {
    let nodes = inside.nodes().map(of);
    let index = |node: usize| inside.nodes().iter().position(|&n| n == node).unwrap_or(0);
    let state = inside.beam().state(
        |node| nodes[index(node)].position,
        |node| nodes[index(node)].rotation.to_rotation_matrix().into_inner(),
    );
    let nodal = BeamRates {
        velocity: nodes.map(|n| n.velocity),
        spin: nodes.map(|n| n.spin),
        acceleration: nodes.map(|n| n.acceleration),
        spin_rate: nodes.map(|n| n.spin_rate),
    };
    let found = inside.motion(&state, nodal);
    let ([position, velocity, acceleration], [spin, spin_rate]) = (found.translation, found.spin);
    NodeMotion { position, rotation: quaternion(found.rotation), velocity, spin, acceleration, spin_rate }
}

fn quaternion(rotation: Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation))
}

impl NodeMotion {
    /// How a point at `offset` from it (own axes) moves.
    pub fn of_point(&self, offset: &Vector3<f64>) -> PointMotion {
        let (q, w, w_dot) = (self.rotation, &self.spin, &self.spin_rate);
        let whirl = w.cross(offset);
        PointMotion {
            attitude: scalar_first(&q),
            v_g: (self.velocity + q * whirl).into(),
            w_g: (q * w).into(),
            a_g: (self.acceleration + q * (w_dot.cross(offset) + w.cross(&whirl))).into(),
            // The components of the spin in its own axes change as the vector itself does.
            alpha_g: (q * w_dot).into(),
        }
    }
}

impl AppliedForce {
    fn new<const N: usize>(nodes: &[usize; N], spread: &SpreadForce<N>) -> Self {
        let zero = [Matrix3::zeros(); 2];
        let mut out = Self {
            count: N,
            nodes: [0; MOST],
            force: [Vector6::zeros(); MOST],
            by_spin: [[zero; MOST]; MOST],
            by_frame_spin: [zero; MOST],
        };
        out.nodes[..N].copy_from_slice(nodes);
        out.force[..N].copy_from_slice(&spread.force);
        out.by_frame_spin[..N].copy_from_slice(&spread.by_frame_spin);
        for a in 0..N {
            out.by_spin[a][..N].copy_from_slice(&spread.by_spin[a]);
        }
        out
    }

    /// Every node with its force (axes of the configuration, N) and moment (node frame, N m).
    pub fn forces(&self) -> impl Iterator<Item = (usize, Vector6<f64>)> + '_ {
        (0..self.count).map(|a| (self.nodes[a], self.force[a]))
    }

    /// Derivatives in the spins of the nodes and of frame A, which is that of the node `frame`: row node, column node, derivatives of
    /// force and moment.
    pub fn derivatives(&self, frame: usize) -> impl Iterator<Item = (usize, usize, &[Matrix3<f64>; 2])> + '_ {
        let pairs = (0..self.count).flat_map(move |a| (0..self.count).map(move |b| (a, b)));
        let by_nodes = pairs.map(|(a, b)| (self.nodes[a], self.nodes[b], &self.by_spin[a][b]));
        let turning = (0..self.count).filter(|&a| self.by_frame_spin[a].iter().any(|m| m.amax() > 0.0));
        by_nodes.chain(turning.map(move |a| (self.nodes[a], frame, &self.by_frame_spin[a])))
    }

    /// With the forces seen in axes turned by `to_axes`, and everything times a factor.
    pub fn seen(mut self, to_axes: &Matrix3<f64>, factor: f64) -> Self {
        for a in 0..self.count {
            let force = to_axes * self.force[a].fixed_rows::<3>(0);
            self.force[a].fixed_rows_mut::<3>(0).copy_from(&force);
            self.force[a] *= factor;
            for pair in self.by_spin[a][..self.count].iter_mut().chain([&mut self.by_frame_spin[a]]) {
                *pair = [to_axes * pair[0] * factor, pair[1] * factor];
            }
        }
        self
    }

    /// Whether all its numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.force[..self.count].iter().all(|f| f.iter().all(|x| x.is_finite()))
    }
}

/// An element of either kind that several sections share.
#[derive(Clone, Debug)]
pub enum SharedBeam {
    /// Linear interpolation.
    Two(Arc<Beam<2>>),
    /// Quadratic interpolation.
    Three(Arc<Beam<3>>),
}

impl SharedBeam {
    /// An element of a mesh.
    pub fn new(mesh: &Mesh, element: usize) -> Self {
        match beam_of(mesh, element) {
            AnyBeam::Two(beam) => Self::Two(Arc::new(beam)),
            AnyBeam::Three(beam) => Self::Three(Arc::new(beam)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::internal_force::split;
    use crate::element::tests::Random;
    use crate::math::so3::{exp, exp_quaternion, log};
    use crate::test_structures::crooked;

    /// Nodes of the crooked tree, bent and moving.
    struct Moving(Vec<NodeMotion>);

    impl Moving {
        fn new(mesh: &Mesh, seed: u64) -> Self {
            let mut random = Random::new(seed);
            let node = |r: &Vector3<f64>| NodeMotion {
                position: r + random.vector3(0.2),
                rotation: exp_quaternion(&random.vector3(0.5)),
                velocity: random.vector3(1.0),
                spin: random.vector3(1.0),
                acceleration: random.vector3(1.0),
                spin_rate: random.vector3(1.0),
            };
            Self(mesh.nodes.iter().map(node).collect())
        }

        fn after(&self, h: f64) -> Self {
            let node = |n: &NodeMotion| NodeMotion {
                position: n.position + (n.velocity + n.acceleration * (0.5 * h)) * h,
                rotation: n.rotation * exp_quaternion(&((n.spin + n.spin_rate * (0.5 * h)) * h)),
                velocity: n.velocity + n.acceleration * h,
                spin: n.spin + n.spin_rate * h,
                ..*n
            };
            Self(self.0.iter().map(node).collect())
        }

        fn of(&self, carrier: &Carrier) -> NodeMotion {
            carrier.motion(|node| self.0[node])
        }

        fn rotation(&self, node: usize) -> Matrix3<f64> {
            self.0[node].rotation.to_rotation_matrix().into_inner()
        }
    }

    fn places(mesh: &Mesh) -> Vec<Carrier> {
        (0..mesh.elements.len())
            .map(|element| Carrier::new(mesh, Place::Inside { element, x: 0.15 + 0.1 * element as f64 }))
            .collect()
    }

    /// Differences of the pose give the velocities, those of the velocities the accelerations.
    #[test]
    fn motion_is_the_derivative_of_the_pose() {
        for n_nodes in [2, 3] {
            let mesh = crooked(n_nodes);
            let moving = Moving::new(&mesh, 3);
            let h = 1e-4;
            let (before, after) = (moving.after(-h), moving.after(h));
            for carrier in places(&mesh) {
                let (a, now, b) = (before.of(&carrier), moving.of(&carrier), after.of(&carrier));
                let slope = |b: Vector3<f64>, a: Vector3<f64>| (b - a) / (2.0 * h);
                let turned = (a.rotation.inverse() * b.rotation).to_rotation_matrix().into_inner();
                // Central differences: h^2 of third derivatives.
                assert!((slope(b.position, a.position) - now.velocity).norm() < 1e-7);
                assert!((log(&turned) / (2.0 * h) - now.spin).norm() < 1e-7);
                assert!((slope(b.velocity, a.velocity) - now.acceleration).norm() < 1e-7);
                assert!((slope(b.spin, a.spin) - now.spin_rate).norm() < 1e-7);
            }
        }
    }

    /// Nodal loads have the power of the load on the section, whatever the motion; the maps of displacements are those of velocities.
    #[test]
    fn nodal_loads_do_the_work_of_the_load_on_the_section() {
        for n_nodes in [2, 3] {
            let mesh = crooked(n_nodes);
            let moving = Moving::new(&mesh, 8);
            let at = Configuration {
                positions: moving.0.iter().map(|n| n.position).collect(),
                rotations: moving.0.iter().map(|n| n.rotation).collect(),
            };
            let zero = [Matrix3::zeros(); 2];
            let force = Random::new(5).vector6();
            let load = CarrierForce { force, by_spin: zero, by_frame_spin: zero };
            for carrier in places(&mesh) {
                let now = moving.of(&carrier);
                let (f, m) = split(&force);
                let power = f.dot(&now.velocity) + m.dot(&now.spin);
                let on_nodes = carrier.apply(|node| moving.rotation(node), &load, false);
                let nodal = |(node, force): (usize, Vector6<f64>)| {
                    let (f, m) = split(&force);
                    f.dot(&moving.0[node].velocity) + m.dot(&moving.0[node].spin)
                };
                let spread: f64 = on_nodes.forces().map(nodal).sum();
                assert!((spread - power).abs() < 1e-14 * force.norm(), "{spread} {power}");
                let rates: Vec<Vec<Vector6<f64>>> = moving
                    .0
                    .iter()
                    .map(|n| vec![crate::element::internal_force::stack(&n.velocity, &n.spin)])
                    .collect();
                let (v, w) = split(&carrier.shapes(&at, |node| &rates[node])[0]);
                assert!((v - now.velocity).norm() < 1e-14 && (w - now.spin).norm() < 1e-14);
            }
        }
    }

    /// In the drawing a section stands on the axis, unturned; turned as a whole it goes along.
    #[test]
    fn sections_move_rigidly_with_the_body() {
        let mesh = crooked(3);
        let turn = exp(&Vector3::new(0.7, -0.4, 1.1));
        for carrier in places(&mesh) {
            let (r, q) = carrier.at(&Configuration::drawing(&mesh));
            assert!(q.angle() < 1e-15);
            let rotation = quaternion(turn);
            let (moved, turned) = carrier.pose(|node| turn * mesh.nodes[node], |_| rotation);
            assert!((moved - turn * r).norm() < 1e-15 && turned.angle_to(&rotation) < 1e-14);
        }
    }
}
