//! Loads that depend on the motion at the end of the step (an aerodynamic code): set from the state, step, look, rewind and step again
//! until loads and motion agree.
//!
//! ```sh
//! romgen build models/fmb.toml -o fmb.rom
//! cargo run --package rom-runtime --example loads_from_state -- fmb.rom
//! ```

use std::error::Error;
use std::sync::Arc;

use rom_runtime::{LoadFrame, LoadSet, Model, Settings, Simulation, StepError, into_axes};

/// Force of a damper on every point, N: a stand-in for aerodynamics, which see the velocity of the surface.
fn damping(simulation: &Simulation, points: &[usize], coefficient: f64) -> Vec<[f64; 3]> {
    let zeta = simulation.state().attitude;
    let velocity = |&point| simulation.point_motion(point).map_or([0.0; 3], |motion| motion.v_g);
    points.iter().map(velocity).map(|v_g| into_axes(zeta, v_g).map(|v| -coefficient * v)).collect()
}

fn set(loads: &mut LoadSet, forces: &[[f64; 3]]) -> Result<(), Box<dyn Error>> {
    loads.clear();
    for (slot, force) in forces.iter().enumerate() {
        if !loads.add(slot, &LoadFrame::Body, *force, [0.0; 3]) {
            return Err("the set has no such slot".into());
        }
    }
    Ok(())
}

fn energy(simulation: &Simulation) -> f64 {
    let ledger = simulation.ledger();
    ledger.kinetic_energy + ledger.elastic_energy
}

/// Kinetic and elastic energy after a second; iterations made.
fn run(model: &Arc<Model>, dt: f64, most: usize) -> Result<(f64, usize), Box<dyn Error>> {
    let points = [model.point("P")?, model.point("Q")?];
    let mut simulation = Simulation::new(model.clone(), Settings { dt, ..Settings::default() })?;
    let mut start = simulation.state().clone();
    start.q_dot.iter_mut().take(2).for_each(|rate| *rate = 5.0);
    simulation.restore(&start)?;
    let mut loads = LoadSet::new(model, &points)?;
    let mut iterations = 0;
    let mut forces = vec![[0.0; 3]; points.len()];
    // Memory of the snapshot, taken over and over.
    let mut before = simulation.state().clone();
    for _ in 0..(1.0 / dt).round() as usize {
        before.clone_from(simulation.state());
        for iteration in 0..most {
            if iteration > 0 {
                // To the bit where the step began.
                simulation.restore(&before)?;
            }
            set(&mut loads, &forces)?;
            simulation.step(&loads)?;
            simulation.solve_accelerations(&loads)?;
            iterations += 1;
            let found = damping(&simulation, &points, 40.0);
            let change = found.iter().flatten().zip(forces.iter().flatten()).map(|(a, b)| (a - b).abs());
            let change = change.fold(0.0, f64::max);
            forces = found;
            if change < 1e-9 {
                break;
            }
        }
    }
    Ok((energy(&simulation), iterations))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name a model file: fmb.rom")?;
    let model = Arc::new(Model::read_path(path)?);
    let (exact, _) = run(&model, 1e-3, 50)?;
    println!("energy after 1 s with damped tips: {exact:.6} J");
    let mut errors = Vec::new();
    for most in [1, 50] {
        let (found, iterations) = run(&model, 0.01, most)?;
        let error = (found / exact - 1.0).abs();
        println!(
            "steps of 0.01 s, loads {}: {iterations} steps made, error {error:.2e}",
            match most {
                1 => "of the step before",
                _ => "iterated to agreement",
            }
        );
        errors.push(error);
    }
    // Loads one step late are of first order, iterated ones of second.
    match errors.as_slice() {
        [late, iterated] if iterated < late => Ok(()),
        _ => Err(Box::new(StepError::NotConverged { time: 1.0, iterations: 50, residual: 0.0 })),
    }
}
