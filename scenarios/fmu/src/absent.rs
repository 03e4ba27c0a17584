//! Functions of the standard that co-simulation units have no use for: each is there, and refuses.

use core::ffi::{c_char, c_void};

use crate::instance::{CallerLog, FmiStatus, LogMessage, Refused, call, make};

/// Refuses: the units are for co-simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: *const c_char,
    _token: *const c_char,
    _resource_path: *const c_char,
    _visible: bool,
    _logging_on: bool,
    environment: *mut c_void,
    message: LogMessage,
) -> *mut c_void {
    refuse_instance("fmi3InstantiateModelExchange", environment, message)
}

/// Refuses: the units are for co-simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _name: *const c_char,
    _token: *const c_char,
    _resource_path: *const c_char,
    _visible: bool,
    _logging_on: bool,
    environment: *mut c_void,
    message: LogMessage,
    _clock_update: *const c_void,
    _lock_preemption: *const c_void,
    _unlock_preemption: *const c_void,
) -> *mut c_void {
    refuse_instance("fmi3InstantiateScheduledExecution", environment, message)
}

fn refuse_instance(function: &str, environment: *mut c_void, message: LogMessage) -> *mut c_void {
    let log = CallerLog {
        environment,
        message,
    };
    make(log, || {
        Err(Refused::of(
            function,
            "a call",
            "fmi3InstantiateCoSimulation",
        ))
    })
}

macro_rules! absent {
    ($($name:ident)*) => {$(
        /// Refuses: the units do not have what it is about, and their descriptions say so.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut c_void) -> FmiStatus {
            // SAFETY: as for this function. Further arguments are not read, and belong to the caller.
            unsafe {
                call(instance, |_| {
                    let expected = "functions of co-simulation without events, clocks and derivatives";
                    Err(Refused::of(stringify!($name), "a call", expected))
                })
            }
        }
    )*};
}

absent! {
    fmi3EnterEventMode fmi3EnterConfigurationMode fmi3ExitConfigurationMode
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies
    fmi3GetDirectionalDerivative fmi3GetAdjointDerivative fmi3GetOutputDerivatives
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates
    fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime
    fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators
    fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates
    fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates
    fmi3ActivateModelPartition
}
