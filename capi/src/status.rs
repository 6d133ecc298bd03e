//! Status codes, the text of the last error, and the boundary no panic crosses.

use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::fmt::{self, Display, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

use rom_runtime::{FormatError, ModelError, SettingsError, StepError};

/// What became of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum rom_status {
    /// Done.
    ROM_OK = 0,
    /// An argument is null, of the wrong size, out of range or not finite.
    ROM_BAD_ARGUMENT = 1,
    /// There is no point, load case or slot of that name or number.
    ROM_NOT_FOUND = 2,
    /// The model file cannot be read, is damaged, is of another version, or holds no model that makes sense.
    ROM_BAD_MODEL = 3,
    /// Settings, loads or a state that do not fit the model.
    ROM_BAD_SETTINGS = 4,
    /// A step did not converge; the state is the one before it.
    ROM_NOT_CONVERGED = 5,
    /// A step diverged; the state is the one before it.
    ROM_DIVERGED = 6,
    /// A defect of the library. The handles of the call may only be freed.
    ROM_INTERNAL = 7,
}

/// Why a call fails. The words for [`rom_last_error`] are in their place already.
pub(crate) struct Failure(rom_status);

/// Error texts have a fixed place, so that failing does not allocate. Longer ones are cut.
const LENGTH: usize = 2048;

/// A NUL-terminated text.
struct Text {
    bytes: [u8; LENGTH],
    length: usize,
}

impl Text {
    const fn new() -> Self {
        Text { bytes: [0; LENGTH], length: 0 }
    }
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            let mut utf8 = [0; 4];
            let utf8 = character.encode_utf8(&mut utf8).as_bytes();
            // One byte stays zero; a zero inside would end the text for C.
            let Some(place) = self.bytes[..LENGTH - 1].get_mut(self.length..self.length + utf8.len()) else {
                return Err(fmt::Error);
            };
            place.copy_from_slice(if character == '\0' { b" " } else { utf8 });
            self.length += utf8.len();
        }
        Ok(())
    }
}

thread_local! {
    static LAST: RefCell<Text> = const { RefCell::new(Text::new()) };
}

impl Failure {
    pub(crate) fn new(status: rom_status, text: impl Display) -> Self {
        // Without a place only while the thread ends; writing fails only where the text is cut.
        let _ = LAST.try_with(|last| {
            if let Ok(mut last) = last.try_borrow_mut() {
                *last = Text::new();
                let _ = write!(last, "{text}");
            }
        });
        Failure(status)
    }

    pub(crate) fn argument(text: impl Display) -> Self {
        Self::new(rom_status::ROM_BAD_ARGUMENT, text)
    }
}

impl From<FormatError> for Failure {
    fn from(error: FormatError) -> Self {
        Self::new(rom_status::ROM_BAD_MODEL, error)
    }
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        let status = match error {
            ModelError::Unknown { .. } | ModelError::Index { .. } => rom_status::ROM_NOT_FOUND,
            _ => rom_status::ROM_BAD_SETTINGS,
        };
        Self::new(status, error)
    }
}

impl From<SettingsError> for Failure {
    fn from(error: SettingsError) -> Self {
        Self::new(rom_status::ROM_BAD_SETTINGS, error)
    }
}

impl From<StepError> for Failure {
    fn from(error: StepError) -> Self {
        let status = match error {
            StepError::NotConverged { .. } => rom_status::ROM_NOT_CONVERGED,
            StepError::Diverged { .. } => rom_status::ROM_DIVERGED,
            _ => rom_status::ROM_BAD_SETTINGS,
        };
        Self::new(status, error)
    }
}

/// Does `work` and tells the caller how it went. Panics stop here.
pub(crate) fn guard(work: impl FnOnce() -> Result<(), Failure>) -> rom_status {
    // What a panic leaves half done is inside handles that the header says may then only be freed.
    let outcome = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err(Failure::new(
            rom_status::ROM_INTERNAL,
            "internal error (a defect of the library: please report it)",
        ))
    });
    match outcome {
        Ok(()) => rom_status::ROM_OK,
        Err(Failure(status)) => status,
    }
}

/// What the last function that failed on this thread says about it, in one or more sentences (UTF-8). Empty if none has.
/// Never null. Valid until the next failure on this thread.
#[unsafe(no_mangle)]
pub extern "C" fn rom_last_error() -> *const c_char {
    LAST.try_with(|last| last.as_ptr()).map_or(c"".as_ptr(), |text| {
        // SAFETY: the text lives as long as the thread, and is NUL-terminated: its last byte is never written.
        unsafe { (&raw const (*text).bytes).cast() }
    })
}

/// A status in words. Never null; constant.
#[unsafe(no_mangle)]
pub extern "C" fn rom_status_text(status: i32) -> *const c_char {
    const TEXTS: [&CStr; 8] = [
        c"done",
        c"bad argument",
        c"not found",
        c"bad model file",
        c"bad settings, loads or state",
        c"step did not converge",
        c"step diverged",
        c"internal error",
    ];
    usize::try_from(status).ok().and_then(|at| TEXTS.get(at)).unwrap_or(&c"unknown status").as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last() -> String {
        // SAFETY: never null, NUL-terminated.
        unsafe { CStr::from_ptr(rom_last_error()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn texts_are_kept_by_thread_and_cut_between_characters() {
        assert_eq!(last(), "");
        let long = "\u{3c9}".repeat(LENGTH);
        assert_eq!(guard(|| Err(Failure::argument(&long))), rom_status::ROM_BAD_ARGUMENT);
        assert_eq!(last().chars().count(), (LENGTH - 1) / 2);
        assert_eq!(guard(|| Err(Failure::argument("a\0b"))), rom_status::ROM_BAD_ARGUMENT);
        assert_eq!(guard(|| Ok(())), rom_status::ROM_OK);
        assert_eq!(last(), "a b");
        assert_eq!(std::thread::spawn(last).join().unwrap(), "");
    }

    #[test]
    fn a_panic_becomes_a_status() {
        assert_eq!(guard(|| panic!("not for C")), rom_status::ROM_INTERNAL);
        assert!(last().contains("internal error"));
    }
}
