//! Simulations: stepped, read, saved and restored.

use std::ffi::c_char;

use rom_runtime::{Integrator, PrescribedMotion, Settings, Simulation, State};

use crate::loads::rom_loads;
use crate::model::{expect_length, rom_model};
use crate::pointers::{Place, Sized1, array, array_mut, exclusive, fill, read, shared, text, vector};
use crate::status::{Failure, guard, rom_status};

/// A model in motion.
pub struct rom_simulation {
    pub(crate) simulation: Simulation,
    /// Where states of the host are looked at before they count.
    scratch: State,
}

/// How a simulation is marched.
#[repr(C)]
pub enum rom_integrator {
    /// Newmark: implicit, any step.
    ROM_NEWMARK = 0,
    /// Classical Runge-Kutta: explicit, fourth order, limited step (rom_model_stable_dt), same work every step.
    ROM_RK4 = 1,
    /// Generalised-alpha: implicit, any step, second order with numerical damping.
    ROM_GENERALIZED_ALPHA = 2,
    /// Energy-momentum: implicit, any step, for models with consistent inertia in free flight. Keeps energy and momenta.
    ROM_ENERGY_MOMENTUM = 3,
}

/// Settings of a simulation. rom_settings_init gives the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_settings {
    /// Set to `sizeof(rom_settings)` before any call.
    pub struct_size: u64,
    /// Time step, s. Default: 0.01.
    pub dt: f64,
    /// Numerical damping of the implicit integrators, 0 to 1; zero for RK4. Default: 0.
    pub numerical_damping: f64,
    /// A rom_integrator. Default: ROM_NEWMARK.
    pub integrator: u32,
    /// Most iterations of an implicit step, 1 to 1000: bounds its time. Default: 40.
    pub max_iterations: u32,
}

// SAFETY: repr(C), 8-byte fields and a pair of 4-byte ones, numbers.
unsafe impl Sized1 for rom_settings {
    const FIRST: usize = 32;
}

/// Motion of frame A, prescribed by a host that carries the rigid body itself.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_motion {
    /// Set to `sizeof(rom_motion)` before the call.
    pub struct_size: u64,
    /// Velocity of the origin of A and angular velocity of A, components in A, m/s and rad/s.
    pub velocity: [f64; 6],
    /// Rates of these components, m/s^2 and rad/s^2. The inertial acceleration of the origin is `v_dot + w x v`.
    pub rate: [f64; 6],
    /// Attitude quaternion, scalar first.
    pub attitude: [f64; 4],
    /// Position of the origin of A in G, m.
    pub position: [f64; 3],
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_motion {
    const FIRST: usize = 160;
}

/// What the body does to the host that moves its frame A: wrenches (force in N, moment in N m) on the host about the
/// origin of A, components in A. A host without inertia of the body accelerates by the sum of the three; one that carries
/// mass and inertia of the undeformed body, by loads + increment (the sum, exchanged explicitly, diverges with a host
/// lighter than the body).
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_reaction {
    /// Set to `sizeof(rom_reaction)` before the call.
    pub struct_size: u64,
    /// Inertia of the undeformed body in the prescribed motion.
    pub inertia: [f64; 6],
    /// Resultant of the loads at the deformed points.
    pub loads: [f64; 6],
    /// What elasticity adds.
    pub increment: [f64; 6],
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_reaction {
    const FIRST: usize = 152;
}

/// Settings by default. `struct_size` has to be set before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_settings_init(settings: *mut rom_settings) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        unsafe { fill(settings, &default_settings(), "settings") }
    })
}

fn default_settings() -> rom_settings {
    let Settings { dt, numerical_damping, max_iterations, .. } = Settings::default();
    rom_settings { struct_size: 0, dt, numerical_damping, integrator: 0, max_iterations }
}

pub(crate) fn integrator(number: u32) -> Result<Integrator, Failure> {
    match number {
        0 => Ok(Integrator::Newmark),
        1 => Ok(Integrator::Rk4),
        2 => Ok(Integrator::GeneralizedAlpha),
        3 => Ok(Integrator::EnergyMomentum),
        _ => Err(Failure::argument(format_args!("integrator is {number}, expected a rom_integrator"))),
    }
}

/// A simulation at rest, undeformed, at t = 0. `settings` may be NULL for the defaults. Allocates everything it will ever
/// need. Free it with rom_simulation_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_new(
    model: *const rom_model,
    settings: *const rom_settings,
    simulation: *mut *mut rom_simulation,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, place) = unsafe { (shared(model, "model")?, Place::new(simulation, "simulation")?) };
        let mut given = default_settings();
        if !settings.is_null() {
            // SAFETY: as above.
            given = unsafe { read(settings, given, "settings") }?;
        }
        let settings = Settings {
            dt: given.dt,
            integrator: integrator(given.integrator)?,
            numerical_damping: given.numerical_damping,
            max_iterations: given.max_iterations,
        };
        let simulation = Simulation::new(model.model.clone(), settings)?;
        let scratch = simulation.state().clone();
        place.set(Box::into_raw(Box::new(rom_simulation { simulation, scratch })));
        Ok(())
    })
}

/// Frees a simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_free(simulation: *mut rom_simulation) {
    guard(|| {
        if !simulation.is_null() {
            // SAFETY: made by Box::into_raw, and the caller has no other use for it.
            drop(unsafe { Box::from_raw(simulation) });
        }
        Ok(())
    });
}

/// Sets the state in which the load case of this name starts, at t = 0: where the structure file gives it initial conditions, there; else
/// at rest. Allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_start(
    simulation: *mut rom_simulation,
    load_case: *const c_char,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, name) = unsafe { (exclusive(simulation, "simulation")?, text(load_case, "load_case")?) };
        let model = this.simulation.model();
        let state = model.initial_state(model.load_case(name)?)?;
        Ok(this.simulation.restore(&state)?)
    })
}

/// Sets the acceleration of free fall in G (m/s^2, 3) from the next step on; it begins as rom_model_gravity, and is no part of the state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_set_gravity(
    simulation: *mut rom_simulation,
    acceleration: *const f64,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, acceleration) =
            unsafe { (exclusive(simulation, "simulation")?, vector(acceleration, "acceleration")?) };
        Ok(this.simulation.set_gravity(acceleration)?)
    })
}

/// One time step. If it fails, the state is the one before it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_step(
    simulation: *mut rom_simulation,
    loads: *const rom_loads,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, loads) = unsafe { (exclusive(simulation, "simulation")?, shared(loads, "loads")?) };
        Ok(this.simulation.step(&loads.set)?)
    })
}

/// `n` time steps with the same wrenches. Stops at the first that fails, with the state before that one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_run(
    simulation: *mut rom_simulation,
    loads: *const rom_loads,
    n: u64,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, loads) = unsafe { (exclusive(simulation, "simulation")?, shared(loads, "loads")?) };
        for _ in 0..n {
            this.simulation.step(&loads.set)?;
        }
        Ok(())
    })
}

/// Begins a motion of frame A that the host prescribes: takes over its velocity, attitude and position at the present time.
/// Amplitudes and rates of the modes stay. Not for mean-axes models.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_prescribe(
    simulation: *mut rom_simulation,
    loads: *const rom_loads,
    motion: *const rom_motion,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, loads) = unsafe { (exclusive(simulation, "simulation")?, shared(loads, "loads")?) };
        // SAFETY: as above.
        let motion = unsafe { prescribed(motion) }?;
        Ok(this.simulation.prescribe(&loads.set, &motion)?)
    })
}

/// One time step in which the host moves frame A, to `motion` at the end of the step; only the modes are marched. Call
/// rom_simulation_prescribe before the first. If it fails, the state is the one before it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_step_prescribed(
    simulation: *mut rom_simulation,
    loads: *const rom_loads,
    motion: *const rom_motion,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, loads) = unsafe { (exclusive(simulation, "simulation")?, shared(loads, "loads")?) };
        // SAFETY: as above.
        let motion = unsafe { prescribed(motion) }?;
        Ok(this.simulation.step_prescribed(&loads.set, &motion)?)
    })
}

/// # Safety
/// As [`read`].
unsafe fn prescribed(motion: *const rom_motion) -> Result<PrescribedMotion, Failure> {
    let PrescribedMotion { velocity, rate, attitude, position } = PrescribedMotion::default();
    let default = rom_motion { struct_size: 0, velocity, rate, attitude, position };
    // SAFETY: as promised.
    let rom_motion { velocity, rate, attitude, position, .. } = unsafe { read(motion, default, "motion") }?;
    Ok(PrescribedMotion { velocity, rate, attitude, position })
}

/// What the body does to the host at the end of the last prescribed step. ROM_NOT_FOUND in free flight.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_reaction(
    simulation: *const rom_simulation,
    reaction: *mut rom_reaction,
) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        let Some(found) = unsafe { shared(simulation, "simulation") }?.simulation.reaction() else {
            return Err(Failure::new(rom_status::ROM_NOT_FOUND, "there is no reaction in free flight"));
        };
        let rom_runtime::Reaction { inertia, loads, increment } = found;
        // SAFETY: as above.
        unsafe { fill(reaction, &rom_reaction { struct_size: 0, inertia, loads, increment }, "reaction") }
    })
}

/// Copies the state out: a snapshot. `n` has to be the size of rom_state_layout.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_get_state(
    simulation: *const rom_simulation,
    state: *mut f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, to) = unsafe { (shared(simulation, "simulation")?, array_mut(state, n, "state")?) };
        expect_length("state", n, this.simulation.model().flat_layout().size())?;
        // The length is right.
        let _ = this.simulation.state().write_flat(to);
        Ok(())
    })
}

/// Goes on from a state: a snapshot, for the same bits as before, or initial conditions (then `accelerations_known` has to
/// be 0). A state that makes no sense is refused, and the simulation stays where it is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_set_state(
    simulation: *mut rom_simulation,
    state: *const f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, from) = unsafe { (exclusive(simulation, "simulation")?, array(state, n, "state")?) };
        if !this.scratch.read_flat(from) {
            return expect_length("state", n, this.simulation.model().flat_layout().size());
        }
        Ok(this.simulation.restore(&this.scratch)?)
    })
}
