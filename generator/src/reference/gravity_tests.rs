//! Gravity and trimmed flight in every method.

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3, Vector6};
use rom_runtime::loads::{Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Model, State, StateRate, Workspace};

use super::method::{Method, Prepared, Run, RunSettings, start_reduced};
use crate::assembly::Assembly;
use crate::build::{BuildError, BuildOptions, ModeSelection, build_mesh};
use crate::configuration::Configuration;
use crate::element::internal_force::{split, stack};
use crate::element::tests::Random;
use crate::equilibrium::trim::{About, Component, Trim, Unknown, WhenUnbalanced, of_mesh};
use crate::equilibrium::{EquilibriumError, EquilibriumSettings};
use crate::math::so3::{MatrixFunction, exp_quaternion};
use crate::mesh::{LumpedMass, Mesh};
use crate::test_structures::{case, crooked_body, fmb, provenance};

fn load(point: u32, frame: LoadFrame, force: [f64; 3], moment: [f64; 3]) -> Load {
    Load { point, frame, force, moment, time: TimeFunction::Constant { value: 1.0 } }
}

fn model(mesh: &Mesh, modes: usize) -> Arc<Model> {
    let options =
        BuildOptions { modes: ModeSelection::Count(modes), all_nodes: false, ..BuildOptions::default() };
    Arc::new(Model::new(build_mesh(mesh, provenance(), &options, &mut |_| ()).unwrap()).unwrap())
}

/// A run of each method, with each of its integrators.
fn every_run(mesh: &Mesh, case: &LoadCase, dt: f64, mut see: impl FnMut(Method, &mut dyn Run)) {
    let prepared = Prepared::about(mesh.clone(), of_mesh(mesh).unwrap());
    let model = model(mesh, 8);
    for method in Method::ALL {
        for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha, Integrator::Rk4] {
            let settings = RunSettings { dt, integrator, numerical_damping: 0.0 };
            if method.is_reduced() {
                see(method, &mut *start_reduced(&model, method, case, &settings).unwrap());
            } else if integrator != Integrator::Rk4 {
                see(method, &mut *prepared.start(method, case, &settings).unwrap());
            }
        }
    }
}

/// However crooked a body and wherever its masses sit, it falls without a tremor: `g t^2/2` is what every integrator has exact.
#[test]
fn free_fall_excites_nothing() {
    let g = Vector3::new(1.3, -0.7, -9.6);
    for n_nodes in [2, 3] {
        let mesh = Mesh { gravity: g, ..crooked_body(n_nodes) };
        let (dt, steps) = (0.01, 50);
        every_run(&mesh, &case(Vec::new()), dt, |method, run| {
            let start = run.output().totals;
            for _ in 0..steps {
                run.step().unwrap();
            }
            let (end, t) = (run.output(), dt * f64::from(steps));
            let fallen = end.totals.centre_of_mass - start.centre_of_mass;
            // Newton's iteration of the finite elements stops at corrections of 1e-10 of the size (3 m).
            assert!((fallen - g * (0.5 * t * t)).norm() < 1e-9, "{method}: {fallen}");
            assert!((end.frame.velocity - g * t).norm() < 1e-8, "{method}: {}", end.frame.velocity);
            assert!(end.frame.spin.norm() < 1e-8, "{method}: {}", end.frame.spin);
            assert!(end.dr_a.iter().all(|d| d.norm() < 1e-9), "{method}: {:?}", end.dr_a);
            let change = |a: f64, b: f64| a - b;
            let energy = change(end.totals.kinetic_energy, start.kinetic_energy)
                + change(end.totals.gravity_energy, start.gravity_energy);
            assert!(energy.abs() < 1e-8 * end.totals.kinetic_energy, "{method}: {energy}");
        });
    }
}

/// The frame with an eccentric mass on each arm.
fn frame() -> Mesh {
    let mut mesh = fmb(2.0, 30, 2);
    mesh.gravity = Vector3::new(0.0, 0.0, -9.81);
    let mut random = Random::new(4);
    let mass = random.body() * 5.0;
    mesh.lumped.extend([2, 4].map(|node| LumpedMass { node, mass }));
    mesh
}

/// Lift at the tips, a thrust-like load at the middle and moments that are solved for, in an attitude of its own.
fn trimmed(attitude: UnitQuaternion<f64>, lift: LoadFrame) -> Mesh {
    let up = [0.0, 0.0, 1000.0];
    let loads = vec![
        load(2, lift, up, [0.0; 3]),
        load(4, lift, up, [0.0; 3]),
        load(0, LoadFrame::Dead, [100.0, 0.0, 0.0], [0.0; 3]),
        load(0, LoadFrame::Dead, [0.0, 100.0, 0.0], [0.0; 3]),
        load(1, LoadFrame::Body, [0.0; 3], [100.0, 0.0, 0.0]),
        load(1, LoadFrame::Body, [0.0; 3], [0.0, 100.0, 0.0]),
        load(3, LoadFrame::Body, [0.0; 3], [0.0, 0.0, 100.0]),
    ];
    let names = ["lift", "lift", "drag", "side", "roll", "pitch", "yaw"].map(String::from).to_vec();
    let wanted = [("drag", 0), ("side", 1), ("lift", 2), ("roll", 3), ("pitch", 4), ("yaw", 5)];
    let unknown = |(load, index): (&str, usize)| Unknown {
        load: load.into(),
        component: Component { index, inertial: index < 3 },
    };
    let settings = EquilibriumSettings { attitude, ..EquilibriumSettings::default() };
    let trim = Trim {
        case: case(loads),
        names,
        settings,
        balance: wanted.map(unknown).to_vec(),
        when_unbalanced: WhenUnbalanced::Refuse,
        about: About::Equilibrium,
    };
    Mesh { trim: Some(trim), ..frame() }
}

fn attitude() -> UnitQuaternion<f64> {
    exp_quaternion(&Vector3::new(0.4, -0.3, 0.8))
}

#[test]
fn factors_balance_the_body() {
    for (attitude, lift) in [
        (UnitQuaternion::identity(), LoadFrame::Dead),
        (attitude(), LoadFrame::Dead),
        (attitude(), LoadFrame::Body),
        (attitude(), LoadFrame::Follower { section: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }),
    ] {
        let mesh = trimmed(attitude, lift);
        let found = of_mesh(&mesh).unwrap().unwrap();
        let balance = found.self_balance();
        // Round-off of section forces: 1e9 N of EA times a strain's rounding of 2.2e-16, a few times, over 20 kN of loads.
        assert!(balance.within(5e-11), "{lift:?} {balance:?}");
        let bent = (found.configuration.positions[2] - mesh.nodes[2]).norm();
        assert!(bent > 0.3, "{lift:?}: a deflection to speak of, not {bent}");
        if lift == LoadFrame::Dead {
            // The lift carries the weight and nothing else does.
            let (mass, _) = Prepared::new(mesh).rigid_mass();
            let factor = found.factors.iter().find(|(name, _)| name == "lift").unwrap().1;
            assert!((factor * 2000.0 / (mass * 9.81) - 1.0).abs() < 1e-10, "{factor}");
        }
    }
}

/// No change of load, no motion: to round-off in the methods that are linear about the equilibrium, to the tolerance of its
/// iteration in the others.
#[test]
fn trimmed_flight_stays() {
    for (attitude, lift) in [(UnitQuaternion::identity(), LoadFrame::Dead), (attitude(), LoadFrame::Body)] {
        let mesh = trimmed(attitude, lift);
        every_run(&mesh, &case(Vec::new()), 2e-3, |method, run| {
            let start = run.output();
            assert!((start.frame.rotation.angle_to(&attitude)) < 1e-14);
            for _ in 0..250 {
                run.step().unwrap();
            }
            let end = run.output();
            // Half a second: round-off of 1e-11 of the loads (4 g) makes 1e-10 m, and some more where modes are excited.
            let limit = if matches!(method, Method::Nonlinear | Method::ConstantMass) { 1e-8 } else { 1e-9 };
            for (moved, (a, b)) in end.dr_a.iter().zip(end.r_g.iter().zip(&start.r_g)) {
                assert!(moved.norm() < limit && (a - b).norm() < limit, "{method}: {moved} {}", a - b);
            }
            let energies = (end.totals.elastic_energy, start.totals.elastic_energy);
            assert!((energies.0 / energies.1 - 1.0).abs() < 1e-7 || method == Method::Rigid, "{method}");
        });
    }
}

/// Weight of the displaced finite elements in the coordinates of the reduced model.
fn projected_weight(mesh: &Mesh, model: &Model, q: &[f64]) -> Vec<f64> {
    let assembly = Assembly::new(mesh);
    let at = Configuration::drawing(mesh);
    let modes = crate::reduce::modes::elastic_modes(
        &assembly,
        &at,
        &assembly.mass(&at),
        &assembly.stiffness(&at),
        q.len(),
    )
    .unwrap();
    let mut now = at.clone();
    let mut theta = vec![Vector3::zeros(); mesh.nodes.len()];
    for node in 0..mesh.nodes.len() {
        let x: Vector6<f64> = modes.at_node(node).iter().zip(q).map(|(phi, q)| phi * *q).sum();
        let (r, turn) = split(&x);
        now.positions[node] += r;
        now.rotations[node] *= exp_quaternion(&turn);
        theta[node] = turn;
    }
    let mut elastic = vec![0.0; q.len()];
    let mut rigid = Vector6::zeros();
    assembly.visit_weight(&now, &mesh.gravity, &mut |node, weight| {
        let (f, m) = split(&weight);
        let structural = stack(&f, &MatrixFunction::tangential(&theta[node]).matrix().tr_mul(&m));
        for (sum, phi) in elastic.iter_mut().zip(modes.at_node(node)) {
            *sum += phi.dot(&structural);
        }
        rigid += stack(&f, &(now.positions[node].cross(&f) + now.rotations[node] * m));
    });
    for (i, sum) in elastic.iter_mut().enumerate() {
        let phi_r = &model.data().modes.phi_r;
        *sum += (0..6).map(|r| phi_r[r * q.len() + i] * rigid[r]).sum::<f64>();
    }
    elastic.into_iter().chain(rigid.iter().copied()).collect()
}

/// The reduced weight agrees with that of the displaced finite elements to second order: the difference of the elastic rows falls
/// with the square of the amplitudes, that of the moment, whose potential is kept to that order, with the cube.
#[test]
fn reduced_weight_is_the_derivative_of_the_potential() {
    let mesh = Mesh { gravity: Vector3::new(3.0, -5.0, -8.0), ..crooked_body(3) };
    let m = 6;
    let model = model(&mesh, m);
    assert!(!model.data().gravity.as_ref().unwrap().second_moment.is_empty());
    let mut random = Random::new(3);
    let direction: Vec<f64> = (0..m).map(|_| random.next()).collect();
    let difference = |size: f64| -> (f64, f64) {
        let q: Vec<f64> = direction.iter().map(|d| d * size).collect();
        let state = State { q: q.clone(), ..State::at_rest(&model) };
        let (mut work, mut rate) = (Workspace::new(&model), StateRate::new(&model));
        let mut accelerations = |gravity: [f64; 3]| {
            work.set_gravity(gravity);
            model.derivatives(&state, &model.no_loads(), &mut work, &mut rate).unwrap();
            rate.u_dot.clone()
        };
        let (with, without) = (accelerations(mesh.gravity.into()), accelerations([0.0; 3]));
        let change: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
        let rigid_mass = nalgebra::Matrix6::from_row_slice(&model.data().rigid.mass_matrix);
        let rigid = rigid_mass * Vector6::from_column_slice(&change[m..]);
        let expected = projected_weight(&mesh, &model, &q);
        let elastic = (0..m).map(|i| (change[i] - expected[i]).abs()).fold(0.0, f64::max);
        (elastic, (rigid - Vector6::from_column_slice(&expected[m..])).amax())
    };
    let (at_rest, _) = difference(0.0);
    assert!(at_rest < 1e-11, "{at_rest}");
    let ((elastic, rigid), (elastic_half, rigid_half)) = (difference(0.1), difference(0.05));
    let (of_elastic, of_rigid) = (elastic / elastic_half, rigid / rigid_half);
    assert!(elastic > 1e-4 && (3.5..4.5).contains(&of_elastic), "{elastic} {of_elastic}");
    assert!(rigid > 1e-6 && (7.0..9.0).contains(&of_rigid), "{rigid} {of_rigid}");
}

/// A cantilever under its own weight, `w L^4/8EI + w L^2/2GA`, in an attitude in which it hangs sideways in the drawing.
#[test]
fn a_beam_sags_under_its_weight() {
    let (length, ei, ga, rho_a) = (5.0, 2.0 * 72_916.666_666_666_67, 2.0 * 1.121_794_871_794_872e8, 13.5);
    let mesh = fmb(2.0, 120, 2);
    let turn = exp_quaternion(&Vector3::new(0.3, 0.5, -0.2));
    // Small enough to be linear: across the arm (along x of A).
    let g = turn * Vector3::new(1e-3, 0.0, 0.0);
    let mut arm = mesh.clone();
    arm.gravity = g;
    arm.reference = 1;
    let settings = EquilibriumSettings { attitude: turn, ..EquilibriumSettings::default() };
    let found = crate::equilibrium::solve(&arm, &case(Vec::new()), &settings).unwrap();
    let tip = found.configuration.positions[2] - arm.nodes[2];
    let w = rho_a * 1e-3;
    let exact = w * f64::powi(length, 4) / (8.0 * ei) + w * length * length / (2.0 * ga);
    // Twenty linear elements: (1/20)^2 of the curvature's share, a quarter of a per cent at most.
    assert!((tip.x / exact - 1.0).abs() < 2.5e-3 && tip.yz().norm() < 1e-3 * exact, "{tip} {exact}");
    let total = w * 30.0;
    // Round-off of section forces: EA = 7e8 N times 1e-16 of 10 m over an element.
    assert!(
        (found.reaction_force - Vector3::new(-total, 0.0, 0.0)).norm() < 1e-5,
        "{}",
        found.reaction_force
    );
}

#[test]
fn what_cannot_be_balanced_is_told() {
    let refused = |change: &dyn Fn(&mut Trim)| {
        let mut mesh = trimmed(attitude(), LoadFrame::Dead);
        change(mesh.trim.as_mut().unwrap());
        of_mesh(&mesh).unwrap_err()
    };
    let message = |change: &dyn Fn(&mut Trim)| refused(change).to_string();
    // The moments have no effect on forces.
    let lost = message(&|trim| {
        trim.balance.truncate(4);
        trim.balance.swap_remove(2);
        trim.balance[2].component = Component { index: 2, inertial: true };
    });
    assert!(lost.contains("`roll` have no effect on"), "{lost}");
    // Two forces at the middle along the same line.
    let same = message(&|trim| {
        trim.case.loads[3].force = [50.0, 0.0, 0.0];
    });
    assert!(
        same.contains("has an effect on the force along y of G") || same.contains("cannot be told apart"),
        "{same}"
    );
    let held = refused(&|trim| trim.balance.clear());
    assert!(matches!(held, EquilibriumError::Unbalanced { force, .. } if force > 1000.0), "{held}");
    // Accepted, the model says so and moves.
    let mut mesh = trimmed(attitude(), LoadFrame::Dead);
    let trim = mesh.trim.as_mut().unwrap();
    trim.balance.clear();
    trim.when_unbalanced = WhenUnbalanced::Warn;
    let model = model(&mesh, 2);
    assert!(model.data().checks.iter().all(|c| c.value <= c.limit));
    assert!(model.data().trim.as_ref().unwrap().reaction[2].abs() > 1000.0);
    let turning = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    mesh.trim.as_mut().unwrap().settings.beta = turning;
    mesh.trim.as_mut().unwrap().case.loads.clear();
    mesh.trim.as_mut().unwrap().names.clear();
    let options = BuildOptions::default();
    let refused = build_mesh(&mesh, provenance(), &options, &mut |_| ()).unwrap_err();
    assert_eq!(refused, BuildError::Equilibrium(EquilibriumError::GravityInTurn));
}
