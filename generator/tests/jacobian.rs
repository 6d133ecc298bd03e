//! Derivatives of the equations of motion of models with consistent inertia, against differences of the runtime.

use std::sync::Arc;

use rom_generator::input::Structure;
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build};
use rom_runtime::{
    Direction, Jacobian, Ledger, LoadFrame, LoadSet, Model, PrescribedMotion, Settings, Simulation, State,
    StateRate, Workspace,
};

fn model(elastic: Elastic) -> Arc<Model> {
    let text = include_str!("../../models/fmb.toml");
    let sets = [("sigma".to_owned(), "10".to_owned()), ("elements".to_owned(), "24".to_owned())];
    let structure = Structure::from_toml_str(text, "fmb.toml", &sets).unwrap_or_else(|e| panic!("{e}"));
    let options = BuildOptions {
        modes: ModeSelection::Count(4),
        all_nodes: false,
        inertia: Inertia::Consistent,
        elastic,
        ..BuildOptions::default()
    };
    Arc::new(Model::new(build(&structure, &options, &mut |_| ()).unwrap()).unwrap())
}

/// Amplitudes at half their range, everything in motion.
fn moving(model: &Model) -> State {
    let mut state = State::at_rest(model);
    let range = &model.data().lagrangian.as_ref().unwrap().range;
    for (i, range) in range.iter().enumerate() {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        state.q[i] = 0.5 * sign * range / (1.0 + i as f64);
        state.q_dot[i] = 0.2 * range * model.data().modes.omega[i] / (1.0 + i as f64);
    }
    state.beta_star = [0.7, -0.4, 0.2, 0.5, -0.8, 1.1];
    let turn = nalgebra::UnitQuaternion::from_euler_angles(0.4, -0.9, 1.3);
    state.attitude = [turn.w, turn.i, turn.j, turn.k];
    state
}

/// The state moved along a coordinate of the Jacobian.
fn moved(state: &State, coordinate: usize, h: f64) -> State {
    let (m, mut next) = (state.q.len(), state.clone());
    if coordinate < m {
        next.q[coordinate] += h;
    } else if coordinate < 2 * m {
        next.q_dot[coordinate - m] += h;
    } else if coordinate < 2 * m + 6 {
        next.beta_star[coordinate - 2 * m] += h;
    } else if coordinate < 2 * m + 9 {
        let [w, x, y, z] = state.attitude;
        let mut theta = nalgebra::Vector3::zeros();
        theta[coordinate - 2 * m - 6] = h;
        let turn = nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
            * nalgebra::UnitQuaternion::from_scaled_axis(theta);
        next.attitude = [turn.w, turn.i, turn.j, turn.k];
    } else {
        next.position[coordinate - 2 * m - 9] += h;
    }
    next
}

/// Of `of`, along a coordinate, over three steps to either side: exact for the polynomials of the inertia; what turns is within
/// `h^6/140` of its seventh derivative.
fn difference(state: &State, coordinate: usize, of: &dyn Fn(&State) -> Vec<f64>) -> Vec<f64> {
    let h = 0.02;
    let rule = [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)];
    let slopes = rule.map(|(k, weight)| {
        let (after, before) = (moved(state, coordinate, k * h), moved(state, coordinate, -k * h));
        of(&after).iter().zip(of(&before)).map(|(a, b)| weight / h * (a - b)).collect::<Vec<f64>>()
    });
    (0..slopes[0].len()).map(|i| slopes.iter().map(|slope| slope[i]).sum()).collect()
}

/// Differences lose round-off of accelerations (some hundred) over the step, relative to the column.
fn check(what: &str, found: &[f64], expected: &[f64]) {
    let scale = expected.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
    for (row, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() < 1e-10 * scale, "{what}, row {row}: {found} instead of {expected}");
    }
}

/// Centre of mass, momenta, energies.
fn sums(of: &Ledger) -> Vec<f64> {
    let vectors = [of.r_cm_g, of.linear_momentum_g, of.angular_momentum_g].concat();
    [&vectors[..], &[of.kinetic_energy, of.elastic_energy, of.gravity_energy]].concat()
}

#[test]
fn columns_of_consistent_models_are_slopes_of_the_rates() {
    for elastic in [Elastic::Linear, Elastic::Geometric] {
        let model = model(elastic);
        let m = model.n_modes();
        let (p, q) = (model.point("P").unwrap(), model.point("Q").unwrap());
        let mut loads = LoadSet::new(&model, &[p, q]).unwrap();
        let section = LoadFrame::Follower { section: model.data().points[p].sections[0].1 };
        for frame in [LoadFrame::Dead, LoadFrame::Body, section] {
            assert!(loads.add(0, &frame, [20.0, -30.0, 10.0], [5.0, 3.0, -4.0]));
            assert!(loads.add(1, &frame, [-10.0, 15.0, 25.0], [2.0, -6.0, 1.0]));
        }
        loads.add_wrench(&LoadFrame::Dead, [5.0, 1.0, -2.0], [3.0, 2.0, 1.0]);
        let gravity = [0.5, -1.0, -9.0];
        let mut jacobian = Jacobian::new(model.clone());
        jacobian.set_gravity(gravity);
        let u_dot_of = |state: &State| {
            let (mut work, mut rate) = (Workspace::new(&model), StateRate::new(&model));
            work.set_gravity(gravity);
            model.derivatives(state, &loads, &mut work, &mut rate).unwrap();
            rate.u_dot
        };
        let accelerations_of_p = |state: &State| {
            let motion = model.point_motion(state, &u_dot_of(state), p).unwrap();
            [motion.a_g, motion.alpha_g].concat()
        };
        let state = moving(&model);
        jacobian.evaluate(&state, &loads).unwrap();
        check("accelerations", jacobian.accelerations(), &u_dot_of(&state));
        for coordinate in 0..jacobian.size() {
            let what = format!("{elastic:?}, column {coordinate}");
            let column: Vec<f64> = jacobian.column(coordinate).skip(m).take(m + 6).collect();
            check(&what, &column, &difference(&state, coordinate, &u_dot_of));
            let mut direction = vec![0.0; jacobian.size()];
            direction[coordinate] = 1.0;
            let along = Direction { state: &direction, u_dot: &column };
            let motion = jacobian.point_motion(along, p).unwrap();
            let expected = difference(&state, coordinate, &accelerations_of_p);
            check(&format!("{what}, P"), &[motion.a_g, motion.alpha_g].concat(), &expected);
            let found = jacobian.ledger(along);
            check(
                &format!("{what}, sums"),
                &sums(&found),
                &difference(&state, coordinate, &|state| {
                    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
                    simulation.set_gravity(gravity).unwrap();
                    simulation.restore(state).unwrap();
                    sums(&simulation.ledger())
                }),
            );
        }
        // A moved by a host: accelerations of the modes, and the wrench on the host.
        let rate = [0.4, -0.3, 0.2, 0.5, 0.1, -0.6];
        let held = |state: &State| {
            let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
            simulation.set_gravity(gravity).unwrap();
            simulation.restore(state).unwrap();
            let motion = PrescribedMotion {
                velocity: model.velocity(state),
                rate,
                attitude: state.attitude,
                position: state.position,
            };
            simulation.prescribe(&loads, &motion).unwrap();
            let mut found = simulation.state().u_dot.clone();
            found.extend(simulation.reaction().unwrap().total());
            found
        };
        jacobian.evaluate_prescribed(&state, &loads, &rate).unwrap();
        for coordinate in 0..jacobian.size() {
            let wrench = jacobian.reaction().chunks(jacobian.size()).map(|row| row[coordinate]);
            let found: Vec<f64> = jacobian.column(coordinate).skip(m).take(m + 6).chain(wrench).collect();
            check(
                &format!("{elastic:?}, held, column {coordinate}"),
                &found,
                &difference(&state, coordinate, &held),
            );
        }
        jacobian.evaluate(&state, &loads).unwrap();

        // A unit load adds what the column says.
        let before = u_dot_of(&state);
        let mut unit = LoadSet::new(&model, &[q]).unwrap();
        assert!(unit.add(0, &LoadFrame::Dead, [1.0, 0.0, 2.0], [0.0, 3.0, 0.0]));
        let mut column = vec![0.0; jacobian.size()];
        jacobian.by_load(&unit, &mut column).unwrap();
        assert!(loads.add(1, &LoadFrame::Dead, [1.0, 0.0, 2.0], [0.0, 3.0, 0.0]));
        let (mut work, mut rate) = (Workspace::new(&model), StateRate::new(&model));
        work.set_gravity(gravity);
        model.derivatives(&state, &loads, &mut work, &mut rate).unwrap();
        let grown: Vec<f64> = rate.u_dot.iter().zip(&before).map(|(a, b)| a - b).collect();
        check("unit load", &column[m..2 * m + 6], &grown);
    }
}
