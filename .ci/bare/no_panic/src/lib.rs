//! What a host calls from step to step, linked without anything that panics or allocates: the panic handler and the allocator call
//! functions that do not exist, so that the library links only if nothing that is kept can reach them.
#![no_std]

#[cfg(feature = "fail")]
extern crate alloc;

use core::alloc::{GlobalAlloc, Layout};

use rom_runtime::{
    Batch, ErrorEstimate, Ledger, LoadFrame, LoadSet, PointMotion, PointOutput, PreparedLoads,
    PrescribedMotion, Reaction, RigidOutput, SensorReading, SettingsError, Simulation, State, StateRate,
    StepError, Workspace,
};

unsafe extern "C" {
    fn something_can_panic() -> !;
    fn something_can_allocate() -> *mut u8;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe { something_can_panic() }
}

struct None;

unsafe impl GlobalAlloc for None {
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        unsafe { something_can_allocate() }
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {
        unsafe { something_can_allocate() };
    }
}

#[global_allocator]
static ALLOCATOR: None = None;

// Of the core library as it comes, which is built to unwind.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}
#[unsafe(no_mangle)]
extern "C" fn _Unwind_Resume() {}

type Out<T> = Result<T, StepError>;
type Outputs = (
    RigidOutput,
    Ledger,
    Option<PointOutput>,
    Option<PointMotion>,
    Option<SensorReading>,
    Option<ErrorEstimate>,
);

#[unsafe(no_mangle)]
pub fn step(simulation: &mut Simulation, loads: &PreparedLoads, out: &mut Out<()>) {
    *out = simulation.step(loads);
}

#[unsafe(no_mangle)]
pub fn step_under_loads_of_host(
    simulation: &mut Simulation,
    loads: &mut LoadSet,
    wrench: &[f64; 6],
    out: &mut Out<()>,
) {
    let [fx, fy, fz, mx, my, mz] = *wrench;
    loads.clear();
    if loads.add(0, &LoadFrame::Body, [fx, fy, fz], [mx, my, mz]) && loads.add_modal(wrench) {
        loads.add_wrench(&LoadFrame::Dead, [fx, fy, fz], [mx, my, mz]);
        *out = simulation.step(loads);
    }
}

#[unsafe(no_mangle)]
pub fn step_prescribed(
    simulation: &mut Simulation,
    loads: &LoadSet,
    motion: &PrescribedMotion,
    out: &mut Out<Option<Reaction>>,
) {
    *out = simulation.step_prescribed(loads, motion).map(|()| simulation.reaction());
}

#[unsafe(no_mangle)]
pub fn prescribe(simulation: &mut Simulation, loads: &LoadSet, motion: &PrescribedMotion, out: &mut Out<()>) {
    *out = simulation.prescribe(loads, motion);
}

#[unsafe(no_mangle)]
pub fn restore(simulation: &mut Simulation, state: &State, out: &mut Result<(), SettingsError>) {
    *out = simulation.restore(state);
}

#[unsafe(no_mangle)]
pub fn set_gravity(simulation: &mut Simulation, g: &[f64; 3], out: &mut Result<(), SettingsError>) {
    *out = simulation.set_gravity(*g);
}

#[unsafe(no_mangle)]
pub fn flat_state(simulation: &Simulation, state: &mut State, flat: &mut [f64]) -> bool {
    simulation.state().write_flat(flat) && state.read_flat(flat)
}

#[unsafe(no_mangle)]
pub fn batch_step(batch: &mut Batch, loads: &[PreparedLoads], out: &mut Out<usize>) {
    *out = batch.step(loads);
}

#[unsafe(no_mangle)]
pub fn batch_step_under_loads_of_host(batch: &mut Batch, loads: &[LoadSet], out: &mut Out<usize>) {
    *out = batch.step(loads);
}

#[unsafe(no_mangle)]
pub fn batch_state(batch: &mut Batch, index: usize, state: &mut State, out: &mut Option<StepError>) -> bool {
    *out = batch.error(index);
    batch.copy_state(index, state) && batch.restore(index, state).is_ok()
}

#[unsafe(no_mangle)]
pub fn derivatives(
    simulation: &Simulation,
    loads: &PreparedLoads,
    work: &mut Workspace,
    rate: &mut StateRate,
    out: &mut Out<()>,
) {
    *out = simulation.model().derivatives(simulation.state(), loads, work, rate);
}

#[unsafe(no_mangle)]
pub fn outputs(simulation: &mut Simulation, loads: &PreparedLoads, index: usize, out: &mut Outputs) -> bool {
    let known = simulation.solve_accelerations(loads).is_ok();
    *out = (
        simulation.rigid_output(),
        simulation.ledger(),
        simulation.point_output(index),
        simulation.point_motion(index),
        simulation.sensor_reading(index),
        simulation.error_estimate(),
    );
    known
}

/// What must not link, so that the proof is known to be one: an index that nobody checks, and a box.
#[cfg(feature = "fail")]
mod fail {
    #[unsafe(no_mangle)]
    pub fn index(values: &[f64], index: usize) -> f64 {
        values[index]
    }

    #[unsafe(no_mangle)]
    pub fn allocate(value: f64) -> alloc::boxed::Box<f64> {
        alloc::boxed::Box::new(value)
    }
}
