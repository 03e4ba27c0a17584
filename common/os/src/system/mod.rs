//! The operating system: all parts of it that the standard library does not have, in one place.
//!
//! [`System`] is the interface. [`Linux`] implements all of it. [`Portable`] uses the standard library
//! alone: enough for the tool, the virtual world and nodes without drives in other processes, and the
//! starting point for another system. [`Os`] is the one this was built for. Nothing outside this module
//! depends on which one that is; docs/INSTALL.md lists what is missing elsewhere.

mod facts;
mod firewall;
#[cfg(target_os = "linux")]
mod linux;
mod portable;
pub mod stamped_socket;
#[cfg(test)]
mod tests;

use std::fs::{File, Metadata};
use std::io;
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

pub use facts::SystemFacts;
pub use firewall::{AdmittedPorts, Firewall};
#[cfg(target_os = "linux")]
pub use linux::Linux;
pub use portable::Portable;
pub use stamped_socket::StampedSocket;

#[cfg(feature = "signals")]
use crate::EndReason;
use crate::PtpService;

/// The system this was built for.
#[cfg(target_os = "linux")]
pub type Os = Linux;
/// The system this was built for.
#[cfg(not(target_os = "linux"))]
pub type Os = Portable;

/// Requirements of a node and the tool on an operating system.
pub trait System {
    /// Listener for the signals that end a program.
    #[cfg(feature = "signals")]
    type EndSignals: EndSignals;

    /// A socket of a timing channel.
    type StampedSocket: StampedSocket + 'static;

    /// Connection to the PTP service of this machine.
    type PtpService: PtpService + 'static;

    /// Reads the time in ns of a clock that never jumps. All processes of one machine read the same
    /// clock, so that their records can be compared.
    fn clock_ns() -> i64;

    /// Reads International Atomic Time, ns since 1970; none if the system does not know it.
    fn tai_ns() -> Option<i64>;

    /// Sleeps until [`clock_ns`](Self::clock_ns) reaches `deadline`, never less. Interrupting signals do
    /// not end it.
    fn sleep_until_ns(deadline: i64);

    /// Prevents bundling of the calling thread's wake-ups with others.
    ///
    /// # Errors
    /// The reason of the failure.
    fn tighten_timers() -> Result<(), String>;

    /// Gives the calling thread this real-time priority, 1 to 99.
    ///
    /// # Errors
    /// The reason of the failure, and its remedy.
    fn set_priority(priority: u8) -> Result<(), String>;

    /// Removes the real-time priority of the calling thread.
    ///
    /// # Errors
    /// The reason of the failure.
    fn drop_priority() -> Result<(), String>;

    /// Returns the threads of this process with a real-time priority, by name; none if the system cannot
    /// report them.
    fn priorities() -> Vec<(String, u8)>;

    /// Binds the calling thread to this processor.
    ///
    /// # Errors
    /// The reason of the failure, and its remedy.
    fn bind_to(processor: usize) -> Result<(), String>;

    /// Locks the memory of this process, so that it is never moved to a disk.
    ///
    /// # Errors
    /// The reason of the failure, and its remedy.
    fn lock_memory() -> Result<(), String>;

    /// Returns the properties of the system, as far as cycles depend on them; none if the system cannot
    /// report them.
    fn facts() -> Option<SystemFacts>;

    /// Returns the firewall rules for incoming packets.
    ///
    /// # Errors
    /// The reason why they cannot be read: mostly missing rights.
    fn firewall() -> Result<Firewall, String>;

    /// Listens for the signals that end a program, in place of their defaults. To be called in a tokio runtime.
    ///
    /// # Errors
    /// A refusal of the system.
    #[cfg(feature = "signals")]
    fn end_signals() -> io::Result<Self::EndSignals>;

    /// Replaces this process by another program, with its process id and open files. Returns only on
    /// failure.
    fn replace_this_process(by: &mut Command) -> io::Error;

    /// Makes this process die with the process that started it, however that ends.
    ///
    /// # Errors
    /// A refusal of the system, or a starting process other than `parent`, which is gone then.
    fn die_with_parent(parent: i32) -> io::Result<()>;

    /// Opens the program that this process runs, even if its file was replaced meanwhile.
    ///
    /// # Errors
    /// A file that cannot be opened.
    fn own_program() -> io::Result<File>;

    /// Notifies the service manager, if there is one.
    ///
    /// # Errors
    /// A service manager that cannot be notified.
    fn notify_service_manager(state: ServiceState) -> io::Result<()>;

    /// Returns the watchdog timeout: the service manager ends this process without a
    /// [`ServiceState::Alive`] for this time.
    fn watchdog() -> Option<Duration>;

    /// Keeps the Ctrl-C of this process's terminal from a process to be started.
    fn ignore_terminal_signals(command: &mut Command);

    /// Sends a signal to a child.
    ///
    /// # Errors
    /// A refusal of the system, or a signal that it does not have.
    fn signal(child: &Child, signal: ChildSignal) -> io::Result<()>;

    /// Returns the resident memory of a process, bytes; none if it is gone.
    fn resident_memory(process: u32) -> Option<u64>;

    /// Returns the processor time of a process so far, of all its threads; none if it is gone.
    fn processor_time(process: u32) -> Option<Duration>;

    /// Locks a folder until the result is dropped or the process ends; none if another process holds it.
    /// A file system without locks excludes nobody.
    ///
    /// # Errors
    /// A folder that cannot be opened.
    fn hold_folder(path: &Path) -> io::Result<Option<HeldFolder>>;

    /// Makes a folder, and its parents, accessible only to its owner.
    ///
    /// # Errors
    /// A folder that cannot be made.
    fn make_private_folder(path: &Path) -> io::Result<()>;

    /// Makes a new or empties an existing file that only its owner may write, and others may read or not.
    ///
    /// # Errors
    /// A file that cannot be made.
    fn create_file(path: &Path, readers: Readers) -> io::Result<File>;

    /// Returns the permissions of others than its owner for a file; none if they cannot be read.
    fn permissions_of_others(path: &Path) -> Option<OtherPermissions>;

    /// Opens a file that this process and another map into their memory, for reading and writing, making
    /// it if `make`; never through a link.
    ///
    /// # Errors
    /// A file that cannot be opened, or a system without such memory.
    fn open_shared_file(path: &Path, make: bool) -> io::Result<File>;

    /// Returns the kind of something that is not a regular file, in words.
    fn kind_of(metadata: &Metadata) -> Option<&'static str>;

    /// Takes one of the two locks of such a file, until it is closed: false if another process has that
    /// one.
    ///
    /// # Errors
    /// A refusal of the system.
    fn lock_shared_file(file: &File, lock: SharedLock) -> io::Result<bool>;

    /// Reserves space for an empty file: from now on writing to its memory cannot fail.
    ///
    /// # Errors
    /// No space left.
    fn reserve(file: &File, bytes: u64) -> io::Result<()>;

    /// Returns the permissions of such a file, as their three octal digits.
    ///
    /// # Errors
    /// A refusal of the system.
    fn mode_of(file: &File) -> io::Result<u32>;

    /// True if the path leads to this file.
    fn is_at(path: &Path, file: &File) -> bool;

    /// True if the file is on a disk, where the system can delay writes to its memory.
    fn is_on_disk(file: &File) -> bool;
}

/// The signals that end a program.
#[cfg(feature = "signals")]
pub trait EndSignals: Send {
    /// Waits for the next one.
    fn next(&mut self) -> impl Future<Output = EndReason> + Send;
}

/// State reported to a service manager.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceState {
    /// Running.
    Ready,
    /// Still running: feeds the watchdog.
    Alive,
    /// Ending.
    Stopping,
}

/// Signal to a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChildSignal {
    /// Stops, whatever the child does.
    Freeze,
    /// Continues.
    Resume,
    /// Requests an end.
    End,
}

/// A locked folder.
#[derive(Debug)]
pub struct HeldFolder {
    /// Lock, released when its process ends, however it does; none without locks.
    _lock: Option<File>,
}

/// Readers of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readers {
    /// Owner only.
    Owner,
    /// Everybody.
    All,
}

/// Permissions of others than its owner for a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherPermissions {
    /// Any access: read, write or execute.
    pub access: bool,
    /// Write access.
    pub write: bool,
}

/// Lock of a file that two processes share, one for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SharedLock {
    /// Lock of the node that made it.
    Node,
    /// Lock of the drive process that uses it.
    DriveProcess,
}
