//! What is read from a simulation: motion of frame A, points, sensors, momenta and energies, estimated errors.

use std::ffi::c_char;

use crate::loads::rom_loads;
use crate::model::{count, name, rom_model};
use crate::pointers::{Place, Sized1, exclusive, fill, shared, text};
use crate::simulation::rom_simulation;
use crate::status::{Failure, guard, rom_status};

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
    /// Potential energy in the field of gravity, zero with the centre of mass at the origin of G, J.
    pub gravity_energy: f64,
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_ledger {
    const FIRST: usize = 96;
}

/// How a named point moves, seen from G.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_point_motion {
    /// Set to `sizeof(rom_point_motion)` before the call.
    pub struct_size: u64,
    /// Attitude quaternion of the point's node, whose axes are those of the drawing at rest, scalar first, node to G.
    pub zeta: [f64; 4],
    /// Velocity, components in G, m/s.
    pub v_g: [f64; 3],
    /// Angular velocity of the node, components in G, rad/s.
    pub w_g: [f64; 3],
    /// Acceleration, components in G, m/s^2.
    pub a_g: [f64; 3],
    /// Angular acceleration of the node, components in G, rad/s^2.
    pub alpha_g: [f64; 3],
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_point_motion {
    const FIRST: usize = 136;
}

/// What an inertial sensor reads, in its own axes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_sensor_reading {
    /// Set to `sizeof(rom_sensor_reading)` before the call.
    pub struct_size: u64,
    /// Acceleration, less that of free fall where the sensor feels gravity, m/s^2.
    pub a: [f64; 3],
    /// Angular velocity, rad/s.
    pub w: [f64; 3],
    /// Angular acceleration, rad/s^2.
    pub alpha: [f64; 3],
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl Sized1 for rom_sensor_reading {
    const FIRST: usize = 80;
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
        let found = simulation.point_output(point);
        let found = found.ok_or_else(|| absent("point", point, simulation.model().n_points()))?;
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
            gravity_energy: found.gravity_energy,
        };
        // SAFETY: as above.
        unsafe { fill(ledger, &value, "ledger") }
    })
}

/// How the point of this number moves: attitude, velocities, accelerations. Accelerations are those at the end of the last step; where
/// the state has none (at the start, after RK4, where a state was set) they are solved under `loads`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_point_motion(
    simulation: *mut rom_simulation,
    loads: *const rom_loads,
    point: usize,
    out: *mut rom_point_motion,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, loads) = unsafe { (exclusive(simulation, "simulation")?, shared(loads, "loads")?) };
        let simulation = &mut this.simulation;
        simulation.solve_accelerations(&loads.set)?;
        let found = simulation.point_motion(point);
        let found = found.ok_or_else(|| absent("point", point, simulation.model().n_points()))?;
        let rom_runtime::PointMotion { attitude: zeta, v_g, w_g, a_g, alpha_g } = found;
        // SAFETY: as above.
        unsafe { fill(out, &rom_point_motion { struct_size: 0, zeta, v_g, w_g, a_g, alpha_g }, "out") }
    })
}

/// Number of inertial sensors. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_n_sensors(model: *const rom_model) -> usize {
    count(model, |model| model.sensors.len())
}

/// Name of a sensor, NULL where there is none. Valid as long as the model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_sensor_name(model: *const rom_model, sensor: usize) -> *const c_char {
    // SAFETY: the pointer is the caller's, as the header asks for.
    name(unsafe { model.as_ref() }.and_then(|model| model.sensors.get(sensor)))
}

/// Number of the sensor of this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_find_sensor(
    model: *const rom_model,
    name: *const c_char,
    sensor: *mut usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, name, place) =
            unsafe { (shared(model, "model")?, text(name, "name")?, Place::new(sensor, "sensor")?) };
        place.set(model.model.sensor(name)?);
        Ok(())
    })
}

/// What the sensor of this number reads. Accelerations as for rom_simulation_point_motion.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_sensor(
    simulation: *mut rom_simulation,
    loads: *const rom_loads,
    sensor: usize,
    out: *mut rom_sensor_reading,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, loads) = unsafe { (exclusive(simulation, "simulation")?, shared(loads, "loads")?) };
        let simulation = &mut this.simulation;
        simulation.solve_accelerations(&loads.set)?;
        let found = simulation.sensor_reading(sensor);
        let found = found.ok_or_else(|| absent("sensor", sensor, simulation.model().data().sensors.len()))?;
        let rom_runtime::SensorReading { a, w, alpha } = found;
        // SAFETY: as above.
        unsafe { fill(out, &rom_sensor_reading { struct_size: 0, a, w, alpha }, "out") }
    })
}

/// Estimates errors from now on, looking at the motion every so many steps (`romrun`: 12), 0 turns it off. Allocates. Setting
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
        let rom_runtime::ErrorEstimate { v_g, w_g, dr_a, amplitude, rate, unseen_loads: _ } = found;
        let indicator = found.indicator();
        let value = rom_error_estimate { struct_size: 0, indicator, v_g, w_g, dr_a, amplitude, rate };
        // SAFETY: as above.
        unsafe { fill(estimate, &value, "estimate") }
    })
}

fn absent(what: &str, found: usize, n: usize) -> Failure {
    let status = rom_status::ROM_NOT_FOUND;
    match n {
        0 => Failure::new(status, format_args!("{what} is {found}, but the model has none")),
        _ => Failure::new(status, format_args!("{what} is {found}, expected less than {n}")),
    }
}
