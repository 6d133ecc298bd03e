//! Instances that are stepped with the same scratch.

use alloc::{boxed::Box, sync::Arc, vec, vec::Vec};

use super::equations::LaneWorkspace;
use super::explicit::{self, LaneStages};
use super::implicit::LaneImplicit;
use super::loads::{KnownLoads, LaneLoads};
use super::state::LaneState;
use crate::data::{DampingData, GravityData, ModelData, TrimData};
use crate::error::{SettingsError, StepError};
use crate::integrator::Integrator;
use crate::integrator::parameters::Parameters;
use crate::loading::{Acting, Loads};
use crate::model::{ElasticMode, Model};
use crate::real::LANES;
use crate::simulation::{Settings, Simulation};
use crate::state::State;

/// Instances of a group: what a thread takes at a time, ten microseconds of work or more.
pub(super) const TOGETHER: usize = 4 * LANES;

/// Up to [`TOGETHER`] instances, chunk after chunk.
#[derive(Clone, Debug)]
pub(super) struct Group {
    chunks: Vec<Chunk>,
    /// None where the model has no lanes for a part of its equations.
    lanes: Option<LaneScratch>,
    /// For what is stepped alone.
    single: Simulation,
    /// Steps of instances that were made alone.
    alone: u64,
}

/// What steps in lanes need besides the states.
#[derive(Clone, Debug)]
struct LaneScratch {
    next: LaneState,
    work: LaneWorkspace,
    method: LaneMethod,
    /// An instance on its way to the single step and back.
    one: State,
}

#[derive(Clone, Debug)]
enum LaneMethod {
    Explicit(LaneStages),
    Implicit(Box<LaneImplicit>),
}

/// Up to [`LANES`] instances.
#[derive(Clone, Debug)]
pub(super) struct Chunk {
    n: usize,
    states: States,
    loads: KnownLoads,
    stopped: [Option<StepError>; LANES],
}

#[derive(Clone, Debug)]
enum States {
    SideBySide(Box<LaneState>),
    /// Of instances that are all stepped alone - (n).
    Apart(Vec<State>),
}

impl Group {
    /// A group of as many instances as there can be, at rest.
    pub(super) fn new(model: &Arc<Model>, settings: Settings) -> Result<Self, SettingsError> {
        let single = Simulation::new(model.clone(), settings)?;
        let Settings { dt, numerical_damping: a, .. } = settings;
        let implicit = |parameters| LaneMethod::Implicit(Box::new(LaneImplicit::new(model, parameters)));
        let method = match settings.integrator {
            _ if !crate::four::is_wide() || !has_lanes(model) => None,
            Integrator::Rk4 => Some(LaneMethod::Explicit(LaneStages::new(model))),
            Integrator::Newmark => Some(implicit(Parameters::newmark(dt, a))),
            Integrator::GeneralizedAlpha => Some(implicit(Parameters::generalized_alpha(dt, a))),
            Integrator::EnergyMomentum => None,
        };
        let rest = single.state().clone();
        let lanes = method.map(|method| LaneScratch {
            next: LaneState::new(&rest),
            work: LaneWorkspace::new(model),
            method,
            one: rest.clone(),
        });
        let states = match lanes {
            Some(_) => States::SideBySide(Box::new(LaneState::new(&rest))),
            None => States::Apart(vec![rest; LANES]),
        };
        let chunk = Chunk { n: LANES, states, loads: KnownLoads::new(), stopped: [None; LANES] };
        Ok(Group { chunks: vec![chunk; TOGETHER / LANES], lanes, single, alone: 0 })
    }

    /// The same of the first `n` instances.
    pub(super) fn of(&self, n: usize) -> Self {
        let mut group = self.clone();
        group.chunks.truncate(n.div_ceil(LANES));
        if let Some(last) = group.chunks.last_mut() {
            last.n = n - (n - 1) / LANES * LANES;
        }
        group
    }

    /// Steps the instances that run, each under its loads; how many still do.
    pub(super) fn step<L: Loads>(&mut self, model: &Model, settings: &Settings, loads: &[L]) -> usize {
        let Group { chunks, lanes, single, alone } = self;
        let mut running = 0;
        for (chunk, loads) in chunks.iter_mut().zip(loads.chunks(LANES)) {
            let Some(first) = loads.first() else { break };
            // Lanes beyond the last instance take the loads of the first.
            let mut acting = [first.acting(); LANES];
            for (lane, loads) in acting.iter_mut().zip(loads) {
                *lane = loads.acting();
            }
            *alone += match lanes {
                Some(lanes) => chunk.step_lanes(model, settings, &acting, lanes, single),
                None => chunk.step_apart(&acting, single),
            };
            running += chunk.running().into_iter().filter(|running| *running).count();
        }
        running
    }

    pub(super) fn steps_alone(&self) -> u64 {
        self.alone
    }

    /// That of an instance.
    pub(super) fn chunk(&self, index: usize) -> Option<&Chunk> {
        self.chunks.get(index / LANES)
    }

    pub(super) fn chunk_mut(&mut self, index: usize) -> Option<&mut Chunk> {
        self.chunks.get_mut(index / LANES)
    }
}

impl Chunk {
    /// Copies the state of an instance into one of the right lengths.
    pub(super) fn copy_state(&self, lane: usize, to: &mut State) -> bool {
        match &self.states {
            States::SideBySide(states) => states.get(lane, to),
            States::Apart(states) => match states.get(lane) {
                Some(state) => to.copy_from(state),
                None => return false,
            },
        }
        true
    }

    /// Sets the state of an instance, of the right lengths, and lets it run.
    pub(super) fn restore(&mut self, lane: usize, from: &State) {
        match &mut self.states {
            States::SideBySide(states) => states.set(lane, from),
            States::Apart(states) => {
                if let Some(state) = states.get_mut(lane) {
                    state.copy_from(from);
                }
            }
        }
        if let Some(stopped) = self.stopped.get_mut(lane) {
            *stopped = None;
        }
    }

    pub(super) fn error(&self, lane: usize) -> Option<StepError> {
        *self.stopped.get(lane)?
    }

    fn running(&self) -> [bool; LANES] {
        let mut running = self.stopped.map(|stopped| stopped.is_none());
        if let Some(beyond) = running.get_mut(self.n..) {
            beyond.fill(false);
        }
        running
    }

    /// Steps every instance alone; how many.
    fn step_apart(&mut self, loads: &[&Acting; LANES], single: &mut Simulation) -> u64 {
        let States::Apart(states) = &mut self.states else { return 0 };
        let mut alone = 0;
        let instances = states.iter_mut().zip(&mut self.stopped).zip(loads).take(self.n);
        for ((state, stopped), loads) in instances.filter(|((_, stopped), _)| stopped.is_none()) {
            alone += 1;
            *stopped = single.with(state, |single| single.step(*loads)).err();
        }
        alone
    }

    /// Steps the instances side by side as far as they can be; how many were stepped alone.
    fn step_lanes(
        &mut self,
        model: &Model,
        settings: &Settings,
        lanes: &[&Acting; LANES],
        scratch: &mut LaneScratch,
        single: &mut Simulation,
    ) -> u64 {
        self.loads.look(model, lanes);
        if let Some(refused) = self.loads.refused() {
            for (stopped, refused) in self.stopped.iter_mut().zip(refused).take(self.n) {
                *stopped = stopped.or(*refused);
            }
        }
        let running = self.running();
        let Chunk { states: States::SideBySide(state), loads: known, stopped, .. } = self else { return 0 };
        let loads = LaneLoads { lanes, known };
        let to_do = if running != [false; LANES] && known.together() {
            if matches!(scratch.method, LaneMethod::Implicit(_)) {
                know_accelerations(state, &running, lanes, &mut scratch.one, single);
            }
            step_wide(model, settings, state, &loads, &running, scratch)
        } else {
            running
        };
        let LaneScratch { next, one, .. } = scratch;
        let mut alone = 0;
        for (lane, loads) in lanes.iter().enumerate() {
            if running.get(lane) == Some(&true) && to_do.get(lane) == Some(&true) {
                alone += 1;
                state.get(lane, one);
                match single.with(one, |single| single.step(*loads)) {
                    Ok(()) => next.set(lane, one),
                    Err(error) => {
                        if let Some(stopped) = stopped.get_mut(lane) {
                            *stopped = Some(error);
                        }
                    }
                }
            }
        }
        // Those that stand still stay where they are.
        let standing = self.running().map(|running| !running);
        let States::SideBySide(state) = &mut self.states else { return alone };
        if standing != [false; LANES] {
            next.take(&standing, state);
        }
        core::mem::swap(&mut **state, next);
        alone
    }
}

/// What the implicit integrators need to know at the start of a step.
fn know_accelerations(
    state: &mut LaneState,
    running: &[bool; LANES],
    loads: &[&Acting; LANES],
    one: &mut State,
    single: &mut Simulation,
) {
    let lanes = running.iter().zip(state.accelerations_known).zip(loads).enumerate();
    for (lane, ((running, known), loads)) in lanes {
        if !*running || known {
            continue;
        }
        state.get(lane, one);
        if single.with(one, |single| single.solve_accelerations(*loads)).is_ok() {
            state.set(lane, one);
        }
    }
}

/// [`step_side_by_side`] with the widest vector instructions of the machine, where the standard library can tell which it has. They round
/// as the narrow ones do.
#[inline(never)]
fn step_wide(
    model: &Model,
    settings: &Settings,
    state: &LaneState,
    loads: &LaneLoads,
    running: &[bool; LANES],
    scratch: &mut LaneScratch,
) -> [bool; LANES] {
    let stepped = crate::four::wide(
        scratch,
        #[inline(always)]
        |scratch| step_side_by_side(model, settings, state, loads, running, scratch),
    );
    stepped.unwrap_or([true; LANES])
}

/// Steps all lanes into `next`; those that have to be stepped alone instead.
#[inline(always)]
fn step_side_by_side(
    model: &Model,
    settings: &Settings,
    state: &LaneState,
    loads: &LaneLoads,
    running: &[bool; LANES],
    scratch: &mut LaneScratch,
) -> [bool; LANES] {
    let LaneScratch { next, work, method, one: _ } = scratch;
    work.held.take(loads);
    let mut alone = match method {
        LaneMethod::Explicit(stages) => {
            explicit::step(model, settings.dt, state, loads, work, stages, next);
            [false; LANES]
        }
        LaneMethod::Implicit(implicit) => {
            implicit.step(model, state, loads, running, settings.max_iterations, work, next)
        }
    };
    for (alone, finite) in alone.iter_mut().zip(next.finite()) {
        *alone |= !finite;
    }
    alone
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
