//! Inertia forces of an element in arbitrary motion, and their exact tangent.
//!
//! The motion is given in one frame without rates of its own (G, or A at an instant): nodal positions `R`, triads, velocities
//! and accelerations, and the material angular velocities `W_a` and accelerations `A_a` of the node frames. Per section
//!
//! ```text
//! V = C Rdot            W = sum B_a W_a          (P, H) = Mcs (V, W)
//! Vdot = C Rddot - W~ V   Wdot = sum B_a A_a + Bdot_a W_a
//! force on node a:   N_a Lam (Pdot + W x P)
//! moment on node a:  B_a^t (Hdot + W x H + V x P)
//! ```
//!
//! which is `M etaddot + Qgyr` of theory section 2 for a frame at rest. Variations use `delta W = d(delta th)/dt + W x delta th`.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::beam::{Beam, BeamState, InertiaPoint};
use super::internal_force::{ElementMatrix, split, stack};
use super::rotation_field::{FieldRates, RotationField};
use super::weight::mass_and_moment;
use crate::math::so3::skew;

/// Rates of an element's ends: those of its nodes, but for levers ([`Beam::end_rates`]). Angular ones in the node frames.
#[derive(Clone, Copy, Debug)]
pub struct BeamRates<const N: usize> {
    /// Velocities, m/s.
    pub velocity: [Vector3<f64>; N],
    /// Angular velocities, rad/s, node frame.
    pub spin: [Vector3<f64>; N],
    /// Accelerations, m/s^2.
    pub acceleration: [Vector3<f64>; N],
    /// Angular accelerations (rates of the components of `spin`), rad/s^2, node frame.
    pub spin_rate: [Vector3<f64>; N],
}

/// How a time integrator ties rates to increments: `delta velocity = c delta u`, `delta acceleration = m delta u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateFactors {
    /// Velocity per displacement, 1/s.
    pub velocity: f64,
    /// Acceleration per displacement, 1/s^2.
    pub acceleration: f64,
}

/// Momentum and kinetic energy of an element.
#[derive(Clone, Copy, Debug, Default)]
pub struct Momentum {
    /// Mass times position, kg m.
    pub first_moment: Vector3<f64>,
    /// Linear momentum, kg m/s.
    pub linear: Vector3<f64>,
    /// Angular momentum about the origin, kg m^2/s.
    pub angular: Vector3<f64>,
    /// Kinetic energy, J.
    pub kinetic: f64,
}

/// Inertia forces: force (N) and moment in the node frame (N m) on every node.
pub fn inertia_force<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    rates: &BeamRates<N>,
) -> [Vector6<f64>; N] {
    let mut force = [Vector6::zeros(); N];
    let moving = MovingField::new(beam, state, rates, false);
    for point in beam.inertia_points() {
        let s = moving.section(point);
        for a in 0..N {
            let f = s.rotation.triad * s.motion.force * (point.weight * point.shape.n[a]);
            let m = beam.frames[a] * s.rotation.b[a].tr_mul(&s.motion.moment) * point.weight;
            force[a] += stack(&f, &m);
        }
    }
    beam.force_to_nodes(state, &mut force);
    force
}

/// Inertia forces on the nodes and their tangent in nodal increments (position, spin in the node frame), the rates following by
/// `factors` from the increments `(position, theta)`; `tangential[a]` is `T(theta)` of the node's rotation since the
/// start of the step: `spin increment = T theta increment`. Columns of the tangent are `(position, theta)`.
pub fn inertia_force_and_tangent<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    rates: &BeamRates<N>,
    factors: RateFactors,
    tangential: &[Matrix3<f64>; N],
) -> ([Vector6<f64>; N], ElementMatrix<N>) {
    let mut force = [Vector6::zeros(); N];
    let mut tangent = [[Matrix6::zeros(); N]; N];
    let moving = MovingField::new(beam, state, rates, true);
    for point in beam.inertia_points() {
        let s = moving.section(point);
        let b2 = moving.field.b2(&s.rotation, &moving.field_rates);
        let turn = moving.field.derivative_bt(&s.rotation, &s.motion.moment);
        let variation: [SectionVariation; N] =
            std::array::from_fn(|b| moving.variation(&s, &b2[b], point, b, factors, &tangential[b]));
        for a in 0..N {
            let bt = beam.frames[a] * s.rotation.b[a].transpose() * point.weight;
            let lam = s.rotation.triad * (point.weight * point.shape.n[a]);
            force[a] += stack(&(lam * s.motion.force), &(bt * s.motion.moment));
            for b in 0..N {
                let v = &variation[b];
                let block = &mut tangent[a][b];
                add_block(block, 0, 0, &(lam * v.force_position));
                add_block(block, 0, 3, &(lam * v.force_rotation));
                add_block(block, 3, 0, &(bt * v.moment_position));
                let turned =
                    beam.frames[a] * turn[a][b] * beam.frames[b].transpose() * tangential[b] * point.weight;
                add_block(block, 3, 3, &(bt * v.moment_rotation + turned));
            }
        }
    }
    beam.rows_to_nodes(state, &mut force, &mut tangent, tangential);
    (force, tangent)
}

/// Momentum and kinetic energy; accelerations are not used.
pub fn momentum<const N: usize>(beam: &Beam<N>, state: &BeamState<N>, rates: &BeamRates<N>) -> Momentum {
    let mut out = Momentum::default();
    let field = RotationField::new(&state.triads);
    for point in beam.inertia_points() {
        let section = field.at(&point.shape);
        let position = state.position(&point.shape);
        let mut v = Vector3::zeros();
        let mut w = Vector3::zeros();
        for a in 0..N {
            v += rates.velocity[a] * point.shape.n[a];
            w += section.b[a] * (beam.frames[a].transpose() * rates.spin[a]);
        }
        let velocity = stack(&(section.triad.transpose() * v), &w);
        let local = point.mass * velocity * point.weight;
        let p = section.triad * local.fixed_rows::<3>(0);
        out.linear += p;
        out.angular += position.cross(&p) + section.triad * local.fixed_rows::<3>(3);
        out.kinetic += 0.5 * velocity.dot(&local);
        out.first_moment += section_first_moment(&point.mass, &section.triad, &position) * point.weight;
    }
    out
}

/// `m R + Lam s`, `s` the first moment of the section.
pub(crate) fn section_first_moment(
    mass: &Matrix6<f64>,
    triad: &Matrix3<f64>,
    position: &Vector3<f64>,
) -> Vector3<f64> {
    let (m, s) = mass_and_moment(mass);
    position * m + triad * s
}

/// Element in motion: rotation field and nodal spins in section frames.
struct MovingField<'a, const N: usize> {
    beam: &'a Beam<N>,
    state: &'a BeamState<N>,
    rates: &'a BeamRates<N>,
    field: RotationField<N>,
    field_rates: FieldRates<N>,
    spin: [Vector3<f64>; N],
    spin_rate: [Vector3<f64>; N],
}

/// One section of an element in motion, and how the nodal spins reach it.
struct MovingSection<const N: usize> {
    rotation: super::rotation_field::SectionRotation<N>,
    motion: SectionMotion,
    b1: [Matrix3<f64>; N],
}

/// A rigid section (or a mass on a node) in motion: velocities and inertia force, in the section frame.
pub(crate) struct SectionMotion {
    mass: Matrix6<f64>,
    triad: Matrix3<f64>,
    v: Vector3<f64>,
    w: Vector3<f64>,
    w1: Vector3<f64>,
    /// `C Rddot`.
    acceleration: Vector3<f64>,
    p: Vector3<f64>,
    h: Vector3<f64>,
    /// `Pdot + W x P`.
    pub(crate) force: Vector3<f64>,
    /// `Hdot + W x H + V x P`.
    pub(crate) moment: Vector3<f64>,
}

/// How a node moves a section: its share of the translation, `B`, its two rates, and the node's spin in its section frame.
pub(crate) struct NodeAction<'a> {
    pub(crate) share: f64,
    pub(crate) b: [&'a Matrix3<f64>; 3],
    pub(crate) to_section: Matrix3<f64>,
    pub(crate) spin: Vector3<f64>,
    pub(crate) spin_rate: Vector3<f64>,
    /// What the node's `theta` adds to the velocity and acceleration it passes on, over a lever.
    pub(crate) lever: Option<[Matrix3<f64>; 2]>,
}

/// Derivatives of the section force and moment in one node's increments.
pub(crate) struct SectionVariation {
    pub(crate) force_position: Matrix3<f64>,
    pub(crate) force_rotation: Matrix3<f64>,
    pub(crate) moment_position: Matrix3<f64>,
    pub(crate) moment_rotation: Matrix3<f64>,
}

impl<'a, const N: usize> MovingField<'a, N> {
    fn new(beam: &'a Beam<N>, state: &'a BeamState<N>, rates: &'a BeamRates<N>, second: bool) -> Self {
        let local = |v: &[Vector3<f64>; N]| std::array::from_fn(|a| beam.frames[a].transpose() * v[a]);
        let field = RotationField::new(&state.triads);
        let (spin, spin_rate) = (local(&rates.spin), local(&rates.spin_rate));
        let field_rates = field.rates(&spin, &spin_rate, second);
        Self { beam, state, rates, field, field_rates, spin, spin_rate }
    }

    fn section(&self, point: &InertiaPoint<N>) -> MovingSection<N> {
        let rotation = self.field.at(&point.shape);
        let b1 = self.field.b1(&rotation, &self.field_rates);
        let (mut v, mut a) = (Vector3::zeros(), Vector3::zeros());
        let (mut w, mut w1) = (Vector3::zeros(), Vector3::zeros());
        for n in 0..N {
            v += self.rates.velocity[n] * point.shape.n[n];
            a += self.rates.acceleration[n] * point.shape.n[n];
            w += rotation.b[n] * self.spin[n];
            w1 += rotation.b[n] * self.spin_rate[n] + b1[n] * self.spin[n];
        }
        let motion = SectionMotion::new(&rotation.triad, &point.mass, &v, &a, &w, &w1);
        MovingSection { rotation, motion, b1 }
    }

    fn variation(
        &self,
        s: &MovingSection<N>,
        b2: &Matrix3<f64>,
        point: &InertiaPoint<N>,
        node: usize,
        factors: RateFactors,
        tangential: &Matrix3<f64>,
    ) -> SectionVariation {
        let action = NodeAction {
            share: point.shape.n[node],
            b: [&s.rotation.b[node], &s.b1[node], b2],
            to_section: self.beam.frames[node].transpose(),
            spin: self.spin[node],
            spin_rate: self.spin_rate[node],
            lever: self.beam.lever_rate_variation(self.state, self.rates, node, factors, tangential),
        };
        s.motion.variation(&action, factors, tangential)
    }
}

impl SectionMotion {
    /// From the velocity and acceleration of the section's origin (fixed axes) and the material spin and its rate.
    pub(crate) fn new(
        triad: &Matrix3<f64>,
        mass: &Matrix6<f64>,
        velocity: &Vector3<f64>,
        acceleration: &Vector3<f64>,
        w: &Vector3<f64>,
        w1: &Vector3<f64>,
    ) -> Self {
        let (v, acceleration) = (triad.tr_mul(velocity), triad.tr_mul(acceleration));
        let v1 = acceleration - w.cross(&v);
        let (p, h) = split(&(mass * stack(&v, w)));
        let (p1, h1) = split(&(mass * stack(&v1, w1)));
        let (force, moment) = (p1 + w.cross(&p), h1 + w.cross(&h) + v.cross(&p));
        Self { mass: *mass, triad: *triad, v, w: *w, w1: *w1, acceleration, p, h, force, moment }
    }

    pub(crate) fn variation(
        &self,
        node: &NodeAction<'_>,
        factors: RateFactors,
        tangential: &Matrix3<f64>,
    ) -> SectionVariation {
        let RateFactors { velocity: cv, acceleration: ca } = factors;
        let (v, w) = (skew(&self.v), skew(&self.w));
        let c = self.triad.transpose() * node.share;
        // Position increments: delta V = cv C, delta Vdot = ca C - W~ delta V; no spin changes.
        let v_x = c * cv;
        let v1_x = c * ca - w * v_x;

        // Rotation increments: the section turns by `th`; its spin and spin rate follow from
        // delta W = d(th)/dt + W x th, with the nodal spins' own increments.
        let [b, b1, b2] = node.b;
        let turn = node.to_section * tangential;
        let (wa, wa1) = (skew(&node.spin), skew(&node.spin_rate));
        let e = b1 - b * wa + w * b;
        let e1 = b2 - b1 * wa - b * wa1 + skew(&self.w1) * b + w * b1;
        let th = b * turn;
        let w_th = b * node.to_section * cv + e * turn;
        let w1_th = b * node.to_section * ca + (b1 + e) * node.to_section * cv + (e1 - e * wa) * turn;
        let mut v_th = v * th;
        let mut a_th = skew(&self.acceleration) * th;
        if let Some([velocity, acceleration]) = &node.lever {
            v_th += c * velocity;
            a_th += c * acceleration;
        }
        let v1_th = a_th + v * w_th - w * v_th;

        let m = &self.mass;
        let momentum = |dv: &Matrix3<f64>, dw: &Matrix3<f64>| {
            (
                m.fixed_view::<3, 3>(0, 0) * dv + m.fixed_view::<3, 3>(0, 3) * dw,
                m.fixed_view::<3, 3>(3, 0) * dv + m.fixed_view::<3, 3>(3, 3) * dw,
            )
        };
        let zero = Matrix3::zeros();
        let (p_x, h_x) = momentum(&v_x, &zero);
        let (p1_x, h1_x) = momentum(&v1_x, &zero);
        let (p_th, h_th) = momentum(&v_th, &w_th);
        let (p1_th, h1_th) = momentum(&v1_th, &w1_th);
        let (p, h) = (skew(&self.p), skew(&self.h));
        SectionVariation {
            force_position: p1_x + w * p_x,
            force_rotation: p1_th - p * w_th + w * p_th - skew(&self.force) * th,
            moment_position: h1_x + w * h_x - p * v_x + v * p_x,
            moment_rotation: h1_th - h * w_th + w * h_th - p * v_th + v * p_th,
        }
    }
}

fn add_block(m: &mut Matrix6<f64>, i: usize, j: usize, block: &Matrix3<f64>) {
    let mut view = m.fixed_view_mut::<3, 3>(i, j);
    view += block;
}
