//! A step through the C interface beside the same step in Rust, in one run: `cargo bench -p rom-capi`.
//!
//! The functions are called through pointers the compiler cannot see through, as a C program calls a library.
#![allow(unsafe_code)]

#[path = "../../runtime/tests/common/mod.rs"]
mod common;

use std::hint::black_box;
use std::ptr::null_mut;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use rom::{rom_frame, rom_loads, rom_model, rom_point, rom_simulation, rom_status};
use rom_runtime::{Integrator, LoadFrame, LoadSet, Model, Settings, Simulation};

const FORCE: [f64; 3] = [0.0, 1.0, 0.0];
const MOMENT: [f64; 3] = [0.0; 3];

fn in_rust(criterion: &mut Criterion, bytes: &[u8], integrator: Integrator) {
    let model = Arc::new(Model::from_bytes(bytes).unwrap());
    let mut loads = LoadSet::new(&model, &[0]).unwrap();
    let settings = Settings { dt: 1e-3, integrator, ..Settings::default() };
    let mut simulation = Simulation::new(model, settings).unwrap();
    criterion.bench_function(&format!("{integrator} in Rust"), |b| {
        b.iter(|| {
            loads.clear();
            assert!(loads.add(0, &LoadFrame::Dead, black_box(FORCE), black_box(MOMENT)));
            simulation.step(black_box(&loads)).unwrap();
            black_box(simulation.point_output(0));
        });
    });
}

fn through_c(criterion: &mut Criterion, bytes: &[u8], integrator: Integrator, number: u32) {
    let (mut model, mut loads, mut simulation) =
        (null_mut::<rom_model>(), null_mut::<rom_loads>(), null_mut::<rom_simulation>());
    let (step, point) = (black_box(rom::rom_simulation_step), black_box(rom::rom_simulation_point));
    let (clear, add) = (black_box(rom::rom_loads_clear), black_box(rom::rom_loads_add));
    let settings = rom::rom_settings {
        struct_size: size_of::<rom::rom_settings>() as u64,
        dt: 1e-3,
        numerical_damping: 0.0,
        integrator: number,
        max_iterations: 40,
    };
    let mut out = rom_point { struct_size: size_of::<rom_point>() as u64, dr_a: [0.0; 3], r_g: [0.0; 3] };
    let good = |status| assert_eq!(status, rom_status::ROM_OK);
    // SAFETY: every pointer is to something that lives until the end of this function.
    unsafe {
        good(rom::rom_model_from_bytes(bytes.as_ptr(), bytes.len(), &raw mut model));
        good(rom::rom_loads_new(model, std::ptr::null(), &0, 1, &raw mut loads));
        good(rom::rom_simulation_new(model, &raw const settings, &raw mut simulation));
        criterion.bench_function(&format!("{integrator} through C"), |b| {
            b.iter(|| {
                good(clear(loads));
                let frame = rom_frame::ROM_FRAME_DEAD as u32;
                good(add(loads, 0, frame, black_box(FORCE).as_ptr(), black_box(MOMENT).as_ptr()));
                good(step(simulation, loads));
                good(point(simulation, 0, &raw mut out));
                black_box(&out);
            });
        });
        rom::rom_simulation_free(simulation);
        rom::rom_loads_free(loads);
        rom::rom_model_free(model);
    }
}

fn overhead(criterion: &mut Criterion) {
    let bytes = common::Lumped::frame(10).data(1).to_bytes().unwrap();
    for (integrator, number) in [(Integrator::Newmark, 0), (Integrator::Rk4, 1)] {
        in_rust(criterion, &bytes, integrator);
        through_c(criterion, &bytes, integrator, number);
    }
}

criterion_group!(benches, overhead);
criterion_main!(benches);
