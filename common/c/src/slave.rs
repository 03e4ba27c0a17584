//! A slave axis with every command: [`SlaveAxis`].

use std::sync::Arc;

use ::coaxle_axis::{CommandState, Job, Masters, Origin};
use ::coaxle_slave::{JobError, JobState, Refusal, SlaveAxis};
use coaxle_cam::Tables;
use coaxle_clock::Seconds;

use crate::axis_struct::coaxle_axis;
use crate::caller_drive::{DriveCells, coaxle_actual};
use crate::command::coaxle_command;
use crate::command_checked::taken;
use crate::failure::{COAXLE_NOT_THERE, COAXLE_OK, Failure};
use crate::handle::{HandleHead, call, free, handle, make};
use crate::memory::{
    check_if_any, read, readable_array, writable, writable_if_any, write, write_if_any,
};
use crate::slave_structs::{coaxle_master, coaxle_slave_parameters, coaxle_slave_state};
use crate::tables::coaxle_tables;

/// Greatest number of masters of a slave axis.
pub const COAXLE_MOST_MASTERS: usize = 4;
const _: () = assert!(COAXLE_MOST_MASTERS == Masters::MOST);

/// No job of this number, or none any more.
pub const COAXLE_JOB_NONE: u32 = 0;
/// Accepted, not yet in control of the axis.
pub const COAXLE_JOB_WAITING: u32 = 1;
/// In control of the axis, not yet at its goal.
pub const COAXLE_JOB_ACTIVE: u32 = 2;
/// Following its master.
pub const COAXLE_JOB_IN_SYNC: u32 = 3;
/// Finished.
pub const COAXLE_JOB_DONE: u32 = 4;
/// Aborted by another command, or by the end of the coupling.
pub const COAXLE_JOB_ABORTED: u32 = 5;
/// Refused or failed.
pub const COAXLE_JOB_FAILED: u32 = 6;

/// A slave axis: commands in, set values out within its limits, whatever its masters do.
///
/// Each cycle: `coaxle_slave_update` with the masters, then the set values to the drive.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_slave {
    head: HandleHead,
    axis: SlaveAxis,
    drive: Arc<DriveCells>,
    /// Newest jobs by their numbers: `SlaveAxis` compares them whole.
    jobs: [Option<Job>; KEPT_JOBS],
    next_job: usize,
}

/// Jobs whose state can be read: no more than the axis keeps.
const KEPT_JOBS: usize = 16;

handle!(coaxle_slave, b"slaveaxi");

/// Makes a slave axis without power, at its drive's position, 0.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_new(
    parameters: *const coaxle_slave_parameters,
    out: *mut *mut coaxle_slave,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || {
            let (axis, drive) = read(parameters)?.axis()?;
            Ok(coaxle_slave {
                head: HandleHead::new::<coaxle_slave>(),
                axis,
                drive,
                jobs: [None; KEPT_JOBS],
                next_job: 0,
            })
        })
    }
}

/// Frees a slave axis; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_free(slave: *mut coaxle_slave) {
    // SAFETY: as for this function.
    unsafe { free(slave) }
}

/// Runs one cycle, `elapsed_s` after the one before, with `number` masters (0 to 4). `tables` is `NULL` for an axis without cam plates,
/// otherwise always the same. `out` may be `NULL`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_update(
    slave: *mut coaxle_slave,
    tables: *mut coaxle_tables,
    masters: *const coaxle_master,
    number: usize,
    elapsed_s: f64,
    out: *mut coaxle_slave_state,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_tables(slave, tables, |slave, tables| {
            let masters = readable_array(masters, number, "masters")?;
            if masters.len() > COAXLE_MOST_MASTERS {
                return Err(Failure::range("number", masters.len(), "0 to 4 masters"));
            }
            if !(elapsed_s > 0.0 && elapsed_s.is_finite()) {
                let expected = "a finite number above 0";
                return Err(Failure::range("elapsed_s", elapsed_s, expected));
            }
            check_if_any(out)?;
            let masters = Masters::of(masters.iter().map(coaxle_master::set_values));
            let _ = (slave.axis).update(tables, masters, Seconds(elapsed_s));
            write_if_any(out, &slave.state())
        })
    }
}

/// Passes out set values and state as of the newest cycle.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_read(
    slave: *mut coaxle_slave,
    out: *mut coaxle_slave_state,
) -> i32 {
    // SAFETY: as for this function.
    unsafe { call(slave, |slave| write(out, &slave.state())) }
}

/// Plans a command without executing it: 0 if it would be accepted now, otherwise why not.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_plan(
    slave: *mut coaxle_slave,
    tables: *mut coaxle_tables,
    command: *const coaxle_command,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_tables(slave, tables, |slave, tables| {
            let plan = slave.axis.plan(tables, &taken(command)?);
            plan.map(drop).map_err(|refusal| refused(&refusal))
        })
    }
}

/// Executes a command, which takes effect with the next cycle. Passes out the number of its job, 0 for one that is done at once; `job`
/// may be `NULL`.
///
/// # Errors
/// The NC code of the refusal; the axis is unchanged then.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_execute(
    slave: *mut coaxle_slave,
    tables: *mut coaxle_tables,
    command: *const coaxle_command,
    job: *mut u32,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_tables(slave, tables, |slave, tables| {
            let command = taken(command)?;
            let job = writable_if_any(job, "job")?;
            let change = slave.axis.plan(tables, &command);
            let change = change.map_err(|refusal| refused(&refusal))?;
            let accepted = slave.axis.apply(tables, change, Origin::Order);
            slave.note_job(accepted);
            if let Some(job) = job {
                *job = accepted.number;
            }
            Ok(())
        })
    }
}

/// Passes out the state of a job, `COAXLE_JOB_NONE` to `COAXLE_JOB_FAILED`, and for a failed one its NC code in `error`, which may be
/// `NULL`. The newest 16 jobs are known.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_job(
    slave: *mut coaxle_slave,
    job: u32,
    state: *mut u32,
    error: *mut u32,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(slave, |slave| {
            let known = slave
                .jobs
                .iter()
                .flatten()
                .find(|known| known.number == job);
            let progress = match (job, known) {
                (0, _) => CommandState::Done,
                (_, Some(known)) => slave.axis.progress(*known),
                (_, None) => CommandState::Idle,
            };
            *writable(state, "state")? = job_state(&progress);
            if let Some(error) = writable_if_any(error, "error")? {
                *error = match &progress {
                    CommandState::Failed(why) => why.code(),
                    _ => 0,
                };
            }
            Ok(())
        })
    }
}

/// Takes the actual values of the caller's drive, for the next cycle.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_report_actual(
    slave: *mut coaxle_slave,
    actual: *const coaxle_actual,
) -> i32 {
    // SAFETY: as for this function.
    unsafe { call(slave, |slave| slave.drive.report(&read(actual)?)) }
}

/// Passes out the axis structure as it is published in frames, with this axis id.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_axis_struct(
    slave: *mut coaxle_slave,
    tables: *mut coaxle_tables,
    axis_id: u32,
    out: *mut coaxle_axis,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        with_tables(slave, tables, |slave, tables| {
            *writable(out, "out")? = coaxle_axis::of(&slave.axis.axis_struct(tables, axis_id));
            Ok(())
        })
    }
}

/// Passes out the 31 characteristic values of the current or last flying saw (`MC_ReadFlyingSawCharacteristics`), in the order of
/// `MC_FlyingSawCharacValues` (TS5055 12.3.2). `values` has 31 places.
///
/// # Errors
/// `COAXLE_NOT_THERE` if there was none.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_slave_saw_characteristics(
    slave: *mut coaxle_slave,
    values: *mut f64,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(slave, |slave| {
            let out = writable(values.cast::<[f64; 31]>(), "values")?;
            let none = || Failure::new(COAXLE_NOT_THERE, "the axis has had no flying saw");
            let plan = slave.axis.saw_plan().ok_or_else(none)?;
            // The id of its table is none of the values.
            *out = plan.characteristics(0).values();
            Ok(())
        })
    }
}

/// Runs a function of an axis with its plates.
///
/// # Safety
/// As for [`call`], for both handles.
unsafe fn with_tables(
    slave: *mut coaxle_slave,
    tables: *mut coaxle_tables,
    body: impl FnOnce(&mut coaxle_slave, &mut Tables) -> Result<(), Failure>,
) -> i32 {
    if tables.is_null() {
        // SAFETY: as for this function.
        return unsafe {
            // A store without places allocates nothing, and nothing of it changes.
            call(slave, |slave| body(slave, &mut Tables::new(0)))
        };
    }
    let mut of_slave = 0;
    // SAFETY: as for this function.
    let of_tables = unsafe {
        call(tables, |store| {
            of_slave = call(slave, |slave| body(slave, &mut store.tables));
            Ok(())
        })
    };
    if of_tables == COAXLE_OK {
        of_slave
    } else {
        of_tables
    }
}

fn refused(refusal: &Refusal) -> Failure {
    Failure::of_nc(refusal.code(), refusal)
}

const fn job_state(progress: &JobState) -> u32 {
    match progress {
        CommandState::Idle => COAXLE_JOB_NONE,
        CommandState::Waiting => COAXLE_JOB_WAITING,
        CommandState::Active => COAXLE_JOB_ACTIVE,
        CommandState::InSync => COAXLE_JOB_IN_SYNC,
        CommandState::Done => COAXLE_JOB_DONE,
        CommandState::Aborted => COAXLE_JOB_ABORTED,
        CommandState::Failed(JobError::Refused(_) | JobError::Failed(_)) => COAXLE_JOB_FAILED,
    }
}

impl coaxle_slave {
    fn state(&self) -> coaxle_slave_state {
        coaxle_slave_state::of(&self.axis, self.drive.wants_power())
    }

    fn note_job(&mut self, job: Job) {
        if job.number != 0 {
            self.jobs[self.next_job] = Some(job);
            self.next_job = (self.next_job + 1) % KEPT_JOBS;
        }
    }
}
