//! FMI 2.0 for co-simulation.

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};

use super::both::unsupported;
use super::component::{
    Component, Failure, Logger, Logger2, Sink, Status, array, directional, guard, instantiate, put, put_one,
    text,
};
use super::location::from_uri;

/// Functions of the host.
#[repr(C)]
pub struct fmi2CallbackFunctions {
    logger: Option<Logger2>,
    allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    component_environment: *mut c_void,
}

const CO_SIMULATION: c_int = 1;
const DO_STEP_STATUS: c_int = 0;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resources: *const c_char,
    functions: *const fmi2CallbackFunctions,
    _visible: c_int,
    _logging_on: c_int,
) -> *mut Component {
    // SAFETY: null or the host's structure.
    let (log, environment) = match unsafe { functions.as_ref() } {
        Some(functions) => (functions.logger, functions.component_environment),
        None => (None, std::ptr::null_mut()),
    };
    // SAFETY: null or a text of the host.
    let name = if instance_name.is_null() { c"" } else { unsafe { CStr::from_ptr(instance_name) } };
    let logger = Logger { sink: Sink::Fmi2(log), environment, name: CString::from(name) };
    // SAFETY: null or a text of the host.
    let token = || unsafe { text(guid, "GUID") }.map(str::to_owned);
    instantiate(logger, token, || {
        if fmu_type != CO_SIMULATION {
            return Err("this FMU is for co-simulation, not for model exchange".to_owned());
        }
        // SAFETY: null or a text of the host.
        from_uri(unsafe { text(resources, "location of the resources") }?)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    component: *mut Component,
    _on: c_int,
    _n: usize,
    _categories: *const *const c_char,
) -> Status {
    // SAFETY: the host's promise.
    unsafe { guard(component, |_| Ok(())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    component: *mut Component,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start_time: f64,
    _stop_time_defined: c_int,
    _stop_time: f64,
) -> Status {
    let work = |this: &mut Component| {
        this.start_time = start_time;
        Ok(())
    };
    // SAFETY: the host's promise.
    unsafe { guard(component, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(component: *mut Component) -> Status {
    // SAFETY: the host's promise.
    unsafe { guard(component, |this| Ok(this.instance.enter_initialization(this.start_time)?)) }
}

/// Getters and setters of scalars: name, type of the values, and what they call.
macro_rules! variables {
    ($($get:ident $set:ident $type:ty: $read:ident $into:expr, $write:ident $from:expr;)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            component: *mut Component,
            references: *const c_uint,
            n: usize,
            values: *mut $type,
        ) -> Status {
            let work = |this: &mut Component| {
                // SAFETY: the host's promise.
                let references = unsafe { array(references, n) }?;
                // SAFETY: the host's promise.
                unsafe { put(values, n, |place| Ok($into(this.instance.$read(references[place])?))) }
            };
            // SAFETY: the host's promise.
            unsafe { guard(component, work) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            component: *mut Component,
            references: *const c_uint,
            n: usize,
            values: *const $type,
        ) -> Status {
            let work = |this: &mut Component| {
                // SAFETY: the host's promise.
                let (references, values) = unsafe { (array(references, n)?, array(values, n)?) };
                let mut pairs = references.iter().zip(values);
                pairs.try_for_each(|(r, value)| Ok(this.instance.$write(*r, $from(*value))?))
            };
            // SAFETY: the host's promise.
            unsafe { guard(component, work) }
        }
    )*};
}

variables! {
    fmi2GetReal fmi2SetReal f64: real |x| x, set_real |x| x;
    fmi2GetInteger fmi2SetInteger c_int: choice |x| x as c_int, set_choice |x: c_int| x.into();
    fmi2GetBoolean fmi2SetBoolean c_int: truth |x: bool| c_int::from(x), set_truth |x| x != 0;
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    component: *mut Component,
    unknowns: *const c_uint,
    n_unknowns: usize,
    knowns: *const c_uint,
    n_knowns: usize,
    seeds: *const f64,
    sensitivities: *mut f64,
) -> Status {
    let work = |this: &mut Component| {
        // SAFETY: the host's promise.
        let (of, by) = unsafe { (array(unknowns, n_unknowns)?, array(knowns, n_knowns)?) };
        // SAFETY: the host's promise.
        unsafe { directional(this, of, by, seeds, sensitivities) }
    };
    // SAFETY: the host's promise.
    unsafe { guard(component, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    component: *mut Component,
    from: f64,
    size: f64,
    _no_set_state_prior: c_int,
) -> Status {
    // SAFETY: the host's promise.
    unsafe { guard(component, |this| Ok(this.instance.step(from, size)?)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(
    component: *mut Component,
    kind: c_int,
    value: *mut f64,
) -> Status {
    let work = |this: &mut Component| match kind {
        // SAFETY: the host's promise.
        LAST_SUCCESSFUL_TIME => unsafe { put_one(value, this.instance.time()) },
        _ => Err(nothing_pending()),
    };
    // SAFETY: the host's promise.
    unsafe { guard(component, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    component: *mut Component,
    kind: c_int,
    value: *mut c_int,
) -> Status {
    let work = |_: &mut Component| match kind {
        // SAFETY: the host's promise.
        TERMINATED => unsafe { put_one(value, 0) },
        _ => Err(nothing_pending()),
    };
    // SAFETY: the host's promise.
    unsafe { guard(component, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(component: *mut Component, kind: c_int, value: *mut c_int) -> Status {
    let work = |_: &mut Component| match kind {
        // SAFETY: the host's promise.
        DO_STEP_STATUS => unsafe { put_one(value, Status::Ok as c_int) },
        _ => Err(nothing_pending()),
    };
    // SAFETY: the host's promise.
    unsafe { guard(component, work) }
}

fn nothing_pending() -> Failure {
    "this status is only for steps that are pending, and here every step is done when its call returns"
        .to_owned()
        .into()
}

unsupported! { "this FMU has no variables of this type":
    fmi2GetString(*const c_uint, usize, *mut *const c_char)
    fmi2SetString(*const c_uint, usize, *const *const c_char)
}

unsupported! { "not supported, as the description says":
    fmi2SetRealInputDerivatives(*const c_uint, usize, *const c_int, *const f64)
    fmi2GetRealOutputDerivatives(*const c_uint, usize, *const c_int, *mut f64)
    fmi2CancelStep()
    fmi2GetIntegerStatus(c_int, *mut c_int)
    fmi2GetStringStatus(c_int, *mut *const c_char)
}
