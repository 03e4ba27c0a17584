//! The own cycle, locked to a far one: [`CycleLock`].

use coaxle_clock::cycle_lock::CycleLockState;
use coaxle_clock::{CycleLock, Span};

use crate::failure::Failure;
use crate::handle::{HandleHead, call, free, handle, make};
use crate::memory::{read, writable, writable_if_any};
use crate::phase::{coaxle_far_phase, cycle_time};

/// The far clock is not known yet: nothing moves.
pub const COAXLE_LOCK_WAITING: u32 = 0;
/// The deadlines are led to the far cycle.
pub const COAXLE_LOCK_LOCKING: u32 = 1;
/// The deadlines follow it.
pub const COAXLE_LOCK_LOCKED: u32 = 2;
/// The far clock is not known any more: the period stays what it was.
pub const COAXLE_LOCK_HOLDOVER: u32 = 3;
/// The cycle times are no multiples of each other, or the clocks drift by too much: nothing moves.
pub const COAXLE_LOCK_REFUSED: u32 = 4;

/// The regulator of a periodic thread: its deadlines follow a far cycle, a constant time behind.
///
/// Suitable for every phase measured in each cycle, such as that of the distributed clock of an EtherCAT network.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_cycle_lock {
    head: HandleHead,
    lock: CycleLock,
}

handle!(coaxle_cycle_lock, b"cyclelok");

/// Makes the lock of a thread with this nominal cycle time, ns, whose cycles are to begin `offset_ns` after the messages have
/// arrived.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_cycle_lock_new(
    cycle_time_ns: i64,
    offset_ns: i64,
    out: *mut *mut coaxle_cycle_lock,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || {
            let cycle = cycle_time(cycle_time_ns)?;
            if !(0..cycle.span().as_nanos()).contains(&offset_ns) {
                let expected = format_args!("0 up to less than the cycle time, {cycle_time_ns}");
                return Err(Failure::range("offset_ns", offset_ns, expected));
            }
            Ok(coaxle_cycle_lock {
                head: HandleHead::new::<coaxle_cycle_lock>(),
                lock: CycleLock::new(cycle, Span::from_nanos(offset_ns)),
            })
        })
    }
}

/// Frees a lock; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_cycle_lock_free(lock: *mut coaxle_cycle_lock) {
    // SAFETY: as for this function.
    unsafe { free(lock) }
}

/// Takes the phase at the start of a cycle, `elapsed` cycles after the one before, and passes out by how many ns the next deadline is
/// to be moved. `phase` is `NULL` while the far clock is not known.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_cycle_lock_advance(
    lock: *mut coaxle_cycle_lock,
    phase: *const coaxle_far_phase,
    elapsed: u32,
    moved_ns: *mut i64,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(lock, |own| {
            let moved_ns = writable(moved_ns, "moved_ns")?;
            let phase = match phase.is_null() {
                true => None,
                false => Some(read(phase)?.checked()?),
            };
            *moved_ns = own.lock.advance(phase.as_ref(), elapsed).as_nanos();
            Ok(())
        })
    }
}

/// Passes out the state of a lock, the time by which the newest cycle began later than wanted (s; not a number while the far clock is
/// not known) and the change of the period (ppm). Each of the three may be `NULL`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_cycle_lock_state(
    lock: *mut coaxle_cycle_lock,
    state: *mut u32,
    phase_s: *mut f64,
    period_ppm: *mut f64,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(lock, |own| {
            if let Some(state) = writable_if_any(state, "state")? {
                *state = match own.lock.state() {
                    CycleLockState::Waiting => COAXLE_LOCK_WAITING,
                    CycleLockState::Locking => COAXLE_LOCK_LOCKING,
                    CycleLockState::Locked => COAXLE_LOCK_LOCKED,
                    CycleLockState::Holdover => COAXLE_LOCK_HOLDOVER,
                    CycleLockState::Refused => COAXLE_LOCK_REFUSED,
                };
            }
            if let Some(phase_s) = writable_if_any(phase_s, "phase_s")? {
                *phase_s = own.lock.phase().map_or(f64::NAN, |of| of.0);
            }
            if let Some(period_ppm) = writable_if_any(period_ppm, "period_ppm")? {
                *period_ppm = own.lock.period_ppm();
            }
            Ok(())
        })
    }
}
