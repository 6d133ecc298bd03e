//! Exact properties of the reference methods.

use std::sync::Arc;

use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use rom_runtime::loads::{DistributedFrame, DistributedLoad, Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Model};

use super::floating::{Forces, Rows};
use super::linear::LinearForces;
use super::method::{Method, Output, Prepared, Run, RunSettings, start_reduced};
use super::motion::Motion;
use super::nonlinear::{Nonlinear, NonlinearError};
use super::scheme::{Family, Scheme};
use crate::assembly::AnyBeam;
use crate::build::{BuildOptions, ModeSelection, build_mesh};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::gyroscopic::{ElementGyroscopic, gyroscopic};
use crate::element::internal_force::strain;
use crate::element::rotation_field::RotationField;
use crate::element::tests::Random;
use crate::mesh::{Mesh, Place};
use crate::test_structures::{case, crooked, fmb, provenance};

fn load(point: u32, frame: LoadFrame, force: [f64; 3], moment: [f64; 3], time: TimeFunction) -> Load {
    Load { point, frame, force, moment, time }
}

/// A smooth pulse that is over after 1 s.
fn pulse(amplitude: f64) -> TimeFunction {
    TimeFunction::OneMinusCosine { amplitude, start: 0.0, duration: 1.0 }
}

fn settings(dt: f64) -> RunSettings {
    RunSettings { dt, integrator: Integrator::Newmark, numerical_damping: 0.0 }
}

fn march(run: &mut dyn Run, steps: usize) -> Output {
    for _ in 0..steps {
        run.step().unwrap();
    }
    run.output()
}

fn sum_blocks<const N: usize>(
    g: &ElementGyroscopic<N>,
    nodes: [Option<usize>; N],
    x: &[Vector6<f64>],
    x_dot: &[Vector6<f64>],
    beta: &Vector6<f64>,
    out: &mut Rows,
) {
    let at = |v: &[Vector6<f64>], n: Option<usize>| n.map_or_else(Vector6::zeros, |i| v[i]);
    for a in 0..N {
        out.r += g.c_rs[a] * at(x_dot, nodes[a]) + g.k_r[a] * at(x, nodes[a]);
        let Some(i) = nodes[a] else { continue };
        out.s[i] += g.c_sr[a] * beta;
        for b in 0..N {
            out.s[i] += g.c_ss[a][b] * at(x_dot, nodes[b]) + g.k_s[a][b] * at(x, nodes[b]);
        }
    }
    out.r += g.c_rr * beta;
}

/// The linear method applies the operators of theory section 3 without forming them.
#[test]
fn linear_forces_are_the_operators_applied() {
    for n_nodes in [2, 3] {
        let mut mesh = crooked(n_nodes);
        mesh.lumped.clear();
        let prepared = Prepared::new(mesh);
        let mut random = Random::new(21);
        let n = prepared.assembly.n_blocks();
        let mut vectors = || (0..n).map(|_| random.vector6()).collect::<Vec<_>>();
        let (x, x_dot) = (vectors(), vectors());
        let beta = random.vector6();
        let mut expected = Rows::zeros(n);
        for beam in &prepared.assembly.beams {
            let block = |node: usize| prepared.assembly.unknown[node];
            match beam {
                AnyBeam::Two(b) => {
                    let g = gyroscopic(b, &prepared.at.of(b), &beta);
                    sum_blocks(&g, b.nodes.map(block), &x, &x_dot, &beta, &mut expected);
                }
                AnyBeam::Three(b) => {
                    let g = gyroscopic(b, &prepared.at.of(b), &beta);
                    sum_blocks(&g, b.nodes.map(block), &x, &x_dot, &beta, &mut expected);
                }
            }
        }
        let mut ours = Rows::zeros(n);
        LinearForces::new(&prepared).add_gyroscopic(&x, &x_dot, &beta, &mut ours);
        let scale = expected.s.iter().map(|f| f.amax()).fold(expected.r.amax(), f64::max);
        for (a, b) in ours.s.iter().zip(&expected.s) {
            assert!((a - b).amax() < 1e-13 * scale);
        }
        assert!((ours.r - expected.r).amax() < 1e-13 * scale);
    }
}

/// Linear forces are the derivative of the nonlinear ones at the equilibrium: the difference falls with the square of the
/// displacement.
#[test]
fn linear_forces_touch_the_nonlinear_ones() {
    let prepared = Prepared::new(crooked(3));
    let n = prepared.assembly.n_blocks();
    let nonlinear = super::constant_mass::NonlinearForces::new(&prepared);
    let linear = LinearForces::new(&prepared);
    let mut random = Random::new(5);
    let mut vectors = || (0..n).map(|_| random.vector6()).collect::<Vec<_>>();
    let (x, x_dot) = (vectors(), vectors());
    let beta = random.vector6();
    let difference = |size: f64| {
        let scaled = |v: &[Vector6<f64>]| v.iter().map(|x| x * size).collect::<Vec<_>>();
        let (mut a, mut b) = (Rows::zeros(n), Rows::zeros(n));
        nonlinear.add(&scaled(&x), &scaled(&x_dot), &beta, &mut a);
        linear.add(&scaled(&x), &scaled(&x_dot), &beta, &mut b);
        let s = a.s.iter().zip(&b.s).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
        (s, (a.r - b.r).amax())
    };
    let ((s1, r1), (s2, r2)) = (difference(1e-3), difference(1e-4));
    assert!((s1 / s2).log10() > 1.95 && (r1 / r2).log10() > 1.95, "{s1} {s2} {r1} {r2}");
    let (s0, r0) = difference(0.0);
    assert!(s0 < 1e-12 && r0 < 1e-12, "at the equilibrium both are C_SR beta, C_RR beta: {s0} {r0}");
}

/// With every mode the reduced model spans the linear method; what is left is the different time discretisation of frame A,
/// of second order in the step.
#[test]
fn the_reduced_model_with_all_modes_is_the_linear_method() {
    let mut mesh = fmb(10.0, 12, 2);
    mesh.load_cases.clear();
    let loads = case(vec![
        load(2, LoadFrame::Dead, [0.0, 0.0, 300.0], [0.0; 3], pulse(1.0)),
        load(4, LoadFrame::Dead, [0.0, 40.0, -300.0], [0.0, 0.0, 100.0], pulse(1.0)),
        load(2, LoadFrame::Body, [10.0, 20.0, 0.0], [30.0, 0.0, 0.0], pulse(1.0)),
    ]);
    let all = 6 * (mesh.nodes.len() - 1);
    let options =
        BuildOptions { modes: ModeSelection::Count(all), all_nodes: false, ..BuildOptions::default() };
    let data = build_mesh(&mesh, provenance(), &options, &mut |_| ()).unwrap();
    let model = Arc::new(Model::new(data).unwrap());
    let prepared = Prepared::new(mesh);
    let difference = |steps: usize| {
        let s = settings(1.0 / steps as f64);
        let a = march(&mut *prepared.start(Method::Linear, &loads, &s).unwrap(), steps);
        let b = march(&mut *start_reduced(&model, Method::Rom, &loads, &s).unwrap(), steps);
        let tip = (a.dr_a[2] - b.dr_a[2]).norm() / a.dr_a[2].norm();
        let w = (a.frame.spin - b.frame.spin).norm() / a.frame.spin.norm();
        (tip, w)
    };
    let (coarse, fine) = (difference(50), difference(200));
    assert!(fine.0 < 1e-5 && fine.1 < 1e-5, "{fine:?}");
    assert!(coarse.0 / fine.0 > 10.0 && coarse.1 / fine.1 > 10.0, "{coarse:?} {fine:?}");
}

/// A tumbling, vibrating free body.
fn free_motion(mesh: &Mesh) -> Motion {
    let mut motion = Motion::at_rest(mesh, &Configuration::drawing(mesh));
    motion.add_rigid_velocity(mesh.reference, &Vector3::new(0.3, -0.2, 0.5), &Vector3::new(0.4, 0.9, -0.6));
    let mut random = Random::new(33);
    for v in &mut motion.velocity {
        *v += random.vector3(0.2);
    }
    motion
}

fn free_run(mesh: &Mesh, family: Family, dt: f64, a: f64, t: f64) -> [super::nonlinear::Totals; 2] {
    let scheme = Scheme::new(family, dt, a);
    let mut run = Nonlinear::from_motion(mesh, free_motion(mesh), &case(Vec::new()), scheme).unwrap();
    let start = run.totals();
    for _ in 0..(t / dt).round() as usize {
        run.step().unwrap();
    }
    [start, run.totals()]
}

/// Without loads momentum, angular momentum and energy drift with the square of the step. (Linear momentum is exact where
/// sections and masses have no offset, see below; here they have, and masses that no solid has.)
#[test]
fn a_free_body_keeps_momentum_and_energy() {
    let mesh = crooked(2);
    let drift = |dt: f64| {
        let [a, b] = free_run(&mesh, Family::Newmark, dt, 0.0, 0.4);
        let linear = (a.linear_momentum - b.linear_momentum).norm() / a.linear_momentum.norm();
        let e = a.kinetic_energy + a.elastic_energy;
        let energy = (b.kinetic_energy + b.elastic_energy - e).abs() / e;
        let angular = (a.angular_momentum - b.angular_momentum).norm() / a.angular_momentum.norm();
        [energy, angular, linear]
    };
    let (coarse, fine) = (drift(0.004), drift(0.001));
    for (coarse, fine) in coarse.iter().zip(&fine) {
        assert!(*fine < 1e-3 && coarse / fine > 8.0, "{coarse} {fine}");
    }
}

/// Order in the step on a smooth load: two without numerical damping and with generalised-alpha, one with Newmark's damping.
#[test]
fn orders_of_the_integrators() {
    let mesh = fmb(1.0, 12, 2);
    let loads = case(vec![
        load(2, LoadFrame::Dead, [0.0, 0.0, 2000.0], [0.0; 3], pulse(1.0)),
        load(
            4,
            LoadFrame::Follower { section: [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]] },
            [0.0; 3],
            [0.0, 1000.0, 0.0],
            pulse(1.0),
        ),
        load(2, LoadFrame::Body, [0.0, 500.0, 0.0], [0.0; 3], pulse(1.0)),
    ]);
    let end = |family, a, steps: usize| {
        let scheme = Scheme::new(family, 1.0 / steps as f64, a);
        let mut run = Nonlinear::new(&mesh, &Configuration::drawing(&mesh), &loads, scheme).unwrap();
        for _ in 0..steps {
            run.step().unwrap();
        }
        run.motion().position[2]
    };
    let exact = end(Family::Newmark, 0.0, 6400);
    for (family, a, order) in
        [(Family::Newmark, 0.0, 2.0), (Family::GeneralizedAlpha, 0.05, 2.0), (Family::Newmark, 0.05, 1.0)]
    {
        let error = |steps| (end(family, a, steps) - exact).norm();
        let observed = (error(200) / error(800)).log2() / 2.0;
        assert!((observed - order).abs() < 0.3, "{family:?} a = {a}: order {observed}");
    }
}

/// Section force and moment at the middle of an element.
fn internal_load(beam: &Beam<2>, motion: &Motion) -> Vector6<f64> {
    let state = motion.of(beam);
    let point = &beam.stiffness_points()[0];
    point.stiffness * strain(&state, &RotationField::new(&state.triads), point)
}

/// A load that jumps inside a step acts from the end of that step on: the impulse is wrong by part of a step, so the order
/// falls to one even without numerical damping.
#[test]
fn a_load_jump_costs_an_order() {
    let mesh = fmb(1.0, 12, 2);
    let end = |t_jump: f64, steps: usize| {
        let step = TimeFunction::Step { value: 1.0, start: t_jump, end: f64::MAX };
        let loads = case(vec![load(2, LoadFrame::Dead, [300.0, 0.0, 800.0], [0.0; 3], step)]);
        let scheme = Scheme::new(Family::Newmark, 1.0 / steps as f64, 0.0);
        let mut run = Nonlinear::new(&mesh, &Configuration::drawing(&mesh), &loads, scheme).unwrap();
        for _ in 0..steps {
            run.step().unwrap();
        }
        // Linear momentum is the impulse, exact but for the jump.
        run.totals().linear_momentum
    };
    // The jump is a third into a step of either grid: at 1/3 s with 100 and 400 steps of 1 s.
    let t_jump = 1.0 / 3.0;
    let impulse = Vector3::new(300.0, 0.0, 800.0) * (1.0 - t_jump);
    let error = |steps| (end(t_jump, steps) - impulse).norm();
    let order = (error(100) / error(400)).log2() / 2.0;
    assert!((order - 1.0).abs() < 0.1, "order {order}");
}

/// Another reference node is another choice of frame: the reduced model changes only within its own error.
#[test]
fn the_reduced_model_changes_with_the_reference_node_within_its_error() {
    let mesh = fmb(10.0, 24, 2);
    let mut other = mesh.clone();
    other.reference = 1;
    other.reference_position = mesh.nodes[1];
    for r in &mut other.nodes {
        *r -= mesh.nodes[1];
    }
    let loads = case(vec![
        load(2, LoadFrame::Dead, [0.0, 0.0, 600.0], [0.0; 3], pulse(1.0)),
        load(4, LoadFrame::Dead, [0.0, 60.0, -600.0], [0.0; 3], pulse(1.0)),
    ]);
    let options =
        BuildOptions { modes: ModeSelection::Count(20), all_nodes: false, ..BuildOptions::default() };
    let tip = |mesh: &Mesh| {
        let model =
            Arc::new(Model::new(build_mesh(mesh, provenance(), &options, &mut |_| ()).unwrap()).unwrap());
        let mut run = start_reduced(&model, Method::Rom, &loads, &settings(0.005)).unwrap();
        march(&mut *run, 200).r_g[2]
    };
    let prepared = Prepared::new(mesh.clone());
    let exact = march(&mut *prepared.start(Method::Nonlinear, &loads, &settings(0.005)).unwrap(), 200).r_g[2];
    let (a, b) = (tip(&mesh), tip(&other));
    let error = (a - exact).norm().max((b - exact).norm());
    assert!(
        (a - b).norm() <= 2.0 * error && error < 0.02 * (exact - mesh.nodes[2]).norm(),
        "{a} {b} {exact}"
    );
}

/// Loads may depend on the motion: a drag on a body, `F = f - c v_x`, gives `v = f/c (1 - exp(-c t/m))`; a spring to the
/// starting point, `F = -k x`, from the same push gives `x = f/k (1 - cos(sqrt(k/m) t))`.
#[test]
fn drag_and_spring() {
    use rom_runtime::expression::{Binary, Instruction, Program, Variable};
    let (mass, push, c) = (405.0, 200.0, 300.0);
    let force_of = |variable| TimeFunction::Expression {
        program: Program {
            source: "push - c * variable".into(),
            code: vec![
                Instruction::Constant(push),
                Instruction::Constant(c),
                Instruction::Variable(variable),
                Instruction::Binary(Binary::Mul),
                Instruction::Binary(Binary::Sub),
            ],
        },
    };
    let mut mesh = fmb(1000.0, 12, 2);
    // Force through the centre of mass, on a body stiff enough to be a particle.
    mesh.points[0].offset = Vector3::new(0.0, 0.0, 2.0 * 5.0 * 2.5 / 30.0);
    let drag = case(vec![load(0, LoadFrame::Dead, [1.0, 0.0, 0.0], [0.0; 3], force_of(Variable::Vx))]);
    let spring = case(vec![load(0, LoadFrame::Dead, [1.0, 0.0, 0.0], [0.0; 3], force_of(Variable::X))]);
    let options =
        BuildOptions { modes: ModeSelection::Count(2), all_nodes: false, ..BuildOptions::default() };
    let data = build_mesh(&mesh, provenance(), &options, &mut |_| ()).unwrap();
    let model = Arc::new(Model::new(data).unwrap());
    let prepared = Prepared::new(mesh);
    for method in [Method::Nonlinear, Method::Rom, Method::MeanAxes, Method::Rigid] {
        let end = |loads| {
            let s = settings(0.005);
            let mut run = if method.is_reduced() {
                start_reduced(&model, method, loads, &s).unwrap()
            } else {
                prepared.start(method, loads, &s).unwrap()
            };
            march(&mut *run, 200).totals
        };
        let v = end(&drag).linear_momentum.x / mass;
        let exact = push / c * (1.0 - (-c / mass).exp());
        assert!((v / exact - 1.0).abs() < 5e-3, "{method}: {v} {exact}");
        let x = end(&spring).centre_of_mass.x;
        let exact = push / c * (1.0 - (c / mass).sqrt().cos());
        assert!((x / exact - 1.0).abs() < 5e-3, "{method}: {x} {exact}");
    }
}

/// Moving the reference node or the whole scene changes nothing physical.
#[test]
fn reference_node_and_scene_do_not_matter() {
    let mesh = fmb(1.0, 12, 2);
    let turn = UnitQuaternion::from_euler_angles(0.4, -1.1, 0.7);
    let (shift, speed) = (Vector3::new(3.0, -2.0, 5.0), Vector3::new(7.0, 1.0, -4.0));
    let loads = |turn: UnitQuaternion<f64>| {
        let dead = |v: [f64; 3]| (turn * Vector3::from(v)).into();
        case(vec![
            load(2, LoadFrame::Dead, dead([0.0, 0.0, 900.0]), [0.0; 3], pulse(1.0)),
            load(1, LoadFrame::Dead, dead([0.0, 90.0, 0.0]), dead([20.0, 0.0, 50.0]), pulse(1.0)),
        ])
    };
    let scheme = Scheme::new(Family::Newmark, 0.01, 0.0);
    let run = |mesh: &Mesh, motion: Motion, loads: &LoadCase| {
        let mut run = Nonlinear::from_motion(mesh, motion, loads, scheme).unwrap();
        for _ in 0..100 {
            run.step().unwrap();
        }
        let motion = run.motion();
        let loads: Vec<Vector6<f64>> = crate::assembly::beams(mesh)
            .iter()
            .map(|beam| match beam {
                AnyBeam::Two(b) => internal_load(b, motion),
                AnyBeam::Three(_) => unreachable!("the frame has two-node elements"),
            })
            .collect();
        (motion.clone(), run.totals(), loads)
    };
    let at_rest = |mesh: &Mesh| Motion::at_rest(mesh, &Configuration::drawing(mesh));
    let (still, totals, forces) = run(&mesh, at_rest(&mesh), &loads(UnitQuaternion::identity()));

    let mut moved = at_rest(&mesh);
    for node in 0..moved.position.len() {
        moved.position[node] = turn * moved.position[node] + shift;
        moved.rotation[node] = turn * moved.rotation[node];
        moved.velocity[node] = speed;
    }
    let (flying, flying_totals, flying_forces) = run(&mesh, moved, &loads(turn));
    for (a, b) in still.position.iter().zip(&flying.position) {
        assert!((turn * a + shift + speed - b).norm() < 1e-8, "{a} {b}");
    }
    for (a, b) in still.velocity.iter().zip(&flying.velocity) {
        assert!((turn * a + speed - b).norm() < 1e-7, "{a} {b}");
    }
    let largest = forces.iter().map(|f| f.amax()).fold(0.0, f64::max);
    let same =
        |other: &[Vector6<f64>]| forces.iter().zip(other).all(|(a, b)| (a - b).amax() < 1e-6 * largest);
    assert!(same(&flying_forces), "section forces and moments");
    assert!((totals.elastic_energy / flying_totals.elastic_energy - 1.0).abs() < 1e-8);

    let mut other = mesh.clone();
    other.reference = 4;
    other.reference_position = mesh.nodes[4];
    for r in &mut other.nodes {
        *r -= mesh.nodes[4];
    }
    let (moved, moved_totals, moved_forces) =
        run(&other, at_rest(&other), &loads(UnitQuaternion::identity()));
    for (a, b) in still.position.iter().zip(&moved.position) {
        assert!((a - b).norm() < 1e-10, "{a} {b}");
    }
    assert!((totals.centre_of_mass - moved_totals.centre_of_mass).norm() < 1e-10);
    assert!(same(&moved_forces), "section forces and moments");
}

/// Tip of the frame after half a second on finer meshes: second order with two nodes, at least third with three.
#[test]
fn mesh_convergence() {
    let loads = case(vec![
        load(2, LoadFrame::Dead, [0.0, 0.0, 4000.0], [0.0; 3], pulse(1.0)),
        load(4, LoadFrame::Dead, [0.0, 500.0, -4000.0], [0.0; 3], pulse(1.0)),
    ]);
    let tip = |elements: usize, n_nodes: usize| {
        let mesh = fmb(1.0, elements, n_nodes);
        let scheme = Scheme::new(Family::Newmark, 0.01, 0.0);
        let mut run = Nonlinear::new(&mesh, &Configuration::drawing(&mesh), &loads, scheme).unwrap();
        for _ in 0..50 {
            run.step().unwrap();
        }
        run.motion().position[2]
    };
    let exact = tip(96, 3);
    let order = |n_nodes| ((tip(12, n_nodes) - exact).norm() / (tip(24, n_nodes) - exact).norm()).log2();
    let (two, three) = (order(2), order(3));
    assert!(two > 1.7 && two < 2.4, "two nodes: {two}");
    assert!(three > 2.7, "three nodes: {three}");
}

/// A load that no step can follow ends with time, place and size, not with a NaN.
#[test]
fn failure_says_when_and_where() {
    let mesh = fmb(1.0, 12, 2);
    let loads = case(vec![load(
        2,
        LoadFrame::Dead,
        [1e14, 0.0, 0.0],
        [0.0, 1e14, 0.0],
        TimeFunction::Constant { value: 1.0 },
    )]);
    let scheme = Scheme::new(Family::Newmark, 0.01, 0.0);
    let mut run = Nonlinear::new(&mesh, &Configuration::drawing(&mesh), &loads, scheme).unwrap();
    let error = (0..20).find_map(|_| run.step().err()).expect("this load tears the frame apart");
    match &error {
        NonlinearError::NotConverged { time, place, .. } => {
            assert!(*time > 0.0 && !place.is_empty());
        }
        NonlinearError::Singular { time, place } => assert!(*time > 0.0 && !place.is_empty()),
        NonlinearError::CoarseElement { member, .. } => assert!(!member.is_empty()),
    }
}

/// A lumped mass alone moves like the rigid body it is: a very stiff structure with masses keeps the particle's path.
#[test]
fn the_centre_of_mass_is_a_particle() {
    let mut mesh = crooked(2);
    for section in &mut mesh.sections {
        // Physical masses: m I, no offset. The identity p = m v_CM needs them.
        let m = section.mass[(0, 0)];
        section.mass = Matrix6::identity() * m;
    }
    mesh.lumped.clear();
    // Nor levers: the step keeps sums over nodes exactly, and over levers to second order.
    mesh.elements.iter_mut().for_each(|e| e.levers = [Vector3::zeros(); 3]);
    let force = Vector3::new(0.4, -0.2, 0.7);
    let loads = case(vec![load(1, LoadFrame::Dead, force.into(), [0.0; 3], pulse(1.0))]);
    let scheme = Scheme::new(Family::Newmark, 0.005, 0.0);
    let mut run = Nonlinear::new(&mesh, &Configuration::drawing(&mesh), &loads, scheme).unwrap();
    let start = run.totals();
    let (mut impulse, mut previous) = (0.0, 0.0);
    for step in 1..=200 {
        run.step().unwrap();
        let now = 0.5 * (1.0 - (std::f64::consts::TAU * f64::from(step) * 0.005).cos());
        impulse += 0.5 * (previous + now) * 0.005;
        previous = now;
        let p = run.totals().linear_momentum - start.linear_momentum;
        assert!((p - force * impulse).norm() < 1e-9, "step {step}");
    }
}

/// A force and a moment per length on the right arm, in every frame.
fn spread(size: f64, stations: usize) -> Vec<DistributedLoad> {
    let mut random = Random::new(13);
    let mut vectors = |size: f64| (0..3 * stations).map(|_| random.next() * size).collect::<Vec<f64>>();
    [DistributedFrame::Dead, DistributedFrame::Body, DistributedFrame::Follower]
        .into_iter()
        .flat_map(|frame| {
            let force =
                DistributedLoad { member: 1, frame, force: vectors(size), moment: vec![], time: pulse(1.0) };
            let moment = DistributedLoad { force: vec![], moment: vectors(0.3 * size), ..force.clone() };
            [force, moment]
        })
        .collect()
}

/// Distributed loads and loads between nodes: the reduced model with all modes is the linear method, but that its sections turn by one
/// rotation vector and those of the elements by their interpolation; the nonlinear one differs with the size of the loads.
#[test]
fn loads_between_nodes_act_alike_in_every_method() {
    let mut mesh = fmb(10.0, 12, 2);
    mesh.points[1].place = Place::Inside { element: mesh.members[1].elements.start + 1, x: 0.35 };
    mesh.points[1].offset = Vector3::new(0.1, 0.2, -0.3);
    let run = |size: f64| {
        let mut mesh = mesh.clone();
        let mut loads = case(vec![
            load(1, LoadFrame::Dead, [0.0, size, size], [0.1 * size, 0.0, 0.0], pulse(1.0)),
            load(1, LoadFrame::Body, [size, 0.0, 0.0], [0.0, 0.2 * size, 0.0], pulse(1.0)),
        ]);
        loads.distributed = spread(size, 3 * mesh.members[1].elements.len());
        mesh.load_cases = vec![loads.clone()];
        let options = BuildOptions {
            modes: ModeSelection::Count(6 * (mesh.nodes.len() - 1)),
            ..BuildOptions::default()
        };
        let model =
            Arc::new(Model::new(build_mesh(&mesh, provenance(), &options, &mut |_| ()).unwrap()).unwrap());
        let prepared = Prepared::new(mesh);
        let out = [Method::Rom, Method::Linear, Method::Nonlinear].map(|method| match method.is_reduced() {
            true => march(&mut *start_reduced(&model, method, &loads, &settings(0.01)).unwrap(), 60),
            false => march(&mut *prepared.start(method, &loads, &settings(0.01)).unwrap(), 60),
        });
        let away = |other: usize| {
            let pairs = out[0].dr_a.iter().zip(&out[other].dr_a);
            let scale = out[other].dr_a.iter().map(|d| d.norm()).fold(0.0, f64::max);
            (pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / scale, scale)
        };
        [away(1), away(2)]
    };
    let (small, large) = (run(100.0), run(200.0));
    // Displacements of some centimetres on an arm of 5 m.
    assert!(large[0].1 > 0.01, "{large:?}");
    // The steps of the methods differ by their own second order, some 1e-4 here; to the linear method that is most of it.
    assert!(large[0].0 < 1e-3, "{large:?}");
    assert!(large[1].0 < 5e-2 && small[1].0 < 0.7 * large[1].0, "{small:?} {large:?}");
}
