//! The caller's pointers, checked as far as they can be: null and sizes. What cannot be checked is what the header asks for:
//! a pointer that is not null points to as much as its type or length says, and handles come from this library.

use std::ffi::{CStr, c_char};
use std::ptr::NonNull;

use crate::status::Failure;

fn null(name: &str) -> Failure {
    Failure::argument(format_args!("{name} is null, expected a pointer"))
}

/// A handle or an input structure.
///
/// # Safety
/// If not null, `pointer` points to a `T` that nothing changes while `'a` lasts.
pub(crate) unsafe fn shared<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Failure> {
    // SAFETY: as promised.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(name))
}

/// A handle that the call changes.
///
/// # Safety
/// If not null, `pointer` points to a `T` that nothing else uses while `'a` lasts.
pub(crate) unsafe fn exclusive<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Failure> {
    // SAFETY: as promised.
    unsafe { pointer.as_mut() }.ok_or_else(|| null(name))
}

/// A place for one result. It may hold anything before.
pub(crate) struct Place<T>(NonNull<T>);

impl<T> Place<T> {
    /// # Safety
    /// If not null, `pointer` may be written to until the place is gone.
    pub(crate) unsafe fn new(pointer: *mut T, name: &str) -> Result<Self, Failure> {
        NonNull::new(pointer).map(Self).ok_or_else(|| null(name))
    }

    pub(crate) fn set(self, value: T) {
        // SAFETY: the promise of `new`; nothing is read or dropped.
        unsafe { self.0.write(value) }
    }
}

/// Numbers to read. A null pointer is an empty array.
///
/// # Safety
/// If not null, `pointer` points to `length` values that nothing changes while `'a` lasts.
pub(crate) unsafe fn array<'a, T>(pointer: *const T, length: usize, name: &str) -> Result<&'a [T], Failure> {
    check_length::<T>(length, name)?;
    if length == 0 {
        return Ok(&[]);
    }
    // SAFETY: as promised, not null, not longer than any object can be.
    Ok(unsafe { std::slice::from_raw_parts(shared(pointer, name)?, length) })
}

/// Numbers to write; they have to be initialised.
///
/// # Safety
/// If not null, `pointer` points to `length` initialised values that nothing else uses while `'a` lasts.
pub(crate) unsafe fn array_mut<'a, T>(
    pointer: *mut T,
    length: usize,
    name: &str,
) -> Result<&'a mut [T], Failure> {
    check_length::<T>(length, name)?;
    if length == 0 {
        return Ok(&mut []);
    }
    // SAFETY: as promised, not null, not longer than any object can be.
    Ok(unsafe { std::slice::from_raw_parts_mut(exclusive(pointer, name)?, length) })
}

fn check_length<T>(length: usize, name: &str) -> Result<(), Failure> {
    match length.checked_mul(size_of::<T>()) {
        Some(bytes) if bytes <= isize::MAX as usize => Ok(()),
        _ => Err(Failure::argument(format_args!("{name} has {length} entries, more than memory can hold"))),
    }
}

/// Three components.
///
/// # Safety
/// If not null, `pointer` points to three values that nothing changes meanwhile.
pub(crate) unsafe fn vector(pointer: *const f64, name: &str) -> Result<[f64; 3], Failure> {
    // SAFETY: as promised.
    let vector = *unsafe { shared(pointer.cast::<[f64; 3]>(), name) }?;
    match vector.iter().find(|x| !x.is_finite()) {
        None => Ok(vector),
        Some(found) => Err(Failure::argument(format_args!("{name} holds {found}, expected finite numbers"))),
    }
}

/// A text.
///
/// # Safety
/// If not null, `pointer` points to a NUL-terminated text that nothing changes while `'a` lasts.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: as promised, and not null.
    unsafe { CStr::from_ptr(pointer) }
        .to_str()
        .map_err(|_| Failure::argument(format_args!("{name} is not UTF-8 text")))
}

/// A structure of the header, which starts with its size in bytes.
///
/// # Safety
/// `repr(C)`, without padding anywhere, first field `struct_size: u64`, every pattern of bits of the others valid.
pub(crate) unsafe trait Sized1: Copy {
    /// Length of the structure in the first version of the header; later ones only add to it.
    const FIRST: usize;
}

/// Bytes of the first field.
const HEAD: usize = size_of::<u64>();

/// Writes as much of `value` as the caller's structure has room for.
///
/// # Safety
/// If not null, `pointer` points to a `uint64_t` and, behind it, as many bytes as it says, less its own, that may be
/// written to.
pub(crate) unsafe fn fill<T: Sized1>(pointer: *mut T, value: &T, name: &str) -> Result<(), Failure> {
    // SAFETY: as promised.
    let size = unsafe { struct_size(pointer, name) }?;
    // SAFETY: both sides have `size` bytes; the first field stays as the caller set it. Bytes, as there is no padding.
    unsafe {
        let from = std::ptr::from_ref(value).cast::<u8>().add(HEAD);
        pointer.cast::<u8>().add(HEAD).copy_from_nonoverlapping(from, size - HEAD);
    }
    Ok(())
}

/// The caller's structure; what it has no room for is as in `default`.
///
/// # Safety
/// If not null, `pointer` points to a `uint64_t` and, behind it, as many initialised bytes as it says, less its own.
pub(crate) unsafe fn read<T: Sized1>(pointer: *const T, default: T, name: &str) -> Result<T, Failure> {
    // SAFETY: as promised.
    let size = unsafe { struct_size(pointer, name) }?;
    let mut value = default;
    // SAFETY: both sides have `size` bytes, and every pattern of bits is a value.
    unsafe {
        let to = (&raw mut value).cast::<u8>().add(HEAD);
        to.copy_from_nonoverlapping(pointer.cast::<u8>().add(HEAD), size - HEAD);
    }
    Ok(value)
}

/// What both sides have of a structure, bytes.
///
/// # Safety
/// If not null, `pointer` points to an initialised `uint64_t`.
unsafe fn struct_size<T: Sized1>(pointer: *const T, name: &str) -> Result<usize, Failure> {
    // SAFETY: as promised; the size is the first field.
    let found = *unsafe { shared(pointer.cast::<u64>(), name) }?;
    let expected = size_of::<T>();
    // Larger than any header will make it: never set.
    if found < T::FIRST as u64 || !found.is_multiple_of(HEAD as u64) || found > 1 << 16 {
        return Err(Failure::argument(format_args!(
            "struct_size of {name} is {found}, expected sizeof the structure ({expected}): set it before the call"
        )));
    }
    Ok((found as usize).min(expected))
}
