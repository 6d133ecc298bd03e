//! A model, its state and all memory of a step in one place.

use alloc::{boxed::Box, sync::Arc};

use crate::base_motion::BaseMotion;
use crate::equations::{Workspace, check_loads};
use crate::error::{SettingsError, StepError};
use crate::estimate::{ErrorEstimate, Estimator};
use crate::identity::Identity;
use crate::integrator::energy_momentum::EnergyMomentum;
use crate::integrator::implicit::{Implicit, start_free};
use crate::integrator::parameters::Parameters;
use crate::integrator::rk4::Course;
use crate::integrator::{Integrator, rk4};
use crate::internal_loads::{InternalLoads, SectionForces};
use crate::jacobian::Jacobian;
use crate::loading::{Acting, Loads};
use crate::model::Model;
use crate::output::{Ledger, PointOutput, RigidOutput};
use crate::point_motion::PointMotion;
use crate::prescribed::{PrescribedMotion, Reaction};
use crate::sensor::SensorReading;
use crate::state::State;

/// How a simulation is marched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Time step, s.
    pub dt: f64,
    /// Integrator. Default: Newmark.
    pub integrator: Integrator,
    /// Numerical damping `a` of Newmark and generalised-alpha, 0 to 1 (see [`Integrator`]); must be zero for the others, which
    /// have none to adjust. Default: 0.
    pub numerical_damping: f64,
    /// Most iterations of a step of the implicit integrators, 1 to [`Settings::MOST_ITERATIONS`]: bounds its cost. Default: 40.
    pub max_iterations: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { dt: 0.01, integrator: Integrator::default(), numerical_damping: 0.0, max_iterations: 40 }
    }
}

/// Marches one model. Everything is allocated by [`Simulation::new`]; [`Simulation::step`] allocates nothing, does not
/// panic and gives the same bits for the same state, loads and settings.
#[derive(Clone, Debug)]
pub struct Simulation {
    model: Arc<Model>,
    settings: Settings,
    state: State,
    next: State,
    work: Workspace,
    method: Method,
    reaction: Option<Reaction>,
    estimator: Option<Box<Estimator>>,
    internal: InternalLoads,
    /// Loads that the accelerations of the state in free flight were solved under by the equations of motion; none where others may have
    /// been.
    solved_under: Identity,
}

#[derive(Clone, Debug)]
enum Method {
    Implicit(Box<Implicit>),
    Explicit(rk4::Stages),
    EnergyMomentum(Box<EnergyMomentum>),
}

impl Simulation {
    /// At rest and undeformed at t = 0 ([`State::at_rest`]).
    ///
    /// # Errors
    /// Settings out of range; for RK4 a step longer than the stable one, which the error names.
    pub fn new(model: Arc<Model>, settings: Settings) -> Result<Self, SettingsError> {
        settings.check(&model)?;
        let Settings { dt, numerical_damping: a, .. } = settings;
        let implicit = |parameters| Method::Implicit(Box::new(Implicit::new(&model, parameters)));
        let method = match settings.integrator {
            Integrator::Newmark => implicit(Parameters::newmark(dt, a)),
            Integrator::GeneralizedAlpha => implicit(Parameters::generalized_alpha(dt, a)),
            Integrator::Rk4 => Method::Explicit(rk4::Stages::new(&model)),
            Integrator::EnergyMomentum => Method::EnergyMomentum(Box::new(EnergyMomentum::new(&model, dt))),
        };
        let state = State::at_rest(&model);
        Ok(Simulation {
            settings,
            next: state.clone(),
            state,
            work: Workspace::new(&model),
            method,
            reaction: None,
            estimator: None,
            internal: InternalLoads::new(&model),
            solved_under: Identity::NONE,
            model,
        })
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The state. A clone of it is a snapshot for [`Simulation::restore`].
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Continues from a state: a snapshot, or initial conditions (see [`State::accelerations_known`]). Does not allocate.
    ///
    /// # Errors
    /// A state of another model, with numbers that are not finite or a quaternion not of unit length.
    pub fn restore(&mut self, state: &State) -> Result<(), SettingsError> {
        state.check(&self.model)?;
        self.state.copy_from(state);
        self.solved_under = Identity::NONE;
        self.reaction = None;
        if let Some(estimator) = &mut self.estimator {
            estimator.reset();
        }
        Ok(())
    }

    /// One time step. Where the load case moves frame A ([`crate::LoadCase::motion`]), or the structure is clamped, A moves as it is
    /// told and [`Simulation::reaction`] tells what that takes.
    ///
    /// Accelerations that are not known (first step, or a state set by hand) are solved from the equations of motion
    /// with the loads at its start.
    ///
    /// # Errors
    /// [`StepError`]; the state is then the one before the step (accelerations that were not known may have been filled in).
    pub fn step<L: Loads + ?Sized>(&mut self, loads: &L) -> Result<(), StepError> {
        self.step_under(loads.acting())
    }

    /// Works on a state of this model that is kept elsewhere.
    pub(crate) fn with<R>(&mut self, state: &mut State, work: impl FnOnce(&mut Self) -> R) -> R {
        core::mem::swap(&mut self.state, state);
        self.solved_under = Identity::NONE;
        let result = work(self);
        core::mem::swap(&mut self.state, state);
        self.solved_under = Identity::NONE;
        result
    }

    fn step_under(&mut self, loads: &Acting) -> Result<(), StepError> {
        check_loads(&self.model, loads)?;
        if let Some(base) = self.model.base_of(loads) {
            return self.step_with_base(loads, base);
        }
        if self.estimator.as_ref().is_some_and(|estimator| estimator.is_new()) {
            self.sample(loads)?;
        }
        match &mut self.method {
            Method::Explicit(stages) => {
                let Settings { dt, .. } = self.settings;
                let (state, work, next) = (&self.state, &mut self.work, &mut self.next);
                let solved = state.accelerations_known && self.solved_under.is(loads.identity());
                rk4::step(&self.model, dt, state, loads, None, solved, work, stages, next);
            }
            Method::EnergyMomentum(method) => {
                let Some(lagrangian) = &self.model.lagrangian else { return Ok(()) };
                let (cap, work, next) = (self.settings.max_iterations, &mut self.work, &mut self.next);
                method.step(&self.model, lagrangian, &self.state, loads, cap, work, next)?;
            }
            Method::Implicit(method) => {
                know_free_accelerations(&self.model, &mut self.state, loads, &mut self.work)?;
                let cap = self.settings.max_iterations;
                method.step(&self.model, &self.state, loads, None, cap, &mut self.work, &mut self.next)?;
            }
        }
        check_finite(&self.next)?;
        core::mem::swap(&mut self.state, &mut self.next);
        self.solved_under = Identity::NONE;
        self.reaction = None;
        if self.estimator.as_mut().is_some_and(|estimator| estimator.counts()) {
            self.sample(loads)?;
        }
        Ok(())
    }

    /// Estimates from now on how far the run is from the body that the model stands for: what the equations leave out is evaluated on the
    /// motion every so many steps (4 costs little; 0 turns it off), and propagated into errors. Allocates. The estimate is no part of the
    /// state: [`Simulation::restore`] and motion prescribed by a host begin it again.
    pub fn watch_errors(&mut self, every: u32) {
        let new = || Box::new(Estimator::new(&self.model, self.settings.dt, every));
        self.estimator = (every > 0).then(new);
    }

    /// Estimated errors of the run so far; none unless they are watched ([`Simulation::watch_errors`]), and none where the motion of A
    /// is given (a clamped structure, base motion, a host): nothing estimates them there.
    pub fn error_estimate(&self) -> Option<ErrorEstimate> {
        if self.reaction.is_some() {
            return None;
        }
        self.estimator.as_ref().map(|estimator| estimator.estimate())
    }

    /// Shows the state to the estimator.
    fn sample(&mut self, loads: &Acting) -> Result<(), StepError> {
        self.know_accelerations(loads)?;
        if let Some(estimator) = &mut self.estimator {
            estimator.sample(&self.model, &self.state, self.work.gravity, loads);
        }
        Ok(())
    }

    /// One time step of a load case that moves frame A, or of a clamped structure.
    fn step_with_base(&mut self, loads: &Acting, base: &BaseMotion) -> Result<(), StepError> {
        self.know_accelerations(loads)?;
        let start = self.model.motion_of(&self.state);
        let motion = base.advance(&start, self.state.time, self.state.time_after(self.settings.dt));
        self.step_prescribed_under(loads, &motion)
    }

    /// Begins a motion of frame A that the host prescribes: takes over velocity, attitude and position at the present
    /// time and solves the elastic accelerations under its rate. Modal amplitudes and rates stay.
    ///
    /// # Errors
    /// Numbers that are not finite, an attitude not of unit length, foreign loads, a mean-axes model. Nothing has changed then.
    pub fn prescribe<L: Loads + ?Sized>(
        &mut self,
        loads: &L,
        motion: &PrescribedMotion,
    ) -> Result<(), StepError> {
        let loads = loads.acting();
        check_loads(&self.model, loads)?;
        motion.check()?;
        self.solved_under = Identity::NONE;
        self.reaction = Some(self.model.prescribe(&mut self.state, loads, motion, &mut self.work)?);
        Ok(())
    }

    /// One time step in which the host moves frame A, to `motion` at the end of the step: only the modes are marched. What
    /// the body does to the host then is [`Simulation::reaction`].
    ///
    /// Call [`Simulation::prescribe`] before the first such step. After steps in free flight the motion goes on from
    /// there; from a state whose accelerations are not known A is taken to accelerate evenly during the step.
    ///
    /// A host that carries mass and inertia of the undeformed body adds the wrench of the elastic motion to its own loads,
    /// one step late:
    ///
    /// ```no_run
    /// # use rom_runtime::{LoadFrame, LoadSet, Model, PrescribedMotion, Settings, Simulation};
    /// # struct Host; // a flight-dynamics code with the rigid aircraft
    /// # impl Host {
    /// #     fn motion(&self) -> PrescribedMotion { PrescribedMotion::default() }
    /// #     fn advance(&mut self, _wrench: [f64; 6], _dt: f64) {}
    /// #     fn lift(&self) -> [f64; 3] { [0.0; 3] }
    /// # }
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let mut host = Host;
    /// let model = std::sync::Arc::new(Model::read_path("aircraft.rom")?);
    /// let tip = model.point("wing tip")?;
    /// let dt = 0.005;
    /// let mut simulation = Simulation::new(model.clone(), Settings { dt, ..Settings::default() })?;
    /// let mut loads = LoadSet::new(&model, &[tip])?;
    /// simulation.prescribe(&loads, &host.motion())?;
    /// for _ in 0..1000 {
    ///     let wrench = simulation.reaction().map_or([0.0; 6], |r| {
    ///         // (force, moment) on the host about the origin of A, axes of A.
    ///         std::array::from_fn(|i| r.loads[i] + r.increment[i])
    ///     });
    ///     host.advance(wrench, dt); // M beta_dot + C(beta) beta = wrench + what else acts on the host
    ///     loads.clear();
    ///     loads.add(0, &LoadFrame::Body, host.lift(), [0.0; 3]);
    ///     simulation.step_prescribed(&loads, &host.motion())?;
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// The increment grows with the rate of the host, by less than the inertia the host carries: by the part of `M_RR` that the
    /// modes take along ([`Model::apparent_inertia`]). Exchanged one step late, that part has the share `mu` of the inertia and
    /// takes `mu^2 omega dt/(2 (1 - mu))` from the damping ratio of a free mode, so that this plain exchange is for steps that are
    /// short against that, and for `mu` well below one. Where wings carry much of the inertia, solve for the acceleration to come
    /// instead, from the wrench extrapolated by a step: that exchange is of second order. [`Reaction::total`] grows by
    /// all of `M_RR`: exchanged explicitly with a host lighter than the body it diverges at any step.
    ///
    /// # Errors
    /// Those of [`Simulation::step`] and [`Simulation::prescribe`]; the state is then the one before the step.
    pub fn step_prescribed<L: Loads + ?Sized>(
        &mut self,
        loads: &L,
        motion: &PrescribedMotion,
    ) -> Result<(), StepError> {
        self.step_prescribed_under(loads.acting(), motion)
    }

    fn step_prescribed_under(&mut self, loads: &Acting, motion: &PrescribedMotion) -> Result<(), StepError> {
        check_loads(&self.model, loads)?;
        motion.check()?;
        let held = self.model.held()?;
        let Settings { dt, max_iterations, .. } = self.settings;
        self.solved_under = Identity::NONE;
        if !self.state.accelerations_known {
            let mut start = self.model.motion_of(&self.state);
            for (rate, (v_0, v_1)) in start.rate.iter_mut().zip(start.velocity.iter().zip(&motion.velocity)) {
                *rate = (v_1 - v_0) / dt;
            }
            self.model.prescribe(&mut self.state, loads, &start, &mut self.work)?;
        }
        let reaction = match &mut self.method {
            Method::Explicit(stages) => {
                let start = self.model.motion_of(&self.state);
                let course = Some(Course { start: &start, end: motion, held });
                let (work, next) = (&mut self.work, &mut self.next);
                rk4::step(&self.model, dt, &self.state, loads, course, false, work, stages, next);
                self.model.prescribe(next, loads, motion, work)?
            }
            Method::EnergyMomentum(_) => {
                return Err(StepError::NotInFrameA {
                    reason: "the energy-momentum method is for free flight; take newmark, gen-alpha or rk4",
                });
            }
            Method::Implicit(method) => {
                let (work, next) = (&mut self.work, &mut self.next);
                method.step(&self.model, &self.state, loads, Some(motion), max_iterations, work, next)?;
                Reaction::of_step(&self.model, work, motion, &next.u_dot)
            }
        };
        check_finite(&self.next)?;
        core::mem::swap(&mut self.state, &mut self.next);
        self.reaction = Some(reaction);
        if let Some(estimator) = &mut self.estimator {
            estimator.reset();
        }
        Ok(())
    }

    /// What the body does to the host, or to the base that a load case moves, at the end of the last prescribed step; none in free
    /// flight.
    pub fn reaction(&self) -> Option<Reaction> {
        self.reaction
    }

    /// Position, velocities and attitude of frame A.
    pub fn rigid_output(&self) -> RigidOutput {
        self.model.rigid_output(&self.state)
    }

    /// Displacement and position of a named point, or none when there is no such index.
    pub fn point_output(&self, point: usize) -> Option<PointOutput> {
        self.model.point_output(&self.state, point)
    }

    /// Solves the accelerations of the state from the equations of motion where they are not known: at the start, after
    /// RK4, and after [`Simulation::restore`] of a state that says so. The implicit integrators leave them behind every step.
    /// Stepping on from there gives the same bits as without.
    ///
    /// # Errors
    /// [`StepError::ForeignLoads`] when the loads were prepared for another model.
    pub fn solve_accelerations<L: Loads + ?Sized>(&mut self, loads: &L) -> Result<(), StepError> {
        let loads = loads.acting();
        check_loads(&self.model, loads)?;
        self.know_accelerations(loads)
    }

    fn know_accelerations(&mut self, loads: &Acting) -> Result<(), StepError> {
        let Some(base) = self.model.base_of(loads) else {
            if !self.state.accelerations_known {
                know_free_accelerations(&self.model, &mut self.state, loads, &mut self.work)?;
                // What a host sets may be other by the next step.
                self.solved_under = if loads.is_prepared() { loads.identity() } else { Identity::NONE };
            }
            return Ok(());
        };
        if !self.state.accelerations_known {
            let motion = base.at(&self.model.motion_of(&self.state), self.state.time);
            self.reaction = Some(self.model.prescribe(&mut self.state, loads, &motion, &mut self.work)?);
        }
        Ok(())
    }

    /// Attitude, velocities and accelerations of a named point; none when there is no such index, or when the accelerations
    /// are not known (see [`Simulation::solve_accelerations`]).
    pub fn point_motion(&self, point: usize) -> Option<PointMotion> {
        let state = self.state.accelerations_known.then_some(&self.state)?;
        self.model.point_motion(state, &state.u_dot, point)
    }

    /// What a sensor reads; none when there is no such index, or when the accelerations are not known.
    pub fn sensor_reading(&self, sensor: usize) -> Option<SensorReading> {
        let state = self.state.accelerations_known.then_some(&self.state)?;
        self.model.sensor_reading_under(self.work.gravity, state, &state.u_dot, sensor)
    }

    /// Evaluates the derivatives of the equations of motion at the present state and under the gravity set here, see [`Jacobian`]. Where a
    /// host moves frame A, see [`Jacobian::evaluate_prescribed`]. Does not allocate.
    ///
    /// # Errors
    /// Those of [`Jacobian::evaluate`].
    pub fn jacobian<L: Loads + ?Sized>(&self, loads: &L, out: &mut Jacobian) -> Result<(), StepError> {
        out.set_gravity(self.work.gravity);
        out.evaluate(&self.state, loads)
    }

    /// Section forces at the places of the model ([`crate::ModelData::cuts`]), in their order, for the present state under these loads;
    /// solves the accelerations where they are not known. Does not allocate.
    ///
    /// # Errors
    /// [`StepError::ForeignLoads`] when the loads were prepared for another model.
    pub fn find_section_forces<L: Loads + ?Sized>(
        &mut self,
        loads: &L,
    ) -> Result<&[SectionForces], StepError> {
        self.solve_accelerations(loads)?;
        let Self { model, state, internal, work, .. } = self;
        internal.find(model, state, &state.u_dot, work.gravity, loads)
    }

    /// What [`Simulation::find_section_forces`] found last.
    pub fn section_forces(&self) -> &[SectionForces] {
        self.internal.found()
    }

    /// Centre of mass, momenta and energies.
    pub fn ledger(&self) -> Ledger {
        self.model.ledger_under(self.work.gravity, &self.state)
    }

    /// Acceleration of free fall in G, m/s^2, under which it is marched.
    pub fn gravity(&self) -> [f64; 3] {
        self.work.gravity
    }

    /// Sets the acceleration of free fall in G, m/s^2, from the next step on; it begins as that of the model, and is not part of the
    /// state. For hosts whose field is not uniform, or that switch it off.
    ///
    /// # Errors
    /// Components that are not finite.
    pub fn set_gravity(&mut self, acceleration: [f64; 3]) -> Result<(), SettingsError> {
        match acceleration.iter().find(|x| !x.is_finite()) {
            Some(&found) => Err(SettingsError::Value {
                what: "gravity",
                found,
                expected: "three finite components in m/s^2",
            }),
            None => {
                self.work.set_gravity(acceleration);
                self.state.accelerations_known = false;
                Ok(())
            }
        }
    }
}

impl Settings {
    /// Most that [`Settings::max_iterations`] may be: what has not converged by then does not, and a step has to end.
    pub const MOST_ITERATIONS: u32 = 1000;

    fn check(&self, model: &Model) -> Result<(), SettingsError> {
        let value = |what, found, expected| Err(SettingsError::Value { what, found, expected });
        if !(self.dt > 0.0 && self.dt.is_finite()) {
            return value("time step dt", self.dt, "a finite number of seconds, more than zero");
        }
        if !(0.0..=1.0).contains(&self.numerical_damping) {
            return value("numerical damping", self.numerical_damping, "a number from 0 to 1");
        }
        if !(1..=Self::MOST_ITERATIONS).contains(&self.max_iterations) {
            return value("max_iterations", f64::from(self.max_iterations), "1 to 1000");
        }
        if !self.integrator.has_numerical_damping() && self.numerical_damping != 0.0 {
            let expected = match self.integrator {
                Integrator::Rk4 => "zero for RK4, which has none to adjust",
                _ => "zero for the energy-momentum method, which has none",
            };
            return value("numerical damping", self.numerical_damping, expected);
        }
        if self.integrator == Integrator::EnergyMomentum && model.lagrangian.is_none() {
            return Err(SettingsError::Integrator {
                integrator: self.integrator.name(),
                reason: "a constant mass matrix has no energy that the equations keep; build the model with elastic modes and \
                         `--inertia consistent`, or take newmark, gen-alpha or rk4",
            });
        }
        if self.integrator == Integrator::EnergyMomentum && model.is_clamped() {
            return Err(SettingsError::Integrator {
                integrator: self.integrator.name(),
                reason: "it is for bodies in free flight, and the structure is clamped; take newmark, gen-alpha or rk4",
            });
        }
        match self.integrator.stable_dt(model) {
            Some(limit) if self.dt > limit.dt => Err(SettingsError::Unstable {
                dt: self.dt,
                stable_dt: limit.dt,
                mode: limit.mode,
                omega: limit.omega,
            }),
            _ => Ok(()),
        }
    }
}

/// Fills `u_dot` and `algorithmic` where they are not known, in free flight.
fn know_free_accelerations(
    model: &Model,
    state: &mut State,
    loads: &Acting,
    work: &mut Workspace,
) -> Result<(), StepError> {
    if !state.accelerations_known {
        model.solve_accelerations(state, loads, work)?;
        start_free(model, state, work);
        state.accelerations_known = true;
    }
    Ok(())
}

/// Refuses a step whose result is not finite.
fn check_finite(state: &State) -> Result<(), StepError> {
    let rigid = state.beta_star.iter().chain(&state.attitude).chain(&state.position);
    // Zero for finite numbers whose square is finite too, so that what is made of them is: one sum instead of a branch per number.
    let sum: f64 = state.q.iter().chain(&state.q_dot).chain(rigid).map(|x| x * x * 0.0).sum();
    // A turn beyond all numbers leaves nothing of the quaternion where its length overflows.
    let turned: f64 = state.attitude.iter().map(|x| x * x).sum();
    if sum == 0.0 && turned > 0.5 {
        return Ok(());
    }
    let modes = state.q.iter().zip(&state.q_dot);
    let mode =
        modes.enumerate().find(|(_, (q, q_dot))| !(q.is_finite() && q_dot.is_finite())).map(|(i, _)| i);
    Err(StepError::Diverged { time: state.time, mode })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::Lumped;

    /// Found by fuzzing the C interface: rates of 1e291 rad/s left the quaternion zero, which is finite.
    #[test]
    fn an_attitude_that_overflowed_is_divergence() {
        let model = Model::new(Lumped::random(2, 3).data(3)).unwrap();
        let mut state = State::at_rest(&model);
        assert_eq!(check_finite(&state), Ok(()));
        state.attitude = [0.0, -0.0, 0.0, 0.0];
        assert_eq!(check_finite(&state), Err(StepError::Diverged { time: 0.0, mode: None }));
    }
}
