//! Threads: wake-ups and priorities.

use std::num::NonZeroU64;

use rustix::io::Errno;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{
    CpuSet, clock_nanosleep_absolute, sched_setaffinity, set_current_timer_slack,
};
use rustix::time::{ClockId, Timespec};
use thread_priority::{
    NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue,
    ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};

pub(super) const NANOS_PER_SEC: i64 = 1_000_000_000;

/// Sleeps to an absolute deadline: neither an interrupting signal nor the time between reading the clock
/// and going to sleep adds to it.
pub(super) fn sleep_until(deadline: i64) {
    // A negative time is refused by the kernel, and long past in any case.
    let nanos = deadline.max(0);
    let request = Timespec {
        tv_sec: nanos / NANOS_PER_SEC,
        tv_nsec: nanos % NANOS_PER_SEC,
    };
    // EINTR is the only error a valid deadline can meet.
    while clock_nanosleep_absolute(ClockId::Monotonic, &request) == Err(Errno::INTR) {}
}

/// Tightens the timer slack: the kernel may otherwise bundle wake-ups within 50 µs.
pub(super) fn tighten_timers() -> Result<(), String> {
    // 1 ns, because 0 restores the default.
    set_current_timer_slack(NonZeroU64::new(1)).map_err(|errno| errno.to_string())
}

pub(super) fn set_priority(priority: u8) -> Result<(), String> {
    let value = ThreadPriorityValue::try_from(priority)
        .ok()
        // SCHED_FIFO of Linux has these; the library admits 0 as well, which the kernel refuses without
        // a reason.
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

pub(super) fn drop_priority() -> Result<(), String> {
    set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Min,
        ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other),
    )
    .map_err(|error| error.to_string())
}

pub(super) fn priorities() -> Vec<(String, u8)> {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    let mut found: Vec<_> = threads
        .flatten()
        .filter_map(|thread| {
            priority_of(&std::fs::read_to_string(thread.path().join("stat")).ok()?)
        })
        .collect();
    found.sort_unstable();
    found
}

/// Returns the name and the real-time priority in a line of `/proc/…/stat`; none for a thread without
/// one. The name is in parentheses, and may itself contain parentheses.
fn priority_of(stat: &str) -> Option<(String, u8)> {
    /// `rt_priority` is the 40th field; the first after the name is the third.
    const PRIORITY: usize = 40 - 3;
    let (_, named) = stat.split_once('(')?;
    let (name, fields) = named.rsplit_once(')')?;
    let priority = fields.split_whitespace().nth(PRIORITY)?.parse().ok()?;
    (priority > 0).then(|| (name.to_owned(), priority))
}

pub(super) fn bind_to(cpu: usize) -> Result<(), String> {
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

pub(super) fn lock_memory() -> Result<(), String> {
    mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).map_err(|errno| match errno {
        // EPERM with a limit of 0, ENOMEM above it, EAGAIN for memory that cannot be locked: mlockall(2).
        Errno::PERM | Errno::NOMEM | Errno::AGAIN => {
            format!("{errno}: needs CAP_IPC_LOCK, or a higher memlock limit (ulimit -l)")
        }
        other => other.to_string(),
    })
}
