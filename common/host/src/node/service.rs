//! Notifications to the service manager: the node runs, its cycle is alive, the node ends.

use std::convert::Infallible;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

use coaxle_os::{Os, ServiceState, System};

use crate::node::counters::read;

/// Number of watchdog notifications within the watchdog time.
// Two of three may be late on a busy machine before the manager acts.
const NOTIFICATIONS_PER_TIMEOUT: u32 = 3;

/// The service manager's view of this process.
pub(crate) struct Service {
    /// Time without a notification after which the manager ends the process.
    watchdog: Option<Duration>,
    pulse: Pulse,
}

impl Service {
    /// Notifies that the node runs.
    pub(crate) fn ready() -> Self {
        tell(ServiceState::Ready);
        Self {
            watchdog: Os::watchdog(),
            pulse: Pulse::default(),
        }
    }

    /// Triggers the watchdog, if there is one, as long as `cycles` increases.
    pub(crate) async fn notify_watchdog(&mut self, cycles: &AtomicU64) -> Infallible {
        let Some(watchdog) = self.watchdog else {
            // Without a watchdog there is nothing to do, and the caller selects over this future.
            return std::future::pending().await;
        };
        loop {
            // Only while cycles advance: a hung cycle must not be kept alive by this task.
            if self.pulse.beats(read(cycles)) {
                tell(ServiceState::Alive);
            }
            tokio::time::sleep(watchdog / NOTIFICATIONS_PER_TIMEOUT).await;
        }
    }

    /// Notifies that the node ends.
    pub(crate) fn stopping(&self) {
        tell(ServiceState::Stopping);
    }
}

fn tell(state: ServiceState) {
    if let Err(error) = Os::notify_service_manager(state) {
        // Without a manager there is nobody to notify, and most runs have none.
        tracing::debug!(%error, "the service manager cannot be told");
    }
}

/// Detects whether a counter still increases.
#[derive(Default)]
struct Pulse {
    last: Option<u64>,
}

impl Pulse {
    fn beats(&mut self, count: u64) -> bool {
        // The first look beats at any count: the first cycle may not have run yet.
        self.last.replace(count) != Some(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cycle_that_stands_still_has_no_pulse() {
        let mut pulse = Pulse::default();
        let seen = [0, 3, 3, 3, 4, 4].map(|count| pulse.beats(count));
        // A count that stands still for one look costs one notification of three.
        assert_eq!(seen, [true, true, false, false, true, false]);
    }
}
