//! Derivatives of the equations of motion against differences of [`Model::derivatives`], and what a host does with them.

use std::sync::Arc;

use crate::common::{Lumped, Random, rotation_rows};
use nalgebra::{DMatrix, DVector, Matrix3, Quaternion, UnitQuaternion, Vector3};
use rom_runtime::data::{ClampedData, DampingData, GravityData, LineData, SensorData, StationSet, TrimData};
use rom_runtime::expression::{Binary, Instruction, Program, Unary, Variable};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    BaseMotion, Direction, DistributedFrame, DistributedLoad, Drive, Jacobian, Ledger, Load, LoadCase,
    LoadFrame, LoadSet, Method, Model, ModelData, PrescribedMotion, Settings, Simulation, State, StateRate,
    StepError, Workspace,
};

fn program(source: &str, code: Vec<Instruction>) -> TimeFunction {
    TimeFunction::Expression { program: Program { source: source.into(), code } }
}

/// Loads of every frame, whose factors depend on velocities and place; distributed loads of every kind.
fn every_load(model: &ModelData) -> LoadCase {
    use Instruction::{Binary as B, Constant as C, Unary as U, Variable as V};
    let mut random = Random::new(3);
    let drag = [V(Variable::Vx), V(Variable::Vx), U(Unary::Abs), B(Binary::Mul), C(-0.3), B(Binary::Mul)];
    let spring = [V(Variable::Z), U(Unary::Sin), V(Variable::Wy), U(Unary::Cos), B(Binary::Mul)];
    let times = [
        TimeFunction::Constant { value: 1.5 },
        program("-0.3 vx |vx|", drag.to_vec()),
        program("sin(z) cos(wy)", spring.to_vec()),
    ];
    let mut loads = Vec::new();
    for time in times {
        // Forces alone on points that are their nodes: projected together.
        let nodes = (0..model.points.len()).filter(|&point| model.points[point].offset == [0.0; 3]);
        for (point, frame) in nodes.flat_map(|point| [(point, LoadFrame::Dead), (point, LoadFrame::Body)]) {
            let (force, moment) = (random.array(2.0), [0.0; 3]);
            loads.push(Load { point: point as u32, frame, force, moment, time: time.clone() });
        }
        for frame in [
            LoadFrame::Dead,
            LoadFrame::Body,
            LoadFrame::Follower { section: rotation_rows(&random.vector()) },
        ] {
            loads.push(Load {
                point: (loads.len() % model.points.len()) as u32,
                frame,
                force: random.array(2.0),
                moment: random.array(2.0),
                time: time.clone(),
            });
        }
    }
    let stations = model.lines.first().map_or(0, |line| line.stations.len());
    let mut distributed = Vec::new();
    for frame in [DistributedFrame::Dead, DistributedFrame::Body, DistributedFrame::Follower] {
        if stations > 0 {
            distributed.push(DistributedLoad {
                member: 0,
                frame,
                force: (0..3 * stations).map(|_| random.next()).collect(),
                moment: if frame == DistributedFrame::Follower { vec![0.3; 3 * stations] } else { vec![] },
                time: program("vx", vec![V(Variable::Vx)]),
            });
        }
    }
    LoadCase { dt: 0.01, loads, distributed, ..LoadCase::empty("all") }
}

/// Everything a model of the paper's kind can have.
fn everything(seed: u64) -> ModelData {
    let lumped = Lumped { damping_ratio: 0.05, ..Lumped::random(4, seed) };
    let mut data = lumped.data(seed);
    for point in &mut data.points[3..6] {
        point.offset = [0.0; 3];
    }
    let (m, mut random) = (4, Random::new(seed + 10));
    let mut coupling = vec![0.0; m * m];
    for (i, j) in [(0, 1), (1, 3), (0, 2)] {
        coupling[i * m + j] = 0.1 * random.next();
        coupling[j * m + i] = coupling[i * m + j];
    }
    data.damping = Some(DampingData { coupling });
    let mut second = vec![0.0; 3 * m * m];
    for (k, i, j) in (0..3).flat_map(|k| (0..m).flat_map(move |i| (0..=i).map(move |j| (k, i, j)))) {
        second[(k * m + i) * m + j] = random.next();
        second[(k * m + j) * m + i] = second[(k * m + i) * m + j];
    }
    data.gravity = Some(GravityData { acceleration: [1.0, -2.0, -9.0], second_moment: second });
    let stations = StationSet {
        position: random.array::<9>(2.0).to_vec(),
        rotation: (0..3)
            .flat_map(|_| {
                let turn = UnitQuaternion::from_scaled_axis(random.vector());
                [turn.w, turn.i, turn.j, turn.k]
            })
            .collect(),
        phi_translation: (0..9 * m).map(|_| random.next()).collect(),
        phi_rotation: (0..9 * m).map(|_| 0.3 * random.next()).collect(),
    };
    data.lines = vec![LineData { name: "wing".into(), length: 3.0, knots: vec![0.0, 1.0], stations }];
    data.sensors = vec![SensorData {
        name: "imu".into(),
        point: 2,
        axes: rotation_rows(&random.vector()),
        gravity: true,
    }];
    data.trim = Some(TrimData {
        loads: vec![Load {
            point: 1,
            frame: LoadFrame::Dead,
            force: [1.0, 0.5, -2.0],
            moment: [0.2, 0.0, 0.1],
            time: TimeFunction::Constant { value: 1.0 },
        }],
        distributed: Vec::new(),
        elastic_force: random.array::<4>(1.0).to_vec(),
        elastic_energy: 2.0,
        attitude: [1.0, 0.0, 0.0, 0.0],
        factors: vec![],
        load_names: Vec::new(),
        reaction: [0.0; 6],
        scales: [1.0, 1.0],
        displacements: vec![[0.0; 3]; data.points.len()],
        effort: [1, 5],
    });
    data
}

fn clamped(seed: u64) -> ModelData {
    let mut data = everything(seed);
    data.modes.phi_r.fill(0.0);
    data.clamped = Some(ClampedData { participation: Random::new(seed).array::<24>(0.5).to_vec() });
    data
}

fn random_state(model: &Model, seed: u64) -> State {
    let mut random = Random::new(seed);
    let mut state = State::at_rest(model);
    state.time = 0.3;
    state.q.iter_mut().for_each(|q| *q = 0.5 * random.next());
    state.q_dot.iter_mut().for_each(|q| *q = random.next());
    state.beta_star = random.array(1.5);
    let turn = UnitQuaternion::from_scaled_axis(2.0 * random.vector());
    state.attitude = [turn.w, turn.i, turn.j, turn.k];
    state.position = random.array(2.0);
    state
}

fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}

/// The state moved by `h` along a coordinate of the Jacobian.
fn moved(state: &State, coordinate: usize, h: f64) -> State {
    let mut next = state.clone();
    let m = state.q.len();
    match coordinate {
        i if i < m => next.q[i] += h,
        i if i < 2 * m => next.q_dot[i - m] += h,
        i if i < 2 * m + 6 => next.beta_star[i - 2 * m] += h,
        i if i < 2 * m + 9 => {
            let mut theta = Vector3::zeros();
            theta[i - 2 * m - 6] = h;
            let turn = quaternion(state.attitude) * UnitQuaternion::from_scaled_axis(theta);
            next.attitude = [turn.w, turn.i, turn.j, turn.k];
        }
        i => next.position[i - 2 * m - 9] += h,
    }
    next
}

/// Central difference of sixth order along a coordinate.
fn difference(state: &State, coordinate: usize, of: &mut dyn FnMut(&State) -> Vec<f64>) -> Vec<f64> {
    let h = 0.01;
    let mut sum: Vec<f64> = Vec::new();
    for (k, weight) in [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)] {
        let (after, before) = (of(&moved(state, coordinate, k * h)), of(&moved(state, coordinate, -k * h)));
        sum.resize(after.len(), 0.0);
        for (sum, (a, b)) in sum.iter_mut().zip(after.iter().zip(&before)) {
            *sum += weight / h * (a - b);
        }
    }
    sum
}

/// Largest difference, relative to the largest entry or one. The rule leaves `h^6/140` of seventh derivatives, which are below some
/// tens per unit here, and round-off of `1e-15/h` of forces of some tens: 1e-11.
fn check(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() < 1e-11 * scale, "{what}, row {i}: {found} instead of {expected}");
    }
}

/// Rates in the rows of the Jacobian, but for those of the turn: angular velocity instead.
fn rates(model: &Model, state: &State, loads: &impl rom_runtime::Loads) -> Vec<f64> {
    let (mut work, mut rate) = (Workspace::new(model), StateRate::new(model));
    model.derivatives(state, loads, &mut work, &mut rate).unwrap();
    let beta = model.velocity(state);
    rate.q_dot.iter().chain(&rate.u_dot).chain(&beta[3..]).chain(&rate.position_dot).copied().collect()
}

fn check_all(what: &str, model: &Arc<Model>, loads: &impl rom_runtime::Loads, seed: u64) {
    let state = random_state(model, seed);
    let mut jacobian = Jacobian::new(Arc::clone(model));
    jacobian.evaluate(&state, loads).unwrap();
    let (n, m) = (jacobian.size(), model.n_modes());
    let w = Vector3::from_row_slice(&model.velocity(&state)[3..]);
    let here = rates(model, &state, loads);
    check(&format!("{what}: accelerations"), jacobian.accelerations(), &here[m..2 * m + 6]);
    for coordinate in 0..n {
        let mut expected = difference(&state, coordinate, &mut |state| rates(model, state, loads));
        // The turn is relative to a frame that turns itself.
        if (2 * m + 6..2 * m + 9).contains(&coordinate) {
            let theta = Vector3::ith(coordinate - 2 * m - 6, 1.0);
            for (row, x) in w.cross(&theta).iter().enumerate() {
                expected[2 * m + 6 + row] -= x;
            }
        }
        let found: Vec<f64> = jacobian.column(coordinate).collect();
        check(&format!("{what}, column {coordinate}"), &found, &expected);
    }
}

/// The body in free flight, by every method, with all that forces can depend on.
#[test]
fn columns_are_slopes_of_the_rates_in_free_flight() {
    let data = everything(7);
    let full = Model::new(data.clone()).unwrap();
    for method in Method::ALL {
        let model = Arc::new(full.with_method(method).unwrap());
        let case = every_load(model.data());
        check_all(method.name(), &model, &model.prepare(&case).unwrap(), 5);
        check_all(method.name(), &model, &model.no_loads(), 6);
        // What a host sets, on points, on A and on the modes, besides the load case.
        let mut set = LoadSet::with_case(&model, &[1, 3], &case).unwrap();
        let mut random = Random::new(9);
        for frame in [
            LoadFrame::Dead,
            LoadFrame::Body,
            LoadFrame::Follower { section: rotation_rows(&random.vector()) },
        ] {
            assert!(set.add(0, &frame, random.array(1.0), random.array(1.0)));
            assert!(set.add(1, &frame, random.array(1.0), random.array(1.0)));
            set.add_wrench(&frame, random.array(1.0), random.array(1.0));
        }
        assert!(set.add_modal(&vec![0.7; model.n_modes()]));
        check_all(method.name(), &model, &set, 8);
    }
}

/// A load case that moves A, in every way it can say so, and a clamped structure.
#[test]
fn columns_are_slopes_of_the_rates_where_a_is_moved() {
    // Ends at a whole number of half turns: velocities may not jump.
    let sine = |omega| TimeFunction::Sine {
        amplitude: 0.8,
        omega,
        phase: 0.0,
        start: 0.0,
        end: 3.0 * std::f64::consts::PI,
    };
    for (name, data) in [("free-free modes", everything(7)), ("clamped", clamped(8))] {
        let model = Arc::new(Model::new(data).unwrap());
        for kind in 0..8 {
            let drive = |acceleration, omega| Drive {
                acceleration,
                components: [Some(sine(omega)), None, Some(sine(2.0 * omega))],
            };
            let motion = BaseMotion {
                translation: drive(kind & 1 == 0, 2.0),
                rotation: drive(kind & 2 == 0, 3.0),
                inertial: kind & 4 == 0,
            };
            let case = LoadCase { motion: Some(motion), ..every_load(model.data()) };
            check_all(&format!("{name}, motion {kind}"), &model, &model.prepare(&case).unwrap(), 5);
        }
    }
    let model = Arc::new(Model::new(clamped(8)).unwrap());
    let case = every_load(model.data());
    check_all("held", &model, &model.prepare(&case).unwrap(), 5);
}

/// Unit loads: the equations are linear in them.
#[test]
fn columns_of_loads_are_what_they_add() {
    for data in [everything(7), clamped(8)] {
        let model = Arc::new(Model::new(data).unwrap());
        let (state, none) = (random_state(&model, 5), model.no_loads());
        let mut jacobian = Jacobian::new(model.clone());
        jacobian.evaluate(&state, &none).unwrap();
        let before = rates(&model, &state, &none);
        let mut random = Random::new(9);
        for kind in 0..3 {
            let mut set = LoadSet::new(&model, &[2]).unwrap();
            match kind {
                0 => assert!(set.add(0, &LoadFrame::Dead, random.array(1.0), random.array(1.0))),
                1 => set.add_wrench(&LoadFrame::Body, random.array(1.0), random.array(1.0)),
                _ => assert!(set.add_modal(&random.array::<4>(1.0))),
            }
            let mut column = vec![f64::NAN; jacobian.size()];
            jacobian.by_load(&set, &mut column).unwrap();
            let after = rates(&model, &state, &set);
            let expected: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
            check("load", &column, &expected);
        }
    }
}

/// A host that moves A: derivatives of the accelerations and of its wrench by the state and by the rate it gives.
#[test]
fn columns_are_slopes_where_a_host_moves_a() {
    for data in [everything(7), clamped(8)] {
        let model = Arc::new(Model::new(data).unwrap());
        let loads = model.prepare(&every_load(model.data())).unwrap();
        let state = random_state(&model, 5);
        let mut rate: [f64; 6] = Random::new(4).array(1.0);
        let mut simulation = Simulation::new(Arc::clone(&model), Settings::default()).unwrap();
        let mut at = |state: &State, rate: &[f64; 6]| -> (Vec<f64>, Vec<f64>) {
            let motion = PrescribedMotion {
                velocity: model.velocity(state),
                rate: *rate,
                attitude: state.attitude,
                position: state.position,
            };
            simulation.restore(state).unwrap();
            simulation.prescribe(&loads, &motion).unwrap();
            (simulation.state().u_dot.clone(), simulation.reaction().unwrap().total().to_vec())
        };
        let mut jacobian = Jacobian::new(model.clone());
        jacobian.evaluate_prescribed(&state, &loads, &rate).unwrap();
        let (n, m) = (jacobian.size(), model.n_modes());
        for coordinate in 0..n {
            let found: Vec<f64> = jacobian.column(coordinate).skip(m).take(m + 6).collect();
            check("accelerations", &found, &difference(&state, coordinate, &mut |s| at(s, &rate).0));
            let found: Vec<f64> = (0..6).map(|row| jacobian.reaction()[row * n + coordinate]).collect();
            check("reaction", &found, &difference(&state, coordinate, &mut |s| at(s, &rate).1));
        }
        for component in 0..6 {
            let mut column = vec![0.0; n];
            let wrench = jacobian.by_rate(component, &mut column).unwrap();
            let before = at(&state, &rate);
            rate[component] += 1.0;
            let after = at(&state, &rate);
            rate[component] -= 1.0;
            let grown = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
            check("rate", &column[m..2 * m + 6], &grown(&after.0, &before.0));
            check("wrench of the rate", &wrench, &grown(&after.1, &before.1));
        }
        let free =
            jacobian.evaluate(&state, &model.no_loads()).map(|()| jacobian.by_rate(0, &mut vec![0.0; n]));
        let refused = matches!(free, Ok(Err(StepError::NotInFrameA { .. })));
        assert!(refused || model.is_clamped(), "{free:?}");
    }
}

/// All numbers of a ledger.
fn sums(ledger: &Ledger) -> impl Iterator<Item = f64> {
    let vectors = [ledger.r_cm_g, ledger.linear_momentum_g, ledger.angular_momentum_g];
    let energies = [ledger.kinetic_energy, ledger.elastic_energy, ledger.gravity_energy];
    vectors.into_iter().flatten().chain(energies)
}

/// Outputs of points, sensors and A, momenta and energies along states and loads.
#[test]
fn outputs_change_as_their_slopes_say() {
    let full = Model::new(everything(7)).unwrap();
    for method in [Method::Rom, Method::MeanAxes, Method::Rigid] {
        let model = Arc::new(full.with_method(method).unwrap());
        let loads = model.prepare(&every_load(model.data())).unwrap();
        let state = random_state(&model, 5);
        let m = model.n_modes();
        let outputs = |state: &State, u_dot: &[f64]| -> Vec<f64> {
            let rigid = model.rigid_output(state);
            let point = model.point_output(state, 3).unwrap();
            let motion = model.point_motion(state, u_dot, 3).unwrap();
            let sensor = model.sensor_reading(state, u_dot, 0).unwrap();
            let three = [
                rigid.r_g,
                rigid.v_a,
                rigid.w_a,
                rigid.v_g,
                rigid.w_g,
                point.dr_a,
                point.r_g,
                motion.v_g,
                motion.w_g,
                motion.a_g,
                motion.alpha_g,
                sensor.a,
                sensor.w,
                sensor.alpha,
            ];
            let four = [rigid.zeta, motion.attitude];
            let vectors = three.iter().flatten().chain(four.iter().flatten()).copied();
            vectors.chain(model.frame_rate(state, u_dot).unwrap()).chain(sums(&model.ledger(state))).collect()
        };
        let slopes = |jacobian: &mut Jacobian, along: Direction<'_>| -> Vec<f64> {
            let rigid = jacobian.rigid_output(along);
            let point = jacobian.point_output(along, 3).unwrap();
            let motion = jacobian.point_motion(along, 3).unwrap();
            let sensor = jacobian.sensor_reading(along, 0).unwrap();
            let three = [
                rigid.r_g,
                rigid.v_a,
                rigid.w_a,
                rigid.v_g,
                rigid.w_g,
                point.dr_a,
                point.r_g,
                motion.v_g,
                motion.w_g,
                motion.a_g,
                motion.alpha_g,
                sensor.a,
                sensor.w,
                sensor.alpha,
            ];
            let four = [rigid.zeta, motion.attitude];
            let vectors = three.iter().flatten().chain(four.iter().flatten()).copied();
            vectors.chain(jacobian.frame_rate(along)).chain(sums(&jacobian.ledger(along))).collect()
        };
        let mut jacobian = Jacobian::new(model.clone());
        jacobian.evaluate(&state, &loads).unwrap();
        let n = jacobian.size();
        for coordinate in 0..n {
            let mut direction = vec![0.0; n];
            direction[coordinate] = 1.0;
            let column: Vec<f64> = jacobian.column(coordinate).collect();
            let along = Direction { state: &direction, u_dot: &column[m..2 * m + 6] };
            let expected = difference(&state, coordinate, &mut |state| {
                outputs(state, &rates(&model, state, &loads)[m..2 * m + 6])
            });
            check(
                &format!("{}, column {coordinate}", method.name()),
                &slopes(&mut jacobian, along),
                &expected,
            );
        }
        let mut unit = LoadSet::new(&model, &[1]).unwrap();
        assert!(unit.add(0, &LoadFrame::Dead, [1.0, 0.5, 0.2], [0.1, -0.2, 0.4]));
        let mut column = vec![0.0; n];
        jacobian.by_load(&unit, &mut column).unwrap();
        let along = Direction { state: &[], u_dot: &column[m..2 * m + 6] };
        let u_dot = jacobian.accelerations().to_vec();
        let loaded: Vec<f64> = u_dot.iter().zip(&column[m..]).map(|(a, b)| a + b).collect();
        let grown: Vec<f64> =
            outputs(&state, &loaded).iter().zip(outputs(&state, &u_dot)).map(|(a, b)| a - b).collect();
        // Outputs are linear in the accelerations.
        check("along a load", &slopes(&mut jacobian, along), &grown);
    }
}

/// A host that steps by the implicit Euler rule: with this Jacobian, every Newton correction squares the error.
#[test]
fn an_implicit_step_of_a_host_converges_quadratically() {
    let model = Arc::new(Model::new(everything(7)).unwrap());
    let loads = model.prepare(&every_load(model.data())).unwrap();
    let start = random_state(&model, 5);
    let (m, dt) = (model.n_modes(), 0.08);
    let mut jacobian = Jacobian::new(model.clone());
    let n = jacobian.size();
    let mut next = start.clone();
    let mut errors = Vec::new();
    for _ in 0..7 {
        jacobian.evaluate(&next, &loads).unwrap();
        let rate = rates(&model, &next, &loads);
        let turn = quaternion(start.attitude).inverse() * quaternion(next.attitude);
        let turned = turn.scaled_axis();
        let change = next.q.iter().zip(&start.q).chain(next.q_dot.iter().zip(&start.q_dot));
        let change = change.chain(next.beta_star.iter().zip(&start.beta_star)).map(|(a, b)| a - b);
        let change = change.chain(turned.iter().copied());
        let change = change.chain(next.position.iter().zip(&start.position).map(|(a, b)| a - b));
        let residual = DVector::from_iterator(n, change.zip(&rate).map(|(x, f)| x - dt * f));
        errors.push(residual.norm());
        // The turn of the step is a vector phi with d phi = T(phi)^-1 theta, and its rate w, which does not depend on the turn.
        let mut a = DMatrix::identity(n, n) - dt * DMatrix::from_row_slice(n, n, jacobian.matrix());
        let inverse = tangential(&turned).try_inverse().unwrap();
        a.view_mut((2 * m + 6, 2 * m + 6), (3, 3)).copy_from(&inverse);
        let step = a.lu().solve(&-residual).unwrap();
        for i in 0..m {
            next.q[i] += step[i];
            next.q_dot[i] += step[m + i];
        }
        for k in 0..6 {
            next.beta_star[k] += step[2 * m + k];
        }
        let theta = Vector3::new(step[2 * m + 6], step[2 * m + 7], step[2 * m + 8]);
        let turned = quaternion(next.attitude) * UnitQuaternion::from_scaled_axis(theta);
        next.attitude = [turned.w, turned.i, turned.j, turned.k];
        for k in 0..3 {
            next.position[k] += step[2 * m + 9 + k];
        }
    }
    // Errors e, C e^2, C^3 e^4, ..: each exponent twice the one before, until round-off.
    let orders: Vec<f64> =
        errors.windows(3).filter(|e| e[2] > 1e-13).map(|e| (e[2] / e[1]).ln() / (e[1] / e[0]).ln()).collect();
    assert!(errors[5] < 1e-12, "{errors:?}");
    assert!(orders.last().is_some_and(|order| (1.7..2.5).contains(order)), "{orders:?} {errors:?}");
}

/// `T(theta)`, by quadrature of `exp(-s theta~)` over s from 0 to 1.
fn tangential(theta: &Vector3<f64>) -> Matrix3<f64> {
    // Simpson's rule on a hundred pieces: error 1e-11 of the fourth power of the angle.
    let pieces = 100;
    let at = |s: f64| UnitQuaternion::from_scaled_axis(-s * theta).to_rotation_matrix().into_inner();
    (0..pieces)
        .map(|k| {
            let (a, b) = (f64::from(k) / f64::from(pieces), f64::from(k + 1) / f64::from(pieces));
            (at(a) + 4.0 * at(0.5 * (a + b)) + at(b)) * (b - a) / 6.0
        })
        .sum()
}

#[test]
fn states_and_loads_of_another_model_are_refused() {
    let model = Arc::new(Model::new(everything(7)).unwrap());
    let other = Model::new(Lumped::random(2, 4).data(4)).unwrap();
    let mut jacobian = Jacobian::new(model.clone());
    let error = jacobian.evaluate(&State::at_rest(&other), &model.no_loads()).unwrap_err();
    assert_eq!(error.to_string(), "the state is that of another model (2 modes, this one has 4)");
    let error = jacobian.evaluate(&State::at_rest(&model), &other.no_loads()).unwrap_err();
    assert!(matches!(error, StepError::ForeignLoads { .. }), "{error}");
    let mean = Arc::new(model.with_method(Method::MeanAxes).unwrap());
    let error = Jacobian::new(mean.clone())
        .evaluate_prescribed(&State::at_rest(&mean), &mean.no_loads(), &[0.0; 6])
        .unwrap_err();
    assert!(matches!(error, StepError::NotInFrameA { .. }), "{error}");
}
