//! Damping: what it takes from a motion, what it leaves alone, and that all methods agree on it.

use std::sync::Arc;

use nalgebra::{Vector3, Vector6};
use rom_runtime::loads::{Load, LoadFrame};
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Model};

use super::damping::Damper;
use super::method::{Method, Prepared, Run, RunSettings, start_reduced};
use super::motion::Motion;
use super::nonlinear::{Damping as Damped, Nonlinear};
use super::scheme::{Family, Scheme};
use super::start::Start;
use crate::assembly::AnyBeam;
use crate::build::{BuildOptions, ModeSelection, build_mesh};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::internal_force::{force_of_stresses, internal_force_and_stiffness, split, strain};
use crate::element::rotation_field::RotationField;
use crate::element::tests::Random;
use crate::element::viscous::{viscous_matrix, viscous_stresses};
use crate::math::so3::exp_quaternion;
use crate::mesh::{Damping, Mesh, ModalRatios};
use crate::reduce::modes::elastic_modes;
use crate::test_structures::{case, crooked, fmb, provenance};

/// A random deformed shape far from the drawing, turned and displaced, with random rates.
fn wild(mesh: &Mesh) -> Motion {
    let mut random = Random::new(5);
    let mut motion = Motion::at_rest(mesh, &Configuration::drawing(mesh));
    let (turn, shift) = (exp_quaternion(&random.vector3(2.0)), random.vector3(30.0));
    for node in 0..motion.position.len() {
        motion.position[node] = turn * (motion.position[node] + random.vector3(0.2)) + shift;
        motion.rotation[node] = turn * motion.rotation[node] * exp_quaternion(&random.vector3(0.2));
        motion.velocity[node] = random.vector3(3.0);
        motion.spin[node] = random.vector3(3.0);
    }
    motion
}

fn damped(mesh: &mut Mesh) {
    mesh.sections.iter_mut().enumerate().for_each(|(k, s)| s.retardation = 0.01 * (k + 1) as f64);
    mesh.damping = Damping { modal: ModalRatios::Listed(vec![0.02, 0.0, 0.05]), alpha: 0.7 };
}

/// Damping forces of a motion on all nodes: of the strains, in proportion to mass, to modes.
fn forces(prepared: &Prepared, motion: &Motion) -> [Vec<Vector6<f64>>; 3] {
    let n = motion.position.len();
    let mut out = [(); 3].map(|()| vec![Vector6::zeros(); n]);
    fn viscous<const N: usize>(b: &Beam<N>, motion: &Motion, out: &mut [Vector6<f64>]) {
        let rates = b.nodes.map(|n| {
            let (v, w) = (motion.velocity[n], motion.spin[n]);
            crate::element::internal_force::stack(&v, &w)
        });
        let state = motion.of(b);
        let force = force_of_stresses(b, &state, &viscous_stresses(b, &state, &rates));
        b.nodes.iter().zip(force).for_each(|(&n, f)| out[n] += f);
    }
    for beam in &prepared.assembly.beams {
        match beam {
            AnyBeam::Two(b) => viscous(b, motion, &mut out[0]),
            AnyBeam::Three(b) => viscous(b, motion, &mut out[0]),
        }
    }
    for (part, force) in [(1, true), (2, false)].map(|(k, mass)| {
        let mut mesh = prepared.mesh.clone();
        match mass {
            true => mesh.damping.modal = ModalRatios::default(),
            false => mesh.damping.alpha = 0.0,
        }
        let damper = Damper::new(&Prepared::new(mesh)).unwrap();
        let mut force = vec![Vector6::zeros(); n];
        damper.add_absolute(&prepared.assembly, prepared.mesh.reference, motion, &mut force);
        (k, force)
    }) {
        out[part] = force;
    }
    out
}

/// No part has a resultant, so that momentum and angular momentum stay what they are; every part takes energy away; none feels a
/// rigid motion. At large deformation, in any attitude.
#[test]
fn damping_takes_energy_but_no_momentum_and_leaves_rigid_motion_alone() {
    for n_nodes in [2, 3] {
        let mut mesh = crooked(n_nodes);
        damped(&mut mesh);
        let prepared = Prepared::new(mesh);
        let motion = wild(&prepared.mesh);
        let mut rigid = motion.clone();
        rigid.velocity.fill(Vector3::zeros());
        rigid.spin.fill(Vector3::zeros());
        let (v, w) = (Vector3::new(20.0, -30.0, 10.0), Vector3::new(3.0, 1.0, -2.0));
        rigid.add_rigid_velocity(prepared.mesh.reference, &v, &w);
        let of_rigid = forces(&prepared, &rigid);
        for (part, force) in forces(&prepared, &motion).iter().enumerate() {
            let (mut sum, mut moment, mut power, mut scale) = (Vector3::zeros(), Vector3::zeros(), 0.0, 0.0);
            for (node, f) in force.iter().enumerate() {
                let (f, m) = split(f);
                let q = motion.rotation[node];
                sum += f;
                moment += (motion.position[node] - motion.position[0]).cross(&f) + q * m;
                power += f.dot(&motion.velocity[node]) + m.dot(&motion.spin[node]);
                scale += f.norm() + m.norm();
            }
            assert!(scale > 1e-3 && power > 1e-3 * scale, "part {part}: power {power} of {scale}");
            // Sums of a few dozen forces; the arms are a few metres.
            assert!(
                sum.norm() < 1e-12 * scale && moment.norm() < 1e-11 * scale,
                "part {part}: {sum} {moment}"
            );
            let left = of_rigid[part].iter().map(|f| f.norm()).fold(0.0, f64::max);
            // Velocities of 40 m/s that cancel in the strains.
            assert!(left < 1e-11 * scale, "part {part}: {left} of {scale}");
        }
    }
}

/// The rate of the strains that the viscous forces are made of is their derivative along the motion, and the power the forces take
/// is that of the section forces on it.
#[test]
fn viscous_forces_are_those_of_the_rate_of_the_strains() {
    fn check<const N: usize>(b: &Beam<N>, motion: &Motion) {
        let at = |h: f64| {
            let mut moved = motion.clone();
            for n in b.nodes {
                moved.position[n] += motion.velocity[n] * h;
                moved.rotation[n] *= exp_quaternion(&(motion.spin[n] * h));
            }
            moved.of(b)
        };
        let strains = |h: f64| {
            let state = at(h);
            let field = RotationField::new(&state.triads);
            b.stiffness_points().iter().map(|p| strain(&state, &field, p)).collect::<Vec<_>>()
        };
        let h = 1e-5;
        let (after, before) = (strains(h), strains(-h));
        let rates =
            b.nodes.map(|n| crate::element::internal_force::stack(&motion.velocity[n], &motion.spin[n]));
        let state = at(0.0);
        let found = viscous_stresses(b, &state, &rates);
        let mut power = 0.0;
        for (k, point) in b.stiffness_points().iter().enumerate() {
            let rate = (after[k] - before[k]) / (2.0 * h);
            let expected = point.stiffness * rate * point.retardation;
            // Central difference: h^2 times third derivatives of the order of 30, round-off over h.
            assert!((found[k] - expected).amax() < 1e-7 * expected.amax(), "{} {expected}", found[k]);
            power += rate.dot(&expected) * point.weight;
        }
        let on_nodes: f64 =
            force_of_stresses(b, &state, &found).iter().zip(&rates).map(|(f, v)| f.dot(v)).sum();
        assert!((on_nodes - power).abs() < 1e-7 * power, "{on_nodes} {power}");
    }
    for n_nodes in [2, 3] {
        let mut mesh = crooked(n_nodes);
        damped(&mut mesh);
        let motion = wild(&mesh);
        for beam in crate::assembly::beams(&mesh) {
            match beam {
                AnyBeam::Two(b) => check(&b, &motion),
                AnyBeam::Three(b) => check(&b, &motion),
            }
        }
    }
}

/// In the stress-free shape the damping of strains is the stiffness times the retardation time.
#[test]
fn viscosity_is_in_proportion_to_the_stiffness_of_the_sections() {
    let mut mesh = crooked(3);
    mesh.sections.iter_mut().for_each(|s| s.retardation = 0.25);
    let at = Configuration::drawing(&mesh);
    for beam in crate::assembly::beams(&mesh) {
        let AnyBeam::Three(b) = beam else { unreachable!("a mesh of three-node elements") };
        let k = internal_force_and_stiffness(&b, &at.of(&b)).1;
        let d = viscous_matrix(&b, &at.of(&b));
        for (k, d) in k.iter().flatten().zip(d.iter().flatten()) {
            assert!((k * 0.25 - d).amax() < 1e-13 * k.amax());
        }
    }
}

/// Energy left of the second mode of the frame after some periods, by every method, over `exp(-2 zeta omega t)`.
fn decay(damping: Damping, retardation: f64, zeta: impl Fn(f64) -> f64) {
    let mut mesh = fmb(10.0, 12, 2);
    mesh.load_cases.clear();
    mesh.sections[0].retardation = retardation;
    mesh.damping = damping;
    let options =
        BuildOptions { modes: ModeSelection::Count(4), all_nodes: false, ..BuildOptions::default() };
    let data = build_mesh(&mesh, provenance(), &options, &mut |_| ()).unwrap();
    assert!(data.damping.is_none());
    let prepared = Prepared::new(mesh);
    let Prepared { assembly, at, mass, stiffness, .. } = &prepared;
    let modes = elastic_modes(assembly, at, mass, stiffness, 4).unwrap();
    let (omega, mode) = (modes.omega[1], 1);
    let ratio = zeta(omega);
    assert!((data.modes.damping_ratio[mode] / ratio - 1.0).abs() < 1e-9);
    // The mode released from a shape of which the largest displacement is a tenth of a millimetre (axial stiffness feels larger ones), A where it is in the mode.
    let size = 1e-4 / (0..at.positions.len()).map(|n| modes.at_node(n)[mode].amax()).fold(0.0, f64::max);
    let mut start = Start::at_rest(&prepared);
    let nodal: Vec<Vector6<f64>> = (0..at.positions.len()).map(|n| modes.at_node(n)[mode] * size).collect();
    start.x = assembly.gather(&nodal);
    let (periods, per_period) = (3, 200);
    let dt = 2.0 * std::f64::consts::PI / omega / f64::from(per_period);
    let scheme = Scheme::new(Family::Newmark, dt, 0.0);
    let damper = || Damper::new(&prepared).unwrap();
    let expected = (-2.0 * ratio * omega * f64::from(periods * per_period) * dt).exp();
    let check = |name: &str, energies: [f64; 2]| {
        let found = energies[1] / energies[0];
        // Newmark's period is long by (omega dt)^2/12 = 8e-5; energies are taken where both kinds are there.
        assert!((found / expected - 1.0).abs() < 4e-3, "{name}: {found} left, expected {expected}");
    };
    let energy = |run: &dyn Run| {
        let totals = run.output().totals;
        totals.kinetic_energy + totals.elastic_energy
    };
    let loads = case(Vec::new());
    let linear = super::linear::LinearForces::new(&prepared).with_damper(damper());
    let mut run = super::floating::Floating::new(&prepared, &start, &loads, scheme, linear).unwrap();
    let begin = energy(&run);
    (0..periods * per_period).for_each(|_| run.step().unwrap());
    check("linear", [begin, energy(&run)]);
    let full = super::constant_mass::NonlinearForces::new(&prepared).with_damper(damper());
    let mut run = super::floating::Floating::new(&prepared, &start, &loads, scheme, full).unwrap();
    (0..periods * per_period).for_each(|_| run.step().unwrap());
    check("constant mass", [begin, energy(&run)]);
    let damping = Some(Damped { damper: damper(), assembly });
    let mut run =
        Nonlinear::started(&prepared.mesh, start.motion(&prepared), &loads, scheme, damping, None).unwrap();
    (0..periods * per_period).for_each(|_| run.step().unwrap());
    let totals = run.totals();
    check("nonlinear", [begin, totals.kinetic_energy + totals.elastic_energy]);
}

/// Logarithmic decrement of a mode: Rayleigh's two parts, the strains', and a ratio.
#[test]
fn modes_decay_as_they_should_in_every_finite_element_method() {
    decay(Damping { alpha: 0.4, ..Damping::default() }, 0.0, |omega| 0.4 / (2.0 * omega));
    decay(Damping::default(), 1e-3, |omega| 0.5e-3 * omega);
    decay(Damping { modal: ModalRatios::All(0.015), alpha: 0.0 }, 0.0, |_| 0.015);
    decay(Damping { modal: ModalRatios::Listed(vec![0.5, 0.02]), alpha: 0.2 }, 0.0, |omega| {
        0.02 + 0.1 / omega
    });
}

/// Strains damped in one arm alone couple the modes; with all of them the reduced model is the linear method.
#[test]
fn damping_that_couples_modes_is_the_same_in_the_reduced_model() {
    let mut mesh = fmb(10.0, 12, 2);
    mesh.load_cases.clear();
    let mut rubber = mesh.sections[0].clone();
    rubber.retardation = 0.05;
    mesh.sections.push(rubber);
    mesh.elements.iter_mut().filter(|e| e.member == 1).for_each(|e| e.sections = [1, 1]);
    mesh.damping = Damping { modal: ModalRatios::Listed(vec![0.01]), alpha: 0.3 };
    let pulse = TimeFunction::OneMinusCosine { amplitude: 1.0, start: 0.0, duration: 0.5 };
    let (force, moment) = ([0.0, 40.0, 300.0], [0.0, 0.0, 50.0]);
    let loads = case(vec![Load { point: 2, frame: LoadFrame::Dead, force, moment, time: pulse }]);
    let all = 6 * (mesh.nodes.len() - 1);
    let options =
        BuildOptions { modes: ModeSelection::Count(all), all_nodes: false, ..BuildOptions::default() };
    let data = build_mesh(&mesh, provenance(), &options, &mut |_| ()).unwrap();
    assert!(data.damping.is_some());
    let model = Arc::new(Model::new(data).unwrap());
    let prepared = Prepared::new(mesh);
    let difference = |steps: usize| {
        let settings =
            RunSettings { dt: 1.0 / steps as f64, integrator: Integrator::Newmark, numerical_damping: 0.0 };
        let mut runs = [
            prepared.start(Method::Linear, &loads, &settings).unwrap(),
            start_reduced(&model, Method::Rom, &loads, &settings).unwrap(),
        ];
        runs.iter_mut().for_each(|run| (0..steps).for_each(|_| run.step().unwrap()));
        let [a, b] = runs.map(|run| run.output());
        (a.dr_a[2] - b.dr_a[2]).norm() / a.dr_a[2].norm()
    };
    // Both solve a step to 1e-10, of displacements of 1e-3 of the size; damping wrong by a hundredth would show as 1e-3.
    let found = [50, 200].map(difference);
    assert!(found[0] < 1e-6 && found[1] < 1e-6, "{found:?}");
}
