//! The rigid model (no elastic modes) against exact solutions.

use std::sync::Arc;

use crate::common::{Lumped, Mass, case};
use nalgebra::{DMatrix, Matrix3, UnitQuaternion, Vector3};
use rom_runtime::data::ModelData;
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Ledger, Load, LoadFrame, Model, Settings, Simulation};

fn settings(integrator: Integrator, dt: f64) -> Settings {
    Settings { dt, integrator, ..Settings::default() }
}

fn body() -> ModelData {
    Lumped::rigid_body().data(1)
}

/// A symmetric top: two masses on the axis, four around it.
fn symmetric_top() -> Model {
    let mut masses = Vec::new();
    for (axis, arm) in [(Vector3::x(), 1.0), (Vector3::y(), 1.0), (Vector3::z(), 2.0)] {
        for sign in [-1.0, 1.0] {
            masses.push(Mass { mass: 1.0, position: sign * arm * axis, shapes: vec![] });
        }
    }
    let stiffness = DMatrix::zeros(0, 0);
    Model::new(Lumped { masses, stiffness, damping_ratio: 0.0, plain_points: true }.data(1)).unwrap()
}

/// Simulation with an initial velocity (v, w) of A.
fn thrown(model: Model, settings: Settings, beta: [f64; 6]) -> Simulation {
    let mut simulation = Simulation::new(Arc::new(model), settings).unwrap();
    let mut state = simulation.state().clone();
    state.beta_star = beta;
    simulation.restore(&state).unwrap();
    simulation
}

fn run(simulation: &mut Simulation, t_end: f64) -> Ledger {
    let loads = simulation.model().clone().no_loads();
    let steps = (t_end / simulation.settings().dt).round() as usize;
    for _ in 0..steps {
        simulation.step(&loads).unwrap();
    }
    simulation.ledger()
}

fn relative(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm() / Vector3::from(b).norm()
}

/// Tumbling about the axis of intermediate inertia, centre of mass off the origin.
const TUMBLE: [f64; 6] = [1.0, -2.0, 0.5, 0.3, 4.0, 0.2];

#[test]
fn implicit_integrators_conserve_both_momenta_to_round_off_at_any_step() {
    for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
        for (dt, numerical_damping) in [(0.01, 0.0), (0.1, 0.0), (0.1, 0.1), (0.3, 0.05)] {
            let settings = Settings { numerical_damping, ..settings(integrator, dt) };
            let mut simulation = thrown(Model::new(body()).unwrap(), settings, TUMBLE);
            let start = simulation.ledger();
            let end = run(&mut simulation, 30.0);
            let (p, l) = (
                relative(end.linear_momentum_g, start.linear_momentum_g),
                relative(end.angular_momentum_g, start.angular_momentum_g),
            );
            // Up to 3000 steps with some round-offs each; the angular momentum is that of r x p too, r going to 60 m.
            assert!(p < 1e-11 && l < 1e-11, "{integrator} dt = {dt}: {p:e} {l:e}");
            // The centre of mass goes straight, at constant speed.
            let mass = simulation.model().data().rigid.mass;
            let travelled = (Vector3::from(end.r_cm_g) - Vector3::from(start.r_cm_g)) / 30.0;
            let error = (travelled - Vector3::from(start.linear_momentum_g) / mass).norm() / travelled.norm();
            assert!(error < 1e-11, "{integrator} dt = {dt}: centre of mass {error:e}");
        }
    }
}

/// Worst relative energy error over 10 s of tumbling.
fn energy_error(integrator: Integrator, dt: f64) -> f64 {
    let mut simulation = thrown(Model::new(body()).unwrap(), settings(integrator, dt), TUMBLE);
    let start = simulation.ledger().kinetic_energy;
    let loads = simulation.model().clone().no_loads();
    let mut worst: f64 = 0.0;
    for _ in 0..(10.0 / dt).round() as usize {
        simulation.step(&loads).unwrap();
        worst = worst.max((simulation.ledger().kinetic_energy / start - 1.0).abs());
    }
    worst
}

#[test]
fn energy_of_a_tumbling_body_is_kept() {
    // The step turns about w_0 + w_1, so that turning leaves (w_0 + w_1) . (h_1 - h_0) = 2 (T_1 - T_0) zero: without
    // numerical damping the implicit integrators keep energy to round-off.
    for dt in [0.01, 0.1] {
        for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
            let error = energy_error(integrator, dt);
            assert!(error < 1e-11, "{integrator} dt = {dt}: {error:e}");
        }
    }
    let (coarse, fine) = (energy_error(Integrator::Rk4, 0.02), energy_error(Integrator::Rk4, 0.01));
    let order = (coarse / fine).log2();
    assert!(order > 3.9, "RK4: energy errors {coarse:e}, {fine:e}, order {order}");
}

#[test]
fn free_precession_of_a_symmetric_top_is_the_exact_one() {
    // Inertia: A = 2 (1 + 4) = 10 across, C = 4 along. In A, the transverse part of w turns with (C - A)/A w_z; in G
    // the body turns about the fixed angular momentum L with |L|/A.
    let (across, along, w) = (10.0, 4.0, Vector3::new(0.8, 0.0, 3.0));
    let t_end = 5.0;
    let inertia = Matrix3::from_diagonal(&Vector3::new(across, across, along));
    let momentum = inertia * w;
    let about_own_axis =
        UnitQuaternion::from_scaled_axis(Vector3::z() * ((across - along) / across * w.z * t_end));
    let exact = UnitQuaternion::from_scaled_axis(momentum / across * t_end) * about_own_axis;
    let mut errors = Vec::new();
    for (integrator, dt) in [
        (Integrator::Rk4, 0.01),
        (Integrator::Rk4, 0.005),
        (Integrator::Newmark, 0.01),
        (Integrator::Newmark, 0.005),
        (Integrator::GeneralizedAlpha, 0.01),
        (Integrator::GeneralizedAlpha, 0.005),
    ] {
        let mut simulation =
            thrown(symmetric_top(), settings(integrator, dt), [0.0, 0.0, 0.0, w.x, w.y, w.z]);
        run(&mut simulation, t_end);
        errors.push(simulation.state().attitude_quaternion().angle_to(&exact));
    }
    for (pair, (order, limit)) in errors.chunks(2).zip([(4.0, 1e-7), (2.0, 3e-3), (2.0, 3e-3)]) {
        let slope = (pair[0] / pair[1]).log2();
        assert!(pair[0] < limit && (slope - order).abs() < 0.15, "errors {pair:?}, order {slope}");
    }
}

#[test]
fn a_body_under_a_constant_dead_force_at_its_centre_falls_as_a_particle() {
    // The point: offset from a node at the origin to the centre of mass.
    let mut data = body();
    let centre = data.rigid.centre_of_mass;
    data.points[0].node_position = [0.0; 3];
    data.points[0].node_rotation = [1.0, 0.0, 0.0, 0.0];
    data.points[0].offset = centre;
    let model = Model::new(data).unwrap();
    let (force, mass, t) = (Vector3::new(3.0, -2.0, 7.0), model.data().rigid.mass, 4.0);
    let load = Load {
        point: 0,
        frame: LoadFrame::Dead,
        force: force.into(),
        moment: [0.0; 3],
        time: TimeFunction::Constant { value: 1.0 },
    };
    let loads = model.prepare(&case(vec![load])).unwrap();
    for (integrator, tolerance) in
        [(Integrator::Newmark, 1e-12), (Integrator::GeneralizedAlpha, 1e-12), (Integrator::Rk4, 1e-7)]
    {
        // It spins meanwhile; RK4 knows nothing of inertial axes and errs by (w dt)^4/120 of the turn of 9 rad.
        let mut simulation =
            thrown(model.clone(), settings(integrator, 0.01), [0.5, 0.0, 0.0, 0.3, 1.0, -2.0]);
        let start = simulation.ledger();
        for _ in 0..400 {
            simulation.step(&loads).unwrap();
        }
        let end = simulation.ledger();
        let p = Vector3::from(start.linear_momentum_g);
        let momentum = p + t * force;
        let position = Vector3::from(start.r_cm_g) + (t * p + 0.5 * t * t * force) / mass;
        assert!(relative(end.linear_momentum_g, momentum.into()) < tolerance, "{integrator}: momentum");
        assert!(relative(end.r_cm_g, position.into()) < tolerance, "{integrator}: position");
    }
}

#[test]
fn a_body_moment_about_a_principal_axis_spins_it_up_exactly() {
    let model = symmetric_top();
    let load = Load {
        point: 0,
        frame: LoadFrame::Body,
        force: [0.0; 3],
        moment: [0.0, 0.0, 2.0],
        time: TimeFunction::Constant { value: 1.0 },
    };
    let loads = model.prepare(&case(vec![load])).unwrap();
    for integrator in Integrator::of(&model) {
        let mut simulation = Simulation::new(Arc::new(model.clone()), settings(integrator, 0.02)).unwrap();
        for _ in 0..200 {
            simulation.step(&loads).unwrap();
        }
        // Inertia 4: w = t/2 = 2 rad/s and angle t^2/4 = 4 rad at t = 4 s.
        let exact = UnitQuaternion::from_scaled_axis(Vector3::z() * 4.0);
        assert!((simulation.rigid_output().w_a[2] - 2.0).abs() < 1e-12, "{integrator}");
        // RK4 turns by the exact exponential only to fourth order: (w dt)^5/1920 per step at most.
        assert!(simulation.state().attitude_quaternion().angle_to(&exact) < 1e-8, "{integrator}");
    }
}

#[test]
fn a_dead_couple_changes_the_angular_momentum_by_its_impulse() {
    // Equal and opposite dead forces far apart: their moment turns with the body, the momentum balance stays exact to
    // second order; and without forces left over the centre of mass stays.
    let model = Model::new(body()).unwrap();
    let couple = |point, sign: f64| Load {
        point,
        frame: LoadFrame::Dead,
        force: [0.0, 0.0, sign],
        moment: [0.0; 3],
        time: TimeFunction::Sine { amplitude: 3.0, omega: 2.0, phase: 0.5, start: 0.0, end: f64::MAX },
    };
    let loads = model.prepare(&case(vec![couple(2, 1.0), couple(3, -1.0)])).unwrap();
    let fine = {
        let mut simulation =
            Simulation::new(Arc::new(model.clone()), settings(Integrator::Rk4, 1e-4)).unwrap();
        for _ in 0..20_000 {
            simulation.step(&loads).unwrap();
        }
        Vector3::from(simulation.ledger().angular_momentum_g)
    };
    for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
        let mut errors = Vec::new();
        for dt in [0.02, 0.01] {
            let mut simulation = Simulation::new(Arc::new(model.clone()), settings(integrator, dt)).unwrap();
            let start = simulation.ledger().r_cm_g;
            for _ in 0..(2.0 / dt).round() as usize {
                simulation.step(&loads).unwrap();
            }
            assert!((Vector3::from(simulation.ledger().r_cm_g) - Vector3::from(start)).norm() < 1e-13);
            errors.push((Vector3::from(simulation.ledger().angular_momentum_g) - fine).norm());
        }
        let slope = (errors[0] / errors[1]).log2();
        assert!((slope - 2.0).abs() < 0.1, "{integrator}: {errors:?}, order {slope}");
    }
}
