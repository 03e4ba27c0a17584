//! Memory of the caller: pointers that are checked as far as can be, and structs that can grow.

use core::ffi::{CStr, c_char};

use crate::failure::{
    COAXLE_CAPACITY, COAXLE_MISALIGNED, COAXLE_NULL, COAXLE_STRUCT_SIZE, COAXLE_TEXT, Failure,
};

/// Borrows what a pointer points to, to write it.
///
/// # Safety
/// `pointer` is null, or points to a value that nobody else uses meanwhile.
pub(crate) unsafe fn writable<'a, T>(
    pointer: *mut T,
    name: &'static str,
) -> Result<&'a mut T, Failure> {
    check_pointer(pointer, name)?;
    // SAFETY: not null and aligned; the rest as for this function.
    Ok(unsafe { &mut *pointer })
}

/// Borrows what a pointer points to, to write it; none for a null one.
///
/// # Safety
/// As for [`writable`].
pub(crate) unsafe fn writable_if_any<'a, T>(
    pointer: *mut T,
    name: &'static str,
) -> Result<Option<&'a mut T>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: as for this function.
    unsafe { writable(pointer, name) }.map(Some)
}

/// Borrows what a pointer points to.
///
/// # Safety
/// `pointer` is null, or points to a value that nobody changes meanwhile.
pub(crate) unsafe fn readable<'a, T>(
    pointer: *const T,
    name: &'static str,
) -> Result<&'a T, Failure> {
    check_pointer(pointer, name)?;
    // SAFETY: not null and aligned; the rest as for this function.
    Ok(unsafe { &*pointer })
}

/// Borrows an array; a null pointer is an empty one.
///
/// # Safety
/// `pointer` is null, or points to `length` values that nobody changes meanwhile.
pub(crate) unsafe fn readable_array<'a, T>(
    pointer: *const T,
    length: usize,
    name: &'static str,
) -> Result<&'a [T], Failure> {
    if length == 0 {
        return Ok(&[]);
    }
    check_pointer(pointer, name)?;
    check_length::<T>(length, name)?;
    // SAFETY: not null, aligned, and no longer than memory can be; the rest as for this function.
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}

/// Borrows an array to write it; a null pointer is an empty one.
///
/// # Safety
/// `pointer` is null, or points to `length` values that nobody else uses meanwhile.
pub(crate) unsafe fn writable_array<'a, T>(
    pointer: *mut T,
    length: usize,
    name: &'static str,
) -> Result<&'a mut [T], Failure> {
    if length == 0 {
        return Ok(&mut []);
    }
    check_pointer(pointer, name)?;
    check_length::<T>(length, name)?;
    // SAFETY: not null, aligned, and no longer than memory can be; the rest as for this function.
    Ok(unsafe { core::slice::from_raw_parts_mut(pointer, length) })
}

/// Returns as many places of a buffer as are needed.
pub(crate) fn fitting(bytes: &mut [u8], needed: usize) -> Result<&mut [u8], Failure> {
    let capacity = bytes.len();
    bytes.get_mut(..needed).ok_or_else(|| {
        let sentence =
            format_args!("capacity: received {capacity} bytes, expected at least {needed}");
        Failure::new(COAXLE_CAPACITY, sentence)
    })
}

/// Borrows a text.
///
/// # Safety
/// `text` is null, or points to bytes that end with a 0 and that nobody changes meanwhile.
pub(crate) unsafe fn text<'a>(text: *const c_char, name: &'static str) -> Result<&'a str, Failure> {
    check_pointer(text, name)?;
    // SAFETY: not null; the rest as for this function.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|wrong| {
        let at = wrong.valid_up_to();
        Failure::new(
            COAXLE_TEXT,
            format_args!("{name}: received a text that is not UTF-8 at byte {at}"),
        )
    })
}

fn check_pointer<T>(pointer: *const T, name: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        let sentence = format_args!("{name}: received a null pointer");
        return Err(Failure::new(COAXLE_NULL, sentence));
    }
    if !pointer.is_aligned() {
        let expected = align_of::<T>();
        let sentence = format_args!(
            "{name}: received the address {pointer:p}, expected a multiple of {expected}"
        );
        return Err(Failure::new(COAXLE_MISALIGNED, sentence));
    }
    Ok(())
}

fn check_length<T>(length: usize, name: &str) -> Result<(), Failure> {
    let most = isize::MAX as usize / size_of::<T>().max(1);
    if length > most {
        return Err(Failure::range(
            name,
            length,
            format_args!("at most {most} elements"),
        ));
    }
    Ok(())
}

/// A struct of plain numbers that begins with its size, a `u32`, so that it can grow.
///
/// # Safety
/// `#[repr(C)]`, its first field is a `u32`, and all bits are valid values.
pub(crate) unsafe trait Growing: Copy {
    /// Size of its first version, bytes.
    const FIRST_SIZE: usize;
    /// Name in errors.
    const NAME: &'static str;
    /// All bytes 0.
    const ZERO: Self;
}

/// Reads a struct of a caller whose version of it may be older or newer. What an older one does not have is 0.
///
/// # Safety
/// `given` is null, or points to a struct with as many bytes as its `struct_size` says.
pub(crate) unsafe fn read<T: Growing>(given: *const T) -> Result<T, Failure> {
    // SAFETY: as for this function.
    let size = unsafe { struct_size(given) }?;
    let mut own = T::ZERO;
    let known = size.min(size_of::<T>());
    // SAFETY: both have that many bytes, and all bits are valid.
    unsafe {
        core::ptr::copy_nonoverlapping(given.cast::<u8>(), (&raw mut own).cast::<u8>(), known);
    }
    // SAFETY: it has that many bytes beyond those that are known.
    let beyond =
        unsafe { core::slice::from_raw_parts(given.cast::<u8>().add(known), size - known) };
    if beyond.iter().any(|byte| *byte != 0) {
        return Err(wrong_size::<T>(size));
    }
    Ok(own)
}

/// Writes as much of a struct as the caller has room for; its `struct_size` stays.
///
/// # Safety
/// As for [`read`], and nobody else uses it meanwhile.
pub(crate) unsafe fn write<T: Growing>(out: *mut T, value: &T) -> Result<(), Failure> {
    // SAFETY: as for this function.
    let size = unsafe { struct_size(out) }?;
    let (head, known) = (size_of::<u32>(), size.min(size_of::<T>()));
    // SAFETY: both have that many bytes.
    unsafe {
        core::ptr::copy_nonoverlapping(
            core::ptr::from_ref(value).cast::<u8>().add(head),
            out.cast::<u8>().add(head),
            known - head,
        );
    }
    Ok(())
}

/// Checks a struct that is written after something has happened: a wrong one must be found before. A null one is not written.
///
/// # Safety
/// As for [`read`].
pub(crate) unsafe fn check_if_any<T: Growing>(out: *const T) -> Result<(), Failure> {
    if out.is_null() {
        return Ok(());
    }
    // SAFETY: as for this function.
    unsafe { struct_size(out) }.map(drop)
}

/// Writes a struct, as [`write()`] does; not a null one.
///
/// # Safety
/// As for [`write()`].
pub(crate) unsafe fn write_if_any<T: Growing>(out: *mut T, value: &T) -> Result<(), Failure> {
    if out.is_null() {
        return Ok(());
    }
    // SAFETY: as for this function.
    unsafe { write(out, value) }
}

/// # Safety
/// As for [`read`].
unsafe fn struct_size<T: Growing>(given: *const T) -> Result<usize, Failure> {
    check_pointer(given, T::NAME)?;
    // SAFETY: not null and aligned; the first field is a `u32`.
    let size = unsafe { *given.cast::<u32>() } as usize;
    // No struct will ever be as large: a size that was not set must not lead far out of it.
    if (T::FIRST_SIZE..=MOST_STRUCT_SIZE).contains(&size) {
        Ok(size)
    } else {
        Err(wrong_size::<T>(size))
    }
}

const MOST_STRUCT_SIZE: usize = 4096;

fn wrong_size<T: Growing>(received: usize) -> Failure {
    let (name, first, known) = (T::NAME, T::FIRST_SIZE, size_of::<T>());
    let sentence = format_args!(
        "{name}: received a struct_size of {received}, expected sizeof({name}): {first} to {known}, or more with zeros only"
    );
    Failure::new(COAXLE_STRUCT_SIZE, sentence)
}

/// Declares that a struct of numbers can grow.
macro_rules! growing {
    ($($name:ident, $first:expr;)*) => {$(
        // It has grown since, or not: it never shrinks.
        const _: () = assert!(size_of::<$name>() >= $first);

        // SAFETY: `#[repr(C)]`, of numbers alone, the first a `u32`.
        unsafe impl $crate::memory::Growing for $name {
            const FIRST_SIZE: usize = $first;
            const NAME: &'static str = stringify!($name);
            const ZERO: Self = {
                // SAFETY: all bits are valid.
                unsafe { core::mem::zeroed() }
            };
        }
    )*};
}
pub(crate) use growing;

/// Returns a number that must be finite.
pub(crate) fn finite(field: &str, received: f64) -> Result<f64, Failure> {
    match received.is_finite() {
        true => Ok(received),
        false => Err(Failure::range(field, received, "a finite number")),
    }
}
