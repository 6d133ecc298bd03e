//! Velocities, accelerations and attitudes of points are time derivatives of one another along a motion.

use std::sync::Arc;

use crate::common::{Lumped, Random, rotation_rows};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use rom_runtime::data::{GravityData, SensorData};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    Integrator, Load, LoadCase, LoadFrame, Method, Model, PointMotion, Settings, Simulation, State,
    StateRate, Workspace, into_axes,
};

fn random_state(model: &Model, random: &mut Random) -> State {
    let mut state = State::at_rest(model);
    state.q.iter_mut().for_each(|q| *q = 0.6 * random.next());
    state.q_dot.iter_mut().for_each(|q| *q = random.next());
    state.beta_star = random.array(1.5);
    let turn = UnitQuaternion::from_scaled_axis(2.0 * random.vector());
    state.attitude = [turn.w, turn.i, turn.j, turn.k];
    state.position = random.array(10.0);
    state.u_dot.iter_mut().for_each(|a| *a = 2.0 * random.next());
    state
}

fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// The state after `h`, its accelerations held: exact to second order in position, attitude and amplitudes, and to first
/// order in the velocities.
fn after(model: &Model, state: &State, h: f64) -> State {
    let (m, mut next) = (model.n_modes(), state.clone());
    for i in 0..m {
        next.q[i] += h * (state.q_dot[i] + 0.5 * h * state.u_dot[i]);
        next.q_dot[i] += h * state.u_dot[i];
    }
    for i in 0..6 {
        next.beta_star[i] += h * state.u_dot[m + i];
    }
    let (beta, later) = (model.velocity(state), model.velocity(&next));
    let mean = |first: usize| Vector3::from_fn(|k, _| 0.5 * (beta[first + k] + later[first + k]));
    let (v, w) = (Vector3::new(beta[0], beta[1], beta[2]), Vector3::new(beta[3], beta[4], beta[5]));
    let turn = quaternion(state.attitude);
    let moved = turn * (mean(0) + 0.5 * h * w.cross(&v)) * h;
    next.position = (Vector3::from(state.position) + moved).into();
    let turned = turn * UnitQuaternion::from_scaled_axis(mean(3) * h);
    next.attitude = [turned.w, turned.i, turned.j, turned.k];
    next
}

/// Central difference of what `of` makes of the motion.
fn slope(model: &Model, state: &State, of: impl Fn(&State) -> Vector3<f64>) -> Vector3<f64> {
    let h = 1e-5;
    (of(&after(model, state, h)) - of(&after(model, state, -h))) / (2.0 * h)
}

fn close(found: [f64; 3], expected: Vector3<f64>, what: &str) {
    let error = (Vector3::from(found) - expected).norm();
    // h^2 times a third derivative (below 1e3), and round-off of numbers near 10 over h.
    assert!(error < 1e-7 * (1.0 + expected.norm()), "{what}: {found:?} instead of {expected:?}");
}

fn motion(model: &Model, state: &State, point: usize) -> PointMotion {
    model.point_motion(state, &state.u_dot, point).unwrap()
}

#[test]
fn velocities_and_accelerations_are_derivatives_of_positions_and_attitudes() {
    let rom = Model::new(Lumped::random(4, 3).data(3)).unwrap();
    let mean_axes = rom.with_method(Method::MeanAxes).unwrap();
    let rigid = rom.with_method(Method::Rigid).unwrap();
    let mut random = Random::new(7);
    for model in [&rom, &mean_axes, &rigid] {
        for _ in 0..3 {
            let state = random_state(model, &mut random);
            for point in 0..model.n_points() {
                let now = motion(model, &state, point);
                let name = format!("{}, point {point}", model.method());
                let position = |s: &State| Vector3::from(model.point_output(s, point).unwrap().r_g);
                close(now.v_g, slope(model, &state, position), &format!("v_g of {name}"));
                let velocity = |s: &State| Vector3::from(motion(model, s, point).v_g);
                close(now.a_g, slope(model, &state, velocity), &format!("a_g of {name}"));
                let spin = |s: &State| Vector3::from(motion(model, s, point).w_g);
                close(now.alpha_g, slope(model, &state, spin), &format!("alpha_g of {name}"));
                // A vector fixed to the node moves with w x it.
                let arm = random.vector();
                let carried = |s: &State| quaternion(motion(model, s, point).attitude) * arm;
                let expected = slope(model, &state, carried);
                close(
                    Vector3::from(now.w_g).cross(&carried(&state)).into(),
                    expected,
                    &format!("w_g of {name}"),
                );
            }
        }
    }
    assert!(rom.point_motion(&State::at_rest(&rom), &[0.0; 10], rom.n_points()).is_none());
}

#[test]
fn the_attitude_carries_the_offset_of_the_point() {
    // Position = node + attitude * offset: the same rotation that the positions are made of.
    let model = Model::new(Lumped::random(3, 4).data(4)).unwrap();
    let state = random_state(&model, &mut Random::new(2));
    for (index, data) in model.data().points.iter().enumerate() {
        let mut bare = model.data().clone();
        bare.points[index].offset = [0.0; 3];
        let node = Model::new(bare).unwrap().point_output(&state, index).unwrap().r_g;
        let arm = quaternion(motion(&model, &state, index).attitude) * Vector3::from(data.offset);
        let whole = Vector3::from(model.point_output(&state, index).unwrap().r_g);
        assert!((Vector3::from(node) + arm - whole).norm() < 1e-13, "point {index}");
    }
}

fn with_sensor() -> (Model, Matrix3<f64>) {
    let mut data = Lumped::random(3, 9).data(9);
    let axes = rotation_rows(&Vector3::new(0.4, -1.0, 0.7));
    data.sensors = vec![SensorData { name: "imu".into(), point: 1, axes, gravity: true }];
    let axes = Matrix3::from_fn(|i, j| axes[i][j]);
    (Model::new(data).unwrap(), axes)
}

#[test]
fn a_sensor_reads_the_motion_of_its_point_in_its_own_axes() {
    let (model, axes) = with_sensor();
    assert_eq!(model.sensor("imu").unwrap(), 0);
    assert!(model.sensor("gyro").unwrap_err().to_string().contains("imu"));
    let state = random_state(&model, &mut Random::new(3));
    let (reading, point) =
        (model.sensor_reading(&state, &state.u_dot, 0).unwrap(), motion(&model, &state, 1));
    let turn = quaternion(point.attitude).to_rotation_matrix().into_inner() * axes;
    for (found, vector) in [(reading.a, point.a_g), (reading.w, point.w_g), (reading.alpha, point.alpha_g)] {
        let back = turn * Vector3::from(found);
        assert!((back - Vector3::from(vector)).norm() < 1e-13 * (1.0 + back.norm()));
    }
    let expected = turn.transpose() * Vector3::from(point.w_g);
    assert!(
        (axes * Vector3::from(reading.w) - Vector3::from(into_axes(point.attitude, point.w_g))).norm()
            < 1e-13
    );
    assert!((Vector3::from(reading.w) - expected).norm() < 1e-13);
}

#[test]
fn a_sensor_in_free_fall_feels_nothing_and_one_that_does_not_feel_gravity_reads_it() {
    let (model, axes) = with_sensor();
    let mut data = model.with_method(Method::Rigid).unwrap().data().clone();
    let fall = [0.3, -0.4, -9.81];
    data.gravity = Some(GravityData { acceleration: fall, second_moment: vec![] });
    data.sensors.push(SensorData { name: "plain".into(), gravity: false, ..data.sensors[0].clone() });
    let model = Arc::new(Model::new(data).unwrap());
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    simulation.solve_accelerations(&model.no_loads()).unwrap();
    let read = |simulation: &Simulation, sensor| Vector3::from(simulation.sensor_reading(sensor).unwrap().a);
    assert!(read(&simulation, 0).norm() < 1e-13);
    let node = quaternion(model.data().points[1].node_rotation).to_rotation_matrix().into_inner();
    assert!((node * axes * read(&simulation, 1) - Vector3::from(fall)).norm() < 1e-13);
    // The same in a field that the host sets.
    let other = [1.0, 2.0, 3.0];
    simulation.set_gravity(other).unwrap();
    simulation.solve_accelerations(&model.no_loads()).unwrap();
    assert!(read(&simulation, 0).norm() < 1e-13);
    assert!((node * axes * read(&simulation, 1) - Vector3::from(other)).norm() < 1e-13);
}

#[test]
fn a_spun_rigid_body_has_the_accelerations_of_the_textbook() {
    // Free symmetric spin about a principal axis: a = -w^2 r towards the axis, no angular acceleration.
    let model = Arc::new(Model::new(Lumped::rigid_body().data(1)).unwrap());
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let centre = Vector3::from(model.data().rigid.centre_of_mass);
    let w = Vector3::new(0.0, 0.0, 3.0);
    let mut state = State::at_rest(&model);
    let v = -w.cross(&centre);
    state.beta_star = [v.x, v.y, v.z, w.x, w.y, w.z];
    simulation.restore(&state).unwrap();
    assert!(simulation.point_motion(0).is_none(), "accelerations are not known before they are solved");
    simulation.solve_accelerations(&model.no_loads()).unwrap();
    for point in 0..model.n_points() {
        let arm = Vector3::from(simulation.point_output(point).unwrap().r_g) - centre;
        let found = simulation.point_motion(point).unwrap();
        let expected = w.cross(&w.cross(&arm));
        assert!((Vector3::from(found.a_g) - expected).norm() < 1e-12 * expected.norm(), "point {point}");
        assert!(Vector3::from(found.alpha_g).norm() < 1e-12);
    }
}

#[test]
fn accelerations_asked_for_do_not_change_the_run() {
    let (model, _) = with_sensor();
    let model = Arc::new(model);
    let case = LoadCase {
        dt: 0.001,
        loads: vec![Load {
            point: 0,
            frame: LoadFrame::Dead,
            force: [1.0, 2.0, 3.0],
            moment: [0.5, 0.0, -0.2],
            time: TimeFunction::Constant { value: 1.0 },
        }],
        ..LoadCase::empty("test")
    };
    let loads = model.prepare(&case).unwrap();
    for integrator in Integrator::of(&model) {
        let settings = Settings { dt: 0.001, integrator, ..Settings::default() };
        let mut plain = Simulation::new(model.clone(), settings).unwrap();
        let mut asked = plain.clone();
        let (mut work, mut rate) = (Workspace::new(&model), StateRate::new(&model));
        for _ in 0..20 {
            asked.solve_accelerations(&loads).unwrap();
            plain.step(&loads).unwrap();
            asked.step(&loads).unwrap();
            assert_eq!(
                (&plain.state().q, plain.state().attitude),
                (&asked.state().q, asked.state().attitude)
            );
            // What the step left behind is what the equations of motion give there.
            asked.solve_accelerations(&loads).unwrap();
            model.derivatives(asked.state(), &loads, &mut work, &mut rate).unwrap();
            let known = asked.sensor_reading(0).unwrap();
            let solved = model.sensor_reading(asked.state(), &rate.u_dot, 0).unwrap();
            for (known, solved) in known.a.iter().zip(solved.a) {
                // The residual of the step's iteration, times stiffness over mass.
                assert!((known - solved).abs() < 1e-9 * (1.0 + solved.abs()), "{integrator:?}");
            }
        }
    }
}
