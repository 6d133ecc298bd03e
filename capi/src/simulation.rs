//! Simulations: stepped, read, saved and restored.

use rom_runtime::{Integrator, PrescribedMotion, Settings, Simulation, State};

use crate::loads::rom_loads;
use crate::model::{expect_length, rom_model};
use crate::pointers::{Place, Sized1, array, array_mut, exclusive, fill, read, shared};
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
    /// Most iterations of an implicit step: bounds its time. Default: 40.
    pub max_iterations: u32,
}

// SAFETY: repr(C), 8-byte fields and a pair of 4-byte ones, numbers.
unsafe impl Sized1 for rom_settings {
    const FIRST: usize = 32;
}

/// Motion of frame A.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_rigid {
    /// Set to `sizeof(rom_rigid)` before the call.
    pub struct_size: u64,
    /// Time, s.
    pub time: f64,
    /// Position of the origin of A in G, m.
    pub r_g: [f64; 3],
    /// Velocity of the origin of A, components in A, m/s.
    pub v_a: [f64; 3],
    /// Angular velocity of A, components in A, rad/s.
    pub w_a: [f64; 3],
    /// Velocity of the origin of A, components in G, m/s.
    pub v_g: [f64; 3],
    /// Angular velocity of A, components in G, rad/s.
    pub w_g: [f64; 3],
    /// Attitude quaternion, scalar first.
    pub zeta: [f64; 4],
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_rigid {
    const FIRST: usize = 168;
}

/// Where a named point is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_point {
    /// Set to `sizeof(rom_point)` before the call.
    pub struct_size: u64,
    /// Displacement from the equilibrium, components in A, m.
    pub dr_a: [f64; 3],
    /// Position in G, m.
    pub r_g: [f64; 3],
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_point {
    const FIRST: usize = 56;
}

/// The quantities whose balance tells whether a result can be trusted.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_ledger {
    /// Set to `sizeof(rom_ledger)` before the call.
    pub struct_size: u64,
    /// Centre of mass in G, m.
    pub r_cm_g: [f64; 3],
    /// Linear momentum in G, kg m/s.
    pub linear_momentum_g: [f64; 3],
    /// Angular momentum in G about the origin of G, kg m^2/s.
    pub angular_momentum_g: [f64; 3],
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Elastic energy of the kept modes, J.
    pub elastic_energy: f64,
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_ledger {
    const FIRST: usize = 96;
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

/// How far a run is estimated to be from the body that its model stands for: relative errors so far, the largest length of
/// the error over the largest of the quantity; and how much of the range of the model is used.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_error_estimate {
    /// Set to `sizeof(rom_error_estimate)` before the call.
    pub struct_size: u64,
    /// Error indicator: the largest of the three errors.
    pub indicator: f64,
    /// Of the velocity of A in G.
    pub v_g: f64,
    /// Of the angular velocity of A in G.
    pub w_g: f64,
    /// Of the displacements of the named points.
    pub dr_a: f64,
    /// Largest amplitude now over the one at which the terms left out reach a tenth of those kept.
    pub amplitude: f64,
    /// Largest angular rate now over the one at which the centrifugal terms left out reach a tenth of the stiffness.
    pub rate: f64,
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_error_estimate {
    const FIRST: usize = 56;
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

/// Estimates errors from now on, looking at the motion every so many steps: 4 costs little, 0 turns it off. Allocates. Setting
/// a state and prescribed motion begin the estimate again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_watch_errors(
    simulation: *mut rom_simulation,
    every: u32,
) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        unsafe { exclusive(simulation, "simulation") }?.simulation.watch_errors(every);
        Ok(())
    })
}

/// Estimated errors of the run so far. ROM_NOT_FOUND unless they are watched.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_error_estimate(
    simulation: *const rom_simulation,
    estimate: *mut rom_error_estimate,
) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        let Some(found) = unsafe { shared(simulation, "simulation") }?.simulation.error_estimate() else {
            let message = "errors are not watched (rom_simulation_watch_errors), or the motion of A is given, which no estimate covers";
            return Err(Failure::new(rom_status::ROM_NOT_FOUND, message));
        };
        let rom_runtime::ErrorEstimate { v_g, w_g, dr_a, amplitude, rate } = found;
        let indicator = found.indicator();
        let value = rom_error_estimate { struct_size: 0, indicator, v_g, w_g, dr_a, amplitude, rate };
        // SAFETY: as above.
        unsafe { fill(estimate, &value, "estimate") }
    })
}

/// Time and motion of frame A.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_rigid(
    simulation: *const rom_simulation,
    rigid: *mut rom_rigid,
) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        let simulation = &unsafe { shared(simulation, "simulation") }?.simulation;
        let out = simulation.rigid_output();
        let value = rom_rigid {
            struct_size: 0,
            time: simulation.state().time,
            r_g: out.r_g,
            v_a: out.v_a,
            w_a: out.w_a,
            v_g: out.v_g,
            w_g: out.w_g,
            zeta: out.zeta,
        };
        // SAFETY: as above.
        unsafe { fill(rigid, &value, "rigid") }
    })
}

/// Where the point of this number is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_point(
    simulation: *const rom_simulation,
    point: usize,
    out: *mut rom_point,
) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        let simulation = &unsafe { shared(simulation, "simulation") }?.simulation;
        let Some(found) = simulation.point_output(point) else {
            let n = simulation.model().n_points();
            let text = format_args!("point is {point}, expected less than {n}");
            return Err(Failure::new(rom_status::ROM_NOT_FOUND, text));
        };
        // SAFETY: as above.
        unsafe { fill(out, &rom_point { struct_size: 0, dr_a: found.dr_a, r_g: found.r_g }, "out") }
    })
}

/// Centre of mass, momenta and energies.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_ledger(
    simulation: *const rom_simulation,
    ledger: *mut rom_ledger,
) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        let found = unsafe { shared(simulation, "simulation") }?.simulation.ledger();
        let value = rom_ledger {
            struct_size: 0,
            r_cm_g: found.r_cm_g,
            linear_momentum_g: found.linear_momentum_g,
            angular_momentum_g: found.angular_momentum_g,
            kinetic_energy: found.kinetic_energy,
            elastic_energy: found.elastic_energy,
        };
        // SAFETY: as above.
        unsafe { fill(ledger, &value, "ledger") }
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
