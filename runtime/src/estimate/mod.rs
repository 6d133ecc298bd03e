//! How far a marched model is from the body it stands for, estimated while it is marched (docs/validity.md).
//!
//! The defect of its equations, what they leave out, is evaluated on its own motion every few steps and propagated by the linear
//! oscillators and the rigid body into errors of `v_G`, `w_G` and the displacements of the named points. Their largest lengths so far,
//! over those of the quantities themselves, are the errors that a validation against the nonlinear structure would measure.

mod bending;
mod defect;
mod forms;
mod instant;
mod lines;
mod manifold;
mod missing;
mod order;
mod propagate;
#[cfg(test)]
mod tests;

use alloc::{sync::Arc, vec, vec::Vec};

use crate::data::{GravityData, TrimData};
use crate::dense::Dense;
use crate::equations::Workspace;
use crate::expression::Variables;
use crate::four::Vectors;
use crate::loading::Acting;
use crate::math::{
    Mat3, Vec3, Vec6, add, add_6, axpy, combine, cross, dot, join, mat_mul, matrix, mul, mul_t, rotation,
    split, sub,
};
use crate::method::Method;
use crate::model::Model;
use crate::state::{State, true_velocity};
use defect::{Defect, Sample};
use instant::Instant;
pub(crate) use lines::Estimated;
use lines::Line;
use manifold::Manifold;
use missing::Missing;
use order::Order;
use propagate::{Body, Errors, central_inertia};

/// Estimated errors of a run so far, and how much of the range of the model it has used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorEstimate {
    /// Of the velocity of A in G: largest length of the error so far over the largest of the velocity.
    pub v_g: f64,
    /// Of the angular velocity of A in G.
    pub w_g: f64,
    /// Of the displacements of the named points: the worst of those that move at least a tenth as far as the farthest.
    pub dr_a: f64,
    /// Largest amplitude at this instant over the one at which the terms left out reach a tenth of those kept.
    pub amplitude: f64,
    /// Largest angular rate at this instant over the one at which the centrifugal terms left out reach a tenth of the stiffness.
    pub rate: f64,
    /// Whether loads per length, or loads on stations, acted whose effect on what the modes miss is not in the estimate: those that the
    /// structure did not declare when the model was built, in a load case or in its equilibrium (docs/validity.md).
    pub unseen_loads: bool,
}

impl ErrorEstimate {
    /// The error indicator: the largest of the three errors.
    pub fn indicator(&self) -> f64 {
        self.v_g.max(self.w_g).max(self.dr_a)
    }

    /// Whether the range of the model is left: an error, or terms left out, above a tenth.
    pub fn out_of_range(&self) -> bool {
        self.indicator() > 0.1 || self.amplitude > 1.0 || self.rate > 1.0
    }
}

/// Largest lengths so far of an error and of what it is an error of.
#[derive(Clone, Copy, Debug, Default)]
struct Largest {
    error: f64,
    value: f64,
}

impl Largest {
    fn see(&mut self, value: Vec3, error: Vec3) {
        let truth = add(value, error);
        self.error = self.error.max(libm::sqrt(dot(error, error)));
        self.value = self.value.max(libm::sqrt(dot(truth, truth)));
    }

    fn ratio(&self) -> f64 {
        relative(self.error, self.value)
    }
}

/// Largest lengths so far of a displacement and of the parts of its error: of the equations, of what the modes miss, and of the levers that
/// missing rotations turn.
#[derive(Clone, Copy, Debug, Default)]
struct Displaced {
    parts: [f64; 3],
    value: f64,
}

impl Displaced {
    fn see(&mut self, truth: Vec3, parts: [f64; 3]) {
        self.value = self.value.max(libm::sqrt(dot(truth, truth)));
        self.parts.iter_mut().zip(parts).for_each(|(to, part)| *to = to.max(part));
    }
}

/// What the named points do at an instant - (points) each.
#[derive(Clone, Debug)]
struct Points {
    /// Motion of all nodes in the modes, six rows each - (6 points x m).
    phi: Dense,
    vectors: Vectors,
    /// Displacements in A.
    displacement: Vec<Vec3>,
    /// Motion of the nodes in the modes by the errors of the amplitudes: of the equations, and by the loads on what the modes miss.
    error: Vec<Vec6>,
    lagging: Vec<Vec6>,
}

impl Points {
    fn new(full: &Model) -> Self {
        let n = full.n_points();
        let entry = |row: usize, mode: usize| {
            let phi = full.points.get(row / 6).and_then(|point| point.phi.get(mode));
            phi.and_then(|phi| phi.get(row % 6)).copied().unwrap_or(0.0)
        };
        Points {
            phi: Dense::new(6 * n, full.n_modes(), entry),
            vectors: Vectors::of_machine(),
            displacement: vec![[0.0; 3]; n],
            error: vec![[0.0; 6]; n],
            lagging: vec![[0.0; 6]; n],
        }
    }

    /// Displacements for amplitudes; on a curved manifold with what points move beyond the modes.
    fn look(&mut self, full: &Model, q: &[f64], manifold: Option<&Manifold>) {
        move_nodes(self.vectors, &self.phi, q, &mut self.error);
        for (index, (to, (point, moved))) in
            self.displacement.iter_mut().zip(full.points.iter().zip(&self.error)).enumerate()
        {
            *to = point.displaced(&manifold.map_or(*moved, |it| add_6(moved, &it.beyond(index))));
        }
    }

    fn take_errors(&mut self, e: &[f64], lagging: &[f64]) {
        move_nodes(self.vectors, &self.phi, e, &mut self.error);
        move_nodes(self.vectors, &self.phi, lagging, &mut self.lagging);
    }
}

/// Motion of all nodes for amplitudes.
fn move_nodes(vectors: Vectors, phi: &Dense, q: &[f64], nodes: &mut [Vec6]) {
    vectors.run(
        (phi, q, nodes.as_flattened_mut()),
        #[inline(always)]
        |(phi, q, nodes)| phi.apply(q, nodes),
    );
}

/// The estimate of one simulation; all memory is taken when it is made.
#[derive(Clone, Debug)]
pub(crate) struct Estimator {
    every: u32,
    countdown: u32,
    /// The reduced model with all couplings, of which the marched one may be a simplification.
    full: Arc<Model>,
    defect: Defect,
    /// Of a model on a curved manifold; none where the marched one is not.
    manifold: Option<Manifold>,
    /// Acceleration of free fall at the equilibrium, in A: its work on what was dropped is in the stiffness.
    rest_gravity: Vec3,
    points: Points,
    errors: Errors,
    /// By the loads on what the modes miss.
    missed_errors: Errors,
    body: Body,
    work: Workspace,
    r: Vec<f64>,
    u: Vec<f64>,
    q: [Vec<f64>; 3],
    acting: Instant,
    velocity: Largest,
    spin: Largest,
    displaced: Vec<Displaced>,
    missing: Missing,
    /// Of what the modes miss in the velocities of A.
    missed_velocity: Largest,
    missed_spin: Largest,
    /// Of a model on a curved manifold, and the part of the defect that it leaves out.
    order: Option<Order>,
    lacks: f64,
    /// Amplitudes at a tenth of what is left out, and the lowest such rate about each axis, inverted - (m), (3).
    amplitude_limits: Vec<f64>,
    rate_limits: Vec3,
    estimate: ErrorEstimate,
}

/// Part of what is kept that the terms left out reach at the limits of the range.
const LIMIT: f64 = 0.1;
/// Instants per period of the slowest mode that the defect is sampled at, at least.
const SAMPLES: f64 = 10.0;

impl Estimator {
    /// Sampled every so many steps of `dt`, or as often as the slowest mode asks if that is more often.
    pub(crate) fn new(model: &Arc<Model>, dt: f64, every: u32) -> Self {
        let full = model.full.clone().unwrap_or_else(|| model.clone());
        let m = full.n_modes();
        let modes = &full.data().modes;
        let slowest = modes.omega.first().copied().unwrap_or(f64::INFINITY);
        let longest = core::f64::consts::TAU / slowest / SAMPLES / dt;
        let every = if longest < f64::from(every) { (longest as u32).max(1) } else { every.max(1) };
        let interval = dt * f64::from(every);
        let (inertia, inertia_inverse) =
            central_inertia(&full.rigid_mass, full.data().rigid.mass, full.centre_of_mass);
        let missing = Missing::new(&full, interval, model.method() != Method::Rom);
        Estimator {
            every,
            countdown: 0,
            defect: Defect::new(&full),
            manifold: Manifold::of(&full).filter(|_| model.consistent().1),
            rest_gravity: rest_gravity(&full),
            points: Points::new(&full),
            errors: Errors::new(&modes.omega, &modes.damping_ratio, interval),
            missed_errors: Errors::new(&modes.omega, &modes.damping_ratio, interval),
            body: Body { inertia, inertia_inverse, ..Body::default() },
            work: Workspace::new(&full),
            r: vec![0.0; m + 6],
            u: vec![0.0; m + 6],
            q: [vec![0.0; m], vec![0.0; m], vec![0.0; m]],
            acting: Instant::new(&full, missing.lines().len()),
            velocity: Largest::default(),
            spin: Largest::default(),
            displaced: vec![Displaced::default(); full.n_points()],
            missing,
            missed_velocity: Largest::default(),
            missed_spin: Largest::default(),
            order: Order::of(&full).filter(|_| model.consistent().1),
            lacks: 1.0,
            amplitude_limits: (0..m)
                .map(|mode| full.data().amplitude_limit(mode, LIMIT).map_or(0.0, |(limit, _)| 1.0 / limit))
                .collect(),
            rate_limits: core::array::from_fn(|axis| {
                let limits = (0..m).filter_map(|mode| full.data().rate_limit(axis, mode, LIMIT));
                limits.fold(0.0, |most: f64, limit| most.max(1.0 / limit))
            }),
            estimate: ErrorEstimate::default(),
            full,
        }
    }

    pub(crate) fn estimate(&self) -> ErrorEstimate {
        self.estimate
    }

    /// Begins again: no error so far.
    pub(crate) fn reset(&mut self) {
        self.errors.reset();
        self.missed_errors.reset();
        self.countdown = 0;
        (self.velocity, self.spin) = (Largest::default(), Largest::default());
        self.displaced.fill(Displaced::default());
        self.order.iter_mut().for_each(Order::reset);
        (self.missed_velocity, self.missed_spin) = (Largest::default(), Largest::default());
        self.missing.reset();
        self.estimate = ErrorEstimate::default();
    }

    /// Whether nothing has been sampled yet.
    pub(crate) fn is_new(&self) -> bool {
        self.countdown == 0
    }

    /// Counts a step; whether the state after it is one to sample.
    pub(crate) fn counts(&mut self) -> bool {
        self.countdown = self.countdown.saturating_sub(1);
        self.countdown == 0
    }

    /// Takes in a state whose accelerations are known.
    pub(crate) fn sample(&mut self, model: &Model, state: &State, gravity: Vec3, loads: &Acting) {
        self.copy_motion(model, state);
        let attitude = self.attitude(model, state);
        let [q, q_dot, q_ddot] = &self.q;
        if let Some(manifold) = &mut self.manifold {
            manifold.look(q, q_dot, q_ddot);
        }
        self.points.look(&self.full, q, self.manifold.as_ref());
        self.lacks = self.order.as_mut().map_or(1.0, |order| order.look(q));
        let Some((beta_star, beta_star_dot)) = self.rigid_motion(model, state) else { return };
        let phi_r = &self.full.phi_r;
        let beta = true_velocity(phi_r, q_dot, &beta_star);
        let beta_dot = true_velocity(phi_r, q_ddot, &beta_star_dot);
        let gravity_a = mul_t(&attitude, gravity);
        let (v, w) = split(&beta);
        let position = model.rigid_output(state).r_g;
        let variables = Variables { t: state.time, v_a: v, w_a: w, r_g: position };
        let (full, lines) = (&self.full, self.missing.lines());
        self.acting.gather(full, lines, loads, &variables, &attitude, q, &mut self.body);
        self.missing.look(&self.acting);
        self.estimate.unseen_loads |= !loads.estimated.all;
        self.r.fill(0.0);
        let at = Sample { q, q_dot, q_ddot, beta, beta_dot, gravity: gravity_a };
        if model.method() != Method::Rom {
            couplings(
                &self.full,
                &at,
                &beta_star,
                &beta_star_dot,
                &self.acting,
                self.missing.lines(),
                &mut self.work,
                &mut self.u,
                &mut self.r,
            );
        }
        let inertia = !model.consistent().0;
        self.defect.add(&at, self.acting.nodes(), self.acting.lines(), inertia, &mut self.r);
        let lacks = self.lacks;
        if lacks != 1.0 {
            self.r.iter_mut().for_each(|r| *r *= lacks);
        }
        if let Some(manifold) = &mut self.manifold {
            let gravity = sub(gravity_a, self.rest_gravity);
            manifold.add(&self.full, &Sample { gravity, ..at }, &mut self.r);
        }
        let Some((elastic, rigid)) = self.r.split_last_chunk::<6>() else { return };

        self.body.attitude = attitude;
        self.body.spin = split(&beta_star).1;
        let masses = &self.full.data().modes.mass;
        let over = |(r, mass): (&f64, &f64)| r / mass;
        let rows = elastic.iter().zip(masses).map(over);
        follow(&mut self.errors, &self.full, rows, rigid, &self.body, w);
        self.missing.defect(&self.full, &self.acting, &mut self.r);
        let Some((elastic, rigid)) = self.r.split_last_chunk::<6>() else { return };
        let rows = elastic.iter().zip(masses).map(over);
        follow(&mut self.missed_errors, &self.full, rows, rigid, &self.body, w);
        self.compare(model, state);
        self.use_of_range(w);
        self.countdown = self.every;
    }

    /// Amplitudes, rates and accelerations of the full model: none where the marched one has no modes.
    fn copy_motion(&mut self, model: &Model, state: &State) {
        let m = model.n_modes();
        let accelerations = state.u_dot.get(..m).unwrap_or_default();
        let [q, q_dot, q_ddot] = &mut self.q;
        for (to, from) in [(q, &state.q[..]), (q_dot, &state.q_dot[..]), (q_ddot, accelerations)] {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        }
    }

    /// `C^{GA}`: mean axes do not turn with A in the modes.
    fn attitude(&self, model: &Model, state: &State) -> Mat3 {
        let axes = matrix(state.attitude);
        let Some(relative) = &model.relative else { return axes };
        mat_mul(&axes, &rotation(split(&combine(&relative.phi_r, &self.q[0])).1))
    }

    /// `beta*` and its rate about the origin of A.
    fn rigid_motion(&self, model: &Model, state: &State) -> Option<(Vec6, Vec6)> {
        let rate = state.u_dot.last_chunk::<6>()?;
        let Some(relative) = &model.relative else { return Some((state.beta_star, *rate)) };
        // Mean axes: the state is about the centre of mass.
        let shifted = |beta: &Vec6| {
            let (v, w) = split(beta);
            join(add(v, cross(w, relative.origin)), w)
        };
        Some((shifted(&state.beta_star), shifted(rate)))
    }

    /// Errors of what is read from the model, and their largest so far.
    fn compare(&mut self, model: &Model, state: &State) {
        let (body, full, errors) = (&self.body, &self.full, &self.errors);
        let output = model.rigid_output(state);
        let own = combine(&full.phi_r, &self.q[1]);
        let (v_error, mut w_error) = velocity_errors(errors, full, body, &own);
        if model.relative.is_some() {
            // Mean axes tell the spin of the rigid body, without that of A in the modes.
            w_error = add(w_error, split(&own).1);
        }
        self.velocity.see(output.v_g, mul(&body.attitude, v_error));
        self.spin.see(output.w_g, mul(&body.attitude, w_error));
        let (v_missed, w_missed) = split(&self.missing.advance());
        let (v_error, w_error) = velocity_errors(&self.missed_errors, full, body, &own);
        self.missed_velocity.see(output.v_g, mul(&body.attitude, add(v_error, v_missed)));
        self.missed_spin.see(output.w_g, mul(&body.attitude, add(w_error, w_missed)));
        self.points.take_errors(&errors.e, &self.missed_errors.e);
        let moved = self.points.error.iter().zip(&self.points.lagging).zip(&self.points.displacement);
        let points = self.displaced.iter_mut().zip(&full.points).zip(moved);
        for (index, ((displaced, point), ((error, lagging), value))) in points.enumerate() {
            let in_a = |motion: &Vec6| point.led(split(motion));
            let mut error = axpy(in_a(error), self.lacks, in_a(&self.defect.curvature(index)));
            if let Some(manifold) = &self.manifold {
                error = add(error, in_a(&manifold.dropped(index)));
            }
            let missed = self.missing.at(index);
            let (_, theta) = split(&missed);
            let missed = add(in_a(&missed), in_a(lagging));
            // The levers of the missing rotations along the way are bent by no more than the point has moved.
            let squares = [dot(error, error), dot(missed, missed), dot(theta, theta) * dot(*value, *value)];
            displaced.see(add(add(*value, error), missed), squares.map(libm::sqrt));
        }
        let of_points = self.displaced.iter().map(|it| (it.parts.iter().sum(), it.value));
        self.estimate.dr_a = worst(of_points);
        self.estimate.v_g = self.velocity.ratio() + self.missed_velocity.ratio();
        self.estimate.w_g = self.spin.ratio() + self.missed_spin.ratio();
    }

    fn use_of_range(&mut self, w: Vec3) {
        let used = self.amplitude_limits.iter().zip(&self.q[0]).map(|(inverse, q)| inverse * q.abs());
        self.estimate.amplitude = used.fold(0.0, f64::max);
        let used = self.rate_limits.iter().zip(w).map(|(inverse, w)| inverse * w.abs());
        self.estimate.rate = used.fold(0.0, f64::max);
    }
}

/// Acceleration of free fall in a loaded equilibrium, in A.
fn rest_gravity(full: &Model) -> Vec3 {
    let data = full.data();
    let of_trim =
        |(trim, gravity): (&TrimData, &GravityData)| mul_t(&matrix(trim.attitude), gravity.acceleration);
    data.trim.as_ref().zip(data.gravity.as_ref()).map_or([0.0; 3], of_trim)
}

/// Goes on to the next instant with the defect there: over the generalised masses in the elastic rows, force and moment about the origin of
/// A in A. `w`: angular velocity of A.
fn follow(
    errors: &mut Errors,
    full: &Model,
    rows: impl Iterator<Item = f64>,
    wrench: &Vec6,
    body: &Body,
    w: Vec3,
) {
    let (force, moment) = split(wrench);
    let moment = sub(moment, cross(full.centre_of_mass, force));
    // theta_dot in A is the error of the angular velocity in G, seen from A.
    let own = add(errors.spin(body), split(&combine(&full.phi_r, &errors.e_dot)).1);
    let turn_rate = add(own, cross(errors.attitude, w));
    errors.advance(rows, mul(&body.attitude, force), mul(&body.attitude, moment), turn_rate, body);
}

/// Errors in A of the velocity and of the angular velocity of A in G, where the modes move A by `own`.
fn velocity_errors(errors: &Errors, full: &Model, body: &Body, own: &Vec6) -> (Vec3, Vec3) {
    let ((v_modes, w_modes), (v_own, w_own)) = (split(&combine(&full.phi_r, &errors.e_dot)), split(own));
    // Errors in G: of the vectors in A, turned, and of the axes.
    let turned = |x: Vec3| cross(errors.attitude, x);
    let spin = errors.spin(body);
    let w_error = add(add(spin, w_modes), turned(add(body.spin, w_own)));
    let c = full.centre_of_mass;
    let momentum = crate::math::scale(1.0 / full.data().rigid.mass, mul_t(&body.attitude, errors.momentum));
    // v* = p/m - w* x c, of which p is known in G.
    let v_star = sub(momentum, add(cross(add(spin, turned(body.spin)), c), cross(body.spin, turned(c))));
    (add(add(v_star, v_modes), turned(v_own)), w_error)
}

/// The worst ratio of error to displacement of the points that move at least a tenth as far as the farthest.
fn worst(points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let far = points.clone().fold(0.0, |far: f64, (_, value)| far.max(value));
    let moving = points.filter(|(_, value)| *value >= 0.1 * far);
    moving.fold(0.0, |worst: f64, (error, value)| worst.max(relative(error, value)))
}

/// An error over what it is an error of. Estimates of a motion far out of the range grow until their numbers end: all of the quantity is an
/// error then.
fn relative(error: f64, value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let ratio = error / value;
    if ratio.is_finite() { ratio } else { 1.0 }
}

/// The couplings that a simplified method leaves out: the equations of the full model on its motion,
/// `M0 u_dot + c u beta + k q beta beta + omega^2 q + 2 zeta omega q_dot + g - Q`.
#[allow(clippy::too_many_arguments)]
fn couplings(
    full: &Model,
    at: &Sample,
    beta_star: &Vec6,
    beta_star_dot: &Vec6,
    acting: &Instant,
    lines: &[Line],
    work: &mut Workspace,
    u: &mut [f64],
    r: &mut [f64],
) {
    u.fill(0.0);
    full.weight.add(at.gravity, at.q, u);
    r.iter_mut().zip(u.iter()).for_each(|(r, weight)| *r -= weight);
    u.iter_mut().zip(at.q_dot.iter().chain(beta_star)).for_each(|(u, value)| *u = *value);
    let Some((rows, rigid)) = r.split_last_chunk_mut::<6>() else { return };
    let external = acting.take_off(full, lines, at.q, rows);
    for (row, phi) in rows.iter_mut().zip(&full.phi_r) {
        *row -= crate::math::dot_6(phi, &external);
    }
    let momentum = crate::math::mul6_symmetric(&full.rigid_mass, beta_star_dot);
    for ((to, m), q) in rigid.iter_mut().zip(momentum).zip(external) {
        *to += m - q;
    }
    let motion = at.q.iter().zip(at.q_dot).zip(at.q_ddot);
    for ((row, mode), ((q, q_dot), q_ddot)) in rows.iter_mut().zip(&full.elastic).zip(motion) {
        *row += mode.mass * q_ddot + mode.damping * q_dot + mode.stiffness * q;
    }
    if let Some(trim) = &full.data().trim {
        rows.iter_mut().zip(&trim.elastic_force).for_each(|(row, force)| *row += force);
    }
    for (to, gyroscopic) in rows.iter_mut().chain(rigid).zip(work.contract(full, u, at.q, &at.beta)) {
        *to += gyroscopic;
    }
}
