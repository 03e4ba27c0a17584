//! What callers point to.

use core::ffi::{CStr, c_char};

use crate::instance::Refused;

/// An array of a caller.
///
/// # Safety
/// `first` is null, or points to `number` elements that nobody writes meanwhile.
pub(crate) unsafe fn array<'a, T>(
    first: *const T,
    number: usize,
    name: &str,
) -> Result<&'a [T], Refused> {
    if number == 0 {
        return Ok(&[]);
    }
    check_array(first, number, name)?;
    // SAFETY: checked as far as possible; the rest is the caller's duty.
    Ok(unsafe { core::slice::from_raw_parts(first, number) })
}

/// An array of a caller that is written.
///
/// # Safety
/// `first` is null, or points to `number` elements that nobody else uses meanwhile.
pub(crate) unsafe fn array_to_write<'a, T>(
    first: *mut T,
    number: usize,
    name: &str,
) -> Result<&'a mut [T], Refused> {
    if number == 0 {
        return Ok(&mut []);
    }
    check_array(first, number, name)?;
    // SAFETY: checked as far as possible; the rest is the caller's duty.
    Ok(unsafe { core::slice::from_raw_parts_mut(first, number) })
}

/// A text of a caller.
///
/// # Safety
/// `text` is null, or points to a text with a zero at its end.
pub(crate) unsafe fn text(text: *const c_char, name: &str) -> Result<String, Refused> {
    if text.is_null() {
        return Err(Refused::of(name, "NULL", "a text"));
    }
    // SAFETY: the caller's duty.
    let text = unsafe { CStr::from_ptr(text) };
    match text.to_str() {
        Ok(text) => Ok(text.to_owned()),
        Err(_) => Err(Refused::of(
            name,
            "bytes that are no UTF-8",
            "a text in UTF-8",
        )),
    }
}

/// Writes a value to a place of a caller; a null one is left alone.
///
/// # Safety
/// `place` is null, or points to a place for the value.
pub(crate) unsafe fn write_if_any<T>(place: *mut T, value: T) {
    if !place.is_null() && place.is_aligned() {
        // SAFETY: checked as far as possible; the rest is the caller's duty.
        unsafe { place.write(value) }
    }
}

fn check_array<T>(first: *const T, number: usize, name: &str) -> Result<(), Refused> {
    if first.is_null() || !first.is_aligned() {
        let received = if first.is_null() {
            "NULL"
        } else {
            "a misaligned pointer"
        };
        return Err(Refused::of(
            name,
            received,
            format_args!("{number} elements"),
        ));
    }
    if number > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(Refused::of(
            name,
            number,
            "a number of elements that fits in memory",
        ));
    }
    Ok(())
}
