//! What the integrators make of energy and momenta in the long run: the frame FMB, geometric, free, from half the range of its amplitudes,
//! `drift STEPS`.

use std::path::Path;
use std::sync::Arc;

use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build, input::Structure};
use rom_runtime::{Integrator, Model, Settings, Simulation, State};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let steps: usize = std::env::args().nth(1).map_or(Ok(1_000_000), |s| s.parse())?;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/fmb.toml");
    let structure = Structure::from_toml_path(&path, &[])?;
    let options = BuildOptions {
        modes: ModeSelection::Count(6),
        all_nodes: false,
        inertia: Inertia::Consistent,
        elastic: Elastic::Geometric,
        ..BuildOptions::default()
    };
    let model = Arc::new(Model::new(build(&structure, &options, &mut |_| ())?)?);
    let mut start = State::at_rest(&model);
    let range = model.data().lagrangian.as_ref().map(|it| it.range.clone()).unwrap_or_default();
    for (i, range) in range.iter().enumerate() {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        start.q[i] = 0.5 * sign * range / (1.0 + i as f64);
        start.q_dot[i] = 0.2 * range * model.data().modes.omega[i] / (1.0 + i as f64);
    }
    start.beta_star = [0.0, 0.0, 0.0, 0.3, -0.4, 0.5];
    println!(
        "6 modes up to {:.1} rad/s, {steps} steps; largest relative change of",
        model.data().modes.omega[5]
    );
    println!("integrator               dt, s       energy   moment of momentum");
    for (integrator, a, dt) in [
        (Integrator::EnergyMomentum, 0.0, 0.02),
        (Integrator::Newmark, 0.0, 0.02),
        (Integrator::Newmark, 0.01, 0.02),
        (Integrator::GeneralizedAlpha, 0.01, 0.02),
        (Integrator::Rk4, 0.0, 0.02),
    ] {
        let settings = Settings { dt, integrator, numerical_damping: a, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings)?;
        simulation.restore(&start)?;
        let first = simulation.ledger();
        let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (energy, spin) = (first.kinetic_energy + first.elastic_energy, norm(first.angular_momentum_g));
        let loads = model.no_loads();
        let mut worst = [0.0_f64; 2];
        let mut failure = None;
        for step in 1..=steps {
            if let Err(error) = simulation.step(&loads) {
                failure = Some(error);
                break;
            }
            if step % 100 == 0 || step == steps {
                let now = simulation.ledger();
                let moved = |i: usize| now.angular_momentum_g[i] - first.angular_momentum_g[i];
                worst[0] = worst[0].max(((now.kinetic_energy + now.elastic_energy) / energy - 1.0).abs());
                worst[1] = worst[1].max(norm([moved(0), moved(1), moved(2)]) / spin);
            }
        }
        let name = if a > 0.0 { format!("{integrator}, a = {a}") } else { integrator.name().to_owned() };
        println!("{name:22} {dt:7} {:12.1e} {:20.1e}", worst[0], worst[1]);
        if let Some(error) = failure {
            println!("    {error}");
        }
    }
    Ok(())
}
