//! The memory that a node and the drive process of a slave share (`docs/DRIVE.md`), from both ends.

use core::ffi::c_char;
use std::ffi::CString;
use std::path::Path;

use ::coaxle_axis::drive::{Drive, ProcessDriveParameters, ProcessState};
use coaxle_clock::{Instant, Seconds};
use coaxle_curve::profile::Kinematics;
use coaxle_drive_memory::{
    DriveIdentity, DriveProcess, ProcessValues, SetValues, SharedMemoryDrive, SharedMemoryError,
};
use coaxle_os::machine;

use crate::caller_drive::coaxle_actual;
use crate::drive_memory_structs::{
    COAXLE_PROCESS_ERROR, COAXLE_PROCESS_FOLLOWING, COAXLE_PROCESS_OFF,
    coaxle_drive_memory_command, coaxle_drive_memory_parameters, coaxle_drive_set_values,
    coaxle_drive_values,
};
use crate::failure::{COAXLE_NOT_THERE, COAXLE_REJECTED, COAXLE_TEXT, Failure};
use crate::handle::{HandleHead, call, free, handle, make};
use crate::memory::{check_if_any, finite, read, text, writable_if_any, write, write_if_any};
use crate::phase::cycle_time;

/// The drive process's end: reads the set values of a slave, and reports the actual values of its drive.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_drive_process {
    head: HandleHead,
    process: DriveProcess,
    name: CString,
}

handle!(coaxle_drive_process, b"drv-proc");

/// The node's end: hands the set values of a slave to the process of its drive, and monitors the process.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_drive_node {
    head: HandleHead,
    drive: SharedMemoryDrive,
    has_power: bool,
}

handle!(coaxle_drive_node, b"drv-node");

/// Attaches to the memory that a running node has created at `path`: opens, locks and maps the file. One process is attached at a time.
///
/// # Errors
/// `COAXLE_NOT_THERE` without a running node, or with another process attached: later it may succeed. `COAXLE_REJECTED` for a file
/// that is no memory of a drive, or that may not be used.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_drive_process_new(
    path: *const c_char,
    out: *mut *mut coaxle_drive_process,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || {
            let path = text(path, "path")?;
            let process = DriveProcess::attach(Path::new(path)).map_err(|error| refused(&error))?;
            // A byte 0 within a name would end it in C.
            let name = CString::new(process.slave().0.replace('\0', " "))
                .map_err(|wrong| Failure::new(COAXLE_TEXT, wrong))?;
            Ok(coaxle_drive_process {
                head: HandleHead::new::<coaxle_drive_process>(),
                process,
                name,
            })
        })
    }
}

/// Reports to the node that no process is attached, and frees the handle; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_drive_process_free(process: *mut coaxle_drive_process) {
    // SAFETY: as for this function.
    unsafe { free(process) }
}

/// Passes out the name of the slave, which stays until the handle is freed, its axis id, and the nominal cycle time of the node, ns. Each
/// of the three may be `NULL`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_drive_process_slave(
    process: *mut coaxle_drive_process,
    name: *mut *const c_char,
    axis_id: *mut u32,
    cycle_time_ns: *mut i64,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(process, |own| {
            if let Some(name) = writable_if_any(name, "name")? {
                *name = own.name.as_ptr();
            }
            if let Some(axis_id) = writable_if_any(axis_id, "axis_id")? {
                *axis_id = own.process.slave().1;
            }
            if let Some(cycle_time_ns) = writable_if_any(cycle_time_ns, "cycle_time_ns")? {
                *cycle_time_ns = own.process.cycle_time().as_nanos();
            }
            Ok(())
        })
    }
}

/// Passes out the newest set values.
///
/// # Errors
/// `COAXLE_NOT_THERE` while they are being written, when the previous ones stay in force; and after the end of the node, when
/// `is_attached` is 0: free the handle, and attach again.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_drive_process_read(
    process: *mut coaxle_drive_process,
    is_attached: *mut u32,
    out: *mut coaxle_drive_set_values,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(process, |own| {
            let set = own.process.set_values();
            if let Some(is_attached) = writable_if_any(is_attached, "is_attached")? {
                *is_attached = own.process.is_attached().into();
            }
            let set = set.ok_or_else(|| {
                let why =
                    "set values: none just now, as they are being written or the node has ended";
                Failure::new(COAXLE_NOT_THERE, why)
            })?;
            write(out, &coaxle_drive_set_values::of(&set))
        })
    }
}

/// Reports the actual values of the drive. Each call is a heartbeat of the process.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_drive_process_report(
    process: *mut coaxle_drive_process,
    values: *const coaxle_drive_values,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(process, |own| {
            own.process.answer(&read(values)?.checked()?);
            Ok(())
        })
    }
}

/// Creates the memory of a slave at `path`, on a file system in memory, or takes over the one of an earlier node that has crashed.
/// `name` is that of the slave.
///
/// # Errors
/// `COAXLE_REJECTED` for a file that another node uses, that is something else, or to which others have any right.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_drive_node_new(
    parameters: *const coaxle_drive_memory_parameters,
    path: *const c_char,
    name: *const c_char,
    out: *mut *mut coaxle_drive_node,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || {
            let given = read(parameters)?;
            let identity = DriveIdentity {
                run: given.run,
                slave_id: given.axis_id,
                slave: text(name, "name")?,
                cycle_time: cycle_time(given.cycle_time_ns)?,
            };
            let path = Path::new(text(path, "path")?);
            let drive = SharedMemoryDrive::create(path, &identity, given.taken())
                .map_err(|error| refused(&error))?;
            Ok(coaxle_drive_node {
                head: HandleHead::new::<coaxle_drive_node>(),
                drive,
                has_power: false,
            })
        })
    }
}

/// Reports the end of the node to the process, removes the file, and frees the handle; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_drive_node_free(node: *mut coaxle_drive_node) {
    // SAFETY: as for this function.
    unsafe { free(node) }
}

/// Hands the set values of a cycle over, and passes out the actual values of the drive, as `coaxle_slave_report_actual` and
/// `coaxle_receiver_report_actual` take them. `out` may be `NULL`. A drive that has tripped stays so until `wants_power` has been 0.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_drive_node_step(
    node: *mut coaxle_drive_node,
    command: *const coaxle_drive_memory_command,
    out: *mut coaxle_actual,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(node, |own| {
            check_if_any(out)?;
            let given = read(command)?;
            let set = given.checked()?;
            own.switch(given.wants_power != 0, &set);
            machine::begin_cycle(Instant::from_nanos(given.ideal_start_ns));
            own.drive.step(&set, Seconds(given.elapsed_s));
            write_if_any(out, &coaxle_actual::of(&own.drive.actual()))
        })
    }
}

impl coaxle_drive_node {
    fn switch(&mut self, wants_power: bool, set: &Kinematics) {
        match (self.has_power, wants_power) {
            (false, true) => self.drive.power_on(set.position, set.velocity),
            (true, false) => self.drive.reset(),
            _ => {}
        }
        self.has_power = wants_power;
    }
}

/// An error of a file as a code: whether trying again may help.
fn refused(error: &SharedMemoryError) -> Failure {
    let code = match error.may_pass() {
        true => COAXLE_NOT_THERE,
        false => COAXLE_REJECTED,
    };
    Failure::new(code, error)
}

impl coaxle_drive_set_values {
    fn of(set: &SetValues) -> Self {
        Self {
            struct_size: 0,
            is_enabled: set.enable.into(),
            counter: set.counter,
            ideal_start_ns: set.ideal_start.as_nanos(),
            position: set.position,
            velocity: set.velocity,
            acceleration: set.acceleration,
            resets: set.resets,
        }
    }
}

impl coaxle_drive_values {
    fn checked(&self) -> Result<ProcessValues, Failure> {
        Ok(ProcessValues {
            state: match self.state {
                COAXLE_PROCESS_OFF => ProcessState::Off,
                COAXLE_PROCESS_FOLLOWING => ProcessState::Following,
                COAXLE_PROCESS_ERROR => ProcessState::Error,
                other => return Err(Failure::range("state", other, "0 to 2")),
            },
            error: self.error,
            position: finite("position", self.position)?,
            velocity: finite("velocity", self.velocity)?,
            counter: self.counter,
            resets: self.resets,
        })
    }
}

impl coaxle_drive_memory_parameters {
    /// The parameters of the drive, which checks them itself.
    const fn taken(&self) -> ProcessDriveParameters {
        ProcessDriveParameters {
            max_silent_cycles: self.max_silent_cycles,
            switch_on_cycles: self.switch_on_cycles,
            following_error_window: self.following_error_window,
            following_error_time: self.following_error_time_s,
        }
    }
}

impl coaxle_drive_memory_command {
    fn checked(&self) -> Result<Kinematics, Failure> {
        if !(1e-9..=1e6).contains(&self.elapsed_s) {
            return Err(Failure::range(
                "elapsed_s",
                self.elapsed_s,
                "1e-9 s to 1e6 s",
            ));
        }
        Ok(Kinematics {
            position: finite("position", self.position)?,
            velocity: finite("velocity", self.velocity)?,
            acceleration: finite("acceleration", self.acceleration)?,
        })
    }
}
