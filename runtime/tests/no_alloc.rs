//! Stepping does not allocate: counted by the global allocator of this binary, per thread (the test harness has its own).

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use common::{Lumped, Random, rotation_rows};
use rom_runtime::data::{CutData, StationSet, StationsData, SummationData};
use rom_runtime::expression::{Binary, Instruction, Program, Unary, Variable};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    Direction, DistributedFrame, Integrator, Jacobian, Load, LoadCase, LoadFrame, LoadSet, Model,
    PrescribedMotion, SectionForces, Settings, Simulation, State, StateRate, StationAxes, Stations,
    Workspace,
};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

fn note() {
    // Fails only while a thread ends.
    let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: forwards to the system allocator; counting does not touch memory it hands out.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // Giving memory back counts too: it takes the same locks.
        note();
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note();
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn count(mut work: impl FnMut()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    work();
    ALLOCATIONS.with(Cell::get) - before
}

fn every_time_function() -> Vec<TimeFunction> {
    let program = Program {
        source: "-0.1 * vx * abs(vx) + sin(t)".into(),
        code: vec![
            Instruction::Constant(-0.1),
            Instruction::Variable(Variable::Vx),
            Instruction::Binary(Binary::Mul),
            Instruction::Variable(Variable::Vx),
            Instruction::Unary(Unary::Abs),
            Instruction::Binary(Binary::Mul),
            Instruction::Variable(Variable::T),
            Instruction::Unary(Unary::Sin),
            Instruction::Binary(Binary::Add),
        ],
    };
    vec![
        TimeFunction::Constant { value: 0.5 },
        TimeFunction::Step { value: 1.0, start: 0.02, end: 0.2 },
        TimeFunction::Ramp { rate: 2.0, start: 0.0, end: 0.3 },
        TimeFunction::Triangle { peak: 1.0, start: 0.0, at: 0.1, end: 0.2 },
        TimeFunction::Sine { amplitude: 1.0, omega: 5.0, phase: 0.1, start: 0.0, end: 1.0 },
        TimeFunction::OneMinusCosine { amplitude: 1.0, start: 0.0, duration: 0.3 },
        TimeFunction::Table { t: vec![0.0, 0.1, 0.3], value: vec![0.0, 1.0, -1.0] },
        TimeFunction::Expression { program },
    ]
}

fn every_load(model: &Model) -> LoadCase {
    let mut random = Random::new(3);
    let mut loads = Vec::new();
    for time in every_time_function() {
        for frame in [
            LoadFrame::Dead,
            LoadFrame::Body,
            LoadFrame::Follower { section: rotation_rows(&random.vector()) },
        ] {
            loads.push(Load {
                point: (loads.len() % model.n_points()) as u32,
                frame,
                force: random.array(2.0),
                moment: random.array(2.0),
                time: time.clone(),
            });
        }
    }
    LoadCase { dt: 0.01, loads, ..LoadCase::empty("all") }
}

#[test]
fn a_step_does_not_allocate() {
    // The counter counts.
    assert!(count(|| drop(std::hint::black_box(Box::new(1)))) == 2);

    let model = Arc::new(Model::new(Lumped::random(4, 7).data(7)).unwrap());
    let loads = model.prepare(&every_load(&model)).unwrap();
    let mut set = LoadSet::new(&model, &[1, 2]).unwrap();
    let section = LoadFrame::Follower { section: rotation_rows(&nalgebra::Vector3::new(0.1, 0.2, 0.3)) };
    let mut fast = State::at_rest(&model);
    fast.beta_star = [0.5, -0.4, 0.3, 1.0, 3.5, -1.5];
    for integrator in Integrator::of(&model) {
        for dt in [0.01, 0.1] {
            // The long step takes the implicit integrators through Newton's corrections.
            if integrator == Integrator::Rk4 && dt > 0.05 {
                continue;
            }
            let settings = Settings { dt, integrator, ..Settings::default() };
            let mut simulation = Simulation::new(model.clone(), settings).unwrap();
            let allocations = count(|| {
                simulation.restore(&fast).unwrap();
                for _ in 0..if dt < 0.05 { 40 } else { 5 } {
                    simulation.step(&loads).unwrap();
                    set.clear();
                    assert!(set.add(0, &LoadFrame::Dead, [0.1; 3], [0.2; 3]));
                    assert!(set.add(1, &section, [0.1; 3], [0.2; 3]));
                    simulation.step(&set).unwrap();
                    std::hint::black_box(simulation.rigid_output());
                    std::hint::black_box(simulation.point_output(1));
                    std::hint::black_box(simulation.ledger());
                }
            });
            assert_eq!(allocations, 0, "{integrator}, dt = {dt}");
        }
    }
    for integrator in Integrator::of(&model) {
        let mut simulation =
            Simulation::new(model.clone(), Settings { integrator, ..Settings::default() }).unwrap();
        let spin = PrescribedMotion { velocity: fast.beta_star, ..Default::default() };
        let allocations = count(|| {
            simulation.prescribe(&loads, &PrescribedMotion::default()).unwrap();
            for _ in 0..40 {
                simulation.step_prescribed(&loads, &spin).unwrap();
                std::hint::black_box(simulation.reaction());
            }
        });
        assert_eq!(allocations, 0, "prescribed motion, {integrator}");
    }
    let (mut work, mut rate) = (Workspace::new(&model), StateRate::new(&model));
    assert_eq!(count(|| model.derivatives(&fast, &loads, &mut work, &mut rate).unwrap()), 0, "derivatives");

    let (mut jacobian, mut column) = (Jacobian::new(model.clone()), vec![0.0; 2 * 4 + 12]);
    let allocations = count(|| {
        jacobian.evaluate(&fast, &loads).unwrap();
        jacobian.by_load(&set, &mut column).unwrap();
        jacobian.evaluate_prescribed(&fast, &loads, &[0.1; 6]).unwrap();
        jacobian.by_rate(2, &mut column).unwrap();
        let along = Direction { state: &column, u_dot: &[] };
        std::hint::black_box((jacobian.rigid_output(along), jacobian.point_motion(along, 1)));
        std::hint::black_box((jacobian.frame_rate(along), jacobian.ledger(along)));
        std::hint::black_box((jacobian.point_output(along, 1), jacobian.sensor_reading(along, 0)));
    });
    assert_eq!(allocations, 0, "derivatives of the equations");

    // Errors do not allocate either.
    let strict = Settings { max_iterations: 1, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), strict).unwrap();
    simulation.restore(&fast).unwrap();
    assert_eq!(count(|| assert!(simulation.step(&loads).is_err())), 0, "a refused step");
}

#[test]
fn an_aerodynamic_code_does_not_allocate() {
    let mut data = Lumped::random(4, 7).data(7);
    let mut sections = StationSet::default();
    for point in &data.points {
        sections.position.extend(point.node_position);
        sections.rotation.extend(point.node_rotation);
        sections.phi_translation.extend(&point.phi_translation);
        sections.phi_rotation.extend(&point.phi_rotation);
    }
    let n = sections.len();
    data.stations = vec![StationsData {
        name: "wing".into(),
        members: vec![("wing".into(), n as u32)],
        fraction: vec![0.5; n],
        offset: vec![0.1; 3 * n],
        sections,
    }];
    let model = Arc::new(Model::new(data).unwrap());
    let mut stations = Stations::new(&model, 0).unwrap();
    let mut set = LoadSet::with_stations(&model, &[], &[0], None).unwrap();
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let mut wrenches = vec![0.0; 6 * n];
    let allocations = count(|| {
        for _ in 0..10 {
            let motion = stations.read(&model, simulation.state(), StationAxes::Section).unwrap();
            for (wrench, v) in wrenches.iter_mut().zip(&motion.velocity) {
                *wrench = 0.1 - v;
            }
            assert!(set.set_stations(0, DistributedFrame::Follower, &wrenches));
            simulation.step(&set).unwrap();
        }
    });
    assert_eq!(allocations, 0);
}

#[test]
fn section_forces_do_not_allocate() {
    let mut data = Lumped::random(4, 7).data(7);
    let (m, places) = (data.modes.omega.len(), data.points.len());
    let mut random = Random::new(9);
    let mut list = |n: usize| (0..n).map(|_| random.next()).collect::<Vec<f64>>();
    data.cuts = vec![CutData {
        name: "root".into(),
        member: "wing".into(),
        fraction: 0.5,
        rest: [1.0; 6],
        modal: list(6 * m),
        modal_rate: list(6 * m),
        summation: Some(SummationData {
            constant: [2.0; 6],
            inertia: list(6 * (m + 6)),
            damping: list(6 * m),
            c: list(36 * (m + 6)),
            k: list(126 * m),
            gravity: list(18 * m),
            places: list(36 * places),
        }),
    }];
    let mut wrong = data.clone();
    wrong.cuts[0].summation.as_mut().unwrap().places.pop();
    let error = Model::new(wrong).unwrap_err().to_string();
    assert!(error.contains("places of internal loads \"root\"") && error.contains("expected"), "{error}");
    let model = Arc::new(Model::new(data).unwrap());
    assert!(model.section("tip").unwrap_err().to_string().contains("root"));
    let loads = model.prepare(&every_load(&model)).unwrap();
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let (mut jacobian, mut along) = (Jacobian::new(model), [SectionForces::default()]);
    let direction = vec![1.0; jacobian.size()];
    let allocations = count(|| {
        for _ in 0..5 {
            simulation.step(&loads).unwrap();
            std::hint::black_box(simulation.find_section_forces(&loads).unwrap());
            jacobian.evaluate(simulation.state(), &loads).unwrap();
            let along_all = Direction { state: &direction, u_dot: &direction[..m + 6] };
            jacobian.section_forces(along_all, &loads, &mut along).unwrap();
            jacobian.section_forces_of_load(&loads, &mut along).unwrap();
        }
    });
    assert_eq!(allocations, 0);
    assert!(simulation.section_forces()[0].best != simulation.section_forces()[0].by_modes);
}
