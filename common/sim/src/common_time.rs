//! The time that nodes have in common: true time, with the faults of each node.

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::beacon::CommonStamp;
use coaxle_node::config::{ClockConfig, CommonTimeConfig, GrandmasterId, StatedBy};
use coaxle_node::faults::FaultyCommonTime;

use crate::true_time::True;

/// TAI at true time 0: in the year 2027. Its size is that of a real one, which a float does not hold to the nanosecond.
const TAI_AT_START: Span = Span::from_secs(1_800_000_037);
/// Grandmaster of the services of all nodes.
const GRANDMASTER: u64 = 0x0000_5eff_fe00_0001;

/// Common time as one node reads it.
pub(crate) struct SimulatedCommonTime {
    bound: Span,
    grandmaster: GrandmasterId,
    faults: FaultyCommonTime,
}

impl SimulatedCommonTime {
    pub(crate) fn new(config: &CommonTimeConfig, clock: &ClockConfig, seed: u64) -> Self {
        Self {
            bound: config.bound_us.span(),
            grandmaster: match config.stated_by {
                StatedBy::Service => GRANDMASTER.into(),
                StatedBy::Config(grandmaster) => grandmaster,
            },
            faults: FaultyCommonTime::new(&clock.common_time, seed),
        }
    }

    /// Reads it where the node's own clock shows `local`; none while it is lost.
    pub(crate) fn read(
        &mut self,
        now: Instant<True>,
        local: Instant<Local>,
    ) -> Option<CommonStamp> {
        let since = now.since_epoch();
        let stamp = CommonStamp {
            at_ns: local.as_nanos(),
            time_ns: (TAI_AT_START + since).as_nanos(),
            // A common time is off by 100 ms at most.
            bound_ns: self.bound.as_nanos() as u32,
            grandmaster: self.grandmaster.number(),
        };
        self.faults.applied(since, stamp)
    }
}
