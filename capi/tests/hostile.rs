//! The C interface under conversations no header would allow, but for what it cannot check (pointers to less than they say): handles
//! that are null or of another model, lengths, numbers and names of any kind, damaged models, in any order. Every call is done or
//! refused with a reason; none reports a defect, and a step that is done leaves numbers.
#![allow(unsafe_code)]
#![allow(clippy::undocumented_unsafe_blocks)] // pointers to locals and handles of this test throughout

#[path = "../../runtime/tests/common/mod.rs"]
mod common;
#[path = "../../tests/fuzz/mod.rs"]
mod fuzz;

use std::ffi::{CStr, CString, c_char};
use std::ptr::{null, null_mut};

use fuzz::{Random, fuzz};
use rom::*;
use rom_runtime::data::StationsData;
use rom_runtime::time::TimeFunction;
use rom_runtime::{Load, LoadCase, LoadFrame};

/// A body with a load case and, if asked for, a block of stations.
fn body(m: usize, seed: u64, stations: bool) -> Vec<u8> {
    let mut data = common::Lumped::random(m, seed).data(seed);
    data.load_cases = vec![LoadCase {
        t_end: 1.0,
        dt: 0.01,
        loads: vec![Load {
            point: 1,
            frame: LoadFrame::Dead,
            force: [1.0, 2.0, 3.0],
            moment: [0.1, 0.0, 0.2],
            time: TimeFunction::Ramp { rate: 1.0, start: 0.0, end: 1.0 },
        }],
        ..LoadCase::empty("push")
    }];
    if stations {
        data.stations = vec![StationsData {
            name: "wing".into(),
            members: vec![("only".into(), 3)],
            fraction: vec![0.0, 0.5, 1.0],
            offset: vec![0.1; 9],
            sections: common::sections_at(&data.points[..3]),
        }];
    }
    data.to_bytes().unwrap()
}

/// Numbers a host may hand over by mistake, among sensible ones.
fn number(random: &mut Random) -> f64 {
    match random.below(8) {
        0 => *random.of(&[0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e-308, 5e-324]),
        1 => f64::from_bits(random.next()),
        _ => random.below(2001) as f64 / 1000.0 - 1.0,
    }
}

fn numbers(n: usize, random: &mut Random) -> Vec<f64> {
    (0..n).map(|_| number(random)).collect()
}

/// Mostly the length that is right.
fn length(right: usize, random: &mut Random) -> usize {
    if random.below(6) == 0 { random.below(2 * right + 3) } else { right }
}

fn name(random: &mut Random) -> CString {
    let bytes =
        *random.of(&[b"push".as_slice(), b"wing", b"p0", b"P", b"", b"\xff\xfe", b"a longer name than any"]);
    CString::new(bytes).unwrap()
}

/// What an operation is done on: at most two of a kind are kept, and null is among them.
struct Hands<T> {
    alive: Vec<*mut T>,
    free: unsafe extern "C" fn(*mut T),
}

impl<T> Hands<T> {
    fn new(free: unsafe extern "C" fn(*mut T)) -> Self {
        Self { alive: Vec::new(), free }
    }

    fn any(&self, random: &mut Random) -> *mut T {
        if random.below(12) == 0 {
            return null_mut();
        }
        self.alive.get(random.below(self.alive.len())).copied().unwrap_or(null_mut())
    }

    fn keep(&mut self, status: rom_status, handle: *mut T, random: &mut Random) {
        assert_eq!(
            status == rom_status::ROM_OK,
            !handle.is_null(),
            "a handle comes with ROM_OK and only then"
        );
        if handle.is_null() {
            return;
        }
        self.alive.push(handle);
        if self.alive.len() > 2 {
            unsafe { (self.free)(self.alive.swap_remove(random.below(3))) }
        }
    }
}

impl<T> Drop for Hands<T> {
    fn drop(&mut self) {
        self.alive.iter().for_each(|&handle| unsafe { (self.free)(handle) });
    }
}

/// One host.
struct Host {
    bodies: Vec<Vec<u8>>,
    models: Hands<rom_model>,
    loads: Hands<rom_loads>,
    simulations: Hands<rom_simulation>,
    evaluators: Hands<rom_evaluator>,
    stations: Hands<rom_stations>,
}

fn fine(status: rom_status) -> bool {
    let said = unsafe { CStr::from_ptr(rom_last_error()) }.to_str().expect("the reason is text");
    assert_ne!(status, rom_status::ROM_INTERNAL, "{said}");
    assert!(status == rom_status::ROM_OK || !said.is_empty(), "{status:?} without a reason");
    status == rom_status::ROM_OK
}

/// A structure of the header with any bits, and mostly its own size.
fn structure<T>(random: &mut Random) -> T {
    let size = size_of::<T>();
    let mut words: Vec<u64> = (0..size / 8).map(|_| number(random).to_bits()).collect();
    words[0] = if random.below(6) == 0 { *random.of(&[0, 7, 8, 16, u64::MAX]) } else { size as u64 };
    // No larger than it is: what the library may write is what there is.
    assert!(words[0] <= size as u64 || words[0] > 1 << 16);
    unsafe { words.as_ptr().cast::<T>().read() }
}

impl Host {
    fn new(bodies: Vec<Vec<u8>>) -> Self {
        Self {
            bodies,
            models: Hands::new(rom_model_free),
            loads: Hands::new(rom_loads_free),
            simulations: Hands::new(rom_simulation_free),
            evaluators: Hands::new(rom_evaluator_free),
            stations: Hands::new(rom_stations_free),
        }
    }

    fn speak(&mut self, random: &mut Random) {
        match random.below(8) {
            0 => self.make_model(random),
            1 => self.make_others(random),
            2 => self.ask_model(random),
            3 => self.load(random),
            4 => self.evaluate(random),
            5 => self.read(random),
            6 => self.set_state(random),
            _ => self.step(random),
        }
    }

    fn make_model(&mut self, random: &mut Random) {
        let mut made = null_mut();
        if random.below(3) == 0 {
            let status = unsafe {
                rom_model_with_method(self.models.any(random), random.below(4) as u32, &raw mut made)
            };
            fine(status);
            return self.models.keep(status, made, random);
        }
        let mut bytes = random.of(&self.bodies).clone();
        if random.below(4) == 0 {
            let at = random.below(bytes.len());
            bytes[at] ^= 1 << random.below(8);
            bytes.truncate(if random.below(2) == 0 { bytes.len() } else { random.below(bytes.len() + 1) });
        }
        let status = unsafe { rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &raw mut made) };
        fine(status);
        self.models.keep(status, made, random);
    }

    fn make_others(&mut self, random: &mut Random) {
        let model = self.models.any(random);
        match random.below(4) {
            0 => {
                let mut made = null_mut();
                let settings: rom_settings = structure(random);
                let mut settings = settings;
                if random.below(2) == 0 {
                    settings.dt = 0.01;
                    settings.numerical_damping = 0.0;
                    settings.integrator = random.below(5) as u32;
                    // An implicit step that does not converge goes on to the last iteration.
                    settings.max_iterations = random.below(60) as u32;
                }
                let given = if random.below(3) == 0 { null() } else { &raw const settings };
                let status = unsafe { rom_simulation_new(model, given, &raw mut made) };
                fine(status);
                self.simulations.keep(status, made, random);
            }
            1 => {
                let mut made = null_mut();
                let status = unsafe { rom_evaluator_new(model, &raw mut made) };
                fine(status);
                self.evaluators.keep(status, made, random);
            }
            2 => {
                let mut made = null_mut();
                let status = unsafe { rom_stations_new(model, random.below(3), &raw mut made) };
                fine(status);
                self.stations.keep(status, made, random);
            }
            _ => self.make_loads(model, random),
        }
    }

    fn make_loads(&mut self, model: *const rom_model, random: &mut Random) {
        let mut made = null_mut();
        let points: Vec<usize> = (0..random.below(4))
            .map(|_| if random.below(12) == 0 { usize::MAX } else { random.below(5) })
            .collect();
        let case = name(random);
        let case: *const c_char = if random.below(2) == 0 { null() } else { case.as_ptr() };
        let status = if random.below(2) == 0 {
            unsafe { rom_loads_new(model, case, points.as_ptr(), points.len(), &raw mut made) }
        } else {
            let blocks: Vec<usize> = (0..random.below(3)).map(|_| random.below(2)).collect();
            let (p, b) = (points.as_ptr(), blocks.as_ptr());
            unsafe {
                rom_loads_new_with_stations(model, case, p, points.len(), b, blocks.len(), &raw mut made)
            }
        };
        fine(status);
        self.loads.keep(status, made, random);
    }

    fn ask_model(&mut self, random: &mut Random) {
        let model = self.models.any(random);
        let name = name(random);
        let (mut place, mut dt) = (0_usize, 0.0);
        let mut case: rom_load_case = structure(random);
        let mut layout: rom_state_layout = structure(random);
        unsafe {
            fine(rom_model_find_point(model, name.as_ptr(), &raw mut place));
            fine(rom_model_find_station_block(model, name.as_ptr(), &raw mut place));
            fine(rom_model_find_sensor(model, name.as_ptr(), &raw mut place));
            fine(rom_model_load_case(model, name.as_ptr(), &raw mut case));
            fine(rom_model_state_layout(model, &raw mut layout));
            fine(rom_model_stable_dt(model, random.below(5) as u32, &raw mut dt));
            for i in 0..4 {
                let i = if i == 3 { usize::MAX } else { i };
                for text in [
                    rom_model_point_name(model, i),
                    rom_model_load_case_name(model, i),
                    rom_model_load_case_description(model, i),
                    rom_model_station_block_name(model, i),
                    rom_model_sensor_name(model, i),
                ] {
                    assert!(text.is_null() || CStr::from_ptr(text).to_str().is_ok());
                }
            }
            let n = length(rom_model_n_modes(model), random);
            let mut array = numbers(n.max(80), random);
            fine(rom_model_frequencies(model, array.as_mut_ptr(), n));
            fine(rom_model_gravity(model, array.as_mut_ptr(), length(3, random)));
            let member = if random.below(2) == 0 { null() } else { name.as_ptr() };
            let (point, to) = (random.below(6), array.as_mut_ptr());
            fine(rom_model_section_axes(model, point, member, to, length(9, random)));
            fine(rom_model_mass_matrix(model, array.as_mut_ptr(), length(36, random)));
            fine(rom_model_apparent_inertia(model, array.as_mut_ptr(), length(36, random)));
        }
    }

    fn load(&mut self, random: &mut Random) {
        let loads = self.loads.any(random);
        let model = self.models.any(random);
        let (slot, frame) = (random.below(5), random.below(4) as u32);
        let given = numbers(30, random);
        let (force, moment, section) = (given.as_ptr(), given[3..].as_ptr(), given[6..].as_ptr());
        let turn = common::rotation_rows(&nalgebra::Vector3::new(0.3, -0.2, 0.5));
        unsafe {
            match random.below(6) {
                0 => fine(rom_loads_clear(loads)),
                1 => fine(rom_loads_add(loads, slot, frame, force, moment)),
                2 => fine(rom_loads_add_in_section(loads, slot, section, force, moment)),
                3 => fine(rom_loads_add_in_section(loads, slot, turn.as_flattened().as_ptr(), force, moment)),
                4 => {
                    let n = length(rom_model_n_modes(model), random).min(given.len());
                    fine(rom_loads_add_modal(loads, given.as_ptr(), n))
                        | fine(rom_loads_add_wrench(loads, frame, force, moment))
                }
                _ => {
                    fine(rom_loads_set_stations(loads, slot, frame, given.as_ptr(), length(3, random).min(5)))
                }
            };
        }
    }

    fn evaluate(&mut self, random: &mut Random) {
        let (evaluator, loads, model) =
            (self.evaluators.any(random), self.loads.any(random), self.models.any(random));
        let (n, tangent) = unsafe { (rom_model_n_variables(model), rom_model_n_tangent(model)) };
        let n = length(n, random);
        let (y, mut y_dot) = (numbers(n, random), vec![0.0; n]);
        let entries = length(tangent * tangent, random);
        let (mut matrix, mut column) = (vec![0.0; entries], vec![0.0; length(tangent, random)]);
        unsafe {
            let t = number(random);
            fine(rom_evaluator_derivatives(evaluator, t, y.as_ptr(), n, loads, y_dot.as_mut_ptr()));
            fine(rom_evaluator_jacobian(evaluator, t, y.as_ptr(), n, loads, matrix.as_mut_ptr(), entries));
            fine(rom_evaluator_by_load(evaluator, loads, column.as_mut_ptr(), column.len()));
        }
    }

    fn read(&mut self, random: &mut Random) {
        let simulation = self.simulations.any(random);
        let stations = self.stations.any(random);
        let loads = self.loads.any(random);
        unsafe {
            let mut motion: rom_point_motion = structure(random);
            fine(rom_simulation_point_motion(simulation, loads, random.below(6), &raw mut motion));
            let mut reading: rom_sensor_reading = structure(random);
            fine(rom_simulation_sensor(simulation, loads, random.below(2), &raw mut reading));
            let mut rigid: rom_rigid = structure(random);
            fine(rom_simulation_rigid(simulation, &raw mut rigid));
            let mut point: rom_point = structure(random);
            fine(rom_simulation_point(simulation, random.below(6), &raw mut point));
            let mut ledger: rom_ledger = structure(random);
            fine(rom_simulation_ledger(simulation, &raw mut ledger));
            let mut reaction: rom_reaction = structure(random);
            fine(rom_simulation_reaction(simulation, &raw mut reaction));
            let mut estimate: rom_error_estimate = structure(random);
            fine(rom_simulation_error_estimate(simulation, &raw mut estimate));
            let n = length(rom_stations_count(stations), random);
            let mut places = vec![0.0; 4 * n];
            let place = if random.below(3) == 0 { null_mut() } else { places.as_mut_ptr() };
            let axes = random.below(4) as u32;
            fine(rom_stations_read(stations, simulation, axes, n, null_mut(), place, null_mut(), null_mut()));
        }
    }

    fn set_state(&mut self, random: &mut Random) {
        let (simulation, model) = (self.simulations.any(random), self.models.any(random));
        let mut layout: rom_state_layout = structure(random);
        layout.struct_size = size_of::<rom_state_layout>() as u64;
        unsafe {
            if !fine(rom_model_state_layout(model, &raw mut layout)) {
                return;
            }
            let n = length(layout.size as usize, random);
            let mut state = numbers(n, random);
            // What is there, a little changed; or anything.
            if random.below(4) > 0 && fine(rom_simulation_get_state(simulation, state.as_mut_ptr(), n)) {
                state[random.below(n)] = number(random);
            }
            fine(rom_simulation_set_state(simulation, state.as_ptr(), n));
        }
    }

    fn step(&mut self, random: &mut Random) {
        let (simulation, loads) = (self.simulations.any(random), self.loads.any(random));
        let motion: rom_motion = structure(random);
        let done = unsafe {
            match random.below(10) {
                8 => {
                    fine(rom_simulation_start(simulation, name(random).as_ptr()));
                    return;
                }
                9 => {
                    let field = numbers(3, random);
                    // So that the numbers of a step that is done stay what the test below asks for.
                    if field.iter().all(|x| x.abs() < 10.0 || !x.is_finite()) {
                        fine(rom_simulation_set_gravity(simulation, field.as_ptr()));
                    }
                    return;
                }
                0 => {
                    fine(rom_simulation_watch_errors(simulation, random.below(4) as u32));
                    return;
                }
                1 => {
                    fine(rom_simulation_prescribe(simulation, loads, &raw const motion));
                    return;
                }
                2 => fine(rom_simulation_step_prescribed(simulation, loads, &raw const motion)),
                3 => fine(rom_simulation_run(simulation, loads, random.below(6) as u64)),
                _ => fine(rom_simulation_step(simulation, loads)),
            }
        };
        if done {
            let mut rigid: rom_rigid = structure(random);
            rigid.struct_size = size_of::<rom_rigid>() as u64;
            assert!(fine(unsafe { rom_simulation_rigid(simulation, &raw mut rigid) }));
            let values = [rigid.r_g, rigid.v_a, rigid.w_a, rigid.v_g, rigid.w_g];
            assert!(values.iter().flatten().chain(&rigid.zeta).all(|x| x.is_finite()), "{values:?}");
        }
    }
}

#[test]
fn conversations() {
    let bodies = vec![body(3, 5, true), body(1, 6, false), body(5, 7, true)];
    let mut outcomes = [0_u64; 2];
    fuzz("C interface", |random| {
        let mut host = Host::new(bodies.clone());
        for _ in 0..60 {
            host.speak(random);
        }
        outcomes[0] += u64::from(!host.simulations.alive.is_empty());
        outcomes[1] += u64::from(!host.loads.alive.is_empty());
    });
    // Conversations that never come to a simulation would test nothing.
    assert!(outcomes.iter().all(|&n| n > 0), "{outcomes:?}");
}
