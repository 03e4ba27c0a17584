//! Real-time settings that the cycle thread requests from the operating system.

use std::fmt;
use std::sync::OnceLock;

use coaxle_node::config::RealTimeConfig;
use coaxle_os::{Os, System};

/// A setting that the operating system did not grant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Denied {
    /// The setting, in the words of the config.
    pub wish: String,
    /// Reason for the denial, and a remedy.
    pub reason: String,
}

/// Denied settings, known once the cycle runs.
pub(crate) type Outcome = OnceLock<Vec<Denied>>;

impl fmt::Display for Denied {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} not granted: {}", self.wish, self.reason)
    }
}

/// Applies the settings to the calling thread, and the memory lock to the whole process. Settings
/// that are not permitted are skipped and returned.
#[must_use]
pub fn apply(config: &RealTimeConfig) -> Vec<Denied> {
    let wishes = [
        // Always requested: the kernel may otherwise bundle wake-ups within 50 µs.
        Some(("a timer slack of 1 ns".to_owned(), Os::tighten_timers())),
        config
            .priority
            .map(|priority| (format!("priority = {priority}"), Os::set_priority(priority))),
        config
            .cpu
            .map(|cpu| (format!("cpu = {cpu}"), Os::bind_to(cpu))),
        config
            .lock_memory
            .then(|| ("lock-memory = true".to_owned(), Os::lock_memory())),
    ];
    wishes
        .into_iter()
        .flatten()
        .filter_map(|(wish, outcome)| outcome.err().map(|reason| Denied { wish, reason }))
        .collect()
}

/// Priority of the threads that carry frames for a cycle of this priority: one below it, so that a
/// flood of messages never holds up the cycle, and no ordinary thread holds up the messages.
#[must_use]
pub fn carriers(config: &RealTimeConfig) -> Option<u8> {
    config
        .priority
        // 1 is the lowest real-time priority: 0 would be refused by the kernel.
        .map(|priority| priority.saturating_sub(1).max(1))
}

/// Sets the priority of the calling thread; returns true if permitted. A denial is reported by the
/// cycle, which requests a higher one.
pub(crate) fn raise(priority: Option<u8>) -> bool {
    priority.is_some_and(|priority| Os::set_priority(priority).is_ok())
}

/// Sets the priority of the calling thread until the result is dropped. Threads started meanwhile
/// inherit and keep it, and so do the threads that the transport starts.
pub(crate) fn raised(priority: Option<u8>) -> Raised {
    Raised {
        is_raised: raise(priority),
    }
}

/// Guard of the raised priority of the calling thread.
pub(crate) struct Raised {
    is_raised: bool,
}

impl Drop for Raised {
    fn drop(&mut self) {
        if self.is_raised
            && let Err(reason) = Os::drop_priority()
        {
            // A thread that cannot go back keeps its priority for the run, which may starve others: the log says so.
            tracing::warn!("the main thread keeps its real-time priority: {reason}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a thread of its own: affinity and priority must not leak into other tests.
    fn applied(config: RealTimeConfig) -> Vec<Denied> {
        std::thread::spawn(move || apply(&config)).join().unwrap()
    }

    #[test]
    fn no_wishes_are_all_granted() {
        assert_eq!(applied(RealTimeConfig::default()), []);
    }

    #[test]
    fn impossible_wishes_are_named_with_the_reason() {
        let denied = applied(RealTimeConfig {
            priority: Some(0),
            cpu: Some(1_000_000),
            ..RealTimeConfig::default()
        });
        let lines: Vec<_> = denied
            .iter()
            .map(|denied| format!("{}: {}", denied.wish, denied.reason))
            .collect();
        assert_eq!(
            lines,
            [
                // `sched_setscheduler` takes 1 to 99 for SCHED_FIFO; a mask of processors has 1024 bits.
                "priority = 0: received 0, expected 1 to 99",
                "cpu = 1000000: received 1000000, expected 0 to 1023",
            ]
        );
    }
}
