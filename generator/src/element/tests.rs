//! Every operator of this module against dual numbers, at random, largely deformed states, with full section matrices.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};
use num_dual::HyperDual64;

use super::beam::{Beam, BeamState, EndSections};
use super::dual_reference::{Motion, elastic_energy, kinetic_energy};
use super::gyroscopic::gyroscopic;
use super::inertia::mass;
use super::inertia_force::{BeamRates, RateFactors, inertia_force, inertia_force_and_tangent};
use super::internal_force::{internal_force, internal_force_and_stiffness};
use super::weight::{lump_weight, lump_weight_tangent, weight, weight_tangent};
use crate::math::so3::{MatrixFunction, exp, skew};

/// Small deterministic generator of numbers in -1..1 (xorshift).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector3(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.next() * size)
    }

    pub(crate) fn vector6(&mut self) -> Vector6<f64> {
        Vector6::from_fn(|_, _| self.next())
    }

    /// Mass matrix of a body: mass, centre of mass beside the origin, inertia.
    pub(crate) fn body(&mut self) -> Matrix6<f64> {
        let (m, c) = (1.5 + self.next(), self.vector3(0.4));
        let j: Matrix3<f64> = Matrix3::from_fn(|_, _| self.next());
        let j = j * j.transpose() + Matrix3::identity();
        let s = skew(&(c * m));
        let mut mass = Matrix6::zeros();
        mass.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * m));
        mass.fixed_view_mut::<3, 3>(0, 3).copy_from(&-s);
        mass.fixed_view_mut::<3, 3>(3, 0).copy_from(&s);
        mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&(j - skew(&c) * s));
        mass
    }

    /// Full symmetric positive definite section matrix.
    pub(crate) fn spd(&mut self) -> Matrix6<f64> {
        let a: SMatrix<f64, 6, 6> = SMatrix::from_fn(|_, _| self.next());
        a * a.transpose() + Matrix6::identity() * 0.5
    }
}

struct Case<const N: usize> {
    beam: Beam<N>,
    state: BeamState<N>,
}

/// A curved, twisted, tapered element with skew section frames, then bent and turned: relative rotations of about 1 rad.
fn case<const N: usize>(seed: u64) -> Case<N> {
    case_of::<N>(seed, Random::spd)
}

/// With section masses of bodies, their centres beside the axis.
fn body_case<const N: usize>(seed: u64) -> Case<N> {
    case_of::<N>(seed, Random::body)
}

fn case_of<const N: usize>(seed: u64, mass: fn(&mut Random) -> Matrix6<f64>) -> Case<N> {
    let mut random = Random::new(seed);
    let (s0, s1) = (random.spd(), random.spd());
    let (m0, m1) = (mass(&mut random), mass(&mut random));
    let sections = EndSections { stiffness: [&s0, &s1], mass: [&m0, &m1] };
    let overall = exp(&random.vector3(2.0));
    let frames: [Matrix3<f64>; N] = std::array::from_fn(|_| overall * exp(&random.vector3(0.3)));
    let drawing: [Vector3<f64>; N] =
        std::array::from_fn(|a| overall * Vector3::new(a as f64, 0.0, 0.0) + random.vector3(0.2));
    let beam = Beam::new(std::array::from_fn(|a| a), drawing, frames, (N - 1) as f64 * 1.1, sections);
    // Every second one is joined to its nodes by rigid links.
    let lever = if seed.is_multiple_of(2) { 0.6 } else { 0.0 };
    let beam = beam.with_levers(std::array::from_fn(|_| random.vector3(lever)));
    let turned = exp(&random.vector3(2.0));
    let state = BeamState {
        positions: drawing.map(|p| turned * p + random.vector3(0.5)),
        triads: frames.map(|e| turned * exp(&random.vector3(0.4)) * e),
    };
    Case { beam, state }
}

/// Unit vector of degree of freedom `k` of node `a`, as the increments of both hyper-dual directions.
fn directions<const N: usize>(i: usize, j: usize) -> [[HyperDual64; 6]; N] {
    std::array::from_fn(|a| {
        std::array::from_fn(|k| {
            let one = |d: usize| f64::from(u8::from(d == 6 * a + k));
            HyperDual64::new(0.0, one(i), one(j), 0.0)
        })
    })
}

/// Dual numbers and closed forms both carry round-off only; 1e-11 of the largest entry leaves three digits for it.
const TOLERANCE: f64 = 1e-11;

fn stiffness_is_the_hessian<const N: usize>(seed: u64) {
    let Case { beam, state } = case::<N>(seed);
    let (force, k) = internal_force_and_stiffness(&beam, &state);
    assert_eq!(internal_force(&beam, &state).force, force.force);
    let scale = k.iter().flatten().map(|b| b.amax()).fold(0.0, f64::max);
    for i in 0..6 * N {
        for j in 0..6 * N {
            let u = elastic_energy(&beam, &state, &directions::<N>(i, j));
            let block = k[i / 6][j / 6][(i % 6, j % 6)];
            assert!((u.eps1eps2 - block).abs() < TOLERANCE * scale, "K[{i},{j}]: {} {block}", u.eps1eps2);
            assert!((u.eps1 - force.force[i / 6][i % 6]).abs() < TOLERANCE * scale, "f[{i}]");
            assert!((u.re - force.energy).abs() < TOLERANCE * scale);
        }
    }
}

#[test]
fn internal_force_and_stiffness_are_derivatives_of_the_energy() {
    for seed in 1..6 {
        stiffness_is_the_hessian::<2>(seed);
        stiffness_is_the_hessian::<3>(seed);
    }
}

/// Directional derivatives of the kinetic energy: `eps1` moves along `(x1, x1_dot, beta1)`, `eps2` along the second.
struct Direction<const N: usize> {
    x: [Vector6<f64>; N],
    x_dot: [Vector6<f64>; N],
    beta: Vector6<f64>,
}

impl<const N: usize> Direction<N> {
    fn zero() -> Self {
        Self { x: [Vector6::zeros(); N], x_dot: [Vector6::zeros(); N], beta: Vector6::zeros() }
    }
}

fn kinetic<const N: usize>(
    case: &Case<N>,
    beta: &Vector6<f64>,
    one: &Direction<N>,
    two: &Direction<N>,
) -> HyperDual64 {
    let mut motion = Motion::<HyperDual64, N>::rest();
    for k in 0..6 {
        for a in 0..N {
            motion.x[a][k] = HyperDual64::new(0.0, one.x[a][k], two.x[a][k], 0.0);
            motion.x_dot[a][k] = HyperDual64::new(0.0, one.x_dot[a][k], two.x_dot[a][k], 0.0);
        }
        motion.beta[k] = HyperDual64::new(beta[k], one.beta[k], two.beta[k], 0.0);
    }
    kinetic_energy(&case.beam, &case.state, &motion)
}

fn blocks_product<const N: usize>(
    m: &[[Matrix6<f64>; N]; N],
    left: &[Vector6<f64>; N],
    right: &[Vector6<f64>; N],
) -> f64 {
    let mut sum = 0.0;
    for a in 0..N {
        for b in 0..N {
            sum += left[a].dot(&(m[a][b] * right[b]));
        }
    }
    sum
}

/// `(w x p_v, w x p_w + v x p_v)`: the transport of a momentum by the velocity of A (theory section 2).
fn transport(beta: &Vector6<f64>, p: &Vector6<f64>) -> Vector6<f64> {
    let (v, w): (Vector3<f64>, Vector3<f64>) =
        (beta.fixed_rows::<3>(0).into(), beta.fixed_rows::<3>(3).into());
    let (pv, pw): (Vector3<f64>, Vector3<f64>) = (p.fixed_rows::<3>(0).into(), p.fixed_rows::<3>(3).into());
    let (force, moment) = (w.cross(&pv), w.cross(&pw) + v.cross(&pv));
    Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
}

fn inertia_operators_are_derivatives<const N: usize>(seed: u64) {
    let case = case::<N>(seed);
    let mut random = Random::new(seed + 100);
    let beta = random.vector6();
    let x: [Vector6<f64>; N] = std::array::from_fn(|_| random.vector6());
    let y: [Vector6<f64>; N] = std::array::from_fn(|_| random.vector6());
    let z = random.vector6();
    let m = mass(&case.beam, &case.state);
    let g = gyroscopic(&case.beam, &case.state, &beta);
    let scale = m.rr.amax();
    let close =
        |a: f64, b: f64, what: &str| assert!((a - b).abs() < 1e2 * TOLERANCE * scale, "{what}: {a} {b}");

    let along_x = Direction { x, ..Direction::zero() };
    let along_y = Direction { x: y, ..Direction::zero() };
    let rate_x = Direction { x_dot: x, ..Direction::zero() };
    let rate_y = Direction { x_dot: y, ..Direction::zero() };
    let rigid = |b: Vector6<f64>| Direction { beta: b, ..Direction::zero() };
    let unit = |r: usize| rigid(Vector6::from_fn(|k, _| f64::from(u8::from(k == r))));
    let t = |one: &Direction<N>, two: &Direction<N>| kinetic(&case, &beta, one, two);

    close(blocks_product(&m.ss, &y, &x), t(&rate_y, &rate_x).eps1eps2, "M_SS");
    let sr: f64 = (0..N).map(|a| y[a].dot(&(m.sr[a] * z))).sum();
    close(sr, t(&rate_y, &rigid(z)).eps1eps2, "M_SR");
    close(z.dot(&(m.rr * z)), t(&rigid(z), &rigid(z)).eps1eps2, "M_RR");

    close(
        blocks_product(&g.c_ss, &y, &x),
        t(&along_x, &rate_y).eps1eps2 - t(&along_y, &rate_x).eps1eps2,
        "C_SS",
    );
    let sr: f64 = (0..N).map(|a| y[a].dot(&(g.c_sr[a] * beta))).sum();
    close(sr, -t(&along_y, &along_y).eps1, "C_SR");
    close(blocks_product(&g.k_s, &y, &x), -t(&along_y, &along_x).eps1eps2, "K_S");

    let momentum = Vector6::from_fn(|r, _| t(&unit(r), &along_x).eps1);
    let momentum_x = Vector6::from_fn(|r, _| t(&unit(r), &along_x).eps1eps2);
    let momentum_rate = Vector6::from_fn(|r, _| t(&unit(r), &rate_x).eps1eps2);
    let c_rr = transport(&beta, &momentum);
    let c_rs = momentum_x + transport(&beta, &momentum_rate);
    let k_r = transport(&beta, &momentum_x);
    let sum = |blocks: &[Matrix6<f64>; N]| -> Vector6<f64> { (0..N).map(|a| blocks[a] * x[a]).sum() };
    for r in 0..6 {
        close((g.c_rr * beta)[r], c_rr[r], "C_RR");
        close(sum(&g.c_rs)[r], c_rs[r], "C_RS");
        close(sum(&g.k_r)[r], k_r[r], "K_R");
    }
}

#[test]
fn inertia_operators_are_derivatives_of_the_kinetic_energy() {
    for seed in 1..9 {
        inertia_operators_are_derivatives::<2>(seed);
        inertia_operators_are_derivatives::<3>(seed);
    }
}

#[test]
fn a_rigid_motion_strains_nothing() {
    for seed in 1..5 {
        let mut random = Random::new(seed + 50);
        let Case { beam, .. } = case::<3>(seed);
        let turn = exp(&random.vector3(3.0));
        let shift = random.vector3(10.0);
        let Case { state, .. } = case::<3>(seed);
        let rest = internal_force(&beam, &state);
        let moved = BeamState {
            positions: state.positions.map(|p| turn * p + shift),
            triads: state.triads.map(|e| turn * e),
        };
        let after = internal_force(&beam, &moved);
        assert!((rest.energy - after.energy).abs() < 1e-12 * rest.energy);
        for a in 0..3 {
            let f: Vector3<f64> = rest.force[a].fixed_rows::<3>(0).into();
            let g: Vector3<f64> = after.force[a].fixed_rows::<3>(0).into();
            assert!((turn * f - g).norm() < 1e-12 * rest.energy);
        }
    }
}

/// Rates for a case, angular ones in the node frames.
fn rates<const N: usize>(seed: u64) -> BeamRates<N> {
    let mut random = Random::new(seed + 300);
    let mut vectors = || std::array::from_fn(|_| random.vector3(1.0));
    BeamRates { velocity: vectors(), spin: vectors(), acceleration: vectors(), spin_rate: vectors() }
}

/// Lagrange's equations of the dual-number energy, with `theta = 0`, `thetadot = spin` at the instant: `d/dt(dT/dxdot) -
/// dT/dx`. Around `theta = 0` the rate of the spin is `thetaddot` (the derivative of `T(theta) thetadot` adds
/// `-1/2 thetadot x thetadot = 0`), and moments about `theta` and about the spin agree.
fn inertia_force_is_lagrange<const N: usize>(seed: u64) {
    let case = case::<N>(seed);
    let rates = rates::<N>(seed);
    let force = inertia_force(&case.beam, &case.state, &case.beam.end_rates(&case.state, rates));
    let join = |a: &[Vector3<f64>; N], b: &[Vector3<f64>; N]| -> [Vector6<f64>; N] {
        std::array::from_fn(|n| Vector6::new(a[n].x, a[n].y, a[n].z, b[n].x, b[n].y, b[n].z))
    };
    let x1 = join(&rates.velocity, &rates.spin);
    let x2 = join(&rates.acceleration, &rates.spin_rate);
    let scale = force.iter().map(|f| f.amax()).fold(0.0, f64::max);
    for i in 0..6 * N {
        let unit = |d: usize, k: usize| f64::from(u8::from(6 * d + k == i));
        // eps1 moves along the path (x += x1, xdot += x2); eps2 along the unit rate, or the unit displacement.
        let path = |displacement: bool| {
            let mut motion = Motion::<HyperDual64, N>::rest();
            for a in 0..N {
                for k in 0..6 {
                    let e = unit(a, k);
                    let (dx, dv) = if displacement { (e, 0.0) } else { (0.0, e) };
                    motion.x[a][k] = HyperDual64::new(0.0, x1[a][k], dx, 0.0);
                    motion.x_dot[a][k] = HyperDual64::new(x1[a][k], x2[a][k], dv, 0.0);
                }
            }
            kinetic_energy(&case.beam, &case.state, &motion)
        };
        let lagrange = path(false).eps1eps2 - path(true).eps2;
        let ours = force[i / 6][i % 6];
        assert!((lagrange - ours).abs() < 1e2 * TOLERANCE * scale, "{i}: {lagrange} {ours}");
    }
}

#[test]
fn inertia_forces_are_lagranges() {
    for seed in 1..9 {
        inertia_force_is_lagrange::<2>(seed);
        inertia_force_is_lagrange::<3>(seed);
    }
}

/// The tangent against sixth-order central differences of the force along every increment, rates following.
fn inertia_tangent_is_the_derivative<const N: usize>(seed: u64) {
    let case = case::<N>(seed);
    let rates = rates::<N>(seed);
    let mut random = Random::new(seed + 400);
    let start: [Vector3<f64>; N] = std::array::from_fn(|_| random.vector3(0.4));
    let factors = RateFactors { velocity: 1.7, acceleration: 2.9 };
    let tangential = start.map(|t| MatrixFunction::tangential(&t).matrix());
    let ends = case.beam.end_rates(&case.state, rates);
    let (force, tangent) = inertia_force_and_tangent(&case.beam, &case.state, &ends, factors, &tangential);
    let plain = inertia_force(&case.beam, &case.state, &ends);
    for a in 0..N {
        assert!((force[a] - plain[a]).amax() < 1e-13 * plain[a].amax());
    }
    let moved = |j: usize, h: f64| {
        let (mut state, mut r) = (case.state, rates);
        let (a, k) = (j / 6, j % 6);
        let step = Vector3::ith(k % 3, h);
        if k < 3 {
            state.positions[a] += step;
            r.velocity[a] += step * factors.velocity;
            r.acceleration[a] += step * factors.acceleration;
        } else {
            let node = state.triads[a] * case.beam.frames[a].transpose();
            let turned = node * exp(&start[a]).transpose() * exp(&(start[a] + step));
            state.triads[a] = turned * case.beam.frames[a];
            let lever = case.beam.levers.map_or_else(Vector3::zeros, |r| r[a]);
            state.positions[a] += (turned - node) * lever;
            r.spin[a] += step * factors.velocity;
            r.spin_rate[a] += step * factors.acceleration;
        }
        inertia_force(&case.beam, &state, &case.beam.end_rates(&state, r))
    };
    let scale = tangent.iter().flatten().map(|b| b.amax()).fold(0.0, f64::max);
    for j in 0..6 * N {
        // Truncation h^6 = 1e-12 of a seventh derivative of order 1e2, round-off 1e-16/h = 1e-14.
        let h = 1e-2;
        let d = |k: f64| {
            let (p, m) = (moved(j, k * h), moved(j, -k * h));
            let difference: [Vector6<f64>; N] = std::array::from_fn(|a| p[a] - m[a]);
            difference
        };
        let (d1, d2, d3) = (d(1.0), d(2.0), d(3.0));
        for a in 0..N {
            let numeric = (d1[a] * 45.0 - d2[a] * 9.0 + d3[a]) / (60.0 * h);
            let exact = tangent[a][j / 6].column(j % 6).into_owned();
            assert!((numeric - exact).amax() < 1e-9 * scale, "{a} {j}: {numeric} {exact}");
        }
    }
}

#[test]
fn inertia_tangents_are_derivatives() {
    for seed in 1..5 {
        inertia_tangent_is_the_derivative::<2>(seed);
        inertia_tangent_is_the_derivative::<3>(seed);
    }
}

/// Weight is the inertia force of a body at rest that accelerates the other way, and so is its tangent; both of those are proven
/// against dual numbers above.
fn weight_is_an_inertia_force<const N: usize>(seed: u64) {
    let mut random = Random::new(seed);
    let Case { beam, state } = body_case::<N>(seed);
    let g = random.vector3(10.0);
    let zero = [Vector3::zeros(); N];
    let rates = BeamRates { velocity: zero, spin: zero, acceleration: [-g; N], spin_rate: zero };
    let factors = RateFactors { velocity: 0.0, acceleration: 0.0 };
    let (force, tangent) =
        inertia_force_and_tangent(&beam, &state, &rates, factors, &[Matrix3::identity(); N]);
    let found = weight(&beam, &state, &g);
    let found_tangent = weight_tangent(&beam, &state, &g).unwrap();
    let scale = force.iter().map(|f| f.amax()).fold(0.0, f64::max);
    for a in 0..N {
        assert!((found[a] + force[a]).amax() < 1e-14 * scale, "{} {}", found[a], force[a]);
        for b in 0..N {
            assert!((found_tangent[a][b] + tangent[a][b]).amax() < 1e-14 * scale);
        }
    }
}

#[test]
fn weight_is_the_inertia_force_of_the_opposite_acceleration() {
    for seed in 1..4 {
        weight_is_an_inertia_force::<2>(seed);
        weight_is_an_inertia_force::<3>(seed);
    }
    // A mass on a node: the pull of its centre of mass and its moment about the node.
    let mut random = Random::new(9);
    let lump = crate::mesh::LumpedMass { node: 0, mass: random.body() };
    let (q, g) = (exp(&random.vector3(2.0)), random.vector3(10.0));
    let m = lump.mass[(0, 0)];
    let arm = Vector3::new(lump.mass[(1, 5)], lump.mass[(2, 3)], lump.mass[(0, 4)]) / m;
    let force = lump_weight(&lump, &q, &g);
    assert!((force.fixed_rows::<3>(0) - g * m).amax() < 1e-13);
    assert!((q * force.fixed_rows::<3>(3) - (q * arm).cross(&(g * m))).amax() < 1e-13);
    let tangent = lump_weight_tangent(&lump, &q, &g).unwrap()[0][0];
    let h = 1e-6;
    for k in 0..3 {
        let at = |h: f64| lump_weight(&lump, &(q * exp(&(Vector3::ith(k, h)))), &g);
        // Central difference: h^2 and round-off over h.
        assert!(((at(h) - at(-h)) / (2.0 * h) - tangent.column(3 + k)).amax() < 1e-8);
    }
}
