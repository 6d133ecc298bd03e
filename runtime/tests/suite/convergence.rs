//! Orders of the integrators on a smooth problem with all couplings, their agreement, and reproducibility.

use std::sync::Arc;

use crate::common::{Lumped, Random, rotation_rows};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    Integrator, Load, LoadCase, LoadFrame, Model, PreparedLoads, Settings, SettingsError, Simulation, State,
    StepError,
};

const T_END: f64 = 1.0;

fn model() -> Arc<Model> {
    let mut lumped = Lumped::random(4, 7);
    lumped.damping_ratio = 0.02;
    Arc::new(Model::new(lumped.data(7)).unwrap())
}

/// Stiff enough to stay small when it spins at 4 rad/s.
fn stiff_model() -> Arc<Model> {
    let mut lumped = Lumped::random(4, 7);
    lumped.stiffness *= 20.0;
    Arc::new(Model::new(lumped.data(7)).unwrap())
}

/// Smooth loads in all three frames, strong enough to turn the body by more than a radian.
fn smooth_loads(model: &Model) -> PreparedLoads {
    scaled_loads(model, 1.0)
}

fn scaled_loads(model: &Model, factor: f64) -> PreparedLoads {
    let mut random = Random::new(31);
    let mut loads = Vec::new();
    for (point, frame) in
        [LoadFrame::Dead, LoadFrame::Body, LoadFrame::Follower { section: rotation_rows(&random.vector()) }]
            .into_iter()
            .enumerate()
    {
        loads.push(Load {
            point: point as u32,
            frame,
            force: random.array(15.0 * factor),
            moment: random.array(15.0 * factor),
            time: TimeFunction::Sine { amplitude: 1.0, omega: 3.0, phase: 0.4, start: 0.0, end: f64::MAX },
        });
    }
    model.prepare(&case(loads)).unwrap()
}

fn case(loads: Vec<Load>) -> LoadCase {
    LoadCase { t_end: T_END, dt: 0.01, loads, ..LoadCase::empty("smooth") }
}

fn start(model: &Model) -> State {
    let mut random = Random::new(17);
    let mut state = State::at_rest(model);
    state.q.iter_mut().for_each(|q| *q = 0.2 * random.next());
    state.q_dot.iter_mut().for_each(|q| *q = 0.3 * random.next());
    state.beta_star = random.array(1.0);
    state
}

fn march(model: &Arc<Model>, loads: &PreparedLoads, settings: Settings) -> State {
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    simulation.restore(&start(model)).unwrap();
    for _ in 0..(T_END / settings.dt).round() as usize {
        simulation.step(loads).unwrap();
    }
    simulation.state().clone()
}

/// Largest difference of the physical state.
fn distance(a: &State, b: &State) -> f64 {
    let physical = |s: &State| {
        let mut all = s.q.clone();
        all.extend(s.q_dot.iter().chain(&s.beta_star).chain(&s.attitude).chain(&s.position));
        all
    };
    physical(a).iter().zip(physical(b)).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
}

fn settings(integrator: Integrator, numerical_damping: f64, steps: u32) -> Settings {
    Settings { dt: T_END / f64::from(steps), integrator, numerical_damping, ..Settings::default() }
}

#[test]
fn every_integrator_converges_with_its_order_to_the_same_motion() {
    let model = model();
    let loads = smooth_loads(&model);
    let reference = march(&model, &loads, settings(Integrator::Rk4, 0.0, 4000));
    assert!(distance(&reference, &start(&model)) > 1.0, "the problem should move");
    for (integrator, numerical_damping, order, limit) in [
        (Integrator::Rk4, 0.0, 4.0, 1e-7),
        (Integrator::Newmark, 0.0, 2.0, 1e-2),
        (Integrator::GeneralizedAlpha, 0.0, 2.0, 1e-2),
        (Integrator::GeneralizedAlpha, 0.3, 2.0, 1e-2),
        (Integrator::Newmark, 0.1, 1.0, 5e-2),
    ] {
        let error = |steps| {
            distance(&march(&model, &loads, settings(integrator, numerical_damping, steps)), &reference)
        };
        let (coarse, fine) = (error(200), error(400));
        let slope = (coarse / fine).log2();
        assert!(
            coarse < limit && (slope - order).abs() < 0.25,
            "{integrator} a = {numerical_damping}: errors {coarse:e}, {fine:e}, order {slope}"
        );
    }
}

#[test]
fn a_load_jump_inside_a_step_costs_an_order() {
    let model = model();
    let jump = Load {
        point: 0,
        frame: LoadFrame::Dead,
        force: [10.0, 5.0, -3.0],
        moment: [0.0; 3],
        // A third of the way through a step at every resolution used here.
        time: TimeFunction::Step { value: 1.0, start: 1.0 / 3.0, end: f64::MAX },
    };
    let loads = model.prepare(&case(vec![jump])).unwrap();
    let at = |steps| march(&model, &loads, settings(Integrator::Newmark, 0.0, steps));
    let reference = at(38_400);
    let (coarse, fine) = (distance(&at(200), &reference), distance(&at(800), &reference));
    let slope = 0.5 * (coarse / fine).log2();
    assert!((slope - 1.0).abs() < 0.2, "errors {coarse:e}, {fine:e}, order {slope}");
}

#[test]
fn long_steps_converge_by_newton() {
    // Fast spin and long steps: w dt = 0.8 rad per step, where substitution alone does not contract.
    let model = stiff_model();
    let loads = scaled_loads(&model, 0.2);
    for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
        for dt in [0.05, 0.1, 0.2] {
            let settings = Settings { dt, integrator, numerical_damping: 0.05, ..Settings::default() };
            let mut simulation = Simulation::new(model.clone(), settings).unwrap();
            let mut state = start(&model);
            state.beta_star = [0.5, -0.4, 0.3, 1.0, 3.5, -1.5];
            state.q.fill(0.0);
            simulation.restore(&state).unwrap();
            for step in 0..10 {
                if let Err(error) = simulation.step(&loads) {
                    panic!("{integrator} dt = {dt}, step {step}: {error}");
                }
            }
        }
    }
}

#[test]
fn a_converged_step_satisfies_the_equations_of_motion() {
    // What the iteration (by substitution at 0.01 s, by Newton at 0.2 s) leaves behind, measured by a fresh evaluation.
    let model = stiff_model();
    let loads = scaled_loads(&model, 0.2);
    let (mut work, mut rate) = (rom_runtime::Workspace::new(&model), rom_runtime::StateRate::new(&model));
    for dt in [0.01, 0.2] {
        let settings = Settings { dt, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        let mut state = start(&model);
        state.beta_star = [0.5, -0.4, 0.3, 1.0, 3.5, -1.5];
        simulation.restore(&state).unwrap();
        for _ in 0..5 {
            simulation.step(&loads).unwrap();
            model.derivatives(simulation.state(), &loads, &mut work, &mut rate).unwrap();
            let size = rate.u_dot.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
            for (carried, fresh) in simulation.state().u_dot.iter().zip(&rate.u_dot) {
                // The tolerance is on velocities: their round-off over dt, and times the stiffest omega^2 dt.
                assert!((carried - fresh).abs() < 1e-10 * size, "dt = {dt}: {carried} instead of {fresh}");
            }
        }
    }
}

#[test]
fn the_same_input_gives_the_same_bits_and_snapshots_rewind() {
    let model = model();
    let loads = smooth_loads(&model);
    for integrator in Integrator::of(&model) {
        let settings = settings(integrator, 0.0, 100);
        assert_eq!(march(&model, &loads, settings), march(&model, &loads, settings));

        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        for _ in 0..20 {
            simulation.step(&loads).unwrap();
        }
        let snapshot = simulation.state().clone();
        let mut future = Vec::new();
        for _ in 0..20 {
            simulation.step(&loads).unwrap();
            future.push(simulation.state().clone());
        }
        // Rewind the same simulation, and continue in another.
        let mut other = Simulation::new(model.clone(), settings).unwrap();
        simulation.restore(&snapshot).unwrap();
        other.restore(&snapshot).unwrap();
        for expected in &future {
            simulation.step(&loads).unwrap();
            other.step(&loads).unwrap();
            assert_eq!(simulation.state(), expected, "{integrator}: rewound");
            assert_eq!(other.state(), expected, "{integrator}: continued elsewhere");
        }
    }
}

#[test]
fn time_is_n_dt_after_a_million_steps() {
    let model = Arc::new(Model::new(Lumped::rigid_body().data(1)).unwrap());
    let loads = model.no_loads();
    let settings = Settings { dt: 0.1, integrator: Integrator::Rk4, ..Settings::default() };
    let mut simulation = Simulation::new(model, settings).unwrap();
    for _ in 0..1_000_000 {
        simulation.step(&loads).unwrap();
    }
    assert!((simulation.state().time - 1e5).abs() <= 1e5 * f64::EPSILON, "{}", simulation.state().time);
}

#[test]
fn rk4_is_refused_beyond_its_limit_and_grows_there() {
    for ratio in [0.0, 0.05, 0.7, 1.5] {
        let mut lumped = Lumped::random(3, 11);
        lumped.damping_ratio = ratio;
        let model = Arc::new(Model::new(lumped.data(11)).unwrap());
        let omega = *model.data().modes.omega.last().unwrap();
        let limit = Integrator::Rk4.stable_dt(&model).unwrap();
        assert_eq!((limit.mode, limit.omega), (3, omega));
        if ratio == 0.0 {
            assert!((limit.dt * omega - 2.0 * 2.0_f64.sqrt()).abs() < 1e-14);
        }
        // The amplification over a step at 1 % below and above the limit, from the exact stability function of the
        // oscillator's first-order system.
        let growth = |dt: f64| {
            let a = nalgebra::Matrix2::new(0.0, 1.0, -omega * omega, -2.0 * ratio * omega) * dt;
            let r = nalgebra::Matrix2::identity() + a + a * a / 2.0 + a * a * a / 6.0 + a * a * a * a / 24.0;
            r.complex_eigenvalues().iter().map(|z| z.norm()).fold(0.0, f64::max)
        };
        assert!(growth(0.99 * limit.dt) < 1.0 && growth(1.01 * limit.dt) > 1.0, "damping ratio {ratio}");

        let settings = |dt| Settings { dt, integrator: Integrator::Rk4, ..Settings::default() };
        assert!(Simulation::new(model.clone(), settings(0.999 * limit.dt)).is_ok());
        let error = Simulation::new(model.clone(), settings(1.001 * limit.dt)).unwrap_err();
        let SettingsError::Unstable { stable_dt, mode: 3, .. } = error else { panic!("{error}") };
        assert_eq!(stable_dt, limit.dt);
        assert!(error.to_string().contains(&format!("{stable_dt}")), "{error}");
        assert_eq!(Integrator::Newmark.stable_dt(&model), None);
    }
}

#[test]
fn settings_out_of_range_are_refused() {
    let model = model();
    let good = Settings::default();
    for (bad, word) in [
        (Settings { dt: 0.0, ..good }, "time step"),
        (Settings { dt: f64::NAN, ..good }, "time step"),
        (Settings { dt: f64::INFINITY, ..good }, "time step"),
        (Settings { numerical_damping: -0.1, ..good }, "numerical damping"),
        (Settings { numerical_damping: f64::NAN, ..good }, "numerical damping"),
        (Settings { max_iterations: 0, ..good }, "max_iterations"),
        // Found by a fuzzer: a step that does not converge went on for minutes.
        (Settings { max_iterations: 1 << 31, ..good }, "1 to 1000"),
        (Settings { integrator: Integrator::Rk4, numerical_damping: 0.1, ..good }, "numerical damping"),
    ] {
        let error = Simulation::new(model.clone(), bad).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    let mut simulation = Simulation::new(model.clone(), good).unwrap();
    let mut foreign = State::at_rest(&model);
    foreign.q.push(0.0);
    assert!(simulation.restore(&foreign).is_err());
    let mut broken = State::at_rest(&model);
    broken.attitude = [2.0, 0.0, 0.0, 0.0];
    assert!(simulation.restore(&broken).is_err());
    broken.attitude = [f64::NAN; 4];
    assert!(simulation.restore(&broken).is_err());
    assert_eq!("gen-alpha".parse(), Ok(Integrator::GeneralizedAlpha));
    assert!("euler".parse::<Integrator>().is_err());
}

#[test]
fn a_failed_step_leaves_the_state_as_it_was() {
    let model = model();
    let blow_up = Load {
        point: 0,
        frame: LoadFrame::Dead,
        force: [1e300; 3],
        moment: [0.0; 3],
        time: TimeFunction::Constant { value: 1e200 },
    };
    let loads = model.prepare(&case(vec![blow_up])).unwrap();
    let other = Arc::new(Model::new(Lumped::random(3, 1).data(1)).unwrap());
    for integrator in Integrator::of(&model) {
        let mut simulation = Simulation::new(model.clone(), settings(integrator, 0.0, 100)).unwrap();
        simulation.restore(&start(&model)).unwrap();
        for _ in 0..3 {
            simulation.step(&model.no_loads()).unwrap();
        }
        let before = simulation.state().clone();
        assert!(matches!(simulation.step(&loads), Err(StepError::Diverged { .. })), "{integrator}");
        assert_eq!(simulation.state(), &before, "{integrator}");
        assert!(matches!(simulation.step(&other.no_loads()), Err(StepError::ForeignLoads { .. })));
        assert_eq!(simulation.state(), &before, "{integrator}");
    }
    let strict = Settings { max_iterations: 1, ..settings(Integrator::Newmark, 0.0, 100) };
    let mut simulation = Simulation::new(model.clone(), strict).unwrap();
    let error = simulation.step(&smooth_loads(&model)).unwrap_err();
    assert!(matches!(error, StepError::NotConverged { iterations: 1, .. }), "{error}");
    assert_eq!(simulation.state().time, 0.0);
}
