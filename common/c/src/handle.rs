//! The border to C: handles, and calls of their functions.
//!
//! Every function of the interface is a line that calls one of the functions here. What a caller may do wrong and can be seen is an
//! error code; what cannot be seen (a pointer to memory that is no longer there, two threads at once) is the caller's duty, and the
//! header says so.

use core::ffi::c_char;
use core::panic::AssertUnwindSafe;
use core::sync::atomic::{AtomicBool, Ordering};
use std::cell::RefCell;

use crate::failure::{COAXLE_IN_USE, COAXLE_NO_HANDLE, COAXLE_OK, COAXLE_PANIC, Failure, Sentence};
use crate::memory::writable;

/// Head of every handle.
#[derive(Debug)]
#[repr(C)]
pub(crate) struct HandleHead {
    kind: u64,
    is_in_use: AtomicBool,
    newest_error: Sentence,
}

/// Marks of a handle whose inside is in an unknown state, and of one that has been freed.
const BROKEN: u64 = 0x636f_6178_6c65_0001;
const FREED: u64 = 0x636f_6178_6c65_0002;

/// A handle: `#[repr(C)]`, with a [`HandleHead`] first.
///
/// # Safety
/// The first field is a [`HandleHead`], and no two kinds are equal.
pub(crate) unsafe trait Handle: Sized {
    /// Distinguishes it from handles of other kinds.
    const KIND: u64;
    /// Name in errors.
    const NAME: &'static str;

    fn head(&mut self) -> &mut HandleHead;
}

/// Makes structs handles: `#[repr(C)]`, with a field `head` first. Eight letters distinguish each from the others.
macro_rules! handle {
    ($name:ident, $letters:literal) => {
        // SAFETY: a `HandleHead` comes first.
        unsafe impl $crate::handle::Handle for $name {
            const KIND: u64 = u64::from_le_bytes(*$letters);
            const NAME: &'static str = stringify!($name);

            fn head(&mut self) -> &mut $crate::handle::HandleHead {
                const { assert!(core::mem::offset_of!($name, head) == 0) }
                &mut self.head
            }
        }
    };
}
pub(crate) use handle;

impl HandleHead {
    pub(crate) const fn new<H: Handle>() -> Self {
        Self {
            kind: H::KIND,
            is_in_use: AtomicBool::new(false),
            newest_error: Sentence::EMPTY,
        }
    }
}

thread_local! {
    // Errors without a handle: those of `_new` functions, and of a handle that is none.
    static NEWEST: RefCell<Sentence> = const { RefCell::new(Sentence::EMPTY) };
}

/// Runs a function of a handle.
///
/// # Safety
/// `handle` is null, or a handle that was made by its `_new` function and not freed since, and no other thread uses it.
pub(crate) unsafe fn call<H: Handle>(
    handle: *mut H,
    body: impl FnOnce(&mut H) -> Result<(), Failure>,
) -> i32 {
    // SAFETY: as for this function.
    let handle = match unsafe { checked(handle) } {
        Ok(handle) => handle,
        Err(failure) => return without_handle(failure),
    };
    if cfg!(debug_assertions) && handle.head().is_in_use.swap(true, Ordering::Acquire) {
        // Its sentence belongs to the other thread.
        return without_handle(Failure::new(
            COAXLE_IN_USE,
            format_args!("{}: is in use by another thread", H::NAME),
        ));
    }
    let result = std::panic::catch_unwind(AssertUnwindSafe(|| body(handle)));
    let head = handle.head();
    if cfg!(debug_assertions) {
        head.is_in_use.store(false, Ordering::Release);
    }
    match result {
        Ok(Ok(())) => COAXLE_OK,
        Ok(Err(failure)) => {
            head.newest_error = failure.sentence;
            failure.code
        }
        Err(_) => {
            head.kind = BROKEN;
            without_handle(panicked(H::NAME))
        }
    }
}

/// Makes a handle and passes it out.
///
/// # Safety
/// `out` is null, or points to a place for the handle.
pub(crate) unsafe fn make<H: Handle>(
    out: *mut *mut H,
    body: impl FnOnce() -> Result<H, Failure>,
) -> i32 {
    let made = std::panic::catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: as for this function.
        let out = unsafe { writable(out, "out") }?;
        // A caller that does not look at the code finds no handle.
        *out = core::ptr::null_mut();
        let handle = body()?;
        *out = Box::into_raw(Box::new(handle));
        Ok(())
    }));
    match made {
        Ok(Ok(())) => COAXLE_OK,
        Ok(Err(failure)) => without_handle(failure),
        Err(_) => without_handle(panicked(H::NAME)),
    }
}

/// Frees a handle; a null one is left alone.
///
/// # Safety
/// As for [`call`].
pub(crate) unsafe fn free<H: Handle>(handle: *mut H) {
    // SAFETY: as for this function.
    let is_handle = unsafe { may_be_freed(handle) };
    if is_handle {
        // SAFETY: made by `make`, of this kind, and not freed before.
        let mut handle = unsafe { Box::from_raw(handle) };
        handle.head().kind = FREED;
        // A drop that panics must not cross the border either.
        let _ = std::panic::catch_unwind(AssertUnwindSafe(|| drop(handle)));
    }
}

/// Runs a function that has no handle.
pub(crate) fn plain(body: impl FnOnce() -> Result<(), Failure>) -> i32 {
    match std::panic::catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => COAXLE_OK,
        Ok(Err(failure)) => without_handle(failure),
        Err(_) => without_handle(panicked("coaxle")),
    }
}

/// Returns the sentence of the newest error of a handle; of the calling thread's newest without a handle, for a null one.
///
/// # Safety
/// As for [`call`].
pub(crate) unsafe fn newest_error(handle: *const core::ffi::c_void) -> *const c_char {
    let handle = handle.cast::<HandleHead>();
    if handle.is_null() || !handle.is_aligned() {
        return NEWEST.with(|newest| newest.borrow().as_ptr());
    }
    // SAFETY: every handle begins with a `HandleHead`.
    let head = unsafe { &*handle };
    match head.kind {
        BROKEN | FREED => NEWEST.with(|newest| newest.borrow().as_ptr()),
        _ => head.newest_error.as_ptr(),
    }
}

fn panicked(name: &str) -> Failure {
    Failure::new(
        COAXLE_PANIC,
        format_args!("{name}: a fault of the library; free the handle, and report it"),
    )
}

fn without_handle(failure: Failure) -> i32 {
    NEWEST.with(|newest| *newest.borrow_mut() = failure.sentence);
    failure.code
}

/// # Safety
/// As for [`call`].
unsafe fn checked<'a, H: Handle>(handle: *mut H) -> Result<&'a mut H, Failure> {
    // SAFETY: as for this function.
    let handle = unsafe { writable(handle, H::NAME) }?;
    match handle.head().kind {
        kind if kind == H::KIND => Ok(handle),
        BROKEN => Err(panicked(H::NAME)),
        _ => Err(Failure::new(
            COAXLE_NO_HANDLE,
            format_args!(
                "{}: received a handle of another kind, or a freed one",
                H::NAME
            ),
        )),
    }
}

/// # Safety
/// As for [`call`].
unsafe fn may_be_freed<H: Handle>(handle: *mut H) -> bool {
    if handle.is_null() || !handle.is_aligned() {
        return false;
    }
    // SAFETY: as for this function.
    let kind = unsafe { (*handle).head().kind };
    kind == H::KIND || kind == BROKEN
}
