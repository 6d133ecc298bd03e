//! Linear models against what the reduced model does, and against what is known of its poles.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Quaternion, UnitQuaternion, Vector3};
use rom_generator::input::Structure;
use rom_generator::linearise::{LineariseError, Request, StateSpace, linearise};
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build};
use rom_runtime::{
    DistributedFrame, Integrator, LoadCase, LoadFrame, LoadSet, Method, Model, PrescribedMotion, Settings,
    Simulation, State, StationAxes, StationMotion, Stations,
};

fn built(text: &str, name: &str, sets: &[(&str, &str)], options: BuildOptions) -> Arc<Model> {
    let sets: Vec<_> = sets.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    let structure = Structure::from_toml_str(text, name, &sets).unwrap_or_else(|e| panic!("{e}"));
    Arc::new(Model::new(build(&structure, &options, &mut |_| ()).unwrap()).unwrap())
}

fn modes(count: usize) -> BuildOptions {
    BuildOptions { modes: ModeSelection::Count(count), all_nodes: false, ..BuildOptions::default() }
}

fn frame(options: BuildOptions) -> Arc<Model> {
    let text = include_str!("../../models/fmb.toml");
    built(text, "fmb.toml", &[("sigma", "10"), ("elements", "24")], options)
}

fn aircraft(count: usize) -> Arc<Model> {
    built(include_str!("../../models/hale.toml"), "hale.toml", &[], modes(count))
}

fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}

/// The steady state, moved by `x` in the states of a model that is not reduced.
fn moved(model: &Model, linear: &StateSpace, x: &DVector<f64>) -> State {
    let (steady, m) = (&linear.steady, model.n_modes());
    let mut state = State::at_rest(model);
    state.attitude = steady.attitude;
    state.position = steady.position;
    let mut beta = steady.velocity;
    for i in 0..m {
        state.q[i] = steady.q[i] + x[i];
        state.q_dot[i] = x[m + i];
    }
    if !steady.driven {
        (0..6).for_each(|k| beta[k] += x[2 * m + k]);
        let turn = quaternion(steady.attitude);
        let [theta, r] = [6, 9].map(|k| Vector3::from_fn(|i, _| x[2 * m + k + i]));
        let turned = turn * UnitQuaternion::from_scaled_axis(theta);
        state.attitude = [turned.w, turned.i, turned.j, turned.k];
        state.position = (Vector3::from(steady.position) + turn * r).into();
    }
    let phi = &model.data().modes.phi_r;
    for k in 0..6 {
        state.beta_star[k] = beta[k] - (0..m).map(|j| phi[k * m + j] * state.q_dot[j]).sum::<f64>();
    }
    state
}

/// Outputs of frame A and of a point after a run of the reduced model itself, components in A.
fn outputs(
    model: &Arc<Model>,
    start: &State,
    loads: &LoadSet,
    point: usize,
    t_end: f64,
) -> (Vec<f64>, State) {
    let settings = Settings { dt: t_end / 200.0, integrator: Integrator::Rk4, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    simulation.restore(start).unwrap();
    for _ in 0..200 {
        simulation.step(loads).unwrap();
    }
    simulation.solve_accelerations(loads).unwrap();
    let rigid = simulation.rigid_output();
    let motion = simulation.point_motion(point).unwrap();
    let dr_a = simulation.point_output(point).unwrap().dr_a;
    let in_a = |v: [f64; 3]| rom_runtime::into_axes(simulation.state().attitude, v);
    let seen = [
        rigid.v_a,
        rigid.w_a,
        dr_a,
        in_a(motion.v_g),
        in_a(motion.w_g),
        in_a(motion.a_g),
        in_a(motion.alpha_g),
    ];
    (seen.concat(), simulation.state().clone())
}

/// `x(T)` from `x(0)` and a constant input: `exp(A T) x + int exp(A s) B u ds`, by the exponential of the augmented matrix.
fn marched(linear: &StateSpace, x: &DVector<f64>, u: &DVector<f64>, t: f64) -> DVector<f64> {
    let n = x.len();
    let mut augmented = DMatrix::zeros(n + 1, n + 1);
    augmented.view_mut((0, 0), (n, n)).copy_from(&(&linear.a * t));
    augmented.view_mut((0, n), (n, 1)).copy_from(&(&linear.b * u * t));
    let mut start = x.clone().insert_row(n, 1.0);
    start[n] = 1.0;
    (augmented.exp() * start).rows(0, n).into_owned()
}

/// Small changes of state and loads, marched by the reduced model and by the linear one: the same outputs, to the second order of the
/// change (central differences) and the fourth of the step.
fn check_response(model: &Arc<Model>, request: &Request, point: &str) {
    let request = Request {
        inputs: Some(vec![point.into()]),
        outputs: Some(vec!["A".into(), point.into()]),
        ..request.clone()
    };
    let linear = linearise(model, &request).unwrap_or_else(|e| panic!("{e}"));
    let (n, m) = (linear.a.nrows(), model.n_modes());
    let index = model.point(point).unwrap();
    let mut random = Random(7);
    let frequencies = &model.data().modes.omega;
    let scale = model.data().rigid.mass.sqrt();
    let size = |k: usize| match k {
        k if k < m => 0.1 * scale,
        k if k < 2 * m => 0.1 * scale * frequencies[k - m],
        _ => 0.1,
    };
    let x = DVector::from_fn(n, |k, _| size(k) * random.next());
    let force = model.data().rigid.mass * 0.2;
    let u = DVector::from_fn(6, |_, _| force * random.next());
    let t_end = 0.15;
    let run = |epsilon: f64| {
        let mut loads = LoadSet::with_case(model, &[index], &request.case).unwrap();
        let held = linear.steady.wrench.unwrap_or_default();
        let three = |v: &[f64], k: usize| -> [f64; 3] { std::array::from_fn(|i| v[k + i]) };
        loads.add_wrench(&LoadFrame::Body, three(&held, 0), three(&held, 3));
        let unit = u.as_slice().iter().map(|u| epsilon * u).collect::<Vec<f64>>();
        assert!(loads.add(0, &LoadFrame::Body, three(&unit, 0), three(&unit, 3)));
        outputs(model, &moved(model, &linear, &(&x * epsilon)), &loads, index, t_end)
    };
    let epsilon = 1e-4;
    let ((after, state_after), (before, state_before)) = (run(epsilon), run(-epsilon));
    let (_, base) = run(0.0);
    let turn =
        |state: &State| (quaternion(base.attitude).inverse() * quaternion(state.attitude)).scaled_axis();
    let to_a = |state: &State| {
        quaternion(base.attitude).inverse() * (Vector3::from(state.position) - Vector3::from(base.position))
    };
    let half = 0.5 / epsilon;
    let mut found: Vec<f64> = after.iter().zip(&before).map(|(a, b)| half * (a - b)).collect();
    let theta = (turn(&state_after) - turn(&state_before)) * half;
    let r = (to_a(&state_after) - to_a(&state_before)) * half;
    found.splice(6..6, theta.iter().chain(r.iter()).copied());
    let expected = &linear.c * marched(&linear, &x, &u, t_end) + &linear.d * &u;
    assert_eq!(found.len(), expected.len());
    // By threes: a vector is as exact as its largest component.
    for (k, (found, expected)) in found.chunks(3).zip(expected.as_slice().chunks(3)).enumerate() {
        let largest = expected.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 2e-5 * largest,
                "{}: {found} instead of {expected}",
                linear.outputs[3 * k].name
            );
        }
    }
    assert!(expected.amax() > 0.0);
}

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

#[test]
fn a_free_body_at_rest_has_its_frequencies_and_twelve_poles_at_the_origin() {
    let model = frame(modes(6));
    let linear = linearise(&model, &Request::of_equilibrium()).unwrap();
    assert_eq!((linear.states.len(), linear.ignorable, linear.poles.len()), (24, 6, 24));
    assert_eq!(linear.poles.iter().filter(|pole| pole.omega() == 0.0).count(), 12);
    let found: Vec<f64> = linear.poles.iter().filter(|pole| pole.im > 0.0).map(|pole| pole.im).collect();
    for (found, omega) in found.iter().zip(&model.data().modes.omega) {
        assert!((found / omega - 1.0).abs() < 1e-10, "{found} {omega}");
    }
    let rates = Request { reduce: true, ..Request::of_equilibrium() };
    let reduced = linearise(&model, &rates).unwrap();
    assert_eq!(reduced.states.len(), 18);
    let names: Vec<&str> = reduced.states.iter().map(|state| state.name.as_str()).collect();
    assert_eq!((names[0], names[6], names[12], names[17]), ("q.1", "q_dot.1", "v.x", "w.z"));
    assert!(
        reduced.dropped.contains(&"theta_A.x".to_owned()) && reduced.dropped.contains(&"r_A.z".to_owned())
    );
    assert_eq!(reduced.poles, linear.poles);
}

#[test]
fn responses_at_rest_and_in_steady_rotation_are_those_of_the_model() {
    let consistent = BuildOptions { inertia: Inertia::Consistent, elastic: Elastic::Geometric, ..modes(4) };
    for model in [frame(modes(6)), frame(consistent)] {
        check_response(&model, &Request::of_equilibrium(), "P");
        // About an axis next to a principal one, and far from one with a wrench that holds it there.
        check_response(&model, &Request { rate: Some([0.0, 0.7, 0.0]), ..Request::of_equilibrium() }, "P");
        let held = Request {
            velocity: Some([1.0, -0.5, 0.3]),
            rate: Some([0.2, 0.3, -0.4]),
            hold: true,
            ..Request::of_equilibrium()
        };
        check_response(&model, &held, "P");
    }
    let model = frame(modes(6));
    for method in [Method::Rigid, Method::MeanAxes] {
        let model = Arc::new(model.with_method(method).unwrap());
        let rate = Some([0.0, 0.7, 0.0]);
        let linear = linearise(&model, &Request { rate, ..Request::of_equilibrium() }).unwrap();
        assert!(linear.steady.residual < 1e-12, "{}", linear.steady.residual);
    }
}

/// Section forces, and places, turns and velocities of stations, for small changes of the state and of the wrenches on the stations, as the
/// runtime tells them: central differences, right to the square of the change.
fn check_readings(model: &Arc<Model>, request: &Request) {
    let (block, read) = ("wing", "tailplane");
    let (first, second) = ("left wing 1", "left wing 3");
    let request = Request {
        inputs: Some(vec![block.into()]),
        outputs: Some([first, second, read].map(String::from).to_vec()),
        ..request.clone()
    };
    let linear = linearise(model, &request).unwrap_or_else(|e| panic!("{e}"));
    let (loaded, seen) = (model.station_block(block).unwrap(), model.station_block(read).unwrap());
    let places = [first, second].map(|name| model.section(name).unwrap());
    let stations = model.data().stations[seen].sections.len();
    let names: Vec<&str> = linear.outputs.iter().map(|output| output.name.as_str()).collect();
    assert_eq!((names[0], names[9], names[12]), ("left wing 1.F.x", "left wing 3.M.x", "tailplane.1.dR_A.x"));
    assert_eq!(names.len(), 2 * 6 + 12 * stations);
    assert_eq!(
        (linear.inputs[0].name.as_str(), linear.inputs[191].name.as_str()),
        ("wing.1.F.x", "wing.32.M.z")
    );
    let (n, m) = (linear.a.nrows(), model.n_modes());
    let (mut random, omega) = (Random(11), &model.data().modes.omega);
    let size = |k: usize| match k {
        k if k < m => 0.3,
        k if k < 2 * m => 0.3 * omega[k - m],
        _ => 0.1,
    };
    let x = DVector::from_fn(n, |k, _| size(k) * random.next());
    let u = DVector::from_fn(linear.inputs.len(), |_, _| random.next());
    let readings = |epsilon: f64| {
        let mut loads = LoadSet::with_stations(model, &[], &[loaded], Some(&request.case)).unwrap();
        let held = linear.steady.wrench.unwrap_or_default();
        loads.add_wrench(&LoadFrame::Body, [held[0], held[1], held[2]], [held[3], held[4], held[5]]);
        let wrenches: Vec<f64> = u.iter().map(|u| epsilon * u).collect();
        assert!(loads.set_stations(0, DistributedFrame::Body, &wrenches));
        let state = moved(model, &linear, &(&x * epsilon));
        let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
        simulation.restore(&state).unwrap();
        let sections = simulation.find_section_forces(&loads).unwrap();
        let forces: Vec<f64> = places.iter().flat_map(|&k| sections[k].best).collect();
        let mut reader = Stations::new(model, seen).unwrap();
        (forces, reader.read(model, &state, StationAxes::Body).unwrap().clone())
    };
    let epsilon = 1e-3;
    let ((forces, after), (forces_before, before)) = (readings(epsilon), readings(-epsilon));
    let half = 0.5 / epsilon;
    let difference =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| half * (a - b)).collect::<Vec<f64>>();
    let mut found = difference(&forces, &forces_before);
    for k in 0..stations {
        let three = |of: fn(&StationMotion) -> &Vec<f64>| {
            difference(&of(&after)[3 * k..3 * k + 3], &of(&before)[3 * k..3 * k + 3])
        };
        let attitude =
            |motion: &StationMotion| quaternion(motion.attitude[4 * k..4 * k + 4].try_into().unwrap());
        let turn = (attitude(&after) * attitude(&before).inverse()).scaled_axis() * half;
        found.extend(three(|motion| &motion.position));
        found.extend(turn.iter());
        found.extend(three(|motion| &motion.velocity));
        found.extend(three(|motion| &motion.angular_velocity));
    }
    let expected = &linear.c * &x + &linear.d * &u;
    for (k, (found, expected)) in found.chunks(3).zip(expected.as_slice().chunks(3)).enumerate() {
        let largest = expected.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
        assert!(largest > 0.0);
        for (found, expected) in found.iter().zip(expected) {
            let name = &linear.outputs[3 * k].name;
            assert!((found - expected).abs() < 1e-5 * largest, "{name}: {found} instead of {expected}");
        }
    }
}

#[test]
fn section_forces_and_stations_in_trimmed_flight_are_those_of_the_model() {
    let model = aircraft(8);
    let flight = Request { velocity: Some([25.0, 0.0, 0.0]), ..Request::of_equilibrium() };
    check_readings(&model, &flight);
    check_readings(&model, &Request { rate: Some([0.0, 0.0, 0.1]), hold: true, ..flight.clone() });
    // By the strains, where there is no summation of forces.
    let options = BuildOptions { inertia: Inertia::Consistent, elastic: Elastic::Geometric, ..modes(6) };
    let curved = built(include_str!("../../models/hale.toml"), "hale.toml", &[], options);
    check_readings(&curved, &flight);
}

#[test]
fn responses_in_trimmed_flight_are_those_of_the_model() {
    let model = aircraft(8);
    let flight = Request { velocity: Some([25.0, 0.0, 0.0]), ..Request::of_equilibrium() };
    check_response(&model, &flight, "left tip");
    // Nothing depends on the position and on the heading.
    let reduced = linearise(&model, &Request { reduce: true, ..flight.clone() }).unwrap();
    assert_eq!((reduced.states.len(), reduced.ignorable), (2 * 8 + 6 + 2, 4));
    let names: Vec<&str> = reduced.states.iter().skip(22).map(|state| state.name.as_str()).collect();
    assert_eq!(names, ["theta.x", "theta.y"]);
    assert_eq!(reduced.dropped, ["theta_A.z", "r_A.x", "r_A.y", "r_A.z"]);
    // The factors of the trim are inputs: together its loads accelerate the mass, in the momenta of the free-free modes, by what the
    // weight does.
    let names: Vec<&str> = reduced.inputs.iter().map(|input| input.name.as_str()).collect();
    assert!(names.contains(&"lift") && names.contains(&"elevator") && names.contains(&"thrust"));
    let (trim, rigid, m) = (model.data().trim.as_ref().unwrap(), &model.data().rigid, model.n_modes());
    let phi = &model.data().modes.phi_r;
    let mut lifted = 0.0;
    for (column, input) in reduced.inputs.iter().enumerate() {
        if !trim.load_names.contains(&input.name) {
            continue;
        }
        let factor =
            trim.factors.iter().find(|(name, _)| *name == input.name).map_or(1.0, |(_, factor)| *factor);
        // Rates of beta* from those of the true velocity.
        let rate = |k: usize| {
            let modal: f64 = (0..m).map(|j| phi[k * m + j] * reduced.b[(m + j, column)]).sum();
            reduced.b[(2 * m + k, column)] - modal
        };
        let row: f64 = (0..6).map(|k| rigid.mass_matrix[2 * 6 + k] * rate(k)).sum();
        lifted += factor * row;
    }
    assert!((lifted / (9.81 * rigid.mass) - 1.0).abs() < 1e-6, "{lifted}");
    // Held on a turn about the vertical.
    let turn = Request { rate: Some([0.0, 0.0, 0.1]), hold: true, ..flight };
    check_response(&model, &turn, "left tip");
    // The rigid body on the same turn is held by its inertia, m w x (v + w x c), as weight and lift are in balance.
    let rigid_body = Arc::new(model.with_method(Method::Rigid).unwrap());
    let held = linearise(&rigid_body, &turn).unwrap().steady.wrench.unwrap();
    let (w, c) = (Vector3::new(0.0, 0.0, 0.1), Vector3::from(model.data().rigid.centre_of_mass));
    let inertia = model.data().rigid.mass * w.cross(&(Vector3::new(25.0, 0.0, 0.0) + w.cross(&c)));
    for (found, expected) in held.iter().zip(inertia.iter()) {
        // The trim is balanced to a millionth of the weight.
        assert!((found - expected).abs() < 1e-6 * 9.81 * model.data().rigid.mass, "{found} {expected}");
    }
}

/// About a loaded equilibrium a geometric model has its stiffness from the work of the loads on curved shapes, of which it drops small
/// terms; the linear one has it from the finite elements. They are the same, whatever is dropped: in flight, where lift and weight cancel, of
/// loads that are dead, turn with the body and follow, on nodes and along members; and in closed loops under stress.
#[test]
fn geometric_models_have_the_stiffness_of_their_equilibrium() {
    let hale = include_str!("../../models/hale.toml");
    let loops = include_str!("../../models/joined_wing.toml")
        .replace("[structure]", "[structure]\nsupport = \"clamped\"")
        + r#"
[gravity]
acceleration = [0, 0, -9.81]

[equilibrium]
loads = [
  { point = "left joint", frame = "dead", force = [300, 0, 20e3], moment = [0, 900, 0] },
  { point = "right joint", frame = "follower", member = "right front wing", force = [1e3, 0, 15e3] },
]

[[equilibrium.distributed_loads]]
member = "left front wing"
frame = "dead"
force = [0, 0, 700]
moment = [100, 0, 0]
"#;
    for (text, name, count) in [(hale, "hale.toml", 10), (&loops, "loops.toml", 8)] {
        let geometric =
            BuildOptions { inertia: Inertia::Consistent, elastic: Elastic::Geometric, ..modes(count) };
        let [linear, geometric] = [modes(count), geometric].map(|options| {
            let found = linearise(&built(text, name, &[], options), &Request::of_equilibrium()).unwrap();
            found.a.view((count, 0), (count, count)).into_owned()
        });
        let omega = |i: usize| linear[(i, i)].abs().sqrt();
        for i in 0..count {
            for j in 0..count {
                // Some 1e-11 is found, as well as the equilibrium is; without the work on what is dropped 4e-3.
                let error = (geometric[(i, j)] - linear[(i, j)]).abs() / (omega(i) * omega(j));
                assert!(error < 1e-9, "{name} {i} {j}: {} {}", geometric[(i, j)], linear[(i, j)]);
            }
        }
    }
}

/// A held structure: the states are those of the modes, the base and its acceleration an input.
#[test]
fn a_moved_structure_has_the_frequencies_of_the_clamped_one_and_its_reaction() {
    let text =
        include_str!("../../models/fmb.toml").replace("[structure]", "[structure]\nsupport = \"clamped\"");
    let model = built(&text, "fmb.toml", &[("sigma", "10"), ("elements", "24")], modes(6));
    let linear = linearise(&model, &Request::of_equilibrium()).unwrap();
    assert_eq!((linear.states.len(), linear.poles.len()), (12, 12));
    let found = linear.poles.iter().filter(|pole| pole.im > 0.0).map(|pole| pole.im);
    for (found, omega) in found.zip(&model.data().modes.omega) {
        assert!((found / omega - 1.0).abs() < 1e-10, "{found} {omega}");
    }
    // The reaction by the acceleration of the base, and by its steady turn, against the runtime.
    let still = |rate: [f64; 6]| {
        let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
        let motion = PrescribedMotion { rate, ..PrescribedMotion::default() };
        simulation.prescribe(&model.no_loads(), &motion).unwrap();
        simulation.reaction().unwrap().total()
    };
    let first = linear.inputs.iter().position(|input| input.name == "v_A_dot.x").unwrap();
    for k in 0..6 {
        let mut rate = [0.0; 6];
        rate[k] = 1.0;
        for (row, expected) in still(rate).iter().enumerate() {
            let found = linear.d[(row, first + k)];
            assert!((found - expected).abs() < 1e-9 * model.data().rigid.mass, "{found} {expected}");
        }
    }
    let spinning =
        linearise(&model, &Request { rate: Some([0.0, 0.0, 0.3]), ..Request::of_equilibrium() }).unwrap();
    assert!(spinning.steady.q.iter().any(|q| q.abs() > 1e-6) && spinning.steady.residual < 1e-12);
}

#[test]
fn what_is_no_steady_state_is_refused_in_words() {
    let model = frame(modes(4));
    let refused = |request: &Request| linearise(&model, request).unwrap_err();
    let lc2 = Request { time: 1.0, ..Request::new(model.load_case("lc2").unwrap().clone()) };
    let error = refused(&lc2);
    assert!(matches!(error, LineariseError::NotSteady { .. }), "{error}");
    assert!(error.to_string().contains("frame A accelerates by ("), "{error}");
    let named = |list: &str| Some(vec![list.to_owned()]);
    let error = refused(&Request { inputs: named("Z"), ..Request::of_equilibrium() });
    assert!(error.to_string().contains("no input \"Z\"; it has: A, modes, "), "{error}");
    let error = refused(&Request { outputs: named("reaction"), ..Request::of_equilibrium() });
    assert!(error.to_string().contains("no output \"reaction\""), "{error}");
    let error = refused(&Request { balance: vec!["lift".into()], ..Request::of_equilibrium() });
    assert!(error.to_string().contains("no load of an equilibrium \"lift\""), "{error}");
    let error = refused(&Request { rate: Some([f64::NAN, 0.0, 0.0]), ..Request::of_equilibrium() });
    assert!(error.to_string().contains("rate is NaN"), "{error}");
    // A dead load on a body that turns.
    let mut case: LoadCase = model.load_case("lc2").unwrap().clone();
    case.loads
        .iter_mut()
        .for_each(|load| load.time = rom_runtime::time::TimeFunction::Constant { value: 1.0 });
    let error = refused(&Request { rate: Some([0.0, 0.5, 0.0]), hold: true, ..Request::new(case) });
    assert!(matches!(error, LineariseError::Passing { .. }), "{error}");
}
