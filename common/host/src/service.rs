//! What the service manager is told, in systemd's protocol: that the node runs, that its cycle still does, and that it
//! ends. Where no manager listens (`NOTIFY_SOCKET`) nothing is told.

use std::convert::Infallible;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

use sd_notify::NotifyState;

use crate::counters::read;

/// A watchdog is fed so many times in its time.
const MEALS: u32 = 3;

/// The service that this process is.
pub(crate) struct Service {
    /// The manager ends it when it is not fed for so long.
    watchdog: Option<Duration>,
    pulse: Pulse,
}

impl Service {
    /// From now on the node runs.
    pub(crate) fn ready() -> Self {
        tell(NotifyState::Ready);
        Self {
            watchdog: sd_notify::watchdog_enabled(),
            pulse: Pulse::default(),
        }
    }

    /// Feeds the watchdog, if there is one, for as long as `cycles` goes on.
    pub(crate) async fn feed_watchdog(&mut self, cycles: &AtomicU64) -> Infallible {
        let Some(watchdog) = self.watchdog else {
            return std::future::pending().await;
        };
        loop {
            if self.pulse.beats(read(cycles)) {
                tell(NotifyState::Watchdog);
            }
            tokio::time::sleep(watchdog / MEALS).await;
        }
    }

    /// From now on the node ends.
    pub(crate) fn stopping(&self) {
        tell(NotifyState::Stopping);
    }
}

fn tell(state: NotifyState<'_>) {
    if let Err(error) = sd_notify::notify(&[state]) {
        tracing::debug!(%error, "the service manager cannot be told");
    }
}

/// Whether something that counts still does.
#[derive(Default)]
struct Pulse {
    last: Option<u64>,
}

impl Pulse {
    fn beats(&mut self, count: u64) -> bool {
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
        assert_eq!(seen, [true, true, false, false, true, false]);
    }
}
