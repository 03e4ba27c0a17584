//! Linux.

mod facts;
mod files;
mod firewall;
mod processes;
mod ptp_service;
#[cfg(feature = "signals")]
mod signals;
mod stamped_socket;
mod threads;

use std::fs::{File, Metadata};
use std::io;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

use rustix::time::{ClockId, DynamicClockId, clock_gettime, clock_gettime_dynamic};

use super::{
    ChildSignal, Firewall, HeldFolder, OtherPermissions, Readers, ServiceState, SharedLock, System,
    SystemFacts,
};

/// Linux, with systemd or without.
#[derive(Clone, Copy, Debug)]
pub enum Linux {}

impl System for Linux {
    #[cfg(feature = "signals")]
    type EndSignals = signals::EndSignalListener;
    type StampedSocket = stamped_socket::KernelStamped;
    type PtpService = ptp_service::Ptp4l;

    /// Reads `CLOCK_MONOTONIC`. An i64 of nanoseconds covers 292 years of uptime.
    fn clock_ns() -> i64 {
        let time = clock_gettime(ClockId::Monotonic);
        time.tv_sec * threads::NANOS_PER_SEC + time.tv_nsec
    }

    /// Reads `CLOCK_TAI`, which is `CLOCK_REALTIME` until a service sets its offset.
    fn tai_ns() -> Option<i64> {
        let time = clock_gettime_dynamic(DynamicClockId::Tai).ok()?;
        Some(time.tv_sec * threads::NANOS_PER_SEC + time.tv_nsec)
    }

    fn sleep_until_ns(deadline: i64) {
        threads::sleep_until(deadline);
    }

    fn tighten_timers() -> Result<(), String> {
        threads::tighten_timers()
    }

    fn set_priority(priority: u8) -> Result<(), String> {
        threads::set_priority(priority)
    }

    fn drop_priority() -> Result<(), String> {
        threads::drop_priority()
    }

    fn priorities() -> Vec<(String, u8)> {
        threads::priorities()
    }

    fn bind_to(processor: usize) -> Result<(), String> {
        threads::bind_to(processor)
    }

    fn lock_memory() -> Result<(), String> {
        threads::lock_memory()
    }

    fn facts() -> Option<SystemFacts> {
        Some(facts::read())
    }

    fn firewall() -> Result<Firewall, String> {
        firewall::read()
    }

    #[cfg(feature = "signals")]
    fn end_signals() -> io::Result<Self::EndSignals> {
        signals::EndSignalListener::listen()
    }

    /// Starts it under the name of this process.
    fn replace_this_process(by: &mut Command) -> io::Error {
        // Process lists then show the same command as before.
        if let Some(called) = std::env::args_os().next() {
            by.arg0(called);
        }
        by.exec()
    }

    fn die_with_parent(parent: i32) -> io::Result<()> {
        processes::die_with_parent(parent)
    }

    fn own_program() -> io::Result<File> {
        // The kernel's link leads to the running program even if its file was replaced or deleted.
        File::open("/proc/self/exe")
    }

    fn notify_service_manager(state: ServiceState) -> io::Result<()> {
        processes::notify_service_manager(state)
    }

    fn watchdog() -> Option<Duration> {
        sd_notify::watchdog_enabled()
    }

    fn ignore_terminal_signals(command: &mut Command) {
        // A terminal sends Ctrl-C to its foreground group, which the child leaves by this.
        command.process_group(0);
    }

    fn signal(child: &Child, signal: ChildSignal) -> io::Result<()> {
        processes::signal(child, signal)
    }

    fn resident_memory(process: u32) -> Option<u64> {
        processes::resident_memory(process)
    }

    fn processor_time(process: u32) -> Option<Duration> {
        processes::processor_time(process)
    }

    fn hold_folder(path: &Path) -> io::Result<Option<HeldFolder>> {
        files::hold_folder(path)
    }

    fn make_private_folder(path: &Path) -> io::Result<()> {
        files::make_private_folder(path)
    }

    fn create_file(path: &Path, readers: Readers) -> io::Result<File> {
        files::create(path, readers)
    }

    fn permissions_of_others(path: &Path) -> Option<OtherPermissions> {
        files::permissions_of_others(path)
    }

    fn open_shared_file(path: &Path, make: bool) -> io::Result<File> {
        files::open_shared(path, make)
    }

    fn kind_of(metadata: &Metadata) -> Option<&'static str> {
        files::kind_of(metadata)
    }

    fn lock_shared_file(file: &File, lock: SharedLock) -> io::Result<bool> {
        files::lock(file, lock)
    }

    fn reserve(file: &File, bytes: u64) -> io::Result<()> {
        files::reserve(file, bytes)
    }

    fn mode_of(file: &File) -> io::Result<u32> {
        files::mode_of(file)
    }

    fn is_at(path: &Path, file: &File) -> bool {
        files::is_at(path, file)
    }

    fn is_on_disk(file: &File) -> bool {
        files::is_on_disk(file)
    }
}
