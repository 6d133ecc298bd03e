//! A wrench on frame A and forces on the modes, against loads on points and against virtual work.

use std::sync::Arc;

use crate::common::{Lumped, Random};
use rom_runtime::data::PointData;
use rom_runtime::{
    LoadFrame, LoadSet, Method, Model, PrescribedMotion, Settings, Simulation, State, StateRate, Workspace,
};

/// A model with a point on the reference node, which does not move in A.
fn with_origin(m: usize) -> Model {
    let mut data = Lumped::random(m, 5).data(5);
    data.points.push(PointData {
        name: "A".into(),
        node_position: [0.0; 3],
        node_rotation: [1.0, 0.0, 0.0, 0.0],
        offset: [0.0; 3],
        phi_translation: vec![0.0; 3 * m],
        phi_rotation: vec![0.0; 3 * m],
        sections: vec![],
    });
    Model::new(data).unwrap()
}

fn state(model: &Model, random: &mut Random) -> State {
    let mut state = State::at_rest(model);
    state.q.iter_mut().for_each(|q| *q = 0.3 * random.next());
    state.q_dot.iter_mut().for_each(|q| *q = random.next());
    state.beta_star = random.array(1.0);
    let attitude = nalgebra::UnitQuaternion::from_scaled_axis(random.vector());
    state.attitude = [attitude.w, attitude.i, attitude.j, attitude.k];
    state
}

/// `u_dot` under loads less that without.
fn response(model: &Model, state: &State, loads: &LoadSet) -> Vec<f64> {
    let (mut work, mut rate) = (Workspace::new(model), StateRate::new(model));
    model.derivatives(state, &LoadSet::new(model, &[]).unwrap(), &mut work, &mut rate).unwrap();
    let free = rate.u_dot.clone();
    model.derivatives(state, loads, &mut work, &mut rate).unwrap();
    rate.u_dot.iter().zip(&free).map(|(with, without)| with - without).collect()
}

#[test]
fn a_wrench_on_a_is_a_load_on_the_reference_node() {
    let mut random = Random::new(11);
    for method in Method::ALL {
        let model = with_origin(5).with_method(method).unwrap();
        let point = model.point("A").unwrap();
        let turn = crate::common::rotation_rows(&random.vector());
        for frame in [LoadFrame::Dead, LoadFrame::Body, LoadFrame::Follower { section: turn }] {
            let state = state(&model, &mut random);
            let (force, moment) = (random.array(3.0), random.array(3.0));
            let mut on_point = LoadSet::new(&model, &[point]).unwrap();
            assert!(on_point.add(0, &frame, force, moment));
            let mut on_a = LoadSet::new(&model, &[]).unwrap();
            on_a.add_wrench(&frame, force, moment);
            let (expected, found) = (response(&model, &state, &on_point), response(&model, &state, &on_a));
            let size = expected.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            for (found, expected) in found.iter().zip(&expected) {
                // Both are differences of accelerations of order 10 to 100.
                assert!((found - expected).abs() < 1e-12 * size.max(100.0), "{method}: {found}, {expected}");
            }
            on_a.clear();
            assert!(response(&model, &state, &on_a).iter().all(|x| *x == 0.0));
        }
    }
}

#[test]
fn forces_on_the_modes_act_on_their_rows_alone() {
    let model = with_origin(4);
    let mut random = Random::new(3);
    let state = state(&model, &mut random);
    let mut loads = LoadSet::new(&model, &[]).unwrap();
    assert!(!loads.add_modal(&[1.0; 3]));
    let forces: [f64; 4] = random.array(2.0);
    assert!(loads.add_modal(&forces) && loads.add_modal(&forces));
    let response = response(&model, &state, &loads);
    for (i, response) in response.iter().enumerate() {
        let expected = forces.get(i).map_or(0.0, |force| 2.0 * force / model.data().modes.mass[i]);
        assert!((response - expected).abs() < 1e-12 * 100.0, "row {i}: {response}, {expected}");
    }
}

/// Held, the wrench on A goes to the host whole and moves no mode.
#[test]
fn a_wrench_on_a_held_goes_to_the_host() {
    let model = Arc::new(with_origin(4));
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let mut loads = LoadSet::new(&model, &[]).unwrap();
    loads.add_wrench(&LoadFrame::Body, [1.0, -2.0, 3.0], [0.5, 0.25, -0.125]);
    let still = PrescribedMotion::default();
    simulation.prescribe(&loads, &still).unwrap();
    for _ in 0..50 {
        simulation.step_prescribed(&loads, &still).unwrap();
    }
    let reaction = simulation.reaction().unwrap();
    for (found, expected) in reaction.loads.iter().zip([1.0, -2.0, 3.0, 0.5, 0.25, -0.125]) {
        assert_eq!(*found, expected);
    }
    // Round-off of Phi_R^t Q_R - Phi_R^t Q_R over 50 steps.
    assert!(reaction.increment.iter().chain(&simulation.state().q).all(|x| x.abs() < 1e-13));
}
