//! Which library this is.

use std::ffi::{CStr, c_char};

use rom_runtime::format::{VERSION_MAJOR, VERSION_MINOR};

/// Version of the library, "major.minor.patch". Below 1.0 programs have to be built again for another minor version.
/// Constant.
#[unsafe(no_mangle)]
pub extern "C" fn rom_version() -> *const c_char {
    const TEXT: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(text) => text,
        Err(_) => c"",
    };
    TEXT.as_ptr()
}

/// Newest version of the model file that this library reads: `1000 major + minor`. It reads all older ones of the same
/// major version.
#[unsafe(no_mangle)]
pub extern "C" fn rom_format_version() -> u32 {
    1000 * u32::from(VERSION_MAJOR) + u32::from(VERSION_MINOR)
}
