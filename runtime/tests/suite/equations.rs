//! The equations of motion against plain sums over the tensors, and loads against virtual work.

use crate::common::{Lumped, Random, case, random_state, rotation_rows};
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};
use rom_runtime::data::{LineData, StationSet};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    DistributedFrame, DistributedLoad, Load, LoadFrame, LoadSet, Method, Model, State, StateRate, Workspace,
};

/// A force and a moment in every frame on several points.
fn all_frames(random: &mut Random, n_points: usize) -> Vec<Load> {
    let mut loads = Vec::new();
    for point in 0..n_points as u32 {
        for frame in [
            LoadFrame::Dead,
            LoadFrame::Body,
            LoadFrame::Follower { section: rotation_rows(&random.vector()) },
        ] {
            loads.push(Load {
                point,
                frame,
                force: random.array(3.0),
                moment: random.array(2.0),
                time: TimeFunction::Constant { value: 0.5 + random.next() },
            });
        }
    }
    loads
}

/// Dense quadruple loop over the tensors with the mass matrix solved as a whole, no loads.
fn accelerations_by_loops(model: &Model, state: &State) -> DVector<f64> {
    let (data, m) = (model.data(), model.n_modes());
    let n = m + 6;
    let u: Vec<f64> = state.q_dot.iter().chain(&state.beta_star).copied().collect();
    let phi_r = |r: usize, i: usize| data.modes.phi_r[r * m + i];
    let beta: [f64; 6] = std::array::from_fn(|r| {
        state.beta_star[r] + (0..m).map(|i| phi_r(r, i) * state.q_dot[i]).sum::<f64>()
    });
    let mut c = vec![0.0; n * n * 6];
    let mut k = vec![0.0; n * m * 36];
    for (entry, value) in data.c.value.iter().enumerate() {
        let (i, l, r) = (data.c.i[entry] as usize, data.c.l[entry] as usize, data.c.r[entry] as usize);
        c[(i * n + l) * 6 + r] = *value;
    }
    for (entry, value) in data.k.value.iter().enumerate() {
        let (i, l, rs) = (data.k.i[entry] as usize, data.k.l[entry] as usize, data.k.r[entry] as usize);
        k[(i * m + l) * 36 + rs] = *value;
    }
    let mut force = DVector::zeros(n);
    let mut mass = DMatrix::zeros(n, n);
    for i in 0..n {
        for l in 0..n {
            for r in 0..6 {
                force[i] -= c[(i * n + l) * 6 + r] * u[l] * beta[r];
                for s in 0..6 {
                    if l < m {
                        force[i] -= k[(i * m + l) * 36 + 6 * r + s] * state.q[l] * beta[r] * beta[s];
                    }
                }
            }
        }
        if i < m {
            let (omega, mass_i) = (data.modes.omega[i], data.modes.mass[i]);
            let ratio = data.modes.damping_ratio[i];
            force[i] -= mass_i * omega * (omega * state.q[i] + 2.0 * ratio * state.q_dot[i]);
            mass[(i, i)] = mass_i;
        } else {
            for j in m..n {
                mass[(i, j)] = data.rigid.mass_matrix[(i - m) * 6 + j - m];
            }
        }
    }
    mass.lu().solve(&force).unwrap()
}

#[test]
fn evaluation_equals_plain_loops() {
    for (m, seed) in [(0, 1), (1, 2), (4, 3), (11, 4)] {
        let mut lumped = Lumped::random(m, seed);
        lumped.damping_ratio = 0.03;
        let model = Model::new(lumped.data(seed)).unwrap();
        let mut random = Random::new(seed);
        let (mut work, mut rate) = (Workspace::new(&model), StateRate::new(&model));
        for _ in 0..5 {
            let state = random_state(&model, &mut random);
            model.derivatives(&state, &model.no_loads(), &mut work, &mut rate).unwrap();
            let expected = accelerations_by_loops(&model, &state);
            let error = (DVector::from_vec(rate.u_dot.clone()) - &expected).norm() / expected.norm();
            // A few hundred roundings, times the condition of M_RR (below 1e2).
            assert!(error < 1e-12, "{m} modes: relative difference {error:e}");
            assert_eq!(rate.q_dot, state.q_dot);
        }
    }
}

#[test]
fn kinematic_rates_are_those_of_the_attitude_and_position() {
    let model = Model::new(Lumped::random(3, 5).data(5)).unwrap();
    let state = random_state(&model, &mut Random::new(6));
    let (mut work, mut rate) = (Workspace::new(&model), StateRate::new(&model));
    model.derivatives(&state, &model.no_loads(), &mut work, &mut rate).unwrap();
    let beta = model.velocity(&state);
    let attitude = state.attitude_quaternion();
    let v = attitude * Vector3::new(beta[0], beta[1], beta[2]);
    assert!((Vector3::from(rate.position_dot) - v).norm() < 1e-14 * v.norm());
    // zeta(t + h) = zeta exp(w h): central difference, error h^2/24 |w|^3 |zeta| plus round-off/h.
    let (h, w) = (1e-5, Vector3::new(beta[3], beta[4], beta[5]));
    let moved = |h: f64| (attitude * UnitQuaternion::from_scaled_axis(h * w)).into_inner();
    let slope = (moved(0.5 * h) - moved(-0.5 * h)) / h;
    for (found, expected) in rate.attitude_dot.iter().zip([slope.w, slope.i, slope.j, slope.k]) {
        assert!((found - expected).abs() < 1e-9, "{found} instead of {expected}");
    }
}

/// Where a loaded point and its triad are in G.
fn placement(model: &Model, state: &State, point: usize) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let (data, m) = (&model.data().points[point], model.n_modes());
    let sum = |phi: &[f64]| -> Vector3<f64> {
        Vector3::from_fn(|row, _| (0..m).map(|mode| phi[row * m + mode] * state.q[mode]).sum())
    };
    let [w, x, y, z] = data.node_rotation;
    let node = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z))
        * UnitQuaternion::from_scaled_axis(sum(&data.phi_rotation));
    let in_a =
        Vector3::from(data.node_position) + sum(&data.phi_translation) + node * Vector3::from(data.offset);
    let attitude = state.attitude_quaternion();
    (Vector3::from(state.position) + attitude * in_a, attitude * node)
}

/// The state a small time `h` later, velocities held.
fn moved(model: &Model, state: &State, h: f64) -> State {
    let beta = model.velocity(state);
    let mut moved = state.clone();
    for (q, q_dot) in moved.q.iter_mut().zip(&state.q_dot) {
        *q += h * q_dot;
    }
    let attitude = state.attitude_quaternion();
    let turned = attitude * UnitQuaternion::from_scaled_axis(h * Vector3::new(beta[3], beta[4], beta[5]));
    moved.attitude = [turned.w, turned.i, turned.j, turned.k];
    let v = attitude * Vector3::new(beta[0], beta[1], beta[2]);
    moved.position = (Vector3::from(state.position) + h * v).into();
    moved
}

/// Power of generalised loads, `Q . (q_dot, beta*)`: `M u_dot` with and without the loads.
fn power_of_generalised_loads<L: rom_runtime::Loads>(model: &Model, state: &State, loads: &L) -> f64 {
    let (mut work, mut with, mut without) =
        (Workspace::new(model), StateRate::new(model), StateRate::new(model));
    model.derivatives(state, loads, &mut work, &mut with).unwrap();
    model.derivatives(state, &model.no_loads(), &mut work, &mut without).unwrap();
    let m = model.n_modes();
    let difference: Vec<f64> = with.u_dot.iter().zip(&without.u_dot).map(|(a, b)| a - b).collect();
    let elastic: f64 = (0..m).map(|i| model.data().modes.mass[i] * difference[i] * state.q_dot[i]).sum();
    let mass = DMatrix::from_row_slice(6, 6, &model.data().rigid.mass_matrix);
    let rigid = DVector::from_column_slice(&state.beta_star)
        .dot(&(mass * DVector::from_column_slice(&difference[m..])));
    elastic + rigid
}

/// Power of the loads as they are: force times velocity of the point, moment times angular velocity of its triad, both
/// from differences of positions.
fn power_of_loads(model: &Model, state: &State, loads: &[Load]) -> f64 {
    let h = 1e-5;
    let (before, after) = (moved(model, state, -0.5 * h), moved(model, state, 0.5 * h));
    let mut power = 0.0;
    for load in loads {
        let point = load.point as usize;
        let ((p0, t0), (p1, t1)) = (placement(model, &before, point), placement(model, &after, point));
        let (velocity, spin) = ((p1 - p0) / h, (t1 * t0.inverse()).scaled_axis() / h);
        let (_, node) = placement(model, state, point);
        let TimeFunction::Constant { value } = load.time else { panic!("constant loads only") };
        let to_g = |x: [f64; 3]| match load.frame {
            LoadFrame::Dead => Vector3::from(x),
            LoadFrame::Body => state.attitude_quaternion() * Vector3::from(x),
            LoadFrame::Follower { section } => {
                let section = nalgebra::Matrix3::from_fn(|row, column| section[row][column]);
                node * (section * Vector3::from(x))
            }
        };
        power += value * (to_g(load.force).dot(&velocity) + to_g(load.moment).dot(&spin));
    }
    power
}

#[test]
fn generalised_loads_do_the_work_of_the_loads() {
    for seed in 1..8 {
        let mut random = Random::new(seed);
        let model = Model::new(Lumped::random(5, seed).data(seed)).unwrap();
        let state = random_state(&model, &mut random);
        for loads in [all_frames(&mut random, 4), all_frames(&mut random, 1)] {
            let prepared = model.prepare(&case(loads.clone())).unwrap();
            let (found, expected) = (
                power_of_generalised_loads(&model, &state, &prepared),
                power_of_loads(&model, &state, &loads),
            );
            // Central difference: h^2/24 times third derivatives of size 1e2, and round-off 1e-15/h times 1e2.
            assert!(
                (found - expected).abs() < 1e-7 * expected.abs().max(1.0),
                "{found} instead of {expected}"
            );
        }
        // One kind at a time: no error can hide behind another.
        for load in all_frames(&mut random, 2) {
            for (force, moment) in [(load.force, [0.0; 3]), ([0.0; 3], load.moment)] {
                let loads = vec![Load { force, moment, ..load.clone() }];
                let prepared = model.prepare(&case(loads.clone())).unwrap();
                let (found, expected) = (
                    power_of_generalised_loads(&model, &state, &prepared),
                    power_of_loads(&model, &state, &loads),
                );
                assert!((found - expected).abs() < 1e-7, "{:?}: {found} instead of {expected}", load.frame);
            }
        }
    }
}

#[test]
fn a_load_set_is_the_load_case_with_the_same_loads() {
    let mut random = Random::new(9);
    let model = Model::new(Lumped::random(4, 9).data(9)).unwrap();
    let state = random_state(&model, &mut random);
    let loads = all_frames(&mut random, 3);
    let mut set = LoadSet::new(&model, &[0, 1, 2]).unwrap();
    assert_eq!(set.points().collect::<Vec<_>>(), [0, 1, 2]);
    for load in &loads {
        let TimeFunction::Constant { value } = load.time else { panic!("constant loads only") };
        assert!(set.add(
            load.point as usize,
            &load.frame,
            load.force.map(|x| value * x),
            load.moment.map(|x| value * x)
        ));
    }
    assert!(!set.add(3, &LoadFrame::Dead, [1.0; 3], [0.0; 3]), "slot 3 does not exist");
    let prepared = model.prepare(&case(loads)).unwrap();
    let (mut work, mut a, mut b) = (Workspace::new(&model), StateRate::new(&model), StateRate::new(&model));
    model.derivatives(&state, &set, &mut work, &mut a).unwrap();
    model.derivatives(&state, &prepared, &mut work, &mut b).unwrap();
    for (a, b) in a.u_dot.iter().zip(&b.u_dot) {
        assert!((a - b).abs() < 1e-13 * b.abs().max(1.0), "{a} instead of {b}");
    }
    set.clear();
    model.derivatives(&state, &set, &mut work, &mut a).unwrap();
    model.derivatives(&state, &model.no_loads(), &mut work, &mut b).unwrap();
    assert_eq!(a, b);
}

#[test]
fn forces_that_are_projected_together_are_the_forces_one_by_one() {
    let mut random = Random::new(19);
    let lumped = Lumped { plain_points: true, ..Lumped::random(4, 19) };
    let whole = Model::new(lumped.data(19)).unwrap();
    for method in Method::ALL {
        let model = whole.with_method(method).unwrap();
        let state = random_state(&model, &mut random);
        let points: Vec<usize> = (0..model.n_points()).collect();
        let mut set = LoadSet::new(&model, &points).unwrap();
        let mut loads = Vec::new();
        for (index, &point) in points.iter().chain(&points).enumerate() {
            // Two functions of time, and one force that has a third for itself.
            let value = if index == 0 { 0.7 } else { [1.5, -0.4][index % 3 % 2] };
            let frame = if index % 2 == 0 { LoadFrame::Dead } else { LoadFrame::Body };
            let force = random.array::<3>(2.0);
            assert!(set.add(point, &frame, force.map(|f| value * f), [0.0; 3]));
            let time = TimeFunction::Constant { value };
            loads.push(Load { point: point as u32, frame, force, moment: [0.0; 3], time });
        }
        let prepared = model.prepare(&case(loads)).unwrap();
        let mut work = Workspace::new(&model);
        let (mut a, mut b) = (StateRate::new(&model), StateRate::new(&model));
        model.derivatives(&state, &set, &mut work, &mut a).unwrap();
        model.derivatives(&state, &prepared, &mut work, &mut b).unwrap();
        let largest = a.u_dot.iter().fold(0.0, |largest: f64, a| largest.max(a.abs()));
        for (a, b) in a.u_dot.iter().zip(&b.u_dot) {
            // Sums of some twenty products each.
            assert!((a - b).abs() < 1e-13 * largest, "{method}: {a} instead of {b}");
        }
    }
}

#[test]
fn a_load_set_adds_to_the_case_it_was_made_with() {
    let mut random = Random::new(10);
    let model = Model::new(Lumped::random(4, 10).data(10)).unwrap();
    let state = random_state(&model, &mut random);
    let loads = all_frames(&mut random, 3);
    let section = LoadFrame::Follower { section: rotation_rows(&random.vector()) };
    let extra = [(2, LoadFrame::Dead), (0, LoadFrame::Body), (2, section)]
        .map(|(point, frame)| (point, frame, random.array::<3>(2.0), random.array::<3>(2.0)));
    // Slots in another order than points, and a point of the case that is none of the set's.
    let mut set = LoadSet::with_case(&model, &[2, 0], &case(loads.clone())).unwrap();
    assert_eq!(set.points().collect::<Vec<_>>(), [2, 0]);
    let mut all = loads.clone();
    for (point, frame, force, moment) in extra {
        assert!(set.add(usize::from(point == 0), &frame, force, moment));
        let time = TimeFunction::Constant { value: 1.0 };
        all.push(Load { point, frame, force, moment, time });
    }
    assert!(!set.add(2, &LoadFrame::Dead, [1.0; 3], [0.0; 3]), "the case's own slots are not the host's");
    let (mut work, mut a, mut b) = (Workspace::new(&model), StateRate::new(&model), StateRate::new(&model));
    let mut agree = |set: &LoadSet, loads: Vec<Load>| {
        model.derivatives(&state, set, &mut work, &mut a).unwrap();
        model.derivatives(&state, &model.prepare(&case(loads)).unwrap(), &mut work, &mut b).unwrap();
        for (a, b) in a.u_dot.iter().zip(&b.u_dot) {
            assert!((a - b).abs() < 1e-13 * b.abs().max(1.0), "{a} instead of {b}");
        }
    };
    agree(&set, all);
    set.clear();
    agree(&set, loads);
}

#[test]
fn outputs_are_where_the_point_is() {
    let model = Model::new(Lumped::random(4, 12).data(12)).unwrap();
    let mut random = Random::new(13);
    for point in 0..3 {
        let state = random_state(&model, &mut random);
        let out = model.point_output(&state, point).unwrap();
        let (expected, _) = placement(&model, &state, point);
        assert!((Vector3::from(out.r_g) - expected).norm() < 1e-13 * expected.norm());
        let rest = State::at_rest(&model);
        let (undeformed, _) = placement(&model, &rest, point);
        let in_a = state.attitude_quaternion().inverse() * (expected - Vector3::from(state.position));
        assert!((Vector3::from(out.dr_a) - (in_a - undeformed)).norm() < 1e-13);
        assert_eq!(model.point_output(&rest, point).unwrap().dr_a, [0.0; 3]);
    }
    assert!(model.point_output(&State::at_rest(&model), model.n_points()).is_none());
}

#[test]
fn ledger_is_the_sum_over_the_masses() {
    // About the undeformed shape (q = 0) the reduced momenta and energy are exact.
    let lumped = Lumped::random(4, 21);
    let model = Model::new(lumped.data(21)).unwrap();
    let mut state = random_state(&model, &mut Random::new(22));
    let (_, phi_s, _) = lumped.modes();
    let shapes = |a: &crate::common::Mass, amplitudes: &[f64]| -> Vector3<f64> {
        let x = &phi_s * DVector::from_column_slice(amplitudes);
        a.shapes.iter().zip(x.iter()).map(|(phi, x)| phi * *x).sum()
    };
    let attitude = state.attitude_quaternion();
    let centre =
        lumped.masses.iter().map(|a| a.mass * (a.position + shapes(a, &state.q))).sum::<Vector3<f64>>()
            / model.data().rigid.mass;
    let expected = Vector3::from(state.position) + attitude * centre;
    assert!((Vector3::from(model.ledger(&state).r_cm_g) - expected).norm() < 1e-12);

    state.q.fill(0.0);
    let beta = model.velocity(&state);
    let (v, w) = (Vector3::new(beta[0], beta[1], beta[2]), Vector3::new(beta[3], beta[4], beta[5]));
    let (mut p, mut l, mut energy) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for a in &lumped.masses {
        let velocity = attitude * (v + w.cross(&a.position) + shapes(a, &state.q_dot));
        p += a.mass * velocity;
        l += a.mass * (Vector3::from(state.position) + attitude * a.position).cross(&velocity);
        energy += 0.5 * a.mass * velocity.norm_squared();
    }
    let ledger = model.ledger(&state);
    assert!((Vector3::from(ledger.linear_momentum_g) - p).norm() < 1e-12 * p.norm());
    assert!((Vector3::from(ledger.angular_momentum_g) - l).norm() < 1e-12 * l.norm());
    assert!((ledger.kinetic_energy - energy).abs() < 1e-12 * energy);
    assert_eq!(ledger.elastic_energy, 0.0);
}

/// Stations at the points of a model, so that loads distributed over them are loads on the points.
fn with_line(mut model: rom_runtime::ModelData) -> rom_runtime::ModelData {
    let mut stations = StationSet::default();
    for point in &mut model.points[..3] {
        point.offset = [0.0; 3];
        stations.position.extend(point.node_position);
        stations.rotation.extend(point.node_rotation);
        stations.phi_translation.extend(&point.phi_translation);
        stations.phi_rotation.extend(&point.phi_rotation);
    }
    model.lines = vec![LineData { name: "wing".into(), length: 2.0, knots: vec![0.0, 1.0], stations }];
    model
}

/// Projected or station by station, in the reduced model and in mean axes.
#[test]
fn distributed_loads_are_the_loads_on_their_stations() {
    let mut random = Random::new(23);
    let model = Model::new(with_line(Lumped::random(5, 9).data(9))).unwrap();
    for model in [model.with_method(Method::MeanAxes).unwrap(), model] {
        for (frame, moments) in [
            (DistributedFrame::Dead, false),
            (DistributedFrame::Body, false),
            (DistributedFrame::Dead, true),
            (DistributedFrame::Body, true),
            (DistributedFrame::Follower, true),
        ] {
            let force: Vec<f64> = (0..9).map(|_| random.next()).collect();
            let moment: Vec<f64> = (0..if moments { 9 } else { 0 }).map(|_| random.next()).collect();
            let time = TimeFunction::Constant { value: 1.3 };
            let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let on_point = |n: usize| Load {
                point: n as u32,
                frame: match frame {
                    DistributedFrame::Dead => LoadFrame::Dead,
                    DistributedFrame::Body => LoadFrame::Body,
                    DistributedFrame::Follower => LoadFrame::Follower { section: one },
                },
                force: [0, 1, 2].map(|k| force[3 * n + k]),
                moment: [0, 1, 2].map(|k| moment.get(3 * n + k).copied().unwrap_or(0.0)),
                time: time.clone(),
            };
            let points = case((0..3).map(on_point).collect());
            let mut line = case(vec![]);
            line.distributed = vec![DistributedLoad {
                member: 0,
                frame,
                force: force.clone(),
                moment: moment.clone(),
                time: time.clone(),
            }];
            let mut work = Workspace::new(&model);
            let state = random_state(&model, &mut random);
            let mut rates = [points, line].map(|case| {
                let mut rate = StateRate::new(&model);
                model.derivatives(&state, &model.prepare(&case).unwrap(), &mut work, &mut rate).unwrap();
                rate.u_dot
            });
            let scale = rates[0].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let [points, line] = &mut rates;
            for (a, b) in points.iter().zip(line) {
                assert!((a - *b).abs() < 1e-13 * scale, "{frame:?} {a} {b}");
            }
        }
    }
}

#[test]
fn distributed_loads_need_the_shapes_of_their_member() {
    let mut data = with_line(Lumped::random(5, 9).data(9));
    data.lines[0].stations = StationSet::default();
    let model = Model::new(data).unwrap();
    let mut line = case(vec![]);
    line.distributed = vec![DistributedLoad {
        member: 0,
        frame: DistributedFrame::Dead,
        force: vec![1.0; 9],
        moment: vec![],
        time: TimeFunction::Constant { value: 1.0 },
    }];
    let error = model.prepare(&line).unwrap_err().to_string();
    assert!(error.contains("member \"wing\"") && error.contains("--all-nodes"), "{error}");
}
