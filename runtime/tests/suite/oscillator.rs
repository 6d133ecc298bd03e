//! Elastic models with a closed solution.

use std::sync::Arc;

use crate::common::Lumped;
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Load, LoadCase, LoadFrame, Model, Settings, Simulation};

const M1: f64 = 6.0;
const M2: f64 = 2.0;
const STIFFNESS: f64 = 40.0;
const FORCE: f64 = 5.0;

fn force_on_second_mass(model: &Model) -> rom_runtime::PreparedLoads {
    // The last mass is the one on the spring; its point carries no offset here.
    let load = Load {
        point: model.n_points() as u32 - 1,
        frame: LoadFrame::Dead,
        force: [FORCE, 0.0, 0.0],
        moment: [0.0; 3],
        time: TimeFunction::Constant { value: 1.0 },
    };
    let case = LoadCase { dt: 0.01, loads: vec![load], ..LoadCase::empty("pull") };
    model.prepare(&case).unwrap()
}

fn spring(damping_ratio: f64) -> Model {
    let mut lumped = Lumped::spring(M1, M2, STIFFNESS);
    lumped.plain_points = true;
    lumped.damping_ratio = damping_ratio;
    Model::new(lumped.data(3)).unwrap()
}

/// Elongation and position of the first mass at time t, both from rest: `mu x_ddot + c x_dot + k x = mu F/m2`.
fn exact(ratio: f64, t: f64) -> (f64, f64) {
    let mu = M1 * M2 / (M1 + M2);
    let omega = (STIFFNESS / mu).sqrt();
    let damped = omega * (1.0 - ratio * ratio).sqrt();
    let decay = (-ratio * omega * t).exp();
    let x = FORCE * mu / (M2 * STIFFNESS)
        * (1.0 - decay * ((damped * t).cos() + ratio * omega / damped * (damped * t).sin()));
    let centre = FORCE * t * t / (2.0 * (M1 + M2));
    (x, centre - M2 * x / (M1 + M2))
}

#[test]
fn two_masses_on_a_spring_follow_the_closed_solution() {
    for ratio in [0.0, 0.2] {
        let model = Arc::new(spring(ratio));
        let mu = M1 * M2 / (M1 + M2);
        assert!((model.data().modes.omega[0] - (STIFFNESS / mu).sqrt()).abs() < 1e-12);
        let loads = force_on_second_mass(&model);
        let tip = model.n_points() - 1;
        for (integrator, order) in
            [(Integrator::Newmark, 2.0), (Integrator::GeneralizedAlpha, 2.0), (Integrator::Rk4, 4.0)]
        {
            let mut errors = Vec::new();
            for steps in [400, 800] {
                let settings = Settings { dt: 4.0 / f64::from(steps), integrator, ..Settings::default() };
                let mut simulation = Simulation::new(model.clone(), settings).unwrap();
                for _ in 0..steps {
                    simulation.step(&loads).unwrap();
                }
                let (elongation, position) = exact(ratio, 4.0);
                let out = simulation.point_output(tip).unwrap();
                let found = (out.dr_a[0], simulation.rigid_output().r_g[0]);
                errors.push((found.0 - elongation).abs().max((found.1 - position).abs()));
                // Along a line: nothing else moves.
                assert!(simulation.rigid_output().r_g[1..].iter().all(|x| x.abs() < 1e-12));
                // The centre of mass is a particle, whatever the spring does: exactly so for Newmark and RK4.
                let centre = simulation.ledger().r_cm_g[0] - (3.0 * M2) / (M1 + M2);
                assert!((centre - FORCE).abs() < 1e-4, "{integrator}: centre of mass {centre}");
            }
            let slope = (errors[0] / errors[1]).log2();
            assert!(
                errors[0] < 2e-3 && (slope - order).abs() < 0.2,
                "{integrator}: {errors:?}, order {slope}"
            );
        }
    }
}

#[test]
fn free_vibration_keeps_its_energy() {
    let model = Arc::new(spring(0.0));
    let loads = model.no_loads();
    for (integrator, damping, limit) in [
        // The trapezoidal rule conserves a quadratic energy exactly; 2000 steps of round-off.
        (Integrator::Newmark, 0.0, 1e-11),
        (Integrator::GeneralizedAlpha, 0.0, 1e-3),
        (Integrator::Rk4, 0.0, 1e-5),
    ] {
        let settings = Settings { dt: 0.01, integrator, numerical_damping: damping, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        let mut state = simulation.state().clone();
        state.q[0] = 0.3;
        simulation.restore(&state).unwrap();
        let start = simulation.ledger().elastic_energy;
        for _ in 0..2000 {
            simulation.step(&loads).unwrap();
            let now = simulation.ledger();
            let change = (now.elastic_energy + now.kinetic_energy) / start - 1.0;
            assert!(change.abs() < limit, "{integrator}: {change:e}");
        }
    }
}

#[test]
fn numerical_damping_removes_unresolved_vibration_and_spares_slow_motion() {
    // omega dt = 52: generalised-alpha with a = 1 (rho_inf = 0) removes it within some steps; Newmark damps it too.
    let model = Arc::new(spring(0.0));
    let loads = model.no_loads();
    for (integrator, numerical_damping, steps) in [
        (Integrator::GeneralizedAlpha, 1.0, 10),
        (Integrator::GeneralizedAlpha, 0.2, 60),
        (Integrator::Newmark, 0.2, 60),
    ] {
        let settings = Settings { dt: 10.0, integrator, numerical_damping, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        let mut state = simulation.state().clone();
        state.q[0] = 0.3;
        simulation.restore(&state).unwrap();
        for _ in 0..steps {
            simulation.step(&loads).unwrap();
        }
        let left = simulation.state().q[0].abs();
        assert!(left < 1e-6, "{integrator} a = {numerical_damping}: {left:e} left");
    }
}
