//! The equations of motion (theory section 4), the same for every integrator:
//!
//! ```text
//! M u_dot + D + c_ilr u_l beta_r + k_ilrs q_l beta_r beta_s + omega_i^2 m_i q_i + g_i = Q_i      u = (q_dot, beta*)
//! zeta_dot = 1/2 zeta (0, w),   r_G_dot = C^{GA} v,                                     beta = (v, w) = Phi_R q_dot + beta*
//! ```
//!
//! Consistent inertia has equations of its own ([`crate::lagrangian`]) behind the same calls.
//!
//! `g = Phi_S^t Qstif_S(eta0)` is the elastic force of a loaded equilibrium, zero about the unloaded structure.

use alloc::{vec, vec::Vec};

use crate::base_motion::BaseMotion;
use crate::dense::rows;
use crate::error::StepError;
use crate::expression::Variables;
use crate::four::{Vectors, minus, times};
use crate::lagrangian::{Lagrangian, Scratch};
use crate::loading::{Acting, LoadWorkspace, Loads, generalised_loads};
use crate::math::{
    Mat3, Vec3, Vec6, constant_vector, dot_6, join, matrix, mul, mul_t, mul6_symmetric, quaternion_product,
    split, sub_6,
};
use crate::model::Model;
use crate::real::Real;
use crate::state::{State, true_velocity};
use crate::tensor::Windows;

/// Scratch memory of the evaluation of the equations of motion; made once per model and host thread.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// `u_l beta_r` and `q_l beta_r beta_s`.
    products: Windows<f64>,
    /// `c_ilr u_l beta_r + k_ilrs q_l beta_r beta_s`, and damping that couples modes - (m + 6).
    pub(crate) gyroscopic: Vec<f64>,
    /// Generalised loads - (m + 6).
    pub(crate) external: Vec<f64>,
    pub(crate) loads: LoadWorkspace,
    /// Acceleration of free fall in G, m/s^2; the model's unless a host sets another.
    pub(crate) gravity: Vec3,
    /// `(q_dot, beta*)` - (m + 6).
    u: Vec<f64>,
    /// What consistent inertia needs; empty without.
    pub(crate) lagrangian: Scratch,
    /// Forces on the relative elastic rows of a consistent model - (m).
    pub(crate) relative: Vec<f64>,
    /// Damping forces off the diagonal - (m).
    damped: Vec<f64>,
    pub(crate) vectors: Vectors,
}

impl Workspace {
    /// For a model.
    pub fn new(model: &Model) -> Self {
        let n = model.n_modes() + 6;
        Workspace {
            products: model.contraction.products(),
            gyroscopic: vec![0.0; n],
            external: vec![0.0; n],
            loads: LoadWorkspace::new(model),
            gravity: model.gravity(),
            u: vec![0.0; n],
            lagrangian: Scratch::new(model),
            relative: vec![0.0; if model.lagrangian.is_some() { model.n_modes() } else { 0 }],
            damped: vec![0.0; model.n_modes()],
            vectors: Vectors::of_machine(),
        }
    }

    /// `c u beta + k q beta beta` - (m + 6).
    pub(crate) fn contract(&mut self, model: &Model, u: &[f64], q: &[f64], beta: &Vec6) -> &[f64] {
        self.vectors.run(
            (&model.contraction, u, q, beta, &mut self.products, &mut self.gyroscopic),
            #[inline(always)]
            |(contraction, u, q, beta, products, gyroscopic)| {
                contraction.apply(u, q, beta, products, gyroscopic);
            },
        );
        &self.gyroscopic
    }

    /// Sets the acceleration of free fall in G, m/s^2, for the evaluations to come. It begins as that of the model.
    pub fn set_gravity(&mut self, acceleration: [f64; 3]) {
        self.gravity = acceleration;
    }
}

/// Time derivative of a [`State`].
#[derive(Clone, Debug, PartialEq)]
pub struct StateRate {
    /// Modal rates, 1/s - (m).
    pub q_dot: Vec<f64>,
    /// `(q_ddot, beta*_dot)` - (m + 6).
    pub u_dot: Vec<f64>,
    /// Rate of the attitude quaternion, 1/s - (4).
    pub attitude_dot: [f64; 4],
    /// Velocity of the origin of A in G, m/s - (3).
    pub position_dot: [f64; 3],
}

impl StateRate {
    /// Zero, of the right lengths.
    pub fn new(model: &Model) -> Self {
        let m = model.n_modes();
        StateRate {
            q_dot: vec![0.0; m],
            u_dot: vec![0.0; m + 6],
            attitude_dot: [0.0; 4],
            position_dot: [0.0; 3],
        }
    }
}

impl Model {
    /// Evaluates the equations of motion: the time derivative of `state` under `loads`. For hosts that integrate
    /// themselves. Where the load case moves A, or the structure is clamped, A accelerates as it is told. Does not allocate. The
    /// attitude need not be of unit length: its direction counts.
    ///
    /// # Errors
    /// [`StepError::ForeignLoads`] when the loads were prepared for another model.
    pub fn derivatives<L: Loads + ?Sized>(
        &self,
        state: &State,
        loads: &L,
        work: &mut Workspace,
        rate: &mut StateRate,
    ) -> Result<(), StepError> {
        let beta = self.evaluate(state, loads.acting(), work, &mut rate.u_dot)?;
        let (v, w) = split(&beta);
        rate.attitude_dot = attitude_rate(state.attitude, w);
        rate.position_dot = mul(&matrix(state.attitude), v);
        for (rate, q_dot) in rate.q_dot.iter_mut().zip(&state.q_dot) {
            *rate = *q_dot;
        }
        Ok(())
    }

    /// `u_dot` of a state from the equations of motion; returns `beta`.
    fn evaluate(
        &self,
        state: &State,
        loads: &Acting,
        work: &mut Workspace,
        u_dot: &mut [f64],
    ) -> Result<Vec6, StepError> {
        check_loads(self, loads)?;
        let beta = true_velocity(&self.phi_r, &state.q_dot, &state.beta_star);
        let attitude = matrix(state.attitude);
        let held = match self.base_of(loads) {
            None => None,
            Some(base) => Some((self.held()?, base.at(&self.motion_of(state), state.time).rate)),
        };
        self.with_u(&state.q_dot, &state.beta_star, work, |u, work| {
            let here = Motion { t: state.time, q: &state.q, u, attitude, position: state.position, beta };
            work.vectors.run(
                (self, loads, &here, held.as_ref(), work, u_dot),
                #[inline(always)]
                |(model, loads, here, held, work, u_dot)| {
                    forces(model, loads, here, work);
                    match held {
                        None => accelerations(model, here, work, u_dot),
                        Some((held, rate)) => model.held_accelerations(held, here, rate, work, u_dot),
                    }
                },
            );
        });
        Ok(beta)
    }

    /// What moves frame A under these loads: the load case, or the clamp that holds it; none in free flight.
    pub(crate) fn base_of<'a>(&self, loads: &'a Acting) -> Option<&'a BaseMotion> {
        static HELD: BaseMotion = BaseMotion::HELD;
        loads.base().or(self.is_clamped().then_some(&HELD))
    }

    /// Calls with `u = (q_dot, beta*)` in one piece.
    pub(crate) fn with_u(
        &self,
        q_dot: &[f64],
        beta_star: &Vec6,
        work: &mut Workspace,
        call: impl FnOnce(&[f64], &mut Workspace),
    ) {
        // Moved out for the borrow checker; an empty vector does not allocate.
        let mut u = core::mem::take(&mut work.u);
        for (u, value) in u.iter_mut().zip(q_dot.iter().chain(beta_star)) {
            *u = *value;
        }
        call(&u, work);
        put_back(&mut work.u, u);
    }

    /// Fills `state.u_dot`.
    pub(crate) fn solve_accelerations(
        &self,
        state: &mut State,
        loads: &Acting,
        work: &mut Workspace,
    ) -> Result<(), StepError> {
        let mut u_dot = core::mem::take(&mut state.u_dot);
        let result = self.evaluate(state, loads, work, &mut u_dot);
        put_back(&mut state.u_dot, u_dot);
        result.map(|_| ())
    }

    /// True velocity of A in A, `(v_A, w_A)`: m/s, rad/s - (6).
    pub fn velocity(&self, state: &State) -> [f64; 6] {
        true_velocity(&self.phi_r, &state.q_dot, &state.beta_star)
    }
}

/// Moves a vector back to where it was taken from. What is there meanwhile is empty; forgetting it keeps the freeing of memory out of
/// the step.
fn put_back(place: &mut Vec<f64>, taken: Vec<f64>) {
    core::mem::forget(core::mem::replace(place, taken));
}

/// What the forces depend on.
#[derive(Clone, Copy)]
pub(crate) struct Motion<'a> {
    pub(crate) t: f64,
    pub(crate) q: &'a [f64],
    pub(crate) u: &'a [f64],
    /// `C^{GA}`.
    pub(crate) attitude: Mat3,
    pub(crate) position: [f64; 3],
    /// True velocity of A in A.
    pub(crate) beta: Vec6,
}

pub(crate) fn check_loads(model: &Model, loads: &Acting) -> Result<(), StepError> {
    let (map, modes) = (loads.map(), model.n_modes());
    if map.n_modes == modes && map.n_points == model.n_points() {
        Ok(())
    } else {
        Err(StepError::ForeignLoads { found_modes: map.n_modes, modes })
    }
}

/// Gyroscopic and mode-coupling damping forces, and generalised loads and weight less the elastic force of the equilibrium, into
/// `work.gyroscopic` and `work.external`.
#[inline(always)]
pub(crate) fn forces(model: &Model, loads: &Acting, at: &Motion, work: &mut Workspace) {
    if let Some(lagrangian) = &model.lagrangian {
        lagrangian.evaluate(at.q, modal(at.u), &at.beta, &mut work.lagrangian);
        relative_forces(model, lagrangian, loads, at, work);
        return;
    }
    model.contraction.apply(at.u, at.q, &at.beta, &mut work.products, &mut work.gyroscopic);
    if let Some(damping) = &model.damping {
        damping.apply(at.u, &mut work.damped);
        for (force, damped) in work.gyroscopic.iter_mut().zip(&work.damped) {
            *force += damped;
        }
    }
    let (v_a, w_a) = split(&at.beta);
    let variables = Variables { t: at.t, v_a, w_a, r_g: at.position };
    generalised_loads(loads, &variables, at.q, &at.attitude, &mut work.loads, &mut work.external);
    if work.gravity != [0.0; 3] {
        model.weight.add(mul_t(&at.attitude, work.gravity), at.q, &mut work.external);
    }
    if let Some(trim) = &model.data().trim {
        for (external, elastic) in work.external.iter_mut().zip(&trim.elastic_force) {
            *external -= elastic;
        }
    }
}

/// Forces of a consistent model whose inertia is evaluated already: generalised loads, weight and resultant into `work.external`,
/// everything but the rates of the unknowns and the damping on the relative elastic rows into `work.relative`.
pub(crate) fn relative_forces(
    model: &Model,
    lagrangian: &Lagrangian,
    loads: &Acting,
    at: &Motion,
    work: &mut Workspace,
) {
    relative_loads(model, loads, at, work);
    if work.gravity != [0.0; 3] {
        let g = mul_t(&at.attitude, work.gravity);
        let weight = lagrangian.weight(g, &work.lagrangian, &mut work.relative);
        add_rigid(&weight, work);
    }
    take_off_inertia(model, work);
}

/// As [`relative_forces`] after [`Lagrangian::inertia`], which has the weight on the elastic rows and the inertia of the accelerations:
/// what the equations miss but for the damping.
#[inline]
pub(crate) fn relative_residual(
    model: &Model,
    lagrangian: &Lagrangian,
    loads: &Acting,
    at: &Motion,
    work: &mut Workspace,
) {
    relative_loads(model, loads, at, work);
    if work.gravity != [0.0; 3] {
        let g = mul_t(&at.attitude, work.gravity);
        add_rigid(&lagrangian.rigid_weight(g, &work.lagrangian), work);
    }
    take_off_inertia(model, work);
}

fn relative_loads(model: &Model, loads: &Acting, at: &Motion, work: &mut Workspace) {
    let (v_a, w_a) = split(&at.beta);
    let variables = Variables { t: at.t, v_a, w_a, r_g: at.position };
    generalised_loads(loads, &variables, at.q, &at.attitude, &mut work.loads, &mut work.external);
    let Some((elastic, rigid)) = work.external.split_last_chunk::<6>() else { return };
    // The shapes of the loads' rows move A along; those of the Lagrangian do not.
    for ((to, from), phi) in work.relative.iter_mut().zip(elastic).zip(&model.phi_r) {
        *to = from - dot_6(phi, rigid);
    }
}

fn add_rigid(wrench: &Vec6, work: &mut Workspace) {
    if let Some(rigid) = work.external.last_chunk_mut::<6>() {
        rigid.iter_mut().zip(wrench).for_each(|(to, from)| *to += from);
    }
}

/// Inertia and elastic forces off the relative elastic rows.
fn take_off_inertia(model: &Model, work: &mut Workspace) {
    for (force, inertia) in work.relative.iter_mut().zip(work.lagrangian.elastic()) {
        *force -= inertia;
    }
    if let Some(trim) = &model.data().trim {
        for (force, elastic) in work.relative.iter_mut().zip(&trim.elastic_force) {
            *force -= elastic;
        }
    }
}

/// `Q_R - h_R` of a consistent model.
#[inline]
pub(crate) fn rigid_force(work: &Workspace) -> Vec6 {
    let external = work.external.last_chunk::<6>().copied().unwrap_or_default();
    sub_6(&external, &work.lagrangian.rigid)
}

/// `q_dot` of `u`.
#[inline(always)]
pub(crate) fn modal(u: &[f64]) -> &[f64] {
    u.split_last_chunk::<6>().map_or(&[], |(q_dot, _)| q_dot)
}

/// `u_dot` from the forces found before.
#[inline(always)]
pub(crate) fn accelerations(model: &Model, at: &Motion, work: &mut Workspace, u_dot: &mut [f64]) {
    if let Some(lagrangian) = &model.lagrangian {
        consistent_accelerations(model, lagrangian, at, work, u_dot);
        return;
    }
    elastic_accelerations(model, at.q, at.u, &work.external, &work.gyroscopic, u_dot);
    if let Some(rigid) = u_dot.last_chunk_mut::<6>() {
        *rigid = mul6_symmetric(&model.rigid_mass_inverse, &rigid_net(&work.external, &work.gyroscopic));
    }
}

/// `(Q_i - N_i - g_i)/m_i - 2 zeta_i omega_i q_dot_i - omega_i^2 q_i` of the elastic rows, four by four.
#[inline(always)]
fn elastic_accelerations(
    model: &Model,
    q: &[f64],
    u: &[f64],
    external: &[f64],
    gyroscopic: &[f64],
    u_dot: &mut [f64],
) {
    let forces = external.as_chunks::<4>().0.iter().zip(gyroscopic.as_chunks::<4>().0);
    let motion = q.as_chunks::<4>().0.iter().zip(u.as_chunks::<4>().0);
    let fours = u_dot.as_chunks_mut::<4>().0.iter_mut().zip(&model.elastic_fours);
    for (((u_dot, mode), (external, gyroscopic)), (q, q_dot)) in fours.zip(forces).zip(motion) {
        let net = minus(*external, *gyroscopic);
        let own = minus(minus(net, times(mode.damping, *q_dot)), times(mode.stiffness, *q));
        *u_dot = times(own, mode.inverse_mass);
    }
    let done = 4 * model.elastic_fours.len();
    let (Some(external), Some(gyroscopic), Some(modes), Some(u_dot)) =
        (external.get(done..), gyroscopic.get(done..), model.elastic.get(done..), u_dot.get_mut(done..))
    else {
        return;
    };
    let motion = q.iter().zip(u).skip(done);
    for ((((u_dot, mode), external), gyroscopic), (q, q_dot)) in
        u_dot.iter_mut().zip(modes).zip(external).zip(gyroscopic).zip(motion)
    {
        let net = external - gyroscopic;
        *u_dot = (net - mode.damping * q_dot - mode.stiffness * q) * mode.inverse_mass;
    }
}

/// The same of a consistent model.
fn consistent_accelerations(
    model: &Model,
    lagrangian: &Lagrangian,
    at: &Motion,
    work: &mut Workspace,
    u_dot: &mut [f64],
) {
    damp(model, at.u, &mut work.relative);
    let rigid = rigid_force(work);
    let Some((q_ddot, beta_star_dot)) = u_dot.split_last_chunk_mut::<6>() else { return };
    let beta_dot = lagrangian.solve(&mut work.lagrangian, &work.relative, &rigid, &[], q_ddot);
    *beta_star_dot = model.own_velocity(&beta_dot, q_ddot);
}

/// Takes the modal damping off the forces on the elastic rows.
#[inline]
pub(crate) fn damp(model: &Model, q_dot: &[f64], force: &mut [f64]) {
    for ((force, mode), q_dot) in force.iter_mut().zip(&model.elastic).zip(q_dot) {
        *force -= mode.damping * q_dot;
    }
    if let Some(damping) = &model.data().damping {
        let rows = rows(&damping.coupling, model.n_modes());
        for (force, row) in force.iter_mut().zip(rows) {
            *force -= row.iter().zip(q_dot).map(|(c, q_dot)| c * q_dot).sum::<f64>();
        }
    }
}

/// `Q_R - N_R`: rate of `M_RR beta*` in A components.
#[inline(always)]
pub(crate) fn rigid_net<R: Real>(external: &[R], gyroscopic: &[R]) -> Vec6<R> {
    sub_6(&tail(external), &tail(gyroscopic))
}

/// The six rigid rows.
#[inline(always)]
pub(crate) fn tail<R: Real>(values: &[R]) -> Vec6<R> {
    values.last_chunk::<6>().copied().unwrap_or_default()
}

/// `1/2 zeta (0, w)`.
#[inline(always)]
pub(crate) fn attitude_rate<R: Real>(zeta: [R; 4], w: Vec3<R>) -> [R; 4] {
    let half = R::of(0.5);
    quaternion_product(zeta, [R::of(0.0), half * w[0], half * w[1], half * w[2]])
}

/// `(p, h)` about the origin of A to `(p, h - c x p)` about the centre of mass `c`.
#[inline(always)]
pub(crate) fn about_centre<R: Real>(c: Vec3, wrench: &Vec6<R>) -> Vec6<R> {
    let (p, h) = split(wrench);
    join(p, crate::math::sub(h, crate::math::cross(constant_vector(&c), p)))
}

/// Inverse of [`about_centre`].
#[inline(always)]
pub(crate) fn about_origin<R: Real>(c: Vec3, wrench: &Vec6<R>) -> Vec6<R> {
    let (p, h) = split(wrench);
    join(p, crate::math::add(h, crate::math::cross(constant_vector(&c), p)))
}
