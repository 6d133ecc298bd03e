//! Stepping a consistent model does not allocate, watched or not: counted by the global allocator of this binary, per thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use rom_generator::input::Structure;
use rom_generator::{BuildOptions, Elastic, Inertia, ModeSelection, build::build};
use rom_runtime::{Integrator, LoadFrame, LoadSet, Model, PrescribedMotion, Settings, Simulation, State};

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

#[test]
fn a_step_of_a_consistent_model_does_not_allocate() {
    let text = include_str!("../../models/fmb.toml");
    let sets = [("elements".to_owned(), "24".to_owned())];
    let structure = Structure::from_toml_str(text, "fmb.toml", &sets).unwrap_or_else(|e| panic!("{e}"));
    let options = BuildOptions {
        modes: ModeSelection::Count(5),
        all_nodes: false,
        inertia: Inertia::Consistent,
        elastic: Elastic::Geometric,
        ..BuildOptions::default()
    };
    let model = Arc::new(Model::new(build(&structure, &options, &mut |_| ()).unwrap()).unwrap());
    let loads = model.prepare(model.load_case("lc1").unwrap()).unwrap();
    let point = model.point("P").unwrap();
    let mut set = LoadSet::new(&model, &[point]).unwrap();
    let mut fast = State::at_rest(&model);
    fast.beta_star = [0.5, -0.4, 0.3, 0.4, 1.5, -0.6];
    fast.q[0] = 0.5;
    for integrator in Integrator::of(&model) {
        // The long step takes the energy-momentum method to its Jacobian by differences.
        for dt in [0.01, 0.3] {
            if dt > 0.1 && integrator != Integrator::EnergyMomentum {
                continue;
            }
            let mut simulation =
                Simulation::new(model.clone(), Settings { dt, integrator, ..Settings::default() }).unwrap();
            for watched in [false, true] {
                if watched {
                    simulation.watch_errors(2);
                }
                let allocations = count(|| {
                    simulation.restore(&fast).unwrap();
                    for _ in 0..10 {
                        simulation.step(&loads).unwrap();
                        set.clear();
                        assert!(set.add(0, &LoadFrame::Body, [0.1; 3], [0.2; 3]));
                        simulation.step(&set).unwrap();
                        std::hint::black_box(simulation.point_output(point));
                        std::hint::black_box(simulation.ledger());
                    }
                });
                assert_eq!(allocations, 0, "{integrator}, dt = {dt}, watched: {watched}");
            }
        }
        if integrator != Integrator::EnergyMomentum {
            let settings = Settings { integrator, ..Settings::default() };
            let mut simulation = Simulation::new(model.clone(), settings).unwrap();
            let spin = PrescribedMotion { velocity: [0.0, 0.0, 0.0, 0.1, 0.2, 0.3], ..Default::default() };
            let allocations = count(|| {
                simulation.prescribe(&loads, &PrescribedMotion::default()).unwrap();
                for _ in 0..10 {
                    simulation.step_prescribed(&loads, &spin).unwrap();
                }
            });
            assert_eq!(allocations, 0, "prescribed motion, {integrator}");
        }
    }
}
