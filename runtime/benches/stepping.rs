//! Steps of models from files: one alone and in batches, by method and integrator, and how long each of a million steps takes.
//! `benches/performance.py` runs it; by hand: `cargo bench -p rom-runtime --bench stepping -- fmb.rom lc2 [STEPS OF LATENCY]`.
//! One line per figure, `KEY<tab>VALUE`; times are the least of many stretches, in ns per step and instance.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use rom_runtime::{Batch, Integrator, Method, Model, PreparedLoads, Settings, Simulation, State};

const STRETCHES: usize = 100;
const STEPS: usize = 200;
const LANES: usize = 8;

struct Case {
    model: Arc<Model>,
    loads: PreparedLoads,
    settings: Settings,
    /// In motion.
    start: State,
}

impl Case {
    fn new(model: Model, case: &str, integrator: Integrator) -> Self {
        let case = model.load_case(case).unwrap().clone();
        let (model, loads) = (Arc::new(model.clone()), model.prepare(&case).unwrap());
        let stable = integrator.stable_dt(&model).map_or(case.dt, |limit| 0.5 * limit.dt);
        let settings = Settings { dt: stable.min(case.dt), integrator, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        for _ in 0..400 {
            simulation.step(&loads).unwrap();
        }
        let start = simulation.state().clone();
        Case { model, loads, settings, start }
    }

    fn alone(&self) -> f64 {
        let mut simulation = Simulation::new(self.model.clone(), self.settings).unwrap();
        least(|| {
            simulation.restore(&self.start).unwrap();
            timed(|| simulation.step(black_box(&self.loads)).unwrap())
        })
    }

    fn batch(&self, n: usize, mut step: impl FnMut(&mut Batch, &[PreparedLoads])) -> f64 {
        let mut batch = Batch::new(self.model.clone(), self.settings, n).unwrap();
        let loads = vec![self.loads.clone(); n];
        let time = least(|| {
            for index in 0..n {
                batch.restore(index, &self.start).unwrap();
            }
            timed(|| step(&mut batch, black_box(&loads)))
        });
        time / n as f64
    }

    /// Least, median, 99.9 % and most of the times of single steps, ns.
    fn latency(&self, steps: usize) -> [u64; 4] {
        let mut simulation = Simulation::new(self.model.clone(), self.settings).unwrap();
        let mut times = Vec::with_capacity(steps);
        for step in 0..steps {
            if step % STEPS == 0 {
                simulation.restore(&self.start).unwrap();
            }
            let start = Instant::now();
            simulation.step(black_box(&self.loads)).unwrap();
            times.push(start.elapsed().as_nanos() as u64);
        }
        times.sort_unstable();
        [times[0], times[steps / 2], times[(steps as f64 * 0.999) as usize], times[steps - 1]]
    }
}

/// ns per call, in a stretch of calls.
fn timed(mut call: impl FnMut()) -> f64 {
    call();
    let start = Instant::now();
    for _ in 0..STEPS {
        call();
    }
    start.elapsed().as_nanos() as f64 / STEPS as f64
}

fn least(stretch: impl FnMut() -> f64) -> f64 {
    std::iter::repeat_with(stretch).take(STRETCHES).fold(f64::INFINITY, f64::min)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let [path, name, rest @ ..] = arguments.as_slice() else {
        println!("stepping: give a model and the name of a load case; benches/performance.py does");
        return;
    };
    let full = Model::read_path(path).unwrap();
    if let [steps] = rest {
        for integrator in [Integrator::Rk4, Integrator::Newmark] {
            let [least, median, rare, most] =
                Case::new(full.clone(), name, integrator).latency(steps.parse().unwrap());
            println!("latency {integrator}\t{least} {median} {rare} {most}");
        }
        return;
    }
    for method in Method::ALL {
        // Some models have no simpler methods.
        let Ok(model) = full.with_method(method) else { continue };
        for integrator in [Integrator::Rk4, Integrator::Newmark] {
            let case = Case::new(model.clone(), name, integrator);
            println!("{method} {integrator}\t{:.0}", case.alone());
            let together = case.batch(LANES, |batch, loads| {
                batch.step(loads).unwrap();
            });
            println!("{method} {integrator} batch\t{together:.0}");
            #[cfg(feature = "parallel")]
            {
                let pool = case.batch(64 * LANES, |batch, loads| {
                    batch.step_parallel(loads).unwrap();
                });
                println!("{method} {integrator} pool\t{pool:.0}");
            }
        }
    }
}
