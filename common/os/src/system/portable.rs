//! System with the standard library and tokio alone.
//!
//! It is built and tested everywhere, so that it keeps working although nobody builds for another system.

use std::fs::{File, Metadata};
use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::process::{Child, Command};
use std::sync::OnceLock;
use std::time::{Duration, Instant, SystemTime};

use coaxle_node::Stamps;

#[cfg(feature = "signals")]
use super::EndSignals;
use super::stamped_socket::{ReceivedDatagram, StampedSocket};
use super::{
    ChildSignal, Firewall, HeldFolder, OtherPermissions, Readers, ServiceState, SharedLock, System,
    SystemFacts,
};
#[cfg(feature = "signals")]
use crate::EndReason;
use crate::{PtpService, PtpState};

/// System without any further support.
///
/// Unsupported functions return errors: real-time priorities, drives in other processes, and faults of
/// real processes that stop and continue. It omits the watchdog of a service manager, the locks on
/// folders of results, private files, and the monitoring of a node's memory.
#[derive(Clone, Copy, Debug)]
pub enum Portable {}

fn unknown<T>(what: &str) -> Result<T, String> {
    Err(format!("{what} is not known for this system"))
}

fn unsupported(what: &str) -> io::Error {
    io::Error::new(
        io::ErrorKind::Unsupported,
        format!("{what}: not known for this system"),
    )
}

/// Returns an instant of both clocks, read once: processes agree as well as their wall clock did then.
fn origin() -> &'static (Instant, i64) {
    // Read once: a later wall clock would move the clock of the rows.
    static ORIGIN: OnceLock<(Instant, i64)> = OnceLock::new();
    ORIGIN.get_or_init(|| {
        let (now, wall) = clocks();
        let since_1970 = wall.duration_since(SystemTime::UNIX_EPOCH);
        (now, since_1970.unwrap_or_default().as_nanos() as i64)
    })
}

#[expect(
    clippy::disallowed_methods,
    reason = "these are the machine's clocks where no better ones are known"
)]
fn clocks() -> (Instant, SystemTime) {
    (Instant::now(), SystemTime::now())
}

impl System for Portable {
    #[cfg(feature = "signals")]
    type EndSignals = CtrlC;
    type StampedSocket = ProgramStamped;
    type PtpService = NoPtpService;

    fn clock_ns() -> i64 {
        let (begin, nanos) = origin();
        nanos + (clocks().0 - *begin).as_nanos() as i64
    }

    /// Knows none: the standard library has UTC alone.
    fn tai_ns() -> Option<i64> {
        None
    }

    #[expect(
        clippy::disallowed_methods,
        reason = "the cycle thread waits here where no absolute sleep is known"
    )]
    fn sleep_until_ns(deadline: i64) {
        // Sleeping may end early on some systems, and the trait promises never to.
        while let Ok(left @ 1..) = u64::try_from(deadline.saturating_sub(Self::clock_ns())) {
            std::thread::sleep(Duration::from_nanos(left));
        }
    }

    /// Does nothing: bundling of timers is not known here.
    fn tighten_timers() -> Result<(), String> {
        Ok(())
    }

    fn set_priority(priority: u8) -> Result<(), String> {
        unknown(&format!("a real-time priority such as {priority}"))
    }

    fn drop_priority() -> Result<(), String> {
        Ok(())
    }

    fn priorities() -> Vec<(String, u8)> {
        Vec::new()
    }

    fn bind_to(processor: usize) -> Result<(), String> {
        unknown(&format!("how to run on processor {processor} alone"))
    }

    fn lock_memory() -> Result<(), String> {
        unknown("how to lock memory")
    }

    fn facts() -> Option<SystemFacts> {
        None
    }

    fn firewall() -> Result<Firewall, String> {
        unknown("how to read the rules of the firewall")
    }

    #[cfg(feature = "signals")]
    fn end_signals() -> io::Result<Self::EndSignals> {
        Ok(CtrlC)
    }

    fn replace_this_process(_by: &mut Command) -> io::Error {
        unsupported("a process in the place of this one")
    }

    /// Does nothing: the parent ends it, unless the parent is killed.
    fn die_with_parent(_parent: i32) -> io::Result<()> {
        Ok(())
    }

    fn own_program() -> io::Result<File> {
        File::open(std::env::current_exe()?)
    }

    fn notify_service_manager(_state: ServiceState) -> io::Result<()> {
        Ok(())
    }

    fn watchdog() -> Option<Duration> {
        None
    }

    fn ignore_terminal_signals(_command: &mut Command) {}

    fn signal(_child: &Child, signal: ChildSignal) -> io::Result<()> {
        let what = match signal {
            ChildSignal::Freeze => "how to stop a process",
            // The child was never stopped.
            ChildSignal::Resume => return Ok(()),
            ChildSignal::End => "how to ask a process to end",
        };
        Err(unsupported(what))
    }

    fn resident_memory(_process: u32) -> Option<u64> {
        None
    }

    fn processor_time(_process: u32) -> Option<Duration> {
        None
    }

    fn hold_folder(path: &Path) -> io::Result<Option<HeldFolder>> {
        std::fs::read_dir(path)?;
        Ok(Some(HeldFolder { _lock: None }))
    }

    fn make_private_folder(path: &Path) -> io::Result<()> {
        std::fs::create_dir_all(path)
    }

    fn create_file(path: &Path, _readers: Readers) -> io::Result<File> {
        File::create(path)
    }

    fn permissions_of_others(_path: &Path) -> Option<OtherPermissions> {
        None
    }

    fn open_shared_file(_path: &Path, _make: bool) -> io::Result<File> {
        Err(unsupported("memory shared with another process"))
    }

    fn kind_of(metadata: &Metadata) -> Option<&'static str> {
        match metadata {
            folder if folder.is_dir() => Some("a folder"),
            link if link.is_symlink() => Some("a link"),
            other if !other.is_file() => Some("a device, pipe or socket"),
            _ => None,
        }
    }

    fn lock_shared_file(_file: &File, _lock: SharedLock) -> io::Result<bool> {
        Err(unsupported("locks of files"))
    }

    fn reserve(file: &File, bytes: u64) -> io::Result<()> {
        file.set_len(bytes)
    }

    fn mode_of(_file: &File) -> io::Result<u32> {
        Ok(0)
    }

    fn is_at(path: &Path, _file: &File) -> bool {
        path.exists()
    }

    fn is_on_disk(_file: &File) -> bool {
        false
    }
}

/// Ctrl-C, the only signal of every system.
#[cfg(feature = "signals")]
#[derive(Clone, Copy, Debug)]
pub struct CtrlC;

#[cfg(feature = "signals")]
impl EndSignals for CtrlC {
    async fn next(&mut self) -> EndReason {
        match tokio::signal::ctrl_c().await {
            Ok(()) => EndReason::Interrupted,
            // It cannot be received: then it ends the process, as it does without a listener.
            Err(_) => std::future::pending().await,
        }
    }
}

/// No PTP service: none is known here.
#[derive(Clone, Copy, Debug)]
pub enum NoPtpService {}

impl PtpService for NoPtpService {
    fn open() -> io::Result<Self> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn ask(&mut self) -> io::Result<()> {
        match *self {}
    }

    fn answer(&mut self) -> Option<PtpState> {
        match *self {}
    }
}

/// A socket with stamps taken by the program.
#[derive(Debug)]
pub struct ProgramStamped(UdpSocket);

impl StampedSocket for ProgramStamped {
    fn bind(address: SocketAddr) -> io::Result<Self> {
        let socket = UdpSocket::bind(address)?;
        // The interface promises a tenth of a second at most, after which the thread looks for its end.
        socket.set_read_timeout(Some(Duration::from_millis(100)))?;
        Ok(Self(socket))
    }

    fn try_clone(&self) -> io::Result<Self> {
        self.0.try_clone().map(Self)
    }

    fn address(&self) -> io::Result<SocketAddr> {
        self.0.local_addr()
    }

    fn stamps(&self) -> Stamps {
        Stamps::Application
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<ReceivedDatagram>> {
        match self.0.recv_from(buffer) {
            Ok((length, from)) => Ok(Some(ReceivedDatagram {
                length,
                from,
                at_ns: Some(Portable::clock_ns()),
            })),
            Err(error) => match error.kind() {
                io::ErrorKind::WouldBlock
                | io::ErrorKind::TimedOut
                | io::ErrorKind::Interrupted
                | io::ErrorKind::ConnectionReset => Ok(None),
                _ => Err(error),
            },
        }
    }

    fn send(&mut self, bytes: &[u8], to: SocketAddr) -> io::Result<()> {
        self.0.send_to(bytes, to).map(drop)
    }

    fn departure(&mut self) -> Option<(u32, i64)> {
        None
    }
}
