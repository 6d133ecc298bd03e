//! Frame A moved by a host: closed solutions, free flight played back, a host that carries the rigid body, energy.

use std::sync::Arc;

use crate::common::{Lumped, Random};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    Integrator, Load, LoadCase, LoadFrame, Method, Model, PreparedLoads, PrescribedMotion, Settings,
    Simulation, State, StateRate, StepError, Workspace,
};

fn loads(model: &Model, size: f64) -> PreparedLoads {
    let mut random = Random::new(31);
    let load = |point, frame| Load {
        point,
        frame,
        force: random.array(size),
        moment: random.array(size),
        time: TimeFunction::Sine { amplitude: 1.0, omega: 3.0, phase: 0.4, start: 0.0, end: f64::MAX },
    };
    let loads = [LoadFrame::Dead, LoadFrame::Body].into_iter().zip(0..).map({
        let mut load = load;
        move |(frame, point)| load(point, frame)
    });
    let case = LoadCase { dt: 0.01, loads: loads.collect(), ..LoadCase::empty("smooth") };
    model.prepare(&case).unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()))
}

/// A mass on a spring along x, 3 m from a body shaken by `x = a sin(W t)`: `m2 y'' + k y = -m2 x''`, from rest relative to
/// the body. The host feels `-(m1 x'' + m2 (x'' + y''))`.
#[test]
fn a_shaken_spring_follows_the_closed_solution() {
    let (m1, m2, k, a, w) = (2.0, 1.0, 100.0, 0.1, 7.0);
    let lumped = Lumped::spring(m1, m2, k);
    let phi = lumped.modes().1[(0, 0)];
    let model = Arc::new(Model::new(lumped.data(1)).unwrap());
    let w0 = f64::sqrt(k / m2);
    // y = b (sin W t - W/w0 sin w0 t), b = a W^2/(w0^2 - W^2)
    let b = a * w * w / (w0 * w0 - w * w);
    let y = |t: f64| b * ((w * t).sin() - w / w0 * (w0 * t).sin());
    let y_ddot = |t: f64| b * (-w * w * (w * t).sin() + w * w0 * (w0 * t).sin());
    let motion = |t: f64| PrescribedMotion {
        velocity: [a * w * (w * t).cos(), 0.0, 0.0, 0.0, 0.0, 0.0],
        rate: [-a * w * w * (w * t).sin(), 0.0, 0.0, 0.0, 0.0, 0.0],
        position: [a * (w * t).sin(), 0.0, 0.0],
        ..Default::default()
    };
    let error = |integrator, dt: f64| {
        let mut simulation =
            Simulation::new(Arc::clone(&model), Settings { dt, integrator, ..Settings::default() }).unwrap();
        let none = model.no_loads();
        simulation.prescribe(&none, &motion(0.0)).unwrap();
        let (mut displacement, mut force) = (0.0_f64, 0.0_f64);
        for step in 1..=(2.0 / dt).round() as usize {
            let t = dt * step as f64;
            simulation.step_prescribed(&none, &motion(t)).unwrap();
            let x_ddot = motion(t).rate[0];
            let reaction = simulation.reaction().unwrap();
            displacement = displacement.max((phi * simulation.state().q[0] - y(t)).abs());
            force = force.max((reaction.total()[0] + m1 * x_ddot + m2 * (x_ddot + y_ddot(t))).abs());
            assert!((reaction.inertia[0] + (m1 + m2) * x_ddot).abs() < 1e-12);
            assert!((reaction.increment[0] + m2 * phi * simulation.state().u_dot[0]).abs() < 1e-10);
        }
        (displacement, force)
    };
    for (integrator, order) in
        [(Integrator::Newmark, 2.0), (Integrator::GeneralizedAlpha, 2.0), (Integrator::Rk4, 4.0)]
    {
        let (coarse, fine) = (error(integrator, 0.01), error(integrator, 0.005));
        for (coarse, fine) in [(coarse.0, fine.0), (coarse.1, fine.1)] {
            let found = (coarse / fine).log2();
            assert!(found > order - 0.2, "{integrator}: order {found} instead of {order}");
        }
        // Second order: phase error (w0 dt)^2/12 w0 t of the amplitude b, 0.8 % at 2 s with the fine step.
        assert!(fine.0 < 0.01 * b, "{integrator}: {}", fine.0);
    }
}

/// The same spring on a body that spins steadily about z: `y'' = -k/m2 y + W^2 (3 + y)`. The host feels the centrifugal
/// force and Coriolis' (the model is linear in y).
#[test]
fn a_spinning_spring_pulls_on_its_host() {
    let (m1, m2, k, w) = (2.0, 1.0, 100.0, 4.0);
    let lumped = Lumped::spring(m1, m2, k);
    let phi = lumped.modes().1[(0, 0)];
    let model = Arc::new(Model::new(lumped.data(1)).unwrap());
    let motion = |t: f64| PrescribedMotion {
        velocity: [0.0, 0.0, 0.0, 0.0, 0.0, w],
        attitude: [(0.5 * w * t).cos(), 0.0, 0.0, (0.5 * w * t).sin()],
        ..Default::default()
    };
    let dt = 1e-3;
    let settings = Settings { dt, integrator: Integrator::Rk4, ..Settings::default() };
    let mut simulation = Simulation::new(Arc::clone(&model), settings).unwrap();
    let none = model.no_loads();
    simulation.prescribe(&none, &motion(0.0)).unwrap();
    let (w1, rest) = ((k / m2 - w * w).sqrt(), w * w * 3.0 / (k / m2 - w * w));
    for step in 1..=2000 {
        let t = dt * f64::from(step);
        simulation.step_prescribed(&none, &motion(t)).unwrap();
        let y = rest * (1.0 - (w1 * t).cos());
        let (y_dot, y_ddot) = (rest * w1 * (w1 * t).sin(), rest * w1 * w1 * (w1 * t).cos());
        // RK4: (w1 dt)^5/120 a step.
        assert!((phi * simulation.state().q[0] - y).abs() < 1e-7);
        let coriolis = -2.0 * m2 * w * y_dot;
        let expected = [m2 * (w * w * (3.0 + y) - y_ddot), coriolis, 0.0, 0.0, 0.0, 3.0 * coriolis];
        let total = simulation.reaction().unwrap().total();
        for (found, expected) in total.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5, "{found} instead of {expected} at {t} s");
        }
    }
}

/// A free flight under loads, its motion of A written down and prescribed again: the modes do the same, and nothing pulls
/// on the host. The implicit integrators fulfil the equations at the end of every step, so that this holds to the
/// tolerance of their iteration.
#[test]
fn free_flight_played_back_leaves_no_reaction() {
    let model = Arc::new(Model::new(Lumped::random(4, 7).data(7)).unwrap());
    let loads = loads(&model, 15.0);
    let mut start = State::at_rest(&model);
    start.beta_star = Random::new(5).array(1.5);
    for (integrator, dt) in
        [(Integrator::Newmark, 0.01), (Integrator::GeneralizedAlpha, 0.01), (Integrator::Newmark, 0.1)]
    {
        let settings = Settings { dt, integrator, ..Settings::default() };
        let mut free = Simulation::new(Arc::clone(&model), settings).unwrap();
        let mut driven = free.clone();
        free.restore(&start).unwrap();
        free.step(&loads).unwrap();
        driven.restore(free.state()).unwrap();
        for _ in 0..(2.0 / dt) as usize {
            free.step(&loads).unwrap();
            driven.step_prescribed(&loads, &model.motion_of(free.state())).unwrap();
            let reaction = driven.reaction().unwrap();
            let size = largest(&reaction.inertia) + largest(&reaction.loads);
            assert!(
                largest(&reaction.total()) < 1e-9 * size,
                "{integrator}: {:?} of {size}",
                reaction.total()
            );
            for (a, b) in free.state().q.iter().zip(&driven.state().q) {
                assert!((a - b).abs() < 1e-11, "{integrator}, dt = {dt}: {a} {b}");
            }
        }
    }
}

/// A host that carries mass and inertia of the undeformed body and adds the elastic increment of the step before.
fn hosted(model: &Arc<Model>, loads: &PreparedLoads, start: &State, dt: f64, t_end: f64) -> Simulation {
    let rigid = model.with_method(Method::Rigid).unwrap();
    let settings = Settings { dt, integrator: Integrator::Rk4, ..Settings::default() };
    let mut simulation = Simulation::new(Arc::clone(model), settings).unwrap();
    simulation.restore(start).unwrap();
    let mass = nalgebra::Matrix6::from_row_slice(&model.data().rigid.mass_matrix);
    let inverse = mass.try_inverse().unwrap();
    let (mut work, mut rate) = (Workspace::new(&rigid), StateRate::new(&rigid));
    let mut body = State::at_rest(&rigid);
    body.beta_star = model.velocity(start);
    let unloaded = rigid.no_loads();
    let motion = |body: &State, rate: [f64; 6]| PrescribedMotion {
        velocity: body.beta_star,
        rate,
        attitude: body.attitude,
        position: body.position,
    };
    simulation.prescribe(loads, &motion(&body, [0.0; 6])).unwrap();
    for _ in 0..(t_end / dt).round() as usize {
        // Rate of the rigid body by the host's own equations, with the wrench of the elastic body.
        let reaction = simulation.reaction().unwrap();
        let wrench = nalgebra::Vector6::from_fn(|i, _| reaction.loads[i] + reaction.increment[i]);
        rigid.derivatives(&body, &unloaded, &mut work, &mut rate).unwrap();
        let beta_dot: Vec<f64> =
            rate.u_dot.iter().zip((inverse * wrench).iter()).map(|(a, b)| a + b).collect();
        // A host of first order.
        for (beta, beta_dot) in body.beta_star.iter_mut().zip(&beta_dot) {
            *beta += dt * beta_dot;
        }
        for (zeta, zeta_dot) in body.attitude.iter_mut().zip(rate.attitude_dot) {
            *zeta += dt * zeta_dot;
        }
        let length = body.attitude.iter().map(|x| x * x).sum::<f64>().sqrt();
        body.attitude.iter_mut().for_each(|x| *x /= length);
        for (r, r_dot) in body.position.iter_mut().zip(rate.position_dot) {
            *r += dt * r_dot;
        }
        let rate = std::array::from_fn(|i| beta_dot[i]);
        simulation.step_prescribed(loads, &motion(&body, rate)).unwrap();
    }
    simulation
}

/// The loosely coupled pair goes to the free flight of the whole model with first order, that of the host and of the
/// exchange.
#[test]
fn a_host_with_the_rigid_body_reproduces_free_flight() {
    let model = Arc::new(Model::new(Lumped::random(4, 7).data(7)).unwrap());
    let loads = loads(&model, 10.0);
    let mut start = State::at_rest(&model);
    start.beta_star = Random::new(5).array(0.5);
    let settings = Settings { dt: 1e-3, integrator: Integrator::Rk4, ..Settings::default() };
    let mut free = Simulation::new(Arc::clone(&model), settings).unwrap();
    free.restore(&start).unwrap();
    for _ in 0..1000 {
        free.step(&loads).unwrap();
    }
    let error = |dt: f64| -> f64 {
        let hosted = hosted(&model, &loads, &start, dt, 1.0);
        let modes = hosted.state().q.iter().zip(&free.state().q).map(|(a, b)| a - b);
        let rigid =
            model.velocity(hosted.state()).into_iter().zip(model.velocity(free.state())).map(|(a, b)| a - b);
        modes.chain(rigid).map(f64::abs).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(4e-4), error(2e-4));
    assert!((coarse / fine - 2.0).abs() < 0.3, "{coarse} {fine}");
    assert!(fine < 5e-3 * largest(&free.state().q), "{fine}");
}

/// Shaken in translation the model's equations are exact, and the work the host does, `-total . beta`, is the growth of the
/// energy. Trapezoidal sum of the work: second order.
#[test]
fn the_work_of_the_host_is_the_growth_of_energy() {
    let model = Arc::new(Model::new(Lumped::random(4, 7).data(7)).unwrap());
    let none = model.no_loads();
    let direction = [0.6, -0.8, 0.5];
    let motion = |t: f64| PrescribedMotion {
        velocity: std::array::from_fn(|i| direction.get(i).map_or(0.0, |d| d * (3.0 * t).sin())),
        rate: std::array::from_fn(|i| direction.get(i).map_or(0.0, |d| 3.0 * d * (3.0 * t).cos())),
        position: direction.map(|d| d * (1.0 - (3.0 * t).cos()) / 3.0),
        ..Default::default()
    };
    let missing = |integrator, dt: f64| {
        let settings = Settings { dt, integrator, ..Settings::default() };
        let mut simulation = Simulation::new(Arc::clone(&model), settings).unwrap();
        simulation.prescribe(&none, &motion(0.0)).unwrap();
        let energy = |s: &Simulation| s.ledger().kinetic_energy + s.ledger().elastic_energy;
        let power = |s: &Simulation, t: f64| -> f64 {
            let total = s.reaction().unwrap().total();
            -total.iter().zip(motion(t).velocity).map(|(f, v)| f * v).sum::<f64>()
        };
        let (before, mut work, mut last) = (energy(&simulation), 0.0, power(&simulation, 0.0));
        for step in 1..=(1.0 / dt).round() as usize {
            let t = dt * step as f64;
            simulation.step_prescribed(&none, &motion(t)).unwrap();
            let now = power(&simulation, t);
            work += 0.5 * dt * (last + now);
            last = now;
        }
        let gained = energy(&simulation) - before;
        assert!(gained.abs() > 0.1, "the host does work: {gained}");
        (work - gained).abs() / gained.abs()
    };
    for integrator in [Integrator::Newmark, Integrator::Rk4, Integrator::GeneralizedAlpha] {
        let (coarse, fine) = (missing(integrator, 0.01), missing(integrator, 0.005));
        assert!(fine < 1e-3 && coarse / fine > 3.5, "{integrator}: {coarse} {fine}");
    }
}

/// Without modes the reaction is Newton's and Euler's, and zero without motion.
#[test]
fn the_rigid_body_resists_with_its_inertia() {
    let model = Arc::new(Model::new(Lumped::rigid_body().data(1)).unwrap());
    let mut simulation = Simulation::new(Arc::clone(&model), Settings::default()).unwrap();
    let none = model.no_loads();
    simulation.step_prescribed(&none, &PrescribedMotion::default()).unwrap();
    assert_eq!(simulation.reaction().unwrap().total(), [0.0; 6]);
    let mut random = Random::new(3);
    let motion =
        PrescribedMotion { velocity: random.array(2.0), rate: random.array(2.0), ..Default::default() };
    simulation.step_prescribed(&none, &motion).unwrap();
    let (v, w) = (
        nalgebra::Vector3::from_row_slice(&motion.velocity[..3]),
        nalgebra::Vector3::from_row_slice(&motion.velocity[3..]),
    );
    let (a, w_dot) = (
        nalgebra::Vector3::from_row_slice(&motion.rate[..3]) + w.cross(&v),
        nalgebra::Vector3::from_row_slice(&motion.rate[3..]),
    );
    // Every mass by its own acceleration.
    let (mut force, mut moment) = (nalgebra::Vector3::zeros(), nalgebra::Vector3::zeros());
    for mass in &Lumped::rigid_body().masses {
        let r = mass.position;
        let inertia = -mass.mass * (a + w_dot.cross(&r) + w.cross(&w.cross(&r)));
        force += inertia;
        moment += r.cross(&inertia);
    }
    let total = simulation.reaction().unwrap().total();
    for (found, expected) in total.iter().zip(force.iter().chain(moment.iter())) {
        assert!((found - expected).abs() < 1e-11, "{found} instead of {expected}");
    }
}

#[test]
fn motions_that_cannot_be_are_refused() {
    let model = Arc::new(Model::new(Lumped::random(3, 7).data(7)).unwrap());
    let mut simulation = Simulation::new(Arc::clone(&model), Settings::default()).unwrap();
    let none = model.no_loads();
    let before = simulation.state().clone();
    let mut motion = PrescribedMotion { attitude: [1.0, 0.1, 0.0, 0.0], ..Default::default() };
    let error = simulation.step_prescribed(&none, &motion).unwrap_err();
    assert_eq!(
        error.to_string(),
        "prescribed motion of frame A: squared length of attitude is 1.01, expected 1 to 1e-6"
    );
    motion = PrescribedMotion { rate: [0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0], ..Default::default() };
    assert!(matches!(simulation.prescribe(&none, &motion), Err(StepError::Motion { what: "rate", .. })));
    assert_eq!(*simulation.state(), before);
    assert_eq!(simulation.reaction(), None);

    let mean = Arc::new(model.with_method(Method::MeanAxes).unwrap());
    let mut simulation = Simulation::new(Arc::clone(&mean), Settings::default()).unwrap();
    let error = simulation.step_prescribed(&mean.no_loads(), &PrescribedMotion::default()).unwrap_err();
    assert!(error.to_string().contains("mean-axes"), "{error}");
}

/// At rest, the increment is what the modes take along of the inertia, times the rate.
#[test]
fn the_increment_grows_with_the_rate_by_what_the_apparent_inertia_lacks() {
    let model = Arc::new(Model::new(Lumped::random(4, 12).data(8)).unwrap());
    let apparent = model.apparent_inertia().unwrap();
    let mass = &model.data().rigid.mass_matrix;
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let mut random = Random::new(5);
    for _ in 0..5 {
        let rate: [f64; 6] = random.array(2.0);
        let motion = PrescribedMotion { rate, ..PrescribedMotion::default() };
        simulation.prescribe(&model.no_loads(), &motion).unwrap();
        let found = simulation.reaction().unwrap().increment;
        let taken = |i: usize| (0..6).map(|j| (mass[6 * i + j] - apparent[i][j]) * rate[j]).sum::<f64>();
        let expected: [f64; 6] = std::array::from_fn(taken);
        for (found, expected) in found.iter().zip(expected) {
            // Differences of inertia forces, whose size is that of M_RR times the rate.
            assert!((found - expected).abs() < 1e-11 * (1.0 + largest(mass)), "{found} {expected}");
        }
        assert!(largest(&found) > 0.0);
    }
    assert!(model.with_method(Method::MeanAxes).unwrap().apparent_inertia().is_err());
    let rigid = model.with_method(Method::Rigid).unwrap().apparent_inertia().unwrap();
    for (found, expected) in rigid.as_flattened().iter().zip(mass) {
        assert!((found - expected).abs() < 1e-12 * largest(mass));
    }
}
