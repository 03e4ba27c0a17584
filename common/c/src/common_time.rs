//! Readings of a time that two nodes have in common.

use coaxle_clock::common_time::{CommonReading, FarCommonReading};
use coaxle_clock::{Instant, Local, Span};

use crate::failure::Failure;
use crate::memory::growing;

/// Readings of a time that both nodes have in common (PTP, TAI), in one exchange.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_common_time {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// 1: there is an own reading, 2: there is one of the far node, 3: both.
    pub readings: u32,
    /// Own clock at the own reading, ns.
    pub here_ns: i64,
    /// Common time that was read here, ns.
    pub own_time_ns: i64,
    /// Greatest error of that time against the grandmaster, ns.
    pub own_bound_ns: i64,
    /// Identity of the grandmaster.
    pub own_grandmaster: u64,
    /// Run of the far node.
    pub epoch: u64,
    /// Far clock at the far reading, ns since the ideal start of its cycle 0.
    pub there_ns: i64,
    /// Common time that was read there, ns.
    pub far_time_ns: i64,
    /// Greatest error of that time against the grandmaster, ns.
    pub far_bound_ns: i64,
    /// Identity of the grandmaster.
    pub far_grandmaster: u64,
}

growing! {
    coaxle_common_time, 80;
}

/// Readings, as the clock takes them.
pub(crate) struct Readings {
    pub(crate) here: Instant<Local>,
    pub(crate) own: Option<CommonReading>,
    pub(crate) there: Option<FarCommonReading>,
}

impl coaxle_common_time {
    pub(crate) fn checked(&self) -> Result<Readings, Failure> {
        let own = CommonReading {
            time: Instant::from_nanos(self.own_time_ns),
            bound: bound("own_bound_ns", self.own_bound_ns)?,
            grandmaster: self.own_grandmaster,
        };
        let there = FarCommonReading {
            epoch: self.epoch,
            at: Span::from_nanos(self.there_ns),
            common: CommonReading {
                time: Instant::from_nanos(self.far_time_ns),
                bound: bound("far_bound_ns", self.far_bound_ns)?,
                grandmaster: self.far_grandmaster,
            },
        };
        if self.readings > 3 {
            return Err(Failure::range("readings", self.readings, "0 to 3"));
        }
        Ok(Readings {
            here: Instant::from_nanos(self.here_ns),
            own: (self.readings & 1 != 0).then_some(own),
            there: (self.readings & 2 != 0).then_some(there),
        })
    }
}

fn bound(field: &str, nanos: i64) -> Result<Span, Failure> {
    match nanos {
        0.. => Ok(Span::from_nanos(nanos)),
        _ => Err(Failure::range(field, nanos, "at least 0")),
    }
}
