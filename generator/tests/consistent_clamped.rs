//! Clamped and moved structures with consistent inertia on the curved manifold: balance of momentum and energy with the reaction, and large
//! swings against the nonlinear method.

use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rom_generator::input::Structure;
use rom_generator::reference::method::{Method, Prepared, RunSettings};
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build};
use rom_runtime::{Integrator, Ledger, Model, Settings, Simulation};

/// A soft blade with a weight at its tip that is off its axis, so that bending, twist and motion in both planes are coupled.
fn blade(extra: &str) -> Structure {
    let text = format!(
        r#"
        [structure]
        name = "blade"
        reference = "root"
        support = "clamped"
        element_nodes = 3
        [sections.blade]
        shape = "constants"
        EA = 1e6
        GAy = 1e6
        GAz = 1e6
        GJ = 8
        EIy = 10
        EIz = 40
        rhoA = 2
        rhoJ = [2e-3, 1e-3, 1e-3]
        [points]
        root = [0, 0, 0]
        tip = [2, 0, 0]
        [[members]]
        name = "blade"
        path = ["root", "tip"]
        section = "blade"
        elements = 10
        local_y = [0, 1, 0]
        [[masses]]
        point = "tip"
        mass = 0.3
        offset = [0, 0.1, 0.02]
        inertia = [1e-3, 1e-3, 1e-3]
        {extra}
        "#
    );
    Structure::from_toml_str(&text, "blade.toml", &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn model(structure: &Structure, modes: usize, elastic: Elastic) -> Arc<Model> {
    let options = BuildOptions {
        modes: ModeSelection::Count(modes),
        all_nodes: false,
        inertia: Inertia::Consistent,
        elastic,
        ..BuildOptions::default()
    };
    Arc::new(Model::new(build(structure, &options, &mut |_| ()).unwrap()).unwrap())
}

/// A base that turns and is shaken, gravity, and a force on the tip.
const SHAKEN: &str = r#"
[gravity]
acceleration = [0, -1, -2]
[load_cases.shaken]
t_end = 1
dt = 0.001
motion = { acceleration = { z = { shape = "sine", omega = 6 }, x = { shape = "sine", omega = 3 } }, angular_velocity = { z = { expression = "0.8*t" }, y = { expression = "0.5*sin(3*t)" } } }
loads = [{ point = "tip", frame = "follower", force = [0, 1, 2] }]
"#;

/// Rates of both momenta in G, by central differences, are what loads and weight do less what the body does to its base. The momenta come
/// from polynomials of the state alone; the reaction from the equations of motion.
#[test]
fn the_reaction_is_what_changes_the_momenta() {
    for elastic in [Elastic::Linear, Elastic::Geometric] {
        let model = model(&blade(SHAKEN), 6, elastic);
        let case = model.load_case("shaken").unwrap().clone();
        let loads = model.prepare(&case).unwrap();
        for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha, Integrator::Rk4] {
            let (dt, every) = (1e-4, 500);
            let settings = Settings { dt, integrator, ..Settings::default() };
            let mut simulation = Simulation::new(model.clone(), settings).unwrap();
            simulation.restore(&model.initial_state(&case).unwrap()).unwrap();
            let momenta =
                |it: &Ledger| (Vector3::from(it.linear_momentum_g), Vector3::from(it.angular_momentum_g));
            let (mut before, mut bent) = (simulation.ledger(), 0.0_f64);
            for step in 1..=6000 {
                let now = simulation.ledger();
                let told = simulation.reaction();
                let frame = simulation.rigid_output();
                simulation.step(&loads).unwrap();
                if step % every == 0 {
                    let [w, x, y, z] = frame.zeta;
                    let to_g = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
                    // Loads are in the reaction already: what is left of both is the inertia.
                    let told = told.unwrap();
                    let inertia: [f64; 6] = std::array::from_fn(|k| told.loads[k] - told.total()[k]);
                    let force = to_g * Vector3::from_column_slice(&inertia[..3]);
                    let moment = to_g * Vector3::from_column_slice(&inertia[3..])
                        + Vector3::from(frame.r_g).cross(&force);
                    let ((p_0, h_0), (p_1, h_1)) = (momenta(&before), momenta(&simulation.ledger()));
                    let (p_dot, h_dot) = ((p_1 - p_0) / (2.0 * dt), (h_1 - h_0) / (2.0 * dt));
                    // Central differences of 1e-4 s leave (omega dt)^2/6 of the highest frequencies kept, some 60 rad/s, at work in
                    // a part of the motion; implicit steps have (omega dt)^2/12 of their own.
                    let error = (p_dot - force).norm() / p_dot.norm();
                    assert!(error < 1e-4, "{integrator} {elastic:?} {step}: {p_dot} {force}");
                    let error = (h_dot - moment).norm() / h_dot.norm();
                    assert!(error < 1e-4, "{integrator} {elastic:?} {step}: {h_dot} {moment}");
                }
                before = now;
                bent = bent.max(Vector3::from(simulation.point_output(1).unwrap().dr_a).norm());
            }
            // Far from where a constant mass matrix would do.
            assert!(bent > 0.3, "{bent}");
        }
    }
}

/// Let go in the field of gravity, a held blade keeps its energy: to fourth order by Runge-Kutta's steps.
#[test]
fn a_held_blade_keeps_its_energy() {
    for elastic in [Elastic::Linear, Elastic::Geometric] {
        let drop = "[gravity]\nacceleration = [0, 0, -0.8]\n[load_cases.drop]\nt_end = 2\ndt = 0.01\n";
        let model = model(&blade(drop), 6, elastic);
        let case = model.load_case("drop").unwrap().clone();
        let loads = model.prepare(&case).unwrap();
        let drift = |dt: f64| {
            let settings = Settings { dt, integrator: Integrator::Rk4, ..Settings::default() };
            let mut simulation = Simulation::new(model.clone(), settings).unwrap();
            simulation.restore(&model.initial_state(&case).unwrap()).unwrap();
            let energy = |it: &Ledger| it.kinetic_energy + it.elastic_energy + it.gravity_energy;
            let (start, mut worst, mut kinetic) = (energy(&simulation.ledger()), 0.0_f64, 0.0_f64);
            for _ in 0..(2.0 / dt).round() as usize {
                simulation.step(&loads).unwrap();
                let now = simulation.ledger();
                worst = worst.max((energy(&now) - start).abs());
                kinetic = kinetic.max(now.kinetic_energy);
            }
            worst / kinetic
        };
        let (coarse, fine) = (drift(0.01), drift(0.005));
        // 16 and, the drift of energy being of an order more, 32; or round-off of 400 steps.
        assert!(coarse < 1e-3 && (fine < coarse / 12.0 || fine < 1e-12), "{elastic:?}: {coarse:e} {fine:e}");
    }
}

/// Under its own weight the blade swings through two fifths of its length.
#[test]
fn a_large_swing_is_that_of_the_nonlinear_method() {
    let drop = "[gravity]\nacceleration = [0, 0, -0.9]\n[load_cases.drop]\nt_end = 4\ndt = 0.01\n";
    let structure = blade(drop);
    let settings = RunSettings { dt: 0.01, integrator: Integrator::Newmark, numerical_damping: 0.01 };
    let prepared = Prepared::new(structure.mesh());
    let case = structure.mesh().load_cases[0].clone();
    let mut nonlinear = prepared.start(Method::Nonlinear, &case, &settings).unwrap();
    let paper = Arc::new(
        Model::new(
            build(
                &structure,
                &BuildOptions { modes: ModeSelection::Count(8), all_nodes: false, ..BuildOptions::default() },
                &mut |_| (),
            )
            .unwrap(),
        )
        .unwrap(),
    );
    let start = |model: &Arc<Model>| {
        let settings = Settings { dt: 0.01, numerical_damping: 0.01, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        simulation.restore(&model.initial_state(&case).unwrap()).unwrap();
        simulation
    };
    let models = [model(&structure, 8, Elastic::Geometric), paper];
    let mut reduced = models.each_ref().map(start);
    let loads = models.each_ref().map(|model| model.prepare(&case).unwrap());
    let (mut error, mut size) = ([0.0_f64; 2], 0.0_f64);
    // Mean squares of the moment on the clamp.
    let (mut missed, mut held) = ([0.0_f64; 2], 0.0_f64);
    for _ in 0..400 {
        nonlinear.step().unwrap();
        let exact = nonlinear.output();
        let moment = Vector3::from_column_slice(&exact.reaction.unwrap().total()[3..]);
        (size, held) = (size.max(exact.dr_a[1].norm()), held + moment.norm_squared());
        for (k, simulation) in reduced.iter_mut().enumerate() {
            simulation.step(&loads[k]).unwrap();
            let moved = Vector3::from(simulation.point_output(1).unwrap().dr_a);
            let told = Vector3::from_column_slice(&simulation.reaction().unwrap().total()[3..]);
            error[k] = error[k].max((moved - exact.dr_a[1]).norm());
            missed[k] += (told - moment).norm_squared();
        }
    }
    let (error, moment) = (error.map(|it| it / size), missed.map(|it| (it / held).sqrt()));
    println!("tip {size} m: {error:?}; moment on the clamp: {moment:?}");
    assert!(size > 0.35 * 2.0, "{size}");
    // A tip that turns by 0.6 rad and more: `theta^4/24` of the manifold, half a per cent of the length, and modes left out.
    assert!(error[0] < 0.02 && error[1] > 10.0 * error[0], "{error:?}");
    // A tenth of the weight leaves 0.1 % in the moment. Here gravity, which begins suddenly, shakes the second and third mode too: they are
    // in the moment more than in the deflection, and drift in phase on the bent blade.
    assert!(moment[0] < 0.06, "{moment:?}");
}

#[test]
fn integrators_agree_on_a_shaken_blade() {
    let model = model(&blade(SHAKEN), 6, Elastic::Geometric);
    let case = model.load_case("shaken").unwrap().clone();
    let loads = model.prepare(&case).unwrap();
    let end = |integrator, dt: f64, steps: usize| {
        let settings = Settings { dt, integrator, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        simulation.restore(&model.initial_state(&case).unwrap()).unwrap();
        for _ in 0..steps {
            simulation.step(&loads).unwrap();
        }
        simulation.state().q.clone()
    };
    let exact = end(Integrator::Rk4, 5e-4, 1600);
    let size = exact.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
        let error = |dt: f64, steps| {
            let found = end(integrator, dt, steps);
            found.iter().zip(&exact).map(|(a, b)| (a - b).abs() / size).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(4e-3, 200), error(2e-3, 400));
        // Second order: 4, with a margin for the next.
        assert!(fine < coarse / 3.0 && fine < 0.01, "{integrator}: {coarse:e} {fine:e}");
    }
}

/// What has no meaning for a structure that is held is refused in words.
#[test]
fn methods_of_free_flight_are_refused() {
    let model = model(&blade(""), 4, Elastic::Geometric);
    let settings = Settings { integrator: Integrator::EnergyMomentum, ..Settings::default() };
    let refused = Simulation::new(model.clone(), settings).unwrap_err().to_string();
    assert!(refused.contains("clamped") && refused.contains("newmark"), "{refused}");
    assert!(Integrator::of(&model).all(|it| it != Integrator::EnergyMomentum));
    let refused = model.with_method(rom_runtime::Method::MeanAxes).unwrap_err().to_string();
    assert!(refused.contains("clamped"), "{refused}");
}
