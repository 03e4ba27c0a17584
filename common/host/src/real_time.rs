//! What the cycle thread asks of the operating system.

use std::num::NonZeroU64;

use coaxle_node::config::RealTimeConfig;
use rustix::io::Errno;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_setaffinity, set_current_timer_slack};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// A wish the operating system did not grant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Denied {
    /// What was wished for, in the words of the config.
    pub wish: String,
    /// Why it was not granted, and what would help.
    pub reason: String,
}

/// Applies the wishes to the calling thread, and the memory lock to the whole process. What is
/// not permitted is left out and returned.
#[must_use]
pub fn apply(config: &RealTimeConfig) -> Vec<Denied> {
    let wishes = [
        // Wished for always: the kernel may otherwise bundle wake-ups within 50 µs.
        Some(("a timer slack of 1 ns".to_owned(), tight_timers())),
        config
            .priority
            .map(|priority| (format!("priority = {priority}"), fifo(priority))),
        config.cpu.map(|cpu| (format!("cpu = {cpu}"), bind_to(cpu))),
        config
            .lock_memory
            .then(|| ("lock-memory = true".to_owned(), lock_memory())),
    ];
    wishes
        .into_iter()
        .flatten()
        .filter_map(|(wish, outcome)| outcome.err().map(|reason| Denied { wish, reason }))
        .collect()
}

fn tight_timers() -> Result<(), String> {
    set_current_timer_slack(NonZeroU64::new(1)).map_err(|errno| errno.to_string())
}

fn fifo(priority: u8) -> Result<(), String> {
    let value = ThreadPriorityValue::try_from(priority)
        .ok()
        .filter(|_| (1..=99).contains(&priority))
        .ok_or_else(|| format!("received {priority}, expected 1 to 99"))?;
    set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Crossplatform(value),
        ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
    )
    .map_err(|error| match error {
        thread_priority::Error::OS(code) if code == Errno::PERM.raw_os_error() => {
            "not permitted: needs CAP_SYS_NICE, or an rtprio limit in /etc/security/limits.conf"
                .to_owned()
        }
        other => other.to_string(),
    })
}

fn bind_to(cpu: usize) -> Result<(), String> {
    if cpu >= CpuSet::MAX_CPU {
        return Err(format!(
            "received {cpu}, expected 0 to {}",
            CpuSet::MAX_CPU - 1
        ));
    }
    let mut set = CpuSet::new();
    set.set(cpu);
    sched_setaffinity(None, &set).map_err(|errno| match errno {
        Errno::INVAL => format!("this process may not run on processor {cpu}, or there is none"),
        other => other.to_string(),
    })
}

fn lock_memory() -> Result<(), String> {
    mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).map_err(|errno| match errno {
        Errno::PERM | Errno::NOMEM | Errno::AGAIN => {
            format!("{errno}: needs CAP_IPC_LOCK, or a higher memlock limit (ulimit -l)")
        }
        other => other.to_string(),
    })
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
                "priority = 0: received 0, expected 1 to 99",
                "cpu = 1000000: received 1000000, expected 0 to 1023",
            ]
        );
    }
}
