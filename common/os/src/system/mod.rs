//! The operating system: everything of it that the standard library does not have, in one place.
//!
//! [`System`] is the interface. [`Linux`] has all of it. [`Portable`] is what the standard library alone gives: enough for the
//! tool, the virtual world and nodes without drives in other processes, and the place to begin from for another system.
//! [`Os`] is the one this was built for. Nothing outside this module asks which that is; docs/INSTALL.md says what is
//! missing elsewhere.

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

pub use facts::Facts;
pub use firewall::{Admitted, Firewall};
#[cfg(target_os = "linux")]
pub use linux::Linux;
pub use portable::Portable;
pub use stamped_socket::StampedSocket;

#[cfg(feature = "signals")]
use crate::Ended;

/// The system this was built for.
#[cfg(target_os = "linux")]
pub type Os = Linux;
/// The system this was built for.
#[cfg(not(target_os = "linux"))]
pub type Os = Portable;

/// What a node and the tool want of an operating system.
pub trait System {
    /// Listens for what ends a program.
    #[cfg(feature = "signals")]
    type EndSignals: EndSignals;

    /// A socket of a timing channel.
    type StampedSocket: StampedSocket + 'static;

    /// ns of a clock that never jumps. All processes of one machine read the same, so that their records can be laid side
    /// by side.
    fn clock_ns() -> i64;

    /// Sleeps until [`clock_ns`](Self::clock_ns) is `deadline`, never less. Interrupting signals do not end it.
    fn sleep_until_ns(deadline: i64);

    /// The calling thread's wake-ups are not bundled with others.
    ///
    /// # Errors
    /// Why not.
    fn tighten_timers() -> Result<(), String>;

    /// The calling thread goes before all that has no such priority, 1 to 99.
    ///
    /// # Errors
    /// Why not, and what would help.
    fn set_priority(priority: u8) -> Result<(), String>;

    /// The calling thread has no such priority any more.
    ///
    /// # Errors
    /// Why not.
    fn drop_priority() -> Result<(), String>;

    /// The threads of this process that have such a priority, by name, and what it is; none where nobody knows how to ask.
    fn priorities() -> Vec<(String, u8)>;

    /// The calling thread runs on this processor alone.
    ///
    /// # Errors
    /// Why not, and what would help.
    fn bind_to(processor: usize) -> Result<(), String>;

    /// The memory of this process is never moved to a disk.
    ///
    /// # Errors
    /// Why not, and what would help.
    fn lock_memory() -> Result<(), String>;

    /// What the system says of itself, as far as cycles depend on it; none where nobody knows how to ask.
    fn facts() -> Option<Facts>;

    /// What is let in from the network.
    ///
    /// # Errors
    /// Why that cannot be read: mostly, that it takes rights.
    fn firewall() -> Result<Firewall, String>;

    /// From now on the signals that end a program are heard instead. To be called in a tokio runtime.
    ///
    /// # Errors
    /// The system refuses.
    #[cfg(feature = "signals")]
    fn end_signals() -> io::Result<Self::EndSignals>;

    /// Puts another program into the place of this one, with its process id and open files. Returns only if that cannot be.
    fn replace_this_process(by: &mut Command) -> io::Error;

    /// From now on this process dies with the one that started it, however that ends.
    ///
    /// # Errors
    /// The system refuses, or the starting one was another than `parent`: that one is gone.
    fn die_with(parent: i32) -> io::Result<()>;

    /// The program that this process runs, even where its file was replaced meanwhile.
    ///
    /// # Errors
    /// It cannot be opened.
    fn own_program() -> io::Result<File>;

    /// Tells whoever manages services, if anybody does.
    ///
    /// # Errors
    /// There is one, and it cannot be told.
    fn tell_service_manager(state: ServiceState) -> io::Result<()>;

    /// The service manager ends this process when it does not hear [`ServiceState::Alive`] for so long.
    fn watchdog() -> Option<Duration>;

    /// What is started does not get the Ctrl-C of this one's terminal.
    fn apart_from_terminal(command: &mut Command);

    /// Does this to a child.
    ///
    /// # Errors
    /// The system refuses, or cannot.
    fn signal(child: &Child, signal: ChildSignal) -> io::Result<()>;

    /// The memory that a process really has, bytes; none if it is gone.
    fn resident_memory(process: u32) -> Option<u64>;

    /// The processor time that a process has taken so far, of all its threads; none if it is gone.
    fn processor_time(process: u32) -> Option<Duration>;

    /// Holds a folder until the result is dropped or the process ends; none if somebody else holds it. A file system that
    /// knows no locks keeps nobody apart.
    ///
    /// # Errors
    /// The folder cannot be opened.
    fn hold_folder(path: &Path) -> io::Result<Option<HeldFolder>>;

    /// Makes a folder, and those it is in, that only its owner may look into.
    ///
    /// # Errors
    /// It cannot be made.
    fn make_private_folder(path: &Path) -> io::Result<()>;

    /// A new or emptied file that only its owner may write, and others may read or not.
    ///
    /// # Errors
    /// It cannot be made.
    fn create_file(path: &Path, readers: Readers) -> io::Result<File>;

    /// What others than its owner may do with a file; none if that cannot be known.
    fn others_may(path: &Path) -> Option<Others>;

    /// Opens a file that this process and another map into their memory, for reading and writing, making it if `make`; never
    /// through a link.
    ///
    /// # Errors
    /// It cannot be opened, or the system has no such memory.
    fn open_shared_file(path: &Path, make: bool) -> io::Result<File>;

    /// What something that is no file is, in words.
    fn kind_of(metadata: &Metadata) -> Option<&'static str>;

    /// Takes one of the two locks of such a file, until it is closed: false if another process has that one.
    ///
    /// # Errors
    /// The system refuses.
    fn lock_shared_file(file: &File, lock: SharedLock) -> io::Result<bool>;

    /// Gives an empty file room: from now on writing to its memory cannot fail.
    ///
    /// # Errors
    /// There is no room.
    fn reserve(file: &File, bytes: u64) -> io::Result<()>;

    /// The permissions of such a file, as their three octal digits.
    ///
    /// # Errors
    /// The system refuses.
    fn mode_of(file: &File) -> io::Result<u32>;

    /// Whether this file is the one that is found there.
    fn is_at(path: &Path, file: &File) -> bool;

    /// Whether the file is on a disk, where the system can hold up whoever writes to its memory.
    fn is_on_disk(file: &File) -> bool;
}

/// The signals that end a program.
#[cfg(feature = "signals")]
pub trait EndSignals: Send {
    /// The next one.
    fn next(&mut self) -> impl Future<Output = Ended> + Send;
}

/// What a service manager is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceState {
    /// It runs.
    Ready,
    /// It still does: feeds the watchdog.
    Alive,
    /// It comes to its end.
    Stopping,
}

/// What is done to a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChildSignal {
    /// It stands still, whatever it does.
    Freeze,
    /// It goes on.
    Resume,
    /// It is asked to end by itself.
    End,
}

/// A folder that nobody else holds.
#[derive(Debug)]
pub struct HeldFolder {
    /// The lock ends with it, however the process does; none where there is no lock.
    _lock: Option<File>,
}

/// Who may read a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readers {
    /// Its owner.
    Owner,
    /// Everybody.
    All,
}

/// What others than its owner may do with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Others {
    /// They may use it at all: read, write or execute.
    pub access: bool,
    /// They may write it.
    pub write: bool,
}

/// A file that two processes share has a lock for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SharedLock {
    /// Of the node that made it.
    Node,
    /// Of the drive process that uses it.
    DriveProcess,
}
