//! Reduced models about a loaded equilibrium: they stay in it, and they move about it as the nonlinear structure does.

use std::sync::Arc;

use nalgebra::{Vector3, Vector6};
use rom_runtime::data::ModelData;
use rom_runtime::loads::{Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Method, Model, Settings, Simulation};

use super::tests::load;
use super::{Equilibrium, EquilibriumSettings, solve};
use crate::build::{BuildError, BuildOptions, ModeSelection, build_about, build_mesh};
use crate::configuration::Configuration;
use crate::mesh::Mesh;
use crate::reference::nonlinear::Nonlinear;
use crate::reference::scheme::{Family, Scheme};
use crate::test_structures::case;
use crate::test_structures::{fmb, provenance};

/// The frame lifted at its arms' tips by more than a metre, with loads of all frames, in balance with itself.
fn lifted() -> (Mesh, LoadCase, Equilibrium) {
    let mesh = fmb(1.0, 60, 2);
    let (f, none) = (Vector3::new(0.0, 10.0, 200.0), Vector3::zeros());
    let e = mesh.points[2].sections[0].1;
    let section = std::array::from_fn(|i| std::array::from_fn(|j| e[(i, j)]));
    let follow = LoadFrame::Follower { section };
    // In drawing axes: opposite moments on the two tips, each with its own arm's section frame.
    let turn = |sign: f64| (e.transpose() * Vector3::new(0.0, -300.0 * sign, 0.0), none);
    let mut trim = case(vec![
        load(2, LoadFrame::Dead, f, none),
        load(4, LoadFrame::Dead, f, none),
        load(2, follow, none, turn(1.0).0),
        load(4, follow, none, turn(-1.0).0),
        load(0, LoadFrame::Body, none, none),
    ]);
    let first = solve(&mesh, &trim, &EquilibriumSettings::default()).unwrap();
    trim.loads[4].force = first.reaction_force.into();
    trim.loads[4].moment = first.reaction_moment.into();
    let found = solve(&mesh, &trim, &EquilibriumSettings::default()).unwrap();
    assert!(found.self_balance().within(1e-12), "{:?}", found.self_balance());
    assert!((found.configuration.positions[2] - mesh.nodes[2]).norm() > 1.0);
    (mesh, trim, found)
}

fn options(modes: usize) -> BuildOptions {
    BuildOptions { modes: ModeSelection::Count(modes), all_nodes: false, ..BuildOptions::default() }
}

fn about(mesh: &Mesh, equilibrium: &Equilibrium, modes: usize) -> ModelData {
    build_about(mesh, equilibrium, provenance(), &options(modes), &mut |_| {}).unwrap()
}

#[test]
fn without_another_load_nothing_moves() {
    let (mesh, _, equilibrium) = lifted();
    let data = about(&mesh, &equilibrium, 12);
    assert!(data.checks.iter().all(|c| c.value <= c.limit), "{:?}", data.checks);
    let bytes = data.to_bytes().unwrap();
    assert_eq!(ModelData::from_bytes(&bytes).unwrap(), data, "the file keeps the equilibrium");
    let model = Arc::new(Model::new(data).unwrap());
    let simple = |method| Arc::new(model.with_method(method).unwrap());
    for (model, integrator) in [
        (model.clone(), Integrator::Newmark),
        (model.clone(), Integrator::GeneralizedAlpha),
        (model.clone(), Integrator::Rk4),
        (simple(Method::MeanAxes), Integrator::Newmark),
        (simple(Method::Rigid), Integrator::Newmark),
    ] {
        let loads = model.prepare(&case(Vec::new())).unwrap();
        let settings = Settings { dt: 2e-3, integrator, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        let start: Vec<_> = (0..5).map(|p| simulation.point_output(p).unwrap().r_g).collect();
        for _ in 0..500 {
            simulation.step(&loads).unwrap();
        }
        for (p, start) in start.iter().enumerate() {
            let now = simulation.point_output(p).unwrap();
            let moved = (Vector3::from(now.r_g) - Vector3::from(*start)).norm();
            // Round-off of the loads (1e-13 of 600 N) on 405 kg and on the softest mode (1/omega^2 = 3 s^2).
            assert!(moved < 1e-10, "{integrator:?} {p}: {moved:.1e}");
            assert!(Vector3::from(now.dr_a).norm() < 1e-10, "{integrator:?} {p}");
        }
        if model.data().modes.omega.len() == 12 {
            let stored = simulation.model().ledger(simulation.state()).elastic_energy;
            assert!((stored - equilibrium.energy).abs() < 1e-8 * equilibrium.energy);
        }
    }
}

/// Displacement in A of the right arm's tip (point 2) at every step of the nonlinear dynamics.
fn nonlinear(mesh: &Mesh, at: &Configuration, case: &LoadCase, dt: f64, steps: usize) -> Vec<Vector3<f64>> {
    let mut run = Nonlinear::new(mesh, at, case, Scheme::new(Family::Newmark, dt, 0.0)).unwrap();
    (0..steps)
        .map(|_| {
            run.step().unwrap();
            let frame = run.motion().frame(mesh.reference);
            frame.rotation.inverse() * (run.motion().position[2] - frame.position) - at.positions[2]
        })
        .collect()
}

fn reduced(data: ModelData, case: &LoadCase, dt: f64, steps: usize) -> Vec<Vector3<f64>> {
    let model = Arc::new(Model::new(data).unwrap());
    let loads = model.prepare(case).unwrap();
    let mut simulation = Simulation::new(model, Settings { dt, ..Settings::default() }).unwrap();
    (0..steps)
        .map(|_| {
            simulation.step(&loads).unwrap();
            simulation.point_output(2).unwrap().dr_a.into()
        })
        .collect()
}

/// Largest difference over time, relative to the largest value.
fn error(found: &[Vector3<f64>], reference: &[Vector3<f64>]) -> f64 {
    let largest = |d: &mut dyn Iterator<Item = f64>| d.fold(0.0, f64::max);
    largest(&mut found.iter().zip(reference).map(|(a, b)| (a - b).norm()))
        / largest(&mut reference.iter().map(|b| b.norm()))
}

#[test]
fn a_small_gust_moves_it_as_it_moves_the_nonlinear_structure() {
    let (mesh, trim, equilibrium) = lifted();
    let (dt, steps) = (0.01, 200);
    let gust = Load {
        time: TimeFunction::OneMinusCosine { amplitude: 1.0, start: 0.0, duration: 1.0 },
        ..load(2, LoadFrame::Dead, Vector3::new(0.3, 0.5, 1.0), Vector3::zeros())
    };
    let together = case(trim.loads.iter().cloned().chain([gust.clone()]).collect());
    let reference = nonlinear(&mesh, &equilibrium.configuration, &together, dt, steps);
    let trimmed = |modes| {
        let data = about(&mesh, &equilibrium, modes);
        error(&reduced(data, &case(vec![gust.clone()]), dt, steps), &reference)
    };
    let drawn = build_mesh(&mesh, provenance(), &options(20), &mut |_| {}).unwrap();
    let about_drawing = error(&reduced(drawn, &case(vec![gust.clone()]), dt, steps), &reference);
    let (few, many) = (trimmed(20), trimmed(120));
    println!(
        "error about the equilibrium {few:.2e} with 20 modes, {many:.2e} with 120, about the drawing {about_drawing:.2e}"
    );
    assert!(about_drawing > 10.0 * few, "{about_drawing} {few}");
    // All that is left is the modes left out, with local loads some 1/m^2 (the motion is a few centimetres on ten metres): the model is
    // exact to first order, load stiffness included.
    assert!(few < 0.03 && many < 2e-3, "{few} {many}");
}

#[test]
fn what_does_not_fly_is_told() {
    let mesh = fmb(1.0, 60, 2);
    let hang = case(vec![load(2, LoadFrame::Dead, Vector3::new(0.0, 0.0, -50.0), Vector3::zeros())]);
    let held = solve(&mesh, &hang, &EquilibriumSettings::default()).unwrap();
    let data = about(&mesh, &held, 3);
    let missing: Vec<_> = data.checks.iter().filter(|c| c.value > c.limit).collect();
    assert_eq!(missing.len(), 2, "{missing:?}");
    assert!(missing.iter().all(|c| c.name.starts_with("equilibrium:") && c.value > 0.5));

    let beta = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.3);
    let turning =
        solve(&mesh, &case(Vec::new()), &EquilibriumSettings { beta, ..Default::default() }).unwrap();
    let refused = build_about(&mesh, &turning, provenance(), &options(3), &mut |_| {}).unwrap_err();
    assert_eq!(refused, BuildError::Turning([0.0, 0.0, 0.3]));
}
