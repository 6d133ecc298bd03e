//! Work to be counted by callgrind, which counts inside of [`measured`] only and writes a count whenever it returns: `check` reads them
//! in the order of the lines printed here, `NAME REPETITIONS`.
//!
//! `instructions PAPER.rom CONSISTENT.rom`: a model as in the paper and one with consistent inertia, with load case lc2.

use std::hint::black_box;
use std::sync::Arc;

use rom_runtime::{
    Batch, Integrator, LoadCase, Method, Model, PreparedLoads, Settings, Simulation, State, StateRate,
    Workspace,
};

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// Steps counted of each kind, and steps before them that bring the body into motion.
const COUNTED: u32 = 50;
const BEFORE: u32 = 400;
const INSTANCES: usize = 8;

/// Named in the call of callgrind.
#[inline(never)]
#[unsafe(no_mangle)]
fn measured(work: &mut dyn FnMut()) {
    work();
}

fn count(name: &str, repetitions: u32, mut work: impl FnMut()) {
    println!("{name} {repetitions}");
    measured(&mut || {
        for _ in 0..repetitions {
            work();
        }
    });
}

struct Case {
    name: &'static str,
    model: Arc<Model>,
    case: LoadCase,
    loads: PreparedLoads,
}

impl Case {
    fn new(name: &'static str, model: Model) -> Outcome<Self> {
        let case = model.load_case("lc2")?.clone();
        Ok(Case { name, loads: model.prepare(&case)?, case, model: Arc::new(model) })
    }

    fn settings(&self, integrator: Integrator) -> Settings {
        let stable = Integrator::Rk4.stable_dt(&self.model).map_or(self.case.dt, |limit| 0.5 * limit.dt);
        let (dt, numerical_damping) = match integrator {
            Integrator::Rk4 => (stable.min(self.case.dt), 0.0),
            _ => (self.case.dt, self.case.numerical_damping),
        };
        Settings { dt, integrator, numerical_damping, ..Settings::default() }
    }

    /// In motion under its loads.
    fn moving(&self) -> Outcome<State> {
        let mut simulation = Simulation::new(self.model.clone(), self.settings(Integrator::Newmark))?;
        for _ in 0..BEFORE {
            simulation.step(&self.loads)?;
        }
        Ok(simulation.state().clone())
    }

    fn step(&self, what: &str, integrator: Integrator, from: &State) -> Outcome {
        let mut simulation = Simulation::new(self.model.clone(), self.settings(integrator))?;
        simulation.restore(from)?;
        simulation.step(&self.loads)?;
        let mut failed = None;
        count(&format!("{}, {integrator}{what}", self.name), COUNTED, || {
            failed = simulation.step(black_box(&self.loads)).err().or(failed);
        });
        failed.map_or(Ok(()), |error| Err(error.into()))
    }

    fn batch(&self, integrator: Integrator, from: &State) -> Outcome {
        let mut batch = Batch::new(self.model.clone(), self.settings(integrator), INSTANCES)?;
        let loads = vec![self.loads.clone(); INSTANCES];
        for index in 0..INSTANCES {
            batch.restore(index, from)?;
        }
        batch.step(&loads)?;
        let mut running = INSTANCES;
        count(&format!("{}, {integrator}, batch of {INSTANCES}", self.name), COUNTED, || {
            running = batch.step(black_box(&loads)).unwrap_or(0).min(running);
        });
        if running == INSTANCES { Ok(()) } else { Err("an instance of the batch has stopped".into()) }
    }

    fn evaluation(&self, state: &State) -> Outcome {
        let (mut work, mut rate) = (Workspace::new(&self.model), StateRate::new(&self.model));
        let mut good = true;
        count(&format!("{}, evaluation", self.name), COUNTED, || {
            good &= self.model.derivatives(black_box(state), &self.loads, &mut work, &mut rate).is_ok();
        });
        if good { Ok(()) } else { Err("the evaluation failed".into()) }
    }
}

fn main() -> Outcome {
    let mut arguments = std::env::args_os().skip(1);
    let mut next = || arguments.next().ok_or("usage: instructions PAPER.rom CONSISTENT.rom");
    let (paper, consistent) = (std::fs::read(next()?)?, std::fs::read(next()?)?);

    let mut read = None;
    count("reading the model", 1, || read = Some(Model::from_bytes(black_box(&paper))));
    let model = read.ok_or("nothing was read")??;

    let case = Case::new("reduced", model.clone())?;
    let moving = case.moving()?;
    case.evaluation(&moving)?;
    for integrator in [Integrator::Rk4, Integrator::Newmark, Integrator::GeneralizedAlpha] {
        case.step("", integrator, &moving)?;
    }
    // What a step costs must not depend on where the body is.
    case.step(", from rest", Integrator::Rk4, &State::at_rest(&case.model))?;
    for integrator in [Integrator::Rk4, Integrator::Newmark] {
        case.batch(integrator, &moving)?;
    }
    for (name, method) in [("mean axes", Method::MeanAxes), ("rigid", Method::Rigid)] {
        let case = Case::new(name, model.with_method(method)?)?;
        let moving = case.moving()?;
        case.step("", Integrator::Rk4, &moving)?;
        case.step("", Integrator::Newmark, &moving)?;
    }
    let case = Case::new("consistent", Model::from_bytes(&consistent)?)?;
    let moving = case.moving()?;
    case.evaluation(&moving)?;
    case.step("", Integrator::Rk4, &moving)?;
    case.step("", Integrator::Newmark, &moving)?;
    case.step(", from rest", Integrator::Rk4, &State::at_rest(&case.model))
}
