//! An instance with its logger, behind the pointer that the host holds; and the boundary no panic crosses.

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::fs;
use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::instance::{Instance, StepFailure};
use crate::snapshot::Snapshot;
use crate::{MODEL_FILE, STATIONS_FILE};

/// How a call went; the numbers of both standards.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
    Fatal = 4,
}

/// Why a call failed: the status and the words for the logger.
#[derive(Debug)]
pub(super) struct Failure {
    status: Status,
    message: String,
}

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Failure { status: Status::Error, message }
    }
}

impl From<StepFailure> for Failure {
    fn from(failure: StepFailure) -> Self {
        match failure {
            StepFailure::Refused(message) => message.into(),
            StepFailure::Stopped(message) => Failure { status: Status::Discard, message },
        }
    }
}

pub(super) type Logger2 =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);
pub(super) type Logger3 = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// The host's logger.
pub(super) enum Sink {
    Fmi2(Option<Logger2>),
    Fmi3(Option<Logger3>),
}

pub(super) struct Logger {
    pub(super) sink: Sink,
    pub(super) environment: *mut c_void,
    pub(super) name: CString,
}

impl Logger {
    /// Errors are told whether or not debug logging is on; there is nothing else to tell.
    fn tell(&self, status: Status, message: &str) {
        let text = |text: &str| CString::new(text.replace('\0', " ")).unwrap_or_default();
        let category = c"logStatusError".as_ptr();
        match self.sink {
            Sink::Fmi2(Some(log)) => {
                // The message is a format of printf.
                let message = text(&message.replace('%', "%%"));
                let (environment, name) = (self.environment, self.name.as_ptr());
                // SAFETY: the host's function, with the arguments the standard says.
                unsafe { log(environment, name, status as c_int, category, message.as_ptr()) }
            }
            Sink::Fmi3(Some(log)) => {
                let message = text(message);
                // SAFETY: as above.
                unsafe { log(self.environment, status as c_int, category, message.as_ptr()) }
            }
            _ => {}
        }
    }
}

/// What the host's pointer leads to.
pub struct Component {
    pub(super) instance: Instance,
    pub(super) logger: Logger,
    /// Start of the experiment as FMI 2.0 sets it before the initialisation.
    pub(super) start_time: f64,
}

/// Text of the host.
///
/// # Safety
/// A pointer that is not null leads to a NUL-terminated text that nothing changes.
pub(super) unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Result<&'a str, String> {
    if pointer.is_null() {
        return Err(format!("the {what} is missing"));
    }
    // SAFETY: as promised.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| format!("the {what} is not UTF-8"))
}

/// Array of the host.
///
/// # Safety
/// A pointer that is not null leads to `length` values that nothing changes.
pub(super) unsafe fn array<'a, T>(pointer: *const T, length: usize) -> Result<&'a [T], String> {
    if length == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() || length > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(format!("an array of {length} values is missing"));
    }
    // SAFETY: as promised; not null, not longer than any object.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// Puts values into an array of the host, which may be uninitialised.
///
/// # Safety
/// A pointer that is not null leads to memory for `length` values that nothing else uses.
pub(super) unsafe fn put<T>(
    pointer: *mut T,
    length: usize,
    mut value: impl FnMut(usize) -> Result<T, String>,
) -> Result<(), Failure> {
    if length > 0 && pointer.is_null() {
        return Err(format!("an array for {length} values is missing").into());
    }
    for place in 0..length {
        let value = value(place)?;
        // SAFETY: as promised.
        unsafe { pointer.add(place).write(value) };
    }
    Ok(())
}

/// One result of a call.
///
/// # Safety
/// As [`put`].
pub(super) unsafe fn put_one<T>(pointer: *mut T, value: T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err("the place for a result is missing".to_owned().into());
    }
    // SAFETY: as promised.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Makes an instance of the model in a folder; null, and words to the logger, where it cannot be.
pub(super) fn instantiate(
    logger: Logger,
    token: impl FnOnce() -> Result<String, String>,
    resources: impl FnOnce() -> Result<std::path::PathBuf, String>,
) -> *mut Component {
    let make = || {
        let folder = resources()?;
        let instance = read(&folder)?;
        let (found, expected) = (token()?, instance.token().to_string());
        // FMI 2.0 leaves the braces of the GUID to the writer.
        let bare = |text: &str| text.trim_matches(['{', '}']).to_ascii_lowercase();
        if bare(&found) == bare(&expected) {
            Ok(instance)
        } else {
            Err(format!(
                "the model in {} belongs to the token {expected}, the description says {found}",
                folder.display()
            ))
        }
    };
    let made = catch_unwind(AssertUnwindSafe(make)).unwrap_or_else(|_| Err(DEFECT.to_owned()));
    match made {
        Ok(instance) => Box::into_raw(Box::new(Component { instance, logger, start_time: 0.0 })),
        Err(message) => {
            logger.tell(Status::Error, &message);
            std::ptr::null_mut()
        }
    }
}

const DEFECT: &str = "internal error (a defect of the library: please report it)";

fn read(folder: &Path) -> Result<Instance, String> {
    let path = folder.join(MODEL_FILE);
    let named = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let bytes = fs::read(&path).map_err(|e| named(&e))?;
    Instance::new(&bytes, &stations(folder)?).map_err(|e| named(&e))
}

/// Indices of the blocks of stations among the variables.
fn stations(folder: &Path) -> Result<Vec<usize>, String> {
    let path = folder.join(STATIONS_FILE);
    let text = match fs::read_to_string(&path) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        found => found.map_err(|e| format!("{}: {e}", path.display()))?,
    };
    let index = |line: &str| {
        let what =
            || format!("{}: found {line:?}, expected the index of a block of stations", path.display());
        line.parse().map_err(|_| what())
    };
    text.lines().map(index).collect()
}

/// Does the work of a call on an instance and tells the host how it went. Panics stop here.
///
/// # Safety
/// `component` is null or comes from [`instantiate`], has not been freed, and is used by nobody else during the call.
pub(super) unsafe fn guard(
    component: *mut Component,
    work: impl FnOnce(&mut Component) -> Result<(), Failure>,
) -> Status {
    // SAFETY: as promised.
    let Some(component) = (unsafe { component.as_mut() }) else { return Status::Error };
    let outcome = catch_unwind(AssertUnwindSafe(|| work(component)))
        .unwrap_or_else(|_| Err(Failure { status: Status::Fatal, message: DEFECT.to_owned() }));
    match outcome {
        Ok(()) => Status::Ok,
        Err(Failure { status, message }) => {
            component.logger.tell(status, &message);
            status
        }
    }
}

/// # Safety
/// As [`guard`]; the component must not be used afterwards.
pub(super) unsafe fn free(component: *mut Component) {
    if !component.is_null() {
        // SAFETY: as promised.
        let owned = unsafe { Box::from_raw(component) };
        // Nothing of it panics when dropped; if it did, it would not reach the host.
        let _ = catch_unwind(AssertUnwindSafe(|| drop(owned)));
    }
}

/// Copies the state into a new snapshot, or into the one already there.
///
/// # Safety
/// `place` is null or holds null or a snapshot of [`get_state`] that is not freed.
pub(super) unsafe fn get_state(component: &Component, place: *mut *mut Snapshot) -> Result<(), Failure> {
    let snapshot = component.instance.snapshot();
    // SAFETY: as promised.
    let Some(place) = (unsafe { place.as_mut() }) else {
        return Err("the place for the state is missing".to_owned().into());
    };
    // SAFETY: as promised.
    match unsafe { place.as_mut() } {
        Some(old) => *old = snapshot,
        None => *place = Box::into_raw(Box::new(snapshot)),
    }
    Ok(())
}

/// # Safety
/// As [`get_state`].
pub(super) unsafe fn free_state(place: *mut *mut Snapshot) -> Result<(), Failure> {
    // SAFETY: as promised.
    if let Some(place) = unsafe { place.as_mut() }
        && !place.is_null()
    {
        // SAFETY: as promised.
        drop(unsafe { Box::from_raw(*place) });
        *place = std::ptr::null_mut();
    }
    Ok(())
}

/// # Safety
/// `snapshot` is null or a snapshot of [`get_state`] that is not freed.
pub(super) unsafe fn state<'a>(snapshot: *const Snapshot) -> Result<&'a Snapshot, String> {
    // SAFETY: as promised.
    unsafe { snapshot.as_ref() }.ok_or_else(|| "the state is missing".to_owned())
}

/// # Safety
/// `seeds` is null or leads to a number for each of `by`, `sensitivities` to memory for one of each of `of`.
pub(super) unsafe fn directional(
    component: &mut Component,
    of: &[c_uint],
    by: &[c_uint],
    seeds: *const f64,
    sensitivities: *mut f64,
) -> Result<(), Failure> {
    // SAFETY: as promised.
    let found = component.instance.directional_derivative(of, by, unsafe { array(seeds, by.len()) }?)?;
    // SAFETY: as promised.
    unsafe { put(sensitivities, found.len(), |place| Ok(found[place])) }
}
