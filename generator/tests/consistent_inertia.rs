//! Reduced models with consistent inertia: what they conserve, and how close they come to the nonlinear method.

use std::sync::Arc;

use nalgebra::{DMatrix, Vector3};
use rom_generator::input::Structure;
use rom_generator::reference::method::{Method, Prepared, RunSettings};
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build};
use rom_runtime::{Batch, Integrator, Model, PictureCurve, Settings, Simulation, State};

fn frame(sigma: &str) -> Structure {
    let text = include_str!("../../models/fmb.toml");
    let sets = [("sigma".to_owned(), sigma.to_owned()), ("elements".to_owned(), "24".to_owned())];
    Structure::from_toml_str(text, "fmb.toml", &sets).unwrap_or_else(|e| panic!("{e}"))
}

fn model(structure: &Structure, modes: usize, elastic: Elastic) -> Arc<Model> {
    let options = BuildOptions {
        modes: ModeSelection::Count(modes),
        all_nodes: false,
        inertia: Inertia::Consistent,
        elastic,
        ..BuildOptions::default()
    };
    Arc::new(Model::new(build(structure, &options, &mut |_| ()).unwrap()).unwrap())
}

/// Amplitudes at half their range, all rates and velocities at work.
fn moving(model: &Model) -> State {
    let mut state = State::at_rest(model);
    let range = &model.data().lagrangian.as_ref().unwrap().range;
    for (i, range) in range.iter().enumerate() {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        state.q[i] = 0.5 * sign * range / (1.0 + i as f64);
        state.q_dot[i] = 0.2 * range * model.data().modes.omega[i] / (1.0 + i as f64);
    }
    state.beta_star = [0.7, -0.4, 0.2, 0.5, -0.8, 1.1];
    state
}

/// Largest relative change of energy, linear and angular momentum, and of the straight path of the centre of mass in m.
fn drift(model: &Arc<Model>, integrator: Integrator, dt: f64, t_end: f64) -> [f64; 4] {
    let settings = Settings { dt, integrator, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    simulation.restore(&moving(model)).unwrap();
    let start = simulation.ledger();
    let energy = start.kinetic_energy + start.elastic_energy;
    let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let minus = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i] - b[i]);
    let loads = model.no_loads();
    let mut worst = [0.0_f64; 4];
    for _ in 0..(t_end / dt).round() as usize {
        simulation.step(&loads).unwrap();
        let now = simulation.ledger();
        let t = simulation.state().time;
        let straight: [f64; 3] = std::array::from_fn(|i| {
            start.r_cm_g[i] + t * start.linear_momentum_g[i] / model.data().rigid.mass
        });
        let changes = [
            ((now.kinetic_energy + now.elastic_energy) / energy - 1.0).abs(),
            norm(minus(now.linear_momentum_g, start.linear_momentum_g)) / norm(start.linear_momentum_g),
            norm(minus(now.angular_momentum_g, start.angular_momentum_g)) / norm(start.angular_momentum_g),
            norm(minus(now.r_cm_g, straight)),
        ];
        worst = std::array::from_fn(|i| worst[i].max(changes[i]));
    }
    worst
}

#[test]
fn a_free_body_keeps_energy_and_momenta() {
    for elastic in [Elastic::Linear, Elastic::Geometric] {
        let model = model(&frame("10"), 6, elastic);
        // Classical Runge-Kutta is of fourth order: all drifts fall by 16 with the step, with a margin for the next order.
        let (coarse, fine) =
            (drift(&model, Integrator::Rk4, 0.01, 2.0), drift(&model, Integrator::Rk4, 0.005, 2.0));
        for (what, (coarse, fine)) in coarse.iter().zip(&fine).enumerate() {
            assert!(
                *coarse < 1e-3 && (*fine < coarse / 10.0 || *fine < 1e-11),
                "{what}: {coarse:e}, {fine:e}"
            );
        }
        // Newmark keeps the momenta to round-off of 200 steps at any step, and the energy to second order.
        for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
            let coarse = drift(&model, integrator, 0.02, 2.0);
            let fine = drift(&model, integrator, 0.01, 2.0);
            for k in 1..4 {
                assert!(coarse[k] < 1e-10 && fine[k] < 1e-10, "{integrator} {k}: {coarse:?} {fine:?}");
            }
            assert!(fine[0] < coarse[0] / 2.0, "{integrator}: {coarse:?} {fine:?}");
        }
    }
}

/// Smallest eigenvalue of the mass matrix at an amplitude of the first modes in turn, over the mass matrix at rest.
fn smallest_mass(model: &Model, size: f64) -> f64 {
    let m = model.n_modes();
    let mass = |q: &[f64]| {
        let kinetic = |rates: &[usize]| {
            let mut state = State::at_rest(model);
            state.q.copy_from_slice(q);
            for &i in rates {
                if i < m { state.q_dot[i] += 1.0 } else { state.beta_star[i - m] += 1.0 }
            }
            model.ledger(&state).kinetic_energy
        };
        let of_one: Vec<f64> = (0..m + 6).map(|i| kinetic(&[i])).collect();
        let entry = |i: usize, j: usize| {
            if i == j { 2.0 * of_one[i] } else { kinetic(&[i, j]) - of_one[i] - of_one[j] }
        };
        DMatrix::from_fn(m + 6, m + 6, entry)
    };
    let inverse = mass(&vec![0.0; m]).cholesky().unwrap().l().try_inverse().unwrap();
    let range = model.data().lagrangian.as_ref().unwrap().range.clone();
    let mut smallest = f64::INFINITY;
    for (i, sign) in [(0, 1.0), (0, -1.0), (1, 1.0)] {
        let mut q = vec![0.0; m];
        q[i] = sign * size * range[i];
        let relative = &inverse * mass(&q) * inverse.transpose();
        smallest = smallest.min(relative.symmetric_eigenvalues().min());
    }
    smallest
}

/// However many modes: what couples their rates with the rotation of a body that others bend must not be dropped. Beyond their range as well,
/// where half as much of it dropped would show.
#[test]
fn deformed_bodies_have_mass_in_every_direction() {
    let hale = Structure::from_toml_str(include_str!("../../models/hale.toml"), "hale.toml", &[])
        .unwrap_or_else(|e| panic!("{e}"));
    for structure in [frame("10"), hale] {
        let least = smallest_mass(&model(&structure, 20, Elastic::Geometric), 1.4);
        assert!(least > 0.0, "{least}");
    }
}

#[test]
fn integrators_agree_on_the_motion() {
    let model = model(&frame("10"), 6, Elastic::Geometric);
    let end = |integrator, dt: f64| {
        let settings = Settings { dt, integrator, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        simulation.restore(&moving(&model)).unwrap();
        let loads = model.prepare(model.load_case("lc1").unwrap()).unwrap();
        for _ in 0..(1.0 / dt).round() as usize {
            simulation.step(&loads).unwrap();
        }
        simulation.state().clone()
    };
    let exact = end(Integrator::Rk4, 0.001);
    let size = exact.q.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let error = |state: &State| {
        let q = state.q.iter().zip(&exact.q).map(|(a, b)| (a - b).abs() / size).fold(0.0, f64::max);
        let attitude =
            state.attitude.iter().zip(&exact.attitude).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        q.max(attitude)
    };
    for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
        let (coarse, fine) = (error(&end(integrator, 0.004)), error(&end(integrator, 0.002)));
        // Second order: 4, with a margin for the next.
        assert!(fine < coarse / 3.0 && fine < 0.02, "{integrator}: {coarse:e} {fine:e}");
    }
}

/// Implicit steps carry momenta from one to the next; a copy of the state, whole or flat, carries them too.
#[test]
fn copies_of_a_state_and_batches_go_on_with_the_same_bits() {
    let model = model(&frame("10"), 4, Elastic::Geometric);
    let loads = model.prepare(model.load_case("lc2").unwrap()).unwrap();
    for integrator in Integrator::of(&model) {
        let damping = if integrator == Integrator::GeneralizedAlpha { 0.1 } else { 0.0 };
        let settings = Settings { dt: 0.01, integrator, numerical_damping: damping, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        simulation.restore(&moving(&model)).unwrap();
        for _ in 0..20 {
            simulation.step(&loads).unwrap();
        }
        let here = simulation.state().clone();
        let mut flat = vec![0.0; model.flat_layout().size()];
        assert!(here.write_flat(&mut flat));
        let mut copy = State::at_rest(&model);
        assert!(copy.read_flat(&flat));
        assert_eq!(copy, here, "{integrator:?}");
        let mut other = Simulation::new(model.clone(), settings).unwrap();
        other.restore(&copy).unwrap();
        let mut batch = Batch::new(model.clone(), settings, 2).unwrap();
        batch.restore(1, &copy).unwrap();
        let mut fresh = Simulation::new(model.clone(), settings).unwrap();
        fresh.restore(&State { accelerations_known: false, ..here }).unwrap();
        for step in 0..20 {
            simulation.step(&loads).unwrap();
            other.step(&loads).unwrap();
            fresh.step(&loads).unwrap();
            assert_eq!(batch.step(&[&loads, &loads]).unwrap(), 2);
            assert_eq!(other.state(), simulation.state(), "{integrator:?}, step {step}");
            assert_eq!(batch.state(1).as_ref(), Some(simulation.state()), "{integrator:?}, step {step}");
        }
        // Without what is carried the accelerations are solved anew: the same but for what an iteration leaves (1e-14 of the velocities,
        // times the highest frequency and its square over the step), and the auxiliary accelerations of damping begin again.
        if damping == 0.0 {
            let size = simulation.state().q_dot.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for (carried, solved) in simulation.state().q_dot.iter().zip(&fresh.state().q_dot) {
                assert!((carried - solved).abs() < 1e-10 * size, "{integrator:?}: {carried} {solved}");
            }
        }
    }
}

/// The iteration begins at accelerations that change as in the last step: nearer than those at its start, and soon enough after a motion
/// began anew.
#[test]
fn a_step_that_knows_the_last_one_takes_fewer_evaluations() {
    let model = model(&frame("10"), 4, Elastic::Geometric);
    let loads = model.prepare(model.load_case("lc2").unwrap()).unwrap();
    for integrator in [Integrator::Newmark, Integrator::GeneralizedAlpha] {
        let settings = Settings { dt: 0.002, integrator, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        simulation.restore(&moving(&model)).unwrap();
        let evaluations = |state: &State| {
            (1..20)
                .find(|&max_iterations| {
                    let limited = Settings { max_iterations, ..settings };
                    let mut simulation = Simulation::new(model.clone(), limited).unwrap();
                    simulation.restore(state).unwrap();
                    simulation.step(&loads).is_ok()
                })
                .unwrap()
        };
        let (mut going_on, mut anew) = (0, 0);
        for _ in 0..10 {
            for _ in 0..5 {
                simulation.step(&loads).unwrap();
            }
            let here = simulation.state().clone();
            going_on += evaluations(&here);
            anew += evaluations(&State { accelerations_known: false, ..here });
        }
        // Four against five or so, but for steps at the edge.
        assert!(going_on + 5 <= anew, "{integrator}: {going_on} {anew}");
    }
}

#[test]
fn a_prescribed_motion_like_the_free_one_needs_no_wrench() {
    let model = model(&frame("10"), 6, Elastic::Geometric);
    let case = model.load_case("lc2").unwrap();
    let loads = model.prepare(case).unwrap();
    for integrator in [Integrator::Rk4, Integrator::Newmark] {
        let settings = Settings { dt: 0.002, integrator, ..Settings::default() };
        let mut free = Simulation::new(model.clone(), settings).unwrap();
        free.restore(&moving(&model)).unwrap();
        free.solve_accelerations(&loads).unwrap();
        let mut held = free.clone();
        held.prescribe(&loads, &model.motion_of(free.state())).unwrap();
        let reaction = held.reaction().unwrap();
        let size = reaction.inertia.iter().fold(1.0_f64, |a, b| a.max(b.abs()));
        let residual = |total: [f64; 6]| total.iter().fold(0.0_f64, |a, b| a.max(b.abs())) / size;
        // Round-off of the solution of the equations.
        assert!(residual(reaction.total()) < 1e-11, "{integrator}: {:?}", reaction.total());
        for _ in 0..50 {
            free.step(&loads).unwrap();
            free.solve_accelerations(&loads).unwrap();
            held.step_prescribed(&loads, &model.motion_of(free.state())).unwrap();
        }
        // Fourth order in the interpolated motion of RK4; the implicit step is the same.
        let total = residual(held.reaction().unwrap().total());
        assert!(total < 1e-4, "{integrator}: {total:e}");
        for (a, b) in free.state().q.iter().zip(&held.state().q) {
            assert!((a - b).abs() < 1e-6 * (1.0 + b.abs()), "{integrator}: {a} {b}");
        }
    }
}

#[test]
fn large_deflections_are_those_of_the_nonlinear_method() {
    let structure = frame("3");
    let model = model(&structure, 10, Elastic::Geometric);
    let case = model.load_case("lc2").unwrap().clone();
    let settings = RunSettings { dt: 0.02, integrator: Integrator::Newmark, numerical_damping: 0.01 };
    let mesh = structure.mesh();
    let point = mesh.points.iter().position(|p| p.name == "P").unwrap();
    let prepared = Prepared::about(mesh, None);
    let mut nonlinear = prepared.start(Method::Nonlinear, &case, &settings).unwrap();
    let settings = Settings { dt: 0.02, numerical_damping: 0.01, ..Settings::default() };
    let mut reduced = Simulation::new(model.clone(), settings).unwrap();
    let loads = model.prepare(&case).unwrap();
    let (mut error, mut size) = (0.0_f64, 0.0_f64);
    // The tip has moved by 0.23 of the arm at 9.3 s; half of it is enough here.
    for _ in 0..300 {
        nonlinear.step().unwrap();
        reduced.step(&loads).unwrap();
        let (a, b): ([f64; 3], _) =
            (nonlinear.output().dr_a[point].into(), reduced.point_output(point).unwrap().dr_a);
        let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        error = error.max(norm(std::array::from_fn(|i| a[i] - b[i])));
        size = size.max(norm(b));
    }
    // Ten modes leave 0.4 % of it out.
    assert!(error < 0.01 * size && size > 0.5, "{error} of {size}");
}

/// Pictures of a model on a curved manifold: the node at the tip is where the point there is, and far from where the shapes of the modes
/// alone would have it.
#[test]
fn pictures_bend_as_points_do() {
    let structure = frame("10");
    let model = model(&structure, 6, Elastic::Geometric);
    let (data, m) = (model.data(), model.n_modes());
    let (picture, curve) = (data.picture.as_ref().unwrap(), data.picture_curve.as_ref().unwrap());
    let nodes = picture.positions.len() / 3;
    let shapes = curve.shapes.len() / (3 * nodes);
    assert!((1..30).contains(&shapes), "few shapes: {shapes}");
    let point = model.point("P").unwrap();
    let tip = (0..nodes)
        .find(|&k| picture.positions[3 * k..3 * k + 3] == data.points[point].node_position)
        .unwrap();
    let mut bent = PictureCurve::new(curve, nodes);
    let mut state = moving(&model);
    let row = |values: &[f64], x: &[f64], k: usize| -> f64 {
        let width = x.len();
        (0..width).map(|j| values[(3 * tip + k) * width + j] * x[j]).sum()
    };
    let drawn = |state: &State, bent: &mut PictureCurve| -> [Vector3<f64>; 3] {
        let (p, p_dot) = bent.at(&state.q, &state.q_dot);
        let of = |q: &[f64], p: &[f64]| {
            Vector3::from_fn(|k, _| row(&picture.phi_translation, q, k) + row(&curve.shapes, p, k))
        };
        let straight = Vector3::from_fn(|k, _| row(&picture.phi_translation, &state.q, k));
        [of(&state.q, p), of(&state.q_dot, p_dot), straight]
    };
    let [place, rate, straight] = drawn(&state, &mut bent);
    let told: Vector3<f64> = model.point_output(&state, point).unwrap().dr_a.into();
    // What pictures leave out, 5e-4, and points, 2e-3, of displacements at the full range of each mode: a fifth of the size of the frame.
    let size = 0.2 * 11.0;
    assert!((place - told).norm() < 3e-3 * size, "{place} {told}");
    assert!((straight - told).norm() > 3.0 * (place - told).norm() + 1e-2 * size, "{straight} {told}");
    // Rates are those of the places: central differences of a cubic, exact but for the third power of the step.
    let h = 1e-4;
    let q = state.q.clone();
    let mut at = |s: f64| {
        (0..m).for_each(|i| state.q[i] = q[i] + s * h * state.q_dot[i]);
        drawn(&state, &mut bent)[0]
    };
    let difference = (at(1.0) - at(-1.0)) / (2.0 * h);
    assert!((difference - rate).norm() < 1e-6 * rate.norm(), "{difference} {rate}");
}
