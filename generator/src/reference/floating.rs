//! The methods that keep frame A and the displacements from the equilibrium apart: linear, and nonlinear with constant mass.
//!
//! Both solve `M(eta0) (xddot, betadot) + g(x, xdot, beta) = Qext(eta0 + x)` (theory (21) and section 5) and differ in `g`
//! only, see [`Forces`]. The displacements `x` are nodal `(R, theta)` from the equilibrium. Frame A is marched like a node of
//! the nonlinear method, in inertial components: its position, and its attitude by rotation increments.

use nalgebra::{DVector, Matrix3, UnitQuaternion, Vector3, Vector6};
use rom_runtime::Reaction;
use rom_runtime::expression::Variables;
use rom_runtime::loads::LoadCase;

use super::anderson::Anderson;
use super::applied::Displaced;
use super::base::{Base, Moved};
use super::bordered::Bordered;
use super::external::ExternalLoads;
use super::method::{Output, Prepared, Run, told};
use super::motion::FrameMotion;
use super::nonlinear::Totals;
use super::scheme::Scheme;
use super::start::Start;
use crate::assembly::BlockMatrix;
use crate::carrier::NodeMotion;
use crate::element::internal_force::{split, stack};
use crate::math::so3::{MatrixFunction, exp_quaternion};

/// Correction of a converged iteration relative to the size of the structure.
const TOLERANCE: f64 = 1e-10;
/// Most iterations of a step before it is halved.
const MAX_ITERATIONS: usize = 40;
/// Most halvings of a step.
const MAX_HALVINGS: u32 = 6;

/// Forces on the structure (per block row, `(R, theta)`) and on A (six rigid rows).
#[derive(Clone, Debug)]
pub struct Rows {
    /// Structural rows - (n).
    pub s: Vec<Vector6<f64>>,
    /// Rigid rows.
    pub r: Vector6<f64>,
}

impl Rows {
    pub(crate) fn zeros(n: usize) -> Self {
        Self { s: vec![Vector6::zeros(); n], r: Vector6::zeros() }
    }
}

/// Elastic and gyroscopic forces of a method: what is left of the equations at zero acceleration and without loads.
pub trait Forces {
    /// Adds `g(x, xdot, beta)`; `x` and `xdot` per block row.
    fn add(&self, x: &[Vector6<f64>], x_dot: &[Vector6<f64>], beta: &Vector6<f64>, out: &mut Rows);

    /// Stiffness, and damping of the strains times a factor on the rates, for the iteration about `x`.
    fn tangent(&self, x: &[Vector6<f64>], rate_factor: f64) -> BlockMatrix;

    /// Whether that is the same about any `x`.
    fn has_constant_tangent(&self) -> bool;

    /// Elastic energy, J.
    fn elastic_energy(&self, x: &[Vector6<f64>]) -> f64;

    /// Section forces `(F, M)` at the places of the structure file - (places).
    fn sections(&self, x: &[Vector6<f64>], x_dot: &[Vector6<f64>]) -> Vec<Vector6<f64>>;
}

/// State: displacements and frame A, with rates and the integrator's accelerations.
#[derive(Clone, Debug)]
struct State {
    time: f64,
    x: Vec<Kinematics>,
    frame: Kinematics,
    attitude: UnitQuaternion<f64>,
}

impl State {
    fn new(start: &Start) -> Self {
        let at = |value: [Vector3<f64>; 2], rate: [Vector3<f64>; 2]| Kinematics {
            value,
            rate,
            ..Kinematics::REST
        };
        let pair = |v: &Vector6<f64>| <[_; 2]>::from(split(v));
        let frame = &start.frame;
        Self {
            time: 0.0,
            x: start.x.iter().zip(&start.x_dot).map(|(x, rate)| at(pair(x), pair(rate))).collect(),
            frame: at([frame.position, Vector3::zeros()], [frame.velocity, frame.spin]),
            attitude: frame.rotation,
        }
    }
}

impl State {
    fn frame_motion(&self) -> FrameMotion {
        FrameMotion {
            position: self.frame.value[0],
            rotation: self.attitude,
            velocity: self.frame.rate[0],
            spin: self.frame.rate[1],
        }
    }

    /// Takes over the motion of a base.
    fn set_frame(&mut self, moved: &Moved) {
        let FrameMotion { position, rotation, velocity, spin } = moved.frame;
        self.frame.value[0] = position;
        self.frame.rate = [velocity, spin];
        self.frame.acceleration = [moved.acceleration, moved.spin_rate];
        self.frame.auxiliary = self.frame.acceleration;
        self.attitude = rotation;
    }
}

/// Displacement (two vectors), its rates and the auxiliary acceleration. For A: position and rotation in inertial and
/// body components.
#[derive(Clone, Copy, Debug)]
struct Kinematics {
    value: [Vector3<f64>; 2],
    rate: [Vector3<f64>; 2],
    acceleration: [Vector3<f64>; 2],
    auxiliary: [Vector3<f64>; 2],
}

impl Kinematics {
    const REST: Self = {
        let zero = [Vector3::new(0.0, 0.0, 0.0); 2];
        Self { value: zero, rate: zero, acceleration: zero, auxiliary: zero }
    };

    /// After an increment.
    fn advanced(&self, scheme: &Scheme, increment: &[Vector3<f64>; 2]) -> Self {
        let mut out = *self;
        for k in 0..2 {
            out.value[k] = self.value[k] + increment[k];
            (out.rate[k], out.auxiliary[k], out.acceleration[k]) =
                scheme.rates(&increment[k], &self.rate[k], &self.auxiliary[k], &self.acceleration[k]);
        }
        out
    }

    fn predicted(&self, scheme: &Scheme) -> [Vector3<f64>; 2] {
        [0, 1].map(|k| scheme.predict(&self.rate[k], &self.auxiliary[k]))
    }
}

/// A run in the floating frame.
pub struct Floating<'a, F> {
    prepared: &'a Prepared,
    forces: F,
    loads: ExternalLoads,
    /// What moves A, and what the body does to it; none in free flight.
    base: Option<Base>,
    reaction: Option<Reaction>,
    scheme: Scheme,
    size: f64,
    state: State,
    trial: State,
    increment: Vec<[Vector3<f64>; 2]>,
    frame_increment: [Vector3<f64>; 2],
    solver: Bordered,
    anderson: Anderson,
}

impl<'a, F: Forces> Floating<'a, F> {
    /// From a given start, with accelerations in balance at t = 0. The loads are those of `case` alone.
    ///
    /// # Errors
    /// A singular mass or stiffness matrix, in words.
    pub fn new(
        prepared: &'a Prepared,
        start: &Start,
        case: &LoadCase,
        scheme: Scheme,
        forces: F,
    ) -> Result<Self, String> {
        let n = prepared.assembly.n_blocks();
        let state = State::new(start);
        let mut run = Self {
            prepared,
            forces,
            loads: ExternalLoads::new(&prepared.mesh, case),
            base: prepared.base(case),
            reaction: None,
            scheme,
            size: prepared.mesh.nodes.iter().map(|r| r.norm()).fold(0.0, f64::max),
            trial: state.clone(),
            state,
            increment: vec![[Vector3::zeros(); 2]; n],
            frame_increment: [Vector3::zeros(); 2],
            solver: Bordered::new(prepared),
            anderson: Anderson::default(),
        };
        run.start_accelerations()?;
        run.factorise(&scheme)?;
        Ok(run)
    }

    fn start_accelerations(&mut self) -> Result<(), String> {
        let zero = BlockMatrix::zeros(self.prepared.stiffness.pattern.clone());
        self.solver.factorise(self.prepared, &zero, 1.0)?;
        if let Some(base) = &self.base {
            let moved = base.at(&self.state.frame_motion(), self.state.time);
            self.state.set_frame(&moved);
            self.trial.set_frame(&moved);
        }
        let mut rows = self.residual();
        self.solve(&mut rows);
        for (x, a) in self.state.x.iter_mut().zip(&rows.s) {
            let (a, b) = split(&-a);
            x.acceleration = [a, b];
            x.auxiliary = [a, b];
        }
        if self.base.is_none() {
            let (a, b) = split(&-rows.r);
            self.state.frame.acceleration = [self.state.attitude * a, b];
            self.state.frame.auxiliary = self.state.frame.acceleration;
        }
        self.trial = self.state.clone();
        self.reaction = self.reaction();
        Ok(())
    }

    /// Solves for the corrections; those of A are zero where it is moved.
    fn solve(&self, rows: &mut Rows) {
        match self.base {
            None => self.solver.solve(rows),
            Some(_) => self.solver.solve_held(rows),
        }
    }

    /// What the body does to the base in the trial: the opposite of what the rigid rows are out of balance by.
    fn reaction(&self) -> Option<Reaction> {
        let base = self.base.as_ref()?;
        let (x, _) = Self::displacements(&self.trial);
        let mut loads = Rows::zeros(x.len());
        self.subtract_loads(&x, &Self::beta(&self.trial), &mut loads);
        let [acceleration, spin_rate] = self.trial.frame.acceleration;
        let moved = Moved { frame: self.trial.frame_motion(), acceleration, spin_rate };
        Some(base.reaction(&-self.residual().r, &-loads.r, &moved))
    }

    /// Velocity of A in its own axes.
    fn beta(state: &State) -> Vector6<f64> {
        let to_a = state.attitude.inverse();
        stack(&(to_a * state.frame.rate[0]), &state.frame.rate[1])
    }

    fn displacements(state: &State) -> (Vec<Vector6<f64>>, Vec<Vector6<f64>>) {
        let join = |v: &[Vector3<f64>; 2]| stack(&v[0], &v[1]);
        (state.x.iter().map(|x| join(&x.value)).collect(), state.x.iter().map(|x| join(&x.rate)).collect())
    }

    /// `M (xddot, betadot) + g - Qext` of the trial.
    fn residual(&self) -> Rows {
        let state = &self.trial;
        let beta = Self::beta(state);
        let (x, x_dot) = Self::displacements(state);
        let mut rows = Rows::zeros(x.len());
        self.forces.add(&x, &x_dot, &beta, &mut rows);
        let (v, w) = split(&beta);
        let v_dot = state.attitude.inverse() * state.frame.acceleration[0] - w.cross(&v);
        let beta_dot = stack(&v_dot, &state.frame.acceleration[1]);
        let x_ddot: Vec<Vector6<f64>> =
            state.x.iter().map(|x| stack(&x.acceleration[0], &x.acceleration[1])).collect();
        self.add_inertia(&x_ddot, &beta_dot, &mut rows);
        self.subtract_loads(&x, &beta, &mut rows);
        rows
    }

    fn add_inertia(&self, x_ddot: &[Vector6<f64>], beta_dot: &Vector6<f64>, rows: &mut Rows) {
        let mass = &self.prepared.mass;
        let mut product = vec![Vector6::zeros(); x_ddot.len()];
        mass.ss.multiply(x_ddot, &mut product);
        for (i, row) in rows.s.iter_mut().enumerate() {
            *row += product[i] + mass.sr[i] * beta_dot;
            rows.r += mass.sr[i].tr_mul(&x_ddot[i]);
        }
        rows.r += mass.rr * beta_dot;
    }

    /// Loads at the deformed point, with the current lever arm.
    fn subtract_loads(&self, x: &[Vector6<f64>], beta: &Vector6<f64>, rows: &mut Rows) {
        let state = &self.trial;
        let (v, w) = split(beta);
        let variables =
            Variables { t: state.time, v_a: v.into(), w_a: w.into(), r_g: state.frame.value[0].into() };
        let frame = state.attitude.to_rotation_matrix().into_inner();
        Displaced { prepared: self.prepared, x, frame }.subtract(&self.loads, variables, rows);
    }

    fn update_trial(&mut self, scheme: &Scheme) {
        for (i, u) in self.increment.iter().enumerate() {
            self.trial.x[i] = self.state.x[i].advanced(scheme, u);
        }
        if self.base.is_some() {
            return;
        }
        self.trial.frame = self.state.frame.advanced(scheme, &self.frame_increment);
        self.trial.attitude = self.state.attitude * exp_quaternion(&self.frame_increment[1]);
        self.trial.attitude.renormalize_fast();
    }

    /// Advances by `dt`, in two halves where the iteration does not converge.
    fn advance(&mut self, dt: f64, halvings: u32) -> Result<(), String> {
        if self.try_step(dt)? {
            return Ok(());
        }
        if halvings == MAX_HALVINGS {
            return Err(format!(
                "no convergence at t = {:.6} s even with steps of {dt:.1e} s: the motion grows without bound, or a load jumps",
                self.trial.time
            ));
        }
        self.advance(0.5 * dt, halvings + 1)?;
        self.advance(0.5 * dt, halvings + 1)
    }

    /// One step; whether it converged.
    fn try_step(&mut self, dt: f64) -> Result<bool, String> {
        let scheme = self.scheme.with_dt(dt);
        self.trial.time = self.state.time + dt;
        for (u, x) in self.increment.iter_mut().zip(&self.state.x) {
            *u = x.predicted(&scheme);
        }
        self.frame_increment = self.state.frame.predicted(&scheme);
        if let Some(base) = &self.base {
            let moved = base.advance(&self.state.frame_motion(), self.state.time, self.trial.time);
            self.trial.set_frame(&moved);
        }
        self.update_trial(&scheme);
        if !self.forces.has_constant_tangent() || self.solver.factor_of != scheme.factors().acceleration {
            self.factorise(&scheme)?;
        }
        self.anderson.clear();
        for _ in 0..MAX_ITERATIONS {
            let mut rows = self.residual();
            self.solve(&mut rows);
            let correction = self.correct(&rows);
            if !correction.is_finite() {
                return Ok(false);
            }
            self.update_trial(&scheme);
            if correction < TOLERANCE {
                self.reaction = self.reaction();
                std::mem::swap(&mut self.state, &mut self.trial);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Makes the solver ready for a step from the trial.
    fn factorise(&mut self, scheme: &Scheme) -> Result<(), String> {
        let factors = scheme.factors();
        let tangent = self.forces.tangent(&Self::displacements(&self.trial).0, factors.velocity);
        self.solver.factorise(self.prepared, &tangent, factors.acceleration)
    }

    /// Corrects the increments by a solution, accelerated by the corrections before it; the size of the plain correction
    /// relative to the structure.
    fn correct(&mut self, rows: &Rows) -> f64 {
        let frame_position = self.trial.attitude * split(&rows.r).0;
        let frame = [frame_position, split(&rows.r).1];
        let corrections = rows.s.iter().map(|delta| <[_; 2]>::from(split(delta))).chain([frame]);
        let increments = self.increment.iter().chain([&self.frame_increment]);
        let n = 6 * (self.increment.len() + 1);
        let size = self.size;
        let flat = |v: [Vector3<f64>; 2]| [v[0] / size, v[1]].into_iter().flat_map(|v| [v.x, v.y, v.z]);
        let f = -DVector::from_iterator(n, corrections.flat_map(flat));
        let x = DVector::from_iterator(n, increments.copied().flat_map(flat));
        // `amax` passes over a NaN.
        let largest = if f.iter().all(|x| x.is_finite()) { f.amax() } else { f64::NAN };
        let step = self.anderson.step(x, f);
        let frame = [&mut self.frame_increment];
        for (u, part) in self.increment.iter_mut().chain(frame).zip(step.as_slice().chunks_exact(6)) {
            u[0] += Vector3::from_column_slice(&part[..3]) * size;
            u[1] += Vector3::from_column_slice(&part[3..]);
        }
        largest
    }

    /// How a node moves in G: rigid motion of A, motion of the node in A, and what couples them.
    fn node_motion(&self, node: usize, frame: &FrameMotion) -> NodeMotion {
        let x = self.prepared.assembly.unknown[node].map_or(Kinematics::REST, |i| self.state.x[i]);
        let ([u, theta], [r_dot, theta_dot], [r_ddot, theta_ddot]) = (x.value, x.rate, x.acceleration);
        let rotation = self.prepared.at.rotations[node] * exp_quaternion(&theta);
        let tangential = MatrixFunction::tangential(&theta);
        // Spin of the node relative to A and its rate, node frame.
        let relative = tangential.matrix() * theta_dot;
        let relative_rate = tangential.matrix() * theta_ddot + tangential.rate(&theta_dot) * theta_dot;
        let r = self.prepared.at.positions[node] + u;
        let (w, [a, w_dot]) = (&frame.spin, self.state.frame.acceleration);
        let carried = w_dot.cross(&r) + w.cross(&w.cross(&r)) + 2.0 * w.cross(&r_dot);
        let (to_g, to_node) = (frame.rotation, rotation.inverse());
        let spin_of_a = to_node * w;
        NodeMotion {
            position: frame.position + to_g * r,
            rotation: to_g * rotation,
            velocity: frame.velocity + to_g * (w.cross(&r) + r_dot),
            spin: spin_of_a + relative,
            acceleration: a + to_g * (carried + r_ddot),
            // The spin of A has constant components in A, not in the node.
            spin_rate: to_node * w_dot - relative.cross(&spin_of_a) + relative_rate,
        }
    }

    fn totals(&self) -> Totals {
        let (mass, rr) = self.prepared.rigid_mass();
        let state = &self.state;
        let (x, x_dot) = Self::displacements(state);
        let beta = Self::beta(state);
        let mut rows = Rows::zeros(x.len());
        self.add_inertia(&x_dot, &beta, &mut rows);
        let kinetic: f64 = rows.s.iter().zip(&x_dot).map(|(p, v)| p.dot(v)).sum::<f64>() + rows.r.dot(&beta);
        let (p, h) = split(&rows.r);
        let linear_momentum = state.attitude * p;
        let position = state.frame.value[0];
        let moved: Vector6<f64> = self.prepared.mass.sr.iter().zip(&x).map(|(sr, x)| sr.tr_mul(x)).sum();
        let rest = crate::assembly::Assembly::centre_of_mass(&rr).1;
        let centre_of_mass = position + state.attitude * (rest + split(&moved).0 / mass);
        Totals {
            mass,
            centre_of_mass,
            linear_momentum,
            angular_momentum: position.cross(&linear_momentum) + state.attitude * h,
            kinetic_energy: 0.5 * kinetic,
            elastic_energy: self.forces.elastic_energy(&x),
            gravity_energy: -mass * self.prepared.mesh.gravity.dot(&centre_of_mass),
        }
    }
}

impl<F: Forces> Run for Floating<'_, F> {
    fn step(&mut self) -> Result<(), String> {
        self.advance(self.scheme.dt, 0)
    }

    fn output(&self) -> Output {
        let state = &self.state;
        let (x, x_dot) = Self::displacements(state);
        let frame = state.frame_motion();
        let at = &self.prepared.at;
        let mut out = Output {
            time: state.time,
            frame,
            dr_a: Vec::new(),
            r_g: Vec::new(),
            motion: Vec::new(),
            q: Vec::new(),
            q_dot: Vec::new(),
            totals: self.totals(),
            errors: None,
            reaction: self.reaction,
            sections: self.forces.sections(&x, &x_dot).into_iter().map(told).collect(),
        };
        let displaced = Displaced { prepared: self.prepared, x: &x, frame: Matrix3::identity() };
        let rotation = |node: usize| {
            let theta = self.prepared.assembly.unknown[node].map_or(Vector3::zeros(), |i| split(&x[i]).1);
            at.rotations[node] * exp_quaternion(&theta)
        };
        for (p, carrier) in self.prepared.mesh.points.iter().zip(&self.prepared.carriers) {
            let (r, q) = carrier.pose(|node| displaced.node_position(node), rotation);
            let (r0, q0) = carrier.at(at);
            let now = r + q * p.offset;
            out.dr_a.push(now - (r0 + q0 * p.offset));
            out.r_g.push(frame.position + frame.rotation * now);
            out.motion.push(carrier.motion(|node| self.node_motion(node, &frame)).of_point(&p.offset));
        }
        out
    }

    fn node_displacements(&self, nodes: &[usize]) -> Vec<Vector3<f64>> {
        let (x, _) = Self::displacements(&self.state);
        let displaced = Displaced { prepared: self.prepared, x: &x, frame: Matrix3::identity() };
        nodes.iter().map(|&node| displaced.node_position(node) - self.prepared.at.positions[node]).collect()
    }

    fn node_velocities(&self, nodes: &[usize]) -> Vec<Vector3<f64>> {
        let frame = self.state.frame_motion();
        nodes.iter().map(|&node| self.node_motion(node, &frame).velocity).collect()
    }
}
