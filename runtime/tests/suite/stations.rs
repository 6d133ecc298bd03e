//! Blocks of stations: the power of what acts on them is that of the generalised loads, and their motion that of points.

use crate::common::{Lumped, Random, random_state, sections_at};
use nalgebra::{UnitQuaternion, Vector3};
use rom_runtime::data::StationsData;
use rom_runtime::{
    DistributedFrame, LoadSet, Method, Model, ModelData, State, StateRate, StationAxes, Stations, Workspace,
};

/// A model whose stations are its first points, in node axes, beside them.
fn with_stations(seed: u64) -> ModelData {
    let mut data = Lumped::random(6, seed).data(seed);
    let mut random = Random::new(seed + 50);
    let sections = sections_at(&data.points[..4]);
    let offset: Vec<f64> = (0..12).map(|_| random.next()).collect();
    for (point, offset) in data.points.iter_mut().zip(offset.as_chunks::<3>().0) {
        point.offset = *offset;
    }
    data.stations = vec![StationsData {
        name: "wing".into(),
        members: vec![("left".into(), 1), ("right".into(), 3)],
        fraction: vec![0.5, 0.0, 0.5, 1.0],
        offset,
        sections,
    }];
    data
}

/// `Q = M (u_dot with - u_dot without)`; modes are orthogonal to the rigid motions.
fn generalised(model: &Model, state: &State, set: &LoadSet) -> Vec<f64> {
    let none = LoadSet::new(model, &[]).unwrap();
    let mut work = Workspace::new(model);
    let mut rates = [StateRate::new(model), StateRate::new(model)];
    model.derivatives(state, set, &mut work, &mut rates[0]).unwrap();
    model.derivatives(state, &none, &mut work, &mut rates[1]).unwrap();
    let jump: Vec<f64> = rates[0].u_dot.iter().zip(&rates[1].u_dot).map(|(a, b)| a - b).collect();
    let m = model.n_modes();
    let mut q: Vec<f64> = jump.iter().zip(&model.data().modes.mass).map(|(u, mass)| u * mass).collect();
    let rigid = &model.data().rigid.mass_matrix;
    q.extend((0..6).map(|i| (0..6).map(|j| rigid[6 * i + j] * jump[m + j]).sum::<f64>()));
    q
}

#[test]
fn power_on_the_stations_is_that_of_the_generalised_loads() {
    let mut random = Random::new(77);
    for seed in 1..6 {
        let model = Model::new(with_stations(seed)).unwrap();
        for model in [model.with_method(Method::MeanAxes).unwrap(), model] {
            let block = model.station_block("wing").unwrap();
            let mut stations = Stations::new(&model, block).unwrap();
            let mut set = LoadSet::with_stations(&model, &[0, 2], &[block], None).unwrap();
            for (frame, axes) in [
                (DistributedFrame::Dead, StationAxes::Inertial),
                (DistributedFrame::Body, StationAxes::Body),
                (DistributedFrame::Follower, StationAxes::Section),
            ] {
                let state = random_state(&model, &mut random);
                let wrenches: Vec<f64> = (0..24).map(|_| random.next()).collect();
                assert!(set.set_stations(0, frame, &wrenches));
                let motion = stations.read(&model, &state, axes).unwrap();
                let rates =
                    motion.velocity.as_chunks::<3>().0.iter().zip(motion.angular_velocity.as_chunks::<3>().0);
                let power: f64 = wrenches
                    .as_chunks::<6>()
                    .0
                    .iter()
                    .zip(rates)
                    .map(|(wrench, (v, w))| {
                        wrench.iter().zip(v.iter().chain(w)).map(|(f, v)| f * v).sum::<f64>()
                    })
                    .sum();
                let u = state.q_dot.iter().chain(&state.beta_star);
                let q = generalised(&model, &state, &set);
                let reduced: f64 = q.iter().zip(u.clone()).map(|(q, u)| q * u).sum();
                // Differences of accelerations lose the digits of what else accelerates the body.
                let scale: f64 = q.iter().zip(u).map(|(q, u)| (q * u).abs()).sum();
                assert!((power - reduced).abs() < 1e-11 * scale, "{frame:?}: {power} {reduced}");
            }
        }
    }
}

#[test]
fn stations_move_as_points_do() {
    let model = Model::new(with_stations(3)).unwrap();
    let mut stations = Stations::new(&model, 0).unwrap();
    let mut random = Random::new(5);
    let state = random_state(&model, &mut random);
    let u_dot = vec![0.0; model.n_modes() + 6];
    let motion = stations.read(&model, &state, StationAxes::Inertial).unwrap().clone();
    let body = stations.read(&model, &state, StationAxes::Body).unwrap().clone();
    let section = stations.read(&model, &state, StationAxes::Section).unwrap().clone();
    let turn = state.attitude_quaternion();
    for n in 0..stations.len() {
        let point = model.point_output(&state, n).unwrap();
        let expected = model.point_motion(&state, &u_dot, n).unwrap();
        let at = |list: &[f64]| Vector3::new(list[3 * n], list[3 * n + 1], list[3 * n + 2]);
        assert!((at(&motion.position) - Vector3::from(point.r_g)).norm() < 1e-13);
        assert!((at(&motion.velocity) - Vector3::from(expected.v_g)).norm() < 1e-13);
        assert!((at(&motion.angular_velocity) - Vector3::from(expected.w_g)).norm() < 1e-13);
        assert!((turn * at(&body.velocity) - at(&motion.velocity)).norm() < 1e-13);
        assert!(
            (turn * at(&body.position) + Vector3::from(state.position) - at(&motion.position)).norm() < 1e-13
        );
        let q = |list: &[f64]| {
            let [w, x, y, z] = [0, 1, 2, 3].map(|k| list[4 * n + k]);
            UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
        };
        assert!((q(&motion.attitude) * at(&section.velocity) - at(&motion.velocity)).norm() < 1e-13);
        assert!(q(&motion.attitude).angle_to(&(turn * q(&body.attitude))) < 1e-13);
        for (a, b) in motion.attitude[4 * n..4 * n + 4].iter().zip(&expected.attitude) {
            assert!((a - b).abs() < 1e-13);
        }
    }
}

#[test]
fn refusals() {
    let model = Model::new(with_stations(3)).unwrap();
    let error = model.station_block("tail").unwrap_err().to_string();
    assert!(error.contains("tail") && error.contains("wing"), "{error}");
    assert!(LoadSet::with_stations(&model, &[], &[1], None).is_err());
    assert!(LoadSet::with_stations(&model, &[], &[0, 0], None).is_err());
    assert!(Stations::new(&model, 1).is_err());
    let mut set = LoadSet::with_stations(&model, &[], &[0], None).unwrap();
    assert!(!set.set_stations(0, DistributedFrame::Body, &[0.0; 18]));
    assert!(!set.set_stations(1, DistributedFrame::Body, &[0.0; 24]));
    let other = Model::new(Lumped::random(3, 1).data(1)).unwrap();
    let mut stations = Stations::new(&model, 0).unwrap();
    assert!(stations.read(&other, &State::at_rest(&other), StationAxes::Body).is_err());
}
