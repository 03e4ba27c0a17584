//! The far cycle in relation to the own one.

use coaxle_clock::cycle_lock::FarPhase;
use coaxle_clock::{CycleTime, Seconds, Span};

use crate::failure::Failure;
use crate::memory::{finite, growing};

/// A far cycle in relation to the own one, at the ideal start of an own cycle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_far_phase {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// Age of any message by the far clock, s.
    pub age_s: f64,
    /// Delay of messages as far as the far clock knows it, s; 0 for one that counts from arrivals.
    pub delay_s: f64,
    /// Drift of the far clock against the own one, ppm.
    pub drift_ppm: f64,
    /// Nominal cycle time of the far node, ns.
    pub cycle_time_ns: i64,
}

growing! {
    coaxle_far_phase, 40;
}

impl coaxle_far_phase {
    pub(crate) const fn of(phase: &FarPhase) -> Self {
        Self {
            struct_size: 0,
            reserved: 0,
            age_s: phase.age.0,
            delay_s: phase.delay.0,
            drift_ppm: phase.drift_ppm,
            cycle_time_ns: phase.cycle_time.span().as_nanos(),
        }
    }

    pub(crate) fn checked(&self) -> Result<FarPhase, Failure> {
        Ok(FarPhase {
            age: Seconds(finite("age_s", self.age_s)?),
            delay: Seconds(finite("delay_s", self.delay_s)?),
            drift_ppm: finite("drift_ppm", self.drift_ppm)?,
            cycle_time: cycle_time(self.cycle_time_ns)?,
        })
    }
}

/// Reads a nominal cycle time.
pub(crate) fn cycle_time(nanos: i64) -> Result<CycleTime, Failure> {
    CycleTime::new(Span::from_nanos(nanos))
        .map_err(|_| Failure::range("cycle_time_ns", nanos, "100000 to 100000000"))
}
