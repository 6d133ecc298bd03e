//! Many instances of one model stepped together.

mod equations;
mod explicit;
mod implicit;
mod state;

use alloc::{boxed::Box, sync::Arc, vec::Vec};

use crate::data::{DampingData, GravityData, ModelData, TrimData};
use crate::equations::check_loads;
use crate::error::{SettingsError, StepError};
use crate::integrator::Integrator;
use crate::integrator::parameters::Parameters;
use crate::loading::{Acting, Loads};
use crate::model::{ElasticMode, Model};
use crate::real::LANES;
use crate::simulation::{Settings, Simulation};
use crate::state::{State, algorithmic_length};
use equations::{LaneLoads, LaneWorkspace};
use explicit::LaneStages;
use implicit::LaneImplicit;
use state::LaneState;

/// Instances of one model under loads of their own, stepped side by side in the lanes of vector registers. Every instance has, bit by
/// bit, the motion that a [`Simulation`] gives it.
///
/// ```no_run
/// # use std::sync::Arc;
/// # use rom_runtime::{Batch, Integrator, LoadFrame, LoadSet, Model, Settings};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let model = Arc::new(Model::read_path("fmb.rom")?);
/// let tip = model.point("P")?;
/// let settings = Settings { dt: 0.005, integrator: Integrator::Rk4, ..Settings::default() };
/// let mut loads = vec![LoadSet::new(&model, &[tip])?; 1000];
/// let mut batch = Batch::new(model, settings, loads.len())?;
/// for _ in 0..200 {
///     for (i, loads) in loads.iter_mut().enumerate() {
///         loads.clear();
///         assert!(loads.add(0, &LoadFrame::Dead, [0.0, 0.0, 0.1 * i as f64], [0.0; 3]));
///     }
///     batch.step(&loads)?;
/// }
/// println!("{:?}", batch.state(999));
/// # Ok(())
/// # }
/// ```
///
/// Instances whose loads act on different points, or with models that have no lanes for a part of their equations, are stepped one
/// by one, as are steps of the implicit integrators that need Newton's corrections: slower, the same bits. [`Batch::steps_alone`] counts
/// them.
#[derive(Clone, Debug)]
pub struct Batch {
    model: Arc<Model>,
    settings: Settings,
    chunks: Vec<Chunk>,
    n: usize,
}

/// Up to [`LANES`] instances.
#[derive(Clone, Debug)]
struct Chunk {
    n: usize,
    state: LaneState,
    next: LaneState,
    work: LaneWorkspace,
    method: LaneMethod,
    /// For what is stepped alone.
    single: Simulation,
    scratch: State,
    stopped: [Option<StepError>; LANES],
    /// Steps of instances that were made alone.
    alone: u64,
}

#[derive(Clone, Debug)]
enum LaneMethod {
    Explicit(LaneStages),
    Implicit(Box<LaneImplicit>),
    /// The model has no lanes for a part of its equations.
    Single,
}

impl Batch {
    /// `n` instances at rest and undeformed at t = 0 ([`State::at_rest`]). Allocates everything that stepping needs.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn new(model: Arc<Model>, settings: Settings, n: usize) -> Result<Self, SettingsError> {
        let chunk = Chunk::new(&model, settings)?;
        let mut chunks = alloc::vec![chunk; n.div_ceil(LANES)];
        if let Some(last) = chunks.last_mut() {
            last.n = n - (n - 1) / LANES * LANES;
        }
        Ok(Batch { model, settings, chunks, n })
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Number of instances.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Whether there are no instances.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// One step of every instance that is running, each under its loads - (n); how many are running after it. Does not allocate.
    ///
    /// An instance whose step fails keeps the state before it and stands still until it is given another
    /// ([`Batch::restore`]); [`Batch::error`] says why. The others go on.
    ///
    /// # Errors
    /// [`StepError::LoadCount`] unless there are loads for every instance; nothing has been stepped then.
    pub fn step<L: Loads>(&mut self, loads: &[L]) -> Result<usize, StepError> {
        self.check_count(loads)?;
        let chunks = self.chunks.iter_mut().zip(loads.chunks(LANES));
        Ok(chunks.map(|(chunk, loads)| chunk.step(&self.model, &self.settings, loads)).sum())
    }

    /// As [`Batch::step`], on the threads of rayon's pool: pays from some hundred instances on. The bits are the same.
    ///
    /// # Errors
    /// As [`Batch::step`].
    #[cfg(feature = "parallel")]
    pub fn step_parallel<L: Loads + Sync>(&mut self, loads: &[L]) -> Result<usize, StepError> {
        use rayon::prelude::*;
        /// Chunks a thread takes at a time: some ten microseconds of work.
        const AT_LEAST: usize = 4;
        self.check_count(loads)?;
        let (model, settings) = (&self.model, &self.settings);
        let chunks = self.chunks.par_iter_mut().with_min_len(AT_LEAST).zip(loads.par_chunks(LANES));
        Ok(chunks.map(|(chunk, loads)| chunk.step(model, settings, loads)).sum())
    }

    fn check_count<L>(&self, loads: &[L]) -> Result<(), StepError> {
        let (found, expected) = (loads.len(), self.n);
        if found == expected { Ok(()) } else { Err(StepError::LoadCount { found, expected }) }
    }

    /// A copy of the state of an instance; none when there is no such index.
    pub fn state(&self, index: usize) -> Option<State> {
        let mut state = State::at_rest(&self.model);
        self.copy_state(index, &mut state).then_some(state)
    }

    /// Copies the state of an instance into one of the same model, without allocating; false (and nothing done) when there is no such
    /// index, or when the lengths differ. The outputs of [`Model`] read from it.
    #[must_use]
    pub fn copy_state(&self, index: usize, state: &mut State) -> bool {
        let m = self.model.n_modes();
        let fits = [state.q.len(), state.q_dot.len()] == [m; 2]
            && [state.u_dot.len(), state.algorithmic.len()] == [m + 6, algorithmic_length(&self.model)];
        match self.chunks.get(index / LANES) {
            Some(chunk) if fits && index < self.n => {
                chunk.state.get(index % LANES, state);
                true
            }
            _ => false,
        }
    }

    /// Sets the state of an instance, which runs from there.
    ///
    /// # Errors
    /// As [`Simulation::restore`], and when there is no such index.
    pub fn restore(&mut self, index: usize, state: &State) -> Result<(), SettingsError> {
        state.check(&self.model)?;
        match self.chunks.get_mut(index / LANES) {
            Some(chunk) if index < self.n => {
                chunk.state.set(index % LANES, state);
                if let Some(stopped) = chunk.stopped.get_mut(index % LANES) {
                    *stopped = None;
                }
                Ok(())
            }
            _ => Err(SettingsError::Value {
                what: "index of the instance",
                found: index as f64,
                expected: "less than the number of instances",
            }),
        }
    }

    /// How many steps of instances have been made one by one so far, instead of side by side.
    pub fn steps_alone(&self) -> u64 {
        self.chunks.iter().map(|chunk| chunk.alone).sum()
    }

    /// Why an instance stands still; none while it is running.
    pub fn error(&self, index: usize) -> Option<StepError> {
        *self.chunks.get(index / LANES)?.stopped.get(index % LANES)?
    }
}

impl Chunk {
    fn new(model: &Arc<Model>, settings: Settings) -> Result<Self, SettingsError> {
        let single = Simulation::new(model.clone(), settings)?;
        let Settings { dt, numerical_damping: a, .. } = settings;
        let implicit = |parameters| LaneMethod::Implicit(Box::new(LaneImplicit::new(model, parameters)));
        let method = match settings.integrator {
            _ if !has_lanes(model) => LaneMethod::Single,
            Integrator::Rk4 => LaneMethod::Explicit(LaneStages::new(model)),
            Integrator::Newmark => implicit(Parameters::newmark(dt, a)),
            Integrator::GeneralizedAlpha => implicit(Parameters::generalized_alpha(dt, a)),
            Integrator::EnergyMomentum => LaneMethod::Single,
        };
        let state = LaneState::new(single.state());
        Ok(Chunk {
            n: LANES,
            next: state.clone(),
            state,
            work: LaneWorkspace::new(model),
            method,
            scratch: single.state().clone(),
            single,
            stopped: [None; LANES],
            alone: 0,
        })
    }

    /// Steps the instances that run, each under its loads; how many still do.
    fn step<L: Loads>(&mut self, model: &Model, settings: &Settings, loads: &[L]) -> usize {
        let Some(first) = loads.first() else { return 0 };
        // Lanes beyond the last instance take the loads of the first.
        let mut lanes = [first.acting(); LANES];
        for (lane, loads) in lanes.iter_mut().zip(loads) {
            *lane = loads.acting();
        }
        self.step_under(model, settings, &LaneLoads::new(lanes))
    }

    fn step_under(&mut self, model: &Model, settings: &Settings, loads: &LaneLoads) -> usize {
        self.check_loads(model, loads);
        let running = self.running();
        let alone = if running != [false; LANES] && act_alike(loads) {
            self.know_accelerations(&running, loads);
            self.step_wide(model, settings, loads, &running)
        } else {
            running
        };
        for (lane, loads) in loads.lanes.iter().enumerate() {
            if running.get(lane) == Some(&true) && alone.get(lane) == Some(&true) {
                self.step_alone(lane, loads);
            }
        }
        // Those that stand still stay where they are.
        let standing = self.running().map(|running| !running);
        if standing != [false; LANES] {
            self.next.take(&standing, &self.state);
        }
        core::mem::swap(&mut self.state, &mut self.next);
        self.running().into_iter().filter(|running| *running).count()
    }

    fn running(&self) -> [bool; LANES] {
        let mut running = self.stopped.map(|stopped| stopped.is_none());
        if let Some(beyond) = running.get_mut(self.n..) {
            beyond.fill(false);
        }
        running
    }

    fn check_loads(&mut self, model: &Model, loads: &LaneLoads) {
        for (stopped, loads) in self.stopped.iter_mut().zip(loads.lanes).take(self.n) {
            if let (None, Err(error)) = (&stopped, check_loads(model, loads)) {
                *stopped = Some(error);
            }
        }
    }

    /// What the implicit integrators need to know at the start of a step.
    fn know_accelerations(&mut self, running: &[bool; LANES], loads: &LaneLoads) {
        if !matches!(self.method, LaneMethod::Implicit(_)) {
            return;
        }
        let lanes = running.iter().zip(self.state.accelerations_known).zip(loads.lanes).enumerate();
        for (lane, ((running, known), loads)) in lanes {
            if !*running || known {
                continue;
            }
            self.state.get(lane, &mut self.scratch);
            let known = self
                .single
                .restore(&self.scratch)
                .map(|()| self.single.solve_accelerations(loads).is_ok())
                .unwrap_or(false);
            if known {
                self.state.set(lane, self.single.state());
            }
        }
    }

    /// [`Chunk::step_lanes`] with the widest vector instructions of the machine, where the standard library can tell which it has.
    /// They round as the narrow ones do.
    #[inline(never)]
    fn step_wide(
        &mut self,
        model: &Model,
        settings: &Settings,
        loads: &LaneLoads,
        running: &[bool; LANES],
    ) -> [bool; LANES] {
        crate::four::wide(
            self,
            #[inline(always)]
            |chunk| chunk.step_lanes(model, settings, loads, running),
        )
    }

    /// Steps all lanes into `next`; those that have to be stepped alone instead.
    #[inline(always)]
    fn step_lanes(
        &mut self,
        model: &Model,
        settings: &Settings,
        loads: &LaneLoads,
        running: &[bool; LANES],
    ) -> [bool; LANES] {
        let Chunk { state, next, work, method, .. } = self;
        let mut alone = match method {
            LaneMethod::Explicit(stages) => {
                explicit::step(model, settings.dt, state, loads, work, stages, next);
                [false; LANES]
            }
            LaneMethod::Implicit(implicit) => {
                implicit.step(model, state, loads, running, settings.max_iterations, work, next)
            }
            LaneMethod::Single => return *running,
        };
        for (alone, finite) in alone.iter_mut().zip(next.finite()) {
            *alone |= !finite;
        }
        alone
    }

    /// Steps one instance into `next` as a [`Simulation`], or stops it.
    fn step_alone(&mut self, lane: usize, loads: &Acting) {
        self.alone += 1;
        self.state.get(lane, &mut self.scratch);
        let result = match self.single.restore(&self.scratch) {
            Ok(()) => self.single.step(loads),
            // A state that was finite and of unit attitude when it was taken over.
            Err(_) => Err(StepError::Diverged { time: self.scratch.time, mode: None }),
        };
        match result {
            Ok(()) => self.next.set(lane, self.single.state()),
            Err(error) => {
                if let Some(stopped) = self.stopped.get_mut(lane) {
                    *stopped = Some(error);
                }
            }
        }
    }
}

/// Whether the loads of all lanes act on the same points, of which there are no more than the lanes have room for (loads on stations may
/// have more), and none moves frame A.
fn act_alike(loads: &LaneLoads) -> bool {
    let [first, ..] = loads.lanes;
    let map = first.map();
    map.slots.len() <= map.n_points
        && loads.lanes.iter().all(|loads| {
            loads.base().is_none()
                && loads.map().slots == map.slots
                && loads.direct().is_none_or(|direct| direct.parts().is_some())
        })
}

/// Whether the lanes do all that the single step does. Every field is here by name: one that changes a step has to be brought into
/// the lanes, or sends the model to the single step from here.
fn has_lanes(model: &Model) -> bool {
    let Model {
        data,
        contraction: _,
        elastic,
        elastic_fours: _,
        phi_r: _,
        rigid_mass: _,
        rigid_mass_inverse: _,
        centre_of_mass: _,
        points: _,
        relative: _,
        method: _,
        weight: _,
        damping: _,
        held: _,
        lagrangian,
        participation: _,
        full: _,
        stations: _,
    } = model;
    // Consistent inertia has equations of its own; a clamp holds A.
    if lagrangian.is_some() || model.is_clamped() {
        return false;
    }
    let ModelData {
        provenance: _,
        lines: _,
        rigid: _,
        modes: _,
        c: _,
        k: _,
        points: _,
        load_cases: _,
        picture: _,
        picture_curve: _,
        trim,
        sensors: _,
        gravity,
        lagrangian: _,
        damping,
        clamped: _,
        residual: _,
        validity: _,
        selection: _,
        stations: _,
        cuts: _,
        checks: _,
    } = data;
    for mode in elastic {
        let ElasticMode { mass: _, inverse_mass: _, damping: _, stiffness: _ } = mode;
    }
    if let Some(trim) = trim {
        let TrimData {
            loads: _,
            distributed: _,
            elastic_force: _,
            elastic_energy: _,
            attitude: _,
            factors: _,
            load_names: _,
            reaction: _,
            scales: _,
            displacements: _,
            effort: _,
        } = trim;
    }
    if let Some(gravity) = gravity {
        let GravityData { acceleration: _, second_moment: _ } = gravity;
    }
    if let Some(damping) = damping {
        let DampingData { coupling: _ } = damping;
    }
    true
}
