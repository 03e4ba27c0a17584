//! The node's end of the memory.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use coaxle_axis::drive::{
    Actual, Drive, DriveCommand, DriveKind, DriveLink, DriveReply, DriveState, ProcessDrive,
    ProcessDriveParameters, ProcessState,
};
use coaxle_clock::{CycleTime, Seconds};
use coaxle_curve::profile::Kinematics;
use coaxle_os::machine;
use coaxle_os::{Os, System};

use super::block;
use super::error::{Reason, SharedMemoryError};
use super::file;
use super::layout as at;
use super::layout::Field;
use super::mapping::Mapping;

/// Identity of the node and the slave in the memory.
#[derive(Clone, Copy, Debug)]
pub struct DriveIdentity<'a> {
    /// Run number of the node, any number.
    pub run: u64,
    /// The axis id of the slave.
    pub slave_id: u32,
    /// Name of the slave, at most 64 bytes.
    pub slave: &'a str,
    /// The nominal cycle time of the node.
    pub cycle_time: CycleTime,
}

/// A drive in another process on this machine, over a file that both map.
///
/// The life of the drive is that of a [`ProcessDrive`]. In the cycle it loads and stores words of
/// the mapping, and makes no system call. When dropped, it signals the end of the node to the drive
/// process and removes the file.
#[derive(Debug)]
pub struct SharedMemoryDrive(ProcessDrive<NodeEnd>);

impl SharedMemoryDrive {
    /// Creates the file, or takes over the one left by an earlier node that crashed.
    ///
    /// # Errors
    /// [`SharedMemoryError`] names the file, the value found and the one expected: the file is used
    /// by another node, or of another format, length or version; the system refuses it; or a
    /// parameter is out of its range.
    pub fn create(
        path: &Path,
        identity: &DriveIdentity<'_>,
        parameters: ProcessDriveParameters,
    ) -> Result<Self, SharedMemoryError> {
        let file = file::create(path)?;
        let system = |source| {
            let what = "mapped";
            file::wrong(path, Reason::System { what, source })
        };
        let end = NodeEnd {
            mapping: Mapping::of(&file).map_err(system)?,
            path: path.to_owned(),
            file,
            // Run 0 means that the node has ended: a random run of 0 becomes 1.
            run: identity.run.max(1),
        };
        end.begin(identity);
        ProcessDrive::new(end, DriveKind::SharedMemory, parameters)
            .map(Self)
            .map_err(|error| file::wrong(path, Reason::Parameter(error)))
    }

    /// True if the file is on a disk: the system may then hold up the cycle when it writes to it.
    #[must_use]
    pub fn is_on_disk(&self) -> bool {
        Os::is_on_disk(&self.0.link().file)
    }
}

impl Drive for SharedMemoryDrive {
    fn power_on(&mut self, position: f64, velocity: f64) {
        self.0.power_on(position, velocity);
    }

    fn reset(&mut self) {
        self.0.reset();
    }

    fn step(&mut self, set: &Kinematics, elapsed: Seconds) {
        self.0.step(set, elapsed);
    }

    fn actual(&self) -> Actual {
        self.0.actual()
    }

    fn kind(&self) -> DriveKind {
        self.0.kind()
    }
}

/// The mapping and its file.
#[derive(Debug)]
struct NodeEnd {
    mapping: Mapping,
    path: PathBuf,
    /// Holds the lock.
    file: File,
    run: u64,
}

impl NodeEnd {
    /// Fills in all fields, the run last: a process that sees the run sees the rest.
    fn begin(&self, identity: &DriveIdentity<'_>) {
        let words = self.mapping.words();
        let put = |field: Field, value: u64| words[field.0].store(value, Ordering::Relaxed);
        // First of all: a process that is attached to an older run lets go before any field changes.
        words[at::RUN.0].store(0, Ordering::SeqCst);
        // Kept across runs: a sequence that began again at 0 could repeat a number that a reader has in hand.
        let set_sequence = words[at::SET_SEQUENCE.0].load(Ordering::Relaxed);
        for word in &words[at::NAME.0..] {
            word.store(0, Ordering::Relaxed);
        }
        // A process that is reading now must not take two different states for one.
        // Up by two and even: a reader in the middle of the old block sees a changed number.
        put(at::SET_SEQUENCE, set_sequence.wrapping_add(2) & !1);
        put(at::MAGIC_FIELD, at::MAGIC);
        put(at::VERSION_FIELD, at::VERSION);
        put(at::SIZE_FIELD, at::SIZE as u64);
        put(at::SLAVE_ID, identity.slave_id.into());
        let cycle_time = identity.cycle_time.span().as_nanos();
        put(at::CYCLE_TIME, u64::try_from(cycle_time).unwrap_or(0));
        put(at::NODE_PID, std::process::id().into());
        // Cut in the middle of a character if need be: the reader replaces what is no UTF-8.
        let name = &identity.slave.as_bytes()[..identity.slave.len().min(at::NAME_BYTES)];
        put(at::NAME_LENGTH, name.len() as u64);
        for (word, bytes) in words[at::NAME.0..].iter().zip(name.chunks(8)) {
            let mut whole = [0; 8];
            whole[..bytes.len()].copy_from_slice(bytes);
            word.store(u64::from_ne_bytes(whole), Ordering::Relaxed);
        }
        // Release: a process that sees the run has all stores above it.
        words[at::RUN.0].store(self.run, Ordering::Release);
    }

    /// The words from the sequence on, as many as the block has.
    fn block(&self, sequence: Field) -> (&AtomicU64, &[AtomicU64]) {
        let words = self.mapping.words();
        (&words[sequence.0], &words[sequence.0 + 1..])
    }

    fn write_set(&self, command: &DriveCommand) {
        let DriveCommand {
            counter,
            enable,
            resets,
            state,
            set,
        } = *command;
        let ideal_start = machine::cycle_start().as_nanos();
        let (sequence, words) = self.block(at::SET_SEQUENCE);
        block::write(
            sequence,
            words,
            [
                counter,
                // Bit patterns of negative instants come back by the same cast at the other end.
                ideal_start as u64,
                set.position.to_bits(),
                set.velocity.to_bits(),
                set.acceleration.to_bits(),
                enable.into(),
                resets,
                // A number of the layout, not of the enum: a reordered enum must not change the memory.
                state_number(state),
            ],
        );
    }
}

const fn state_number(state: DriveState) -> u64 {
    match state {
        DriveState::Off => 0,
        DriveState::SwitchingOn => 1,
        DriveState::Following => 2,
        DriveState::Tripped => 3,
    }
}

impl DriveLink for NodeEnd {
    fn write(&mut self, command: &DriveCommand) {
        self.write_set(command);
    }

    fn read(&mut self) -> Option<DriveReply> {
        let (sequence, words) = self.block(at::ACTUAL_SEQUENCE);
        let [
            run,
            heartbeat,
            counter,
            resets,
            state,
            error,
            position,
            velocity,
        ] = block::read(sequence, words)?;
        // Values of a process that is attached to an earlier run of the node are none.
        (run == self.run).then(|| DriveReply {
            heartbeat,
            counter,
            resets,
            state: ProcessState::of(state),
            // The layout gives the code the lower 32 bits of a word.
            error: error as u32,
            position: f64::from_bits(position),
            velocity: f64::from_bits(velocity),
        })
    }
}

impl Drop for NodeEnd {
    fn drop(&mut self) {
        // The last command is "no power", for a process that checks no other field.
        self.write_set(&DriveCommand::default());
        // A process that has the file mapped does not notice its removal.
        self.mapping.words()[at::RUN.0].store(0, Ordering::Release);
        file::remove(&self.path, &self.file);
    }
}
