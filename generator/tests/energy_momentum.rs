//! The energy-momentum method: what it keeps, to which order it is right, and what it asks for.

use std::sync::Arc;

use rom_generator::input::Structure;
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build};
use rom_runtime::{Integrator, Ledger, Model, Settings, SettingsError, Simulation, State, StepError};

fn structure(text: &str, elements: &str) -> Structure {
    let sets = [("elements".to_owned(), elements.to_owned())];
    Structure::from_toml_str(text, "structure.toml", &sets).unwrap_or_else(|e| panic!("{e}"))
}

fn frame(more: &str) -> Structure {
    structure(&format!("{}\n{more}", include_str!("../../models/fmb.toml")), "24")
}

fn model(structure: &Structure, modes: usize, inertia: Inertia, elastic: Elastic) -> Arc<Model> {
    let options = BuildOptions {
        modes: ModeSelection::Count(modes),
        all_nodes: false,
        inertia,
        elastic,
        ..BuildOptions::default()
    };
    Arc::new(Model::new(build(structure, &options, &mut |_| ()).unwrap()).unwrap())
}

/// Amplitudes at half their range, all rates and velocities at work.
fn moving(model: &Model) -> State {
    let mut state = State::at_rest(model);
    let range = &model.data().lagrangian.as_ref().unwrap().range;
    for (i, range) in range.iter().enumerate() {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        state.q[i] = 0.5 * sign * range / (1.0 + i as f64);
        state.q_dot[i] = 0.2 * range * model.data().modes.omega[i] / (1.0 + i as f64);
    }
    state.beta_star = [0.7, -0.4, 0.2, 0.5, -0.8, 1.1];
    state
}

fn simulation(model: &Arc<Model>, integrator: Integrator, dt: f64) -> Simulation {
    let settings = Settings { dt, integrator, max_iterations: 60, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    simulation.restore(&moving(model)).unwrap();
    simulation
}

fn energy(ledger: &Ledger) -> f64 {
    ledger.kinetic_energy + ledger.elastic_energy + ledger.gravity_energy
}

/// Largest relative changes of energy (over the kinetic and elastic one at the start), of moment of momentum about the centre of mass,
/// and of the path of the centre of mass in the field `g`, m.
fn drift(model: &Arc<Model>, integrator: Integrator, dt: f64, steps: usize, g: [f64; 3]) -> [f64; 3] {
    let mut simulation = simulation(model, integrator, dt);
    let mass = model.data().rigid.mass;
    let start = simulation.ledger();
    let size = start.kinetic_energy + start.elastic_energy;
    let spin = |l: &Ledger| -> [f64; 3] {
        let (r, p) = (l.r_cm_g, l.linear_momentum_g);
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            l.angular_momentum_g[i] - (r[j] * p[k] - r[k] * p[j])
        })
    };
    let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let first = spin(&start);
    let loads = model.no_loads();
    let mut worst = [0.0_f64; 3];
    for _ in 0..steps {
        simulation.step(&loads).unwrap();
        let (now, t) = (simulation.ledger(), simulation.state().time);
        let path: [f64; 3] = std::array::from_fn(|i| {
            let fallen = start.r_cm_g[i] + t * start.linear_momentum_g[i] / mass + 0.5 * g[i] * t * t;
            now.r_cm_g[i] - fallen
        });
        let turned = spin(&now);
        let changes = [
            (energy(&now) - energy(&start)).abs() / size,
            norm(std::array::from_fn(|i| turned[i] - first[i])) / norm(first),
            norm(path),
        ];
        worst = std::array::from_fn(|i| worst[i].max(changes[i]));
    }
    worst
}

#[test]
fn energy_and_momenta_are_kept_at_any_step() {
    for elastic in [Elastic::Linear, Elastic::Geometric] {
        let model = model(&frame(""), 6, Inertia::Consistent, elastic);
        for (dt, steps) in [(0.05, 2000), (0.2, 300)] {
            let [energy, spin, path] = drift(&model, Integrator::EnergyMomentum, dt, steps, [0.0; 3]);
            // Each step adds some round-off of sums that cancel; the path gains the error of the velocity times the time.
            assert!(energy < 1e-10 && spin < 1e-10 && path < 1e-9, "{dt}: {energy:e} {spin:e} {path:e}");
        }
        let [of_newmark, ..] = drift(&model, Integrator::Newmark, 0.05, 2000, [0.0; 3]);
        assert!(of_newmark > 1e-3, "a step at which Newmark does not keep the energy: {of_newmark:e}");
    }
}

#[test]
fn self_stress_of_closed_loops_is_in_the_energy() {
    let structure = structure(include_str!("../../models/joined_wing.toml"), "4");
    let model = model(&structure, 4, Inertia::Consistent, Elastic::Geometric);
    assert!(!model.data().lagrangian.as_ref().unwrap().self_stress.is_empty());
    let [energy, spin, path] = drift(&model, Integrator::EnergyMomentum, 0.02, 300, model.gravity());
    assert!(energy < 1e-10 && spin < 1e-10 && path < 1e-9, "{energy:e} {spin:e} {path:e}");
}

#[test]
fn energy_in_a_uniform_field_is_kept() {
    let model = model(
        &frame("[gravity]\nacceleration = [0, 0, -9.81]\n"),
        6,
        Inertia::Consistent,
        Elastic::Geometric,
    );
    // It falls by 500 m: its energy by a thousand times that of the motion at the start.
    let [energy, spin, path] = drift(&model, Integrator::EnergyMomentum, 0.05, 200, [0.0, 0.0, -9.81]);
    assert!(energy < 1e-8 && spin < 1e-10 && path < 1e-9, "{energy:e} {spin:e} {path:e}");
}

#[test]
fn the_motion_is_right_to_second_order_under_loads_and_damping() {
    let damped = frame("[damping]\nmodal_ratio = 0.01\n");
    let model = model(&damped, 6, Inertia::Consistent, Elastic::Geometric);
    let loads = model.prepare(model.load_case("lc1").unwrap()).unwrap();
    let end = |integrator, dt: f64| {
        let mut simulation = simulation(&model, integrator, dt);
        for _ in 0..(1.0 / dt).round() as usize {
            simulation.step(&loads).unwrap();
        }
        simulation.state().clone()
    };
    let exact = end(Integrator::Rk4, 0.001);
    let size = exact.q.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let error = |state: &State| {
        let pairs = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (pairs(&state.q, &exact.q) / size)
            .max(pairs(&state.attitude, &exact.attitude))
            .max(pairs(&state.position, &exact.position))
            .max(pairs(&state.beta_star, &exact.beta_star))
    };
    let [coarse, fine] = [0.004, 0.002].map(|dt| error(&end(Integrator::EnergyMomentum, dt)));
    // Second order: 4, with a margin for the next.
    assert!(fine < coarse / 3.0 && fine < 0.02, "{coarse:e} {fine:e}");
}

#[test]
fn what_it_does_not_do_is_refused() {
    let paper = model(&frame(""), 3, Inertia::Constant, Elastic::Linear);
    let settings = Settings { integrator: Integrator::EnergyMomentum, ..Settings::default() };
    let refused = Simulation::new(paper, settings).unwrap_err();
    assert!(matches!(refused, SettingsError::Integrator { integrator: "energy-momentum", .. }), "{refused}");
    let model = model(&frame(""), 3, Inertia::Consistent, Elastic::Linear);
    let damped = Settings { numerical_damping: 0.01, ..settings };
    assert!(matches!(Simulation::new(model.clone(), damped), Err(SettingsError::Value { .. })));
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    let refused = simulation.step_prescribed(&model.no_loads(), &Default::default()).unwrap_err();
    assert!(matches!(refused, StepError::NotInFrameA { .. }), "{refused}");
    // One iteration is not enough, and the state stays.
    let strict = Settings { max_iterations: 1, ..settings };
    let mut simulation = Simulation::new(model.clone(), strict).unwrap();
    simulation.restore(&moving(&model)).unwrap();
    let before = simulation.state().clone();
    assert!(matches!(simulation.step(&model.no_loads()), Err(StepError::NotConverged { .. })));
    assert_eq!(simulation.state(), &before);
}
