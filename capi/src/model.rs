//! Models: read, looked at, shared.

use std::ffi::{CString, c_char};
use std::sync::Arc;

use rom_runtime::{Integrator, Method, Model};

use crate::pointers::{Place, array, array_mut, shared, text};
use crate::simulation::integrator;
use crate::status::{Failure, guard, rom_status};

/// A reduced model. Never changes; may be used by any number of threads at once.
pub struct rom_model {
    pub(crate) model: Arc<Model>,
    points: Vec<CString>,
    cases: Vec<[CString; 2]>,
    pub(crate) blocks: Vec<CString>,
    pub(crate) sections: Vec<CString>,
    pub(crate) sensors: Vec<CString>,
}

/// How the equations of a model are simplified.
#[repr(C)]
pub enum rom_method {
    /// The reduced model: all couplings.
    ROM_METHOD_ROM = 0,
    /// Oscillators and a rigid body, coupled only by the loads.
    ROM_METHOD_MEAN_AXES = 1,
    /// The rigid body alone.
    ROM_METHOD_RIGID = 2,
}

/// What the author of a load case ran it with.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_load_case {
    /// Set to `sizeof(rom_load_case)` before the call.
    pub struct_size: u64,
    /// End of the run, s.
    pub t_end: f64,
    /// Time step, s.
    pub dt: f64,
    /// Numerical damping of the implicit integrators.
    pub numerical_damping: f64,
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl crate::pointers::Sized1 for rom_load_case {
    const FIRST: usize = 32;
}

/// Where the parts of a state are in its array of numbers. All of a state is in it: a simulation that goes on from a copy
/// gives the same bits. `m` is the number of elastic modes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct rom_state_layout {
    /// Set to `sizeof(rom_state_layout)` before the call.
    pub struct_size: u64,
    /// Length of the array.
    pub size: u64,
    /// Time, s (1).
    pub time: u64,
    /// What rounding has taken from the time, s (1).
    pub time_carry: u64,
    /// Modal amplitudes (m).
    pub q: u64,
    /// Modal rates, 1/s (m).
    pub q_dot: u64,
    /// Rigid part of the velocity of A in A, m/s and rad/s (6). The true velocity, that of rom_rigid, is the sum of it and
    /// of what the modal rates move A by.
    pub beta_star: u64,
    /// Attitude quaternion, scalar first (4).
    pub attitude: u64,
    /// Position of the origin of A in G, m (3).
    pub position: u64,
    /// 1 when the accelerations below belong to the rest, 0 when they do not: set 0 after changing anything by hand, and
    /// the next step solves them anew (1).
    pub accelerations_known: u64,
    /// Modal accelerations and rates of beta_star (m + 6).
    pub u_dot: u64,
    /// What the implicit methods carry from step to step (m + 6; with consistent inertia 2 m + 27).
    pub algorithmic: u64,
}

// SAFETY: repr(C), 8-byte fields only, numbers.
unsafe impl crate::pointers::Sized1 for rom_state_layout {
    const FIRST: usize = 96;
}

impl rom_model {
    fn new(model: Model) -> Self {
        // Names with a NUL cannot be had from C; nothing else about them matters here.
        let text = |text: &str| CString::new(text.replace('\0', " ")).unwrap_or_default();
        let data = model.data();
        rom_model {
            points: data.points.iter().map(|point| text(&point.name)).collect(),
            cases: data.load_cases.iter().map(|case| [text(&case.name), text(&case.description)]).collect(),
            blocks: data.stations.iter().map(|block| text(&block.name)).collect(),
            sections: data.cuts.iter().map(|cut| text(&cut.name)).collect(),
            sensors: data.sensors.iter().map(|sensor| text(&sensor.name)).collect(),
            model: Arc::new(model),
        }
    }

    fn handle(model: Model) -> *mut rom_model {
        Box::into_raw(Box::new(rom_model::new(model)))
    }
}

/// Reads a model file. `path` is UTF-8. Free the model with rom_model_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_read(path: *const c_char, model: *mut *mut rom_model) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (path, place) = unsafe { (text(path, "path")?, Place::new(model, "model")?) };
        place.set(rom_model::handle(Model::read_path(path)?));
        Ok(())
    })
}

/// A model from the bytes of its file, which may be given back afterwards. Free the model with rom_model_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_from_bytes(
    bytes: *const u8,
    length: usize,
    model: *mut *mut rom_model,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (bytes, place) = unsafe { (array(bytes, length, "bytes")?, Place::new(model, "model")?) };
        place.set(rom_model::handle(Model::from_bytes(bytes)?));
        Ok(())
    })
}

/// The same body by a simpler method (rom_method), as a model of its own. A simplified model cannot be turned back.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_with_method(
    model: *const rom_model,
    method: u32,
    simpler: *mut *mut rom_model,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, place) = unsafe { (shared(model, "model")?, Place::new(simpler, "simpler")?) };
        let Some(&method) = [Method::Rom, Method::MeanAxes, Method::Rigid].get(method as usize) else {
            return Err(Failure::argument(format_args!("method is {method}, expected a rom_method")));
        };
        place.set(rom_model::handle(model.model.with_method(method)?));
        Ok(())
    })
}

/// Frees a model. What was made from it stays valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_free(model: *mut rom_model) {
    guard(|| {
        if !model.is_null() {
            // SAFETY: made by Box::into_raw, and the caller has no other use for it.
            drop(unsafe { Box::from_raw(model) });
        }
        Ok(())
    });
}

pub(crate) fn count(model: *const rom_model, count: impl FnOnce(&rom_model) -> usize) -> usize {
    // SAFETY: the pointer is the caller's, as the header asks for.
    unsafe { model.as_ref() }.map_or(0, count)
}

pub(crate) fn name(text: Option<&CString>) -> *const c_char {
    text.map_or(std::ptr::null(), |text| text.as_ptr())
}

/// Number of elastic modes m. The model has m + 6 degrees of freedom. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_n_modes(model: *const rom_model) -> usize {
    count(model, |model| model.model.n_modes())
}

/// Number of named points. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_n_points(model: *const rom_model) -> usize {
    count(model, |model| model.points.len())
}

/// Number of load cases. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_n_load_cases(model: *const rom_model) -> usize {
    count(model, |model| model.cases.len())
}

/// Name of a point, NULL where there is none. Valid as long as the model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_point_name(model: *const rom_model, point: usize) -> *const c_char {
    // SAFETY: the pointer is the caller's, as the header asks for.
    name(unsafe { model.as_ref() }.and_then(|model| model.points.get(point)))
}

/// Name of a load case, NULL where there is none. Valid as long as the model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_load_case_name(
    model: *const rom_model,
    load_case: usize,
) -> *const c_char {
    // SAFETY: the pointer is the caller's, as the header asks for.
    name(unsafe { model.as_ref() }.and_then(|model| model.cases.get(load_case)).map(|[name, _]| name))
}

/// What a load case is about, NULL where there is none. Valid as long as the model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_load_case_description(
    model: *const rom_model,
    load_case: usize,
) -> *const c_char {
    // SAFETY: the pointer is the caller's, as the header asks for.
    name(unsafe { model.as_ref() }.and_then(|model| model.cases.get(load_case)).map(|[_, about]| about))
}

/// Number of the point of this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_find_point(
    model: *const rom_model,
    name: *const c_char,
    point: *mut usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, name, place) =
            unsafe { (shared(model, "model")?, text(name, "name")?, Place::new(point, "point")?) };
        place.set(model.model.point(name)?);
        Ok(())
    })
}

/// Axes of a member's section at the point of number `point`, as rom_loads_add_in_section takes them: rotation matrix, row by row,
/// section components to node components; `n` has to be 9. `member` may be NULL where all members at the point have the same axes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_section_axes(
    model: *const rom_model,
    point: usize,
    member: *const c_char,
    matrix: *mut f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let model = unsafe { shared(model, "model") }?;
        let member = if member.is_null() {
            None
        } else {
            // SAFETY: as above.
            Some(unsafe { text(member, "member") }?)
        };
        let axes = model.model.section_axes(point, member)?;
        // SAFETY: as above.
        unsafe { copy(axes.as_flattened(), matrix, n, "matrix") }
    })
}

/// Acceleration of free fall in G, m/s^2 (`n` has to be 3), under which the model is marched: zero in weightlessness.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_gravity(
    model: *const rom_model,
    acceleration: *mut f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let model = unsafe { shared(model, "model") }?;
        // SAFETY: as above.
        unsafe { copy(&model.model.gravity(), acceleration, n, "acceleration") }
    })
}

/// Settings of the load case of this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_load_case(
    model: *const rom_model,
    name: *const c_char,
    load_case: *mut rom_load_case,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, name) = unsafe { (shared(model, "model")?, text(name, "name")?) };
        let case = model.model.load_case(name)?;
        let value = rom_load_case {
            struct_size: 0,
            t_end: case.t_end,
            dt: case.dt,
            numerical_damping: case.numerical_damping,
        };
        // SAFETY: as above.
        unsafe { crate::pointers::fill(load_case, &value, "load_case") }
    })
}

/// Circular frequencies of the elastic modes, rad/s: `n` has to be their number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_frequencies(
    model: *const rom_model,
    omega: *mut f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let model = unsafe { shared(model, "model") }?;
        // SAFETY: as above.
        unsafe { copy(&model.model.data().modes.omega, omega, n, "omega") }
    })
}

/// Mass matrix of the rigid body about the origin of A, row by row, v before w: `n` has to be 36.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_mass_matrix(
    model: *const rom_model,
    matrix: *mut f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let model = unsafe { shared(model, "model") }?;
        // SAFETY: as above.
        unsafe { copy(&model.model.data().rigid.mass_matrix, matrix, n, "matrix") }
    })
}

/// Inertia about the origin of A with the modes free to respond, which is what a sudden acceleration meets: row by row, v before
/// w; `n` has to be 36. Refused for mean axes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_apparent_inertia(
    model: *const rom_model,
    matrix: *mut f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let model = unsafe { shared(model, "model") }?;
        // SAFETY: as above.
        unsafe { copy(model.model.apparent_inertia()?.as_flattened(), matrix, n, "matrix") }
    })
}

/// Longest stable time step of an integrator (rom_integrator), s; infinite for those that have no limit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_stable_dt(
    model: *const rom_model,
    integrator: u32,
    dt: *mut f64,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, place) = unsafe { (shared(model, "model")?, Place::new(dt, "dt")?) };
        let integrator: Integrator = self::integrator(integrator)?;
        place.set(integrator.stable_dt(&model.model).map_or(f64::INFINITY, |limit| limit.dt));
        Ok(())
    })
}

/// Layout of the states of a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_state_layout(
    model: *const rom_model,
    layout: *mut rom_state_layout,
) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        let flat = unsafe { shared(model, "model") }?.model.flat_layout();
        let value = rom_state_layout {
            struct_size: 0,
            size: flat.size() as u64,
            time: flat.time as u64,
            time_carry: flat.time_carry as u64,
            q: flat.q.start as u64,
            q_dot: flat.q_dot.start as u64,
            beta_star: flat.beta_star.start as u64,
            attitude: flat.attitude.start as u64,
            position: flat.position.start as u64,
            accelerations_known: flat.accelerations_known as u64,
            u_dot: flat.u_dot.start as u64,
            algorithmic: flat.algorithmic.start as u64,
        };
        // SAFETY: as above.
        unsafe { crate::pointers::fill(layout, &value, "layout") }
    })
}

/// Copies values into an array of the caller, which has to have as many entries.
///
/// # Safety
/// As for [`array_mut`].
unsafe fn copy(values: &[f64], to: *mut f64, n: usize, name: &str) -> Result<(), Failure> {
    // SAFETY: as promised.
    let to = unsafe { array_mut(to, n, name) }?;
    expect_length(name, n, values.len())?;
    to.copy_from_slice(values);
    Ok(())
}

pub(crate) fn expect_length(what: &str, found: usize, expected: usize) -> Result<(), Failure> {
    if found == expected {
        return Ok(());
    }
    Err(Failure::argument(format_args!("{what} has {found} entries, expected {expected}")))
}
