//! Velocities and accelerations of points agree between the methods and are derivatives of positions.

use std::sync::Arc;

use nalgebra::Vector3;
use rom_runtime::loads::{Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;
use rom_runtime::{Integrator, Model, PointMotion};

use super::method::{Method, Output, Prepared, Run, RunSettings, start_reduced};
use crate::build::{BuildOptions, ModeSelection, build_mesh};
use crate::math::so3::exp_quaternion;
use crate::mesh::{Mesh, Place};
use crate::test_structures::{fmb, provenance};

/// The frame with a point off the structure, so that spins matter.
fn frame() -> Mesh {
    let mut mesh = fmb(10.0, 12, 2);
    mesh.load_cases.clear();
    mesh.points[2].offset = Vector3::new(0.4, -0.3, 0.5);
    // A sensor's place between the nodes of the right arm.
    mesh.points[1].place = Place::Inside { element: mesh.members[1].elements.end - 1, x: 0.3 };
    mesh.points[1].offset = Vector3::new(0.1, 0.2, -0.1);
    mesh
}

/// A pulse in every direction, `size` newtons on the tips.
fn case(size: f64) -> LoadCase {
    let load = |point, frame, force: [f64; 3], moment: [f64; 3]| Load {
        point,
        frame,
        force: force.map(|x| size * x),
        moment: moment.map(|x| size * x),
        time: TimeFunction::OneMinusCosine { amplitude: 1.0, start: 0.0, duration: 1.0 },
    };
    let loads = vec![
        load(2, LoadFrame::Dead, [0.0, 0.0, 1.0], [0.0; 3]),
        load(4, LoadFrame::Dead, [0.0, 0.2, -1.0], [0.0, 0.0, 0.3]),
        load(2, LoadFrame::Body, [0.1, 0.1, 0.0], [0.2, 0.0, 0.0]),
    ];
    crate::test_structures::case(loads)
}

fn outputs(run: &mut dyn Run, steps: usize) -> Vec<Output> {
    let mut list = vec![run.output()];
    for _ in 0..steps {
        run.step().unwrap();
        list.push(run.output());
    }
    list
}

fn all_modes(mesh: &Mesh) -> Arc<Model> {
    let count = 6 * (mesh.nodes.len() - 1);
    let options =
        BuildOptions { modes: ModeSelection::Count(count), all_nodes: false, ..BuildOptions::default() };
    Arc::new(Model::new(build_mesh(mesh, provenance(), &options, &mut |_| ()).unwrap()).unwrap())
}

fn settings(steps: usize) -> RunSettings {
    RunSettings { dt: 1.0 / steps as f64, integrator: Integrator::Newmark, numerical_damping: 0.0 }
}

fn norms(motion: &PointMotion) -> [f64; 4] {
    [motion.v_g, motion.w_g, motion.a_g, motion.alpha_g].map(|v| Vector3::from(v).norm())
}

/// Largest difference of velocity, spin, acceleration and angular acceleration of the tip over the run, each relative to
/// its own maximum.
fn differences(a: &[Output], b: &[Output]) -> [f64; 4] {
    let mut worst = [0.0_f64; 4];
    let mut size = [0.0_f64; 4];
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (&a.motion[2], &b.motion[2]);
        let pairs = [(a.v_g, b.v_g), (a.w_g, b.w_g), (a.a_g, b.a_g), (a.alpha_g, b.alpha_g)];
        for (k, (x, y)) in pairs.into_iter().enumerate() {
            worst[k] = worst[k].max((Vector3::from(x) - Vector3::from(y)).norm());
            size[k] = size[k].max(norms(a)[k]);
        }
    }
    std::array::from_fn(|k| worst[k] / size[k])
}

/// A node that spins and speeds up carries a point: its velocity and acceleration by central differences of the motion.
#[test]
fn a_point_off_its_node_moves_as_the_node_carries_it() {
    let mesh = frame();
    let (offset, node) = (mesh.points[2].offset, 2);
    let mut random = crate::element::tests::Random::new(4);
    let mut start =
        super::motion::Motion::at_rest(&mesh, &crate::configuration::Configuration::drawing(&mesh));
    start.rotation[node] = exp_quaternion(&random.vector3(2.0));
    start.velocity[node] = random.vector3(1.0);
    start.spin[node] = random.vector3(2.0);
    start.acceleration[node] = random.vector3(3.0);
    start.spin_rate[node] = random.vector3(3.0);
    let after = |h: f64| {
        let mut next = start.clone();
        next.position[node] += h * (start.velocity[node] + 0.5 * h * start.acceleration[node]);
        next.velocity[node] += h * start.acceleration[node];
        let turn = h * (start.spin[node] + 0.5 * h * start.spin_rate[node]);
        next.rotation[node] = start.rotation[node] * exp_quaternion(&turn);
        next.spin[node] += h * start.spin_rate[node];
        next
    };
    let h = 1e-5;
    let slope =
        |of: &dyn Fn(&super::motion::Motion) -> Vector3<f64>| (of(&after(h)) - of(&after(-h))) / (2.0 * h);
    let of_point = |m: &super::motion::Motion| m.of_node(node).of_point(&offset);
    let now = of_point(&start);
    let checks = [
        (now.v_g, slope(&|m| m.position[node] + m.rotation[node] * offset)),
        (now.a_g, slope(&|m| of_point(m).v_g.into())),
        (now.alpha_g, slope(&|m| of_point(m).w_g.into())),
    ];
    for (found, expected) in checks {
        // h^2 times third derivatives, and round-off over h.
        assert!((Vector3::from(found) - expected).norm() < 1e-8, "{found:?} {expected}");
    }
}

/// In every method the velocity of a point is the slope of its position, to the second order of the step, and the
/// acceleration that of its velocity.
#[test]
fn velocities_and_accelerations_of_points_are_slopes_in_every_method() {
    let mesh = frame();
    let model = all_modes(&mesh);
    let prepared = Prepared::new(mesh);
    let error = |method: Method, steps: usize| {
        let s = settings(steps);
        let mut run = match method.is_reduced() {
            true => start_reduced(&model, method, &case(600.0), &s).unwrap(),
            false => prepared.start(method, &case(600.0), &s).unwrap(),
        };
        let out = outputs(&mut *run, steps);
        let mut worst = [0.0_f64; 2];
        let mut size = [0.0_f64; 2];
        for three in out.windows(3) {
            let slope = |of: &dyn Fn(&Output) -> Vector3<f64>| (of(&three[2]) - of(&three[0])) / (2.0 * s.dt);
            let now = &three[1].motion[2];
            let (v, a) = (Vector3::from(now.v_g), Vector3::from(now.a_g));
            worst[0] = worst[0].max((slope(&|o| o.r_g[2]) - v).norm());
            worst[1] = worst[1].max((slope(&|o| o.motion[2].v_g.into()) - a).norm());
            size = [size[0].max(v.norm()), size[1].max(a.norm())];
        }
        [worst[0] / size[0], worst[1] / size[1]]
    };
    for method in [Method::Nonlinear, Method::Linear, Method::Rigid, Method::MeanAxes] {
        let (coarse, fine) = (error(method, 100), error(method, 400));
        assert!(fine[0] < 1e-3 && coarse[0] / fine[0] > 8.0, "{method}: {coarse:?} {fine:?}");
        // Axial vibrations that no step resolves leave a floor under the accelerations.
        assert!(fine[1] < 5e-3, "{method}: {coarse:?} {fine:?}");
    }
}

/// With every mode the reduced model has the accelerations of the linear method, but for the time discretisation of A.
#[test]
fn the_reduced_model_with_all_modes_has_the_accelerations_of_the_linear_method() {
    let mesh = frame();
    let model = all_modes(&mesh);
    let prepared = Prepared::new(mesh);
    let difference = |steps: usize| {
        let s = settings(steps);
        let a = outputs(&mut *prepared.start(Method::Linear, &case(600.0), &s).unwrap(), steps);
        let b = outputs(&mut *start_reduced(&model, Method::Rom, &case(600.0), &s).unwrap(), steps);
        differences(&a, &b)
    };
    let (coarse, fine) = (difference(50), difference(200));
    for k in 0..4 {
        assert!(fine[k] < 1e-3 && coarse[k] / fine[k] > 10.0, "{coarse:?} {fine:?}");
    }
}

/// The nonlinear and the linear method share the limit of small loads: the relative difference falls with the load.
#[test]
fn accelerations_of_the_nonlinear_method_have_the_linear_limit() {
    let prepared = Prepared::new(frame());
    let difference = |size: f64| {
        let run = |method| outputs(&mut *prepared.start(method, &case(size), &settings(100)).unwrap(), 100);
        differences(&run(Method::Nonlinear), &run(Method::Linear))
    };
    let (large, small) = (difference(30.0), difference(3.0));
    for k in 0..4 {
        let rate = large[k] / small[k];
        assert!(small[k] < 2e-3 && (5.0..20.0).contains(&rate), "{large:?} {small:?}");
    }
}
