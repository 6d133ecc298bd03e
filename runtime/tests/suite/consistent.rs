//! Consistent inertia at large amplitudes: the equations against Newton's law of every mass, and superposed motions of the frame of
//! reference that no body can feel.

use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rom_runtime::data::GravityData;
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    Integrator, Load, LoadFrame, LoadSet, Model, ModelData, PrescribedMotion, Settings, Simulation, State,
    StateRate, Workspace,
};

use crate::common::lagrangian::{Bent, bent};
use crate::common::{Random, case};

const FALL: [f64; 3] = [0.4, -1.1, -2.0];

/// In a field of gravity.
fn falling(clamped: bool) -> (Bent, ModelData) {
    let (masses, mut data) = bent(clamped);
    data.gravity = Some(GravityData { acceleration: FALL, second_moment: vec![] });
    (masses, data)
}

/// Amplitudes, rates and velocities of the order of one.
fn moving(model: &Model, seed: u64) -> State {
    let mut random = Random::new(seed);
    let mut state = State::at_rest(model);
    state.q = random.array::<3>(0.7).to_vec();
    state.q_dot = random.array::<3>(2.0).to_vec();
    state.beta_star = random.array(1.5);
    let turn = UnitQuaternion::from_scaled_axis(2.0 * random.vector());
    state.attitude = [turn.w, turn.i, turn.j, turn.k];
    state.position = random.array(3.0);
    state
}

fn attitude(state: &State) -> UnitQuaternion<f64> {
    let [w, x, y, z] = state.attitude;
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}

/// Sum over the masses of `m (acceleration - fall)` along every freedom: shapes relative to A, translation and rotation of A.
fn newton(masses: &Bent, state: &State, beta: &[f64; 6], q_ddot: &[f64], beta_dot: &[f64; 6]) -> [f64; 9] {
    let vector = |x: &[f64]| Vector3::from_column_slice(x);
    let (v, w, v_dot, w_dot) =
        (vector(&beta[..3]), vector(&beta[3..]), vector(&beta_dot[..3]), vector(&beta_dot[3..]));
    let fall = attitude(state).inverse() * vector(&FALL);
    let mut out = [0.0; 9];
    for (k, mass) in masses.mass.iter().enumerate() {
        let (x, d, second) = masses.at(k, &state.q, &state.q_dot);
        let x_dot: Vector3<f64> = (0..3).map(|i| d[i] * state.q_dot[i]).sum();
        let x_ddot = second + (0..3).map(|i| d[i] * q_ddot[i]).sum::<Vector3<f64>>();
        let felt =
            v_dot + w.cross(&v) + w_dot.cross(&x) + w.cross(&w.cross(&x)) + 2.0 * w.cross(&x_dot) + x_ddot
                - fall;
        let moment = x.cross(&felt);
        let along = d.iter().map(|d| d.dot(&felt)).chain(felt.iter().copied()).chain(moment.iter().copied());
        out.iter_mut().zip(along).for_each(|(out, along)| *out += mass * along);
    }
    out
}

/// Elastic forces: those of the frequencies, and of the self-stress `e` whose energy is `e^2/2`.
fn elastic(data: &ModelData, q: &[f64]) -> [f64; 3] {
    let e = 0.3 + 2.0 * q[1] * q[1] - q[1] * q[2] + 1.5 * q[0] * q[0] * q[1];
    let de = [3.0 * q[0] * q[1], 4.0 * q[1] - q[2] + 1.5 * q[0] * q[0], -q[1]];
    std::array::from_fn(|i| data.modes.omega[i].powi(2) * q[i] + e * de[i])
}

#[test]
fn every_mass_obeys_newton() {
    for clamped in [false, true] {
        let (masses, data) = falling(clamped);
        let model = Model::new(data).unwrap();
        let (mut work, mut rate) = (Workspace::new(&model), StateRate::new(&model));
        let loads = model.no_loads();
        for seed in 1..20 {
            let mut state = moving(&model, seed);
            if clamped {
                // At rest, as the clamp has it.
                state.beta_star = [0.0; 6];
            }
            model.derivatives(&state, &loads, &mut work, &mut rate).unwrap();
            let beta = model.velocity(&state);
            let phi = &model.data().modes.phi_r;
            let beta_dot: [f64; 6] = std::array::from_fn(|r| {
                rate.u_dot[3 + r] + (0..3).map(|i| phi[3 * r + i] * rate.u_dot[i]).sum::<f64>()
            });
            let left = newton(&masses, &state, &beta, &rate.u_dot[..3], &beta_dot);
            let elastic = elastic(model.data(), &state.q);
            // Sums of some tens of terms of the order 100: round-off 1e-13, times the condition of the mass matrix.
            let missed = left.iter().zip(&elastic).map(|(left, elastic)| (left + elastic).abs());
            assert!(missed.fold(0.0, f64::max) < 1e-10, "{clamped} {seed}: {left:?} {elastic:?}");
            let held = if clamped { &left[..0] } else { &left[3..] };
            assert!(held.iter().all(|x| x.abs() < 1e-10), "{seed}: {left:?}");
        }
    }
}

/// Moved by a host in any way: the modes obey Newton, and what the masses miss of his law in the motion of A acts on the host.
#[test]
fn a_host_feels_the_inertia_of_every_mass() {
    for clamped in [false, true] {
        let (masses, data) = falling(clamped);
        let model = Arc::new(Model::new(data).unwrap());
        for seed in 1..10 {
            let (state, mut random) = (moving(&model, seed), Random::new(90 + seed));
            let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
            simulation.restore(&state).unwrap();
            let motion = PrescribedMotion {
                velocity: random.array(1.5),
                rate: random.array(4.0),
                attitude: state.attitude,
                position: state.position,
            };
            simulation.prescribe(&model.no_loads(), &motion).unwrap();
            let now = simulation.state();
            let left = newton(&masses, now, &motion.velocity, &now.u_dot[..3], &motion.rate);
            let elastic = elastic(model.data(), &now.q);
            assert!((0..3).all(|i| (left[i] + elastic[i]).abs() < 1e-10), "{left:?} {elastic:?}");
            let told = simulation.reaction().unwrap().total();
            assert!((0..6).all(|i| (left[3 + i] + told[i]).abs() < 1e-10), "{left:?} {told:?}");
        }
    }
}

/// What a body does, under loads that go with it, depends neither on where north is nor on the velocity of the laboratory.
#[test]
fn superposed_rigid_motions_change_nothing_that_a_body_feels() {
    let (_, data) = bent(false);
    let model = Arc::new(Model::new(data).unwrap());
    let start = moving(&model, 3);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -1.9, 0.8));
    let (boost, shift) = (Vector3::new(20.0, -35.0, 10.0), Vector3::new(100.0, 50.0, -70.0));
    let mut moved = start.clone();
    let there = turn * attitude(&start);
    moved.attitude = [there.w, there.i, there.j, there.k];
    moved.position = (turn * Vector3::from(start.position) + shift).into();
    let in_a = there.inverse() * boost;
    (0..3).for_each(|k| moved.beta_star[k] += in_a[k]);
    for integrator in Integrator::ALL {
        let settings = Settings { dt: 0.005, integrator, ..Settings::default() };
        let mut loads = LoadSet::new(&model, &[0, 1]).unwrap();
        let _ = loads.add(0, &LoadFrame::Body, [3.0, -2.0, 1.0], [0.5, 0.0, 1.0]);
        let mut pair = [&start, &moved].map(|state| {
            let mut simulation = Simulation::new(model.clone(), settings).unwrap();
            simulation.restore(state).unwrap();
            simulation
        });
        let mut worst = 0.0_f64;
        for step in 1..=200 {
            pair.iter_mut().for_each(|simulation| simulation.step(&loads).unwrap());
            let [a, b] = pair.each_ref().map(Simulation::state);
            let (va, vb) = (model.velocity(a), model.velocity(b));
            let pairs =
                a.q.iter().zip(&b.q).chain(a.q_dot.iter().zip(&b.q_dot)).chain(va[3..].iter().zip(&vb[3..]));
            let felt = pairs.fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
            // A velocity of 41 m/s rounds accelerations by 41 w eps = 1e-14, of which a step of 5 ms keeps 5e-17. Implicit iterations stop
            // at 32 eps of the velocities, those of the laboratory included: 3e-13 m/s in a step, more in light modes. That of the
            // energy-momentum method may stop at corrections of 1e-12 of the rates, which 200 steps add up.
            let tolerance = match integrator {
                Integrator::Rk4 => 1e-12,
                Integrator::EnergyMomentum => 1e-9,
                _ => 1e-11,
            };
            worst = worst.max(felt);
            assert!(felt < tolerance, "{integrator}, step {step}: {felt:e}");
            let apart = turn * attitude(a);
            let turned =
                (apart.coords - attitude(b).coords).norm().min((apart.coords + attitude(b).coords).norm());
            assert!(turned < tolerance, "{integrator}, step {step}: {turned:e}");
            let expected = turn * Vector3::from(a.position) + shift + boost * a.time;
            let missed = (expected - Vector3::from(b.position)).norm();
            // Runge-Kutta turns the velocity of the laboratory with the axes of A: to fourth order. Positions are of the order 100.
            let tolerance = if integrator == Integrator::Rk4 { 1e-5 } else { 100.0 * tolerance };
            assert!(missed < tolerance, "{integrator}, step {step}: {missed:e}");
        }
        println!("{integrator}: {worst:e}");
        assert!((attitude(&start).inverse() * attitude(pair[0].state())).angle() > 0.1, "it turned");
    }
}

/// A force that grows evenly gives the body its impulse, `1/2 rate T^2`: its mean over every step is that in the middle.
#[test]
fn a_growing_force_gives_its_impulse() {
    let (_, data) = bent(false);
    let model = Arc::new(Model::new(data).unwrap());
    let (force, rate, t_end) = (Vector3::new(3.0, -2.0, 1.0), 5.0, 1.0);
    let load = Load {
        point: 1,
        frame: LoadFrame::Dead,
        force: force.into(),
        moment: [0.0; 3],
        time: TimeFunction::Ramp { rate, start: 0.0, end: f64::MAX },
    };
    let loads = model.prepare(&case(vec![load])).unwrap();
    for integrator in [Integrator::EnergyMomentum, Integrator::Newmark] {
        let settings = Settings { dt: 0.01, integrator, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        simulation.restore(&moving(&model, 4)).unwrap();
        let start = Vector3::from(simulation.ledger().linear_momentum_g);
        for _ in 0..100 {
            simulation.step(&loads).unwrap();
        }
        let gained = Vector3::from(simulation.ledger().linear_momentum_g) - start;
        let impulse = 0.5 * rate * t_end * t_end * force;
        let error = (gained - impulse).norm() / impulse.norm();
        assert!(error < 1e-9, "{integrator}: {error:e}");
    }
}
