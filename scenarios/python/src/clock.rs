//! A far clock, followed from arrivals.

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::far_clock::{DelaySource, FarClock as Clock};
use coaxle_clock::observer::{FarTime, ObserverParameters};
use coaxle_clock::{CycleTime, Instant, Span};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{told, wrong};

/// Follows one far clock: pass arrivals to `message` and `response`, then call `cycle`, then `request`.
#[pyclass(module = "coaxle")]
pub(crate) struct FarClock(Clock);

#[pymethods]
impl FarClock {
    /// The clock of a node with this nominal cycle time. The delay is off, fixed (s), or measured.
    #[new]
    #[pyo3(signature = (cycle_time_s, *, delay_s = None, measured = false, run = 1))]
    fn new(cycle_time_s: f64, delay_s: Option<f64>, measured: bool, run: u64) -> PyResult<Self> {
        let cycle_time = cycle_time(cycle_time_s)?;
        let delay = match (delay_s, measured) {
            (None, true) => DelaySource::Measured,
            (None, false) => DelaySource::Off,
            // A range test, which NaN fails.
            (Some(delay), false) if (0.0..=1.0).contains(&delay) => {
                DelaySource::Fixed(Span::from_secs_f64(delay))
            }
            (Some(delay), false) => {
                return Err(wrong(format!("delay_s: received {delay}, expected 0 to 1")));
            }
            (Some(_), true) => {
                return Err(wrong("received delay_s and measured, expected one of them"));
            }
        };
        let clock = Clock::new(cycle_time, ObserverParameters::default(), delay, run);
        clock
            .map(Self)
            .map_err(|wrong| told(anyhow::anyhow!("{wrong}")))
    }

    /// Message number `count` of the run `epoch` arrived at `at_ns`; it left `send_stamp_ns` after the ideal start of its
    /// cycle.
    #[pyo3(signature = (count, at_ns, *, epoch = 1, send_stamp_ns = None))]
    fn message(&mut self, count: u64, at_ns: i64, epoch: u64, send_stamp_ns: Option<i64>) {
        let stamp = send_stamp_ns.map(Span::from_nanos);
        self.0
            .message(epoch, count, Instant::from_nanos(at_ns), stamp);
    }

    /// A response to request `number` of this run arrived at `at_ns`: sent at t1 of the own clock, received at t2 of the far
    /// one, counted from its cycle 0, responded at t3 of that; all ns.
    #[expect(clippy::too_many_arguments, reason = "an exchange has so many stamps")]
    #[pyo3(signature = (at_ns, number, t1_ns, t2_ns, t3_ns, *, epoch = 1, run = 1))]
    fn response(
        &mut self,
        at_ns: i64,
        number: u32,
        t1_ns: i64,
        t2_ns: i64,
        t3_ns: i64,
        epoch: u64,
        run: u64,
    ) {
        let response = TimeResponse {
            epoch,
            run,
            number,
            requested: Instant::from_nanos(t1_ns),
            received: Span::from_nanos(t2_ns),
            responded: Span::from_nanos(t3_ns),
        };
        self.0.response(Instant::from_nanos(at_ns), &response);
    }

    /// The number of the request that is due in the cycle that begins at `now_ns`, if one is.
    fn request(&mut self, now_ns: i64) -> Option<u32> {
        self.0.request(Instant::from_nanos(now_ns))
    }

    /// Runs the cycle whose ideal start is `now_ns`, with all messages up to then. Returns the state of the far clock.
    fn cycle<'py>(&mut self, py: Python<'py>, now_ns: i64) -> PyResult<Bound<'py, PyDict>> {
        // Nothing is recorded here: arrivals have been passed by the caller.
        let output = self.0.cycle(Instant::from_nanos(now_ns), |_, _| {});
        let known = PyDict::new(py);
        let far = output.observer.far_time.map(nanos);
        known.set_item("far_time_ns", far)?;
        known.set_item("is_sure", output.is_sure)?;
        known.set_item("drift_ppm", output.observer.drift_ppm)?;
        known.set_item("drift_sigma_ppm", output.observer.drift_sigma_ppm)?;
        known.set_item("offset_sigma_s", output.observer.offset_sigma.0)?;
        known.set_item("delay_s", output.delay.delay.map(|delay| delay.0))?;
        Ok(known)
    }

    /// Far time at `at_ns` of the own clock, ns, and its uncertainty, s; none before the clock is
    /// known.
    fn far_time_at(&self, at_ns: i64) -> Option<(i64, f64)> {
        let reading = self.0.far_time_at(Instant::from_nanos(at_ns))?;
        Some((nanos(reading.time), reading.uncertainty.0))
    }

    /// Correction that moves message number `count` to the newest cycle, s; none as long as it is not
    /// certain.
    fn correction_s(&self, count: u64) -> Option<f64> {
        self.0.correction(count).map(|correction| correction.0)
    }
}

/// Time since the ideal start of the far node's cycle 0, ns.
fn nanos(time: FarTime) -> i64 {
    // Rounded: Python gets whole nanoseconds, and the fraction is below one.
    time.instant.since_epoch().as_nanos() + i64::from(time.fraction_ns >= 0.5)
}

/// A cycle time in seconds.
pub(crate) fn cycle_time(seconds: f64) -> PyResult<CycleTime> {
    // Clamped far beyond all cycle times: seconds that nanoseconds of i64 cannot hold get the same refusal.
    let span = Span::from_secs_f64(seconds.clamp(-1e6, 1e6));
    CycleTime::new(span).map_err(|error| wrong(format!("cycle_time_s: {error}")))
}

/// Longest wait.
const LONGEST_S: f64 = 3600.0;

/// A time to wait.
pub(crate) fn span(field: &str, seconds: f64) -> PyResult<Span> {
    if (0.0..=LONGEST_S).contains(&seconds) {
        return Ok(Span::from_secs_f64(seconds));
    }
    Err(wrong(format!(
        "{field}: received {seconds}, expected 0 to {LONGEST_S} s"
    )))
}
