//! Many instances of one model stepped together.

mod contraction;
mod equations;
mod explicit;
mod group;
mod implicit;
mod loads;
mod state;

use alloc::{sync::Arc, vec::Vec};

use crate::error::{SettingsError, StepError};
use crate::integrator::algorithmic;
use crate::loading::Loads;
use crate::model::Model;
use crate::real::LANES;
use crate::simulation::Settings;
use crate::state::State;
use group::{Chunk, Group, TOGETHER};

/// Instances of one model under loads of their own, stepped side by side in the lanes of vector registers. Every instance has, bit by
/// bit, the motion that a [`Simulation`](crate::Simulation) gives it.
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
/// Instances whose loads act on different points, with models that have no lanes for a part of their equations, or on an x86-64 processor
/// without AVX2, are stepped one by one, as are steps of the implicit integrators that need Newton's corrections: slower, the same bits. [`Batch::steps_alone`] counts
/// them. Instances next to each other whose loads are copies of one that was prepared cost least.
#[derive(Clone, Debug)]
pub struct Batch {
    model: Arc<Model>,
    settings: Settings,
    groups: Vec<Group>,
    n: usize,
}

impl Batch {
    /// `n` instances at rest and undeformed at t = 0 ([`State::at_rest`]). Allocates everything that stepping needs.
    ///
    /// # Errors
    /// As [`Simulation::new`](crate::Simulation::new).
    pub fn new(model: Arc<Model>, settings: Settings, n: usize) -> Result<Self, SettingsError> {
        let whole = Group::new(&model, settings)?;
        let sizes = (0..n).step_by(TOGETHER).map(|start| TOGETHER.min(n - start));
        let groups = sizes.map(|size| whole.of(size)).collect();
        Ok(Batch { model, settings, groups, n })
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
        let groups = self.groups.iter_mut().zip(loads.chunks(TOGETHER));
        Ok(groups.map(|(group, loads)| group.step(&self.model, &self.settings, loads)).sum())
    }

    /// As [`Batch::step`], on the threads of rayon's pool: pays from some hundred instances on. The bits are the same.
    ///
    /// # Errors
    /// As [`Batch::step`].
    #[cfg(feature = "parallel")]
    pub fn step_parallel<L: Loads + Sync>(&mut self, loads: &[L]) -> Result<usize, StepError> {
        use rayon::prelude::*;
        self.check_count(loads)?;
        let (model, settings) = (&self.model, &self.settings);
        let groups = self.groups.par_iter_mut().zip(loads.par_chunks(TOGETHER));
        Ok(groups.map(|(group, loads)| group.step(model, settings, loads)).sum())
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
            && [state.u_dot.len(), state.algorithmic.len()] == [m + 6, algorithmic::length(&self.model)];
        match self.chunk(index) {
            Some(chunk) if fits => chunk.copy_state(index % LANES, state),
            _ => false,
        }
    }

    /// Sets the state of an instance, which runs from there.
    ///
    /// # Errors
    /// As [`Simulation::restore`](crate::Simulation::restore), and when there is no such index.
    pub fn restore(&mut self, index: usize, state: &State) -> Result<(), SettingsError> {
        state.check(&self.model)?;
        let missing = SettingsError::Value {
            what: "index of the instance",
            found: index as f64,
            expected: "less than the number of instances",
        };
        if index >= self.n {
            return Err(missing);
        }
        let chunk = self.groups.get_mut(index / TOGETHER).and_then(|group| group.chunk_mut(index % TOGETHER));
        chunk.map(|chunk| chunk.restore(index % LANES, state)).ok_or(missing)
    }

    /// How many steps of instances have been made one by one so far, instead of side by side.
    pub fn steps_alone(&self) -> u64 {
        self.groups.iter().map(Group::steps_alone).sum()
    }

    /// Why an instance stands still; none while it is running.
    pub fn error(&self, index: usize) -> Option<StepError> {
        self.chunk(index)?.error(index % LANES)
    }

    fn chunk(&self, index: usize) -> Option<&Chunk> {
        if index >= self.n {
            return None;
        }
        self.groups.get(index / TOGETHER)?.chunk(index % TOGETHER)
    }
}
