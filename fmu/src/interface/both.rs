//! What differs between the standards by its name only.

use super::component::{Component, Status, array, free, free_state, get_state, guard, put, put_one, state};
use crate::snapshot::Snapshot;

/// Functions of FMI 2.0 and of FMI 3.0: both names, what follows the component among the arguments, and what they do.
macro_rules! functions {
    ($($old:ident $new:ident($($argument:ident: $type:ty),*) $work:expr;)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $old(component: *mut Component, $($argument: $type),*) -> Status {
            // SAFETY: the host's promise.
            unsafe { guard(component, $work) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $new(component: *mut Component, $($argument: $type),*) -> Status {
            // SAFETY: the host's promise.
            unsafe { guard(component, $work) }
        }
    )*};
}

functions! {
    fmi2ExitInitializationMode fmi3ExitInitializationMode() |this| Ok(this.instance.exit_initialization()?);

    fmi2Terminate fmi3Terminate() |this| Ok(this.instance.terminate()?);

    fmi2Reset fmi3Reset() |this| {
        this.instance.reset();
        this.start_time = 0.0;
        Ok(())
    };

    fmi2GetFMUstate fmi3GetFMUState(place: *mut *mut Snapshot) |this| get_state(this, place);

    fmi2SetFMUstate fmi3SetFMUState(snapshot: *mut Snapshot) |this| Ok(this.instance.restore(state(snapshot)?)?);

    fmi2FreeFMUstate fmi3FreeFMUState(place: *mut *mut Snapshot) |_| free_state(place);

    fmi2SerializedFMUstateSize fmi3SerializedFMUStateSize(snapshot: *mut Snapshot, size: *mut usize) |this| {
        put_one(size, state(snapshot)?.to_bytes(this.instance.token()).len())
    };

    fmi2SerializeFMUstate fmi3SerializeFMUState(snapshot: *mut Snapshot, bytes: *mut u8, size: usize) |this| {
        let found = state(snapshot)?.to_bytes(this.instance.token());
        if size < found.len() {
            return Err(format!("the place for the state has {size} bytes, expected {}", found.len()).into());
        }
        put(bytes, found.len(), |place| Ok(found[place]))
    };

    fmi2DeSerializeFMUstate fmi3DeserializeFMUState(bytes: *const u8, size: usize, place: *mut *mut Snapshot) |this| {
        let snapshot = Snapshot::from_bytes(array(bytes, size)?, this.instance.token())?;
        put_one(place, Box::into_raw(Box::new(snapshot)))
    };
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: *mut Component) {
    // SAFETY: the host's promise.
    unsafe { free(component) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(component: *mut Component) {
    // SAFETY: the host's promise.
    unsafe { free(component) }
}

/// Functions of what the description says this FMU does not do.
macro_rules! unsupported {
    ($what:literal: $($name:ident($($argument:ty),*))*) => {$(
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments)] // the standard's
        pub unsafe extern "C" fn $name(component: *mut Component, $(_: $argument),*) -> Status {
            // SAFETY: the host's promise.
            unsafe { guard(component, |_| Err(concat!(stringify!($name), ": ", $what).to_owned().into())) }
        }
    )*};
}

pub(super) use unsupported;
