//! A far clock: [`FarClock`].

use coaxle_clock::cycle_lock::FarPhase;
use coaxle_clock::delay::{DelayState, TimeResponse};
use coaxle_clock::far_clock::{DelaySource, FarClock, FarClockOutput};
use coaxle_clock::observer::{ObserverParameters, ObserverState};
use coaxle_clock::{Instant, Seconds, Span};

use crate::common_time::coaxle_common_time;
use crate::failure::{COAXLE_NOT_THERE, Failure, wrong_parameter};
use crate::handle::{HandleHead, call, free, handle, make};
use crate::memory::{check_if_any, growing, read, readable, writable, write, write_if_any};
use crate::phase::{coaxle_far_phase, cycle_time};

/// The delay of messages is not compensated: far time lags by it.
pub const COAXLE_DELAY_OFF: u32 = 0;
/// The delay is `delay_ns`.
pub const COAXLE_DELAY_FIXED: u32 = 1;
/// The delay is measured by requests and responses.
pub const COAXLE_DELAY_MEASURED: u32 = 2;

/// Too few messages to say anything.
pub const COAXLE_STARTUP: u32 = 0;
/// There is a far time that may still move fast.
pub const COAXLE_LOCKING: u32 = 1;
/// The far time is sure.
pub const COAXLE_SYNCED: u32 = 2;
/// The far time was sure, and is uncertain now.
pub const COAXLE_UNSURE: u32 = 3;
/// No messages lately: it goes on by the last estimate.
pub const COAXLE_HOLDOVER: u32 = 4;
/// No messages for too long.
pub const COAXLE_LOST: u32 = 5;

/// A far clock that is followed: messages in, far time out at any instant of the own clock.
///
/// Each cycle: `coaxle_far_clock_message` and `coaxle_far_clock_response` for what has arrived, then
/// `coaxle_far_clock_cycle`, then `coaxle_far_clock_request`.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_far_clock {
    head: HandleHead,
    clock: FarClock,
}

handle!(coaxle_far_clock, b"farclock");

/// Parameters of a far clock.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_far_clock_parameters {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_DELAY_OFF`, `COAXLE_DELAY_FIXED` or `COAXLE_DELAY_MEASURED`.
    pub delay_source: u32,
    /// Nominal cycle time of the far node, ns: 100 000 to 100 000 000.
    pub cycle_time_ns: i64,
    /// A fixed delay, ns: within a second, forwards and backwards.
    pub delay_ns: i64,
    /// Number of this run of the own node, which its requests carry: random, say.
    pub run: u64,
}

/// A message of the far node.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_message {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// Other than 0 if `send_stamp_ns` is stated.
    pub has_send_stamp: u32,
    /// Run of the far node: another one is another clock.
    pub epoch: u64,
    /// Cycle count of the far node.
    pub count: u64,
    /// Arrival, ns of the own clock.
    pub arrived_ns: i64,
    /// Departure after the ideal start of its cycle, ns of the far clock.
    pub send_stamp_ns: i64,
}

/// A response to a request of the own node, or an exchange of a timing channel. It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_time_response {
    /// Run of the own node.
    pub run: u64,
    /// Run of the far node.
    pub epoch: u64,
    /// Departure of the request, ns of the own clock.
    pub requested_ns: i64,
    /// Arrival of the request, ns of the far clock since the ideal start of its cycle 0.
    pub received_ns: i64,
    /// Departure of the response, likewise.
    pub responded_ns: i64,
    /// Number of the request.
    pub number: u32,
    /// 0.
    pub reserved: u32,
}

/// Far time, and what is known about it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_far_time {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_STARTUP` to `COAXLE_LOST`.
    pub state: u32,
    /// Other than 0 if there is a far time.
    pub is_known: u32,
    /// Other than 0 if far time is sure, or was and goes on as it did.
    pub is_sure: u32,
    /// Far time, ns since the ideal start of the far node's cycle 0.
    pub time_ns: i64,
    /// Rest beyond whole nanoseconds, ns: 0 to below 1.
    pub fraction_ns: f64,
    /// Greatest error as far as is known, s.
    pub uncertainty_s: f64,
    /// Rate of the far clock against the own one, ppm.
    pub drift_ppm: f64,
    /// Standard deviation of the drift, ppm.
    pub drift_sigma_ppm: f64,
    /// Standard deviation of the estimated offset, s.
    pub offset_sigma_s: f64,
    /// Delay in use, s; not a number without one.
    pub delay_s: f64,
    /// Greatest error of the delay, s; not a number if it is not measured.
    pub delay_uncertainty_s: f64,
}

growing! {
    coaxle_far_clock_parameters, 32;
    coaxle_message, 40;
    coaxle_far_time, 80;
}

/// Makes a far clock, and passes it out in `out`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_new(
    parameters: *const coaxle_far_clock_parameters,
    out: *mut *mut coaxle_far_clock,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || {
            let given = read(parameters)?;
            let cycle_time = cycle_time(given.cycle_time_ns)?;
            let delay = delay_source(&given)?;
            FarClock::new(cycle_time, ObserverParameters::default(), delay, given.run)
                .map(|clock| coaxle_far_clock {
                    head: HandleHead::new::<coaxle_far_clock>(),
                    clock,
                })
                .map_err(wrong_parameter)
        })
    }
}

/// Frees a far clock; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_free(clock: *mut coaxle_far_clock) {
    // SAFETY: as for this function.
    unsafe { free(clock) }
}

/// Takes a message of the far node. The order of arrival is the order of the calls.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_message(
    clock: *mut coaxle_far_clock,
    message: *const coaxle_message,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(clock, |far| {
            let message = read(message)?;
            let stamp = Span::from_nanos(message.send_stamp_ns);
            let stamp = (message.has_send_stamp != 0).then_some(stamp);
            let arrived = Instant::from_nanos(message.arrived_ns);
            (far.clock).message(message.epoch, message.count, arrived, stamp);
            Ok(())
        })
    }
}

/// Takes a response that arrived at `arrived_ns` of the own clock.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_response(
    clock: *mut coaxle_far_clock,
    arrived_ns: i64,
    response: *const coaxle_time_response,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(clock, |far| {
            let response = readable(response, "response")?.taken();
            far.clock
                .response(Instant::from_nanos(arrived_ns), &response);
            Ok(())
        })
    }
}

/// Takes an exchange of a timing channel, whose response arrived at `arrived_ns`: all stamps were taken near to the wire.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_timing_exchange(
    clock: *mut coaxle_far_clock,
    arrived_ns: i64,
    exchange: *const coaxle_time_response,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(clock, |far| {
            let exchange = readable(exchange, "exchange")?.taken();
            (far.clock).timing_exchange(Instant::from_nanos(arrived_ns), &exchange);
            Ok(())
        })
    }
}

/// Takes readings of a time that both nodes have in common.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_common_time(
    clock: *mut coaxle_far_clock,
    readings: *const coaxle_common_time,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(clock, |far| {
            let given = read(readings)?.checked()?;
            (far.clock).common_time(given.here, given.own, given.there);
            Ok(())
        })
    }
}

/// Runs the cycle whose ideal start is `now_ns` of the own clock, with all messages up to then. `out` may be `NULL`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_cycle(
    clock: *mut coaxle_far_clock,
    now_ns: i64,
    out: *mut coaxle_far_time,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(clock, |far| {
            check_if_any(out)?;
            let now = Instant::from_nanos(now_ns);
            let _ = far.clock.cycle(now, |_, _| {});
            write_if_any(out, &reading(&far.clock, now_ns))
        })
    }
}

/// Passes out far time at the instant `at_ns` of the own clock, extrapolated from the newest cycle.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_time_at(
    clock: *mut coaxle_far_clock,
    at_ns: i64,
    out: *mut coaxle_far_time,
) -> i32 {
    // SAFETY: as for this function.
    unsafe { call(clock, |far| write(out, &reading(&far.clock, at_ns))) }
}

/// Passes out whether a request is due in the cycle that begins at `now_ns` of the own clock: other than 0 in `is_due`, then its
/// number in `number`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_request(
    clock: *mut coaxle_far_clock,
    now_ns: i64,
    is_due: *mut u32,
    number: *mut u32,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(clock, |far| {
            // Looked at first: a request that nobody learns of would be missed.
            let (is_due, number) = (writable(is_due, "is_due")?, writable(number, "number")?);
            let due = far.clock.request(Instant::from_nanos(now_ns));
            *is_due = due.is_some().into();
            *number = due.unwrap_or(0);
            Ok(())
        })
    }
}

/// Passes out the shift in time, s, that makes message number `count` what the far node would have sent at the newest cycle.
///
/// # Errors
/// `COAXLE_NOT_THERE` while far time is not sure.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_correction(
    clock: *mut coaxle_far_clock,
    count: u64,
    out: *mut f64,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(clock, |far| {
            *writable(out, "out")? = correction(&far.clock, count)?.0;
            Ok(())
        })
    }
}

/// Passes out the far cycle in relation to the own one, for a cycle lock: `count` is that of the newest message.
///
/// # Errors
/// `COAXLE_NOT_THERE` while far time is not sure, or is being moved: a lock goes on without a phase then.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_clock_phase(
    clock: *mut coaxle_far_clock,
    count: u64,
    cycle_time_ns: i64,
    out: *mut coaxle_far_phase,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(clock, |far| {
            let age = correction(&far.clock, count)?;
            let phase = (far.clock.newest())
                .and_then(|newest| FarPhase::of(newest, age, cycle_time(cycle_time_ns).ok()?))
                .ok_or_else(|| Failure::new(COAXLE_NOT_THERE, "far time is being moved"))?;
            write(out, &coaxle_far_phase::of(&phase))
        })
    }
}

fn correction(clock: &FarClock, count: u64) -> Result<Seconds, Failure> {
    let sure = "far time is not sure";
    (clock.correction(count)).ok_or_else(|| Failure::new(COAXLE_NOT_THERE, sure))
}

fn delay_source(given: &coaxle_far_clock_parameters) -> Result<DelaySource, Failure> {
    let source = match given.delay_source {
        COAXLE_DELAY_OFF => DelaySource::Off,
        COAXLE_DELAY_FIXED => DelaySource::Fixed(Span::from_nanos(given.delay_ns)),
        COAXLE_DELAY_MEASURED => DelaySource::Measured,
        other => return Err(Failure::range("delay_source", other, "0, 1 or 2")),
    };
    if source.is_in_range() {
        Ok(source)
    } else {
        let expected = "-1000000000 to 1000000000";
        Err(Failure::range("delay_ns", given.delay_ns, expected))
    }
}

impl coaxle_time_response {
    const fn taken(&self) -> TimeResponse {
        TimeResponse {
            run: self.run,
            number: self.number,
            requested: Instant::from_nanos(self.requested_ns),
            epoch: self.epoch,
            received: Span::from_nanos(self.received_ns),
            responded: Span::from_nanos(self.responded_ns),
        }
    }

    pub(crate) const fn of(response: &TimeResponse) -> Self {
        Self {
            run: response.run,
            epoch: response.epoch,
            requested_ns: response.requested.as_nanos(),
            received_ns: response.received.as_nanos(),
            responded_ns: response.responded.as_nanos(),
            number: response.number,
            reserved: 0,
        }
    }
}

/// Far time at an instant of the own clock.
fn reading(clock: &FarClock, at_ns: i64) -> coaxle_far_time {
    const NONE: f64 = f64::NAN;
    let FarClockOutput {
        observer,
        delay,
        is_sure,
        ..
    } = clock.newest().copied().unwrap_or_default();
    let far = clock.far_time_at(Instant::from_nanos(at_ns));
    let time = far.map(|far| far.time);
    let is_measured = matches!(delay.state, DelayState::Measured | DelayState::Stale);
    coaxle_far_time {
        struct_size: 0,
        state: match observer.state {
            ObserverState::Startup => COAXLE_STARTUP,
            ObserverState::Locking => COAXLE_LOCKING,
            ObserverState::Synced => COAXLE_SYNCED,
            ObserverState::Unsure => COAXLE_UNSURE,
            ObserverState::Holdover => COAXLE_HOLDOVER,
            ObserverState::Lost => COAXLE_LOST,
        },
        is_known: far.is_some().into(),
        is_sure: is_sure.into(),
        time_ns: time.map_or(0, |time| time.instant.as_nanos()),
        fraction_ns: time.map_or(0.0, |time| time.fraction_ns),
        uncertainty_s: far.map_or(NONE, |far| far.uncertainty.0),
        drift_ppm: observer.drift_ppm,
        drift_sigma_ppm: observer.drift_sigma_ppm,
        offset_sigma_s: observer.offset_sigma.0,
        delay_s: delay.delay.map_or(NONE, |delay| delay.0),
        delay_uncertainty_s: (delay.uncertainty.filter(|_| is_measured)).map_or(NONE, |of| of.0),
    }
}
