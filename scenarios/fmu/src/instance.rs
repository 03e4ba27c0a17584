//! The handle of an instance, its log, and calls of its functions.

use core::ffi::{c_char, c_void};
use core::fmt;
use core::panic::AssertUnwindSafe;
use std::ffi::CString;

use coaxle_fmi::UnitInstance;
use coaxle_node::config::Wrong;

/// `fmi3Status`.
pub(crate) type FmiStatus = i32;
/// `fmi3OK`.
pub(crate) const OK: FmiStatus = 0;
/// `fmi3Warning`.
const WARNING: FmiStatus = 1;
/// `fmi3Error`.
pub(crate) const ERROR: FmiStatus = 3;
/// `fmi3Fatal`: the instance cannot be used any more.
const FATAL: FmiStatus = 4;

/// `fmi3LogMessageCallback`.
pub(crate) type LogMessage =
    Option<unsafe extern "C" fn(*mut c_void, FmiStatus, *const c_char, *const c_char)>;

/// The log of a caller.
#[derive(Clone, Copy)]
pub(crate) struct CallerLog {
    pub(crate) environment: *mut c_void,
    pub(crate) message: LogMessage,
}

/// An instance as its caller holds it.
pub(crate) struct InstanceHandle {
    kind: u64,
    pub(crate) instance: UnitInstance,
    pub(crate) log: CallerLog,
    /// Texts that were passed out, until the next call that does so.
    pub(crate) texts: Vec<CString>,
}

/// Marks of a handle, and of one that has been freed or whose inside is in an unknown state.
const LIVING: u64 = u64::from_le_bytes(*b"coaxfmi3");
const GONE: u64 = u64::from_le_bytes(*b"coaxgone");

/// A refusal: what the log says, and the status that the caller gets.
pub(crate) struct Refused(String);

impl Refused {
    pub(crate) fn of(
        field: &str,
        received: impl fmt::Display,
        expected: impl fmt::Display,
    ) -> Self {
        Self::from(Wrong::of(field, received, expected))
    }

    /// A refusal with its causes.
    pub(crate) fn from_chain(error: anyhow::Error) -> Self {
        Self(format!("{error:#}"))
    }
}

impl From<Wrong> for Refused {
    fn from(wrong: Wrong) -> Self {
        Self(wrong.to_string())
    }
}

impl CallerLog {
    pub(crate) fn say(self, status: FmiStatus, text: &str) {
        let category = if status == WARNING {
            c"logStatusWarning"
        } else {
            c"logStatusError"
        };
        // A zero within would end the sentence early.
        let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
        if let Some(message) = self.message {
            // SAFETY: the callback and its environment are those of the caller, who keeps them as long as the instance.
            unsafe { message(self.environment, status, category.as_ptr(), text.as_ptr()) }
        }
    }

    pub(crate) fn warn(self, text: &str) {
        self.say(WARNING, text);
    }
}

/// Makes a handle; null after a refusal, which the log says.
pub(crate) fn make(
    log: CallerLog,
    body: impl FnOnce() -> Result<UnitInstance, Refused>,
) -> *mut c_void {
    match std::panic::catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(instance)) => {
            let handle = InstanceHandle {
                kind: LIVING,
                instance,
                log,
                texts: Vec::new(),
            };
            Box::into_raw(Box::new(handle)).cast()
        }
        Ok(Err(Refused(text))) => {
            log.say(ERROR, &text);
            core::ptr::null_mut()
        }
        Err(_) => {
            log.say(FATAL, FAULT);
            core::ptr::null_mut()
        }
    }
}

/// What the log says after a panic.
const FAULT: &str = "a fault of the unit; free the instance, and report it";

/// Runs a function of an instance. A refusal is logged.
///
/// # Safety
/// `instance` is null, or was made by `fmi3InstantiateCoSimulation` and not freed since, and no other thread uses it.
pub(crate) unsafe fn call(
    instance: *mut c_void,
    body: impl FnOnce(&mut InstanceHandle) -> Result<(), Refused>,
) -> FmiStatus {
    // SAFETY: as for this function.
    let Some(handle) = (unsafe { living(instance) }) else {
        return ERROR;
    };
    match std::panic::catch_unwind(AssertUnwindSafe(|| body(handle))) {
        Ok(Ok(())) => OK,
        Ok(Err(Refused(text))) => {
            handle.log.say(ERROR, &text);
            ERROR
        }
        Err(_) => {
            handle.kind = GONE;
            handle.log.say(FATAL, FAULT);
            FATAL
        }
    }
}

/// Frees an instance; a null one is left alone.
///
/// # Safety
/// As for [`call`].
pub(crate) unsafe fn free(instance: *mut c_void) {
    let handle = instance.cast::<InstanceHandle>();
    if handle.is_null() || !handle.is_aligned() {
        return;
    }
    // SAFETY: as for this function.
    let mut handle = unsafe { Box::from_raw(handle) };
    handle.kind = GONE;
    // A drop that panics must not cross the border either.
    let _ = std::panic::catch_unwind(AssertUnwindSafe(|| drop(handle)));
}

/// # Safety
/// As for [`call`].
unsafe fn living<'a>(instance: *mut c_void) -> Option<&'a mut InstanceHandle> {
    let handle = instance.cast::<InstanceHandle>();
    if handle.is_null() || !handle.is_aligned() {
        return None;
    }
    // SAFETY: as for this function.
    let handle = unsafe { &mut *handle };
    (handle.kind == LIVING).then_some(handle)
}
