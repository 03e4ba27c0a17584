//! This process and its children, and systemd.

use std::io;
use std::process::Child;

use rustix::process::{Pid, Signal, getppid, kill_process, set_parent_process_death_signal};
use sd_notify::NotifyState;

use crate::os::{ChildSignal, ServiceState};

pub(super) fn die_with(parent: i32) -> io::Result<()> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    if Pid::as_raw(getppid()) == parent {
        Ok(())
    } else {
        Err(io::Error::other(format!("the process {parent} is gone")))
    }
}

/// In systemd's protocol; where nobody listens (`NOTIFY_SOCKET`) nothing is told.
pub(super) fn tell_service_manager(state: ServiceState) -> io::Result<()> {
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
    let pages: u64 = pages.split_whitespace().nth(1)?.parse().ok()?;
    pages.checked_mul(rustix::param::page_size() as u64)
}
