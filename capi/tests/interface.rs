//! What a C program meets at the edges: refusals instead of undefined behaviour, states and structures of other sizes, and
//! the same bits as in Rust.
#![allow(unsafe_code)]
#![allow(clippy::undocumented_unsafe_blocks)] // pointers to locals and handles of this test throughout

#[path = "../../runtime/tests/common/mod.rs"]
mod common;

use std::ffi::{CStr, CString, c_char};
use std::ptr::{null, null_mut};
use std::sync::Arc;

use rom::*;
use rom_runtime::data::{CutData, SensorData, TrimData};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    InitialState, Jacobian, Load, LoadCase, LoadFrame, LoadSet, Model, Settings, Simulation, State,
    StateRate, Workspace,
};

/// A body with one load case.
fn bytes() -> Vec<u8> {
    let mut data = common::Lumped::random(3, 5).data(5);
    data.load_cases = vec![LoadCase {
        description: "a ramp".into(),
        dt: 0.01,
        numerical_damping: 0.1,
        loads: vec![Load {
            point: 1,
            frame: LoadFrame::Dead,
            force: [1.0, 2.0, 3.0],
            moment: [0.1, 0.0, 0.2],
            time: TimeFunction::Ramp { rate: 1.0, start: 0.0, end: 1.0 },
        }],
        ..LoadCase::empty("push")
    }];
    data.to_bytes().unwrap()
}

fn said() -> String {
    unsafe { CStr::from_ptr(rom_last_error()) }.to_str().unwrap().to_owned()
}

fn good(status: rom_status) {
    assert_eq!(status, rom_status::ROM_OK, "{}", said());
}

fn refused(status: rom_status, expected: rom_status, words: &str) {
    assert_eq!(status, expected, "{}", said());
    assert!(said().contains(words), "{}", said());
}

struct Handles {
    model: *mut rom_model,
    simulation: *mut rom_simulation,
    loads: *mut rom_loads,
}

impl Handles {
    fn new(load_case: bool) -> Self {
        let mut handles = Handles { model: null_mut(), simulation: null_mut(), loads: null_mut() };
        let (bytes, points) = (bytes(), [2_usize, 0]);
        let name = if load_case { c"push".as_ptr() } else { null() };
        unsafe {
            good(rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &raw mut handles.model));
            good(rom_simulation_new(handles.model, null(), &raw mut handles.simulation));
            good(rom_loads_new(handles.model, name, points.as_ptr(), 2, &raw mut handles.loads));
        }
        handles
    }

    fn state(&self) -> Vec<f64> {
        let mut layout = sized::<rom_state_layout>();
        unsafe {
            good(rom_model_state_layout(self.model, &raw mut layout));
            let mut state = vec![f64::NAN; layout.size as usize];
            good(rom_simulation_get_state(self.simulation, state.as_mut_ptr(), state.len()));
            state
        }
    }
}

impl Drop for Handles {
    fn drop(&mut self) {
        unsafe {
            // The model first: what is made from it does not need it.
            rom_model_free(self.model);
            rom_loads_free(self.loads);
            rom_simulation_free(self.simulation);
        }
    }
}

/// A structure of the header with nothing but its size.
fn sized<T>() -> T {
    unsafe {
        let mut value = std::mem::MaybeUninit::<T>::zeroed();
        value.as_mut_ptr().cast::<u64>().write(size_of::<T>() as u64);
        value.assume_init()
    }
}

#[test]
fn steps_have_the_bits_of_rust() {
    let handles = Handles::new(true);
    let model = Arc::new(Model::from_bytes(&bytes()).unwrap());
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let mut set = LoadSet::with_case(&model, &[2, 0], model.load_case("push").unwrap()).unwrap();
    let (force, moment) = ([0.5, -0.3, 0.2], [0.1, 0.2, -0.3]);
    let section = common::rotation_rows(&nalgebra::Vector3::new(0.3, -0.2, 0.5));
    let modal = vec![0.05; model.n_modes()];
    for step in 0..50 {
        unsafe {
            good(rom_loads_clear(handles.loads));
            good(rom_loads_add(handles.loads, 1, 1, force.as_ptr(), moment.as_ptr()));
            let rows = section.as_flattened();
            good(rom_loads_add_in_section(handles.loads, 0, rows.as_ptr(), force.as_ptr(), moment.as_ptr()));
            good(rom_loads_add_wrench(handles.loads, 0, force.as_ptr(), moment.as_ptr()));
            good(rom_loads_add_modal(handles.loads, modal.as_ptr(), modal.len()));
            good(rom_simulation_step(handles.simulation, handles.loads));
        }
        set.clear();
        set.add_wrench(&LoadFrame::Dead, force, moment);
        assert!(set.add_modal(&modal));
        assert!(set.add(1, &LoadFrame::Body, force, moment));
        assert!(set.add(0, &LoadFrame::Follower { section }, force, moment));
        simulation.step(&set).unwrap();
        let mut expected = vec![0.0; model.flat_layout().size()];
        assert!(simulation.state().write_flat(&mut expected));
        assert_eq!(handles.state(), expected, "step {step}");
    }
    let (mut rigid, mut point, mut ledger) =
        (sized::<rom_rigid>(), sized::<rom_point>(), sized::<rom_ledger>());
    unsafe {
        good(rom_simulation_rigid(handles.simulation, &raw mut rigid));
        good(rom_simulation_point(handles.simulation, 2, &raw mut point));
        good(rom_simulation_ledger(handles.simulation, &raw mut ledger));
    }
    let (out, at, sums) =
        (simulation.rigid_output(), simulation.point_output(2).unwrap(), simulation.ledger());
    assert_eq!((rigid.time, rigid.r_g, rigid.zeta), (simulation.state().time, out.r_g, out.zeta));
    assert_eq!((rigid.v_a, rigid.w_a, rigid.v_g, rigid.w_g), (out.v_a, out.w_a, out.v_g, out.w_g));
    assert_eq!((point.dr_a, point.r_g), (at.dr_a, at.r_g));
    assert_eq!((ledger.r_cm_g, ledger.linear_momentum_g), (sums.r_cm_g, sums.linear_momentum_g));
    assert_eq!(ledger.angular_momentum_g, sums.angular_momentum_g);
    assert_eq!((ledger.kinetic_energy, ledger.elastic_energy), (sums.kinetic_energy, sums.elastic_energy));
}

#[test]
fn motion_of_points_sensors_and_gravity_are_those_of_rust() {
    let mut data = Model::from_bytes(&bytes()).unwrap().data().clone();
    data.sensors = vec![SensorData {
        name: "imu".into(),
        point: 2,
        axes: common::rotation_rows(&nalgebra::Vector3::new(0.3, -0.2, 0.5)),
        gravity: true,
    }];
    let bytes = data.to_bytes().unwrap();
    let model = Arc::new(Model::new(data).unwrap());
    let mut own = Simulation::new(model.clone(), Settings::default()).unwrap();
    let set = LoadSet::with_case(&model, &[], model.load_case("push").unwrap()).unwrap();
    let field = [0.3, 0.1, -9.81];
    own.set_gravity(field).unwrap();
    let (mut motion, mut reading) = (sized::<rom_point_motion>(), sized::<rom_sensor_reading>());
    unsafe {
        let (mut handle, mut simulation, mut loads) = (null_mut(), null_mut(), null_mut());
        good(rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &raw mut handle));
        good(rom_simulation_new(handle, null(), &raw mut simulation));
        good(rom_loads_new(handle, c"push".as_ptr(), null(), 0, &raw mut loads));
        let (mut sensor, mut gravity) = (9, [1.0; 3]);
        good(rom_model_gravity(handle, gravity.as_mut_ptr(), 3));
        assert_eq!(gravity, model.gravity());
        good(rom_simulation_set_gravity(simulation, field.as_ptr()));
        assert_eq!(rom_model_n_sensors(handle), 1);
        assert_eq!(CStr::from_ptr(rom_model_sensor_name(handle, 0)), c"imu");
        good(rom_model_find_sensor(handle, c"imu".as_ptr(), &raw mut sensor));
        let status = rom_model_find_sensor(handle, c"gyro".as_ptr(), &raw mut sensor);
        refused(status, rom_status::ROM_NOT_FOUND, "imu");
        // At the start they are not known, and solved.
        for steps in [0, 20] {
            good(rom_simulation_run(simulation, loads, steps));
            (0..steps).for_each(|_| own.step(&set).unwrap());
            own.solve_accelerations(&set).unwrap();
            good(rom_simulation_point_motion(simulation, loads, 1, &raw mut motion));
            good(rom_simulation_sensor(simulation, loads, sensor, &raw mut reading));
            let (expected, read) = (own.point_motion(1).unwrap(), own.sensor_reading(0).unwrap());
            assert_eq!(
                (motion.zeta, motion.v_g, motion.w_g),
                (expected.attitude, expected.v_g, expected.w_g)
            );
            assert_eq!((motion.a_g, motion.alpha_g), (expected.a_g, expected.alpha_g));
            assert_eq!((reading.a, reading.w, reading.alpha), (read.a, read.w, read.alpha));
        }
        assert!(motion.v_g[2] < -1.0, "it falls: {:?}", motion.v_g);
        let mut ledger = sized::<rom_ledger>();
        good(rom_simulation_ledger(simulation, &raw mut ledger));
        assert_eq!(ledger.gravity_energy, own.ledger().gravity_energy);
        assert!(ledger.gravity_energy != 0.0);
        let status = rom_simulation_point_motion(simulation, loads, 99, &raw mut motion);
        refused(status, rom_status::ROM_NOT_FOUND, "point is 99, expected less than");
        let status = rom_simulation_sensor(simulation, loads, 1, &raw mut reading);
        refused(status, rom_status::ROM_NOT_FOUND, "sensor is 1, expected less than 1");
        let infinite = [f64::INFINITY; 3];
        let status = rom_simulation_set_gravity(simulation, infinite.as_ptr());
        refused(status, rom_status::ROM_BAD_ARGUMENT, "acceleration holds inf");
        rom_loads_free(loads);
        rom_simulation_free(simulation);
        rom_model_free(handle);
    }
}

#[test]
fn a_load_case_starts_where_it_says_and_an_equilibrium_may_act_alone() {
    let mut data = Model::from_bytes(&bytes()).unwrap().data().clone();
    let rates = vec![0.3, -0.1];
    data.load_cases[0].initial =
        Some(InitialState { angular_velocity: Some([0.1, 0.2, -0.3]), rates, ..InitialState::default() });
    let loads = std::mem::take(&mut data.load_cases[0].loads);
    let (m, points) = (data.modes.omega.len(), data.points.len());
    data.trim = Some(TrimData {
        distributed: Vec::new(),
        loads,
        elastic_force: vec![0.5; m],
        elastic_energy: 2.0,
        attitude: [0.6, 0.0, 0.8, 0.0],
        factors: Vec::new(),
        load_names: Vec::new(),
        reaction: [0.0; 6],
        scales: [1.0, 1.0],
        displacements: vec![[0.0; 3]; points],
        effort: [1, 5],
    });
    let bytes = data.to_bytes().unwrap();
    let model = Arc::new(Model::new(data).unwrap());
    let case = model.load_case("push").unwrap();
    let flat = |simulation: &Simulation| {
        let mut flat = vec![0.0; model.flat_layout().size()];
        assert!(simulation.state().write_flat(&mut flat));
        flat
    };
    // The case has no loads of its own: what it brings along is what the name "" stands for. Without either the body is left alone.
    let sets = [
        (c"push".as_ptr(), LoadSet::with_case(&model, &[1], case).unwrap()),
        (c"".as_ptr(), LoadSet::with_case(&model, &[1], case).unwrap()),
        (null(), LoadSet::new(&model, &[1]).unwrap()),
    ];
    let mut ends = Vec::new();
    for (name, set) in sets {
        let mut own = Simulation::new(model.clone(), Settings::default()).unwrap();
        own.restore(&model.initial_state(case).unwrap()).unwrap();
        let (mut handle, mut simulation, mut loads) = (null_mut(), null_mut(), null_mut());
        let mut state = flat(&own);
        unsafe {
            good(rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &raw mut handle));
            good(rom_simulation_new(handle, null(), &raw mut simulation));
            refused(rom_simulation_start(simulation, c"".as_ptr()), rom_status::ROM_NOT_FOUND, "push");
            good(rom_simulation_start(simulation, c"push".as_ptr()));
            good(rom_loads_new(handle, name, [1].as_ptr(), 1, &raw mut loads));
            good(rom_simulation_run(simulation, loads, 10));
            good(rom_simulation_get_state(simulation, state.as_mut_ptr(), state.len()));
            rom_loads_free(loads);
            rom_simulation_free(simulation);
            rom_model_free(handle);
        }
        (0..10).for_each(|_| own.step(&set).unwrap());
        assert_eq!(state, flat(&own));
        ends.push(state);
    }
    assert_eq!(ends[0], ends[1]);
    assert_ne!(ends[1], ends[2]);
}

#[test]
fn section_axes_are_found_by_member() {
    let turned = |angle: f64| common::rotation_rows(&nalgebra::Vector3::new(angle, 0.0, 0.0));
    let mut data = Model::from_bytes(&bytes()).unwrap().data().clone();
    let named = |name: &str, angle| (name.to_owned(), turned(angle));
    data.points[0].sections = vec![named("wing", 0.1), named("fin", 0.2), named("wing", 0.3)];
    data.points[1].sections = vec![named("wing", 0.1), named("fin", 0.1)];
    data.points[2].sections = Vec::new();
    let bytes = data.to_bytes().unwrap();
    let (mut model, mut matrix) = (null_mut(), [0.0; 9]);
    unsafe {
        good(rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &raw mut model));
        let mut axes =
            |point, name: *const c_char| rom_model_section_axes(model, point, name, matrix.as_mut_ptr(), 9);
        use rom_status::{ROM_BAD_SETTINGS, ROM_NOT_FOUND};
        refused(axes(0, null()), ROM_BAD_SETTINGS, "at point P0, name one of: wing[1], fin, wing[2]");
        refused(axes(0, c"wing".as_ptr()), ROM_BAD_SETTINGS, "name one of");
        refused(axes(0, c"tail".as_ptr()), ROM_NOT_FOUND, "no member tail at point P0; it has: wing[1]");
        refused(axes(2, null()), ROM_NOT_FOUND, "it has: none");
        refused(axes(99, null()), ROM_NOT_FOUND, "no point number 99");
        good(axes(1, null()));
        assert_eq!(matrix, *turned(0.1).as_flattened());
        for (name, angle) in [(c"fin", 0.2), (c"wing[1]", 0.1), (c"wing[2]", 0.3)] {
            good(rom_model_section_axes(model, 0, name.as_ptr(), matrix.as_mut_ptr(), 9));
            assert_eq!(matrix, *turned(angle).as_flattened());
        }
        rom_model_free(model);
    }
}

#[test]
fn a_snapshot_rewinds_to_the_same_bits_and_a_bad_one_is_refused() {
    let handles = Handles::new(true);
    let run = |n| unsafe { good(rom_simulation_run(handles.simulation, handles.loads, n)) };
    run(20);
    let snapshot = handles.state();
    run(30);
    let first = handles.state();
    let set =
        |state: &[f64]| unsafe { rom_simulation_set_state(handles.simulation, state.as_ptr(), state.len()) };
    good(set(&snapshot));
    run(30);
    assert_eq!(handles.state(), first);

    let mut bad = snapshot.clone();
    bad[3] = f64::NAN;
    refused(set(&bad), rom_status::ROM_BAD_SETTINGS, "q is NaN");
    refused(set(&snapshot[1..]), rom_status::ROM_BAD_ARGUMENT, "expected");
    assert_eq!(handles.state(), first, "a refused state changes nothing");
}

#[test]
fn derivatives_are_those_of_rust_and_may_overwrite_the_state() {
    let handles = Handles::new(true);
    let model = Model::from_bytes(&bytes()).unwrap();
    let m = model.n_modes();
    let mut random = common::Random::new(3);
    let mut y: Vec<f64> = (0..2 * m + 13).map(|_| random.next()).collect();
    let mut state = State::at_rest(&model);
    state.time = 0.7;
    state.q.copy_from_slice(&y[..m]);
    state.q_dot.copy_from_slice(&y[m..2 * m]);
    state.beta_star.copy_from_slice(&y[2 * m..2 * m + 6]);
    state.attitude.copy_from_slice(&y[2 * m + 6..2 * m + 10]);
    state.position.copy_from_slice(&y[2 * m + 10..]);
    let loads = model.prepare(model.load_case("push").unwrap()).unwrap();
    let mut rate = StateRate::new(&model);
    model.derivatives(&state, &loads, &mut Workspace::new(&model), &mut rate).unwrap();
    let expected = [&rate.q_dot[..], &rate.u_dot, &rate.attitude_dot, &rate.position_dot].concat();
    unsafe {
        let mut evaluator = null_mut();
        good(rom_evaluator_new(handles.model, &raw mut evaluator));
        assert_eq!(rom_model_n_variables(handles.model), y.len());
        let mut loads = null_mut();
        good(rom_loads_new(handles.model, c"push".as_ptr(), null(), 0, &raw mut loads));
        let at = y.as_mut_ptr();
        good(rom_evaluator_derivatives(evaluator, 0.7, at, y.len(), loads, at));
        assert_eq!(y, expected);
        y[2 * m + 6..2 * m + 10].fill(0.0);
        let status = rom_evaluator_derivatives(evaluator, 0.7, at, y.len(), loads, at);
        refused(status, rom_status::ROM_BAD_ARGUMENT, "quaternion");
        rom_loads_free(loads);
        rom_evaluator_free(evaluator);
    }
}

#[test]
fn the_jacobian_is_that_of_rust() {
    let handles = Handles::new(true);
    let model = Arc::new(Model::from_bytes(&bytes()).unwrap());
    let m = model.n_modes();
    let mut random = common::Random::new(3);
    let y: Vec<f64> = (0..2 * m + 13).map(|_| random.next()).collect();
    let mut state = State::at_rest(&model);
    state.time = 0.7;
    state.q.copy_from_slice(&y[..m]);
    state.q_dot.copy_from_slice(&y[m..2 * m]);
    state.beta_star.copy_from_slice(&y[2 * m..2 * m + 6]);
    state.attitude.copy_from_slice(&y[2 * m + 6..2 * m + 10]);
    state.position.copy_from_slice(&y[2 * m + 10..]);
    let push = model.prepare(model.load_case("push").unwrap()).unwrap();
    let mut expected = Jacobian::new(model.clone());
    expected.evaluate(&state, &push).unwrap();
    let n = expected.size();
    let (mut matrix, mut column, mut of_load) = (vec![0.0; n * n], vec![0.0; n], vec![0.0; n]);
    unsafe {
        let (mut evaluator, mut loads) = (null_mut(), null_mut());
        good(rom_evaluator_new(handles.model, &raw mut evaluator));
        good(rom_loads_new(handles.model, c"push".as_ptr(), null(), 0, &raw mut loads));
        assert_eq!(rom_model_n_tangent(handles.model), n);
        let status = rom_evaluator_by_load(evaluator, loads, column.as_mut_ptr(), n);
        refused(status, rom_status::ROM_BAD_ARGUMENT, "rom_evaluator_jacobian first");
        let at = matrix.as_mut_ptr();
        let status = rom_evaluator_jacobian(evaluator, 0.7, y.as_ptr(), y.len(), loads, at, n * n - 1);
        refused(status, rom_status::ROM_BAD_ARGUMENT, "expected");
        good(rom_evaluator_jacobian(evaluator, 0.7, y.as_ptr(), y.len(), loads, at, n * n));
        assert_eq!(matrix, expected.matrix());
        good(rom_evaluator_by_load(evaluator, loads, column.as_mut_ptr(), n));
        expected.by_load(&push, &mut of_load).unwrap();
        assert_eq!(column, of_load);
        rom_loads_free(loads);
        rom_evaluator_free(evaluator);
    }
}

#[test]
fn a_host_may_move_the_frame() {
    let handles = Handles::new(false);
    let mut motion = sized::<rom_motion>();
    motion.attitude[0] = 1.0;
    let mut reaction = sized::<rom_reaction>();
    unsafe {
        let status = rom_simulation_reaction(handles.simulation, &raw mut reaction);
        refused(status, rom_status::ROM_NOT_FOUND, "free flight");
        motion.rate[0] = 2.0;
        good(rom_simulation_prescribe(handles.simulation, handles.loads, &raw const motion));
        good(rom_simulation_reaction(handles.simulation, &raw mut reaction));
        // Carried along from rest at 2 m/s^2: the undeformed body pushes back with its mass.
        let mass = Model::from_bytes(&bytes()).unwrap().data().rigid.mass;
        assert!((reaction.inertia[0] + 2.0 * mass).abs() < 1e-12 * mass);
        good(rom_simulation_step_prescribed(handles.simulation, handles.loads, &raw const motion));
        motion.attitude[0] = 2.0;
        let status = rom_simulation_step_prescribed(handles.simulation, handles.loads, &raw const motion);
        refused(status, rom_status::ROM_BAD_SETTINGS, "attitude");
    }
}

#[test]
fn older_and_newer_headers_go_on_working() {
    #[repr(C)]
    struct Newer {
        known: rom_point,
        unknown: f64,
    }
    let handles = Handles::new(false);
    let mut newer = Newer { known: sized(), unknown: 7.0 };
    newer.known.struct_size = size_of::<Newer>() as u64;
    let at = |out: *mut rom_point| unsafe { rom_simulation_point(handles.simulation, 0, out) };
    good(at((&raw mut newer).cast()));
    assert_eq!((newer.known.struct_size, newer.unknown), (size_of::<Newer>() as u64, 7.0));
    for size in [0, 8, 55, 1 << 40] {
        newer.known.struct_size = size;
        refused(at((&raw mut newer).cast()), rom_status::ROM_BAD_ARGUMENT, "struct_size of out");
    }
}

#[test]
fn bad_arguments_are_refused_in_words() {
    use rom_status::*;
    let handles = Handles::new(true);
    let (mut model, mut loads, mut simulation) = (null_mut(), null_mut(), null_mut());
    let (mut number, finite, infinite) = (0, [0.0; 3], [0.0, f64::INFINITY, 0.0]);
    unsafe {
        refused(rom_model_read(null(), &raw mut model), ROM_BAD_ARGUMENT, "path is null");
        refused(rom_model_read(c"x".as_ptr(), null_mut()), ROM_BAD_ARGUMENT, "model is null");
        refused(rom_model_read(c"/no/such.rom".as_ptr(), &raw mut model), ROM_BAD_MODEL, "/no/such.rom");
        let latin = CString::new([0xe9]).unwrap();
        refused(rom_model_read(latin.as_ptr(), &raw mut model), ROM_BAD_ARGUMENT, "UTF-8");
        refused(rom_model_from_bytes(null(), 4, &raw mut model), ROM_BAD_ARGUMENT, "bytes is null");
        refused(rom_model_from_bytes(null(), usize::MAX, &raw mut model), ROM_BAD_ARGUMENT, "memory");
        refused(rom_model_from_bytes(null(), 0, &raw mut model), ROM_BAD_MODEL, "");
        refused(rom_model_with_method(handles.model, 3, &raw mut model), ROM_BAD_ARGUMENT, "rom_method");
        assert!(model.is_null(), "nothing is written when a call fails");
        let found = rom_model_find_point(handles.model, c"tip".as_ptr(), &raw mut number);
        refused(found, ROM_NOT_FOUND, "P0, P1");
        let twice = [1_usize, 1];
        let made = rom_loads_new(handles.model, null(), twice.as_ptr(), 2, &raw mut loads);
        refused(made, ROM_BAD_SETTINGS, "each point once");
        let made = rom_loads_new(handles.model, c"pull".as_ptr(), null(), 0, &raw mut loads);
        refused(made, ROM_NOT_FOUND, "push");
        let add = |slot, frame, force: &[f64; 3]| {
            rom_loads_add(handles.loads, slot, frame, force.as_ptr(), finite.as_ptr())
        };
        refused(add(2, 0, &finite), ROM_NOT_FOUND, "slot is 2");
        refused(add(0, 3, &finite), ROM_BAD_ARGUMENT, "rom_frame");
        refused(add(0, 0, &infinite), ROM_BAD_ARGUMENT, "force holds inf");
        let stretched = [1.1, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let at = (stretched.as_ptr(), finite.as_ptr());
        refused(rom_loads_add_wrench(handles.loads, 3, at.1, at.1), ROM_BAD_ARGUMENT, "rom_frame");
        refused(rom_loads_add_modal(handles.loads, at.1, 0), ROM_BAD_ARGUMENT, "every elastic mode");
        refused(rom_loads_add_in_section(handles.loads, 0, at.0, at.1, at.1), ROM_BAD_ARGUMENT, "rotation");
        refused(rom_simulation_step(handles.simulation, null()), ROM_BAD_ARGUMENT, "loads is null");
        let mut settings = sized::<rom_settings>();
        good(rom_settings_init(&raw mut settings));
        settings.dt = -1.0;
        let made = rom_simulation_new(handles.model, &raw const settings, &raw mut simulation);
        refused(made, ROM_BAD_SETTINGS, "dt is -1");
        settings.integrator = 9;
        let made = rom_simulation_new(handles.model, &raw const settings, &raw mut simulation);
        refused(made, ROM_BAD_ARGUMENT, "rom_integrator");
        let n = Model::from_bytes(&bytes()).unwrap().n_points();
        assert_eq!((rom_model_n_modes(null()), rom_model_n_points(handles.model)), (0, n));
        assert!(rom_model_point_name(handles.model, n).is_null());
        assert_eq!(CStr::from_ptr(rom_model_load_case_name(handles.model, 0)), c"push");
        assert_eq!(CStr::from_ptr(rom_status_text(-1)), c"unknown status");
        assert_eq!(CStr::from_ptr(rom_version()).to_str().unwrap(), env!("CARGO_PKG_VERSION"));
        rom_model_free(null_mut());
    }
}

/// What C reads from a block of stations and sets on it is what Rust does, to the bit; mistakes are refused.
#[test]
fn inertias_are_those_of_rust() {
    let bytes = bytes();
    let expected = Model::from_bytes(&bytes).unwrap();
    let (mut model, mut axes) = (null_mut(), null_mut());
    let (mut rigid, mut apparent) = ([0.0; 36], [0.0; 36]);
    unsafe {
        good(rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &mut model));
        good(rom_model_mass_matrix(model, rigid.as_mut_ptr(), 36));
        good(rom_model_apparent_inertia(model, apparent.as_mut_ptr(), 36));
        refused(
            rom_model_mass_matrix(model, rigid.as_mut_ptr(), 6),
            rom_status::ROM_BAD_ARGUMENT,
            "expected 36",
        );
        good(rom_model_with_method(model, 1, &mut axes));
        let status = rom_model_apparent_inertia(axes, rigid.as_mut_ptr(), 36);
        assert_ne!(status, rom_status::ROM_OK);
        assert!(said().contains("mean-axes"), "{}", said());
        rom_model_free(axes);
        rom_model_free(model);
    }
    assert_eq!(rigid[..], expected.data().rigid.mass_matrix[..]);
    assert_eq!(apparent[..], *expected.apparent_inertia().unwrap().as_flattened());
}

#[test]
fn stations_are_those_of_rust() {
    use rom_runtime::data::{StationSet, StationsData};
    use rom_runtime::{DistributedFrame, StationAxes, Stations};
    use rom_status::*;
    let mut data = common::Lumped::random(3, 5).data(5);
    let (mut sections, point) = (StationSet::default(), data.points[1].clone());
    sections.position.extend(point.node_position);
    sections.rotation.extend(point.node_rotation);
    sections.phi_translation.extend(&point.phi_translation);
    sections.phi_rotation.extend(&point.phi_rotation);
    data.stations = vec![StationsData {
        name: "wing".into(),
        members: vec![("wing".into(), 1)],
        fraction: vec![0.5],
        offset: vec![0.1, 0.2, 0.3],
        sections,
    }];
    let bytes = data.to_bytes().unwrap();
    let (mut model, mut simulation, mut loads) = (null_mut(), null_mut(), null_mut());
    let (mut stations, mut block, wrench) = (null_mut(), 9_usize, [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
    let (mut position, mut attitude, mut velocity, mut spin) = ([0.0; 3], [0.0; 4], [0.0; 3], [0.0; 3]);
    unsafe {
        good(rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &raw mut model));
        assert_eq!(rom_model_n_station_blocks(model), 1);
        assert_eq!(CStr::from_ptr(rom_model_station_block_name(model, 0)), c"wing");
        assert!(rom_model_station_block_name(model, 1).is_null());
        let found = rom_model_find_station_block(model, c"tail".as_ptr(), &raw mut block);
        refused(found, ROM_NOT_FOUND, "wing");
        good(rom_model_find_station_block(model, c"wing".as_ptr(), &raw mut block));
        good(rom_stations_new(model, block, &raw mut stations));
        refused(
            rom_stations_new(model, 1, &raw mut stations),
            ROM_NOT_FOUND,
            "station block number 1; it has: wing",
        );
        assert_eq!((rom_stations_count(stations), rom_stations_count(null())), (1, 0));
        let new = |blocks: &[usize], loads| {
            rom_loads_new_with_stations(model, null(), null(), 0, blocks.as_ptr(), blocks.len(), loads)
        };
        refused(new(&[0, 0], &raw mut loads), ROM_BAD_SETTINGS, "each block of stations once");
        good(new(&[block], &raw mut loads));
        good(rom_simulation_new(model, null(), &raw mut simulation));
        let set =
            |slot, frame, w: &[f64]| rom_loads_set_stations(loads, slot, frame, w.as_ptr(), w.len() / 6);
        refused(set(1, 0, &wrench), ROM_NOT_FOUND, "slot is 1");
        refused(set(0, 3, &wrench), ROM_BAD_ARGUMENT, "rom_frame");
        refused(set(0, 0, &[0.0; 12]), ROM_BAD_ARGUMENT, "has 2 entries, expected 1");
        refused(set(0, 0, &[f64::NAN; 6]), ROM_BAD_ARGUMENT, "NaN");
        good(set(0, rom_frame::ROM_FRAME_NODE as u32, &wrench));
        good(rom_simulation_run(simulation, loads, 20));
        let mut read = |axes, n| {
            let parts =
                (position.as_mut_ptr(), attitude.as_mut_ptr(), velocity.as_mut_ptr(), spin.as_mut_ptr());
            rom_stations_read(stations, simulation, axes, n, parts.0, parts.1, parts.2, parts.3)
        };
        refused(read(3, 1), ROM_BAD_ARGUMENT, "rom_station_axes");
        refused(read(2, 2), ROM_BAD_ARGUMENT, "expected 1");
        good(read(rom_station_axes::ROM_STATION_SECTION as u32, 1));
        rom_stations_free(stations);
        rom_loads_free(loads);
        rom_simulation_free(simulation);
        rom_model_free(model);
    }
    let model = Arc::new(Model::new(data).unwrap());
    let mut set = LoadSet::with_stations(&model, &[], &[0], None).unwrap();
    assert!(set.set_stations(0, DistributedFrame::Follower, &wrench));
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    for _ in 0..20 {
        simulation.step(&set).unwrap();
    }
    let mut stations = Stations::new(&model, 0).unwrap();
    let motion = stations.read(&model, simulation.state(), StationAxes::Section).unwrap();
    assert_eq!((&motion.position[..], &motion.attitude[..]), (&position[..], &attitude[..]));
    assert_eq!((&motion.velocity[..], &motion.angular_velocity[..]), (&velocity[..], &spin[..]));
    assert!(velocity.iter().all(|v| *v != 0.0));
}

#[test]
fn section_forces_are_those_of_rust() {
    let mut data = Model::from_bytes(&bytes()).unwrap().data().clone();
    let m = data.modes.omega.len();
    let place = |name: &str, scale: f64| CutData {
        name: name.into(),
        member: "wing".into(),
        fraction: 0.5,
        rest: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        modal: (0..6 * m).map(|k| scale * (k as f64).sin()).collect(),
        modal_rate: Vec::new(),
        summation: None,
    };
    data.cuts = vec![place("root", 1.0), place("tip", 0.3)];
    let bytes = data.to_bytes().unwrap();
    let model = Arc::new(Model::new(data).unwrap());
    let mut own = Simulation::new(model.clone(), Settings::default()).unwrap();
    let set = LoadSet::with_case(&model, &[], model.load_case("push").unwrap()).unwrap();
    unsafe {
        let (mut handle, mut simulation, mut loads) = (null_mut(), null_mut(), null_mut());
        good(rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &raw mut handle));
        good(rom_simulation_new(handle, null(), &raw mut simulation));
        good(rom_loads_new(handle, c"push".as_ptr(), null(), 0, &raw mut loads));
        assert_eq!(rom_model_n_sections(handle), 2);
        assert_eq!(CStr::from_ptr(rom_model_section_name(handle, 1)), c"tip");
        assert!(rom_model_section_name(handle, 2).is_null());
        let mut section = 9;
        good(rom_model_find_section(handle, c"tip".as_ptr(), &raw mut section));
        assert_eq!(section, 1);
        let status = rom_model_find_section(handle, c"kink".as_ptr(), &raw mut section);
        refused(status, rom_status::ROM_NOT_FOUND, "root");
        let mut forces = [0.0; 12];
        for _ in 0..20 {
            good(rom_simulation_step(simulation, loads));
            own.step(&set).unwrap();
        }
        let status = rom_simulation_section_forces(simulation, loads, forces.as_mut_ptr(), 6);
        refused(status, rom_status::ROM_BAD_ARGUMENT, "expected 12");
        good(rom_simulation_section_forces(simulation, loads, forces.as_mut_ptr(), 12));
        let found: Vec<f64> = own.find_section_forces(&set).unwrap().iter().flat_map(|s| s.best).collect();
        assert_eq!(found, forces);
        assert!(forces[0] != 1.0, "the structure has moved");
        rom_loads_free(loads);
        rom_simulation_free(simulation);
        rom_model_free(handle);
    }
}
