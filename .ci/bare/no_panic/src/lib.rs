//! What a host calls from step to step, linked without anything that panics or allocates: the panic handler and the allocator call
//! functions that do not exist, so that the library links only if nothing that is kept can reach them.
#![no_std]

#[cfg(feature = "fail")]
extern crate alloc;

use core::alloc::{GlobalAlloc, Layout};

use rom_runtime::{
    Batch, Direction, DistributedFrame, ErrorEstimate, Jacobian, Ledger, LoadFrame, LoadSet, PointMotion,
    PointOutput, PreparedLoads, PrescribedMotion, Reaction, RigidOutput, SectionForces, SensorReading,
    SettingsError, Simulation, State, StateRate, StationAxes, Stations, StepError, Workspace,
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

#[unsafe(no_mangle)]
pub fn jacobian(simulation: &Simulation, loads: &PreparedLoads, out: &mut Jacobian, result: &mut Out<()>) {
    *result = simulation.jacobian(loads, out);
}

#[unsafe(no_mangle)]
pub fn jacobian_where_a_host_moves(
    simulation: &Simulation,
    loads: &LoadSet,
    rate: &[f64; 6],
    out: &mut Jacobian,
    result: &mut Out<()>,
) {
    *result = out.evaluate_prescribed(simulation.state(), loads, rate);
}

#[unsafe(no_mangle)]
pub fn jacobian_columns(
    out: &mut Jacobian,
    loads: &LoadSet,
    component: usize,
    column: &mut [f64],
    results: &mut [Out<[f64; 6]>; 2],
) {
    *results = [out.by_load(loads, column), out.by_rate(component, column)];
}

#[unsafe(no_mangle)]
pub fn jacobian_of_outputs(out: &mut Jacobian, along: Direction<'_>, index: usize, found: &mut Outputs) {
    found.0 = out.rigid_output(along);
    found.2 = out.point_output(along, index);
    found.3 = out.point_motion(along, index);
    found.4 = out.sensor_reading(along, index);
    found.3 = out.station_motion(along, index, index).map(|(motion, _)| motion).or(found.3);
    found.0.r_g = out.station_position(along, index, index).unwrap_or(found.0.r_g);
}

#[unsafe(no_mangle)]
pub fn jacobian_of_sums(out: &mut Jacobian, along: Direction<'_>, found: &mut (Ledger, [f64; 6])) {
    *found = (out.ledger(along), out.frame_rate(along));
}

#[unsafe(no_mangle)]
pub fn jacobian_of_section_forces(
    out: &mut Jacobian,
    along: Direction<'_>,
    loads: &PreparedLoads,
    forces: &mut [SectionForces],
    results: &mut [Out<()>; 2],
) {
    *results = [out.section_forces(along, loads, forces), out.section_forces_of_load(loads, forces)];
}

#[unsafe(no_mangle)]
pub fn stations(
    stations: &mut Stations,
    simulation: &Simulation,
    loads: &mut LoadSet,
    wrenches: &[f64],
    first: &mut [f64; 3],
) -> bool {
    let Ok(motion) = stations.read(simulation.model(), simulation.state(), StationAxes::Section) else {
        return false;
    };
    *first = motion.velocity.first_chunk::<3>().copied().unwrap_or_default();
    loads.set_stations(0, DistributedFrame::Follower, wrenches)
        && loads.add_to_station(0, wrenches.len(), DistributedFrame::Dead, [1.0; 3], [0.0; 3])
}

#[unsafe(no_mangle)]
pub fn section_forces(
    simulation: &mut Simulation,
    loads: &PreparedLoads,
    first: &mut Option<SectionForces>,
) -> bool {
    match simulation.find_section_forces(loads) {
        Ok(found) => {
            *first = found.first().copied();
            true
        }
        Err(_) => false,
    }
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
