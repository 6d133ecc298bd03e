//! Internal loads: section forces and moments at the places along the members that the model has.

use std::ffi::c_char;

use crate::loads::rom_loads;
use crate::model::{count, expect_length, name, rom_model};
use crate::pointers::{Place, array_mut, exclusive, shared, text};
use crate::simulation::rom_simulation;
use crate::status::{guard, rom_status};

/// Number of places of internal loads. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_n_sections(model: *const rom_model) -> usize {
    count(model, |model| model.sections.len())
}

/// Name of a place of internal loads, NULL where there is none. Valid as long as the model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_section_name(model: *const rom_model, section: usize) -> *const c_char {
    // SAFETY: the pointer is the caller's, as the header asks for.
    name(unsafe { model.as_ref() }.and_then(|model| model.sections.get(section)))
}

/// Number of the place of internal loads of this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_find_section(
    model: *const rom_model,
    name: *const c_char,
    section: *mut usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, name, place) =
            unsafe { (shared(model, "model")?, text(name, "name")?, Place::new(section, "section")?) };
        place.set(model.model.section(name)?);
        Ok(())
    })
}

/// Force (N) and moment (N m) on the positive face of the section at every place of internal loads, in the axes of the deformed section,
/// at the present state under these loads: `n` has to be 6 times their number. By summation of forces where the model has what that
/// takes, else by the strains of the modes. Where the accelerations of the state are not known they are solved.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_simulation_section_forces(
    simulation: *mut rom_simulation,
    loads: *const rom_loads,
    forces: *mut f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, loads, to) = unsafe {
            (exclusive(simulation, "simulation")?, shared(loads, "loads")?, array_mut(forces, n, "forces")?)
        };
        expect_length("forces", n, 6 * this.simulation.model().section_names().len())?;
        let found = this.simulation.find_section_forces(&loads.set)?;
        for (to, found) in to.chunks_exact_mut(6).zip(found) {
            to.copy_from_slice(&found.best);
        }
        Ok(())
    })
}
