//! The functions of co-simulation: an instance from its making to its end.

use core::ffi::{c_char, c_void};
use std::path::{Path, PathBuf};

use coaxle_fmi::{Resources, UnitInstance, UnitValue};

use crate::instance::{CallerLog, ERROR, FmiStatus, LogMessage, OK, Refused, call, free, make};
use crate::memory::{array, text, write_if_any};

/// Returns the version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Takes note of what is to be logged: all refusals are, whatever is asked.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut c_void,
    _logging_on: bool,
    number: usize,
    categories: *const *const c_char,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |_| {
            array(categories, number, "categories").map(drop)
        })
    }
}

/// Makes an instance of the unit whose resources are in a folder.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resource_path: *const c_char,
    _visible: bool,
    _logging_on: bool,
    event_mode_used: bool,
    _early_return_allowed: bool,
    _intermediate: *const u32,
    number_of_intermediate: usize,
    environment: *mut c_void,
    message: LogMessage,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    let log = CallerLog {
        environment,
        message,
    };
    make(log, || {
        // SAFETY: as for this function.
        let (token, path) = unsafe {
            (
                text(token, "instantiationToken")?,
                text(resource_path, "resourcePath")?,
            )
        };
        if event_mode_used || number_of_intermediate != 0 {
            let received = "event mode or intermediate variables";
            return Err(Refused::of(
                "fmi3InstantiateCoSimulation",
                received,
                "neither",
            ));
        }
        instance_of(&folder_of(&path), &token)
    })
}

/// A path of resources; masters that still pass an address, as in FMI 2, pass that of a file.
fn folder_of(path: &str) -> PathBuf {
    Path::new(path.strip_prefix("file://").unwrap_or(path)).to_owned()
}

fn instance_of(folder: &Path, token: &str) -> Result<UnitInstance, Refused> {
    let resources = Resources::load(folder).map_err(Refused::from_chain)?;
    let expected = resources.token();
    if token != expected {
        let expected =
            format!("{expected}, that of the resources and of this version of the library");
        return Err(Refused::of("instantiationToken", token, expected));
    }
    let model = resources.model(folder).map_err(Refused::from_chain)?;
    Ok(UnitInstance::new(model).with_token(expected))
}

/// Frees an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    // SAFETY: as for this function.
    unsafe { free(instance) }
}

/// Enters initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_time: f64,
    _stop_time_defined: bool,
    _stop_time: f64,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |handle| {
            Ok(handle.instance.enter_initialization(start_time)?)
        })
    }
}

/// Leaves initialization mode: the unit starts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |handle| {
            let started = handle.instance.exit_initialization();
            started.map_err(Refused::from_chain)
        })
    }
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: *mut c_void) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe { call(instance, |handle| Ok(handle.instance.terminate()?)) }
}

/// Returns to the state after the making.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |handle| {
            handle.instance.reset();
            Ok(())
        })
    }
}

/// Runs a communication step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_state_before: bool,
    event_handling_needed: *mut bool,
    terminate_simulation: *mut bool,
    early_return: *mut bool,
    last_successful_time: *mut f64,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        for flag in [event_handling_needed, terminate_simulation, early_return] {
            write_if_any(flag, false);
        }
        call(instance, |handle| {
            let (point, size) = (current_communication_point, communication_step_size);
            let stepped = handle.instance.step(point, size);
            if let Ok(UnitValue::Float64(time)) = handle.instance.get(0) {
                write_if_any(last_successful_time, *time);
            }
            if let Some(note) = stepped.map_err(Refused::from_chain)? {
                handle.log.warn(&note);
            }
            Ok(())
        })
    }
}

/// Enters step mode, in which the unit is after its initialization.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(instance: *mut c_void) -> FmiStatus {
    if instance.is_null() { ERROR } else { OK }
}
