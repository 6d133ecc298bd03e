//! Cost of a step of consistent models over that of the paper's, by integrator and number of modes: the frame FMB under load case 2,
//! `step_cost 5,10,20`. All models take turns, and the fastest of many short stretches counts, so that other work on the machine shifts
//! the ratios little.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build, input::Structure};
use rom_runtime::{Integrator, Model, PreparedLoads, Settings, Simulation, State};

const BLOCKS: usize = 100;
const STEPS: usize = 100;

/// A model in full motion.
struct Moving {
    model: Arc<Model>,
    loads: PreparedLoads,
    state: State,
}

fn moving(modes: usize, inertia: Inertia, elastic: Elastic) -> Result<Moving, Box<dyn std::error::Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/fmb.toml");
    let structure = Structure::from_toml_path(&path, &[])?;
    let options = BuildOptions {
        modes: ModeSelection::Count(modes),
        all_nodes: false,
        inertia,
        elastic,
        ..BuildOptions::default()
    };
    let model = Arc::new(Model::new(build(&structure, &options, &mut |_| ())?)?);
    let loads = model.prepare(model.load_case("lc2")?)?;
    let settings = Settings { dt: 1e-3, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), settings)?;
    for _ in 0..2000 {
        simulation.step(&loads)?;
    }
    Ok(Moving { state: simulation.state().clone(), model, loads })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let counts = std::env::args().nth(1).unwrap_or_else(|| "5,10,20".to_owned());
    println!("modes  integrator            paper, us   consistent    geometric");
    for modes in counts.split(',') {
        let modes: usize = modes.parse()?;
        let models = [
            moving(modes, Inertia::Constant, Elastic::Linear)?,
            moving(modes, Inertia::Consistent, Elastic::Linear)?,
            moving(modes, Inertia::Consistent, Elastic::Geometric)?,
        ];
        for integrator in [Integrator::Rk4, Integrator::Newmark, Integrator::GeneralizedAlpha] {
            let limit = integrator.stable_dt(&models[0].model).map_or(0.01, |limit| 0.5 * limit.dt);
            let settings = Settings { dt: limit.min(0.01), integrator, ..Settings::default() };
            let mut simulations = Vec::new();
            for moving in &models {
                simulations.push(Simulation::new(moving.model.clone(), settings)?);
            }
            let mut best = [f64::INFINITY; 3];
            for _ in 0..BLOCKS {
                for ((simulation, moving), best) in simulations.iter_mut().zip(&models).zip(&mut best) {
                    simulation.restore(&moving.state)?;
                    let start = Instant::now();
                    for _ in 0..STEPS {
                        simulation.step(&moving.loads)?;
                    }
                    *best = best.min(start.elapsed().as_secs_f64() / STEPS as f64);
                }
            }
            let [paper, consistent, geometric] = best;
            println!(
                "{modes:5}  {:16}  {:12.2} {:10.2} x {:10.2} x",
                integrator.name(),
                1e6 * paper,
                consistent / paper,
                geometric / paper
            );
        }
    }
    Ok(())
}
