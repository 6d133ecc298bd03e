//! What acts on a body: a load case of the model, wrenches of the host, or both.

use std::borrow::Cow;
use std::ffi::c_char;

use rom_runtime::{LoadCase, LoadFrame, LoadSet, Model};

use crate::model::rom_model;
use crate::pointers::{Place, array, exclusive, shared, text, vector};
use crate::status::{Failure, guard, rom_status};

/// Loads on the points of a model.
pub struct rom_loads {
    pub(crate) set: LoadSet,
}

/// Axes in which the components of a wrench are given, and stay constant during a step.
#[repr(C)]
pub enum rom_frame {
    /// Inertial frame G: dead loads.
    ROM_FRAME_DEAD = 0,
    /// Body frame A.
    ROM_FRAME_BODY = 1,
    /// Axes that turn with the node of the point, those of A in the drawing: follower loads.
    ROM_FRAME_NODE = 2,
}

/// Loads for a model: those of a load case, and wrenches on the `n` points of numbers `points`, each given once, which are zero until
/// rom_loads_add adds to them. Wrench `slot` acts on `points[slot]`. `load_case` is the name of one, which about a loaded equilibrium
/// brings the loads of the equilibrium along; "" for the loads of the equilibrium alone; NULL for none at all, so that the host gives
/// those of the equilibrium too. Free the loads with rom_loads_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_new(
    model: *const rom_model,
    load_case: *const c_char,
    points: *const usize,
    n: usize,
    loads: *mut *mut rom_loads,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, points, place) =
            unsafe { (shared(model, "model")?, array(points, n, "points")?, Place::new(loads, "loads")?) };
        // SAFETY: as above.
        let case = unsafe { case(&model.model, load_case) }?;
        let set = LoadSet::with_stations(&model.model, points, &[], case.as_deref())?;
        place.set(Box::into_raw(Box::new(rom_loads { set })));
        Ok(())
    })
}

/// The load case that a name stands for.
///
/// # Safety
/// As [`text`].
pub(crate) unsafe fn case(model: &Model, name: *const c_char) -> Result<Option<Cow<'_, LoadCase>>, Failure> {
    if name.is_null() {
        return Ok(None);
    }
    // SAFETY: as promised.
    Ok(Some(match unsafe { text(name, "load_case") }? {
        // No load case has an empty name.
        "" => Cow::Owned(LoadCase::empty("equilibrium")),
        name => Cow::Borrowed(model.load_case(name)?),
    }))
}

/// Frees loads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_free(loads: *mut rom_loads) {
    guard(|| {
        if !loads.is_null() {
            // SAFETY: made by Box::into_raw, and the caller has no other use for it.
            drop(unsafe { Box::from_raw(loads) });
        }
        Ok(())
    });
}

/// Makes all wrenches zero. A load case goes on acting.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_clear(loads: *mut rom_loads) -> rom_status {
    guard(|| {
        // SAFETY: the pointer is the caller's, as the header asks for.
        unsafe { exclusive(loads, "loads") }?.set.clear();
        Ok(())
    })
}

/// Adds a force (N, 3) and a moment (N m, 3) on a slot, components in `frame` (rom_frame). The implicit integrators take
/// wrenches as those at the end of a step, RK4 holds them over the step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_add(
    loads: *mut rom_loads,
    slot: usize,
    frame: u32,
    force: *const f64,
    moment: *const f64,
) -> rom_status {
    guard(|| {
        let frame = load_frame(frame)?;
        // SAFETY: pointers are the caller's, as the header asks for.
        unsafe { add(loads, slot, &frame, force, moment) }
    })
}

/// Adds a follower force (N, 3) and moment (N m, 3) with components in a section frame that turns with the node:
/// `section` is its rotation matrix, row-major (9), section components to node components.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_add_in_section(
    loads: *mut rom_loads,
    slot: usize,
    section: *const f64,
    force: *const f64,
    moment: *const f64,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let section = *unsafe { shared(section.cast::<[[f64; 3]; 3]>(), "section") }?;
        if !is_rotation(&section) {
            return Err(Failure::argument("section is not a rotation matrix (to 1e-6)"));
        }
        // SAFETY: as above.
        unsafe { add(loads, slot, &LoadFrame::Follower { section }, force, moment) }
    })
}

/// # Safety
/// As [`exclusive`] and [`vector`].
unsafe fn add(
    loads: *mut rom_loads,
    slot: usize,
    frame: &LoadFrame,
    force: *const f64,
    moment: *const f64,
) -> Result<(), Failure> {
    // SAFETY: as promised.
    let (loads, force, moment) =
        unsafe { (exclusive(loads, "loads")?, vector(force, "force")?, vector(moment, "moment")?) };
    if loads.set.add(slot, frame, force, moment) {
        return Ok(());
    }
    let n = loads.set.points().len();
    Err(Failure::new(rom_status::ROM_NOT_FOUND, format_args!("slot is {slot}, expected less than {n}")))
}

/// Adds a force (N, 3) on the origin of frame A and a moment (N m, 3), components in `frame` (rom_frame; the axes of A's node are
/// those of A): what acts on the body as a whole.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_add_wrench(
    loads: *mut rom_loads,
    frame: u32,
    force: *const f64,
    moment: *const f64,
) -> rom_status {
    guard(|| {
        let frame = load_frame(frame)?;
        // SAFETY: pointers are the caller's, as the header asks for.
        let (loads, force, moment) =
            unsafe { (exclusive(loads, "loads")?, vector(force, "force")?, vector(moment, "moment")?) };
        loads.set.add_wrench(&frame, force, moment);
        Ok(())
    })
}

/// Adds generalised forces on the elastic modes, N m per unit amplitude (n), one for each of the model's `n` modes: the work of loads
/// in their shapes. What the same loads do to the rigid motion goes by rom_loads_add_wrench.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_add_modal(
    loads: *mut rom_loads,
    forces: *const f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (loads, forces) = unsafe { (exclusive(loads, "loads")?, array(forces, n, "forces")?) };
        if let Some(x) = forces.iter().find(|x| !x.is_finite()) {
            return Err(Failure::argument(format_args!("forces holds {x}, expected finite numbers")));
        }
        if loads.set.add_modal(forces) {
            return Ok(());
        }
        Err(Failure::argument(format_args!("forces has {n} entries, expected one for every elastic mode")))
    })
}

fn load_frame(frame: u32) -> Result<LoadFrame, Failure> {
    match frame {
        0 => Ok(LoadFrame::Dead),
        1 => Ok(LoadFrame::Body),
        2 => Ok(LoadFrame::Follower { section: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }),
        _ => Err(Failure::argument(format_args!("frame is {frame}, expected a rom_frame"))),
    }
}

fn is_rotation(rows: &[[f64; 3]; 3]) -> bool {
    let [a, b, c] = *rows;
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let unit = [(a, a, 1.0), (b, b, 1.0), (a, b, 0.0), (cross, c, 1.0), (c, c, 1.0)];
    unit.iter().all(|&(a, b, expected)| (dot(a, b) - expected).abs() <= 1e-6)
}
