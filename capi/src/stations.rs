//! Blocks of stations, for aerodynamic codes: many places on the members read and loaded in one call each.

use std::ffi::c_char;

use rom_runtime::{DistributedFrame, LoadSet, StationAxes, Stations};

use crate::loads::{case, rom_loads};
use crate::model::{count, expect_length, name, rom_model};
use crate::pointers::{Place, array, array_mut, exclusive, shared, text};
use crate::simulation::rom_simulation;
use crate::status::{Failure, guard, rom_status};

/// A block of stations made ready for reading.
pub struct rom_stations {
    stations: Stations,
}

/// Axes in which the motion of stations is given.
#[repr(C)]
pub enum rom_station_axes {
    /// Everything in G.
    ROM_STATION_INERTIAL = 0,
    /// In A: positions from its origin, attitudes against it; velocities are against G, components in A.
    ROM_STATION_BODY = 1,
    /// Positions and attitudes in A; velocities are against G, components in the axes of every section.
    ROM_STATION_SECTION = 2,
}

/// Number of blocks of stations. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_n_station_blocks(model: *const rom_model) -> usize {
    count(model, |model| model.blocks.len())
}

/// Name of a block of stations, NULL where there is none. Valid as long as the model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_station_block_name(
    model: *const rom_model,
    block: usize,
) -> *const c_char {
    // SAFETY: the pointer is the caller's, as the header asks for.
    name(unsafe { model.as_ref() }.and_then(|model| model.blocks.get(block)))
}

/// Number of the block of stations of this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_find_station_block(
    model: *const rom_model,
    name: *const c_char,
    block: *mut usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, name, place) =
            unsafe { (shared(model, "model")?, text(name, "name")?, Place::new(block, "block")?) };
        place.set(model.model.station_block(name)?);
        Ok(())
    })
}

/// Makes a block of stations of a model ready for reading: everything is allocated here. Free it with rom_stations_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_stations_new(
    model: *const rom_model,
    block: usize,
    stations: *mut *mut rom_stations,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, place) = unsafe { (shared(model, "model")?, Place::new(stations, "stations")?) };
        let stations = Stations::new(&model.model, block)?;
        place.set(Box::into_raw(Box::new(rom_stations { stations })));
        Ok(())
    })
}

/// Frees stations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_stations_free(stations: *mut rom_stations) {
    guard(|| {
        if !stations.is_null() {
            // SAFETY: made by Box::into_raw, and the caller has no other use for it.
            drop(unsafe { Box::from_raw(stations) });
        }
        Ok(())
    });
}

/// Number of stations. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_stations_count(stations: *const rom_stations) -> usize {
    // SAFETY: the pointer is the caller's, as the header asks for.
    unsafe { stations.as_ref() }.map_or(0, |it| it.stations.len())
}

/// Where the stations are and how they move now, in `axes` (rom_station_axes), station after station: positions in m (3 n), attitudes
/// of the section axes as unit quaternions, scalar first (4 n), velocities in m/s (3 n), angular velocities in rad/s (3 n). `n` has to
/// be rom_stations_count; any of the arrays may be NULL. The simulation has to be one of the model of the stations. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_stations_read(
    stations: *mut rom_stations,
    simulation: *const rom_simulation,
    axes: u32,
    n: usize,
    position: *mut f64,
    attitude: *mut f64,
    velocity: *mut f64,
    angular_velocity: *mut f64,
) -> rom_status {
    guard(|| {
        let axes = match axes {
            0 => StationAxes::Inertial,
            1 => StationAxes::Body,
            2 => StationAxes::Section,
            _ => return Err(Failure::argument(format_args!("axes is {axes}, expected a rom_station_axes"))),
        };
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, simulation) =
            unsafe { (exclusive(stations, "stations")?, shared(simulation, "simulation")?) };
        expect_length("the arrays of stations", n, this.stations.len())?;
        let simulation = &simulation.simulation;
        let motion = this.stations.read(simulation.model(), simulation.state(), axes)?;
        let parts = [
            (position, &motion.position, "position"),
            (attitude, &motion.attitude, "attitude"),
            (velocity, &motion.velocity, "velocity"),
            (angular_velocity, &motion.angular_velocity, "angular_velocity"),
        ];
        for (pointer, values, name) in parts.into_iter().filter(|(pointer, ..)| !pointer.is_null()) {
            // SAFETY: as above.
            unsafe { array_mut(pointer, values.len(), name) }?.copy_from_slice(values);
        }
        Ok(())
    })
}

/// As rom_loads_new, with `n_blocks` blocks of stations (numbers `blocks`, each given once) that can be loaded besides the points. What
/// acts on them is zero until rom_loads_set_stations sets it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_new_with_stations(
    model: *const rom_model,
    load_case: *const c_char,
    points: *const usize,
    n: usize,
    blocks: *const usize,
    n_blocks: usize,
    loads: *mut *mut rom_loads,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, points, blocks, place) = unsafe {
            (
                shared(model, "model")?,
                array(points, n, "points")?,
                array(blocks, n_blocks, "blocks")?,
                Place::new(loads, "loads")?,
            )
        };
        // SAFETY: as above.
        let case = unsafe { case(&model.model, load_case) }?;
        let set = LoadSet::with_stations(&model.model, points, blocks, case.as_deref())?;
        place.set(Box::into_raw(Box::new(rom_loads { set })));
        Ok(())
    })
}

/// Replaces what acts on the `slot`-th block given to rom_loads_new_with_stations: force (N) and moment (N m) on every station (6 n),
/// at the stations, components in `frame` (rom_frame; ROM_FRAME_NODE
/// stands for the axes of every section). `n` is the number of stations of the block. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_loads_set_stations(
    loads: *mut rom_loads,
    slot: usize,
    frame: u32,
    wrenches: *const f64,
    n: usize,
) -> rom_status {
    guard(|| {
        let frame = match frame {
            0 => DistributedFrame::Dead,
            1 => DistributedFrame::Body,
            2 => DistributedFrame::Follower,
            _ => return Err(Failure::argument(format_args!("frame is {frame}, expected a rom_frame"))),
        };
        let numbers = n.saturating_mul(6);
        // SAFETY: pointers are the caller's, as the header asks for.
        let (loads, wrenches) =
            unsafe { (exclusive(loads, "loads")?, array(wrenches, numbers, "wrenches")?) };
        let Some(expected) = loads.set.station_counts().nth(slot) else {
            let n = loads.set.station_counts().len();
            let message = format_args!("slot is {slot}, expected less than {n}, the number of blocks given");
            return Err(Failure::new(rom_status::ROM_NOT_FOUND, message));
        };
        expect_length("wrenches of stations", n, expected)?;
        if let Some(x) = wrenches.iter().find(|x| !x.is_finite()) {
            return Err(Failure::argument(format_args!("wrenches holds {x}, expected finite numbers")));
        }
        // There are as many as stations.
        let _ = loads.set.set_stations(slot, frame, wrenches);
        Ok(())
    })
}
