//! The own process and its children, and systemd.

use std::io;
use std::process::Child;
use std::time::Duration;

use rustix::process::{Pid, Signal, getppid, kill_process, set_parent_process_death_signal};
use sd_notify::NotifyState;

use crate::{ChildSignal, ServiceState};

pub(super) fn die_with_parent(parent: i32) -> io::Result<()> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    // The parent may have died before the request, which then never fires: checked afterwards, no gap remains.
    if Pid::as_raw(getppid()) == parent {
        Ok(())
    } else {
        Err(io::Error::other(format!("the process {parent} is gone")))
    }
}

/// Notifies in systemd's protocol; without a listener (`NOTIFY_SOCKET`) nothing is sent.
pub(super) fn notify_service_manager(state: ServiceState) -> io::Result<()> {
    let state = match state {
        ServiceState::Ready => NotifyState::Ready,
        ServiceState::Alive => NotifyState::Watchdog,
        ServiceState::Stopping => NotifyState::Stopping,
    };
    sd_notify::notify(&[state])
}

pub(super) fn signal(child: &Child, signal: ChildSignal) -> io::Result<()> {
    let signal = match signal {
        ChildSignal::Freeze => Signal::STOP,
        ChildSignal::Resume => Signal::CONT,
        ChildSignal::End => Signal::TERM,
    };
    Ok(kill_process(Pid::from_child(child), signal)?)
}

pub(super) fn resident_memory(process: u32) -> Option<u64> {
    let pages = std::fs::read_to_string(format!("/proc/{process}/statm")).ok()?;
    // The second field of statm is the resident part, in pages.
    let pages: u64 = pages.split_whitespace().nth(1)?.parse().ok()?;
    pages.checked_mul(rustix::param::page_size() as u64)
}

pub(super) fn processor_time(process: u32) -> Option<Duration> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let ticks = processor_ticks(&stat)?;
    Some(Duration::from_secs_f64(
        ticks as f64 / rustix::param::clock_ticks_per_second() as f64,
    ))
}

/// Returns the ticks in a line of `/proc/…/stat`: in user mode, and in kernel mode. The name is in
/// parentheses, and may itself contain parentheses.
fn processor_ticks(stat: &str) -> Option<u64> {
    /// `utime` is the 14th field and `stime` the 15th; the first after the name is the third.
    const USER: usize = 14 - 3;
    // From the last parenthesis: a program may be called `a) b`.
    let (_, fields) = stat.rsplit_once(')')?;
    let mut ticks = fields.split_whitespace().skip(USER);
    let mut next = || ticks.next()?.parse::<u64>().ok();
    Some(next()? + next()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_those_of_programs_and_of_the_kernel() {
        let stat = "77 (a ) b) S 1 77 77 0 -1 4194560 9 0 0 0 120 34 0 0 20 0 6 0 5 1 2";
        assert_eq!(processor_ticks(stat), Some(154));
        for short in ["", "77 (a) S 1 2", "77 a S"] {
            assert_eq!(processor_ticks(short), None);
        }
    }
}
