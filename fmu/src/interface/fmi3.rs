//! FMI 3.0 for co-simulation.

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::path::PathBuf;

use super::both::unsupported;
use super::component::{
    Component, Logger, Logger3, Sink, Status, array, directional, guard, instantiate, put, put_one, text,
};
use crate::instance::Instance;

/// The Boolean of the standard: a byte, of which a careless host may leave more than the lowest bit set.
type Boolean = u8;
type IntermediateUpdate =
    unsafe extern "C" fn(*mut c_void, f64, Boolean, Boolean, Boolean, Boolean, *mut Boolean, *mut f64);

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // the standard's
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instance_name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: Boolean,
    _logging_on: Boolean,
    event_mode_used: Boolean,
    _early_return_allowed: Boolean,
    _intermediate: *const c_uint,
    n_intermediate: usize,
    environment: *mut c_void,
    log: Option<Logger3>,
    _intermediate_update: Option<IntermediateUpdate>,
) -> *mut Component {
    // SAFETY: null or a text of the host.
    let logger = unsafe { logger(instance_name, environment, log) };
    // SAFETY: null or a text of the host.
    let token = || unsafe { text(token, "instantiation token") }.map(str::to_owned);
    instantiate(logger, token, || {
        if event_mode_used != 0 || n_intermediate > 0 {
            return Err("this FMU has neither an event mode nor intermediate variables".to_owned());
        }
        // SAFETY: null or a text of the host.
        Ok(PathBuf::from(unsafe { text(resources, "path of the resources") }?))
    })
}

/// # Safety
/// `name` is null or a text of the host.
unsafe fn logger(name: *const c_char, environment: *mut c_void, log: Option<Logger3>) -> Logger {
    // SAFETY: as promised.
    let name = if name.is_null() { c"" } else { unsafe { CStr::from_ptr(name) } };
    Logger { sink: Sink::Fmi3(log), environment, name: CString::from(name) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: Boolean,
    _logging_on: Boolean,
    environment: *mut c_void,
    log: Option<Logger3>,
) -> *mut Component {
    // SAFETY: null or a text of the host.
    unsafe { only_co_simulation(logger(name, environment, log)) }
}

#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // the standard's
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: Boolean,
    _logging_on: Boolean,
    environment: *mut c_void,
    log: Option<Logger3>,
    _clock_update: Option<unsafe extern "C" fn(*mut c_void)>,
    _lock: Option<unsafe extern "C" fn()>,
    _unlock: Option<unsafe extern "C" fn()>,
) -> *mut Component {
    // SAFETY: null or a text of the host.
    unsafe { only_co_simulation(logger(name, environment, log)) }
}

fn only_co_simulation(logger: Logger) -> *mut Component {
    instantiate(logger, || Ok(String::new()), || Err("this FMU is for co-simulation only".to_owned()))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    component: *mut Component,
    _on: Boolean,
    _n: usize,
    _categories: *const *const c_char,
) -> Status {
    // SAFETY: the host's promise.
    unsafe { guard(component, |_| Ok(())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    component: *mut Component,
    _tolerance_defined: Boolean,
    _tolerance: f64,
    start_time: f64,
    _stop_time_defined: Boolean,
    _stop_time: f64,
) -> Status {
    // SAFETY: the host's promise.
    unsafe { guard(component, |this| Ok(this.instance.enter_initialization(start_time)?)) }
}

/// Getters and setters: name, type of the values, and what they call.
macro_rules! variables {
    ($($get:ident $set:ident $type:ty: $read:ident $into:expr, $write:ident $from:expr;)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            component: *mut Component,
            references: *const c_uint,
            n: usize,
            values: *mut $type,
            n_values: usize,
        ) -> Status {
            let work = |this: &mut Component| {
                // SAFETY: the host's promise.
                let mut elements = Elements::of(unsafe { array(references, n) }?);
                elements.check_length(&this.instance, n_values)?;
                let mut value = |_| {
                    let element = elements.next(&this.instance)?;
                    Ok($into(this.instance.$read(element)?))
                };
                // SAFETY: the host's promise.
                unsafe { put(values, n_values, &mut value) }
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
            n_values: usize,
        ) -> Status {
            let work = |this: &mut Component| {
                // SAFETY: the host's promise.
                let (references, values) = unsafe { (array(references, n)?, array(values, n_values)?) };
                let mut elements = Elements::of(references);
                elements.check_length(&this.instance, n_values)?;
                values.iter().try_for_each(|value| {
                    let element = elements.next(&this.instance)?;
                    Ok(this.instance.$write(element, $from(*value))?)
                })
            };
            // SAFETY: the host's promise.
            unsafe { guard(component, work) }
        }
    )*};
}

variables! {
    fmi3GetFloat64 fmi3SetFloat64 f64: real |x| x, set_real |x| x;
    fmi3GetInt64 fmi3SetInt64 i64: choice |x| x, set_choice |x| x;
    fmi3GetBoolean fmi3SetBoolean Boolean: truth |x: bool| u8::from(x), set_truth |x| x != 0;
}

/// The elements of variables, scalars and arrays, one after the other.
#[derive(Clone)]
struct Elements<'a> {
    variables: std::slice::Iter<'a, c_uint>,
    left: std::ops::Range<c_uint>,
}

impl<'a> Elements<'a> {
    fn of(references: &'a [c_uint]) -> Self {
        Elements { variables: references.iter(), left: 0..0 }
    }

    /// Reference of the next one.
    fn next(&mut self, instance: &Instance) -> Result<c_uint, String> {
        loop {
            if let Some(element) = self.left.next() {
                return Ok(element);
            }
            let first = *self.variables.next().ok_or("there are fewer variables than values")?;
            self.left = first..first + instance.size(first)? as c_uint;
        }
    }

    /// Whether as many values have been given, or are asked for, as there are elements.
    fn check_length(&self, instance: &Instance, values: usize) -> Result<(), String> {
        let mut elements = 0;
        for reference in self.variables.clone() {
            elements += instance.size(*reference)?;
        }
        if elements == values {
            return Ok(());
        }
        let n = self.variables.len();
        Err(format!("there are {values} values for {n} variables with {elements} elements"))
    }

    /// All that are left, of as many values.
    fn all(mut self, instance: &Instance, values: usize) -> Result<Vec<c_uint>, String> {
        self.check_length(instance, values)?;
        (0..values).map(|_| self.next(instance)).collect()
    }
}

#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // the standard's
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    component: *mut Component,
    unknowns: *const c_uint,
    n_unknowns: usize,
    knowns: *const c_uint,
    n_knowns: usize,
    seeds: *const f64,
    n_seeds: usize,
    sensitivities: *mut f64,
    n_sensitivities: usize,
) -> Status {
    let work = |this: &mut Component| {
        // SAFETY: the host's promise.
        let (of, by) = unsafe { (array(unknowns, n_unknowns)?, array(knowns, n_knowns)?) };
        let of = Elements::of(of).all(&this.instance, n_sensitivities)?;
        let by = Elements::of(by).all(&this.instance, n_seeds)?;
        // SAFETY: the host's promise.
        unsafe { directional(this, &of, &by, seeds, sensitivities) }
    };
    // SAFETY: the host's promise.
    unsafe { guard(component, work) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    component: *mut Component,
    from: f64,
    size: f64,
    _no_set_state_prior: Boolean,
    event_handling_needed: *mut Boolean,
    terminate: *mut Boolean,
    early_return: *mut Boolean,
    last_successful_time: *mut f64,
) -> Status {
    let work = |this: &mut Component| {
        let outcome = this.instance.step(from, size);
        // SAFETY: the host's promise.
        unsafe {
            put_one(event_handling_needed, 0)?;
            put_one(terminate, 0)?;
            put_one(early_return, 0)?;
            put_one(last_successful_time, this.instance.time())?;
        }
        Ok(outcome?)
    };
    // SAFETY: the host's promise.
    unsafe { guard(component, work) }
}

unsupported! { "this FMU has no variables of this type":
    fmi3GetFloat32(*const c_uint, usize, *mut f32, usize)
    fmi3GetInt8(*const c_uint, usize, *mut i8, usize)
    fmi3GetUInt8(*const c_uint, usize, *mut u8, usize)
    fmi3GetInt16(*const c_uint, usize, *mut i16, usize)
    fmi3GetUInt16(*const c_uint, usize, *mut u16, usize)
    fmi3GetInt32(*const c_uint, usize, *mut i32, usize)
    fmi3GetUInt32(*const c_uint, usize, *mut u32, usize)
    fmi3GetUInt64(*const c_uint, usize, *mut u64, usize)
    fmi3GetString(*const c_uint, usize, *mut *const c_char, usize)
    fmi3GetBinary(*const c_uint, usize, *mut usize, *mut *const u8, usize)
    fmi3GetClock(*const c_uint, usize, *mut Boolean)
    fmi3SetFloat32(*const c_uint, usize, *const f32, usize)
    fmi3SetInt8(*const c_uint, usize, *const i8, usize)
    fmi3SetUInt8(*const c_uint, usize, *const u8, usize)
    fmi3SetInt16(*const c_uint, usize, *const i16, usize)
    fmi3SetUInt16(*const c_uint, usize, *const u16, usize)
    fmi3SetInt32(*const c_uint, usize, *const i32, usize)
    fmi3SetUInt32(*const c_uint, usize, *const u32, usize)
    fmi3SetUInt64(*const c_uint, usize, *const u64, usize)
    fmi3SetString(*const c_uint, usize, *const *const c_char, usize)
    fmi3SetBinary(*const c_uint, usize, *const usize, *const *const u8, usize)
    fmi3SetClock(*const c_uint, usize, *const Boolean)
}

unsupported! { "not supported, as the description says":
    fmi3EnterEventMode()
    fmi3EnterConfigurationMode()
    fmi3ExitConfigurationMode()
    fmi3EnterStepMode()
    fmi3EnterContinuousTimeMode()
    fmi3GetNumberOfVariableDependencies(c_uint, *mut usize)
    fmi3GetVariableDependencies(c_uint, *mut usize, *mut c_uint, *mut usize, *mut c_int, usize)
    fmi3GetAdjointDerivative(*const c_uint, usize, *const c_uint, usize, *const f64, usize, *mut f64, usize)
    fmi3GetIntervalDecimal(*const c_uint, usize, *mut f64, *mut c_int)
    fmi3GetIntervalFraction(*const c_uint, usize, *mut u64, *mut u64, *mut c_int)
    fmi3GetShiftDecimal(*const c_uint, usize, *mut f64)
    fmi3GetShiftFraction(*const c_uint, usize, *mut u64, *mut u64)
    fmi3SetIntervalDecimal(*const c_uint, usize, *const f64)
    fmi3SetIntervalFraction(*const c_uint, usize, *const u64, *const u64)
    fmi3SetShiftDecimal(*const c_uint, usize, *const f64)
    fmi3SetShiftFraction(*const c_uint, usize, *const u64, *const u64)
    fmi3EvaluateDiscreteStates()
    fmi3UpdateDiscreteStates(*mut Boolean, *mut Boolean, *mut Boolean, *mut Boolean, *mut Boolean, *mut f64)
    fmi3CompletedIntegratorStep(Boolean, *mut Boolean, *mut Boolean)
    fmi3SetTime(f64)
    fmi3SetContinuousStates(*const f64, usize)
    fmi3GetContinuousStateDerivatives(*mut f64, usize)
    fmi3GetEventIndicators(*mut f64, usize)
    fmi3GetContinuousStates(*mut f64, usize)
    fmi3GetNominalsOfContinuousStates(*mut f64, usize)
    fmi3GetNumberOfEventIndicators(*mut usize)
    fmi3GetNumberOfContinuousStates(*mut usize)
    fmi3GetOutputDerivatives(*const c_uint, usize, *const c_int, *mut f64, usize)
    fmi3ActivateModelPartition(c_uint, f64)
}
