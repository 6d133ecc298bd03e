//! Derivatives of the right-hand side by state and loads, and of outputs along them.
//!
//! Everything is differentiated as it is computed ([`crate::forward`]): loads that follow the structure, expressions, weight, gyroscopic
//! forces, the rates of a load case that moves A. The forces of a consistent model are polynomials in the state, and a rule of
//! differences that is exact for their degree takes the place of it (`consistent.rs`). Nothing here is an approximation: what is left
//! is round-off.

mod consistent;
mod forces;
mod ledger;
mod loads;
mod outputs;
mod sections;

use alloc::{sync::Arc, vec, vec::Vec};

use crate::equations::{Motion, Workspace, accelerations, check_loads, forces, rigid_net};
use crate::error::StepError;
use crate::expression::Variables;
use crate::forward::DIRECTIONS;
use crate::integrator::implicit::tail;
use crate::loading::{Acting, Loads, generalised_loads};
use crate::math::{Vec3, Vec6, combine, cross, dot_6, matrix, mul, mul6_symmetric, split, sub, sub_6};
use crate::model::Model;
use crate::prescribed::Held;
use crate::state::State;
use consistent::Consistent;
use forces::ForwardForces;
pub use outputs::Direction;
use sections::Sections;

/// Derivatives of the equations of motion at a state, for hosts with implicit integrators, for linear models, and for sensitivities.
///
/// States are the `2 m + 12` coordinates of the tangent at the state given:
///
/// | columns | coordinate | unit |
/// |---|---|---|
/// | `0 .. m` | modal amplitudes `q` | 1 |
/// | `m .. 2 m` | modal rates `q_dot` | 1/s |
/// | `2 m .. 2 m + 6` | rigid part of the velocity of A, `beta* = (v*, w*)`, in A | m/s, rad/s |
/// | `2 m + 6 .. 2 m + 9` | a small turn `theta` of A in its own axes: `zeta = zeta_0 (1, theta/2)` | rad |
/// | `2 m + 9 .. 2 m + 12` | position of the origin of A in G | m |
///
/// Rows are the rates of the same, `theta_dot = dw - w x theta` being relative to the motion at hand. In a mean-axes model the rigid
/// coordinates are those of its axes about the centre of mass.
///
/// ```no_run
/// # use std::sync::Arc;
/// # use rom_runtime::{Jacobian, LoadFrame, LoadSet, Model, State};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let model = Arc::new(Model::read_path("aircraft.rom")?);
/// let (tip, loads) = (model.point("wing tip")?, model.no_loads());
/// let mut jacobian = Jacobian::new(model.clone());
/// jacobian.evaluate(&State::at_rest(&model), &loads)?;
/// let n = jacobian.size();
/// let a = jacobian.matrix().to_vec(); // d x_dot / d x, n x n, row by row
///
/// // Derivative by a force along z of A at the tip: that of a unit load.
/// let (mut unit, mut column) = (LoadSet::new(&model, &[tip])?, vec![0.0; n]);
/// let _ = unit.add(0, &LoadFrame::Body, [0.0, 0.0, 1.0], [0.0; 3]);
/// jacobian.by_load(&unit, &mut column)?;
/// # drop(a); Ok(()) }
/// ```
///
/// Made once per model and thread; evaluating allocates nothing.
#[derive(Clone, Debug)]
pub struct Jacobian {
    model: Arc<Model>,
    parts: Parts,
    sections: Sections,
}

/// What evaluating writes to. Apart from the model, which it only reads: a clone of its handle would have to be given back, and the
/// proof that nothing is freed would not hold.
#[derive(Clone, Debug)]
struct Parts {
    /// Where it was evaluated last.
    state: State,
    /// The same, moved a little.
    moved: State,
    /// Whether A is held or moved there.
    held: bool,
    /// `(q_ddot, beta*_dot)` there - (m + 6).
    u_dot: Vec<f64>,
    /// Row by row - (n x n).
    matrix: Vec<f64>,
    /// Of the wrench on the host, row by row - (6 x n).
    reaction: Vec<f64>,
    work: Workspace,
    forward: ForwardForces,
    consistent: Consistent,
    slope: Slope,
}

/// Scratch for one direction.
#[derive(Clone, Debug)]
struct Slope {
    q: Vec<f64>,
    u: Vec<f64>,
    u_dot: Vec<f64>,
}

/// What a direction changes.
struct Coordinates {
    /// Of A in its own axes.
    theta: Vec3,
    beta: Vec6,
}

impl Jacobian {
    /// All memory for a model.
    pub fn new(model: Arc<Model>) -> Self {
        let m = model.n_modes();
        let n = 2 * m + 12;
        let parts = Parts {
            state: State::at_rest(&model),
            moved: State::at_rest(&model),
            held: false,
            u_dot: vec![0.0; m + 6],
            matrix: vec![0.0; n * n],
            reaction: vec![0.0; 6 * n],
            work: Workspace::new(&model),
            forward: ForwardForces::new(&model),
            consistent: Consistent::new(&model),
            slope: Slope { q: vec![0.0; m], u: vec![0.0; m + 6], u_dot: vec![0.0; m + 6] },
        };
        Jacobian { sections: Sections::new(&model), model, parts }
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Number of states, `2 m + 12`.
    pub fn size(&self) -> usize {
        size(&self.model)
    }

    /// Sets the acceleration of free fall in G, m/s^2, for the evaluations to come. It begins as that of the model.
    pub fn set_gravity(&mut self, acceleration: [f64; 3]) {
        self.parts.work.set_gravity(acceleration);
    }

    /// Differentiates [`Model::derivatives`] at `state` under `loads`, which may be a load case or the loads of a host; time is held.
    /// Where a load case moves A, or the structure is clamped, A accelerates as it is told. Does not allocate.
    ///
    /// # Errors
    /// [`StepError::ForeignLoads`] and [`StepError::ForeignState`] when they belong to another model;
    /// [`StepError::NotInFrameA`] where A should be moved but cannot be.
    pub fn evaluate<L: Loads + ?Sized>(&mut self, state: &State, loads: &L) -> Result<(), StepError> {
        self.parts.evaluate(&self.model, state, loads.acting(), None)
    }

    /// The same where a host moves A ([`crate::Simulation::prescribe`]): `rate` are the rates `(v_dot, w_dot)` in A of its true velocity,
    /// which stay as they are whatever the state. What the host's wrench does along the states is [`Jacobian::reaction`]; by the rate
    /// itself see [`Jacobian::by_rate`].
    ///
    /// # Errors
    /// As [`Jacobian::evaluate`].
    pub fn evaluate_prescribed<L: Loads + ?Sized>(
        &mut self,
        state: &State,
        loads: &L,
        rate: &[f64; 6],
    ) -> Result<(), StepError> {
        self.parts.evaluate(&self.model, state, loads.acting(), Some(*rate))
    }

    /// Derivative of the rates by a factor on `loads`, at the state evaluated last, into `column` - (2 m + 12): loads enter the
    /// equations linearly, so that this is what they add. What moves A in a load case is not looked at. Returns the derivative of
    /// [`crate::Reaction::total`], zero in free flight.
    ///
    /// # Errors
    /// [`StepError::ForeignLoads`] when the loads were prepared for another model; [`StepError::NotInFrameA`] as before.
    pub fn by_load<L: Loads + ?Sized>(
        &mut self,
        loads: &L,
        column: &mut [f64],
    ) -> Result<[f64; 6], StepError> {
        let loads = loads.acting();
        let Jacobian { model, parts, .. } = self;
        check_loads(model, loads)?;
        let Parts { state, work, .. } = parts;
        let (v_a, w_a) = split(&model.velocity(state));
        let variables = Variables { t: state.time, v_a, w_a, r_g: state.position };
        let attitude = matrix(state.attitude);
        generalised_loads(loads, &variables, &state.q, &attitude, &mut work.loads, &mut work.external);
        parts.by_force(model, &[0.0; 6], column)
    }

    /// Derivative by a component of the rate at which a host moves A, `(v_dot, w_dot)` in A: 0 to 5. Otherwise as [`Jacobian::by_load`].
    ///
    /// # Errors
    /// [`StepError::NotInFrameA`] in free flight, or where A cannot be moved.
    pub fn by_rate(&mut self, component: usize, column: &mut [f64]) -> Result<[f64; 6], StepError> {
        let Jacobian { model, parts, .. } = self;
        if !parts.held {
            return Err(StepError::NotInFrameA { reason: "the body was evaluated in free flight" });
        }
        parts.work.external.fill(0.0);
        let rate: Vec6 = core::array::from_fn(|k| f64::from(u8::from(k == component)));
        parts.by_force(model, &rate, column)
    }

    /// `d x_dot / d x`, row by row - (2 m + 12 x 2 m + 12).
    pub fn matrix(&self) -> &[f64] {
        &self.parts.matrix
    }

    /// A column of [`Jacobian::matrix`].
    pub fn column(&self, column: usize) -> impl Iterator<Item = f64> + '_ {
        self.parts.matrix.chunks_exact(self.size()).map(move |row| row.get(column).copied().unwrap_or(0.0))
    }

    /// Derivative of [`crate::Reaction::total`] by the state where A is held or moved, row by row - (6 x 2 m + 12); zero in free flight.
    pub fn reaction(&self) -> &[f64] {
        &self.parts.reaction
    }

    /// Accelerations `(q_ddot, beta*_dot)` at the state evaluated last - (m + 6).
    pub fn accelerations(&self) -> &[f64] {
        &self.parts.u_dot
    }

    /// The state evaluated last.
    pub fn state(&self) -> &State {
        &self.parts.state
    }
}

impl Parts {
    fn evaluate(
        &mut self,
        model: &Model,
        state: &State,
        loads: &Acting,
        prescribed: Option<Vec6>,
    ) -> Result<(), StepError> {
        check_loads(model, loads)?;
        check_state(model, state)?;
        self.state.copy_from(state);
        let base = if prescribed.is_some() { None } else { model.base_of(loads) };
        let rate = match base {
            Some(base) => Some(base.at(&model.motion_of(state), state.time).rate),
            None => prescribed,
        };
        let held = if rate.is_some() { Some(model.held()?) } else { None };
        self.held = held.is_some();
        self.accelerate(model, loads, held.zip(rate.as_ref()));

        self.consistent.start(model, state, &self.u_dot, self.work.gravity);
        let n = size(model);
        for first in (0..n).step_by(DIRECTIONS) {
            self.forward.seed(model, state, first);
            self.forward.evaluate(model, loads, self.work.gravity);
            let rates = base.map(|base| self.forward.base_rate(base));
            for lane in 0..DIRECTIONS.min(n - first) {
                let rate: Vec6 = rates.map_or([0.0; 6], |rates| rates.map(|x| x.slope(lane)));
                self.write_column(model, first + lane, lane, held.map(|held| (held, &rate)));
            }
        }
        Ok(())
    }

    /// Fills `u_dot`.
    fn accelerate(&mut self, model: &Model, loads: &Acting, held: Option<(&Held, &Vec6)>) {
        let Parts { state, u_dot, work, .. } = self;
        let beta = model.velocity(state);
        model.with_u(&state.q_dot, &state.beta_star, work, |u, work| {
            let attitude = matrix(state.attitude);
            let here = Motion { t: state.time, q: &state.q, u, attitude, position: state.position, beta };
            forces(model, loads, &here, work);
            match held {
                None => accelerations(model, &here, work, u_dot),
                Some((held, rate)) => model.held_accelerations(held, &here, rate, work, u_dot),
            }
        });
    }

    /// Writes the column of a state whose direction is that of `lane`.
    fn write_column(&mut self, model: &Model, column: usize, lane: usize, held: Option<(&Held, &Vec6)>) {
        let along = self.forward.slopes(lane, &mut self.slope.q, &mut self.slope.u, &mut self.work);
        if let Some(lagrangian) = &model.lagrangian {
            self.consistent.add_slopes(
                model,
                lagrangian,
                column,
                self.forward.gravity_slope(lane),
                &mut self.work,
            );
        }
        self.solve(model, held, &along.beta);
        let n = size(model);
        let m = model.n_modes();
        let (v, w) = split(&model.velocity(&self.state));
        let attitude = matrix(self.state.attitude);
        let (dv, dw) = split(&along.beta);
        let theta_dot = sub(dw, cross(w, along.theta));
        let position_dot = mul(&attitude, crate::math::add(dv, cross(along.theta, v)));
        let q_dot = self.slope.u.iter().take(m);
        let rates = q_dot.chain(&self.slope.u_dot).chain(&theta_dot).chain(&position_dot);
        for (row, rate) in self.matrix.chunks_exact_mut(n).zip(rates) {
            if let Some(entry) = row.get_mut(column) {
                *entry = *rate;
            }
        }
        let reaction = match held {
            Some((_, rate)) => self.reaction_slope(model, rate),
            None => [0.0; 6],
        };
        for (row, value) in self.reaction.chunks_exact_mut(n).zip(reaction) {
            if let Some(entry) = row.get_mut(column) {
                *entry = value;
            }
        }
    }

    /// Slopes of the accelerations from those of the forces: the equations are linear in both.
    fn solve(&mut self, model: &Model, held: Option<(&Held, &Vec6)>, beta: &Vec6) {
        let Parts { slope, work, state, .. } = self;
        let at = Motion {
            t: state.time,
            q: &slope.q,
            u: &slope.u,
            attitude: matrix(state.attitude),
            position: [0.0; 3],
            beta: *beta,
        };
        match held {
            None => accelerations(model, &at, work, &mut slope.u_dot),
            Some((held, rate)) => model.held_accelerations(held, &at, rate, work, &mut slope.u_dot),
        }
    }

    /// Slope of [`crate::Reaction::total`], from the slopes of forces and accelerations.
    fn reaction_slope(&self, model: &Model, rate: &Vec6) -> Vec6 {
        let Parts { slope, work, .. } = self;
        match &model.lagrangian {
            None => {
                let own = mul6_symmetric(&model.rigid_mass, &tail(&slope.u_dot));
                sub_6(
                    &sub_6(&rigid_net(&work.external, &work.gyroscopic), &own),
                    &combine(&model.participation, &slope.u_dot),
                )
            }
            Some(lagrangian) => {
                let (q_ddot, _) = slope.u_dot.split_at_checked(model.n_modes()).unwrap_or_default();
                sub_6(&tail(&work.external), &lagrangian.rigid_rows(&work.lagrangian, q_ddot, rate))
            }
        }
    }

    /// From the generalised forces in `work.external`.
    fn by_force(&mut self, model: &Model, rate: &Vec6, column: &mut [f64]) -> Result<[f64; 6], StepError> {
        let held = if self.held { Some((model.held()?, rate)) } else { None };
        self.slope.q.fill(0.0);
        self.slope.u.fill(0.0);
        self.work.gyroscopic.fill(0.0);
        self.work.lagrangian.rigid = [0.0; 6];
        relative_rows(model, &mut self.work);
        self.solve(model, held, &[0.0; 6]);
        let m = model.n_modes();
        column.fill(0.0);
        for (to, from) in column.iter_mut().skip(m).zip(&self.slope.u_dot) {
            *to = *from;
        }
        Ok(if self.held { self.reaction_slope(model, rate) } else { [0.0; 6] })
    }
}

/// Number of states.
fn size(model: &Model) -> usize {
    2 * model.n_modes() + 12
}

/// Relative elastic rows of a consistent model, whose shapes do not move A, from those of `work.external`.
fn relative_rows(model: &Model, work: &mut Workspace) {
    let Some((elastic, rigid)) = work.external.split_last_chunk::<6>() else { return };
    for ((to, from), phi) in work.relative.iter_mut().zip(elastic).zip(&model.phi_r) {
        *to = from - dot_6(phi, rigid);
    }
}

fn check_state(model: &Model, state: &State) -> Result<(), StepError> {
    let modes = model.n_modes();
    match [&state.q, &state.q_dot].map(|x| x.len()).into_iter().find(|found| *found != modes) {
        None => Ok(()),
        Some(found_modes) => Err(StepError::ForeignState { found_modes, modes }),
    }
}
