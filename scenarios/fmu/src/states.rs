//! States of instances, kept by their caller.

use core::ffi::c_void;

use coaxle_fmi::InstanceState;

use crate::instance::{FmiStatus, Refused, call};
use crate::memory::{array, array_to_write};

/// Marks of a state, and of one that has been freed.
const LIVING: u64 = u64::from_le_bytes(*b"coaxstat");
const GONE: u64 = u64::from_le_bytes(*b"goneaway");

/// A state as its caller holds it.
struct StateHandle {
    kind: u64,
    state: InstanceState,
}

/// Passes out the state of an instance, in place of an earlier one if there is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(
    instance: *mut c_void,
    out: *mut *mut c_void,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |handle| {
            let [out] = array_to_write(out, 1, "FMUState")? else {
                return Ok(());
            };
            let state = handle.instance.state()?;
            if out.is_null() {
                *out = passed_out(state);
            } else {
                living(*out)?.state = state;
            }
            Ok(())
        })
    }
}

/// Returns to a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, state: *mut c_void) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |handle| {
            let restored = handle.instance.restore(&living(state)?.state);
            restored.map_err(Refused::from_chain)
        })
    }
}

/// Frees a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(
    instance: *mut c_void,
    state: *mut *mut c_void,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |_| {
            let [state] = array_to_write(state, 1, "FMUState")? else {
                return Ok(());
            };
            if !state.is_null() {
                living(*state)?.kind = GONE;
                drop(Box::from_raw(state.cast::<StateHandle>()));
                *state = core::ptr::null_mut();
            }
            Ok(())
        })
    }
}

/// Passes out the size of a state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |_| {
            let bytes = living(state)?.state.to_bytes()?;
            if let [size] = array_to_write(size, 1, "size")? {
                *size = bytes.len();
            }
            Ok(())
        })
    }
}

/// Writes a state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: *mut c_void,
    state: *mut c_void,
    serialized: *mut u8,
    size: usize,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |_| {
            let bytes = living(state)?.state.to_bytes()?;
            let out = array_to_write(serialized, size, "serializedState")?;
            if out.len() != bytes.len() {
                let expected = format!("{}, that of fmi3SerializedFMUStateSize", bytes.len());
                return Err(Refused::of("size", size, expected));
            }
            out.copy_from_slice(&bytes);
            Ok(())
        })
    }
}

/// Reads a state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: *mut c_void,
    serialized: *const u8,
    size: usize,
    out: *mut *mut c_void,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |_| {
            let state = InstanceState::from_bytes(array(serialized, size, "serializedState")?)?;
            if let [out] = array_to_write(out, 1, "FMUState")? {
                *out = passed_out(state);
            }
            Ok(())
        })
    }
}

fn passed_out(state: InstanceState) -> *mut c_void {
    let handle = StateHandle {
        kind: LIVING,
        state,
    };
    Box::into_raw(Box::new(handle)).cast()
}

/// # Safety
/// `state` is null, or was passed out here and not freed since, and no other thread uses it.
unsafe fn living<'a>(state: *mut c_void) -> Result<&'a mut StateHandle, Refused> {
    let handle = state.cast::<StateHandle>();
    if !handle.is_null() && handle.is_aligned() {
        // SAFETY: as for this function.
        let handle = unsafe { &mut *handle };
        if handle.kind == LIVING {
            return Ok(handle);
        }
    }
    Err(Refused::of(
        "FMUState",
        "none",
        "one of fmi3GetFMUState that has not been freed",
    ))
}
