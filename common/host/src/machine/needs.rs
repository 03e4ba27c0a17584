//! Resources that a program needs, checked before it starts. Without them a library would panic in the middle of the
//! start, an allocation would end the process, or the node would run without connections.
//!
//! The check takes everything at once and gives it back: limits come from several places (a shell, a service manager, a
//! container), and what is in use already counts.

use std::hint::black_box;
use std::io::{self, PipeReader, pipe};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;

/// Resources of a program, at least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// Descriptors to open.
    pub files: usize,
    /// Threads to start.
    pub threads: usize,
    /// Memory to allocate at the start, bytes.
    pub memory: usize,
}

/// A resource that is not there.
#[derive(Debug, thiserror::Error)]
pub enum MissingResource {
    /// Descriptors.
    #[error(
        "open files: received a limit that leaves {received}, expected at least {expected}; raise it with `ulimit -n`, or \
         LimitNOFILE= in the unit of the service"
    )]
    Files {
        /// Number left.
        received: usize,
        /// Number needed.
        expected: usize,
    },
    /// Threads.
    #[error(
        "threads: received {received} ({reason}), expected at least {expected}; raise the limit of threads or memory with \
         `ulimit -u` or `ulimit -v`, or TasksMax= or LimitAS= in the unit of the service"
    )]
    Threads {
        /// Number started.
        received: usize,
        /// Number needed.
        expected: usize,
        /// Reason of the system.
        reason: io::Error,
    },
    /// Memory.
    #[error(
        "memory: received a limit that leaves less than {} MiB beside {threads} threads, expected at least that; raise it \
         with `ulimit -v`, or LimitAS= in the unit of the service", expected >> 20
    )]
    Memory {
        /// Bytes needed.
        expected: usize,
        /// Threads at that moment.
        threads: usize,
    },
}

/// Memory that has to be left at any time.
// From 32 MiB on glibc maps an allocation by itself (DEFAULT_MMAP_THRESHOLD_MAX): below, freed memory of the program would
// answer for that of the system. Stacks of threads are 2 MiB.
const CUSHION: usize = 33 << 20;

impl Needs {
    /// Needs of any program of Coaxle: its log, a thread that writes it, and the files that it reads.
    pub const PROGRAM: Self = Self {
        files: 6,
        threads: 2,
        memory: 0,
    };

    /// Needs of a client of the network: a session of Zenoh, with a link or two.
    // 20 descriptors and 6 threads of a client with one link (/proc/PID, Zenoh 1.10.2).
    pub const CLIENT: Self = Self {
        files: 24,
        threads: 8,
        memory: 16 << 20,
    };

    /// Takes all of it, and gives it back.
    ///
    /// # Errors
    /// [`MissingResource`], the first one.
    pub fn check(&self) -> Result<(), MissingResource> {
        let _files = self.take_files()?;
        let _memory = take_memory(self.memory, 0)?;
        self.start_threads()
    }

    fn take_files(&self) -> Result<Vec<PipeReader>, MissingResource> {
        let missing = |received| MissingResource::Files {
            received,
            expected: self.files,
        };
        // Two descriptors, of which one is closed: a pipe needs no file and no network.
        let (first, _) = pipe().map_err(|_| missing(0))?;
        let mut files = vec![first];
        while files.len() < self.files {
            let another = files[0].try_clone();
            files.push(another.map_err(|_| missing(files.len()))?);
        }
        Ok(files)
    }

    /// Starts all threads, and ends them once the last one runs.
    fn start_threads(&self) -> Result<(), MissingResource> {
        let mut started = StartedThreads::default();
        for received in 0..self.threads {
            // Before each of them: a thread without memory for its signal stack panics.
            drop(take_memory(CUSHION, received)?);
            started.start().map_err(|reason| MissingResource::Threads {
                received,
                expected: self.threads,
                reason,
            })?;
        }
        take_memory(CUSHION, self.threads).map(drop)
    }
}

fn take_memory(bytes: usize, threads: usize) -> Result<Vec<u8>, MissingResource> {
    let mut memory = Vec::new();
    let taken = memory.try_reserve_exact(bytes);
    taken.map_err(|_| MissingResource::Memory {
        expected: bytes,
        threads,
    })?;
    // An allocation that nobody uses may be optimised away.
    Ok(black_box(memory))
}

/// Threads that wait, until dropped.
#[derive(Default)]
struct StartedThreads(Vec<(Sender<()>, JoinHandle<()>)>);

impl StartedThreads {
    /// Starts another one, and waits until it runs.
    fn start(&mut self) -> io::Result<()> {
        let (ending, ended) = channel::<()>();
        let (running, runs) = channel();
        let thread = std::thread::Builder::new()
            .name("check".to_owned())
            .spawn(move || {
                // The first allocation of a thread takes an arena of its own, 64 MiB of addresses.
                black_box(Vec::<u8>::with_capacity(1 << 10));
                let _ = running.send(());
                // Closed by the other end.
                let _ = ended.recv();
            })?;
        self.0.push((ending, thread));
        runs.recv()
            .map_err(|_| io::Error::other("a thread ended at its start"))
    }
}

impl Drop for StartedThreads {
    fn drop(&mut self) {
        for (ending, thread) in self.0.drain(..) {
            drop(ending);
            // Its stack is free only then.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn needs_that_can_be_met_are_and_others_are_named() {
        assert!(Needs::PROGRAM.check().is_ok());
        // Descriptors and threads are those of the whole test program: tests of processes take them all.
        let too_much = Needs {
            memory: isize::MAX as usize,
            ..Needs::PROGRAM
        };
        let missing = too_much.check().unwrap_err().to_string();
        assert!(missing.starts_with("memory: received a limit"), "{missing}");
        assert!(missing.contains("`ulimit -v`"), "{missing}");
    }
}
